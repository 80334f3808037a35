"""Laws of motion s(tau), s', s'' on [0, 1]; where s'' jumps, the value just after, at the end just before."""
from math import cos, pi, sin


def polynomial(coefficients):
    def law(x):
        s = sum(c * x**k for k, c in coefficients.items())
        ds = sum(k * c * x**(k - 1) for k, c in coefficients.items())
        dds = sum(k * (k - 1) * c * x**(k - 2) for k, c in coefficients.items())
        return s, ds, dds
    return law


def bang_bang(x):
    return (2 * x * x, 4 * x, 4.0) if x < 0.5 else (1 - 2 * (1 - x)**2, 4 * (1 - x), -4.0)


LAWS = {
    "cycloidal": lambda x: (x - sin(2 * pi * x) / (2 * pi), 1 - cos(2 * pi * x), 2 * pi * sin(2 * pi * x)),
    "bang-bang": bang_bang,
    "uniform": lambda x: (x, 1.0, 0.0),
    "cubic": polynomial({2: 3, 3: -2}),
    "3-4-5": polynomial({3: 10, 4: -15, 5: 6}),
    "4-5-6-7": polynomial({4: 35, 5: -84, 6: 70, 7: -20}),
    "harmonic": lambda x: ((1 - cos(pi * x)) / 2, pi * sin(pi * x) / 2, pi * pi * cos(pi * x) / 2),
}

"""The four-bar that several tests write down, crank at A, rocker at D."""


def four_bar(base, crank, coupler, rocker, *, coupler_com=None, gravity=False, more=""):
    """A spec.

    @param base from A to D, along x [m]
    @param crank, coupler, rocker the far joint in the link's axes: a length along x, or [x, y] [m]
    @param coupler_com [x, y] [m]; not given: 0.1 m along x
    @param more lines at its end
    """
    place = lambda far: far if isinstance(far, list) else [far, 0]
    return f"""\
space: planar
{"gravity: [0, -9.81]" if gravity else ""}
ground: {{points: {{A: [0, 0], D: [{base}, 0]}}}}
bodies:
  crank: {{mass: 1, com: [0.05, 0], inertia: 0.01, points: {{A: [0, 0], B: {place(crank)}}}}}
  coupler: {{mass: 1, com: {coupler_com or [0.1, 0]}, inertia: 0.01, points: {{B: [0, 0], C: {place(coupler)}}}}}
  rocker: {{mass: 1, com: [0.1, 0], inertia: 0.01, points: {{D: [0, 0], C: {place(rocker)}}}}}
joints:
  A: {{type: revolute, connects: [ground.A, crank.A]}}
  B: {{type: revolute, connects: [crank.B, coupler.B]}}
  C: {{type: revolute, connects: [coupler.C, rocker.C]}}
  D: {{type: revolute, connects: [ground.D, rocker.D]}}
actuators: [A]
{more}
"""


# The coupler is too short to reach: the gap is 1 - 3 * 0.2.
SHORT = four_bar(1, 0.2, 0.2, 0.2)

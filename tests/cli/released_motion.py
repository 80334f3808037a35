"""Motions in which nothing is driven, starts that nothing determines, and where messages about free coordinates point."""

import json
import math
import re
import resource
import unittest

import h5py
import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from _program import SLOWNESS, Case, run

PENDULUM = """
space: planar
gravity: [0, -9.81]
bodies:
  a: {mass: 2, com: [0, -0.5], inertia: 0, points: {O: [0, 0]}}
joints:
  J: {type: revolute, connects: [ground.origin, a.O]}
actuators: [J]
trajectories:
  swing: {drive: none, duration: PERIOD, samples: 101, free: [J], initial: {joints: {J: 2}}}
  rest:  {drive: none, duration: 1, samples: 11, free: [J], initial: {joints: {J: 0.3}, start: equilibrium}}
"""

DOUBLE = """
space: planar
gravity: [0, -9.81]
bodies:
  a: {mass: 2, com: [0, -0.3], inertia: 0.1, points: {O: [0, 0], P: [0, -0.6]}}
  b: {mass: 1, com: [0, -0.3], inertia: 0.02, points: {O: [0, 0]}}
joints:
  J: {type: revolute, connects: [ground.origin, a.O]}
  P: {type: revolute, connects: [a.P, b.O]}
trajectories:
  fall: {drive: none, duration: 2, samples: 201, free: [J, P], initial: {joints: {J: 1, P: 0.5}, rates: {P: 2}}}
  held: {drive: none, duration: 1, samples: 101, free: [P], hold: [J], initial: {joints: {J: 0.4, P: 1}}}
"""

TOP = """
space: spatial
bodies:
  b: {mass: 3, com: [0.1, 0, 0], inertia: [0.2, 0.3, 0.45], points: {O: [0, 0, 0]}}
joints:
  F: {type: free, connects: [ground.origin, b.O]}
trajectories:
  spin: {drive: none, duration: 20, samples: 401, free: [F.x, F.y, F.z, F.1, F.2, F.3], initial: {rates: {F.1: 0.3, F.2: 0.1, F.3: 2, F.x: 0.2}}}
"""

# A crank on a frame on mounts, with coordinates to be named in every wrong way.
FRAME = """space: planar
bodies:
  frame: {mass: 10, com: [0, 0], inertia: 0.3, points: {O: [0, 0]}}
  crank: {mass: 0.4, com: [0.05, 0], inertia: 0.001, points: {A: [0, 0], B: [0.1, 0]}}
  rod: {mass: 0.2, com: [0.15, 0], inertia: 0.002, points: {B: [0, 0], C: [0.3, 0]}}
  slider: {mass: 0.1, com: [0, 0], inertia: 0.0001, points: {C: [0, 0]}}
joints:
  F: {type: free, connects: [ground.origin, frame.O]}
  A: {type: revolute, connects: [frame.O, crank.A]}
  B: {type: revolute, connects: [crank.B, rod.B]}
  C: {type: revolute, connects: [rod.C, slider.C]}
  S: {type: prismatic, connects: [frame.O, slider.C], axis: [1, 0]}
bushings: {mount: {between: [ground.origin, frame.O], stiffness: [3000, 3000], damping: [50, 50], angular: {stiffness: 60, damping: 0.5}}}
actuators: [A]
assembly: {A: 0, B: 0, S: 0.4, C: 0}
trajectories:
  run: {TRAJECTORY}
"""

ROLLER = """
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  d: {mass: 2, com: [0, 0], inertia: 0.1, points: {C: [0, 0]}}
  p: {mass: 1, com: [0, 0], inertia: 0.01, points: {O: [0, 0]}}
joints:
  R: {type: rolling, connects: [ground.O, d.C], radius: 0.3}
  P: {type: revolute, connects: [d.C, p.O]}
actuators: [P]
trajectories:
  turn: {drive: joints, speed: {P: 3}, from: {joints: {P: 0}}, free: [R.angle], initial: steady}
  still: {law: cycloidal, drive: joints, duration: 1, from: {joints: {P: 0}}, to: {joints: {P: 1}}, free: [R.angle], initial: equilibrium}
"""

LIFT = """
space: planar
gravity: [0, -9.81]
bodies:
  a: {mass: 2, com: [0, 0], inertia: 0.1, points: {O: [0, 0]}}
  b: {mass: 1, com: [0, -0.3], inertia: 0.02, points: {O: [0, 0]}}
joints:
  Y: {type: prismatic, connects: [ground.origin, a.O], axis: [0, 1]}
  P: {type: revolute, connects: [a.O, b.O]}
actuators: [P]
trajectories:
  still: {law: cycloidal, drive: joints, duration: 1, from: {joints: {P: 0}}, to: {joints: {P: 1}}, free: [Y], initial: equilibrium}
  turn: {drive: joints, speed: {P: 3}, from: {joints: {P: 0}}, free: [Y], initial: steady}
"""

HOOP = """
space: spatial
gravity: [0, 0, -9.81]
bodies:
  hub: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01], points: {O: [0, 0, 0]}}
  bob: {mass: 1, com: [0, 0, -0.5], inertia: [0, 0, 0], points: {O: [0, 0, 0]}}
joints:
  T: {type: revolute, connects: [ground.origin, hub.O], axis: [0, 0, 1]}
  P: {type: revolute, connects: [hub.O, bob.O], axis: [0, 1, 0]}
actuators: [T]
trajectories:
  slow: {drive: joints, speed: {T: 3}, samples: 129, from: {joints: {T: 0}}, free: [P], initial: {joints: {P: 0.8}, start: steady}}
  fast: {drive: joints, speed: {T: 6}, samples: 129, from: {joints: {T: 0}}, free: [P], initial: {joints: {P: 0.8}, start: steady}}
  bottom: {drive: joints, speed: {T: 6}, samples: 129, from: {joints: {T: 0}}, free: [P], initial: steady}
"""


def said(done):
    return " ".join((done.stdout + done.stderr).split())


class Released(Case):
    def result(self, text, *arguments):
        output = self.path("result.h5")
        done = run("simulate", self.write("spec.yaml", text), *arguments, "-o", output, "--force")
        self.assertEqual(done.returncode, 0, said(done))
        with h5py.File(output) as file:
            arrays = {name: file[name][()] for name in file if isinstance(file[name], h5py.Dataset) and file[name].dtype.kind == "f"}
            names = [name.decode() for name in file["coordinate"][()]]
            attributes = dict(file.attrs)
        return dict(zip(names, arrays["joint_position"].T)), arrays, said(done), attributes

    def test_a_pendulum_is_back_after_the_period_of_the_elliptic_integral(self):
        period = 4 * math.sqrt(0.5 / 9.81) * ellipk(math.sin(1) ** 2)
        q, arrays, text, attributes = self.result(PENDULUM.replace("PERIOD", repr(period)), "-t", "swing")
        self.assertLess(abs(q["J"][-1] - 2), 1e-11)  # a maximum: the error of the period counts squared
        self.assertLess(abs(q["J"][50] + 2), 1e-11)
        energy = arrays["kinetic_energy"] + arrays["potential_energy"]
        self.assertLess(np.ptp(energy), 1e-11 * arrays["kinetic_energy"].max())
        self.assertIn("its actuator exerts nothing: J", text)
        self.assertEqual((attributes["law"], attributes["drive"]), ("free", "none"))
        self.assertNotIn("torque", arrays)

    def test_both_formulations_and_an_own_integration_agree(self):
        q, arrays, _, _ = self.result(DOUBLE, "-t", "fall")
        other, _, _, _ = self.result(DOUBLE, "-t", "fall", "--formulation", "natural")
        for name in ("J", "P"):
            self.assertLess(np.abs(q[name] - other[name]).max(), 1e-10)

        def rates(_, state):  # angles of both bodies from the vertical
            a, b, u, w = state
            mass = np.array([[0.1 + 2 * 0.09 + 0.36, 0.18 * math.cos(a - b)], [0.18 * math.cos(a - b), 0.02 + 0.09]])
            s = 0.18 * math.sin(a - b)
            force = np.array([-s * w * w - 9.81 * (0.6 + 0.6) * math.sin(a), s * u * u - 9.81 * 0.3 * math.sin(b)])
            return [u, w, *np.linalg.solve(mass, force)]

        own = solve_ivp(rates, (0, 2), [1, 1.5, 0, 2], rtol=1e-12, atol=1e-12).y[:, -1]
        self.assertLess(abs(q["J"][-1] - own[0]) + abs(q["J"][-1] + q["P"][-1] - own[1]), 1e-9)
        self.assertLess(np.ptp(arrays["kinetic_energy"] + arrays["potential_energy"]), 1e-11 * 20)

    def test_what_is_held_stays_and_has_an_effort(self):
        q, arrays, text, _ = self.result(DOUBLE, "-t", "held")
        self.assertEqual(np.ptp(q["J"]), 0)
        self.assertGreater(np.abs(arrays["torque"]).max(), 5)
        self.assertIn("held by a guide: J", text)

    def test_a_body_that_floats_keeps_momentum_and_energy(self):
        q, arrays, _, _ = self.result(TOP, "--poses")
        velocity = arrays["com_velocity"]
        self.assertLess(np.abs(velocity - velocity[0]).max(), 1e-12)
        self.assertLess(np.ptp(arrays["kinetic_energy"]), 1e-11)
        self.assertEqual(np.abs(arrays["shaking_moment_com"]).max(), 0)
        self.assertGreater(np.ptp(q["F.1"]), 0.1)

    def test_equilibrium_and_vibration(self):
        spec = PENDULUM.replace("PERIOD", "1")
        q, _, _, _ = self.result(spec, "-t", "rest")
        self.assertLess(np.abs(q["J"]).max(), 1e-11)
        view = json.loads(run("modes", self.write("spec.yaml", spec), "-t", "rest", "--json").stdout)
        self.assertAlmostEqual(view["modes"][0]["frequency"], math.sqrt(9.81 / 0.5) / (2 * math.pi), delta=1e-9)

    def test_keys_that_do_not_go_with_nothing_driven(self):
        start = "{drive: none, duration: 1, free: [J, P]"
        for keys, message in ((", law: uniform}", "s.yaml:11:55: trajectories.fall.law: expected no law with 'drive: none'"),
                              (", from: {joints: {J: 0}}}", "trajectories.fall.from: expected no 'from' with 'drive: none'"),
                              (", speed: {J: 1}}", "trajectories.fall.speed: expected no 'speed'"),
                              (", path: line}", "trajectories.fall.path: expected no 'path'")):
            text = re.sub(r"  fall: .*\n", f"  fall: {start}{keys}\n", DOUBLE)
            self.assertIn(message, said(run("check", self.write("s.yaml", text))), keys)
        for line, message in (("{drive: none, duration: 1}", "trajectories.fall.drive: expected with 'drive: none' 'free'"),
                              ("{drive: joints, law: uniform, duration: 1, free: [J, P]}", "'drive: none' if nothing is driven"),
                              ("{drive: none, free: [J, P]}", "'duration' here or in 'motion'")):
            text = re.sub(r"  fall: .*\n", f"  fall: {line}\n", DOUBLE)
            self.assertIn(message, said(run("check", self.write("s.yaml", text))), line)


class Families(Case):
    def test_a_start_that_nothing_determines_says_so(self):
        roller = self.write("roller.yaml", ROLLER)
        for trajectory, what in (("turn", "the periodic motion"), ("still", "the equilibrium")):
            done = run("simulate", roller, "-t", trajectory)
            self.assertEqual(done.returncode, 0, said(done))
            self.assertIn(f"{what} is one of many, because nothing determines R.angle", said(done))
        self.assertIn("is one of many, because nothing determines R.angle", said(run("modes", roller, "-t", "still")))

    def test_what_nothing_holds_has_no_start(self):
        lift = self.write("lift.yaml", LIFT)
        for trajectory, what in (("still", "no equilibrium found: nothing determines Y"), ("turn", "no periodic motion found: nothing determines Y")):
            done = run("simulate", lift, "-t", trajectory)
            self.assertEqual(done.returncode, 4)
            self.assertRegex(said(done), rf"lift\.yaml:1[23]:\d+: trajectories\.{trajectory}\.free: {what}")

    def test_a_bead_on_a_turning_hoop(self):
        hoop = self.write("hoop.yaml", HOOP)
        slow = said(run("modes", hoop, "-t", "slow"))
        self.assertNotIn("does not repeat", slow)
        self.assertIn("nothing moves beyond round-off", slow)
        # at 6 rad/s it leaves the bottom: cos P = g/(l w^2), l w^2 cos^2... the frequency is w sin P
        view = json.loads(run("modes", hoop, "-t", "fast", "--json").stdout)
        angle = math.acos(9.81 / (0.5 * 36))
        self.assertAlmostEqual(view["equilibrium"]["P"], angle, delta=1e-9)
        self.assertAlmostEqual(view["modes"][0]["frequency"], 6 * math.sin(angle) / (2 * math.pi), delta=1e-9)

    def test_the_stability_of_periodic_motions(self):
        """Floquet multipliers of linear equations with constant coefficients are exponentials."""
        bottom = said(run("simulate", self.write("hoop.yaml", HOOP), "-t", "bottom"))
        factor = math.exp(math.sqrt(36 - 9.81 / 0.5) * 2 * math.pi / 6)
        self.assertIn(f"the periodic motion is unstable: deviations from it are multiplied by up to {factor:.4g} in every period", bottom)
        self.assertIn("neither stable nor unstable", said(run("simulate", self.path("hoop.yaml"), "-t", "fast")))
        damped = HOOP.replace("actuators:", "friction: {P: {viscous: 0.1}}\nactuators:")  # m l^2 = 0.25
        factor = math.exp(-0.1 / (2 * 0.25) * 2 * math.pi / 3)
        self.assertIn(f"the periodic motion is stable: deviations from it are multiplied by at most {factor:.4g} in every period",
                      said(run("simulate", self.write("damped.yaml", damped), "-t", "slow")))

    def test_forty_undamped_freedoms(self):
        n = 40
        bodies = "\n".join(f"  m{i}: {{mass: 1, com: [0, 0], inertia: 0.1, points: {{O: [0, 0]}}}}" for i in range(n))
        joints = "\n".join(f"  X{i}: {{type: prismatic, connects: [{f'm{i - 1}.O' if i else 'ground.origin'}, m{i}.O], axis: [1, 0]}}" for i in range(n))
        springs = "\n".join(f"  s{i}: {{joint: X{i}, stiffness: 100}}" for i in range(n))
        spec = self.write("chain.yaml", f"""space: planar
bodies:
{bodies}
  w: {{mass: 1, com: [0.01, 0], inertia: 0.1, points: {{O: [0, 0]}}}}
joints:
{joints}
  W: {{type: revolute, connects: [m{n - 1}.O, w.O]}}
springs:
{springs}
actuators: [W]
trajectories:
  r: {{drive: joints, speed: {{W: 7}}, from: {{joints: {{W: 0}}}}, samples: 201, free: [{', '.join(f'X{i}' for i in range(n))}], initial: steady}}
""")
        begin = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        view = json.loads(run("modes", spec, "--json").stdout)
        mass = np.diag([1.0] * (n - 1) + [2.0])
        stiffness = 100 * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
        stiffness[-1, -1] = 100
        expected = np.sort(np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)) / (2 * math.pi)
        self.assertLess(np.abs(np.sort([mode["frequency"] for mode in view["modes"]]) - expected).max(), 1e-9)
        self.assertEqual(view["response"]["exact_outcome"]["status"], "done")
        self.assertLess(max(row["difference"] or 0 for row in view["response"]["rows"]), 1e-11)  # shooting: 1e-12
        # a run per start coordinate and rate, 80 of them, took minutes
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - begin, 20 * SLOWNESS)


class Places(Case):
    def test_every_message_about_coordinates_has_its_place(self):
        """File, line, column and key, whatever is wrong: found on reading or on moving."""
        drive = "drive: joints, speed: {A: 10}, from: {joints: {A: 0}}"
        for keys, key, message in (
            ("", "from", "neither driven, held nor free: F.x, F.y, F.angle"),
            (", free: [F.x]", "free", "neither driven, held nor free: F.y, F.angle"),
            (", free: [F.x, F.y, F.angle, S]", "free", "S cannot be chosen independently of A, F.x, F.y, F.angle"),
            (", free: [F.x, F.y, S], hold: [F.angle]", "free", "S cannot be chosen independently"),
            (", free: [F.x, F.y], hold: [F.angle, B]", "free", "F.x, F.y"),
            (", free: [F.x, F.x, F.y], hold: [F.angle]", "free", "each coordinate only once"),
            (", free: [F.x, F.z], hold: [F.angle]", "free", "nearest"),
            (", free: [], hold: [F.angle]", "free", "at least one"),
            (", free: F.x", "free", "a list of joint coordinates"),
            (", free: [A, F.x, F.y, F.angle]", "free", "a joint of 'from'"),
            (", hold: [F.x, F.y, F.angle]", "hold", "'free'"),
            (", free: [F.x, F.y], hold: [F.x]", "hold", "not free"),
            (", free: [F.x, F.y, F.angle], initial: soon", "initial", "rest, equilibrium or steady"),
            (", free: [F.x, F.y, F.angle], initial: {joints: {A: 1}}", "initial", "free or held"),
            (", free: [F.x, F.y, F.angle], initial: {joints: {Q: 1}}", "initial", "'Q'"),
            (", free: [F.x, F.y], hold: [F.angle], initial: {rates: {F.angle: 1}}", "initial", "a free coordinate"),
            (", free: [F.x, F.y, F.angle], initial: {rates: {F.x: 1}, start: equilibrium}", "initial", "no 'rates'"),
            (", free: [F.x, F.y, F.angle], initial: {start: now}", "initial", "rest, equilibrium or steady"),
            (", free: [F.x, F.y, F.angle], initial: {jonts: {F.x: 1}}", "initial", "nearest is 'joints'"),
            (", initial: steady", "initial", "'free'"),
        ):
            with self.subTest(keys):
                spec = self.write("s.yaml", FRAME.replace("TRAJECTORY", drive + keys))
                for command in ("simulate", "modes"):
                    if command == "modes" and "free: [" not in keys:
                        continue
                    done = run(command, spec)
                    self.assertNotEqual(done.returncode, 0)
                    self.assertRegex(said(done), rf"s\.yaml:17:\d+: trajectories\.run\.{key}")
                    self.assertIn(message, said(done))


if __name__ == "__main__":
    unittest.main()

"""Inverse dynamics at states, against Newton and Euler by hand, other routes of the library, and threads."""

import concurrent.futures
import unittest
import warnings

import numpy

import balance_mechanisms as bm

from _module import Case, config

PENDULUM = """
name: pendulum
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  rod: {mass: 2, com: [0.25, 0], inertia: 0.02, points: {A: [0, 0]}}
joints:
  A: {type: revolute, connects: [ground.O, rod.A]}
actuators: [A]
"""


def random_states(mechanism, count, seed=1, size=0.3):
    numbers = numpy.random.default_rng(seed)
    return [size * numbers.standard_normal((count, mechanism.dof)) for _ in range(3)]


class States(Case):
    def test_a_pendulum_feels_its_weight_and_its_inertia(self):
        mechanism = bm.load(PENDULUM).mechanism
        q, dq, ddq = random_states(mechanism, 50)
        by_hand = (0.02 + 2 * 0.25**2) * ddq + 2 * 9.81 * 0.25 * numpy.cos(q)
        numpy.testing.assert_allclose(mechanism.inverse_dynamics(q, dq, ddq), by_hand, rtol=1e-13, atol=1e-13)

    def test_shapes_are_kept(self):
        mechanism = bm.load(config("spatial-rrr.yaml")).mechanism
        q, dq, ddq = random_states(mechanism, 24)
        flat = mechanism.inverse_dynamics(q, dq, ddq)
        folded = mechanism.inverse_dynamics(*(one.reshape(2, 3, 4, -1) for one in (q, dq, ddq)))
        self.assertEqual(folded.shape, (2, 3, 4, len(mechanism.actuators)))
        numpy.testing.assert_array_equal(folded.reshape(flat.shape), flat)
        self.assertEqual(mechanism.inverse_dynamics(q[0], dq[0], ddq[0]).shape, flat[0].shape)
        numpy.testing.assert_array_equal(mechanism.inverse_dynamics(q, 0 * q[0], ddq)[3],
                                         mechanism.inverse_dynamics(q[3], 0 * q[0], ddq[3]))
        fortran = mechanism.inverse_dynamics(*(numpy.asfortranarray(one) for one in (q, dq, ddq)))
        numpy.testing.assert_array_equal(fortran, flat)
        self.assertEqual(mechanism.inverse_dynamics(q[:0], dq[:0], ddq[:0]).shape, (0, flat.shape[1]))

    def test_dicts_are_by_name(self):
        mechanism = bm.load(config("3rrr.yaml")).mechanism
        start = bm.InverseDynamics(mechanism)
        names = mechanism.independent
        q, dq, ddq = (one * 0.01 for one in random_states(mechanism, 5))
        q = q + [start_value(mechanism)[name] for name in names]
        flat = mechanism.inverse_dynamics(q, dq, ddq)
        named = mechanism.inverse_dynamics(*({name: one[:, k] for k, name in reversed(list(enumerate(names)))}
                                             for one in (q, dq, ddq)))
        self.assertEqual(list(named), start.actuators)
        for k, name in enumerate(start.actuators):
            numpy.testing.assert_array_equal(named[name], flat[:, k])

    def test_wrong_shapes_and_names_are_told(self):
        mechanism = bm.load(config("3rrr.yaml")).mechanism
        good = numpy.zeros((10, 3))
        with self.assertRaisesRegex(ValueError, r"q: expected \(…, 3\) for A1, A2, A3; got \(10, 2\)"):
            mechanism.inverse_dynamics(good[:, :2], good, good)
        with self.assertRaisesRegex(ValueError, r"ddq: expected \(…, 3\) for A1, A2, A3; got \(\)"):
            mechanism.inverse_dynamics(good, good, 0)
        with self.assertRaisesRegex(ValueError, "dq: expected A1, A2, A3; A3 is missing"):
            mechanism.inverse_dynamics(good, {"A1": 0, "A2": 0}, good)
        with self.assertRaisesRegex(ValueError, "do not match"):
            mechanism.inverse_dynamics(good, good[:4], good)
        with self.assertRaises(ValueError):
            mechanism.inverse_dynamics(good + numpy.nan, good, good)
        with self.assertRaises(ValueError):
            mechanism.inverse_dynamics(good, good, good, threads=0)

    def test_rows_without_an_answer_are_told(self):
        mechanism = bm.load(config("3rrr.yaml")).mechanism
        start = numpy.array([start_value(mechanism)[name] for name in mechanism.independent])
        q, zero = numpy.array([start, start + [2.5, -2.5, 2.5], start]), numpy.zeros((3, 3))
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            efforts = mechanism.inverse_dynamics(q, zero, zero)
        self.assertEqual(numpy.isnan(efforts).any(axis=1).tolist(), [False, True, False])
        self.assertIn("1 of 3 states have no solution; the first, 1:", str(said[0].message))
        with self.assertRaises(bm.MotionError) as caught:
            mechanism.inverse_dynamics(q, zero, zero, failures="raise")
        self.assertNotEqual(caught.exception.status, "done")

    def test_a_first_state_without_an_answer_is_told_like_any_other(self):
        door = bm.InverseDynamics(bm.load(config("5r.yaml")).mechanism)
        far, near, zero = numpy.array([3.1, 0]), numpy.array([2.2, 0.8]), numpy.zeros(2)  # arms end too far from each other
        with self.assertRaises(bm.MotionError):
            door.at(far, zero, zero)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            run = door.rows(numpy.array([far, near]), zero, zero)
        self.assertIn("1 of 2 states have no solution; the first, 0:", str(said[0].message))
        self.assertEqual(numpy.isnan(run.torque).all(axis=1).tolist(), [True, False])

    def test_the_ways_to_the_efforts_agree(self):
        for name in ("3rrr.yaml", "spatial-rrr.yaml"):
            mechanism = bm.load(config(name)).mechanism
            door = bm.InverseDynamics(mechanism)
            middle = start_value(mechanism)
            q, dq, ddq = (0.1 * one[0] for one in random_states(mechanism, 1))
            q = q + [middle[coordinate] for coordinate in mechanism.independent]
            efforts = mechanism.inverse_dynamics(q, dq, ddq)
            scale = abs(efforts).max()
            numpy.testing.assert_allclose(door.at(q, dq, ddq)["torque"], efforts, atol=1e-11 * scale)
            found = door.regressor(q, dq, ddq)
            numpy.testing.assert_allclose(found["effort"] @ found["values"] + found["other"], efforts, atol=1e-11 * scale)
            if mechanism.independent == mechanism.actuators:
                again = door.mass_matrix(q) @ ddq + door.bias(q, dq)
                numpy.testing.assert_allclose(again, efforts, atol=1e-11 * scale)


def start_value(mechanism):
    """A configuration in which the loops close: the one that the spec's first motion starts from."""
    run = mechanism.spec.simulate(samples=11)
    return dict(zip(mechanism.coordinates, run.joint_position[0].tolist()))


class Threads(Case):
    def test_many_threads_give_the_answers_of_one(self):
        open_chain = bm.load(config("spatial-rrr.yaml")).mechanism
        states = random_states(open_chain, 30000)
        numpy.testing.assert_array_equal(open_chain.inverse_dynamics(*states, threads=3),
                                         open_chain.inverse_dynamics(*states))
        closed = bm.load(config("3rrr.yaml")).mechanism
        run = closed.spec.simulate(samples=3001)
        columns = [closed.coordinates.index(name) for name in closed.independent]
        along = [run[name][:, columns] for name in ("joint_position", "joint_velocity", "joint_acceleration")]
        one, several = (closed.inverse_dynamics(*along, threads=count) for count in (1, 3))
        scale = abs(one).max()
        # Newton's iteration ends elsewhere within its tolerance where a part of the rows begins anew.
        numpy.testing.assert_allclose(several, one, atol=1e-9 * scale)
        numpy.testing.assert_allclose(one, run.torque, atol=1e-9 * scale)

    def test_ten_threads_of_python_work_at_once(self):
        spec = bm.load(config("3rrr.yaml"))
        alone = spec.simulate("cycloid", samples=201).torque.tobytes()

        def work(k):
            other = bm.load(config("3rrr.yaml"))
            states = random_states(other.mechanism, 4, seed=k, size=1e-3)
            other.mechanism.inverse_dynamics(*states, failures="ignore")
            return (spec if k % 2 else other).simulate("cycloid", samples=201).torque.tobytes()

        with concurrent.futures.ThreadPoolExecutor(10) as pool:
            for found in pool.map(work, range(30)):
                self.assertEqual(found, alone)

    def test_a_single_state_has_what_a_run_has_there(self):
        spec = bm.load(config("3rrr.yaml"))
        run = spec.simulate("cycloid", samples=41)
        k, names = 13, run.labels["coordinate"]
        actuated = spec.mechanism.actuators

        def row(values, wanted=names):
            return {name: values[k, names.index(name)] for name in wanted}

        state = spec.state(row(run.joint_position), rates=row(run.joint_velocity, actuated),
                           accelerations=row(run.joint_acceleration, actuated), time=run.time[k], trajectory="cycloid")
        self.assertEqual(len(state.time), 1)
        for name in ("torque", "shaking_force", "shaking_moment", "joint_force", "kinetic_energy"):
            scale = abs(run[name]).max()  # loops are closed to 1e-12 anew
            numpy.testing.assert_allclose(state[name][0], run[name][k], rtol=0, atol=1e-9 * scale, err_msg=name)
        self.assertIn("torque[A1]", state.text())

    def test_a_state_on_a_spec_in_other_units_is_in_si(self):
        text = PENDULUM.replace("space: planar", "space: planar\nunits: {angle: deg}")
        state = bm.load(text).state({"A": 0.3}, rates={"A": 2})
        numpy.testing.assert_allclose(state.joint_position, [[0.3]], rtol=1e-15)
        numpy.testing.assert_allclose(state.joint_velocity, [[2]], rtol=1e-15)
        numpy.testing.assert_allclose(state.torque, [[2 * 9.81 * 0.25 * numpy.cos(0.3)]], rtol=1e-14)

    def test_a_state_without_motors_has_the_rest(self):
        state = bm.load(PENDULUM.replace("actuators: [A]\n", "")).state({"A": 0.3})
        self.assertNotIn("torque", state)
        self.assertIn("shaking_force", state)
        self.assertTrue(any(note.startswith("no torques") for note in state.notes), state.notes)

    def test_a_slide_has_a_force_by_both_names(self):
        run = bm.load(config("scara.yaml")).simulate("cycloid", samples=11)
        numpy.testing.assert_array_equal(run["force[J3]"], run.torque[:, 2])
        numpy.testing.assert_array_equal(run["torque[J3]"], run.torque[:, 2])
        self.assertEqual(run.metrics["torque[J3]"], run.metrics["force[J3]"])
        with self.assertRaises(KeyError):
            run["force[J1]"]


if __name__ == "__main__":
    unittest.main()

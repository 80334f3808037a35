#!/usr/bin/env python3
"""A second opinion on `balance simulate`: inverse dynamics in absolute coordinates with Lagrange multipliers.

Shares nothing with the program but the spec: no tree, no recursion, no loop joints; every body has six (planar: three)
unknowns, every joint is a set of constraint forces. numpy and PyYAML only.

    reference.py spec.yaml trajectory [sample index ...]     prints JSON
"""
import json
import sys

import numpy as np

from drive import Drive, follow
from mechanism import Mechanism, skew
from solve import complex_step, gear_rows


def at_time(load, time):
    pick = [np.interp(time, load["time"], load[key][:, k]) for key in ("force", "moment") for k in range(3)]
    return np.array(pick[:3]), np.array(pick[3:])


class Balance:
    """Newton-Euler for every body at one instant."""
    def __init__(self, drive, state):
        self.mechanism, self.about, self.state = drive.mechanism, drive.about, state
        n = self.mechanism.n
        self.p, self.R = state["p"], state["R"]
        self.v, self.w = state["velocity"].reshape(n, 6)[:, :3], state["velocity"].reshape(n, 6)[:, 3:]
        self.a, self.dw = state["acceleration"].reshape(n, 6)[:, :3], state["acceleration"].reshape(n, 6)[:, 3:]
        self.inertial = np.zeros((n, 6))          # rate of momentum, moment about each body's origin
        self.external = np.zeros((n, 6))          # weight, loads, springs on each body, moment about its origin
        self.force, self.moment = np.zeros(3), np.zeros(3)
        self.outer_force, self.outer_moment = np.zeros(3), np.zeros(3)
        self.kinetic = 0.0
        self._inertia()
        self._surroundings()
        self._solve()

    def _inertia(self):
        for body, lumps in enumerate(self.mechanism.lumps):
            w, dw = self.w[body], self.dw[body]
            for m, place, inertia in lumps:
                s, I = self.R[body] @ place, self.R[body] @ inertia @ self.R[body].T
                a = self.a[body] + np.cross(dw, s) + np.cross(w, np.cross(w, s))
                v = self.v[body] + np.cross(w, s)
                spin = I @ dw + np.cross(w, I @ w)
                self.inertial[body] += np.append(m * a, np.cross(s, m * a) + spin)
                self.force += m * a
                self.moment += np.cross(self.p[body] + s - self.about, m * a) + spin
                self.kinetic += m * v @ v / 2 + w @ I @ w / 2
                self._push(body, s, m * self.mechanism.gravity, np.zeros(3), True)

    def _push(self, body, arm, force, moment, from_outside):
        self.external[body] += np.append(force, np.cross(arm, force) + moment)
        if from_outside:
            self.outer_force += force
            self.outer_moment += np.cross(self.p[body] + arm - self.about, force) + moment

    def _surroundings(self):
        for load in self.mechanism.loads:
            force, moment = at_time(load, self.state["time"])
            turn = self.R[load["body"]] if load["in_body"] else np.eye(3)
            self._push(load["body"], self.R[load["body"]] @ load["at"], turn @ force, turn @ moment, True)
        for spring in self.mechanism.springs:
            if "joint" in spring:
                continue                           # like friction, a part of what the joint transmits
            i, j = spring["first"], spring["second"]
            arm_i, arm_j = self.R[i] @ spring["p"], self.R[j] @ spring["q"]
            line = self.p[j] + arm_j - self.p[i] - arm_i
            length = np.linalg.norm(line)
            stretch = 1 - spring["free_length"] / length if spring["free_length"] else 1
            pull = spring["stiffness"] * stretch * line
            self._push(i, arm_i, pull, np.zeros(3), False)
            self._push(j, arm_j, -pull, np.zeros(3), False)

    def _solve(self):
        mechanism, p, R = self.mechanism, self.p, self.R
        _, joint_rows, owner = mechanism.constraints(p, R)
        joint_rows, G = joint_rows.real, mechanism.rates(p, R).real
        gears = gear_rows(mechanism, p, R).real
        motors = G[mechanism.actuators].reshape(-1, 6 * mechanism.n)
        self.rates = G @ self.state["velocity"]
        drift = complex_step(mechanism, mechanism.rates, p, R, self.state["velocity"])
        self.rate_changes = G @ self.state["acceleration"] + drift @ self.state["velocity"]
        friction = np.zeros(len(G))
        for c, viscous, coulomb in mechanism.friction:
            friction[c] -= viscous * self.rates[c] + coulomb * np.sign(self.rates[c])
        for spring in mechanism.springs:
            if "joint" in spring:
                c = spring["joint"]
                friction[c] += spring["preload"] - spring["stiffness"] * self.state["q"][c]
        known = self.inertial.ravel() - self.external.ravel() - friction @ G
        A = np.vstack([joint_rows, gears, motors])[:, mechanism.columns].T
        # forces and moments are scaled alike: the columns of A are made unit vectors first
        U, S, Vt = np.linalg.svd(A, full_matrices=True)
        rank = int((S > 1e-9 * S[0]).sum())
        x = Vt[:rank].T @ ((U[:, :rank].T @ known[mechanism.columns]) / S[:rank])
        free = Vt[rank:].T                         # what the over-constrained mechanism leaves open
        self.residual = np.abs(A @ x - known[mechanism.columns]).max()
        k, g = len(joint_rows), len(gears)
        self.torque, self.torque_open = x[k + g:], np.abs(free[k + g:]).sum(axis=1)
        # what goes through each joint on its second body, and how it depends on x
        self.joint_wrench, self.joint_open = [], []
        for j in range(mechanism.spec_joints):
            own = np.array([o == j for o in owner])
            through = np.zeros((6 * mechanism.n, len(x)))
            through[:, :k][:, own] = joint_rows[own].T
            fixed = np.zeros(6 * mechanism.n)
            for c, at in enumerate(mechanism.coordinate_joint):
                if at != j:
                    continue
                effort = np.zeros(len(x))
                for n, (follower, leaders, _) in enumerate(mechanism.couplings):
                    effort[k + n] += (follower == c) - leaders.get(c, 0)
                for n, motor in enumerate(mechanism.actuators):
                    effort[k + g + n] += motor == c
                through += np.outer(G[c], effort)
                fixed += friction[c] * G[c]
            second = mechanism.joints[j]["second"]
            here = slice(6 * second, 6 * second + 6)
            arm = R[second] @ mechanism.joints[j]["q"]
            shift = np.eye(6)
            shift[3:, :3] = -skew(arm)
            self.joint_wrench.append(shift @ (through[here] @ x + fixed[here]))
            self.joint_open.append(np.abs(shift @ through[here] @ free).sum(axis=1) if free.size else np.zeros(6))


def quaternion(R):
    """w, x, y, z from the largest component of R."""
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0], [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]]) / 3
    x, y, z, w = np.linalg.eigh(K)[1][:, -1]
    return np.array([w, x, y, z])


def at_indices(path, trajectory, indices=None, parts=(0, 0.1, 0.3, 0.45, 0.5, 0.8, 1)):
    """Everything that the program writes, at some samples of a trajectory."""
    mechanism = Mechanism(path)
    drive = Drive(mechanism, trajectory)
    if not indices:
        indices = sorted({round(part * (drive.samples - 1)) for part in parts})
    out = dict(freedoms=drive.freedoms, coordinate=mechanism.names[:mechanism.spec_coordinates],
               joint=[j["name"] for j in mechanism.joints[:mechanism.spec_joints]],
               actuator=[mechanism.names[a] for a in mechanism.actuators], samples=[])
    for state in follow(drive, indices):
        out["samples"].append(sample(drive, state))
    return out


def sample(drive, state):
    mechanism, balance = drive.mechanism, Balance(drive, state)
    axes, turns = (slice(0, 2), slice(2, 3)) if mechanism.planar else (slice(0, 3), slice(0, 3))
    n, com = mechanism.spec_coordinates, mechanism.com_rows(state["R"]).real
    wrench, opened = np.array(balance.joint_wrench), np.array(balance.joint_open)
    row = dict(
        index=state["index"], time=state["time"], condition=state["condition"], residual=balance.residual,
        joint_position=state["q"][:n], joint_velocity=balance.rates[:n], joint_acceleration=balance.rate_changes[:n],
        torque=balance.torque, torque_open=balance.torque_open,
        power=balance.torque * balance.rates[mechanism.actuators],
        com_position=mechanism.com(state["p"], state["R"])[axes], com_velocity=(com @ state["velocity"])[axes],
        com_acceleration=balance.force[axes] / mechanism.mass,
        shaking_force=balance.force[axes], shaking_moment=balance.moment[turns],
        ground_force=(balance.outer_force - balance.force)[axes],
        ground_moment=(balance.outer_moment - balance.moment)[turns],
        joint_force=wrench[:, :3][:, axes], joint_moment=wrench[:, 3:][:, turns],
        joint_force_open=opened[:, :3][:, axes], joint_moment_open=opened[:, 3:][:, turns],
        kinetic_energy=balance.kinetic)
    if mechanism.tool:
        body, place = mechanism.tool
        R = state["R"][body]
        row["tool_position"] = (state["p"][body] + R @ place)[axes]
        row["tool_orientation"] = np.atleast_1d(np.arctan2(R[1, 0], R[0, 0])) if mechanism.planar else quaternion(R)
    return {key: np.asarray(value).tolist() for key, value in row.items()}


if __name__ == "__main__":
    print(json.dumps(at_indices(sys.argv[1], sys.argv[2], [int(k) for k in sys.argv[3:]])))

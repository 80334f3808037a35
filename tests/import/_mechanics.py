"""Reads a URDF's tree and its inverse dynamics by virtual power, from the file's numbers and with nothing of the program."""

import xml.etree.ElementTree as ElementTree

import numpy as np


def rotation(axis, angle):
    """Rodrigues."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def numbers(text, fallback):
    return np.array([float(word) for word in text.split()]) if text else np.array(fallback, float)


def origin(element):
    found = element.find("origin")
    if found is None:
        return np.eye(3), np.zeros(3)
    roll, pitch, yaw = numbers(found.get("rpy"), [0, 0, 0])
    ex, ey, ez = np.eye(3)
    return rotation(ez, yaw) @ rotation(ey, pitch) @ rotation(ex, roll), numbers(found.get("xyz"), [0, 0, 0])


class Urdf:
    """Links and joints of a tree, in an order in which parents come first."""

    def __init__(self, text):
        root = ElementTree.fromstring(text)
        self.mass, self.com, self.inertia = {}, {}, {}
        for link in root.findall("link"):
            name, inertial = link.get("name"), link.find("inertial")
            self.mass[name], self.com[name], self.inertia[name] = 0.0, np.zeros(3), np.zeros((3, 3))
            if inertial is None:
                continue
            R, p = origin(inertial)
            I = inertial.find("inertia")
            xx, xy, xz, yy, yz, zz = (float(I.get(k, 0)) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
            self.mass[name], self.com[name] = float(inertial.find("mass").get("value")), p
            self.inertia[name] = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
        waiting = root.findall("joint")
        children = {j.find("child").get("link") for j in waiting}
        self.base = next(name for name in self.mass if name not in children)
        self.joints, known = [], {self.base}
        while waiting:
            ready = [j for j in waiting if j.find("parent").get("link") in known]
            for joint in ready:
                known.add(joint.find("child").get("link"))
                self.joints.append(self._joint(joint))
            waiting = [j for j in waiting if j not in ready]

    @staticmethod
    def _joint(joint):
        axis = joint.find("axis")
        u = numbers(axis.get("xyz") if axis is not None else None, [1, 0, 0])
        mimic = joint.find("mimic")
        return {"name": joint.get("name"), "type": joint.get("type"), "parent": joint.find("parent").get("link"),
                "child": joint.find("child").get("link"), "origin": origin(joint), "axis": u / max(np.linalg.norm(u), 1e-300),
                "mimic": None if mimic is None else
                (mimic.get("joint"), float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0)))}

    def full(self, q, dq, ddq):
        """The coordinates of all joints from those that mimic nobody."""
        q, dq, ddq = dict(q), dict(dq), dict(ddq)
        for _ in self.joints:
            for joint in self.joints:
                if joint["mimic"] and joint["mimic"][0] in q:
                    leader, ratio, offset = joint["mimic"]
                    q[joint["name"]] = ratio * q[leader] + offset
                    dq[joint["name"]], ddq[joint["name"]] = ratio * dq[leader], ratio * ddq[leader]
        return q, dq, ddq

    def dynamics(self, q, dq, ddq, gravity=(0, 0, -9.81)):
        """Efforts by joint (followers' included in their leaders'), F, N about the origin, the centre of mass, the mass."""
        q, dq, ddq = self.full(q, dq, ddq)
        zero = np.zeros(3)
        state = {self.base: (np.eye(3), zero, zero, zero, zero, zero)}  # R, p, w, v, alpha, a
        columns = {self.base: {}}
        standing = {self.base}
        for joint in self.joints:
            R, p, w, v, alpha, a = state[joint["parent"]]
            R0, p0 = joint["origin"]
            u, name, kind = R @ R0 @ joint["axis"], joint["name"], joint["type"]
            r = R @ p0
            new = dict(columns[joint["parent"]])
            if kind == "fixed":
                if joint["parent"] in standing:
                    standing.add(joint["child"])
                state[joint["child"]] = (R @ R0, p + r, w, v + np.cross(w, r), alpha,
                                         a + np.cross(alpha, r) + np.cross(w, np.cross(w, r)))
            elif kind == "prismatic":
                s, ds, dds = q[name], dq[name], ddq[name]
                r = r + s * u
                state[joint["child"]] = (R @ R0, p + r, w, v + np.cross(w, r) + ds * u, alpha,
                                         a + np.cross(alpha, r) + np.cross(w, np.cross(w, r)) + 2 * ds * np.cross(w, u) + dds * u)
                new[name] = ("slide", u, None)
            else:
                spin = dq[name] * u
                state[joint["child"]] = (R @ R0 @ rotation(joint["axis"], q[name]), p + r, w + spin, v + np.cross(w, r),
                                         alpha + ddq[name] * u + np.cross(w, spin),
                                         a + np.cross(alpha, r) + np.cross(w, np.cross(w, r)))
                new[name] = ("turn", u, p + r)
            columns[joint["child"]] = new
        efforts = {joint["name"]: 0.0 for joint in self.joints if joint["type"] != "fixed"}
        F, N, moment, total = np.zeros(3), np.zeros(3), np.zeros(3), 0.0
        for link, (R, p, w, v, alpha, a) in state.items():
            if link in standing:
                continue
            c = R @ self.com[link]
            m, I = self.mass[link], R @ self.inertia[link] @ R.T
            force = m * (a + np.cross(alpha, c) + np.cross(w, np.cross(w, c)))
            couple = I @ alpha + np.cross(w, I @ w)
            F, N = F + force, N + np.cross(p + c, force) + couple
            moment, total = moment + m * (p + c), total + m
            for name, (kind, u, place) in columns[link].items():
                push = force - m * np.array(gravity)
                efforts[name] += u @ push if kind == "slide" else u @ couple + np.cross(u, p + c - place) @ push
        for joint in reversed(self.joints):
            if joint["mimic"]:
                efforts[joint["mimic"][0]] += joint["mimic"][1] * efforts.pop(joint["name"])
        return efforts, F, N, moment / total if total else moment, total

"""Reads the plain part of a spec: everything that inverse dynamics needs, for specs that are known to be valid."""
import ast
import math
import operator

import numpy as np
import yaml


class Loader(yaml.SafeLoader):
    """YAML as the program reads it: `on`, `off`, `yes`, `no` are words, not truth values."""


Loader.yaml_implicit_resolvers = {
    letter: [(tag, pattern) for tag, pattern in rules if tag != "tag:yaml.org,2002:bool"]
    for letter, rules in yaml.SafeLoader.yaml_implicit_resolvers.items()
}

OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
             ast.Pow: operator.pow, ast.USub: operator.neg, ast.UAdd: operator.pos}
FUNCTIONS = {name: getattr(math, name)
             for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp")}
JOINT_COORDINATES = {
    "revolute": ("angle",), "prismatic": ("slide",), "fixed": (), "pin-slot": ("slide", "angle"),
    "rolling": ("slide", "angle"),
    "cylindrical": ("angle", "slide"), "universal": ("1", "2"), "spherical": ("1", "2", "3"),
    "planar": ("x", "y", "angle"),
}


def binds_rates(raw):
    """Rates that places do not follow: no concern of this reference; tests/cli/rolling_in_space.py has closed forms."""
    rolls = any(joint["type"] == "rolling" for joint in raw["joints"].values())
    return "constraints" in raw or (rolls and raw["space"] == "spatial")


def buys_parts(raw):
    """Parts of catalogues have no numbers before they are chosen, nor have shapes masses; tests/cli/catalogue.py has them."""
    return any({"catalogue", "shape"} & set(part) for section in ("springs", "counterweights") for part in (raw.get(section) or {}).values())


def carrier(item):
    """The body that something is on: `on` is the older key."""
    return item["body"] if "body" in item else item["on"]


def roll_pitch_yaw(angles):
    """Rotation about the fixed x, then y, then z axis."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in angles)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def from_quaternion(values):
    w, x, y, z = np.array(values) / np.linalg.norm(values)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class Spec:
    def __init__(self, path):
        self.raw = self.load(path)
        self.planar = self.raw["space"] == "planar"
        self.parameters = dict(self.raw.get("parameters") or {})
        self.body_names = ["ground"] + list(self.raw["bodies"])
        self.gravity = self.vector(self.raw.get("gravity", [0, 0, 0]))

    @staticmethod
    def load(path):
        with open(path, encoding="utf-8") as stream:
            return yaml.load(stream, Loader)

    # numbers

    def number(self, value):
        if isinstance(value, dict):
            return self.number(value["start"]) if "start" in value else sum(map(self.number, value["free"])) / 2
        if isinstance(value, (int, float)):
            return float(value)
        return self._evaluate(ast.parse(value.replace("^", "**"), mode="eval").body)

    def _evaluate(self, node):
        if isinstance(node, ast.Constant):
            return float(node.value)
        if isinstance(node, ast.Name):
            return math.pi if node.id == "pi" else self.number(self.parameters[node.id])
        if isinstance(node, ast.BinOp):
            return OPERATORS[type(node.op)](self._evaluate(node.left), self._evaluate(node.right))
        if isinstance(node, ast.UnaryOp):
            return OPERATORS[type(node.op)](self._evaluate(node.operand))
        if isinstance(node, ast.Call):
            return FUNCTIONS[node.func.id](*map(self._evaluate, node.args))
        raise ValueError(f"not an arithmetic expression: {ast.dump(node)}")

    def vector(self, values):
        numbers = [self.number(v) for v in values]
        return np.array(numbers + [0.0] * (3 - len(numbers)))

    def point(self, body, place):
        """A named point of a body, or coordinates in its axes."""
        if not isinstance(place, str):
            return self.vector(place)
        holder = self.raw["ground"] if body == "ground" else self.raw["bodies"][body]
        return self.vector(holder["points"][place])

    def inertia(self, value, mass, com):
        """About the CoM, 3 by 3."""
        if value is None:
            return np.zeros((3, 3))
        about_origin = isinstance(value, dict) and value.get("about") == "origin"
        if isinstance(value, dict) and "value" in value:
            value = value["value"]
        if isinstance(value, list):
            xx, yy, zz, xy, xz, yz = ([self.number(v) for v in value] + [0.0] * 3)[:6]
            matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        else:
            matrix = np.diag([0, 0, self.number(value)])
        if about_origin:
            matrix = matrix - mass * (com @ com * np.eye(3) - np.outer(com, com))
        return matrix

    # elements

    def lumps(self, body):
        """(mass, place of the CoM, inertia about it) of a body and of everything fixed to it."""
        raw = self.raw["bodies"][body]
        mass, com = self.number(raw["mass"]), self.vector(raw["com"])
        found = [(mass, com, self.inertia(raw["inertia"], mass, com))]
        for kind in ("counterweights", "payloads"):
            for item in (self.raw.get(kind) or {}).values():
                if carrier(item) == body:
                    mass, place = self.number(item["mass"]), self.point(body, item["at"])
                    found.append((mass, place, self.inertia(item.get("inertia"), mass, np.zeros(3))))
        return found

    def joints(self):
        for name, raw in self.raw["joints"].items():
            (first, p), (second, q) = (place.split(".", 1) for place in raw["connects"])
            kind = raw["type"]
            if self.planar:
                rotation = roll_pitch_yaw([0, 0, self.number(raw.get("angle", 0))])
                axis = self.vector(raw["axis"]) if "axis" in raw else np.array([0, 0, 1.0])
            else:
                rotation = roll_pitch_yaw(self.vector(raw.get("rpy", [0, 0, 0])))
                axis = self.vector(raw.get("axis", [0, 0, 1]))
            axis2 = self.vector(raw.get("axis2", [1, 0, 0]))
            if self.planar and kind == "planar":  # the axis is the direction of x
                axis, axis2 = np.array([0, 0, 1.0]), self.vector(raw.get("axis", [1, 0]))
            place = self.point(first, p)
            if kind == "rolling":  # the wheel's centre goes along a slot
                kind, axis = "pin-slot", self.vector(raw.get("axis", [1, 0]))
                place = place + self.number(raw["radius"]) * np.array([-axis[1], axis[0], 0]) / np.linalg.norm(axis)
            yield dict(name=name, kind=kind, first=self.body_names.index(first), second=self.body_names.index(second),
                       p=place, q=self.point(second, q), axis=axis / np.linalg.norm(axis),
                       axis2=axis2 / np.linalg.norm(axis2), rotation=rotation)

    def coordinate_names(self):
        names = []
        for name, raw in self.raw["joints"].items():
            parts = JOINT_COORDINATES[raw["type"]]
            names += [name] if len(parts) == 1 else [f"{name}.{part}" for part in parts]
        return names

    def leaders(self, raw):
        """Ratios to the coordinates that a coupling or a disc follows."""
        follows, index = raw["follows"], self.coordinate_names().index
        ratios = follows if isinstance(follows, dict) else {follows: 1}
        return {index(name): self.number(raw.get("ratio", 1)) * self.number(ratio) for name, ratio in ratios.items()}

    def wheels(self):
        """(coordinate, its leaders with their ratios, offset) of joints that roll."""
        index = self.coordinate_names().index
        for name, raw in self.raw["joints"].items():
            if raw["type"] == "rolling":
                yield index(f"{name}.slide"), {index(f"{name}.angle"): -self.number(raw["radius"])}, 0.0

    def discs(self):
        for name, raw in (self.raw.get("discs") or {}).items():
            mass, value = self.number(raw.get("mass", 0)), raw["inertia"]
            axis = np.array([0, 0, 1.0])
            if "axis" in raw:
                axis = self.vector(raw["axis"])
            elif not self.planar:
                axis = self._followed_axis(carrier(raw), raw["follows"])
            axis = axis / np.linalg.norm(axis)
            if isinstance(value, dict) and "axial" in value:
                along, across = self.number(value["axial"]), self.number(value["transverse"])
                inertia = across * np.eye(3) + (along - across) * np.outer(axis, axis)
            else:
                inertia = self.inertia(value, mass, np.zeros(3))
            yield dict(name=name, carrier=self.body_names.index(carrier(raw)), at=self.point(carrier(raw), raw["at"]),
                       axis=axis, leaders=self.leaders(raw), mass=mass, inertia=inertia)

    def _followed_axis(self, carrier, coordinate):
        """The followed joint's axis in the carrier; the carrier must be one of the bodies that it connects."""
        joint = next(j for j in self.joints() if j["name"] == coordinate.split(".")[0])
        if self.body_names[joint["first"]] == carrier:
            return joint["axis"]
        assert self.body_names[joint["second"]] == carrier, "give the disc an axis"
        return joint["rotation"].T @ joint["axis"]

    def loads(self):
        for raw in (self.raw.get("loads") or {}).values():
            table = raw.get("table") or {}
            times = [self.number(t) for t in table.get("time", [0])]
            force = self._rows(table.get("force"), raw.get("force"), len(times), False)
            moment = self._rows(table.get("moment"), raw.get("moment"), len(times), True)
            yield dict(body=self.body_names.index(carrier(raw)), at=self.point(carrier(raw), raw.get("at", [0, 0, 0])),
                       in_body=raw.get("frame", "world") == "body", time=times, force=force, moment=moment)

    def _rows(self, rows, constant, count, about_z):
        def read(value):
            return self.vector(value) if isinstance(value, list) else np.array([0, 0, self.number(value)])
        if rows is not None:
            return np.array([read(row) for row in rows])
        one = np.zeros(3) if constant is None else read(constant)
        return np.array([one] * count)

    def springs(self):
        for raw in (self.raw.get("springs") or {}).values():
            given = raw["stiffness"]  # a free one is not there to begin with
            stiffness = 0 if isinstance(given, dict) and "start" not in given and given["free"][0] == 0 else self.number(given)
            if "joint" in raw:
                preload = self.number(raw["preload"]) if "preload" in raw else stiffness * self.number(raw.get("rest", 0))
                yield dict(joint=self.coordinate_names().index(raw["joint"]), stiffness=stiffness, preload=preload)
                continue
            (first, p), (second, q) = (place.split(".", 1) for place in raw["between"])
            yield dict(first=self.body_names.index(first), second=self.body_names.index(second), p=self.point(first, p),
                       q=self.point(second, q), stiffness=stiffness,
                       free_length=self.number(raw.get("free_length", 0)))

    def pose(self, raw):
        """from / to: what is given, as numbers."""
        target = {}
        for key, value in raw.items():
            if key == "joints":
                target["joints"] = {self.coordinate_names().index(k): self.number(v) for k, v in value.items()}
            elif key in ("tool", "com"):
                target[key] = self.vector(value)
            elif key == "angle":
                target["angle"] = self.number(value)
            elif key == "rpy":
                target["orientation"] = roll_pitch_yaw(self.vector(value))
            elif key == "quaternion":
                target["orientation"] = from_quaternion([self.number(v) for v in value])
            else:
                raise ValueError(f"pose key {key} is not part of the reference")
        return target

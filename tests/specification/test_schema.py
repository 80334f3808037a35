"""The JSON Schema takes every mechanism in configs and in the reader's tests, and refuses what no spec may have."""

import json
import os
import pathlib
import re
import sys

import jsonschema
import yaml

here = pathlib.Path(__file__).parent
configs = pathlib.Path(os.environ.get("CONFIGS", here.parents[1] / "configs"))


class Loader(yaml.SafeLoader):
    """YAML 1.2 as far as it matters: `on` and `no` are words, not truth values. For specs in the older spelling."""


Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:bool"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}


def read(text):
    return yaml.load(text, Loader)


def specs():
    """The mechanisms in configs and the two complete specs that the reader's tests spoil, by name."""
    for path in sorted([*configs.glob("*.yaml"), *configs.glob("starters/*.yaml"), *configs.glob("machines/*.yaml")]):
        # (D8) as any tool reads them, by YAML 1.1; nothing in them may turn into a truth value
        yield path.name, yaml.safe_load(path.read_text(encoding="utf-8"))
    raw_strings = re.findall(r'R"\((.*?)\)"', (here / "specs.hpp").read_text(encoding="utf-8"), re.DOTALL)
    for number, text in enumerate(raw_strings):
        yield f"specs.hpp, spec {number}", read(text)


def vector_of(spec):
    """The centre of mass of the first body."""
    return next(iter(spec["bodies"].values()))["com"]


def mistakes(spec):
    """The spec with one mistake at a time: (name, wrong spec)."""

    def changed(change):
        copy = json.loads(json.dumps(spec))
        change(copy)
        return copy

    first_body = next(iter(spec["bodies"]))
    first_joint = next(iter(spec["joints"]))
    yield "unknown key", changed(lambda s: s.update(bodeis={}))
    yield "no space", changed(lambda s: s.pop("space"))
    yield "another space", changed(lambda s: s.update(space="flat"))
    yield "no mass", changed(lambda s: s["bodies"][first_body].pop("mass"))
    yield "a mass that is a list", changed(lambda s: s["bodies"][first_body].update(mass=[1]))
    yield "one bound", changed(lambda s: s["bodies"][first_body].update(mass={"free": [1]}))
    yield "an unknown type", changed(lambda s: s["joints"][first_joint].update(type="hinge"))
    yield "one end", changed(lambda s: s["joints"][first_joint].update(connects=["ground.O"]))
    yield "a unit of nothing", changed(lambda s: s.update(units={"length": "inch"}))
    yield "a motion without an end", changed(lambda s: s.update(motion={"duration": 1, "form": {}}))
    yield "a name with a blank", changed(lambda s: s["bodies"].update({"a b": s["bodies"][first_body]}))
    yield "a name that turns the direction", changed(lambda s: s["bodies"].update({"a\u202eb": s["bodies"][first_body]}))
    load = {"force": [0] * len(vector_of(spec))}
    yield "a load on nothing", changed(lambda s: s.update(loads={"f": load}))
    yield "a load on two bodies", changed(lambda s: s.update(loads={"f": dict(load, body=first_body, on=first_body)}))
    yield "a load on what YAML 1.1 makes of 'on'", changed(lambda s: s.update(loads={"f": dict(load, true=first_body)}))
    yield "an unknown law", changed(lambda s: s.update(trajectories={"t": {"law": "fast", "drive": "tool"}}))


def designs():
    """What `design` may say, by name."""
    yield "one size", {"goal": "decoupled", "minimize": "added-inertia"}
    yield "two goals", {"goal": ["force", "moment"]}
    yield "a figure", {"minimize": {"peak": "shaking_force", "along": "cycloid"}}
    yield "a sum", {"minimize": [{"rms": "torque[J1]", "weight": "2 * l"}, {"of": "total-mass", "weight": 0.5}, "added-mass"]}
    yield "orders", {"goal": ["static", {"orders": {"shaking_force": {"forward": [1], "backward": "1/2"}, "torque[J1]": 2}, "along": "run"}]}
    yield "an order as text", {"goal": "backward order 2 of shaking_force along run"}
    yield "figures of orders", {"minimize": [{"order": 2, "of": "shaking_force", "along": "run"}, {"quality": "shaft"}, {"of": "fluctuation", "along": "run"}]}
    yield "a search", {
        "search": {"global": "isres", "local": "sbplx", "seed": 0, "restarts": 10000, "evaluations": 1, "seconds": 0.5}
    }


def wrong_designs():
    """What `design` may not say, by name."""
    yield "an unknown goal", {"goal": "statics"}
    yield "orders along nothing", {"goal": {"orders": {"shaking_force": [1]}}}
    yield "order zero", {"goal": {"orders": {"shaking_force": [0]}, "along": "run"}}
    yield "an order of nothing", {"minimize": {"order": 2}}
    yield "an unknown size", {"minimize": "mass"}
    yield "a figure without its quantity", {"minimize": {"along": "cycloid"}}
    yield "two figures at once", {"minimize": {"rms": "power", "peak": "power"}}
    yield "a size along a trajectory", {"minimize": {"of": "added-mass", "along": "cycloid"}}
    yield "an unknown method", {"search": {"global": "luck"}}
    yield "no restarts", {"search": {"restarts": 0}}


def controllers():
    """What `controllers` may say, by name."""
    yield "a type alone", {"c": {"type": "computed-torque"}}
    yield "gains by name", {"c": {"type": "pd", "rate": 500, "kp": {"J1": 3}, "kd": [1, 2], "gravity": "ignored"}}
    yield "a boundary layer", {"c": {"type": "sliding-mode", "lambda": "2*l", "k": 3, "switching": {"boundary_layer": 0.1}}}
    yield "a model", {"c": {"type": "pd", "model": {"without": ["cargo"], "mass_scale": 1.1, "set": {"bodies.a.mass": 2}}}}
    yield "torques by a spline", {"c": {"type": "open-loop", "interpolation": "spline",
                                        "table": [[0, 1, 2], [1, 2, 3], [2, 0, 1], [3, 1, 1]]}}
    yield "torques over time", {"c": {"type": "open-loop", "table": [[0, 1, 2], [1, 2, 3]], "period": 0.01}}


def wrong_controllers():
    """What `controllers` may not say, by name."""
    yield "no type", {"c": {"rate": 100}}
    yield "an unknown type", {"c": {"type": "pid"}}
    yield "a key of another type", {"c": {"type": "pd", "lambda": 1}}
    yield "an unknown interpolation", {"c": {"type": "open-loop", "table": [[0, 1, 2]], "interpolation": "steps"}}
    yield "rate and period", {"c": {"type": "pd", "rate": 1, "period": 1}}
    yield "a free gain", {"c": {"type": "pd", "kp": {"free": [0, 1]}, "kd": {"free": [0]}}}
    yield "two initial errors", {"c": {"type": "pd", "initial_error": {"joints": {"J": 1}, "tool": [0, 0]}}}


def parts():
    """What `include` may say, by name."""
    yield "one part", {"file": "leg.yaml", "as": "leg"}
    yield "copies", [{"file": "leg.yaml", "as": ["a", "b"], "at": {"a": [0, "l"]}, "on": "platform", "set": {"l": {"a": 1}, "m": "shared"}}]
    yield "less of it", [{"file": "leg.yaml", "as": "a", "without": ["payloads", "actuators.B"], "angle": {"free": [0, 1]}}]


def wrong_parts():
    """What `include` may not say, by name."""
    yield "a file alone", "leg.yaml"
    yield "no name", [{"file": "leg.yaml"}]
    yield "another key", [{"file": "leg.yaml", "as": "a", "place": [0, 0]}]


def is_mechanism(spec):
    return isinstance(spec, dict) and "bodies" in spec


def main():
    schema = json.loads((configs / "balance.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft7Validator.check_schema(schema)
    validator = jsonschema.Draft7Validator(schema)
    failures = []
    mechanisms = {name: spec for name, spec in specs() if is_mechanism(spec)}
    for name, spec in mechanisms.items():
        for error in validator.iter_errors(spec):
            failures.append(f"{name}: {'.'.join(map(str, error.absolute_path))}: {error.message}")
        for mistake, wrong in mistakes(spec):
            if validator.is_valid(wrong):
                failures.append(f"{name}: the schema takes {mistake}")
    name, spec = min(mechanisms.items(), key=lambda item: len(str(item[1])))
    for right, all_designs in ((True, designs()), (False, wrong_designs())):
        for design, value in all_designs:
            if validator.is_valid(dict(spec, design=value)) != right:
                failures.append(f"{name}: the schema {'refuses' if right else 'takes'} {design}")
    for right, all_controllers in ((True, controllers()), (False, wrong_controllers())):
        for controller, value in all_controllers:
            if validator.is_valid(dict(spec, controllers=value)) != right:
                failures.append(f"{name}: the schema {'refuses' if right else 'takes'} {controller}")
    for right, all_parts in ((True, parts()), (False, wrong_parts())):
        for part, value in all_parts:
            if validator.is_valid(dict(spec, include=value)) != right:
                failures.append(f"{name}: the schema {'refuses' if right else 'takes'} {part}")
    print("\n".join(failures) or f"{len(mechanisms)} mechanisms fit the schema")
    return 1 if failures or not mechanisms else 0


if __name__ == "__main__":
    sys.exit(main())

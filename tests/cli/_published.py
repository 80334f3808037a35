"""The suite of published cases, and parts of it."""

import os
import re

from _program import CONFIGS

SUITE = os.path.join(CONFIGS, "suites", "published.yaml")
SPECS = os.path.join(CONFIGS, "published")


def read_cases():
    """{name: its text} of all cases, in their order."""
    with open(SUITE, encoding="utf-8") as file:
        text = file.read().split("\ncases:\n", maxsplit=1)[1]
    parts = re.split(r"^  ([\w.+=-]+):$", text, flags=re.MULTILINE)
    return {name: re.sub(r"^ *#.*\n", "", content, flags=re.MULTILINE) for name, content in zip(parts[1::2], parts[2::2])}


def spec_of(content):
    """The spec of a case, relative to the suite."""
    return re.search(r"\bspec: ([^,\s]+)", content)[1]


def traits_of(content):
    """What kinds of things a case asks for."""
    found = set(re.findall(r"^ +(run|solve|design|controller|points|set|require|waits|trajectory):", content, re.MULTILINE))
    found |= set(re.findall(r"\brun: (\w+)", content)) | set(re.findall(r"\bverdict: ([\w-]+)", content))
    return found | set(re.findall(r"\b([a-z_]+)\(", content)) - {"sin", "cos", "sqrt", "abs", "max", "asin"}


def with_named(cases, names):
    """These cases and those that their requirements name, in the suite's order."""
    wanted, pending = set(), list(names)
    while pending:
        name = pending.pop()
        if name not in wanted:
            wanted.add(name)
            pending += [other for other in re.findall(r"'([\w.+=-]+)'", cases[name]) if other in cases]
    return [name for name in cases if name in wanted]


def write_suite(cases, names, path):
    """A suite of these cases and those that their requirements name."""
    text = "".join(f"  {name}:\n{cases[name].rstrip()}\n" for name in with_named(cases, names))
    with open(path, "w", encoding="utf-8") as file:
        file.write("name: some of the published cases\ncases:\n" + text.replace("spec: ../", f"spec: {CONFIGS}/"))

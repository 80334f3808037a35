"""Every command of the program and every public function of the library has its twin, or a reason why not, in docs/python.md."""

import functools
import os
import re
import unittest

import balance_mechanisms

from _module import run

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


def text_of(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


def public_functions():
    """Names of the functions outside of classes in the public headers."""
    listed = " ".join(re.findall(r"set\(balance_public_\w+([^)]*)\)", text_of("cmake", "PublicHeaders.cmake")))
    names = set()
    for header in re.findall(r"[a-z_]+/[a-z_]+/[a-z_0-9]+\.hpp", listed):
        if header == "foundation/base/version.hpp":
            names.add("version")
            continue
        text = text_of("lib", "balance", header)
        text = re.sub(r"//.*|^#.*", "", text, flags=re.M).replace("{}", "")
        depth, line = 0, ""
        for symbol in text:  # what stands in the namespace itself
            if symbol == "{":
                depth += 0 if line.strip().startswith("namespace") else 1
                line = line if depth else ""
            elif symbol == "}":
                depth = max(0, depth - 1)
                line = ""
            elif depth == 0:
                line += symbol
                if symbol == ";":
                    names.update(declared(line))
                    line = ""
    return names


def declared(line):
    line = " ".join(line.split())
    if re.match(r"(struct|class|enum|using|template|extern|inline constexpr)\b", line):
        return []
    found = re.search(r"([a-z][a-z_0-9]*)\(", line)
    return [found.group(1)] if found else []


def table(heading):
    """The rows of the table below a heading of the page: the first column's names, the second column."""
    part = text_of("docs", "python.md").split(f"## {heading}\n")[1].split("\n## ")[0]
    rows = {}
    for row in re.findall(r"^\| (.+?) \| (.+?) \|$", part, re.M)[1:]:
        for name in re.findall(r"`([^`]+)`", row[0]):
            rows[name] = row[1]
    return rows


class Twins(unittest.TestCase):
    def check(self, wanted, rows):
        self.assertEqual(sorted(wanted - set(rows)), [], "docs/python.md does not name these")
        self.assertEqual(sorted(set(rows) - wanted), [], "docs/python.md names what there is not")
        for name, twin in rows.items():
            twins = re.findall(r"`([A-Za-z_.]+)`", twin)
            self.assertTrue(twins or twin.startswith("none: "), name)
            for path in twins:
                functools.reduce(getattr, path.split("."), balance_mechanisms)

    def test_of_commands(self):
        shown = run("--help").stdout
        commands = set(re.findall(r"^  ([a-z]+) {2,}", shown, re.M))
        self.assertGreater(len(commands), 10)
        self.check(commands, table("Commands"))

    def test_of_functions(self):
        functions = public_functions()
        self.assertGreater(len(functions), 60)
        self.check(functions, table("Functions of the library"))


if __name__ == "__main__":
    unittest.main()

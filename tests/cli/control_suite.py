#!/usr/bin/env python3
"""The table of docs/control.md is what the suite gives."""

import importlib.machinery
import importlib.util
import json
import os
import pathlib
import re
import unittest

import yaml

from _program import CONFIGS, Case, run
from _sampling import draw

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def load(path):
    loader = importlib.machinery.SourceFileLoader("control_table", str(path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def traits(row):
    """Which mechanism, how fast, and what is done to it."""
    return {row["name"].split("-")[0], row.get("trajectory", ""), *(key for key in ("design", "set") if key in row)}


class Table(Case):
    def part_of_the_suite(self):
        """Some of its mechanisms with all their controllers. The path, and their names."""
        with open(os.path.join(CONFIGS, "suites", "control.yaml"), encoding="utf-8") as file:
            suite = yaml.safe_load(file)
        suite["matrix"] = draw("mechanisms under control", suite["matrix"], 0.2, traits)
        for row in suite["matrix"]:
            row["spec"] = os.path.join(CONFIGS, "suites", row["spec"])
        return self.write("control.yaml", yaml.safe_dump(suite)), {row["name"] for row in suite["matrix"]}

    def test_every_figure_of_the_page_comes_from_the_suite(self):
        suite, names = self.part_of_the_suite()
        done = run("batch", suite, "-o", self.path("out"))
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = json.loads(pathlib.Path(self.path("out/summary.json")).read_text(encoding="utf-8"))
        control_table = load(ROOT / "scripts" / "control-table")
        page = (ROOT / "docs" / "control.md").read_text(encoding="utf-8")
        printed = page.split(control_table.BEGIN)[1].split(control_table.END)[0].strip().splitlines()
        heads, rows = printed[:2], printed[2:]
        self.assertLessEqual(names, {cells(row)[0] for row in rows})
        printed = heads + [row for row in rows if cells(row)[0] in names]
        computed = control_table.table(summary).splitlines()
        self.assertEqual(len(printed), len(computed))
        for old, new in zip(printed, computed):
            old_cells, new_cells = cells(old), cells(new)
            self.assertEqual(old_cells[:2], new_cells[:2])
            for a, b in zip(old_cells[2:], new_cells[2:]):
                number = r"\d[\d.]*(?:e[-+]?\d+)?"
                for x, y in zip(re.findall(number, a), re.findall(number, b)):
                    # three digits are printed; another compiler may round the last one the other way
                    self.assertAlmostEqual(float(x), float(y), delta=0.011 * float(y) + 1e-9, msg=f"{old}\n{new}")


if __name__ == "__main__":
    unittest.main()

"""Whether a design exists: the file that `balance design -o` writes is a spec, and its runs have the figures that were claimed."""

import json
import os
import re

from _program import run

# A figure goes through the text of the spec, whose numbers read back to the last digit, and through sums in another order.
RELATIVE = 1e-9
# What balances is a sum that cancels; the search's own figures stand for it to so much of the figure before.
CANCELLED = 1e-9
FIGURE = re.compile(r"(peak|rms|mean|range)\(([^()]*)\) along (\S+)$")


def differs(a, b, size):
    if a is None or b is None:
        return a is not b
    return abs(a - b) > RELATIVE * max(abs(a), abs(b)) + CANCELLED * abs(size)


def metrics_of(run_json):
    return {m["quantity"]: m for m in run_json["metrics"]}


def compare_run(name, claimed, before, found, complaints):
    """A trajectory's figures in the answer, and those that `simulate` finds."""
    there, was = metrics_of(found), metrics_of(before)
    for quantity, metric in metrics_of(claimed).items():
        for figure in ("peak", "rms", "mean", "range"):
            size = (was.get(quantity) or {}).get(figure) or 0
            if differs(metric[figure], there[quantity][figure], size):
                complaints.append(f"{name}: {figure} of {quantity}: {metric[figure]} claimed, {there[quantity][figure]} found")
    return there


def design(spec, output, *options):
    """The answer, and what is wrong with it; nothing of a spec that has no design at all (exit code 4)."""
    done = run("design", spec, "--json", "-o", output, "--force", *options)
    if done.returncode == 4:
        return None, ([] if not os.path.exists(output) else ["refused, and written"])
    if done.returncode not in (0, 1):
        return None, [f"exit code {done.returncode}: {done.stderr.strip()}"]
    return json.loads(done.stdout), []


def complaints_about(spec, output, *options):
    answer, complaints = design(spec, output, *options)
    if answer is None:
        return complaints
    check = run("check", output)
    if check.returncode != 0:
        return complaints + [f"check refuses what was written: {check.stderr.strip()}"]
    if "trajectories" not in answer:  # a front tells figures of its points only
        return complaints
    figures = {}
    for trajectory in answer["trajectories"]:
        name, claimed = trajectory["trajectory"], trajectory["after"]
        if claimed["outcome"]["status"] != "done":
            continue
        ran = run("simulate", output, "--trajectory", name, "--json")
        if ran.returncode != 0:
            complaints.append(f"{name}: cannot be run: {ran.stderr.strip()}")
            continue
        figures[name] = compare_run(name, claimed, trajectory["before"], json.loads(ran.stdout), complaints)
    found = FIGURE.match(answer["objective"]["name"] or "")
    if found and found[3] in figures and found[2] in figures[found[3]] and "load_cases" not in answer:
        value, there = answer["objective"]["value"], figures[found[3]][found[2]][found[1]]
        if differs(value, there, answer["objective"]["start"] or 0):
            complaints.append(f"{answer['objective']['name']}: {value} claimed, {there} found")
    mass = answer["mass"]
    if answer["objective"]["name"] == "added mass" and differs(answer["objective"]["value"], mass["added"], mass["after"]):
        complaints.append(f"added mass: {answer['objective']['value']} minimized, {mass['added']} weighed")
    return complaints

"""Which part of many cases `scripts/test` tries; `scripts/soak whole` tries all of them.

The sample is drawn with the seed in the environment variable SEED, 1 unless it is set, and is printed. With BALANCE_WHOLE=1 it is the whole."""

import math
import os
import random
import re

WHOLE = os.environ.get("BALANCE_WHOLE") == "1"
SEED = int(os.environ.get("SEED", "1"))

KINDS = re.compile(r"\b(space|type|drive|law|goal): *\[?\"?([a-z0-9-]+)")
WORDS = re.compile(r"\b(waypoints|circle|arc|table|file|free|free_length|preload|coulomb|viscous|static)\b")


def traits(text):
    """What kinds of things a spec has: its sections, types of joints, drives, laws, goals, paths and forces, and whether there are loops."""
    text = re.sub(r"#.*", "", text)
    sections = set(re.findall(r"^(\w+):", text, re.MULTILINE))
    mechanism = text.split("\nmotion:", maxsplit=1)[0]
    loops = "closed" if mechanism.count("connects:") > mechanism.count("com:") else "open"
    return sections | {loops} | {f"{key}: {value}" for key, value in KINDS.findall(text)} | set(WORDS.findall(text))


def traits_of(path):
    with open(path, encoding="utf-8") as file:
        return traits(file.read())


def draw(what, cases, share, traits_of_case=lambda case: ()):
    """The whole, or a sample of at least this share of the cases, in their order. Every trait of any case is one of a drawn case.
    @param what names the cases in what is printed; samples of other names are drawn independently"""
    cases = list(cases)
    if WHOLE:
        return cases
    order = list(range(len(cases)))
    random.Random(f"{SEED} {what}").shuffle(order)
    having = [set(traits_of_case(case)) for case in cases]
    missing, drawn = set().union(*having), []
    while missing:
        drawn.append(max(order, key=lambda i: len(having[i] & missing)))
        missing -= having[drawn[-1]]
    rest = [i for i in order if i not in drawn]
    drawn += rest[:max(0, math.ceil(share * len(cases)) - len(drawn))]
    print(f"{what}: {len(drawn)} of {len(cases)}, drawn with SEED={SEED}; BALANCE_WHOLE=1 tries all", flush=True)
    return [cases[i] for i in sorted(drawn)]

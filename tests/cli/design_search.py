"""`balance design` on seeded problems: more work is never worse, seeds agree or the answer says that they may not, bounds hold for all."""

import json
import unittest

from _program import Case, run
from _sampling import WHOLE, draw
from _search_problems import problem

BUDGETS = (1, 2, 4, 8, 16, 32)
SEEDS = range(1, 6)
# 30 and 20 problems in the whole; those drawn by default are known to take little time
QUICK = (0, 1, 3, 6, 12, 14, 15, 17, 18, 23, 29)
# the seconds only keep the whole from lasting for hours
SECONDS = "10"
# exact designs are repaired, and conditions and limits met, to about 1e-9
ROUNDING = 1e-9
# what the program calls the same end, and how well seeds that claim it must agree
AGREEMENT = 1e-5
# bounds are proved in floating point
PROOF = 1e-7


class Answer:
    def __init__(self, done):
        self.code = done.returncode
        # 4: there was no design before the budget was used up
        self.found = self.code in (0, 1)
        if not self.found:
            return
        answer = json.loads(done.stdout)
        self.status, self.optimality = answer["status"], answer["optimality"]
        self.value, self.bound = answer["objective"]["value"], answer["objective"]["lower_bound"]
        # such a compromise is not chosen by the objective
        self.is_by_residual = any("squared residuals" in note for note in answer["notes"])
        self.is_balanced = self.status in ("balanced", "not-asked")
        self.misses = max([0] + [c["violation"] for c in answer["constraints"] if not c["kept"]])
        self.is_proved = self.optimality == "proved-best"
        self.is_proved_impossible = self.status == "impossible" and bool(answer["proved"])
        self.chosen = None
        if answer["chosen"]:
            self.chosen = sum(len(choice["kept"]) for choice in answer["chosen"]["choices"])
        search = answer["search"]
        self.says_starts_agree = search["ended_by"] == "starts-agree"
        self.ended_by = search["ended_by"]

    @property
    def rank(self):
        """Better is less: balanced before limits kept, then how many elements are used."""
        return (not self.is_balanced, self.misses > 0, self.chosen or 0)

    def __str__(self):
        if not self.found:
            return f"exit code {self.code}"
        return f"{self.status}, {self.optimality}, {self.value!r} >= {self.bound}, limits missed by {self.misses:.3g}, ended by {self.ended_by}"


def solve(spec, *options):
    return Answer(run("design", spec, "--json", *options))


def exceeds(one, other, relative):
    return one - other > relative * max(abs(one), abs(other), 1e-6)


def is_worse(more, less):
    """Whether the first answer is a worse one than the second to the same problem."""
    if not less.found or not more.found:
        return less.found and not more.found
    if more.rank != less.rank:
        return more.rank > less.rank
    if more.is_by_residual or less.is_by_residual:
        return False
    if more.misses > 0:
        return exceeds(more.misses, less.misses, 1e-6)
    return exceeds(more.value, less.value, ROUNDING)


def complaints_about_work(answers, *, timed=False):
    """Of answers with more and more work.

    @param timed whether seconds are the budget; otherwise what they cut short is not compared: they are not the same work twice
    """
    found = []
    if not timed:
        answers = [(n, answer) for n, answer in answers if answer.found and answer.ended_by != "time"]
    for (k, less), (n, more) in zip(answers, answers[1:]):
        if is_worse(more, less):
            found.append(f"worse with {n} than with {k}: {more}; {less}")
        elif less.found and less.is_proved and not more.is_proved and more.rank == less.rank:
            found.append(f"proved with {k}, not with {n}: {more}; {less}")
    return found


def complaints_about_bounds(answers):
    """Of any answers to one problem."""
    found = []
    designs = [(name, answer) for name, answer in answers if answer.found and answer.misses == 0]
    for k, one in designs:
        for n, other in designs:
            if one.is_proved_impossible and other.is_balanced:
                found.append(f"impossible with {k}, not with {n}: {one}; {other}")
            if one.rank != other.rank:
                continue
            if one.bound is not None and exceeds(one.bound, other.value, PROOF):
                found.append(f"the bound with {k} is above the value with {n}: {one}; {other}")
            if one.is_proved and exceeds(one.value, other.value, PROOF):
                found.append(f"proved-best with {k}, better with {n}: {one}; {other}")
    return found


def complaints_about_seeds(answers):
    """Who claims that starts agree, or a proof, is not beaten by another seed."""
    found = []
    for k, one in answers:
        for n, other in answers:
            if not one.found or not (one.says_starts_agree or one.is_proved):
                continue
            if other.found and is_worse(one, other) and (one.rank != other.rank or exceeds(one.value, other.value, AGREEMENT)):
                found.append(f"seed {k} claims that its starts agree or a proof, seed {n} is better: {one}; {other}")
    return found


def sample(what, count, share):
    """Problems of the whole, or of those that are quick."""
    seeds = range(count) if WHOLE else [s for s in QUICK if s < count]
    return draw(what, seeds, share)


class Search(Case):
    def complain(self, law, seed, found):
        self.assertFalse(found, f"{law}: problem {seed}\n" + "\n".join(found) + "\n" + problem(seed))

    def test_more_work_is_never_worse(self):
        for seed in sample("problems with more and more starts", 30, 0.4):
            with self.subTest(problem=seed):
                spec = self.write(f"{seed}.yaml", problem(seed))
                answers = [(n, solve(spec, "--starts", str(n), "--seconds", SECONDS)) for n in BUDGETS]
                self.complain("work", seed, complaints_about_work(answers) + complaints_about_bounds(answers))

    def test_seeds_agree_or_the_answer_says_that_they_may_not(self):
        for seed in sample("problems with five seeds", 20, 0.4):
            with self.subTest(problem=seed):
                spec = self.write(f"{seed}.yaml", problem(seed))
                answers = [(n, solve(spec, "--seed", str(n), "--seconds", SECONDS)) for n in SEEDS]
                self.complain("seeds", seed, complaints_about_seeds(answers) + complaints_about_bounds(answers))


if __name__ == "__main__":
    unittest.main()

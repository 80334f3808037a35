"""Mutants of the shipped specs through every command: documented exit codes, a place for every mistake, nothing half written."""

import unittest

import _mutants
from _sampling import draw

SEEDS = range(1, 301)


class Mutants(unittest.TestCase):
    def test_every_mutant_ends_as_documented(self):
        failed, codes = _mutants.run_many(draw("mutants", SEEDS, 0.3), told=lambda text: None)
        self.assertEqual([], [_mutants.describe(*one) for one in failed])
        self.assertGreaterEqual(len({command for command, _ in codes}), 10)

    def test_the_same_seed_is_the_same_mutant(self):
        texts = _mutants.sources()
        for seed in SEEDS[:10]:
            self.assertEqual(_mutants.make_trial(seed, texts), _mutants.make_trial(seed, texts))


if __name__ == "__main__":
    unittest.main()

"""Formulas and programs of random mechanisms say what the engine says, whatever numbers are zero, free or parameters."""

import unittest

from _random_equations import fault


class Random(unittest.TestCase):
    def test_a_sample_of_random_mechanisms(self):
        """The whole is `scripts/soak equations`."""
        for seed in range(1, 9):
            with self.subTest(seed=seed):
                self.assertIsNone(fault(seed))


if __name__ == "__main__":
    unittest.main()

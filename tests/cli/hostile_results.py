"""Result files and tables that were made to do harm, under an intact checksum: a message, in little time and memory, or an honest answer."""

import itertools
import os
import random
import shutil
import unittest

import h5py
import numpy

import _hostile
from _program import CONFIGS, PROGRAM, SLOWNESS, SPEC, Case, run
from _sampling import WHOLE, draw


class HostileResults(Case):
    def setUp(self):
        super().setUp()
        self.good = self.path("good.h5")
        self.assert_quiet_success(run("simulate", SPEC, "-t", "cycloid", "--samples", "21", "-o", self.good))
        self.bad = self.path("bad.h5")

    def changed(self, change, *arguments):
        """A copy with an intact checksum, changed by h5py."""
        shutil.copy(self.good, self.bad)
        with h5py.File(self.bad, "r+") as file:
            change(file, *arguments)
        _hostile.add_checksum(self.bad)

    def commands(self):
        out = self.path("out")
        return (["compare", self.bad, self.good], ["compare", self.good, self.bad], ["plot", self.bad, "--force", "-o", out + ".svg"],
                ["report", self.bad, "--force", "-o", out + ".html"])

    def assert_harmless(self, what, commands=None):
        """No crash, nothing inside that fails, little time and memory. The exit codes."""
        codes = []
        for command in commands or self.commands():
            code, said, seconds, mebibytes = _hostile.run_limited([PROGRAM, *command])
            where = f"{what}: {command[0]}: {said}"
            self.assertIn(code, (0, 1, 2, 3, 4, 5), where)
            self.assertNotIn("internal error", said, where)
            self.assertLess(seconds, 10 * SLOWNESS, where)
            self.assertLess(mebibytes, 512, where)
            codes.append(code)
        return codes

    def test_bytes_spoilt_under_an_intact_checksum_do_no_harm(self):  # (C2)
        with open(self.good, "rb") as file:
            content = file.read()[:-_hostile.CHECKSUM]
        refused = 0
        for seed in draw("seeds of spoilt bytes", range(40), 0.25, lambda seed: {seed % 4}):
            with open(self.bad, "wb") as file:
                file.write(_hostile.checked(_hostile.spoil_bytes(content, random.Random(seed))))
            commands = self.commands()
            refused += self.assert_harmless(f"seed {seed}", [commands[seed % 4]])[0] == 5
        self.assertGreater(refused, 5 if WHOLE else 0)

    def test_files_with_a_checksum_that_crashed_the_library_do_no_harm(self):  # (C2)
        """Lengths, addresses and kinds of messages in the library's own tables, each changed alone."""
        with open(self.good, "rb") as file:
            content = file.read()[:-_hostile.CHECKSUM]
        heads = [i for i in range(len(content)) if content[i:i + 4] in (b"OHDR", b"OCHK", b"FRHP", b"BTHD", b"TREE", b"HEAP", b"GCOL")]
        self.assertTrue(heads)
        dice = random.Random(7)
        for at in draw("spoilt headers", dice.sample(heads, min(len(heads), 12)), 0.3):
            spoilt = bytearray(content)
            for _ in range(3):
                spoilt[at + dice.randrange(4, 40)] = dice.choice([0, 0x7F, 0xFF, dice.randrange(256)])
            with open(self.bad, "wb") as file:
                file.write(_hostile.checked(bytes(spoilt)))
            self.assert_harmless(f"header at {at}", [self.commands()[at % 4]])

    def test_structures_that_no_honest_writer_has_do_no_harm(self):  # (C2)
        made = None
        for (i, change), command in draw("structures", itertools.product(enumerate(_hostile.STRUCTURES), (1, 2, 3)), 0.3,
                                         lambda case: {case[0][1].__name__, case[1]}):
            if made != i:
                self.changed(change, random.Random(i))
            made = i
            self.assert_harmless(change.__name__, [self.commands()[command]])

    def test_values_in_other_files_are_not_followed(self):  # (C9)
        secret = self.path("secret.h5")
        shutil.copy(self.good, secret)

        def link(file):
            del file["torque"]
            file["torque"] = h5py.ExternalLink(secret, "/torque")

        def soft_way(file):
            del file["torque"]
            file["aside"] = h5py.ExternalLink(secret, "/")
            file["torque"] = h5py.SoftLink("/aside/torque")

        def storage(file):
            shape = file["torque"].shape
            _hostile.replace(file, "torque", shape=shape, dtype="f8", external=[(secret, 0, h5py.h5f.UNLIMITED)])

        def virtual(file):
            layout = h5py.VirtualLayout(shape=file["torque"].shape, dtype="f8")
            layout[...] = h5py.VirtualSource(secret, "torque", shape=file["torque"].shape)
            del file["torque"]
            file.create_virtual_dataset("torque", layout)

        for change in (link, soft_way, storage, virtual):
            self.changed(change)
            for command in self.commands():
                done = run(*command)
                self.assert_failure(done, 5, f"error: {self.bad}: ", "'torque'")
            if change != soft_way:
                self.assertIn("'torque': is stored in another file, which is not read", done.stderr)

    def test_tables_in_other_files_are_not_followed(self):  # (C9)
        with open(os.path.join(CONFIGS, "rr.yaml"), encoding="utf-8") as spec:
            text = spec.read()
        names = ["R1", "R2"]
        text = text.replace("trajectories:\n", "trajectories:\n  table: {drive: joints, path: {file: table.h5}}\n")
        spec = self.write("s.yaml", text)
        for follow in (False, True):
            with h5py.File(self.path("table.h5"), "w") as file, h5py.File(self.path("other.h5"), "w") as other:
                (other if follow else file)["time"] = numpy.linspace(0, 1, 9)
                if follow:
                    file["time"] = h5py.ExternalLink("other.h5", "/time")
                for name in names:
                    file[name] = numpy.linspace(0, 0.1, 9)
            done = run("simulate", spec, "-t", "table")
            if follow:
                self.assert_failure(done, 3, "'time': is stored in another file, which is not read")
            else:
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_hundred_thousand_metrics_are_compared_in_little_time(self):  # (C10)
        def grow(file):
            count = 100_000
            for name in ("quantity", "unit"):
                labels = [f"torque[{i}]" if name == "quantity" else "N" for i in range(count)]
                _hostile.replace(file, "metrics/" + name, data=numpy.array(labels, dtype=object), dtype=_hostile.TEXT)
            for name in ("peak", "peak_time", "rms", "mean", "range", "round_off"):
                _hostile.replace(file, "metrics/" + name, data=numpy.ones(count) * (name != "round_off"))

        self.changed(grow)
        commands = [["compare", self.bad, self.bad], ["compare", self.good, self.bad], ["compare", self.bad, self.bad, "--format", "json"]]
        for command in draw("comparisons of very many metrics", commands, 0.3):
            self.assertEqual(self.assert_harmless("metrics", [command]), [0])

    def test_a_million_samples_in_a_small_file_are_refused_with_the_reason(self):  # (C10)
        def grow(file):
            for name in [name for name, item in file.items() if isinstance(item, h5py.Dataset) and item.shape[:1] == (21,)]:
                rows = (1_000_000,) + file[name].shape[1:]
                if name == "time":
                    _hostile.replace(file, name, data=numpy.arange(rows[0]), compression="gzip")
                else:
                    _hostile.replace(file, name, shape=rows, dtype="f8", chunks=True)

        self.changed(grow)
        self.assertEqual(self.assert_harmless("samples"), [5, 5, 5, 5])
        self.assert_failure(run("report", self.bad, "-o", self.path("p.html")), 5, "too many numbers for a file of this size")

    def test_more_curves_than_a_picture_holds_are_refused(self):  # (C10)
        class Most(random.Random):
            def choice(self, seq):
                return max(seq)

        self.changed(_hostile.many_joints, Most())
        done = run("plot", self.bad, "-o", self.path("p.svg"))
        self.assert_failure(done, 2, "more than 300 curves", "name one, such as torque[j0]")

    def test_what_is_no_file_is_not_waited_for(self):  # (C2)
        os.mkfifo(self.path("pipe.h5"))
        self.assert_failure(run("compare", self.path("pipe.h5"), self.good), 5, "is not a regular file")


if __name__ == "__main__":
    unittest.main()

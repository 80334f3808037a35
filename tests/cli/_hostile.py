"""Result files as a stranger would make them to do harm: bytes changed, or structures that no honest writer has, under an intact checksum."""

import os
import struct
import subprocess
import zlib

import h5py
import numpy

CHECKSUM = 16  # bytes behind the last one of HDF5


def checked(content):
    return content + f"balance:{zlib.crc32(content):08x}".encode()


def add_checksum(path):
    """Adds a checksum to what h5py has changed; whatever stood behind the end of HDF5 is gone."""
    with open(path, "rb") as file:
        content = file.read()
    if content[-CHECKSUM:].startswith(b"balance:"):
        content = content[:-CHECKSUM]
    with open(path, "wb") as file:
        file.write(checked(content))


def spoil_bytes(content, random):
    """Some bytes of a file without checksum changed: bits, bytes, numbers that sizes and addresses are likely to be; cut, moved, repeated."""
    spoilt = bytearray(content)
    # What steers the library stands between the numbers and before them.
    places = [i for i in range(0, len(content) - 8, 8) if any(content[i:i + 8])]
    for _ in range(random.choice([1, 1, 2, 3, 5, 10, 30])):
        at = random.choice([random.randrange(min(2048, len(spoilt))), random.randrange(len(spoilt)),
                            random.choice(places) + random.randrange(8)]) % max(len(spoilt) - 8, 1)
        kind = random.randrange(8)
        if kind == 0:
            spoilt[at] ^= 1 << random.randrange(8)
        elif kind <= 2:
            spoilt[at] = random.choice([0, 1, 2, 3, 7, 8, 15, 16, 127, 128, 254, 255, random.randrange(256)])
        elif kind == 3:
            spoilt[at:at + 4] = struct.pack("<I", random.choice([0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 1 << 20, 1 << 30]))
        elif kind == 4:
            spoilt[at:at + 8] = struct.pack("<Q", random.choice([0, 1, 1 << 20, 1 << 32, 1 << 40, (1 << 63) - 1, (1 << 64) - 1,
                                                                random.randrange(len(spoilt))]))
        elif kind == 5:
            other, count = random.randrange(len(spoilt)), random.choice([8, 16, 64, 512])
            spoilt[at:at + count] = spoilt[other:other + count]
        elif kind == 6:
            spoilt[at:at + 8] = struct.pack("<d", random.choice([numpy.nan, numpy.inf, -numpy.inf, 1e308, -1e308, 5e-324]))
        elif random.random() < 0.2:
            del spoilt[at + 1:]
        if len(spoilt) < 64:
            break
    return bytes(spoilt)


def replace(file, name, **how):
    """A dataset with the same attributes in the place of another one."""
    attributes = {key: value for key, value in file[name].attrs.items() if key in ("units", "long_name", "about")}
    del file[name]
    made = file.create_dataset(name, **how)
    for key, value in attributes.items():
        made.attrs[key] = value
    return made


TEXT = h5py.string_dtype()
SAMPLED = ["joint_position", "torque", "shaking_force", "shaking_moment", "joint_force", "kinetic_energy", "time"]


def huge_sizes(file, random):
    for name in random.sample(SAMPLED, 2):
        replace(file, name, shape=tuple(random.choice([1 << 20, 1 << 31, 1 << 40]) for _ in file[name].shape), dtype="f8",
                chunks=tuple(1 for _ in file[name].shape))


def many_samples(file, random):
    """Every array grows, though not the file: nothing of them is stored."""
    rows = random.choice([10_000, 300_000, 1_000_000, 3_000_000])
    packed = {"chunks": True, "compression": "gzip", "compression_opts": 9} if random.random() < 0.5 else {"chunks": True}
    for name in [name for name, item in file.items() if isinstance(item, h5py.Dataset) and item.shape[:1] == file["time"].shape]:
        shape = (rows,) + file[name].shape[1:]
        if name == "time" and rows < 2_000_000:
            replace(file, name, data=numpy.arange(rows))
        else:
            replace(file, name, shape=shape, dtype="f8", **packed)


def big_chunks(file, random):
    name = random.choice(SAMPLED)
    shape = file[name].shape
    replace(file, name, shape=shape, maxshape=tuple(None for _ in shape), dtype="f8", compression="gzip",
            chunks=(random.choice([1 << 16, 1 << 21, 1 << 24]),) + tuple(max(1, n) for n in shape[1:]))
    file[name][0] = 1


def bomb(file, random):
    chunk = (1 << 17,) + file["shaking_force"].shape[1:]
    shape = (random.choice([8, 64, 512]) * chunk[0],) + chunk[1:]
    made = replace(file, "shaking_force", shape=shape, dtype="f8", chunks=chunk, compression="gzip")
    packed = zlib.compress(bytes(8 * int(numpy.prod(chunk))), 9)
    for start in range(0, shape[0], chunk[0]):
        made.id.write_direct_chunk((start,) + (0,) * (len(chunk) - 1), packed)


def deep_groups(file, random):
    group, parent = file, random.choice(["before", "after", "x"])
    group = file.require_group(parent)
    for _ in range(random.choice([100, 3000])):
        group = group.create_group("g")


def many_groups(file, random):
    for when in ("before", "after"):
        group = file.require_group(when)
        for i in range(random.choice([10, 5000])):
            group.create_group(f"g{i}")
    if random.random() < 0.7:
        del file["time"]


def circles(file, random):
    file["after"] = file["/"]
    file["before"] = h5py.SoftLink("/before")
    name = random.choice(SAMPLED)
    del file[name]
    file[name] = h5py.SoftLink(random.choice(["/" + name, "/after/" + name, "/after/after/after", "/none"]))


def elsewhere(file, random):
    name = random.choice(SAMPLED)
    shape, kind = file[name].shape, random.randrange(3)
    if kind == 0:
        del file[name]
        file[name] = h5py.ExternalLink(file.filename if random.random() < 0.5 else "/dev/zero", "/torque")
    elif kind == 1:
        replace(file, name, shape=shape, dtype="f8", external=[("/dev/zero", 0, h5py.h5f.UNLIMITED)])
    else:
        layout = h5py.VirtualLayout(shape=shape, dtype="f8")
        layout[...] = h5py.VirtualSource(random.choice([file.filename, "."]), name, shape=shape)
        del file[name]
        file.create_virtual_dataset(name, layout)


def wrong_types(file, random):
    for _ in range(random.choice([1, 3])):
        name = random.choice(SAMPLED + ["coordinate", "joint", "axis", "metrics/quantity", "metrics/peak", "newton_iterations"])
        rows = min(len(file[name]), 100) if file[name].shape else 1
        data = random.choice([numpy.arange(rows), numpy.arange(rows, dtype="c16"), numpy.arange(rows, dtype="f2"), [b"text"] * rows,
                              numpy.zeros(rows, dtype=[("a", "f8"), ("b", "i4")]), numpy.zeros(rows, dtype=bool),
                              numpy.zeros((rows, 2, 2, 2, 2)), numpy.float64(1), numpy.zeros(0), numpy.zeros((0, 3))])
        replace(file, name, data=data)
    if random.random() < 0.3:
        del file["joint_position"]
        file.create_dataset("joint_position", (3,), dtype=h5py.vlen_dtype("f8"))


def odd_numbers(file, random):
    name = random.choice(SAMPLED + ["newton_iterations", "metrics/peak", "metrics/energy"])
    values = numpy.asarray(file[name][()], dtype="f8")
    odd = random.choice([numpy.nan, numpy.inf, -numpy.inf, 1e308, -1e308, 5e-324, 0.0, 1e18])
    values = numpy.where(numpy.asarray([random.random() < random.choice([0.02, 1]) for _ in range(values.size)]).reshape(values.shape),
                         odd, values)
    replace(file, name, data=numpy.sort(values) if name == "time" and random.random() < 0.7 else values)


def odd_names(file, random):
    name = random.choice(["coordinate", "joint", "actuator", "axis", "metrics/quantity", "metrics/unit"])
    count = len(file[name])
    odd = random.choice(["", "\x1b]0;x\x07", "\u202eabc", "a'b\"`c`", "$(id)", "a\nb", "%s%n", "=1+1", "x" * 5000, "x" * 4000, "@", "\\",
                         "<script>", "]", "[", "torque[A1]", b"\xff\xfe".decode("utf-8", "surrogateescape")])
    data = [odd.encode("utf-8", "surrogateescape") if random.random() < 0.7 else b"A1" for _ in range(count)]
    replace(file, name, data=numpy.array(data, dtype=object), dtype=TEXT)


def many_metrics(file, random):
    count = random.choice([1000, 100_000, 300_000])
    for name in ("quantity", "unit"):
        labels = [f"{random.choice(['torque', 'joint_force', 'q'])}[{i}]" if name == "quantity" else "N" for i in range(count)]
        replace(file, "metrics/" + name, data=numpy.array(labels, dtype=object), dtype=TEXT)
    for name in ("peak", "peak_time", "rms", "mean", "range"):
        replace(file, "metrics/" + name, data=numpy.ones(count))


def many_joints(file, random):
    """Few samples of a mechanism that has everything in plenty."""
    count, rows, axes = random.choice([300, 5_000, 50_000]), 4, len(file["axis"])
    labels = numpy.array([f"j{i}" for i in range(count)], dtype=object)
    for name in ("coordinate", "joint", "actuator"):
        replace(file, name, data=labels, dtype=TEXT)
    for name, item in list(file.items()):
        if not isinstance(item, h5py.Dataset) or name in ("coordinate", "joint", "actuator", "axis"):
            continue
        of = item.shape[1:]
        wide = name.startswith("joint") or name in ("torque", "power")
        shape = (rows,) + ((count,) + of[1:] if wide else of)
        if name == "time":
            replace(file, name, data=numpy.linspace(0, 1, rows))
        else:
            replace(file, name, data=numpy.full(shape, 0.5))
    assert axes in (2, 3)


def odd_attributes(file, random):
    name = random.choice(["spec", "title", "Conventions", "trajectory", "command_line", "law", "drive", "controller"])
    file.attrs[name] = random.choice(["", "x" * 1_000_000, "\x1b[31m", "a\nb", 3, numpy.zeros(5), "name: x\n", "[" * 3000,
                                      "&a [*a, *a]", "balance simulate --set " + "x=1 " * 1000])
    if random.random() < 0.3:
        file["shaking_moment"].attrs["about"] = random.choice([numpy.zeros(0), numpy.zeros(999), numpy.full(2, numpy.nan), "text"])


def other_spec(file, random):
    """The samples of one mechanism and the spec of another."""
    configs = os.environ["CONFIGS"]
    name = random.choice(sorted(entry for entry in os.listdir(configs) if entry.endswith(".yaml")))
    with open(os.path.join(configs, name), encoding="utf-8") as spec:
        file.attrs["spec"] = spec.read()


STRUCTURES = [huge_sizes, many_samples, big_chunks, bomb, deep_groups, many_groups, circles, elsewhere, wrong_types, odd_numbers,
              odd_names, many_metrics, many_joints, odd_attributes, other_spec]


def run_limited(arguments, seconds=60):
    """Exit code (None: took too long), what stderr says, seconds of the processor and MiB of the largest process. A run's children count."""
    with subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        killer = subprocess.Popen(["sh", "-c", f"sleep {seconds}; kill -9 {process.pid}"], start_new_session=True)
        said = process.stderr.read().decode("utf-8", "replace")
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        os.killpg(killer.pid, 9)
        killer.wait()
    return process.returncode, said, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024

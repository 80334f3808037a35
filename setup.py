"""Lets CMake build the compiled part of the Python module for pip: without tests and without the program, in a folder
of build that the next installation uses again. CMAKE_ARGS in the environment has further options for CMake."""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent
# As deep as build/release: the compiler's cache then knows what that has compiled.
BUILD = ROOT / "build" / f"pip-{sys.implementation.cache_tag}"
OPTIONS = {"CMAKE_BUILD_TYPE": "Release", "BALANCE_UNITY": "ON", "BALANCE_TESTS": "OFF", "BALANCE_PAGE": "OFF", "BALANCE_PYTHON_MODULE": "REQUIRED",
           "BALANCE_PYTHON_DIR": "module", "Python_EXECUTABLE": sys.executable}


def version():
    """The project's, which CMakeLists.txt has."""
    return re.search(r"^  VERSION (\S+)$", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.MULTILINE).group(1)


class BuildWithCMake(build_ext):
    def build_extension(self, extension):
        if not shutil.which("cmake"):
            sys.exit("error: CMake compiles balance_mechanisms; scripts/setup python installs it, and the libraries, on Debian")
        generator = ["-G", "Ninja"] if shutil.which("ninja") and "CMAKE_GENERATOR" not in os.environ else []
        options = [f"-D{name}={value}" for name, value in OPTIONS.items()]
        place = BUILD / "installed"
        shutil.rmtree(place, ignore_errors=True)
        for command in (["cmake", "-S", ROOT, "-B", BUILD, *generator, *options, *shlex.split(os.environ.get("CMAKE_ARGS", ""))],
                        ["cmake", "--build", BUILD, "--target", "balance_python", "--parallel", str(os.cpu_count() or 1)],
                        ["cmake", "--install", BUILD, "--component", "python", "--strip", "--prefix", place]):
            if subprocess.run(command, check=False).returncode != 0:
                sys.exit(f"error: {shlex.join(map(str, command))} failed; scripts/setup python installs what it needs on Debian")
        target = pathlib.Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        (compiled,) = (place / "module/balance_mechanisms").glob("_native*.so")
        shutil.copy2(compiled, target)


# setuptools keeps nothing beside the sources, and no module of an earlier version.
PACKAGE = BUILD / "package"
shutil.rmtree(PACKAGE, ignore_errors=True)
PACKAGE.mkdir(parents=True)

setup(version=version(), ext_modules=[Extension("balance_mechanisms._native", sources=[])], cmdclass={"build_ext": BuildWithCMake},
      options={"build": {"build_base": str(PACKAGE)}, "egg_info": {"egg_base": str(PACKAGE)}, "bdist_wheel": {"bdist_dir": str(PACKAGE / "wheel")}})

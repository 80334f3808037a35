#!/usr/bin/env bash
# The demo installs what the program needs and nothing that only tests need (D10). Nothing is installed here: what would be asked for is.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
printf '#!/bin/sh\nexit 1\n' >"$folder/dpkg-query"
printf '#!/bin/sh\necho 0\n' >"$folder/id"
printf '#!/bin/sh\necho "$@"\n' >"$folder/apt-get"
chmod +x "$folder"/*

wanted() { PATH=$folder:$PATH "$root/scripts/setup" "$@" | sed -n 's/^install .*--no-install-recommends//p'; }
program=" $(wanted program) "
module=" $(wanted python) "
everything=" $(wanted) "
for package in g++ cmake libhdf5-dev libeigen3-dev libnlopt-dev libboost-dev coinor-libclp-dev; do
  [[ $program == *" $package "* ]] || { echo "the program is built without $package?" >&2; exit 1; }
done
for package in chromium snakemake clang clang-tidy npm nodejs python3 gnuplot-nox lintian; do
  [[ $program != *" $package "* ]] || { echo "the program needs no $package" >&2; exit 1; }
done
for package in $program pybind11-dev python3-dev python3-numpy python3-venv python3-setuptools; do
  [[ $module == *" $package "* ]] || { echo "the Python module is built without $package?" >&2; exit 1; }
done
[[ $module != *" doctest-dev "* ]] || { echo "the Python module needs no tests" >&2; exit 1; }
for package in $program $module chromium snakemake lintian; do
  [[ $everything == *" $package "* ]] || { echo "$package is missing in the whole" >&2; exit 1; }
done
for package in $program libmujoco-dev libdart-dev libsimbody-dev liborocos-kdl-dev; do
  [[ " $(wanted peers) " == *" $package "* ]] || { echo "the comparison with other libraries needs $package" >&2; exit 1; }
done
for package in libmujoco-dev libdart-dev libsimbody-dev liborocos-kdl-dev; do
  [[ $everything != *" $package "* ]] || { echo "$package is asked for by everybody" >&2; exit 1; }
done
grep -q '^scripts/setup program$' "$root/scripts/demo" || { echo "the demo installs more than it needs" >&2; exit 1; }

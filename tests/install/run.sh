#!/usr/bin/env bash
# Installs a build into an empty folder, then builds and runs a project that knows only what is there.
# usage: run.sh <build folder> <cmake>
set -euo pipefail
build=$1
cmake=$2
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$cmake" --install "$build" --prefix "$folder/prefix" >/dev/null
version=$("$folder/prefix/bin/balance" --version)
echo "installed program says: $version"

spec=$folder/prefix/share/balance/configs/3rrr.yaml
"$folder/prefix/bin/balance" check "$spec" >/dev/null

share=$folder/prefix/share
for file in man/man1/balance-simulate.1* bash-completion/completions/balance zsh/vendor-completions/_balance \
  fish/vendor_completions.d/balance.fish; do
  [[ -s $(echo "$share/"$file) ]] || { echo "not installed: $file" >&2; exit 1; }
done

"$cmake" -G Ninja -S "$here" -B "$folder/guest" -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE=Debug >/dev/null
"$cmake" --build "$folder/guest"
said=$("$folder/guest/guest" "$spec")
echo "guest says: $said"
# 869.7 N is the peak that the literature's data give for the cycloidal motion.
[[ $said == *"peak shaking force 869.7"* ]]

"$cmake" -G Ninja -S "$here" -B "$folder/core" -DCORE_ALONE=ON -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE=Debug >/dev/null
"$cmake" --build "$folder/core"
"$folder/core/guest"

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

# Only headers that are meant for users, or that those include.
include=$folder/prefix/include/balance
if find "$include" -path "*/kinematics/*" -o -path "*/lanes/*" | grep .; then
  echo "installed, yet private" >&2
  exit 1
fi

page=$folder/page
mkdir -p "$page/core" "$page/derivatives" "$page/synthesis"
awk -v folder="$page" -f "$here/page_programs.awk" "$(find "$share/doc" -name library.md)"

# Of the programs for the core one is drawn, with the seed SEED, or 1; all are compiled with BALANCE_WHOLE=1.
if [[ ${BALANCE_WHOLE:-} != 1 ]]; then
  programs=("$page"/core/*.cpp)
  drawn=$(($(cksum <<<"${SEED:-1}" | cut -d ' ' -f 1) % ${#programs[@]}))
  echo "page: $(basename "${programs[drawn]}") of ${#programs[@]} for the core, drawn with SEED=${SEED:-1}; BALANCE_WHOLE=1 compiles all"
  unset "programs[drawn]"
  rm "${programs[@]}" "${programs[@]/%.cpp/.txt}"
fi

# Every program of the page prints what the page says.
run_page() { # <part> <build folder>
  local said
  for said in "$page/$1"/*.txt; do
    "$2/page_$(basename "$said" .txt)" | diff "$said" - || { echo "page: $(basename "$said" .txt)" >&2; exit 1; }
  done
}

# Without a build type: with assertions, and without information for a debugger, which takes time and nobody reads.
"$cmake" -G Ninja -S "$here" -B "$folder/guest" -DPAGE="$page" -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE= >/dev/null
"$cmake" --build "$folder/guest"
said=$("$folder/guest/guest" "$spec")
echo "guest says: $said"
# 869.7 N is the peak that the literature's data give for the cycloidal motion.
[[ $said == *"peak shaking force 869.7"* ]]
run_page derivatives "$folder/guest"
run_page synthesis "$folder/guest"

"$cmake" -G Ninja -S "$here" -B "$folder/core" -DPAGE="$page" -DCORE_ALONE=ON -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE= >/dev/null
"$cmake" --build "$folder/core"
"$folder/core/guest"
if grep "BALANCE_" "$folder/core/macros.txt"; then
  echo "macros stay defined" >&2
  exit 1
fi
run_page core "$folder/core"

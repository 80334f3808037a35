#!/usr/bin/env bash
# Installs a build into an empty folder, then builds and runs a project that knows only what is there.
# usage: run.sh <build folder> <cmake>
set -euo pipefail
build=$1
cmake=$2
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
mkdir "$folder/records" # of what is really installed from this build
cp "$build"/install_manifest*.txt "$build"/installed_beside_*.txt "$folder/records" 2>/dev/null || true
trap 'cp "$folder"/records/*.txt "$build" 2>/dev/null || true; rm -rf "$folder"' EXIT

# What somebody else has put below the prefix stays when the build is uninstalled, and nothing else.
mkdir -p "$folder/prefix/share/balance" "$folder/prefix/bin"
touch "$folder/prefix/share/balance/.theirs"
before=$(find "$folder/prefix" | sort)
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

# The Python module is where the interpreter looks below this prefix.
if compgen -G "$build/python/balance_mechanisms/_native*.so" >/dev/null; then
  python=${PYTHON:-/usr/bin/python3}
  modules=$("$python" -c "import sysconfig; print(sysconfig.get_path('platlib', 'posix_prefix', {'platbase': '$folder/prefix'}))")
  PYTHONPATH=$modules "$python" -c "
import balance_mechanisms as bm
assert bm.__file__.startswith('$modules'), bm.__file__
bm.load('$spec').check()"
fi

# Only headers that are meant for users, or that those include.
include=$folder/prefix/include/balance
if find "$include" -path "*/kinematics/*" -o -path "*/lanes/*" | grep .; then
  echo "installed, yet private" >&2
  exit 1
fi

page=$folder/page
mkdir -p "$page/core" "$page/derivatives" "$page/synthesis"
release=${version##* }
grep -q "find_package(balance ${release%.*} " "$(find "$share/doc" -name library.md)" || { echo "library.md names another version" >&2; exit 1; }
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
"$cmake" -G Ninja -S "$here" -B "$folder/guest" -DPAGE="$page" -DWANTED="$release" -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE= >/dev/null
"$cmake" --build "$folder/guest"
said=$("$folder/guest/guest" "$spec")
echo "guest says: $said"
# 869.7 N is the peak that the literature's data give for the cycloidal motion.
[[ $said == *"peak shaking force 869.7"* ]]
run_page derivatives "$folder/guest"
run_page synthesis "$folder/guest"

"$cmake" -G Ninja -S "$here" -B "$folder/core" -DPAGE="$page" -DWANTED="$release" -DCORE_ALONE=ON -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE= >/dev/null
"$cmake" --build "$folder/core"
"$folder/core/guest"
if grep "BALANCE_" "$folder/core/macros.txt"; then
  echo "macros stay defined" >&2
  exit 1
fi
run_page core "$folder/core"

# What the target `uninstall` runs, without asking Ninja whether the build is up to date.
"$cmake" -D BUILD_FOLDER="$build" -P "$here/../../cmake/RemoveInstalled.cmake" >/dev/null
diff <(echo "$before") <(find "$folder/prefix" | sort) || { echo "not as before the installation" >&2; exit 1; }

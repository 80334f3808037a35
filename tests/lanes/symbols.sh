#!/usr/bin/env bash
# An object for an instruction set shows its table alone, and fuses no product with a sum; in a program that holds such objects no
# function that others may have been linked to uses registers that the baseline lacks.
# usage: symbols.sh <program> <object>…
set -euo pipefail
export LC_ALL=C
program=$1
shift
failed=0
complain() { echo "$1" >&2; failed=1; }
[[ $# -gt 0 ]] || { echo "nothing was compiled for other instruction sets than the baseline"; exit 0; }
for object in "$@"; do
  shown=$(nm --extern-only --defined-only "$object")
  [[ $(wc -l <<<"$shown") -eq 1 && $shown =~ \ [DRB]\  ]] || complain "$object shows more than its table: $shown"
  fused=$(objdump -d --no-show-raw-insn "$object" | grep -cE '\bvfn?m(add|sub)' || true)
  [[ $fused -eq 0 ]] || complain "$object holds $fused fused products and sums"
done
# addresses of functions with wide registers, and of what is global or weak
wide=$(objdump -d --no-show-raw-insn "$program" | awk '/^[0-9a-f]+ </ { at = $1 } /%[yz]mm/ { if (at != last) print at; last = at }' | sort -u)
[[ -n $wide ]] || complain "$program holds no code for wide registers"
shared=$(nm --defined-only "$program" | awk '$2 ~ /^[TWVu]$/ { print $1 }' | sort -u)
both=$(comm -12 <(echo "$wide") <(echo "$shared"))
[[ -z $both ]] || complain "$program: shared functions use wide registers, at $both"
exit "$failed"

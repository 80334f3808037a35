#!/usr/bin/env bash
# The program is hardened and loads no library from the current folder (C3, C12).
set -euo pipefail
command -v readelf >/dev/null || { echo "no readelf: run scripts/setup" >&2; exit 1; }
exec "$(dirname "$0")/../../scripts/check_hardening" "$BALANCE"

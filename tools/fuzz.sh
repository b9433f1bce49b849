#!/usr/bin/env bash
# Random sets of hard kinds, each answer proven cell by cell, on all cores until the time is over.
#   ./tools/fuzz.sh HOURS [KIND...] [--device cpu|lavapipe] [--seed N] [--findings FOLDER] [--jobs N]
#   ./tools/fuzz.sh --replay FILE [--device cpu|lavapipe]
# Kinds: wrapped thin skewed clusters weights walls wedges lattices spheres jobs many; default: all.
# Prints how many sets of each kind it tried. What fails, hangs, crashes or takes too much is kept in FOLDER (default
# build/fuzz), reduced, as a text that --replay runs again. Exits 1 when something was found.
set -euo pipefail
cd "$(dirname "$0")/.."

if [[ $# -eq 0 ]]; then
    sed -n '2,7s/^# //p' "$0" >&2
    exit 2
fi
tools/setup.sh run test
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { cmake --preset release -DVOTESS_BUILD_TESTS=ON &&
       cmake --build --preset release --parallel "$(nproc)" --target votess_fuzz; } >"$log" 2>&1; then
    cat "$log"
    exit 2
fi
status=0
build/release/bin/votess_fuzz "$@" || status=$?
exit "$status"

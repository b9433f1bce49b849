#!/usr/bin/env bash
# Builds votess and runs clvotess with these arguments. Without arguments it tessellates and checks 100,000 random seeds.
#   ./tools/run.sh
#   ./tools/run.sh points.xyz -o cells.txt
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

# In a subshell, so that file names among the arguments keep their meaning.
(
    cd "$root"
    tools/setup.sh run
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    # Tests and bench need more packages; a tree that was configured with them stays as it is.
    if [[ ! -f build/release/build.ninja ]]; then
        echo "run: configuring build/release"
        cmake --preset release -DVOTESS_BUILD_TESTS=OFF -DVOTESS_BUILD_BENCH=OFF >"$log" 2>&1 || { cat "$log"; exit 1; }
    fi
    echo "run: building clvotess"
    cmake --build --preset release --parallel "$(nproc)" --target clvotess >"$log" 2>&1 || { cat "$log"; exit 1; }
) >&2

if [[ $# -eq 0 ]]; then
    set -- --random 100000 --verify
    echo "run: clvotess $*" >&2
fi
exec "$root/build/release/bin/clvotess" "$@"

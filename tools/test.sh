#!/usr/bin/env bash
# Everything that must hold, in three builds: release (all tests), then address and undefined-behaviour sanitizers
# (tests labelled "sanitize") and the thread sanitizer ("threads"), which compiles without precompiled headers, so that an
# include that is missing is found.
#   ./tools/test.sh [release|asan|tsan]...     default: all three
# VOTESS_TEST_BEST=avx2 (or baseline) tests as on a processor that has no better instructions.
# Exits 0 when every test of every build passed; the last line counts them.
set -euo pipefail
cd "$(dirname "$0")/.."

[[ $# -gt 0 ]] || set -- release asan tsan
tools/setup.sh run test
jobs=$(nproc)
# What lavapipe compiles takes most of the time of tests on it: kept here for all builds.
mkdir -p build
export MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-$PWD/build/mesa}
passed=0
failed=0
broken=()
log=$(mktemp)
trap 'rm -f "$log"' EXIT

run_tree() {  # preset, then arguments of ctest
    local preset=$1
    shift
    echo "== $preset: build"
    # Bench is on in release: it has a smoke test. Options are set here because run.sh may have turned them off.
    local bench=OFF
    [[ $preset != release ]] || bench=ON
    if ! { cmake --preset "$preset" -DVOTESS_BUILD_TESTS=ON -DVOTESS_BUILD_BENCH=$bench &&
           cmake --build --preset "$preset" --parallel "$jobs"; } >"$log" 2>&1; then
        cat "$log"
        broken+=("$preset")
        return
    fi
    grep -E 'warning:|CMake Warning' "$log" || true
    echo "== $preset: test"
    local command=(ctest --test-dir "build/$preset" --output-on-failure --no-tests=error --parallel "$jobs" "$@")
    # GCC 12's thread sanitizer cannot place its shadow where newer kernels randomize widely.
    if [[ $preset == tsan ]] && setarch "$(uname -m)" -R true 2>/dev/null; then
        command=(setarch "$(uname -m)" -R "${command[@]}")
    fi
    "${command[@]}" 2>&1 | tee "$log" || true
    # "97% tests passed, 1 tests failed out of 38"; absent when ctest found no test.
    local counts
    counts=$(sed -nE 's/^[0-9]+% tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\1 \2/p' "$log")
    if [[ -z $counts ]]; then
        broken+=("$preset")
        return
    fi
    failed=$((failed + ${counts% *}))
    passed=$((passed + ${counts#* } - ${counts% *}))
}

for preset in "$@"; do
    case $preset in
        release) run_tree release ;;
        asan) run_tree asan --label-regex '^sanitize$' ;;
        tsan) run_tree tsan --label-regex '^threads$' ;;
        *) echo "test: unknown build '$preset'; it is release, asan or tsan" >&2; exit 2 ;;
    esac
done

if [[ ${#broken[@]} -gt 0 ]]; then
    echo "did not build or had no tests: ${broken[*]}"
    failed=$((failed + ${#broken[@]}))
fi
echo "$passed passed, $failed failed"
[[ $failed -eq 0 ]]

#!/usr/bin/env bash
# Builds votess and tests it. Exits 0 when every test passed; the last line counts them.
#   ./tools/test.sh                             the quick tests: release build, no GPU, in minutes
#   ./tools/test.sh --all                       all tests: release, then the sanitizers
#   ./tools/test.sh quick|release|asan|tsan...  these builds
# asan is AddressSanitizer with UBSan and runs the tests labeled "sanitize". Four checks of UBSan are off, which take an
# eighth of the time to compile: AddressSanitizer finds bad accesses. tsan is ThreadSanitizer, runs the tests labeled
# "threads" without the GPU engine. Both compile the files of a folder together. Shaders are validated in the release
# build.
# VOTESS_TEST_BEST=avx2 (or baseline) limits the CPU's vector instructions.
set -euo pipefail
cd "$(dirname "$0")/.."

[[ $# -gt 0 ]] || set -- quick
[[ $* != --all ]] || set -- release asan tsan
if [[ $* == quick ]]; then tools/setup.sh run quick; else tools/setup.sh run test; fi
jobs=$(nproc)
# Compiling for lavapipe takes most of the time of its tests: all builds share one cache.
mkdir -p build
export MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-$PWD/build/mesa}
passed=0
failed=0
broken=()
log=$(mktemp)
trap 'rm -f "$log"' EXIT

run_tree() {  # preset, target or "all", label or "" for all tests
    local preset=$1 target=$2 label=$3
    echo "== $preset: build"
    # The options are set because run.sh may have turned them off. A smoke test runs the benchmark.
    local options=(-DVOTESS_BUILD_TESTS=ON)
    [[ $preset-$target != release-all ]] || options+=(-DVOTESS_BUILD_BENCH=ON)
    if ! { cmake --preset "$preset" "${options[@]}" &&
           cmake --build --preset "$preset" --parallel "$jobs" --target "$target"; } >"$log" 2>&1; then
        cat "$log"
        broken+=("$preset")
        return
    fi
    grep -E 'warning:|CMake Warning' "$log" || true
    echo "== $preset: test"
    local command=(ctest --test-dir "build/$preset" --output-on-failure --no-tests=error --parallel "$jobs")
    [[ -z $label ]] || command+=(--label-regex "^$label\$")
    # GCC 12's ThreadSanitizer cannot place its shadow memory where newer kernels randomize widely.
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

for build in "$@"; do
    case $build in
        quick) run_tree release votess_quick quick ;;
        release) run_tree release all "" ;;
        asan) run_tree asan all sanitize ;;
        tsan) run_tree tsan all threads ;;
        *) echo "test: unknown build '$build'; use --all, quick, release, asan or tsan" >&2; exit 2 ;;
    esac
done

if [[ ${#broken[@]} -gt 0 ]]; then
    echo "did not build or had no tests: ${broken[*]}"
    failed=$((failed + ${#broken[@]}))
fi
echo "$passed passed, $failed failed"
[[ $failed -eq 0 ]]

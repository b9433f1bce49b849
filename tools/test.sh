#!/usr/bin/env bash
# Builds votess and tests it. Exits 0 when every test passed; the last line counts them.
#   ./tools/test.sh                             the quick tests: release build, no GPU, in minutes
#   ./tools/test.sh --all                       all tests: release, then the sanitizers
#   ./tools/test.sh quick|release|asan|tsan...  these builds
# asan is AddressSanitizer with UBSan and runs the tests labeled "sanitize". Four checks of UBSan are off, which take an
# eighth of the time to compile: AddressSanitizer finds bad accesses. It names functions; for lines add -g1 to the
# preset. tsan is ThreadSanitizer, runs the tests labeled "threads" without the GPU engine. Both compile the files of a
# folder together. Shaders are validated in the release build.
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
logs=$(mktemp -d)
compiling=
trap '[[ -z $compiling ]] || kill "$compiling" 2>/dev/null; rm -rf "$logs"' EXIT

# Of each build: the target to build, and the label of the tests to run, or "" for all.
declare -A target=([quick]=votess_quick [release]=all [asan]=all [tsan]=all)
declare -A label=([quick]=quick [release]="" [asan]=sanitize [tsan]=threads)
for build in "$@"; do
    if [[ -z ${target[$build]:-} ]]; then
        echo "test: unknown build '$build'; use --all, quick, release, asan or tsan" >&2
        exit 2
    fi
done
preset_of() { if [[ $1 == quick ]]; then echo release; else echo "$1"; fi; }

compile() {  # build; in the background
    local preset
    preset=$(preset_of "$1")
    # The options are set because run.sh may have turned them off. A smoke test runs the benchmark.
    local options=(-DVOTESS_BUILD_TESTS=ON)
    [[ $1 != release ]] || options+=(-DVOTESS_BUILD_BENCH=ON)
    { cmake --preset "$preset" "${options[@]}" &&
      exec nice -n 10 cmake --build --preset "$preset" --parallel "$jobs" --target "${target[$1]}"; } \
        >"$logs/$1" 2>&1 &
    compiling=$!
}

run_tests() {  # build
    local preset
    preset=$(preset_of "$1")
    local command=(ctest --test-dir "build/$preset" --output-on-failure --no-tests=error --parallel "$jobs")
    [[ -z ${label[$1]} ]] || command+=(--label-regex "^${label[$1]}\$")
    # GCC 12's ThreadSanitizer cannot place its shadow memory where newer kernels randomize widely.
    if [[ $preset == tsan ]] && setarch "$(uname -m)" -R true 2>/dev/null; then
        command=(setarch "$(uname -m)" -R "${command[@]}")
    fi
    "${command[@]}" 2>&1 | tee "$logs/tests" || true
    # "97% tests passed, 1 tests failed out of 38"; absent when ctest found no test.
    local counts
    counts=$(sed -nE 's/^[0-9]+% tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\1 \2/p' "$logs/tests")
    if [[ -z $counts ]]; then
        broken+=("$preset")
        return
    fi
    failed=$((failed + ${counts% *}))
    passed=$((passed + ${counts#* } - ${counts% *}))
}

while [[ $# -gt 0 ]]; do
    build=$1
    shift
    [[ $compiling ]] || { echo "== $build: build"; compile "$build"; }
    wait "$compiling" && built=yes || built=
    compiling=
    grep -E 'warning:|CMake Warning' "$logs/$build" || true
    # Tests that wait for each other leave a core idle, so the next build compiles beside them.
    [[ $# -eq 0 || $(preset_of "${1:-}") == $(preset_of "$build") ]] || compile "$1"
    if [[ $built ]]; then
        echo "== $build: test${compiling:+, and build of $1}"
        run_tests "$build"
    else
        cat "$logs/$build"
        broken+=("$build")
    fi
done

if [[ ${#broken[@]} -gt 0 ]]; then
    echo "did not build or had no tests: ${broken[*]}"
    failed=$((failed + ${#broken[@]}))
fi
echo "$passed passed, $failed failed"
[[ $failed -eq 0 ]]

#!/usr/bin/env bash
# Proves the answers to random inputs cell by cell, on all cores until the time is over. Or feeds damaged files to the
# readers of clvotess.
#   ./tools/fuzz.sh HOURS|--sets N [KIND...] [--device cpu|lavapipe] [--seed N] [--findings FOLDER] [--jobs N]
#   ./tools/fuzz.sh --replay FILE... [--device cpu|lavapipe]
#   ./tools/fuzz.sh --readers HOURS [READER...]
# Kinds: ties extremes wrapped thin skewed clusters weights walls wedges lattices spheres jobs moving histories many; default: all.
# Readers: number text csv gz xyz poscar tess lammps_dump lammps_data ply npy npz off obj stl ply_mesh hdf5; default: all, for equal times.
# Prints the seed, which is random unless given, and how many sets of each kind it tried. A wrong answer, crash, hang or
# excess of time or memory is a finding: it is reduced and kept in FOLDER (default build/fuzz) as a text for --replay.
# --readers needs clang with libFuzzer. It starts from the inputs that earlier runs kept in build/fuzz/readers and keeps
# findings there as READER-crash-... Exits 1 when there is a finding.
set -euo pipefail
cd "$(dirname "$0")/.."

if [[ $# -eq 0 ]]; then
    sed -n '2,13s/^# //p' "$0" >&2
    exit 2
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT

build() {  # preset or folder, target, then options of cmake
    local target=$2 where=(--preset "$1") tree="build/$1"
    [[ $1 == */* ]] && where=(-S . -B "$1") tree=$1
    shift 2
    if ! { cmake "${where[@]}" -DVOTESS_BUILD_TESTS=ON "$@" &&
           cmake --build "$tree" --parallel "$(nproc)" --target "$target"; } >"$log" 2>&1; then
        cat "$log"
        exit 2
    fi
}

fuzz_readers() {  # hours, then readers
    local hours=$1 clang malloc_limit status=0
    shift
    clang=$(compgen -c clang++ | grep -E '^clang\+\+(-[0-9]+)?$' | sort -V | tail -n 1 || true)
    [[ -n $clang ]] || { echo "fuzz: --readers needs clang++ with libFuzzer (Debian: clang libclang-rt-14-dev)" >&2; exit 2; }
    [[ $# -gt 0 ]] || set -- number text csv gz xyz poscar tess lammps_dump lammps_data ply npy npz off obj stl ply_mesh hdf5
    build build/fuzz/clang votess_reader_fuzzer -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
        "-DCMAKE_CXX_COMPILER=$clang" "-DCMAKE_C_COMPILER=${clang/++/}" -DVOTESS_BUILD_VULKAN=OFF -DVOTESS_FUZZ_READERS=ON
    local seconds seed kept=build/fuzz/readers
    seconds=$(awk -v h="$hours" -v n=$# 'BEGIN { printf "%d", h * 3600 / n + 1 }')
    for reader in "$@"; do
        seed=$((RANDOM * 32768 + RANDOM + 1))
        mkdir -p "$kept/$reader"
        echo "fuzz: reader $reader, $seconds seconds, seed $seed"
        # HDF5 has its own memory pool, reads beyond the end of damaged data, and requests any amount of memory.
        malloc_limit=4096
        [[ $reader != hdf5 ]] || malloc_limit=1000000000
        if ! VOTESS_FUZZ_READER=$reader UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
            ASAN_OPTIONS="detect_leaks=0:allocator_may_return_null=1:suppressions='$PWD/tests/fuzz/readers/hdf5.supp'" \
            build/fuzz/clang/bin/votess_reader_fuzzer -max_total_time="$seconds" -seed="$seed" -max_len=16384 -timeout=20 \
            -rss_limit_mb=4096 -malloc_limit_mb="$malloc_limit" -print_final_stats=1 -verbosity=0 -print_funcs=0 -artifact_prefix="$kept/$reader-" \
            "$kept/$reader" "tests/fuzz/readers/corpus/$reader"; then
            echo "found: see $kept/$reader-*; VOTESS_FUZZ_READER=$reader build/fuzz/clang/bin/votess_reader_fuzzer FILE runs it again"
            status=1
        fi
    done
    exit "$status"
}

tools/setup.sh run test
if [[ $1 == --readers ]]; then
    [[ $# -gt 1 ]] || { echo "fuzz: --readers HOURS [READER...]" >&2; exit 2; }
    fuzz_readers "${@:2}"
fi
build release votess_fuzz
status=0
build/release/bin/votess_fuzz "$@" || status=$?
exit "$status"

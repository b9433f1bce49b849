#!/usr/bin/env bash
# Builds and runs bindings/examples against an installed votess, as a user would. Prints the parts that it skips, with
# the reason.
# Usage: check_examples.sh SOURCE_DIR BUILD_DIR   (BUILD_DIR: a built votess with VOTESS_INSTALL on)
set -euo pipefail

if [[ $# -ne 2 ]]; then
    echo "usage: $0 SOURCE_DIR BUILD_DIR" >&2
    exit 2
fi
source_dir=$(cd "$1" && pwd)
build_dir=$(cd "$2" && pwd)
examples=$source_dir/bindings/examples
python=$source_dir/tools/python.sh
skipped=0

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cached() {
    sed -n "s/^$1:[A-Z]*=//p" "$build_dir/CMakeCache.txt"
}
build() {  # example's folder, build folder; writes all output to a log
    {
        cmake -G "$(cached CMAKE_GENERATOR)" -S "$1" -B "$2" -DCMAKE_PREFIX_PATH="$work/prefix" \
            -DCMAKE_C_COMPILER="$(cached CMAKE_C_COMPILER)" -DCMAKE_CXX_COMPILER="$(cached CMAKE_CXX_COMPILER)" \
            -DCMAKE_C_FLAGS="-Wall -Wextra -pedantic -Werror" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" &&
            cmake --build "$2"
    } >"$2.log" 2>&1
}
built() {  # building process, build folder
    wait "$1" || { cat "$2.log" >&2; exit 1; }
}
skip() {
    echo "skipped: $*"
    skipped=$((skipped + 1))
}
expect() {  # expected text, command
    local text=$1 output
    shift
    output=$("$@")
    echo "$output"
    [[ $output == *"$text"* ]] || { echo "not printed by $*: $text" >&2; exit 1; }
}

cmake --install "$build_dir" --prefix "$work/prefix" >/dev/null
build "$examples/cmake" "$work/cmake" &
plain=$!
vulkan=$(cached VOTESS_BUILD_VULKAN)
if [[ $vulkan == ON ]]; then
    build "$examples/vulkan_frames" "$work/frames" &
    frames=$!
    if command -v nvcc >/dev/null; then
        build "$examples/cuda_frames" "$work/cuda" &
        cuda=$!
    fi
fi

echo "== C and C++ by CMake"
built "$plain" "$work/cmake"
expect "sum of the volumes: 1" "$work/cmake/cells"
printf '# x y z\n0 0 0\n1 0 0\n2 0 0\n' >"$work/points.txt"
expect ", neighbors 0 2" "$work/cmake/cells" "$work/points.txt"
printf '0 0 0\n1 0\n' >"$work/ragged.txt"
if output=$("$work/cmake/cells" "$work/ragged.txt" 2>&1); then
    echo "a file with a ragged row was read" >&2
    exit 1
fi
expect "line 2" echo "$output"
in_c="cell 0: volume 1, neighbors 1 3 4 12 16 48"
expect "$in_c" "$work/cmake/cells_c"

echo "== MPI"
if [[ -x $work/cmake/ranks ]]; then
    expect "4000 cells, their volumes sum to 1.0000000000; volumes of remote neighbors received: yes" env \
        OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
        PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe \
        "$(cached MPIEXEC_EXECUTABLE)" -n 2 "$work/cmake/ranks"
else
    skip "votess is built without MPI"
fi

echo "== C by pkg-config"
pc=$(find "$work/prefix" -name votess.pc)
if ! command -v pkg-config >/dev/null; then
    skip "no pkg-config"
else
    export PKG_CONFIG_PATH=${pc%/*}
    static=()
    [[ $(cached BUILD_SHARED_LIBS) == ON ]] || static=(--static)
    read -ra flags <<<"$(pkg-config "${static[@]}" --cflags --libs votess)"
    "$(cached CMAKE_C_COMPILER)" -std=c11 -Wall -Wextra -pedantic -Werror "$examples/c/cells.c" "${flags[@]}" \
        -o "$work/cells_pc"
    expect "$in_c" env LD_LIBRARY_PATH="$(pkg-config --variable=libdir votess)" "$work/cells_pc"
    version=$(sed -n 's/^CMAKE_PROJECT_VERSION:[A-Z]*=//p' "$build_dir/CMakeCache.txt")
    expect "$version" pkg-config --modversion votess
fi

echo "== Vulkan"
if [[ $vulkan != ON ]]; then
    skip "votess is built without Vulkan"
else
    built "$frames" "$work/frames"
    # Uses the validation layer if it is installed; the layer looks for missing barriers too.
    if output=$(VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation \
                VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT \
                "$work/frames/vulkan_frames" --frames 7 --output "$work/frame.png" 2>&1); then
        echo "$output"
        if [[ $output == *VUID* || $output == *SYNC-HAZARD* ]]; then
            exit 1
        fi
        if "$python" -c "import matplotlib" 2>/dev/null; then
            "$python" "$source_dir/tests/embed/check_picture.py" "$work/frame.png" "$source_dir/tests/embed/frame.png"
        else
            skip "comparing the picture: no matplotlib"
        fi
    elif [[ $output == *"no Vulkan device"* || $output == *IncompatibleDriver* || $output == *"without libpng"* ]]; then
        skip "$output"
    else
        echo "$output" >&2
        exit 1
    fi
fi

echo "== CUDA"
if [[ -z ${cuda:-} ]]; then
    skip "no CUDA toolkit, or votess is built without Vulkan"
else
    built "$cuda" "$work/cuda"
    status=0
    "$work/cuda/cuda_frames" || status=$?
    case $status in
        0) ;;
        77) skip "running cuda_frames: no device of CUDA" ;;
        *) exit 1 ;;
    esac
fi

echo "== Python"
library=$(find "$work/prefix" -name 'libvotess.so' -o -name 'libvotess.dylib')
export VOTESS_LIBRARY=$library PYTHONPATH=$source_dir/bindings/python PYTHONDONTWRITEBYTECODE=1
run_python() {  # required package, script, expected text
    if [[ -z $library ]]; then
        skip "$2: libvotess is a static library"
    elif ! "$python" -c "import $1" 2>/dev/null; then
        skip "$2: no $1"
    else
        expect "$3" "$python" "$examples/python/$2"
    fi
}
run_python ase ase_slab.py "layer at   10.526: neighbors 12 (16 atoms)"
run_python h5py arepo_density.py "volumes fill the box: True"

echo "examples: all passed, $skipped skipped"

#!/usr/bin/env bash
# Builds the CPU engine with its tests for another system and runs the tests here, on Debian for x86_64: for ARM under qemu,
# for Windows under Wine. Does not test a GPU or Python. Under qemu sizes are reduced; it takes about an hour.
#   ./tools/test_cross.sh linux-aarch64|windows-x86_64 [arguments of votess_tests, for example -tc="star*"]
set -euo pipefail
cd "$(dirname "$0")/.."

target=${1:-}
[[ $# -eq 0 ]] || shift
work=$PWD/build/cross
mkdir -p "$work"
source tools/cross/cross.sh
case $target in
    linux-aarch64)
        host=aarch64-linux-gnu suffix=
        run=(env VOTESS_TEST_REDUCED=1 qemu-aarch64 -L "/usr/$host")
        set -- --test-case-exclude="forks:*" "$@"  # qemu 7 fails where a process with threads forks
        tools/setup.sh run quick arm
        ;;
    windows-x86_64)
        host=x86_64-w64-mingw32 suffix=.exe
        run=(env WINEPREFIX="$work/wine" WINEDEBUG=-all wine)
        tools/setup.sh run quick wheel wine
        [[ -d $work/tools ]] || python3 -m venv "$work/tools"
        PATH=$work/tools/bin:$PATH
        quietly pip install --quiet ziglang
        ;;
    *) sed -n '2,4s/^# //p' "$0" >&2; exit 2 ;;
esac
compilers "$target"
if [[ ! -f $CROSS_FOLDER/made ]]; then
    zlib_and_libpng
    gmp_qhull_and_voropp "$host"
    touch "$CROSS_FOLDER/made"
fi
build=$work/$target/build
cmake -S . -B "$build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/tools/cross/cross.cmake" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_UNITY_BUILD=ON -DCMAKE_CXX_FLAGS="-Wall -Wextra" -DVOTESS_PNG_LIBRARY_png="$CROSS_FOLDER/lib/libpng.a;$CROSS_FOLDER/lib/libz.a" \
    -DVOTESS_BUILD_VULKAN=OFF -DVOTESS_BUILD_BENCH=OFF -DVOTESS_USE_HDF5=OFF -DVOTESS_USE_MPI=OFF
cmake --build "$build" --target votess_tests clvotess
"${run[@]}" "$build/bin/clvotess$suffix" --random 10000 --verify
"${run[@]}" "$build/bin/votess_tests$suffix" "$@"

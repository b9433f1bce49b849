#!/usr/bin/env bash
# Builds the CPU engine and its tests for ARM (aarch64) and runs them under qemu's emulation, on Debian for x86_64. Does
# not test a GPU, clvotess or Python. Sizes are reduced; it takes about half an hour.
#   ./tools/test_arm.sh [arguments of votess_tests, for example -tc="star*"]
# Needs: apt install g++-aarch64-linux-gnu qemu-user ninja-build. Libraries for the tests are downloaded as packages and
# unpacked in build/arm; nothing is installed.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh arm
build=$PWD/build/arm
root=$build/root
if [[ ! -d $root ]]; then
    mkdir -p "$build/lists/partial" "$build/packages"
    apt=(apt-get -qq -o "Dir::State::Lists=$build/lists" -o APT::Architectures::=amd64 -o APT::Architectures::=arm64)
    "${apt[@]}" update
    (cd "$build/packages" && "${apt[@]}" download libgmp-dev:arm64 libgmp10:arm64 libgmpxx4ldbl:arm64 libqhull-dev:arm64 \
        libqhull-r8.0:arm64 voro++-dev:arm64 doctest-dev libeigen3-dev)
    for package in "$build"/packages/*.deb; do dpkg -x "$package" "$root.part"; done
    mv "$root.part" "$root"
fi
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
    -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
    -DCMAKE_C_COMPILER=aarch64-linux-gnu-gcc -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ \
    -DCMAKE_FIND_ROOT_PATH="/usr/aarch64-linux-gnu;$root" -DCMAKE_FIND_ROOT_PATH_MODE_PROGRAM=NEVER \
    -DCMAKE_FIND_ROOT_PATH_MODE_LIBRARY=ONLY -DCMAKE_FIND_ROOT_PATH_MODE_INCLUDE=ONLY \
    -DCMAKE_LIBRARY_ARCHITECTURE=aarch64-linux-gnu -DCMAKE_CXX_FLAGS="-Wall -Wextra -isystem $root/usr/include/aarch64-linux-gnu" \
    -DVOTESS_BUILD_VULKAN=OFF -DVOTESS_BUILD_CLI=OFF -DVOTESS_BUILD_BENCH=OFF
cmake --build "$build" --target votess_tests
libraries=$build/lib:$root/usr/lib/aarch64-linux-gnu
VOTESS_TEST_REDUCED=1 qemu-aarch64 -L /usr/aarch64-linux-gnu -E LD_LIBRARY_PATH="$libraries" "$build/bin/votess_tests" "$@"

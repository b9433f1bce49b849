#!/usr/bin/env bash
# Measures votess on this machine's GPU, and checks its lists against the CPU. Prints million cells per second of every
# stage for 1e4 to 1e7 seeds of every kind of domain, and of recorded frames. Tries both kernels, work-groups of 32 and
# 128, and volumes in float64 and float32, and names the fastest. Writes gpu-DEVICE-DATE.json into the current folder.
# Needs no network.
#   tools/bench/gpu.sh                              the first GPU
#   tools/bench/gpu.sh --device lavapipe --sizes 1e4,1e5
#   tools/bench/gpu.sh --pack DIR                   makes a folder for any machine of this architecture with a Vulkan
#                                                   driver and no older C library: run DIR/gpu.sh there
#   --bin DIR                                       folder of votess_bench; default: build/release/bin, else it is built
#   --build                                         builds it always
# Other arguments, such as --kernel, --local-size, --numbers, --json FILE, --input, --want, --repeats, go to
# votess_bench --gpu-table (see its --help).
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

die() {
    echo "gpu: $*" >&2
    exit 1
}

build() {  # in $root, offline; names missing packages and installs nothing
    [[ -f $root/CMakePresets.json ]] || die "no votess_bench in $here/bin, and no sources to build it from"
    local command missing=() configure=(-DVOTESS_BUILD_BENCH=ON) log
    for command in cmake ninja "${CXX:-c++}"; do
        command -v "$command" >/dev/null || missing+=("$command")
    done
    [[ ${#missing[@]} -eq 0 ]] ||
        die "cannot build votess_bench, missing: ${missing[*]}. ./tools/setup.sh run bench installs it where there is" \
            "a network; or make a folder with --pack elsewhere and copy it here"
    # Other options of a tree that is there stay as they are.
    [[ -f $root/build/release/build.ninja ]] || configure+=(-DVOTESS_BUILD_TESTS=OFF)
    log=$(mktemp)
    echo "gpu: building votess_bench in build/release" >&2
    if ! { (cd "$root" && cmake --preset release "${configure[@]}" &&
            cmake --build --preset release --parallel "$(nproc)" --target votess_bench) >"$log" 2>&1; }; then
        cat "$log" >&2
        rm -f "$log"
        die "votess_bench does not build; ./tools/setup.sh run bench installs what is missing where there is a network"
    fi
    rm -f "$log"
}

system_has() {  # library
    PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | grep -F "$1 " >/dev/null
}

find_system_library() {  # library: its file
    PATH=$PATH:/sbin:/usr/sbin ldconfig -p | sed -nE "s|^[[:space:]]*$1 .* => (.*)$|\1|p" | head -n 1
}

pack() {  # folder
    local folder name file loader
    mkdir -p "$1/bin" "$1/lib/runtime" "$1/lib/vulkan"
    folder=$(cd "$1" && pwd)
    cp "$bench" "$folder/bin/"
    cp "$here/gpu.sh" "$folder/"
    while read -r name file; do
        case $name in
            libc.so.* | libm.so.* | libdl.so.* | libpthread.so.* | librt.so.*) ;;
            # Drivers want the machine's own, unless it has none.
            libstdc++.so.* | libgcc_s.so.*) cp -L "$file" "$folder/lib/runtime/$name" ;;
            *) cp -L "$file" "$folder/lib/$name" ;;
        esac
    done < <(ldd "$bench" | sed -nE 's/^[[:space:]]*([^ ]+) => ([^ ]+) .*$/\1 \2/p')
    loader=$(find_system_library libvulkan.so.1)
    if [[ -n $loader ]]; then
        cp -L "$loader" "$folder/lib/vulkan/libvulkan.so.1"
    else
        echo "gpu: no libvulkan.so.1 here to pack; the other machine has to have one" >&2
    fi
    echo "gpu: packed $(du -sh "$folder" | cut -f 1) into $1; copy it and run gpu.sh there" >&2
}

use() {  # adds a folder of libraries, after those in LD_LIBRARY_PATH
    LD_LIBRARY_PATH=${LD_LIBRARY_PATH:+$LD_LIBRARY_PATH:}$1
    export LD_LIBRARY_PATH
}

# Uses the libraries of the packed folder that the machine lacks.
complete_machine() {
    local lacking file
    lacking=$(ldd "$bench" 2>&1 | grep 'not found' || true)
    if [[ -n $lacking && -d $here/lib/runtime ]]; then
        use "$here/lib/runtime"
        lacking=$(ldd "$bench" 2>&1 | grep 'not found' || true)
    fi
    [[ -z $lacking ]] || die "$bench does not run here:"$'\n'"$lacking"
    if ! system_has libvulkan.so.1 && [[ -f $here/lib/vulkan/libvulkan.so.1 ]]; then
        use "$here/lib/vulkan"
    fi
    # Where containers get NVIDIA's driver from the host, the loader does not look.
    if [[ -z ${VK_ADD_DRIVER_FILES:-}${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-} ]]; then
        for file in /usr/local/nvidia/{share/vulkan,vulkan}/icd.d/nvidia_icd.json; do
            if [[ -f $file ]]; then
                export VK_ADD_DRIVER_FILES=$file
                break
            fi
        done
    fi
}

bin=
to_pack=
fresh=no
arguments=()
while [[ $# -gt 0 ]]; do
    case $1 in
        --bin | --pack)
            [[ $# -gt 1 && -n $2 ]] || { echo "gpu: $1 needs a folder" >&2; exit 2; }
            if [[ $1 == --bin ]]; then bin=$2; else to_pack=$2; fi
            shift
            ;;
        --build) fresh=yes ;;
        -h | --help)
            sed -nE '2,/^[^#]/s/^# ?//p' "${BASH_SOURCE[0]}"
            exit 0
            ;;
        *) arguments+=("$1") ;;
    esac
    shift
done

if [[ -n $bin ]]; then
    bench=$bin/votess_bench
    [[ -x $bench ]] || die "no votess_bench in $bin"
elif [[ -x $here/bin/votess_bench ]]; then
    bench=$here/bin/votess_bench
else
    root=$(cd "$here/../.." && pwd)
    bench=$root/build/release/bin/votess_bench
    [[ $fresh == no && -x $bench ]] || build
fi
if [[ -n $to_pack ]]; then
    [[ ${#arguments[@]} -eq 0 ]] || { echo "gpu: --pack only packs, what is ${arguments[0]} for?" >&2; exit 2; }
    pack "$to_pack"
    exit 0
fi
complete_machine
help=$("$bench" --help) || die "$bench does not run here"
[[ $help == *--gpu-table* ]] || die "$bench is older than this script; --build makes it anew"
exec "$bench" --gpu-table "${arguments[@]}"

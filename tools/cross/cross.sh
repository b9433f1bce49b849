# Functions of wheel.sh and test_cross.sh: compilers for another system, and libraries made with them. The caller sets the
# folder `work`; zig's targets need the Python package ziglang.

log=$work/log
quietly() {
    "$@" >"$log" 2>&1 || { cat "$log"; exit 1; }
}

program() {  # file, and the command with options that it runs
    local file=$1
    shift
    printf '#!/bin/sh\nexec %s "$@"\n' "$(printf '"%s" ' "$@")" >"$file"
    chmod +x "$file"
}

# Makes a folder with cc, c++, ar, ranlib, headers and an empty lib. Exports CROSS_SYSTEM, CROSS_PROCESSOR and CROSS_FOLDER,
# which cross.cmake reads.
compilers() {  # target, options of the compilers
    local target=$1 command name zig=
    shift
    export CROSS_FOLDER=$work/$target
    mkdir -p "$CROSS_FOLDER/include" "$CROSS_FOLDER/lib"
    case $target in
        linux-aarch64) CROSS_SYSTEM=Linux CROSS_PROCESSOR=aarch64 ;;
        windows-x86_64) CROSS_SYSTEM=Windows CROSS_PROCESSOR=x86_64 zig=x86_64-windows-gnu ;;
        macos-aarch64) CROSS_SYSTEM=Darwin CROSS_PROCESSOR=arm64 zig=aarch64-macos.11.0 ;;
        macos-x86_64) CROSS_SYSTEM=Darwin CROSS_PROCESSOR=x86_64 zig=x86_64-macos.11.0 ;;
        *) echo "cross: unknown target '$target'" >&2; exit 2 ;;
    esac
    export CROSS_SYSTEM CROSS_PROCESSOR
    if [[ -n $zig ]]; then
        # -fno-sanitize: by default zig stops programs at undefined behavior. -g0: it always adds debug information.
        # -fno-define-target-os-macros: zlib and libpng take them for a Macintosh of old.
        set -- -target "$zig" -fno-sanitize=undefined -g0 -fno-define-target-os-macros "$@"
        command=$(python3 -c 'import ziglang; print(ziglang.__path__[0])')/zig
        for name in cc c++; do program "$CROSS_FOLDER/$name" "$command" $name "$@"; done
        for name in ar ranlib; do program "$CROSS_FOLDER/$name" "$command" $name; done
        # CMake asks for the version of macOS, and uses @rpath from 10.5 on.
        mkdir -p "$CROSS_FOLDER/bin"
        program "$CROSS_FOLDER/bin/sw_vers" echo 11.0
        PATH=$CROSS_FOLDER/bin:$PATH
    else
        command=aarch64-linux-gnu
        program "$CROSS_FOLDER/cc" $command-gcc "$@"
        program "$CROSS_FOLDER/c++" $command-g++ "$@"
        for name in ar ranlib; do program "$CROSS_FOLDER/$name" $command-$name; done
    fi
    for name in CLI doctest eigen3 glm vk_video vulkan volk.h volk.c; do
        [[ ! -e /usr/include/$name ]] || ln -sf "/usr/include/$name" "$CROSS_FOLDER/include/"
    done
}

# Unpacks the sources of packages of Debian in a folder, without Debian's patches, which a mirror may lack.
sources() {  # folder, packages
    local folder=$1 file
    shift
    mkdir -p "$folder/lists/partial" "$folder/parts"
    for file in /etc/apt/sources.list.d/*.sources; do
        [[ ! -f $file ]] || sed 's/^Types:.*/Types: deb-src/' "$file" >"$folder/parts/${file##*/}"
    done
    for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
        [[ ! -f $file ]] || sed -n 's/^deb /deb-src /p' "$file" >"$folder/parts/${file##*/}.list"
    done
    local apt=(apt-get -qq -o Dir::Etc::SourceList=/dev/null -o "Dir::Etc::SourceParts=$folder/parts"
               -o "Dir::State::Lists=$folder/lists")
    quietly "${apt[@]}" update
    (cd "$folder" && "${apt[@]}" source --download-only "$@" >"$log" 2>&1 || true)
    for file in "$folder"/*.orig.tar.*; do tar -xf "$file" -C "$folder"; done
}

# Makes static libraries of zlib and libpng.
zlib_and_libpng() {
    local folder=$work/sources-zlib file zlib libpng
    [[ -d $folder ]] || sources "$folder" zlib libpng1.6
    zlib=$(echo "$folder"/zlib-*) libpng=$(echo "$folder"/libpng*/)
    cp "$libpng/scripts/pnglibconf.h.prebuilt" "$libpng/pnglibconf.h"
    cp "$zlib"/{zlib,zconf}.h "$libpng"/{png,pngconf,pnglibconf}.h "$CROSS_FOLDER/include/"
    for file in adler32 compress crc32 deflate inffast inflate inftrees trees uncompr zutil; do archive z "$zlib/$file.c"; done
    for file in "$libpng"/png*.c; do
        [[ $file == */pngtest.c ]] || archive png "$file" -DPNG_ARM_NEON_OPT=0
    done
}

# Makes static libraries of what the tests link: GMP, Qhull and Voro++.
gmp_qhull_and_voropp() {
    local folder=$work/sources-tests file
    [[ -d $folder ]] || sources "$folder" gmp qhull voro++
    mkdir -p "$(echo "$folder"/gmp-*)/doc"
    printf 'all install:\n' >"$(echo "$folder"/gmp-*)/doc/Makefile.in"  # Debian removes the manual
    (
        mkdir -p "$CROSS_FOLDER/gmp"
        cd "$CROSS_FOLDER/gmp"
        quietly env CC="$CROSS_FOLDER/cc" CXX="$CROSS_FOLDER/c++" AR="$CROSS_FOLDER/ar" RANLIB="$CROSS_FOLDER/ranlib" NM=nm \
            CC_FOR_BUILD=gcc "$(echo "$folder"/gmp-*)/configure" --host="$1" --prefix="$CROSS_FOLDER" --enable-cxx \
            --disable-shared --disable-assembly
        quietly make -j"$(nproc)" install
    )
    mkdir -p "$CROSS_FOLDER/include/libqhull_r" "$CROSS_FOLDER/include/voro++"
    cp "$folder"/qhull-*/src/libqhull_r/*.h "$CROSS_FOLDER/include/libqhull_r/"
    cp "$folder"/voro++-*/src/*.{hh,cc} "$CROSS_FOLDER/include/voro++/"
    for file in "$folder"/qhull-*/src/libqhull_r/*.c; do archive qhull_r "$file"; done
    archive voro++ "$CROSS_FOLDER/include/voro++/voro++.cc"
}

# Compiles a file of C or C++ and adds it to a library.
archive() {  # name of the library, file, options
    local object compiler=cc
    object=$CROSS_FOLDER/$(basename "$2").o
    [[ $2 == *.c ]] || compiler=c++
    "$CROSS_FOLDER/$compiler" -O2 -w -I"$CROSS_FOLDER/include" -c "$2" -o "$object" "${@:3}"
    "$CROSS_FOLDER/ar" rc "$CROSS_FOLDER/lib/lib$1.a" "$object"
    "$CROSS_FOLDER/ranlib" "$CROSS_FOLDER/lib/lib$1.a"
}

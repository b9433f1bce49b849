#!/bin/sh
# Checks what is installed: headers of MPI only with votess_mpi, and the number in the name of a shared library, which
# until 1.0 holds the minor version.
# Usage: check_installed.sh PREFIX VERSION
set -eu
prefix=$1
version=$2

for header in mpi.h mpi.hpp block_cells.hpp; do
    with_library=$(find "$prefix" -name 'libvotess_mpi.*' | head -1)
    with_header=$(find "$prefix" -path "*/votess/$header")
    if [ -n "$with_library" ] && [ -z "$with_header" ] || [ -z "$with_library" ] && [ -n "$with_header" ]; then
        echo "votess/$header is not there just when votess_mpi is" >&2
        exit 1
    fi
done

case $version in
    0.*) number=${version%.*} ;;
    *) number=${version%%.*} ;;
esac
for library in $(find "$prefix" -name 'libvotess*.so'); do
    name=$(readelf -d "$library" | sed -n 's/.*(SONAME).*\[\(.*\)\]/\1/p')
    if [ "$name" != "$(basename "$library").$number" ]; then
        echo "$library has the name $name, not $(basename "$library").$number" >&2
        exit 1
    fi
done

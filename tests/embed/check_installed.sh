#!/bin/sh
# Checks installed files. Headers for MPI are installed exactly when votess_mpi is. Names of shared libraries hold the
# major version, before 1.0 the minor version too.
# Usage: check_installed.sh PREFIX VERSION
set -eu
prefix=$1
version=$2

for header in mpi.h mpi.hpp; do
    with_library=$(find "$prefix" -name 'libvotess_mpi.*' | head -1)
    with_header=$(find "$prefix" -path "*/votess/$header")
    if [ -n "$with_library" ] && [ -z "$with_header" ] || [ -z "$with_library" ] && [ -n "$with_header" ]; then
        echo "votess/$header and votess_mpi must be installed together" >&2
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
        echo "$library has SONAME $name, expected $(basename "$library").$number" >&2
        exit 1
    fi
done

#!/usr/bin/env bash
# Formats the sources by .clang-format; --check only names the files that would change (exit 1).
set -euo pipefail
cd "$(dirname "$0")/.."

# Versions differ in details: another one would reformat files that nobody touched.
readonly version=14
formatter=
for candidate in "${CLANG_FORMAT:-}" "clang-format-$version" clang-format; do
    if [[ -n $candidate ]] && "$candidate" --version 2>/dev/null | grep -q "version $version\."; then
        formatter=$candidate
        break
    fi
done
[[ -n $formatter ]] || { echo "format: needs clang-format $version" >&2; exit 2; }

mapfile -t files < <(find bindings cli engine include shaders tests tools -name '*.[ch]' -o -name '*.[ch]pp' -o -name '*.inl')
if [[ ${1:-} == --check ]]; then
    "$formatter" --dry-run --Werror "${files[@]}"
else
    "$formatter" -i "${files[@]}"
fi

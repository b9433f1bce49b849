#!/usr/bin/env bash
# Measures votess and its peers from 1e3 to 1e6 points and draws the figure.
#   tools/bench/figure.sh                           speed.json and speed.png in the current folder
#   --name NAME                                     NAME.json and NAME.png
#   --bin DIR                                       folder of votess_bench; default: build/release/bin
# Other arguments, such as --n 1e3,1e4 or --peers voro++, go to votess_bench --sweep (see its --help). Needs matplotlib.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

bin=$root/build/release/bin
name=speed
arguments=()
while [[ $# -gt 0 ]]; do
    case $1 in
        --bin | --name)
            [[ $# -gt 1 && -n $2 ]] || { echo "figure: $1 needs a value" >&2; exit 2; }
            if [[ $1 == --bin ]]; then bin=$2; else name=$2; fi
            shift
            ;;
        -h | --help)
            sed -nE '2,/^[^#]/s/^# ?//p' "${BASH_SOURCE[0]}"
            exit 0
            ;;
        *) arguments+=("$1") ;;
    esac
    shift
done

[[ -x $bin/votess_bench ]] ||
    { echo "figure: no votess_bench in $bin: cmake --build --preset release --target votess_bench" >&2; exit 1; }
# Now rather than after the measurements.
"$root/tools/python.sh" -c 'import matplotlib' 2>/dev/null ||
    { echo "figure: needs matplotlib: ./tools/setup.sh bench" >&2; exit 1; }
"$bin/votess_bench" --sweep --json "$name.json" "${arguments[@]}"
"$root/tools/python.sh" "$root/tools/bench/figure.py" "$name.json" "$name.png"
echo "written to $name.json and $name.png"

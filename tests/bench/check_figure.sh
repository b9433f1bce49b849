#!/usr/bin/env bash
# check_figure.sh SOURCE BIN FOLDER: the sweep and its figure, small. Exit code 77 without matplotlib.
set -euo pipefail
source=$1
bin=$2
if ! "$source/tools/python.sh" -c 'import matplotlib' 2>/dev/null; then
    echo "no matplotlib (Debian, Ubuntu: python3-matplotlib): the figure is not tested"
    exit 77
fi
rm -rf "$3"
mkdir -p "$3"
cd "$3"
export MPLCONFIGDIR=$3.cache  # kept: making it takes a while

"$source/tools/bench/figure.sh" --bin "$bin" --name small --n 500,1000 --repeats 1 --at-least 0
# PNG, 1600 pixels wide.
[[ $(od -An -tx1 -N8 small.png | tr -d ' ') == 89504e470d0a1a0a ]]
[[ $(od -An -tu1 -j16 -N4 small.png | tr -s ' ') == ' 0 0 6 64' ]]

status=0
echo '{}' >empty.json
"$source/tools/python.sh" "$source/tools/bench/figure.py" empty.json empty.png || status=$?
[[ $status -eq 2 && ! -e empty.png ]]

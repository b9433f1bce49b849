#!/usr/bin/env bash
# Builds the documentation pages of bindings/python/docs into build/docs/site: runs the code of the pages, makes their
# pictures, and then the site, in which no link is broken.
#   ./tools/docs.sh
#   --build DIR     a build of votess, with bin/clvotess and lib/libvotess; default: build/release, which is built if
#                   there is none
# Needs a network the first time, for the packages in pyproject.toml under "docs", which go into build/docs/venv.
set -euo pipefail
cd "$(dirname "$0")/.."

build=build/release
while [[ $# -gt 0 ]]; do
    case $1 in
        --build)
            [[ $# -gt 1 && -n $2 ]] || { echo "docs: $1 needs a value" >&2; exit 2; }
            build=$2
            shift
            ;;
        -h | --help)
            sed -nE '2,/^[^#]/s/^# ?//p' "$0"
            exit 0
            ;;
        *) echo "docs: $1 is not known" >&2; exit 2 ;;
    esac
    shift
done
if [[ ! -x $build/bin/clvotess || ! -e $build/lib/libvotess.so ]]; then
    [[ $build == build/release ]] || { echo "docs: no bin/clvotess and lib/libvotess.so in $build" >&2; exit 1; }
    tools/run.sh --version
fi
build=$(cd "$build" && pwd)

docs=$PWD/bindings/python/docs
work=$PWD/build/docs
python=$work/venv/bin/python
mkdir -p "$work"
# The same packages as the last time are not asked for again.
wanted=$(python3 - <<'END'
import pathlib, re
text = pathlib.Path("pyproject.toml").read_text()
print("\n".join(re.findall(r'"([^"]+)"', re.search(r"^docs = \[(.*?)^\]", text, re.M | re.S)[1])))
END
)
if [[ ! -x $python || $(cat "$work/packages" 2>/dev/null) != "$wanted" ]]; then
    echo "docs: installing packages"
    python3 -m venv "$work/venv"
    mapfile -t packages <<<"$wanted"
    "$python" -m pip install --quiet --disable-pip-version-check "${packages[@]}"
    echo "$wanted" >"$work/packages"
fi

export VOTESS_LIBRARY=$build/lib/libvotess.so PYTHONPATH=$PWD/bindings/python PATH=$build/bin:$work/venv/bin:$PATH
export VOTESS_DOCS_MADE=$work/made PYTHONDONTWRITEBYTECODE=1

echo "docs: running the code of the pages"
rm -rf "$work/made" "$work/site"
"$python" tests/readme/check_readme.py --source . --build "$build" --bin "$build/bin" --lib "$build/lib" --all \
    --keep "$work/made" "$docs"/pages/*.md
echo "docs: drawing the pictures"
"$python" "$docs/build_pages/pictures.py" "$work/made/exactness"

echo "docs: building the pages"
export NO_MKDOCS_2_WARNING=1
cd "$docs"
if ! "$python" -m mkdocs build --strict >"$work/log" 2>&1 || grep -E '^(WARNING|ERROR)' "$work/log"; then
    cat "$work/log"
    exit 1
fi
echo "docs: $(find "$work/site" -name '*.html' | wc -l) pages, $(find "$work/made" -type f | wc -l) pictures: $work/site/index.html"

#!/usr/bin/env bash
# Builds the documentation pages of bindings/python/docs into build/docs/site: runs the code of the pages and the notebooks,
# makes pictures, builds the site, in which no link is broken, and looks at its pages in a browser. The last lines sum up.
#   ./tools/docs.sh
#   --build DIR     a build of votess, with bin/clvotess and lib/libvotess; default: build/release, which is built if
#                   there is none
#   --small         also renews the small pictures in bindings/python/docs/pages/made, for readers of the sources
# Needs a network the first time, for the packages in pyproject.toml under "docs", which go into build/docs/venv. The browser is
# Chromium; without it the pages are not looked at.
set -euo pipefail
cd "$(dirname "$0")/.."

build=build/release
small=
while [[ $# -gt 0 ]]; do
    case $1 in
        --build)
            [[ $# -gt 1 && -n $2 ]] || { echo "docs: $1 needs a value" >&2; exit 2; }
            build=$2
            shift
            ;;
        --small) small=yes ;;
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

failures=()
# step NAME COMMAND...: runs it, with its output in build/docs/NAME.log, and goes on after a failure.
step() {
    local name=$1
    shift
    echo "docs: $name"
    "$@" >"$work/$name.log" 2>&1 || { failures+=("$name"); grep -Ei 'fail|error|warning' "$work/$name.log" | head -20 || true; }
}
site() {
    cd "$docs"
    NO_MKDOCS_2_WARNING=1 "$python" -m mkdocs build --strict && ! grep -E '^(WARNING|ERROR)' "$work/site.log"
}

rm -rf "$work/made" "$work/site" "$work/look" "$work/look.log"
step code "$python" tests/readme/check_readme.py --source . --build "$build" --bin "$build/bin" --lib "$build/lib" --all \
    --keep "$work/made" "$docs"/pages/*.md
step pictures "$python" "$docs/build_pages/pictures.py" "$work/made/exactness"
step notebooks "$python" "$docs/build_pages/notebooks.py" "$docs/notebooks" "$work/made/notebooks"
[[ -z $small ]] || step small "$python" "$docs/build_pages/small.py" "$work/made" "$docs/pages"
step site site
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
# Without a site there is nothing to look at.
[[ -z $browser || ! -e $work/site/index.html ]] || step look "$python" "$docs/build_pages/look.py" "$browser" "$work/site" "$work/look"

count() { find "$1" -name "$2" 2>/dev/null | wc -l; }
echo "docs: $work/site/index.html"
echo "  pages       $(find "$work/site" -maxdepth 1 -name '*.html' ! -name 404.html | wc -l), the code of $(count "$docs/pages" '*.md') ran: $(grep -c ': ok$' "$work/code.log" || true) blocks"
echo "  pictures    $(($(count "$work/made" '*.png') + $(count "$work/made" '*.svg')))"
echo "  notebooks   $(count "$work/made/notebooks" '*.ipynb')"
if [[ -n $browser && ! -e $work/look.log ]]; then
    echo "  browser     has no site to look at"
elif [[ -n $browser ]]; then
    echo "  browser     $(tail -1 "$work/look.log"), $(count "$work/look" '*.png') screenshots in $work/look"
else
    echo "  browser     none: install chromium, and run again, to look at the pages"
fi
echo "  failures    ${#failures[@]}"
for name in "${failures[@]}"; do echo "    $name: see $work/$name.log"; done
((${#failures[@]} == 0))

#!/usr/bin/env bash
# check_modes.sh BENCH PYTHON FOLDER: --goals, --memory and files of points, on sizes that measure nothing.
set -euo pipefail
bench=$1
python=$2
rm -rf "$3"
mkdir -p "$3"
cd "$3"

"$python" -c '
import random
random.seed(1)
for i in range(1000):
    print(i, random.gauss(-50, 3), random.gauss(7, 3), random.random(), "# a point" if i % 9 == 0 else "")' >points.txt

# Every goal is judged, answers agree, and a program that is missing is named rather than passed over.
"$bench" --goals --n 1000,2000 --repeats 1 --check --file points.txt --json goals.json | tee goals.txt
[[ $(grep -c '>=\|<=' goals.txt) -eq 31 ]]
grep -q '^[0-9]* of 31 goals met$' goals.txt
status=0
"$bench" --goals --n 200 --repeats 1 --peers qhull --strict >strict.txt || status=$?
[[ $status -eq 1 ]]
grep -q 'periodic .* voro++ / votess .* not measured' strict.txt

"$bench" --memory --n 1000 --input uniform,radii,heavy --json memory.json
"$bench" --file points.txt --want full --repeats 2 --at-least 0.01 --check --json file.json

"$python" - <<'END'
import json

def read(name):
    with open(name, encoding="utf-8") as file:
        return json.load(file)

goals = read("goals.json")
assert len(goals["goals"]) == 31 and goals["measurements"] and goals["machine"]["date"], goals
memory = read("memory.json")["memory"]
assert memory and all(row["n"] == 1000 and row["bytes_per_point"] >= 0 for row in memory), memory
assert {row["peer"] for row in memory if row["input"] == "heavy"} - {"geogram"} == {"votess"}, memory
for m in read("file.json")["measurements"]:
    assert m["input"] == "file:points" and m["n"] == 1000 and len(m["seconds"]) >= 2, m
END

# Input that cannot be used is refused.
printf '1 2 3\n4 5\n' >ragged.txt
printf '1 2 x\n' >letters.txt
for bad in ragged letters; do
    status=0
    "$bench" --file $bad.txt 2>error.txt || status=$?
    [[ $status -ne 0 ]] && grep -q "$bad.txt:" error.txt
done

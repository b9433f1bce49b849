#!/usr/bin/env python3
"""Copies the arrays of results from their table, include/votess/arrays.h, to the places that cannot read it.

    tools/arrays.py                      writes _arrays.py of pyvotess, and the table of the page on files
    tools/arrays.py --check [FILE]...    writes nothing; exit code 1 if a file differs from the table, or another file of the
                                         product, or FILE, lists the arrays again
"""
import pathlib
import re
import subprocess
import sys
import textwrap
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[1]
TABLE, PYTHON, PAGE = "include/votess/arrays.h", "bindings/python/pyvotess/_arrays.py", "bindings/python/docs/pages/files.md"
BITS = {"std::int8_t": "Int8", "Id": "Int32", "std::int32_t": "Int32", "std::int64_t": "Int64", "std::uint32_t": "UInt32",
        "double": "Float64", "CellStatus": "UInt8"}  # fmt: skip
SHAPES = {"cell": "N", "entry": "indptr[N]", "vertex": "V"}
# A file of the product with so many of the longer names in quotes is a second list.
LISTED, PRODUCT = 5, ("engine", "cli", "include", "bindings/python/pyvotess")


@dataclass
class Array:
    name: str
    type: str
    per: str
    components: int
    group: str  # "" in every result
    column: str
    text: str
    of_rows: bool  # that streams and ranks have

    @property
    def optional(self):
        return "; only " in self.text

    def shape(self):
        if self.per == "other":
            return self.text.split(") ", 1)[0] + ")"
        return f"({SHAPES[self.per]}, {self.components})" if self.components > 1 else f"({SHAPES[self.per]},)"

    def meaning(self):
        return self.text.split(") ", 1)[1] if self.per == "other" else self.text

    def python_type(self, wide=False):
        return ("Int64" if wide and self.type == "Id" else BITS[self.type]) + "Array"

    def python_text(self):
        text = self.meaning().replace("; only ", "; None except ").replace("CellStatus", ":class:`CellStatus`")
        return f"{self.shape()} {BITS[self.type].lower()}: {text}."

    def docstring(self):
        text = self.python_text()
        if len(text) < 105:
            return f'        """{text}"""\n'
        lines = textwrap.wrap(text, 112, break_long_words=False, break_on_hyphens=False)
        return '        """' + "\n        ".join(lines) + '\n        """\n'

    def attribute(self):
        kind = self.python_type()
        kind, get = (f"Optional[{kind}]", "_held") if self.optional else (kind, "_array")
        return f'    @property\n    def {self.name}(self) -> {kind}:\n{self.docstring()}        return self.{get}("{self.name}")\n'

    def field(self):
        kind = self.python_type(wide=True)
        kind = f"Optional[{kind}]" if self.group or self.optional else kind
        text = self.python_text().replace("indptr[N]", "entries")
        lines = textwrap.wrap(text, 112, break_long_words=False, break_on_hyphens=False)
        return "".join(f"    #: {line}\n" for line in lines) + f"    {self.name}: {kind}\n"


def read_table():
    """Returns the groups (name, bit) and the arrays."""
    text = re.sub(r"^ *//.*|^#.*\n", "", (ROOT / TABLE).read_text(), flags=re.M)
    groups = [(name, int(bit)) for name, bit in re.findall(r"VOTESS_GROUP\((\w+), \w+, (\d+), \w+\)", text)]
    arrays = []
    row = re.compile(r'VOTESS_(ROW|OTHER)_(ARRAY|STARTS)\(([\w:, ]+?),\s*"(\w*)",((?:\s*"[^"]*")+)\)')
    for of, _, values, column, pieces in row.findall(text):
        name, kind, per, components, group = values.split(", ")
        meaning = "".join(re.findall(r'"([^"]*)"', pieces))
        arrays.append(Array(name, kind, per, int(components), "" if group == "every" else group, column, meaning, of == "ROW"))
    if len(groups) + len(arrays) != text.count("VOTESS_"):
        sys.exit(f"{TABLE}: a row has another form than the others")
    return groups, arrays


def python(groups, arrays):
    words = [name for name, _ in groups]
    names = [array.name for array in arrays if array.name not in words and array.name != "weights"]
    quoted = lambda names: textwrap.fill(", ".join(f'"{name}"' for name in names), 112, initial_indent="    ", subsequent_indent="    ")
    table = "".join(f'    "{a.name}": Array("{a.group}", "{a.per}", "{a.column}", {a.optional}),\n' for a in arrays)
    properties = "\n".join(array.attribute() for array in arrays)
    fields = "".join(a.field() for a in arrays if a.of_rows and a.per != "other" and a.name != "indices")
    return f'''"""The arrays of results. tools/arrays.py writes this file from the table {TABLE}."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Literal, NamedTuple, Optional, Tuple

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Float64Array, Int8Array, Int32Array, Int64Array, UInt8Array, UInt32Array

WANT_BITS: Dict[str, int] = {{
{textwrap.fill(", ".join(f'"{name}": {bit}' for name, bit in groups) + ",", 112, initial_indent="    ", subsequent_indent="    ")}
}}  # fmt: skip
WantWord = Literal[
{quoted(words)}
]  # fmt: skip
#: Names that ``want`` accepts: words, and the arrays in their groups.
WantName = Literal[
    WantWord, "cell_vertices",
{quoted(names)}
]  # fmt: skip


class Array(NamedTuple):
    """A row of the table."""

    group: str  #: that wants it; "" for an array of every result
    per: str  #: "cell", "entry", "vertex" or "other"
    column: str  #: its name in tables of cells; "" for none
    optional: bool  #: whether it may be missing


TABLE: Dict[str, Array] = {{
{table}}}
#: The arrays of each word of want that are always there.
ARRAYS: Dict[str, Tuple[str, ...]] = {{
    group: tuple(name for name, array in TABLE.items() if array.group == group and not array.optional) for group in WANT_BITS
}}


class ArrayAttributes:
    """The arrays of a result as attributes."""

    if TYPE_CHECKING:

        def _array(self, name: str) -> npt.NDArray[Any]: ...

        def _held(self, name: str) -> Optional[npt.NDArray[Any]]: ...

{properties}

@dataclass(frozen=True, eq=False)
class RowFields:
    """The arrays that streams and ranks have, except the rows."""

{fields}'''


def page(text, groups, arrays):
    rows = "".join(
        f"| {f'`{a.group}`' if a.group else ''} | `{a.name}` | {a.shape()} {BITS[a.type].lower()} | {a.meaning()} |\n"
        for group in [*(name for name, _ in groups), ""] for a in arrays if a.group == group
    )  # fmt: skip
    begin, end = "<!-- written by tools/arrays.py -->\n", "<!-- end -->\n"
    head, rest = text.split(begin)
    table = "| group | array | shape and type | meaning |\n|---|---|---|---|\n"
    return head + begin + table + rows + end + rest.split(end, 1)[1]


def other_lists(arrays, files):
    """Returns the files that list the arrays again."""
    files = subprocess.run(["git", "ls-files", *PRODUCT, *files], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    found = {}
    for file in set(files.split()) - {TABLE, PYTHON}:
        if pathlib.Path(file).suffix in (".cpp", ".hpp", ".h", ".py"):
            text = (ROOT / file).read_text("utf-8")
            names = [array.name for array in arrays if "_" in array.name and f'"{array.name}"' in text]
            if len(names) >= LISTED:
                found[file] = names
    return found


def main():
    check = sys.argv[1:2] == ["--check"]
    if sys.argv[1:] and not check:
        sys.exit(__doc__)
    groups, arrays = read_table()
    new = {PYTHON: python(groups, arrays), PAGE: page((ROOT / PAGE).read_text(), groups, arrays)}
    wrong = {name: text for name, text in new.items() if not (ROOT / name).exists() or text != (ROOT / name).read_text()}
    lists = other_lists(arrays, sys.argv[2:]) if check else {}
    for name, text in wrong.items():
        if check:
            print(f"{name} differs from {TABLE}: run tools/arrays.py")
        else:
            (ROOT / name).write_text(text)
    for name, found in lists.items():
        print(f"{name} lists arrays again: {', '.join(found)}: iterate over the table")
    print(f"{len(arrays)} arrays")
    return 1 if check and (wrong or lists) else 0


if __name__ == "__main__":
    sys.exit(main())

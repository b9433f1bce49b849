#!/usr/bin/env python3
"""Copies the options of the library from their table, cli/options.cpp, to the places that cannot read it.

    tools/options.py            writes votess.hpp, votess.h, engine/input/each_option.hpp and Python
    tools/options.py --check    writes nothing; exit code 1 if a file differs from the table

An option that a file has keeps its place there. A new one follows the row before it; in votess.h it comes last, because
its order is a promise. Afterwards tools/format.sh aligns comments.
"""
import pathlib
import re
import sys
import textwrap
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[1]
HPP, H, EACH = "include/votess/votess.hpp", "include/votess/votess.h", "engine/input/each_option.hpp"
PYTHON, DOMAIN = "bindings/python/pyvotess/tessellator.py", "bindings/python/pyvotess/_domain.py"
# kind in the table: types in C++, C and Python
TYPES = {"Flag": ("bool", "int32_t", "bool"), "Count": ("unsigned", "uint32_t", "int"), "Number": ("double", "double", "float"),
         "Word": ("ENUM", "int32_t", "ENUMWord"), "Text": ("std::string", "const char*", "str")}


@dataclass
class Row:
    """An option of the library that is one flag, number, word or text."""

    name: str
    kind: str
    text: str  # a sentence without its period
    words: list
    start: str
    max: str
    place: str  # in Python: "device" for an argument of Tessellator(), "call" of its tessellate(), "domain" of Domain()

    def types(self):
        return [kind.replace("ENUM", self.name.title().replace("_", "")) for kind in TYPES[self.kind]]

    def cpp(self):
        text = textwrap.wrap(f"{self.text[0].upper()}{self.text[1:]}.", 113, break_on_hyphens=False)
        kind = self.types()[0]
        start = {"Word": f"{kind}::{self.start}", "Text": f'"{self.start}"'}.get(self.kind, self.start)
        end = ";" if start == '""' else f" = {start};"
        return "".join(f"    // {line}\n" for line in text) + f"    {kind} {self.name}{end}\n"

    def c(self):
        note = {"Flag": "nonzero: true", "Word": f"VOTESS_{self.name.upper()}_*", "Text": "NULL: default"}.get(self.kind)
        return f"    {self.types()[1]} {self.name};" + (f"  // {note}\n" if note else "\n")

    def call(self):
        allowed = {"Count": f"UpTo<unsigned>{{{self.max}}}", "Number": f"UpTo<double>{{{self.max}}}",
                   "Word": "std::array{" + ", ".join(f'"{word}"' for word in self.words) + "}"}.get(self.kind, "anything")
        return f'    use("{self.name}", &Options::{self.name}, &votess_options::{self.name}, {allowed});\n'

    def argument(self, indent):
        start = {"Flag": "False", "Count": self.start, "Number": self.start + ("" if "." in self.start else ".0")}
        return f"{indent}{self.name}: {self.types()[2]} = " + start.get(self.kind, f'"{self.start}"') + ",\n"

    def keyword(self):
        return f"    {self.name}: {self.types()[2]}\n"

    def docstring(self):
        words = " or ".join(f'"{word}"' for word in self.words) + "; " if self.words else ""
        lines = textwrap.wrap(f"{self.name} : {words}{self.text}.", 112, break_on_hyphens=False)
        return f"    {lines[0]}\n" + "".join(f"        {line}\n" for line in lines[1:])


def read_table():
    """Returns the rows that state a value: &Options::... in the table."""
    source = (ROOT / "cli/options.cpp").read_text()
    rows = []
    for chunk in re.finditer(r'\{"([^"]+)",\s*R"\(((?:(?!\)").)*)\)",\s*\{([^{}]*\.member = (\w+)[^(]*\(&Options::(\w+)[^{}]*)\}',
                             source, re.S):
        names, text, traits, kind, name = chunk.groups()
        text = " ".join(text.split()).replace("an index of --list-devices", "the id of one of devices()")
        text = re.sub(r"--([a-z][a-z-]*)", lambda option: option[1].replace("-", "_"), text)
        notes = re.findall(r'\.unit = "([^"]*)"', traits) + [f"at most {max}" for max in re.findall(r"\.max = (\w+)", traits)]
        words = names.split()[-1].split("|") if kind == "Word" else []
        given = dict(re.findall(r'\.(start|max) = "?([^",\s]+)', traits))
        start = {"Flag": "false", "Text": ""}.get(kind, "0")
        heading = re.findall(r'\{"", "(\w+)', source[: chunk.start()])[-1]
        rows.append(Row(name, kind, text + (f" ({', '.join(notes)})" if notes else ""), words, given.get("start", start),
                        given.get("max", "infinity" if kind == "Number" else "4294967295"),
                        "domain" if name == "outside" else {"run": "device", "tuning": "device"}.get(heading, "call")))
    if len(rows) != source.count("&Options::"):
        sys.exit("cli/options.cpp: a row with &Options:: has another form than the others")
    return rows


def put(rows, text, begin, end, old, new, last=False):
    """Replaces what old matches, with a row's name for NAME, between begin and end.

    A row that is not there follows the row before it, or is last."""
    head, body, tail = re.match(rf"(.*?{begin})(.*?)({end}.*)", text, re.S).groups()
    at = len(body)
    for row in rows:
        found = re.search(old.replace("NAME", row.name), body, re.M)
        begins, ends = found.span() if found else (len(body), len(body)) if last else (at, at)
        same = found and found[0].split() == new(row).split()
        piece = found[0] if same else new(row)  # an aligned comment stays
        body = body[:begins] + piece + body[ends:]
        at = begins + len(piece)
    return head + body + tail


def copies(rows):
    """Returns the new text of each file."""
    text = {name: (ROOT / name).read_text() for name in (HPP, H, EACH, PYTHON, DOMAIN)}
    text[HPP] = put(rows, text[HPP], r"struct Options \{\n", r"\};\n//", r"(?:^    // .*\n)*^    [\w:]+ NAME( =.*)?;.*\n", Row.cpp)
    text[H] = put(rows, text[H], r"struct votess_options \{\n", r"\} votess_options", r"^    (?:const )?\w+\*? NAME;.*\n", Row.c, True)
    text[EACH] = put(rows, text[EACH], r"each_option\(const Use& use\) \{\n", r"\}\n", r'^    use\("NAME".*\n', Row.call)
    for begin, places in (("\ndef tessellate", ("device", "call")), ("    def __init__", ("device",)), ("    def tessellate", ("call",))):
        those = [row for row in rows if row.place in places]
        indent = "    " if len(places) > 1 else "        "
        text[PYTHON] = put(those, text[PYTHON], begin, r" *\) ->", r"^ +NAME: .*\n", lambda row: row.argument(indent))
    of_domain = [row for row in rows if row.place == "domain"]
    text[DOMAIN] = put(of_domain, text[DOMAIN], r"class DomainKeywords", r"\n\nSHORT_FORMS", r"^    NAME: .*\n", Row.keyword)
    for name, those in ((PYTHON, [row for row in rows if row.place != "domain"]), (DOMAIN, of_domain)):
        begin, end = (r"\n    points : ", r"\n    The GIL") if name == PYTHON else (r"\n    box : ", r"\n    Raises")
        text[name] = put(those, text[name], begin, end, r"^    NAME : .*\n(?:        .*\n)*", Row.docstring)
    return text


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    rows = read_table()
    wrong = {name: text for name, text in copies(rows).items() if text != (ROOT / name).read_text()}
    for name, text in wrong.items():
        if sys.argv[1:]:
            print(f"{name} differs from cli/options.cpp: run tools/options.py")
        else:
            (ROOT / name).write_text(text)
    print(f"{len(rows)} options of the library")
    return 1 if wrong and sys.argv[1:] else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Checks that messages of the engine mark the options that they name, by Options:: or by option().

    check_words.py SOURCE

A message says Options::min_face, so that the C interface, Python and the command line can use their own words. The names
are those of the members of public structs of options. A name that is an English word too, such as mesh, is found only
in messages that say to set it or to leave it out.
"""
import pathlib
import re
import sys

LITERAL = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
STRUCT = re.compile(r"^struct (\w*Options) \{\n(.*?)^\};", re.M | re.S)
MEMBER = re.compile(r"^    [\w:<>, ]+[\w>] (\w+)(?: = [^;]+|\{[^;]*\})?;", re.M)
# Messages with these words are not for users of options: the C interface names its own arguments.
CALL = re.compile(r'(?<![\w"])option\("([\w.]+)"\)')
LEFT_OUT = ("engine/c/", "engine/gpu/frames/", "engine/picture/", "engine/input/each_option.hpp", "engine/input/want_names.cpp",
            "engine/core/clock")


def main():
    source = pathlib.Path(sys.argv[1])
    names, declared = set(), set()
    for header in sorted((source / "include/votess").glob("*.hpp")):
        if header.name in ("vulkan.hpp", "picture.hpp"):
            continue
        for _, members in STRUCT.findall(header.read_text()):
            names.update(MEMBER.findall(members))
            declared.update(re.findall(r"\b(\w+)(?: = [^;]+|\{[^;]*\})?;", members))
    every = "|".join(sorted(names))
    # Names with _ are no English words. The others follow a verb, without an article.
    bare = re.compile(rf"(?<![\w.:])(?:({'|'.join(n for n in sorted(names) if '_' in n)})\b"
                      rf"|(?<![\w.:])({every})(?= (?:\w+ \w+ )?and [\w:. ]+(?:are both|contradict)\b| are both)"
                      rf"|(?:leave out|set|raise|lower|give|use|without|with|or) `?({every})\b`?(?=[\",:.;)]|$| (?:and|or|so|to)\b))")
    wrong, count = [], 0
    for path in sorted((source / "engine").rglob("*")):
        file = path.relative_to(source).as_posix()
        if path.suffix not in (".cpp", ".hpp", ".inl") or file.startswith(LEFT_OUT):
            continue
        for number, line in enumerate(path.read_text().split("\n"), 1):
            if line.lstrip().startswith(("//", "#")):
                continue
            wrong += [f'{file}:{number}: there is no option "{name}"' for name in CALL.findall(line) if name.split(".")[0] not in names | declared]
            for literal in LITERAL.findall(line):
                count += " " in literal
                if " " in literal and (found := bare.search(literal)):
                    wrong.append(f'{file}:{number}: "{literal}" names {found[1] or found[2] or found[3]}: write Options:: or option(), see CONTRIBUTING.md')
    if len(names) < 20:
        wrong.append(f"only {len(names)} names of options are found")
    print("\n".join(wrong) if wrong else f"{count} texts mark the {len(names)} options that they name")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

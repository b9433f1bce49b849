#!/usr/bin/env python3
"""Checks that the sources keep to the rooms of the house.

    check_house.py SOURCE [--include FILE=HEADER]...

The table of folders in engine/README.md lists which folders a folder of the engine may include: only folders above it, so
that no include runs up. The modules of pyvotess import each other in no circle. cli/ and bindings/ include nothing of the
engine except core/system.hpp and core/processors.hpp. No other file asks which system it is on. In the engine only input/,
where options are settled, run/ and c/ name `Options`. All files that state the version state the same.
--include adds an include that does not exist, to see the check fail.
"""
import argparse
import ast
import pathlib
import re
import sys

SOURCES = {".cpp", ".hpp", ".inl", ".h", ".c", ".glsl", ".comp", ".vert", ".frag", ".py", ".sh"}
VERSIONS = {
    "CMakeLists.txt": r"project\(votess VERSION (\S+)",
    "bindings/python/pyvotess/_library.py": r'^VERSION = "(.+)"',
    "CITATION.cff": r"^version: (\S+)",
    "tools/recipes/vcpkg/votess/vcpkg.json": r'"version": "(.+)"',
}
# Only these files ask which system they are on: one for its calls, one for the marks of symbols in public headers.
SYSTEM = {"engine/core/system.cpp", "include/votess/export.hpp"}
KNOW_OPTIONS = {"input", "run", "c"}
FOR_CLI = {"core/system.hpp", "core/processors.hpp"}
NAMES = re.compile(r"\b(_WIN32|_WIN64|__MINGW32__|__APPLE__|__linux__|__unix__|__GLIBC__)\b")
# Tests include headers of POSIX where they are built only there.
HEADERS = re.compile(r"#\s*include <(unistd|fcntl|dlfcn|windows|io|signal|poll|sched|pthread|sys/\w+|mach\S*)\.h>")
TREES = ("engine", "shaders", "cli", "bindings", "tests", "tools", "include")


def rules(readme):
    """Returns a dict: folder -> folders that it may include, in the order of the table."""
    text = readme.read_text().split("## Folders, and who may include whom", 1)[1].split("\n## ", 1)[0]
    table = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| `") and len(cells) == 3:
            table[cells[0].strip("`/")] = re.findall(r"`([^`]+?)/`", cells[2])
    return table


def imports(package, file):
    """The modules of the package that a module imports, in functions and under TYPE_CHECKING too."""
    found = set()
    for node in ast.walk(ast.parse((package / file).read_text())):
        if not isinstance(node, ast.ImportFrom) or node.level == 0:
            continue
        folder = (package / file).parents[node.level - 1] / (node.module or "").replace(".", "/")
        for target in [folder / name.name for name in node.names] + [folder] * bool(node.module):
            paths = (target.with_suffix(".py"), target / "__init__.py")
            found.update(path.relative_to(package) for path in paths if path.is_file())
    return found


def circle(arrows):
    """The modules of one circle of arrows, in order; empty when there is none."""
    done = set()

    def visit(module, way):
        if module in way:
            return way[way.index(module):]
        if module not in done:
            for target in sorted(arrows[module]):
                if found := visit(target, [*way, module]):
                    return found
            done.add(module)
        return []

    return next((found for module in sorted(arrows) if (found := visit(module, []))), [])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("--include", action="append", default=[])
    arguments = parser.parse_args()
    source = arguments.source
    table = rules(source / "engine/README.md")
    engine = source / "engine"
    files = [pathlib.PurePosixPath(p.relative_to(source)) for tree in TREES for p in sorted((source / tree).rglob("*"))
             if p.suffix in SOURCES and p.is_file()]
    wrong = []

    if len(table) < 8:
        wrong.append("engine/README.md: the table of folders is not found")
    above = set()
    for folder, allowed in table.items():
        if not (engine / folder).is_dir():
            wrong.append(f"engine/README.md: there is no folder engine/{folder}")
        wrong += [f"engine/README.md: {folder}/ may include {a}/, which is not above it" for a in allowed if a not in above]
        above.add(folder)

    includes = [(f, i) for f in files if f.parts[0] in ("engine", "cli")
                for i in re.findall(r'^\s*#\s*include "([^"]+)"', (source / f).read_text(), re.M)]
    includes += [tuple(pair.split("=", 1)) for pair in arguments.include]
    for file, header in includes:
        file = pathlib.PurePosixPath(file)
        if not (engine / header).is_file():
            continue
        if file.parts[0] == "cli":
            if header not in FOR_CLI and not (source / "cli" / header).is_file():
                wrong.append(f"{file}: includes {header} of the engine; cli/ uses include/ and {sorted(FOR_CLI)} alone")
            continue
        room, target = file.parts[1], header.split("/")[0]
        if room not in table:
            wrong.append(f"{file}: engine/README.md does not list {room}/")
        elif target != room and target not in table[room]:
            wrong.append(f"{file}: {room}/ may not include {header}")

    for file in (f for f in files if f.parts[0] == "engine" and f.parts[1] not in KNOW_OPTIONS):
        if re.search(r"\bOptions\b", (source / file).read_text()):
            wrong.append(f"{file}: names Options: settle() in engine/input has their values, option() their names")

    for file in files:
        if str(file) in SYSTEM or file.suffix in {".py", ".sh"} or file.parts[0] == "tools":
            continue
        text = (source / file).read_text()
        found = NAMES.search(text) or (file.parts[0] != "tests" and HEADERS.search(text))
        if found:
            wrong.append(f"{file}: asks which system it is on ({found[0]}): that belongs into engine/core/system.cpp")

    package = source / "bindings/python/pyvotess"
    arrows = {file: imports(package, file) for file in (p.relative_to(package) for p in package.rglob("*.py"))}
    if way := circle(arrows):
        wrong.append("bindings/python/pyvotess: these modules import each other: " + " -> ".join(map(str, way)))

    versions = {file: re.findall(stated, (source / file).read_text(), re.M) for file, stated in VERSIONS.items()}
    for file, stated in versions.items():
        if len(stated) != 1 or stated != versions["CMakeLists.txt"]:
            wrong.append(f"{file}: states version {stated}, CMakeLists.txt {versions['CMakeLists.txt']}")
    print("\n".join(wrong) if wrong else f"{len(files)} files, {len(includes)} includes: as engine/README.md says")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

"""Checks that the shared library exports its own interface and nothing else.

The defined dynamic symbols must be the functions that votess.h, frames.h, picture.h, stream.h and surface.h declare, and members of classes marked
VOTESS_API in the C++ headers and ENGINE_HEADERs, with their type information. Nothing of Vulkan or volk may be exported,
and no template instantiation of std or boost: a second copy of the library in the process would share them. No Vulkan
function may be undefined, because the loader is opened at run time.

Usage: check_symbols.py NM LIBRARY INCLUDE_FOLDER ENGINE_HEADER...
"""

import re
import subprocess
import sys
from pathlib import Path

CLASS = re.compile(r"(?:class|struct)\s+VOTESS_API\s+(\w+)")
FUNCTION = re.compile(r"VOTESS_API\s[\w:<>,*&\s]*?\b(\w+)\(")
PREFIX = re.compile(r"^(?:typeinfo (?:name )?for|vtable for) ")


def names(nm, library, *options):
    """Yields (type, name) of each dynamic symbol."""
    listed = subprocess.run([nm, "-D", *options, library], check=True, capture_output=True, text=True).stdout
    for line in listed.splitlines():
        match = re.match(r"^[0-9a-f ]* ([A-Za-z]) (.+)$", line)
        if not match:
            sys.exit(f"{nm} printed an unexpected line: {line}")
        yield match[1], match[2]


def without_comments(path):
    return re.sub(r"//.*", "", path.read_text())


def main():
    nm, library, include, *shared = sys.argv[1:]
    headers = [*sorted(Path(include, "votess").glob("*.hpp")), *map(Path, shared)]
    c_text = "".join(without_comments(Path(include, "votess", name)) for name in ["votess.h", "frames.h", "picture.h", "stream.h", "surface.h"])
    c_functions = set(re.findall(r"VOTESS_API[^;]*?\b(votess_\w+)\(", c_text))
    cpp_text = "".join(without_comments(header) for header in headers)
    cpp_names = {*CLASS.findall(cpp_text), *FUNCTION.findall(cpp_text)}
    if "votess_tessellate" not in c_functions or not {"tessellate", "Tessellation", "Error"} <= cpp_names:
        sys.exit(f"no declarations found in the headers of {include}")

    wrong = []
    exported = set()
    for _, name in names(nm, library, "--defined-only", "--demangle"):
        if name in c_functions:
            exported.add(name)
            continue
        # votess::vulkan::Plan::frame(...) belongs to Plan, votess::devices() to devices.
        match = re.match(r"^votess::(?:(?:vulkan|c|blocks)::)?(\w+)", PREFIX.sub("", name))
        if match and match[1] in cpp_names:
            exported.add(match[1])
        else:
            wrong.append(f"exported, but not declared in include/: {name}")
    # Only functions: a class whose members are all inline exports nothing.
    wrong += [f"declared in votess.h, but not exported: {name}" for name in sorted(c_functions - exported)]
    for _, name in names(nm, library, "--undefined-only"):
        if re.match(r"^(?:votess_)?(?:vk[A-Z]|volk)", name):
            wrong.append(f"undefined: {name}")
    print("\n".join(wrong) or f"{len(exported)} functions and classes are exported, nothing else")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

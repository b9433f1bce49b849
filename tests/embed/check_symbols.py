"""The shared library shows its own interface and nothing else.

Defined dynamic symbols must be exactly: the functions that votess.h and stream.h declare, and members of what the C++ headers mark
with VOTESS_API (with type information and vtables of those), as ENGINE_HEADERs do for libvotess_mpi. So no function of
Vulkan or volk, whatever its prefix, and no instantiation of a template of std or boost, not even a weak one: a second
copy in the process, or a host with another compiler, would share those. Undefined ones must not be of Vulkan: the loader is opened at run time.

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
    """(type, name) of the dynamic symbols."""
    listed = subprocess.run([nm, "-D", *options, library], check=True, capture_output=True, text=True).stdout
    for line in listed.splitlines():
        match = re.match(r"^[0-9a-f ]* ([A-Za-z]) (.+)$", line)
        if not match:
            sys.exit(f"{nm}: not understood: {line}")
        yield match[1], match[2]


def without_comments(path):
    return re.sub(r"//.*", "", path.read_text())


def main():
    nm, library, include, *shared = sys.argv[1:]
    headers = [*sorted(Path(include, "votess").glob("*.hpp")), *map(Path, shared)]
    c_text = "".join(without_comments(Path(include, "votess", name)) for name in ["votess.h", "stream.h"])
    c_functions = set(re.findall(r"VOTESS_API[^;]*?\b(votess_\w+)\(", c_text))
    cpp_text = "".join(without_comments(header) for header in headers)
    cpp_names = {*CLASS.findall(cpp_text), *FUNCTION.findall(cpp_text)}
    if "votess_tessellate" not in c_functions or not {"tessellate", "Tessellation", "Error"} <= cpp_names:
        sys.exit(f"the headers in {include} were not understood")

    wrong = []
    shown = set()
    for _, name in names(nm, library, "--defined-only", "--demangle"):
        if name in c_functions:
            shown.add(name)
            continue
        # votess::vulkan::Plan::frame(...) belongs to Plan, votess::devices() to devices.
        match = re.match(r"^votess::(?:(?:vulkan|c)::)?(\w+)", PREFIX.sub("", name))
        if match and match[1] in cpp_names:
            shown.add(match[1])
        else:
            wrong.append(f"shown, but not declared in include/: {name}")
    # Classes of which everything is inline are declared without being shown, so functions are enough here.
    wrong += [f"declared in votess.h, but not shown: {name}" for name in sorted(c_functions - shown)]
    for _, name in names(nm, library, "--undefined-only"):
        if re.match(r"^(?:votess_)?(?:vk[A-Z]|volk)", name):
            wrong.append(f"taken from outside: {name}")
    print("\n".join(wrong) or f"{len(shown)} functions and classes, nothing else")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

"""The command clvotess of an installed pyvotess. It does not import pyvotess, which would load NumPy first."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path


def _program() -> Path:
    """Returns the path of the program in the package pyvotess."""
    package = importlib.util.find_spec("pyvotess")
    name = "clvotess.exe" if os.name == "nt" else "clvotess"
    for folder in (package.submodule_search_locations if package else None) or ():
        program = Path(folder) / "bin" / name
        if program.is_file():
            return program
    raise SystemExit("clvotess: the program is missing from the package pyvotess: install it again with pip")


def main() -> None:
    """Replaces this process by the program, with the same arguments."""
    program = str(_program())
    if os.name == "nt":
        raise SystemExit(subprocess.call([program, *sys.argv[1:]]))
    os.execv(program, ["clvotess", *sys.argv[1:]])

"""The command clvotess of an installed pyvotess. It does not import pyvotess, which would load NumPy first."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path


def _program() -> Path:
    """The program that lies in the package pyvotess."""
    package = importlib.util.find_spec("pyvotess")
    name = "clvotess.exe" if os.name == "nt" else "clvotess"
    for folder in (package.submodule_search_locations if package else None) or ():
        program = Path(folder) / "bin" / name
        if program.is_file():
            return program
    raise SystemExit("clvotess: the program is missing from the package pyvotess: install it anew by pip")


def main() -> None:
    """Becomes the program, with the arguments of this process."""
    program = str(_program())
    if os.name == "nt":
        raise SystemExit(subprocess.call([program, *sys.argv[1:]]))
    os.execv(program, ["clvotess", *sys.argv[1:]])

"""Runs notebooks, and writes them with their outputs: notebooks.py FOLDER TARGET"""

from __future__ import annotations

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient


def main() -> None:
    folder, target = map(Path, sys.argv[1:])
    target.mkdir(parents=True, exist_ok=True)
    for file in sorted(folder.glob("*.ipynb")):
        notebook = nbformat.read(file, as_version=4)
        NotebookClient(notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(target)}}).execute()
        nbformat.write(notebook, target / file.name)
        print(f"{file.name}: {sum(cell.cell_type == 'code' for cell in notebook.cells)} cells: ok")


if __name__ == "__main__":
    main()

#!/usr/bin/env bash
# OVITO multiplies each value of a Gaussian cube file by 6.75, as if it were a density; ASE and pymatgen refuse files in angstrom.
#
# Surprise: ASE writes an electrostatic potential of 1 everywhere. ASE and pymatgen read 1, OVITO 6.7483, which is 1 / bohr^3 per
#   angstrom^3. That is the unit of an electron density. Potentials, orbitals, ELF and spin ratios are multiplied alike, so an
#   isosurface at a level from the literature lies elsewhere. Its manual speaks of lengths alone. The same file in angstrom, which
#   negative numbers of voxels mark, keeps its values in OVITO. ASE and pymatgen end in a ValueError about shapes there.
# Versions: OVITO 3.17.2, ASE 3.29.0, pymatgen 2026.10.24
# Seen: 2026-11
# Do: divide by 6.7483345 in OVITO unless the file holds a density. Write files in bohr for ASE and pymatgen.
# Source: Gaussian manual, utility cubegen: values "in atomic units"; a negative number of voxels means angstrom. OVITO manual,
#   "Gaussian Cube file reader".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ovito==3.17.2 ase==3.29.0 pymatgen==2026.10.24 numpy==2.4.6
export QT_QPA_PLATFORM=offscreen

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
from ase import Atoms
from ase.io.cube import read_cube, write_cube
from ase.units import Bohr
from ovito.io import import_file
from pymatgen.io.common import VolumetricData

print({name: version(name) for name in ("ovito", "ase", "pymatgen")})
cell = np.diag([4., 3., 2.])
with open("bohr.cube", "w") as file:
    write_cube(file, Atoms("H", [[0, .5, .5]], cell=cell, pbc=True), np.ones((4, 3, 2)), comment="electrostatic potential")
lines = open("bohr.cube").read().split("\n")
for line in range(2, 7):  # origin, voxels, atom: the last three numbers are lengths
    words = lines[line].split()
    lengths = " ".join(f"{float(word) * Bohr:.6f}" for word in words[-3:])
    lines[line] = " ".join(["-" + words[0] if 2 < line < 6 else words[0], *words[1:-3], lengths])
with open("angstrom.cube", "w") as file:
    file.write("\n".join(lines))


def by_ase(name):
    with open(name) as file:
        read = read_cube(file)
    return read["atoms"].cell[:], read["data"]


def by_pymatgen(name):
    read = VolumetricData.from_cube(name)
    return read.structure.lattice.matrix, read.data["total"]


def by_ovito(name):
    read = import_file(name).compute()
    grid = next(iter(read.grids.values()))
    return np.array(read.cell)[:, :3].T, np.array(grid[next(iter(grid.keys()))])


changed = False
for name, stated in (("bohr.cube", {"ASE": 1, "pymatgen": 1, "OVITO": 1 / Bohr**3}),
                     ("angstrom.cube", {"ASE": None, "pymatgen": None, "OVITO": 1})):
    for reader, read in (("ASE", by_ase), ("pymatgen", by_pymatgen), ("OVITO", by_ovito)):
        try:
            edges, values = read(name)
        except ValueError as error:
            same = stated[reader] is None
            print(f"{name} by {reader}: ValueError: {error}", "" if same else "CHANGED")
        else:
            same = stated[reader] is not None and np.allclose(values, stated[reader], rtol=1e-5) and np.allclose(edges, cell, atol=1e-4)
            print(f"{name} by {reader}: values {values.min():.4f} to {values.max():.4f}, edges {edges.diagonal().round(3)}",
                  "" if same else "CHANGED")
        changed |= not same
sys.exit(bool(changed))
EOF

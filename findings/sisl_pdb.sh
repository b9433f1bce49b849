#!/usr/bin/env bash
# Atoms of a PDB file of sisl all lie at the origin in ASE, and their cell is shrunk in gemmi.
#
# Surprise: sisl writes a crystal of two atoms as .pdb, and MDAnalysis reads both at their places. sisl writes the record ORIGX as
#   zeros, where the format has the transformation to the submitted coordinates. ASE applies it: both atoms lie at 0, without a
#   warning. sisl writes the edges of the cell as SCALE, where the format has the inverse, which leads to fractional coordinates.
#   gemmi takes matrices that differ from CRYST1 for deliberate: the lattice vector of 4 A becomes 0.25 A, and so images lie
#   among the atoms. sisl reads its own file back right.
# Versions: sisl 0.20.0, ASE 3.29.0, gemmi 0.7.5, MDAnalysis 2.11.0
# Seen: 2026-11
# Do: write such structures by sisl as .xsf or POSCAR, or remove the lines ORIGX and SCALE from the file.
# Source: PDB format 3.3, "Crystallographic and Coordinate Transformation Section": ORIGXn, and SCALEn, which transforms orthogonal
#   coordinates to fractional ones.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet sisl==0.20.0 ase==3.29.0 gemmi==0.7.5 MDAnalysis==2.11.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.io
import gemmi
import MDAnalysis
import numpy as np
import sisl

print({name: version(name) for name in ("sisl", "ase", "gemmi", "MDAnalysis")})
edges = np.array([[4, 0, 0], [.5, 3.5, 0], [.3, .4, 3]])  # as CRYST1 orients a cell: a along x, b in the plane of x and y
points = np.array([[.1, .2, .3], [1, 2, 1.5]])
sisl.Geometry(points, ["Si", "O"], lattice=sisl.Lattice(edges)).write("crystal.pdb")
with open("crystal.pdb") as file:
    lines = file.readlines()
print("".join(line for line in lines if line[:5] in ("CRYST", "SCALE", "ORIGX")), end="")
with open("without.pdb", "w") as file:
    file.writelines(line for line in lines if line[:5] not in ("SCALE", "ORIGX"))


def by_ase(name):
    atoms = ase.io.read(name)
    return atoms.positions, atoms.cell[0]


def by_gemmi(name):
    structure = gemmi.read_structure(name)
    return np.array([list(site.atom.pos) for site in structure[0].all()]), list(structure.cell.orthogonalize(gemmi.Fractional(1, 0, 0)))


def by_mdanalysis(name):
    atoms = MDAnalysis.Universe(name).atoms
    return atoms.positions.astype(float), MDAnalysis.lib.mdamath.triclinic_vectors(atoms.dimensions)[0]


def by_sisl(name):
    read = sisl.get_sile(name).read_geometry()
    return read.xyz, read.cell[0]


changed = False
right = points, edges[0]
readers = {"ASE": by_ase, "gemmi": by_gemmi, "MDAnalysis": by_mdanalysis, "sisl": by_sisl}
wrong = {"ASE": (0 * points, edges[0]), "gemmi": (points, [.25, -.036, -.02])}
for name, stated in (("crystal.pdb", {**wrong, "MDAnalysis": right, "sisl": right}),
                     ("without.pdb", dict.fromkeys(("ASE", "gemmi", "MDAnalysis"), right))):
    for reader, expected in stated.items():
        places, edge = readers[reader](name)
        same = np.allclose(places, expected[0], atol=1e-3) and np.allclose(edge, expected[1], atol=1e-3)
        changed |= not same
        print(f"{name} by {reader}: atoms at {np.round(places, 3).tolist()}, first edge {np.round(edge, 3).tolist()}",
              "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

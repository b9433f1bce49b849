#!/usr/bin/env bash
# Open Babel turns the cell and leaves the atoms when it writes PDB: copper from a POSCAR has neighbors at 0.44 angstrom.
#
# Surprise: a POSCAR states three edges in any orientation, and primitive cells of cubic metals are written so. Open Babel writes
#   lengths and angles as CRYST1 and the coordinates as they were, without SCALE records. Readers lay the first edge along x, so
#   the lattice is another one. Nearest neighbors of copper, silicon and iron lie at 0.44, 1.49 and 0.83 angstrom for 2.55, 2.35
#   and 2.49. Volume, lengths and angles are right, and nothing warns. ASE, gemmi and Open Babel itself read the file so. The
#   same holds for .xsf and FHI-aims files. Its .cif of the same input is right, and so is .pdb if the first edge lies along x.
# Versions: Open Babel 3.1.1.23 (wheel), ASE 3.29.0, gemmi 0.7.5
# Seen: 2026-11
# Do: convert to .cif first and from there to .pdb, or let ASE write the PDB.
# Source: wwPDB, "PDB file format" 3.30, CRYST1 and SCALEn: without SCALE the axes are a along x, b in the plane of x and y.
#   VASP wiki, POSCAR: lattice vectors by their components. Open Babel manual, "Protein Data Bank format" and "VASP format".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet openbabel-wheel==3.1.1.23 ase==3.29.0 gemmi==0.7.5 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gemmi
import numpy as np
from ase import Atoms
from ase.build import bulk
from ase.io import read, write
from ase.neighborlist import neighbor_list
from openbabel import openbabel, pybel

print({name: version(name) for name in ("openbabel-wheel", "ase", "gemmi")})
openbabel.obErrorLog.SetOutputLevel(1)


def nearest(atoms):
    return neighbor_list("d", atoms, 5.).min()


def by_gemmi(path):
    structure = gemmi.read_pdb(path)
    cell = structure.cell
    at = [cell.fractionalize(atom.atom.pos).tolist() for atom in structure[0].all()]
    return Atoms(len(at) * ["X"], scaled_positions=at, cell=cell.parameters, pbc=True)


def by_babel(path):
    molecule = next(pybel.readfile("pdb", path))
    rows = openbabel.toUnitCell(molecule.OBMol.GetData(openbabel.UnitCell)).GetCellVectors()
    return Atoms(len(molecule.atoms) * ["X"], [atom.coords for atom in molecule.atoms],
                 cell=[[row.GetX(), row.GetY(), row.GetZ()] for row in rows], pbc=True)


turned = bulk("Fe", cubic=True) * (2, 2, 2)
turned.rotate(40, (1, 2, 3), rotate_cell=True)
changed = False
for name, crystal, stated in (("Cu", bulk("Cu") * (3, 3, 3), .438), ("Si", bulk("Si") * (2, 2, 2), 1.489), ("Fe", bulk("Fe") * (3, 3, 3), .827),
                              ("Fe turned", turned, .995), ("Mg", bulk("Mg") * (3, 3, 2), None)):
    right = nearest(crystal)
    write("POSCAR", crystal)
    write("a.xsf", crystal)
    write("a.in", crystal, format="aims")
    next(pybel.readfile("vasp", "POSCAR")).write("cif", "a.cif", overwrite=True)
    by_cif = nearest(read("a.cif"))
    for kind, path in (("vasp", "POSCAR"), ("axsf", "a.xsf"), ("fhiaims", "a.in")):
        next(pybel.readfile(kind, path)).write("pdb", "a.pdb", overwrite=True)
        records = {line.split()[0] for line in open("a.pdb")}
        atoms = read("a.pdb")
        found = nearest(atoms), nearest(by_gemmi("a.pdb")), nearest(by_babel("a.pdb"))
        same = abs(by_cif - right) < .01 and np.allclose(found, right if stated is None else stated, atol=.02) and "SCALE1" not in records and \
            abs(atoms.cell.volume / crystal.cell.volume - 1) < .01
        changed |= not same
        print(f"{name}, {path}: nearest neighbor at {right:.3f}, by .cif {by_cif:.3f}; by .pdb read by ASE {found[0]:.3f}, gemmi {found[1]:.3f}, "
              f"Open Babel {found[2]:.3f}; volume {atoms.cell.volume:.2f} for {crystal.cell.volume:.2f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

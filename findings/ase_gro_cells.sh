#!/usr/bin/env bash
# ASE writes cells of any orientation in .gro, which GROMACS forbids: readers have another lattice, or a cell of volume 0.
#
# Surprise: GROMACS puts the first edge along x and the second into the plane of x and y. ASE writes the edges as they are:
#   primitive cells of copper and iron, a cell with turned axes. MDAnalysis and MDTraj take the lengths and angles of the edges
#   and leave the positions where they are: distances between neighbors across the boundary are wrong. chemfiles drops the
#   numbers that GROMACS wants to be 0: volumes 0 and 210 for 318 and 244. ASE itself reads the nine numbers.
# Versions: ASE 3.29.0, MDAnalysis 2.11.0, MDTraj 1.11.1, chemfiles 0.10.4
# Seen: 2026-11
# Do: turn the atoms before they are written: atoms.set_cell(atoms.cell.standard_form()[0], scale_atoms=True).
# Source: GROMACS manual, "File formats", gro: "GROMACS only supports boxes with v1(y)=v1(z)=v2(z)=0".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ase==3.29.0 MDAnalysis==2.11.0 mdtraj==1.11.1.post2 chemfiles==0.10.4 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import chemfiles
import MDAnalysis
import mdtraj
import numpy as np
from ase import Atoms
from ase.build import bulk
from ase.io import read, write
from ase.neighborlist import neighbor_list

chemfiles.set_warnings_callback(lambda message: None)
print({name: version(name) for name in ("ase", "MDAnalysis", "mdtraj", "chemfiles")})


def by_ase():
    atoms = read("crystal.gro")
    return atoms.cell[:], atoms.positions


def by_mdanalysis():
    universe = MDAnalysis.Universe("crystal.gro")
    return universe.trajectory.ts.triclinic_dimensions.astype(float), universe.atoms.positions.astype(float)


def by_mdtraj():
    frame = mdtraj.load("crystal.gro")
    return 10. * frame.unitcell_vectors[0], 10. * frame.xyz[0]


def by_chemfiles():
    frame = chemfiles.Trajectory("crystal.gro").read()
    return np.array(frame.cell.matrix).T, np.array(frame.positions)


def neighbors(cell, positions):  # distances up to 4 angstrom in the crystal, or nothing where the cell has no volume
    if abs(np.linalg.det(cell)) < 1e-6:
        return np.empty(0)
    return np.sort(neighbor_list("d", Atoms(f"Cu{len(positions)}", positions, cell=cell, pbc=True), 4.))


copper = bulk("Cu") * 3
turned = Atoms("Cu8", cell=[[5, 2, 1], [-1, 6, 2], [1, -2, 7]], pbc=True, scaled_positions=np.random.default_rng(1).random((8, 3)))
changed = False
for name, atoms, right_readers, drops in (("copper", copper, ["ase"], 0), ("turned axes", turned, ["ase"], 210),
                                          ("turned axes, in standard form", turned, ["ase", "mdanalysis", "mdtraj", "chemfiles"], 244)):
    atoms = atoms.copy()
    if "standard" in name:
        atoms.set_cell(atoms.cell.standard_form()[0], scale_atoms=True)
    write("crystal.gro", atoms)
    right = neighbors(atoms.cell[:], atoms.positions)
    agree, volumes = [], {}
    for reader in (by_ase, by_mdanalysis, by_mdtraj, by_chemfiles):
        cell, positions = reader()
        found = neighbors(cell, positions)
        tool = reader.__name__[3:]
        volumes[tool] = round(abs(np.linalg.det(cell)))
        if len(found) == len(right) and abs(found - right).max() < .02:
            agree.append(tool)
    same = agree == right_readers and volumes["chemfiles"] == drops
    changed |= not same
    print(f"{name}: volume {atoms.get_volume():.0f}, read as {volumes}; same distances between neighbors: {agree}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

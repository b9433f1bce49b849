#!/usr/bin/env bash
# A crystal whose cell is left-handed becomes its mirror image in files of ASE and pymatgen, without a word.
#
# Surprise: swapping two edges of a cell changes no atom of quartz, only the sign of the determinant. Written as CIF or as
#   LAMMPS data by ASE, or as CIF by pymatgen, it comes back as the other enantiomorph. pymatgen's POSCAR is the mirror image
#   with direct coordinates, which are the default, and the right crystal with Cartesian ones. ASE's POSCAR, PDB and extended
#   XYZ are right. Volumes, distances and neighbors are equal in both crystals, so no check of those sees it.
# Versions: ASE 3.29.0, pymatgen-core 2026.10.16
# Seen: 2026-11
# Do: before writing, look at the sign of the determinant, and swap two edges together with their fractions (set the cell,
#   keep the positions).
# Source: International Tables for Crystallography, volume A, section 1.5.1: cell lengths and angles, as in CIF, refer to a
#   right-handed basis. VASP manual, "POSCAR": direct coordinates are multiples of the written edges. LAMMPS manual, "Howto
#   triclinic": edges must be right-handed; swap two of them otherwise.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ase==3.29.0 pymatgen-core==2026.10.16 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import itertools
import sys
from importlib.metadata import version

import ase.io
import numpy as np
from ase.neighborlist import neighbor_list
from ase.spacegroup import crystal
from pymatgen.core import Structure
from pymatgen.io.ase import AseAtomsAdaptor
from pymatgen.io.vasp import Poscar

print({name: version(name) for name in ("ase", "pymatgen-core")})


def handedness(atoms):  # a sum over triples of near neighbors that changes its sign in a mirror
    atoms = atoms.copy()
    atoms.pbc = True
    first, vectors, lengths = neighbor_list("iDd", atoms, 4.)
    total = 0
    for k in range(len(atoms)):
        near = np.argsort(lengths[first == k])[:6]
        for triple in itertools.combinations(vectors[first == k][near], 3):
            x, y, z = np.linalg.norm(triple, axis=1)
            total += np.linalg.det(triple) * (x - y) * (y - z) * (z - x)
    return total


places = [(.4697, 0, 1 / 3), (.4133, .2672, .2144)]
right = crystal(["Si", "O"], places, spacegroup=152, cellpar=[4.916, 4.916, 5.405, 90, 90, 120])
left = right.copy()
left.set_cell(right.cell[[1, 0, 2]])  # the same lattice and positions
sign = handedness(right)
changed = abs(sign) < .1 or not np.isclose(handedness(left), sign) or np.linalg.det(left.cell) > 0


def check(way, atoms, mirrored):
    global changed
    seen = handedness(atoms) / sign
    same = len(atoms) == 9 and np.isclose(seen, -1 if mirrored else 1, atol=.1)
    changed |= not same
    print(f"{way:34} {'mirror image' if seen < 0 else 'same crystal'}, {len(atoms)} atoms", "" if same else "CHANGED")


def by_ase(atoms, name, form, **how):
    ase.io.write(name, atoms, format=form, **how)
    return ase.io.read(name, format=form, **({"atom_style": "atomic"} if form == "lammps-data" else {}))


def by_pymatgen(atoms, **how):
    structure = AseAtomsAdaptor.get_structure(atoms)
    if not how:
        return AseAtomsAdaptor.get_atoms(Structure.from_str(structure.to(fmt="cif"), fmt="cif"))
    with open("poscar", "w") as file:
        file.write(Poscar(structure).get_str(**how))
    return ase.io.read("poscar", format="vasp")


for name, atoms in (("right", right), ("left", left)):
    wrong = name == "left"
    check(f"{name}, ASE, CIF", by_ase(atoms, "a.cif", "cif"), wrong)
    check(f"{name}, ASE, LAMMPS data", by_ase(atoms, "a.data", "lammps-data", specorder=["Si", "O"]), wrong)
    check(f"{name}, ASE, POSCAR", by_ase(atoms, "poscar", "vasp"), False)
    check(f"{name}, ASE, PDB", by_ase(atoms, "a.pdb", "proteindatabank"), False)
    check(f"{name}, ASE, extended XYZ", by_ase(atoms, "a.xyz", "extxyz"), False)
    check(f"{name}, pymatgen, CIF", by_pymatgen(atoms), wrong)
    check(f"{name}, pymatgen, POSCAR direct", by_pymatgen(atoms, direct=True), wrong)
    check(f"{name}, pymatgen, POSCAR Cartesian", by_pymatgen(atoms, direct=False), False)
sys.exit(bool(changed))
EOF

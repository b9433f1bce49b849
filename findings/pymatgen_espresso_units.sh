#!/usr/bin/env bash
# pymatgen takes bohr of Quantum ESPRESSO inputs for angstrom, and skips atoms whose coordinates are integers.
#
# Surprise: phonopy writes supercells for Quantum ESPRESSO in bohr. pymatgen's PWInput ignores the unit behind CELL_PARAMETERS:
#   cells are 6.75 times too large, and silicon has its neighbors at 4.44 angstrom for 2.35. Under "alat" the cell has a volume
#   of 0.25. Positions in bohr or alat are read as fractions of the cell. A line "Si 0 0 0" is dropped, so one of two atoms
#   is left. ASE and phonopy read all of these right. pymatgen is right for angstrom with positions "angstrom" or "crystal".
# Versions: pymatgen 2026.10.24, phonopy 4.10.0, ASE 3.29.0
# Seen: 2026-11
# Do: read the file by ASE and convert it by pymatgen.io.ase.AseAtomsAdaptor.
# Source: Quantum ESPRESSO, INPUT_PW: CELL_PARAMETERS { alat | bohr | angstrom }, ATOMIC_POSITIONS { alat | bohr | angstrom |
#   crystal }. pymatgen manual, io.pwscf.PWInput.from_file. phonopy manual, "Quantum ESPRESSO (QE) interface".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pymatgen==2026.10.24 phonopy==4.10.0 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
from ase import Atoms
from ase.build import bulk
from ase.io import read
from ase.neighborlist import neighbor_list
from phonopy.interface.calculator import read_crystal_structure, write_crystal_structure
from phonopy.structure.atoms import PhonopyAtoms
from pymatgen.io.pwscf import PWInput

print({name: version(name) for name in ("pymatgen", "phonopy", "ase")})
bohr, a = .529177210903, 5.43
silicon = bulk("Si", a=a)
units = {"angstrom": 1, "bohr": 1 / bohr, "alat": 1 / a}


def header(more=""):
    return f"&CONTROL\n calculation = 'scf'\n/\n&SYSTEM\n ibrav = 0, nat = 2, ntyp = 1, ecutwfc = 20{more}\n/\n&ELECTRONS\n/\n"


def text(cell, positions, integers=False):
    """Returns an input of silicon with the units of its cell and of its positions."""
    at = silicon.get_scaled_positions() if positions == "crystal" else silicon.positions * units[positions]
    lines = ["ATOMIC_SPECIES", "Si 28.085 Si.UPF", f"CELL_PARAMETERS {cell}", *("%.10f %.10f %.10f" % tuple(row) for row in silicon.cell * units[cell]),
             f"ATOMIC_POSITIONS {positions}", *(("Si 0 0 0" if integers and not row.any() else "Si %.10f %.10f %.10f" % tuple(row)) for row in at)]
    return header(f", celldm(1) = {a / bohr:.10f}" if cell == "alat" else "") + "\n".join(lines) + "\nK_POINTS gamma\n"


def measures(atoms):
    return len(atoms), atoms.cell.volume, neighbor_list("d", atoms, 9.).min()


write_crystal_structure("cards", PhonopyAtoms(symbols=["Si"] * 2, cell=silicon.cell / bohr, scaled_positions=silicon.get_scaled_positions()), interface_mode="qe")
inputs = [("phonopy's", header() + "".join(line for line in open("cards") if line[0] != "!") + "\nK_POINTS gamma\n", (2, 270.107, 4.443))]
for cell, positions, integers, stated in (("angstrom", "crystal", False, (2, 40.026, 2.351)), ("angstrom", "angstrom", False, (2, 40.026, 2.351)),
                                          ("bohr", "crystal", False, (2, 270.107, 4.443)), ("bohr", "bohr", False, (2, 270.107, 4.56)),
                                          ("angstrom", "bohr", False, (2, 40.026, 2.413)), ("alat", "crystal", False, (2, .25, .433)),
                                          ("angstrom", "crystal", True, (1, 40.026, 3.84))):
    inputs.append((f"{cell}, {positions}" + ", Si 0 0 0" * integers, text(cell, positions, integers), stated))
changed = False
for name, content, stated in inputs:
    with open("si.in", "w") as file:
        file.write(content)
    by_ase = measures(read("si.in", format="espresso-in"))
    cell = read_crystal_structure("si.in", interface_mode="qe")[0]
    by_phonopy = measures(Atoms("Si2", scaled_positions=cell.scaled_positions, cell=cell.cell * bohr, pbc=True))
    structure = PWInput.from_file("si.in").structure
    by_pymatgen = measures(Atoms(["Si"] * len(structure), structure.cart_coords, cell=structure.lattice.matrix, pbc=True))
    right = measures(silicon)
    same = np.allclose(by_ase, right, rtol=1e-3) and np.allclose(by_phonopy, right, rtol=1e-3) and np.allclose(by_pymatgen, stated, rtol=1e-3)
    changed |= not same
    print(f"{name}: atoms, volume, nearest neighbor by ASE {by_ase[0]}, {by_ase[1]:.3f}, {by_ase[2]:.3f}, phonopy {by_phonopy[0]}, "
          f"{by_phonopy[1]:.3f}, {by_phonopy[2]:.3f}, pymatgen {by_pymatgen[0]}, {by_pymatgen[1]:.3f}, {by_pymatgen[2]:.3f}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

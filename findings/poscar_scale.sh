#!/usr/bin/env bash
# The scale in the second line of a POSCAR moves atoms in pymatgen and makes another cell in OVITO, without a message.
#
# Surprise: a negative scale states the volume of the cell. pymatgen makes the right cell from it, and multiplies Cartesian
#   positions by the volume: a structure of volume 960 has an atom moved by -960 times its coordinates. Three numbers scale x, y
#   and z. OVITO takes the first for all three: 120 for 720. Direct positions with one number, of either sign, are right in
#   pymatgen. OVITO refuses negative ones, pymatgen and dpdata refuse three, with messages. ASE reads all of them.
# Versions: ASE 3.29.0, pymatgen-core 2026.10.16, OVITO 3.17.2, dpdata 1.1.0
# Seen: 2026-11
# Do: rewrite such files by ASE first, which writes a scale of 1.
# Source: VASP manual, "POSCAR", full format specification, "Scaling factor(s)": one or three numbers; a negative one is the
#   desired volume, from which the factor for edges and Cartesian positions is computed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ase==3.29.0 pymatgen-core==2026.10.16 ovito==3.17.2 dpdata==1.1.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.io
import dpdata
import numpy as np
from ase import Atoms
from ovito.io import import_file
from pymatgen.core import Structure

print({name: version(name) for name in ("ase", "pymatgen-core", "ovito", "dpdata")})
atoms = Atoms("SiO", scaled_positions=[[0, 0, 0], [.25, .5, .75]], cell=[[4, 0, 0], [1, 5, 0], [0, 0, 6]], pbc=True)


def by_ase():
    read = ase.io.read("POSCAR", format="vasp")
    return read.cell.volume, read.positions[1]


def by_pymatgen():
    read = Structure.from_file("POSCAR")
    return read.volume, read.cart_coords[1]


def by_ovito():
    read = import_file("POSCAR").compute()
    return read.cell.volume, read.particles.positions[1] - read.cell[:, 3]


def by_dpdata():
    read = dpdata.System("POSCAR", fmt="vasp/poscar")
    return np.linalg.det(read["cells"][0]), read["coords"][0][1]


right = {"1": (120, [1.5, 2.5, 4.5]), "2": (960, [3, 5, 9]), "-960": (960, [3, 5, 9]), "1 2 3": (720, [1.5, 5, 13.5])}
stated = {  # None: refused
    ("pymatgen", "-960", False): (960, [-1440, -2400, -4320]),
    ("pymatgen", "1 2 3", True): None,
    ("pymatgen", "1 2 3", False): None,
    ("OVITO", "-960", True): None,
    ("OVITO", "-960", False): None,
    ("OVITO", "1 2 3", True): (120, [1.5, 2.5, 4.5]),
    ("OVITO", "1 2 3", False): (120, [1.5, 2.5, 4.5]),
    ("dpdata", "1 2 3", True): None,
    ("dpdata", "1 2 3", False): None,
}
changed = False
for scale, wanted in right.items():
    for direct in (True, False):
        ase.io.write("POSCAR", atoms, format="vasp", direct=direct)
        lines = open("POSCAR").read().splitlines()
        lines[1] = scale
        with open("POSCAR", "w") as file:
            file.write("\n".join(lines) + "\n")
        for name, read in (("ASE", by_ase), ("pymatgen", by_pymatgen), ("OVITO", by_ovito), ("dpdata", by_dpdata)):
            expected = stated.get((name, scale, direct), wanted)
            try:
                volume, place = read()
                what = f"volume {volume:5.0f}, second atom at {np.round(place, 3).tolist()}"
                same = expected is not None and np.allclose(volume, expected[0]) and np.allclose(place, expected[1])
            except (ValueError, RuntimeError) as error:
                what, same = f"refused: {type(error).__name__}", expected is None
            changed |= not same
            print(f"scale {scale:5} {'direct' if direct else 'Cartesian':9} {name:8} {what}",
                  "wrong" if same and expected is not None and expected != wanted else "", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

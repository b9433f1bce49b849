#!/usr/bin/env bash
# ASE takes the empty cell of a PDB file for a crystal with a period of 1 angstrom.
#
# Surprise: a PDB file must have a CRYST1 line, and a structure without a lattice has 1 1 1 90 90 90 there. MDAnalysis writes
#   it so. MDAnalysis and gemmi read no lattice from it. ASE makes a cubic cell of 1 angstrom, periodic along all axes.
#   Distances by the minimum image are below 0.87 then, each atom is its own neighbor, and the extended XYZ that ASE writes
#   hands the lattice on.
# Versions: MDAnalysis 2.11.0, ASE 3.29.0, gemmi 0.7.5
# Seen: 2026-11
# Do: after reading, if the cell is 1 1 1: atoms.cell = None; atoms.pbc = False.
# Source: PDB format 3.3, section 8, CRYST1: "unitary values" where the structure was not determined by crystallography, with
#   the remark 285.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet MDAnalysis==2.11.0 ase==3.29.0 gemmi==0.7.5 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.io
import gemmi
import MDAnalysis
import numpy as np
from ase.neighborlist import neighbor_list

print({name: version(name) for name in ("MDAnalysis", "ase", "gemmi")})
count = 20
universe = MDAnalysis.Universe.empty(count, atom_resindex=range(count), n_residues=count, residue_segindex=[0] * count,
                                     trajectory=True)
for name, values in (("names", ["CA"] * count), ("elements", ["C"] * count), ("resnames", ["ALA"] * count),
                     ("resids", range(1, count + 1)), ("chainIDs", ["A"] * count)):
    universe.add_TopologyAttr(name, list(values))
places = np.round(np.random.default_rng(1).random((count, 3)) * 30, 3)
universe.atoms.positions = places
universe.atoms.write("chain.pdb")
print("MDAnalysis wrote:", next(line.strip() for line in open("chain.pdb") if line.startswith("CRYST1")))

changed = False


def check(text, seen, stated):
    global changed
    changed |= seen != stated
    print(f"{text}: {seen}", "" if seen == stated else f"CHANGED, was {stated}")


check("MDAnalysis, dimensions", MDAnalysis.Universe("chain.pdb").dimensions, None)
check("gemmi, is_crystal()", gemmi.read_structure("chain.pdb").cell.is_crystal(), False)
atoms = ase.io.read("chain.pdb")
check("ASE, positions", bool(np.allclose(atoms.positions, places, atol=1e-3)), True)
check("ASE, lengths and periodic axes", (atoms.cell.lengths().tolist(), atoms.pbc.tolist()), ([1, 1, 1], [True] * 3))
check("ASE, largest distance by the minimum image is below 0.87", bool(atoms.get_all_distances(mic=True).max() < .87), True)
check("ASE, neighbors within 1.2 of the first atom are itself", bool((neighbor_list("ij", atoms, 1.2)[0] == 0).sum() > 6), True)
atoms.write("chain.xyz", format="extxyz")
check("ASE, extended XYZ has a lattice", 'Lattice="1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0"' in open("chain.xyz").read(), True)
sys.exit(bool(changed))
EOF

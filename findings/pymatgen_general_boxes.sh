#!/usr/bin/env bash
# pymatgen reads every box that OVITO wrote for LAMMPS as a cube of 1 angstrom, or with negative edges, without a message.
#
# Surprise: LAMMPS files may state the edges of a box in any orientation, as avec, bvec, cvec in data files and as "abc
#   origin" in dumps. OVITO does so by default, also for a cubic box. OVITO and ASE read the edges back. pymatgen gives a cube
#   of volume 1 for a data file, and edges of length 0 and below for a dump.
# Versions: OVITO 3.17.2, ASE 3.29.0, pymatgen-core 2026.10.16
# Seen: 2026-11
# Do: export with restricted_triclinic=True, or read by ASE or OVITO.
# Source: LAMMPS manual, "read_data command" (avec, bvec, cvec, abc origin), "dump command" (BOX BOUNDS abc origin), "Howto
#   triclinic" (general triclinic boxes).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ovito==3.17.2 ase==3.29.0 pymatgen-core==2026.10.16 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.build
import ase.io
import numpy as np
from ovito.io import export_file, import_file
from ovito.io.ase import ase_to_ovito
from ovito.pipeline import Pipeline, StaticSource
from pymatgen.io.lammps.data import LammpsData
from pymatgen.io.lammps.outputs import parse_lammps_dumps

print({name: version(name) for name in ("ovito", "ase", "pymatgen-core")})
primitive, cubic = ase.build.bulk("Cu", a=3.6), ase.build.bulk("Cu", a=3.6, cubic=True)
columns = ["Particle Identifier", "Particle Type", "Position.X", "Position.Y", "Position.Z"]
changed = False
cases = (("primitive", primitive, {}), ("cubic", cubic, {}), ("cubic, restricted", cubic, {"restricted_triclinic": True}))
for name, atoms, how in cases:
    pipeline = Pipeline(source=StaticSource(data=ase_to_ovito(atoms)))
    export_file(pipeline, "box.dump", "lammps/dump", columns=columns, **how)
    export_file(pipeline, "box.data", "lammps/data", atom_style="atomic", **how)
    print("".join(open("box.dump").readlines()[4:8]), end="")
    seen = {
        "dump, OVITO": import_file("box.dump").compute().cell[:, :3].T,
        "dump, ASE": ase.io.read("box.dump", format="lammps-dump-text").cell[:],
        "dump, pymatgen": next(parse_lammps_dumps("box.dump")).box.to_lattice().matrix,
        "data, OVITO": import_file("box.data").compute().cell[:, :3].T,
        "data, ASE": ase.io.read("box.data", format="lammps-data", atom_style="atomic").cell[:],
        "data, pymatgen": LammpsData.from_file("box.data", atom_style="atomic").structure.lattice.matrix,
    }
    for way, edges in seen.items():
        right = np.allclose(edges, atoms.cell[:], atol=1e-4)
        same = right == (bool(how) or "pymatgen" not in way)
        if not right:
            same &= np.allclose(edges, np.eye(3)) if "data" in way else np.min(edges) < 0
        changed |= not same
        text = "right" if right else "wrong: " + str(np.asarray(edges).tolist())
        print(f"{name}, {way}: the edges are {text}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

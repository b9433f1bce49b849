#!/usr/bin/env bash
# pymatgen writes the first cell of an XDATCAR for all frames: a run at constant pressure becomes one at constant volume.
#
# Surprise: VASP repeats the header before each frame when the cell changes. pymatgen's Xdatcar reads that right, and so do ASE and
#   OVITO. Xdatcar.write_file, and its get_str, write the header once, with the cell of the first frame. The fractional positions
#   are scaled with it. Copper that grows from 3.6 to 4.32 angstrom keeps 3.6: neighbors stay at 2.55 instead of 3.05, the last
#   volume is 46.7 instead of 80.6. Nothing warns. pymatgen's own Trajectory.write_Xdatcar keeps the cells, but
#   ASE refuses its file, for symbols follow the positions.
# Versions: pymatgen 2026.10.24, ASE 3.29.0, OVITO 3.17.2
# Seen: 2026-12
# Do: ase.io.write("XDATCAR", [each.to_ase_atoms() for each in structures], format="vasp-xdatcar").
# Source: VASP manual, XDATCAR (a new header for each cell when the cell changes). pymatgen 2026.10.24, docstrings of
#   pymatgen.io.vasp.outputs.Xdatcar: write_file, "Write Xdatcar class into a file", and get_str, which name no fixed cell.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pymatgen==2026.10.24 ase==3.29.0 ovito==3.17.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import os
import sys
from importlib.metadata import version

import ase.build
import ase.io
import numpy as np
from ovito.io import import_file
from ovito.io.ase import ovito_to_ase
from pymatgen.core.trajectory import Trajectory
from pymatgen.io.vasp import Xdatcar

print({name: version(name) for name in ("pymatgen", "ase", "ovito")})
edges = np.array([3.6, 3.96, 4.32])
for name in ("ase", "pymatgen", "trajectory", "through_ase"):
    os.mkdir(name)
ase.io.write("ase/XDATCAR", [ase.build.bulk("Cu", a=edge, cubic=True) for edge in edges], format="vasp-xdatcar")
read = Xdatcar("ase/XDATCAR")
read.write_file("pymatgen/XDATCAR")
Trajectory.from_structures(read.structures, constant_lattice=False).write_Xdatcar("trajectory/XDATCAR")
ase.io.write("through_ase/XDATCAR", [each.to_ase_atoms() for each in read.structures], format="vasp-xdatcar")


def by_pymatgen(name):
    return [(each.volume, each.get_distance(0, 1)) for each in Xdatcar(name).structures]


def by_ase(name):
    return [(each.get_volume(), each.get_distance(0, 1, mic=True)) for each in ase.io.read(name, index=":", format="vasp-xdatcar")]


def by_ovito(name):
    pipeline = import_file(name)
    frames = [ovito_to_ase(pipeline.compute(i)) for i in range(pipeline.num_frames)]
    return [(each.get_volume(), each.get_distance(0, 1, mic=True)) for each in frames]


changed = False
for writer, stated in (("ase", edges), ("pymatgen", np.full(3, 3.6)), ("trajectory", edges), ("through_ase", edges)):
    for reader in (by_pymatgen, by_ase, by_ovito):
        try:
            seen = np.array(reader(f"{writer}/XDATCAR"))
        except ValueError as error:
            same = (writer, reader) == ("trajectory", by_ase)
            changed |= not same
            print(f"written by {writer:11}, read {reader.__name__:11}: {error}", "" if same else "CHANGED")
            continue
        right = seen.shape == (3, 2) and np.allclose(seen, np.c_[stated ** 3, stated / np.sqrt(2)], atol=1e-3)
        same = right and (writer, reader) != ("trajectory", by_ase)
        changed |= not same
        print(f"written by {writer:11}, read {reader.__name__:11}: volumes {seen[:, 0].round(2).tolist()}, neighbors at "
              f"{seen[:, 1].round(3).tolist()}", "" if same else f"CHANGED, edges were {stated.tolist()}")
sys.exit(bool(changed))
EOF

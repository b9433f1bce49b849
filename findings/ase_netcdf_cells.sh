#!/usr/bin/env bash
# ASE writes AMBER NetCDF files in which the atoms lie in another lattice, when the first edge of the cell is not along x.
#
# Surprise: the format holds lengths and angles of the cell. ASE writes them beside the positions as they are. A reader puts
#   the first edge along x and the second into the plane x y, so atoms and lattice no longer fit. Copper of two
#   primitive cells comes back with neighbors at 2.01 instead of 2.26, by ASE itself and by OVITO. The volume is right. ASE
#   turns the positions when it writes a PDB file of the same atoms.
# Versions: ASE 3.29.0, netCDF4 1.7.5.1.post1, OVITO 3.17.2
# Seen: 2026-11
# Do: before writing, turn the atoms: atoms.set_cell(atoms.cell.standard_form()[0], scale_atoms=True), for right-handed cells.
# Source: AMBER NetCDF trajectory convention 1.0, section 2.2.4, cell_lengths and cell_angles (a along x, b in the plane x y).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ase==3.29.0 netCDF4==1.7.5.1.post1 ovito==3.17.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import ase.build
import ase.io
import numpy as np
from ovito.io import import_file
from ovito.io.ase import ovito_to_ase

print({name: version(name) for name in ("ase", "netCDF4", "ovito")})
turned = ase.build.bulk("Cu", a=3.6) * (2, 1, 1)
turned.rattle(.1, seed=1)
straight = turned.copy()
straight.set_cell(turned.cell.standard_form()[0], scale_atoms=True)
changed = False
for name, atoms, by_netcdf in (("edges as ASE builds them", turned, 2.0145), ("edges in standard form", straight, 2.2590)):
    ase.io.write("run.nc", atoms, format="netcdftrajectory")
    ase.io.write("one.pdb", atoms)
    seen = {"written": atoms, "PDB, ASE": ase.io.read("one.pdb"),
            "NetCDF, ASE": ase.io.read("run.nc", format="netcdftrajectory"),
            "NetCDF, OVITO": ovito_to_ase(import_file("run.nc").compute())}
    for way, found in seen.items():
        distance = found.get_distance(0, 1, mic=True)
        stated = by_netcdf if "NetCDF" in way else 2.2590
        same = abs(distance - stated) < 5e-3 and np.isclose(found.get_volume(), 23.328, rtol=1e-3)
        changed |= not same
        print(f"{name}, {way:14} distance {distance:.4f}, volume {found.get_volume():.3f}",
              "" if same else f"CHANGED, was {stated}")
sys.exit(bool(changed))
EOF

#!/usr/bin/env bash
# A tilted box of a GSD file arrives as another lattice in MDAnalysis and in MDTraj.
#
# Surprise: GSD stores the tilt factors xy, xz, yz. MDAnalysis takes them for cosines of the angles and Lx, Ly, Lz for the
#   lengths of the edges: 520 instead of the volume 720. MDTraj transposes the matrix: the volume is right and the edges are
#   others. OVITO and freud read the lattice as written. Without tilt all agree.
# Versions: gsd 5.0.1, MDAnalysis 2.11.0, MDTraj 1.11.1.post2, OVITO 3.17.2, freud 3.4.0
# Seen: 2026-11
# Do: read tilted GSD by gsd.hoomd or OVITO. In MDAnalysis, set dimensions by triclinic_box() of the three edges.
# Source: GSD manual, "HOOMD schema", configuration/box; HOOMD-blue manual, hoomd.Box: a1 = (Lx, 0, 0), a2 = (xy Ly, Ly, 0),
#   a3 = (xz Lz, yz Lz, Lz).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gsd==5.0.1 MDAnalysis==2.11.0 mdtraj==1.11.1.post2 ovito==3.17.2 freud-analysis==3.4.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import freud
import gsd.hoomd
import MDAnalysis
import mdtraj
import numpy as np
from ovito.io import import_file

print({name: version(name) for name in ("gsd", "MDAnalysis", "mdtraj", "ovito", "freud-analysis")})
frame = gsd.hoomd.Frame()
frame.particles.N, frame.particles.types, frame.particles.typeid = 2, ["A"], [0, 0]
frame.particles.position = [[0, 0, 0], [.5, .5, .5]]
frame.configuration.box = [10, 9, 8, .5, .25, -.3]
with gsd.hoomd.open("tilted.gsd", "w") as file:
    file.append(frame)


def shape(edges):
    """Lengths of the edges, and the volume: both are independent of the cell's orientation."""
    edges = np.array(edges, float)
    return np.r_[np.linalg.norm(edges, axis=1), abs(np.linalg.det(edges))]


right = shape([[10, 0, 0], [.5 * 9, 9, 0], [.25 * 8, -.3 * 8, 8]])
seen = {
    "ovito": shape(import_file("tilted.gsd").compute().cell[:, :3].T),
    "freud": shape(freud.locality.NeighborQuery.from_system(frame).box.to_matrix().T),
    "MDAnalysis": shape(MDAnalysis.Universe("tilted.gsd").trajectory.ts.triclinic_dimensions),
    "mdtraj": shape(mdtraj.load("tilted.gsd").unitcell_vectors[0]),
}
stated = {"ovito": right, "freud": right, "MDAnalysis": [10, 9, 8, 520.446], "mdtraj": [11.1467, 9.3145, 8, 720]}
changed = False
print("as written", np.round(right, 4))
for reader, found in seen.items():
    same = np.allclose(found, stated[reader], rtol=1e-4)
    changed |= not same
    print(f"{reader:10}", np.round(found, 4), "" if same else f"CHANGED, was {stated[reader]}")
sys.exit(bool(changed))
EOF

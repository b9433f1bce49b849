#!/usr/bin/env bash
# OVITO writes every tilted box into GSD as another lattice, of a larger volume.
#
# Surprise: Ly and Lz of GSD are the extents along y and z. OVITO writes the lengths of the second and third edge there, and
#   divides the tilt factors by them. A box of volume 720 becomes one of 864, the primitive cell of fcc of 432 one of 611. OVITO
#   reads its own file back so. Most Voronoi volumes change. Positions are shifted to the frame of GSD and are right.
#   Boxes without tilt are right, also where OVITO has to turn them.
# Versions: OVITO 3.17.2, gsd 5.0.1, freud 3.4.0
# Seen: 2026-11
# Do: write GSD by gsd.hoomd, with the box from freud.box.Box.from_matrix(); from OVITO export a LAMMPS dump instead.
# Source: GSD manual, "HOOMD schema", configuration/box; HOOMD-blue manual, hoomd.Box: a1 = (Lx, 0, 0), a2 = (xy Ly, Ly, 0),
#   a3 = (xz Lz, yz Lz, Lz). OVITO manual, "GSD/HOOMD file writer".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ovito==3.17.2 gsd==5.0.1 freud-analysis==3.4.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import freud
import gsd.hoomd
import numpy as np
from ovito.data import DataCollection, Particles, SimulationCell
from ovito.io import export_file, import_file
from ovito.modifiers import VoronoiAnalysisModifier
from ovito.pipeline import Pipeline, StaticSource

print({name: version(name) for name in ("ovito", "gsd", "freud-analysis")})
fractions = np.random.default_rng(1).random((100, 3))
changed = False
for name, edges, stated in (("straight", [[10, 0, 0], [0, 9, 0], [0, 0, 8]], 720),
                            ("straight, turned", [[0, 9, 0], [0, 0, 8], [10, 0, 0]], 720),
                            ("tilted", [[10, 0, 0], [4.5, 9, 0], [2, -2.4, 8]], 864.187),
                            ("primitive fcc", [[0, 6, 6], [6, 0, 6], [6, 6, 0]], 610.940)):
    edges = np.array(edges, float)
    data = DataCollection()
    cell = SimulationCell(pbc=(True, True, True))
    cell[...] = np.c_[edges.T, np.zeros(3)]
    data.objects.append(cell)
    particles = Particles()
    particles.create_property("Position", data=fractions @ edges)
    particles.create_property("Particle Type", data=np.zeros(100, int))
    data.objects.append(particles)
    pipeline = Pipeline(source=StaticSource(data=data))
    pipeline.modifiers.append(VoronoiAnalysisModifier())
    right = np.array(pipeline.compute().particles["Atomic Volume"])
    export_file(pipeline, "box.gsd", "gsd/hoomd")
    with gsd.hoomd.open("box.gsd") as file:
        frame = file[0]
    box = freud.box.Box(*frame.configuration.box)
    seen = freud.locality.Voronoi().compute((box, frame.particles.position)).volumes
    back = abs(np.linalg.det(import_file("box.gsd").compute().cell[:, :3]))
    off = np.mean(abs(seen / right - 1) > .01)
    same = np.isclose(box.volume, stated, rtol=1e-5) and np.isclose(back, stated, rtol=1e-5) and \
        (off == 0 if "straight" in name else off > .5)
    changed |= not same
    print(f"{name}: volume {abs(np.linalg.det(edges)):.2f}; box in the file {np.round(frame.configuration.box, 3)}, volume "
          f"{box.volume:.2f}, by OVITO {back:.2f}; {off:.0%} of the cells are off by more than 1 %", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

#!/usr/bin/env bash
# freud's Voronoi cells are periodic along all axes, also where the box that it is given is not.
#
# Surprise: a slab of 100 points, periodic in x and y, has vacuum above it. freud drops the flags of OVITO's cell. A Box has
#   a setter for them, which Voronoi ignores: it lists 1540 entries for 1350, with neighbors across the vacuum at a distance of
#   up to 17. A cluster that is open on all sides gets the same list. OVITO's own Voronoi analysis ends the
#   cells at the open sides. All volumes sum to the box, so a check of the sum passes.
# Versions: freud 3.4.0, OVITO 3.17.2
# Seen: 2026-11
# Do: drop the entries whose vector crosses an open side, and distrust the volumes at the surface.
# Source: freud manual, Box.periodic (the periodicity in each dimension); locality.Voronoi, which states no restriction. OVITO
#   manual, "Voronoi analysis" and "Simulation cell" (a cell that is not periodic ends at its sides).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet freud-analysis==3.4.0 ovito==3.17.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import freud
import numpy as np
from ovito.data import DataCollection, Particles, SimulationCell
from ovito.modifiers import VoronoiAnalysisModifier
from ovito.pipeline import Pipeline, StaticSource

print({name: version(name) for name in ("freud-analysis", "ovito")})
points = np.random.default_rng(1).random((100, 3)) * [10, 10, 4]
sides = np.array([10, 10, 20])


def by_ovito(periodic):
    data = DataCollection()
    cell = SimulationCell(pbc=periodic)
    cell[...] = np.c_[np.diag(sides), np.zeros(3)]
    data.objects.append(cell)
    particles = Particles()
    particles.create_property("Position", data=points)
    data.objects.append(particles)
    pipeline = Pipeline(source=StaticSource(data=data))
    pipeline.modifiers.append(VoronoiAnalysisModifier(generate_bonds=True))
    return pipeline.compute()


changed = False
for periodic, right in (((True, True, True), 1540), ((True, True, False), 1350), ((False, False, False), 1100)):
    data = by_ovito(periodic)
    box = freud.box.Box(*sides)
    box.periodic = periodic
    of_box = freud.locality.Voronoi().compute((box, points - sides / 2))
    of_ovito = freud.locality.Voronoi().compute(data)
    entries = 2 * data.particles.bonds.count
    volumes = np.array(data.particles["Atomic Volume"])
    off = np.mean(abs(of_ovito.volumes / volumes - 1) > .01)
    same = entries == right and len(of_ovito.nlist) == len(of_box.nlist) == 1540 and \
        (off == 0 if all(periodic) else off > .1) and \
        np.isclose(of_ovito.volumes.sum(), 2000, rtol=1e-4) and np.isclose(volumes.sum(), 2000, rtol=1e-4)
    changed |= not same
    print(f"periodic {periodic}: OVITO {entries} entries; freud {len(of_ovito.nlist)} from OVITO, {len(of_box.nlist)} from "
          f"its box, longest {np.linalg.norm(of_box.nlist.vectors, axis=1).max():.1f}; {off:.0%} of the volumes differ by more "
          "than 1 %", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

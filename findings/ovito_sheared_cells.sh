#!/usr/bin/env bash
# OVITO's Voronoi cells and nearest neighbors are wrong in strongly sheared periodic cells.
#
# Surprise: the cells (1, 0, 0), (k, 1, 0), (0, 0, 1) with a whole k describe the same simple cubic lattice: one atom of volume 1
#   with 6 neighbors at the distance 1. For k = 5 the Voronoi analysis gives a volume of 2, for k = 8 one of 15.7. Of 200 random
#   atoms in a cell that is sheared by 8, 6 % have a wrong volume, and the sum exceeds the cell by 0.4 %; for k = 0, the same
#   periodic system, all are right. Such cells come from runs of shear without flips. NearestNeighborFinder gives distances up
#   to 1.414 for the 6 nearest. CutoffNeighborFinder, ASE and freud are right.
# Versions: OVITO 3.17.2, freud 3.4.0, ASE 3.29.0
# Seen: 2026-11
# Do: reduce the cell before the analysis, for example by ase.geometry.minkowski_reduce() and wrapping.
# Source: OVITO manual, "Voronoi analysis" (the cells of a periodic system fill its cell); pages of NearestNeighborFinder (the N
#   nearest neighbors, periodic images among them) and SimulationCell (any three vectors).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ovito==3.17.2 freud-analysis==3.4.0 ase==3.29.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import freud
import numpy as np
from ase import Atoms
from ase.neighborlist import neighbor_list
from ovito.data import CutoffNeighborFinder, DataCollection, NearestNeighborFinder, Particles, SimulationCell
from ovito.modifiers import VoronoiAnalysisModifier
from ovito.pipeline import Pipeline, StaticSource

print({name: version(name) for name in ("ovito", "freud-analysis", "ase")})


def scene(points, edges):
    data = DataCollection()
    cell = SimulationCell(pbc=(True, True, True))
    cell[...] = np.c_[edges.T, np.zeros(3)]
    data.objects.append(cell)
    particles = Particles()
    particles.create_property("Position", data=points)
    data.objects.append(particles)
    return data


def volumes(data):
    pipeline = Pipeline(source=StaticSource(data=data))
    pipeline.modifiers.append(VoronoiAnalysisModifier())
    return np.array(pipeline.compute().particles["Atomic Volume"])


def by_freud(points, edges):
    box = freud.box.Box.from_matrix(edges.T)
    return freud.locality.Voronoi().compute((box, box.wrap(points))).volumes


changed = False
for shear, stated, nearest in ((0, 1, 1), (3, 1, 1), (5, 2, 1.414), (8, 15.661, 1.414)):
    edges, point = np.array([[1., 0, 0], [shear, 1, 0], [0, 0, 1]]), np.array([[.1, .2, .3]])
    data = scene(point, edges)
    volume, right = volumes(data)[0], by_freud(point, edges)[0]
    farthest = max(found.distance for found in NearestNeighborFinder(6, data).find(0))
    within = len(list(CutoffNeighborFinder(1.1, data).find(0)))
    by_ase = len(neighbor_list("i", Atoms("H", positions=point, cell=edges, pbc=True), 1.1))
    same = np.allclose([volume, farthest], [stated, nearest], rtol=1e-3) and abs(right - 1) < 1e-5 and within == by_ase == 6
    changed |= not same
    print(f"one atom, shear {shear}: volume {volume:.3f} by OVITO, {right:.3f} by freud; the 6 nearest are within {farthest:.3f}; "
          f"within 1.1 are {within} by its other finder, {by_ase} by ASE", "" if same else "CHANGED")

fractions = np.random.default_rng(1).random((200, 3))
for shear, stated in ((0, 1), (8, 1.0037)):
    edges = np.array([[10., 0, 0], [10 * shear, 10, 0], [0, 0, 10]])
    points = fractions @ np.diag([10, 10, 10])  # the same atoms for a whole shear
    found, right = volumes(scene(points, edges)), by_freud(points, edges)
    same = abs(found.sum() / 1000 - stated) < 1e-3 and abs(right.sum() / 1000 - 1) < 1e-4
    changed |= not same
    print(f"200 atoms, shear {shear}: the volumes sum to {found.sum() / 1000:.4f} of the cell by OVITO, "
          f"{right.sum() / 1000:.4f} by freud; "
          f"{np.mean(abs(found / right - 1) > .01):.0%} of the volumes differ by more than 1 %", "" if same else "CHANGED")
sys.exit(changed)
EOF

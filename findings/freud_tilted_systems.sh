#!/usr/bin/env bash
# freud computes with another lattice when it takes a tilted system from MDAnalysis or from OVITO.
#
# Surprise: freud accepts MDAnalysis and OVITO objects, and reads a matrix by columns. MDAnalysis has the edges in rows, so
#   freud gets the transposed cell. OVITO's cell can have any orientation, as the primitive cell
#   of fcc has. freud turns the cell to its own frame and leaves the positions. The Voronoi volumes still sum to the volume
#   of the cell, so a check of the sum passes.
# Versions: freud 3.4.0, MDAnalysis 2.11.0, OVITO 3.17.2
# Seen: 2026-11
# Do: pass (box, points): freud.box.Box.from_matrix(edges.T) for rows, and positions turned to the frame of that box:
#   fractions @ box.to_matrix().T.
# Source: freud manual, Box.from_matrix, which follows HOOMD-blue's (columns are lattice vectors; the first lies along x);
#   MDAnalysis manual, Timestep.triclinic_dimensions (rows); OVITO manual, "SimulationCell".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet freud-analysis==3.4.0 MDAnalysis==2.11.0 ovito==3.17.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import freud
import MDAnalysis
import numpy as np
from MDAnalysis.lib.mdamath import triclinic_box
from ovito.data import DataCollection, Particles, SimulationCell
from ovito.modifiers import VoronoiAnalysisModifier
from ovito.pipeline import Pipeline, StaticSource

print({name: version(name) for name in ("freud-analysis", "MDAnalysis", "ovito")})
fractions = np.random.default_rng(1).random((100, 3))


def by_ovito(edges):
    data = DataCollection()
    cell = SimulationCell(pbc=(True, True, True))
    cell[...] = np.c_[edges.T, np.zeros(3)]
    data.objects.append(cell)
    particles = Particles()
    particles.create_property("Position", data=fractions @ edges)
    data.objects.append(particles)
    pipeline = Pipeline(source=StaticSource(data=data))
    pipeline.modifiers.append(VoronoiAnalysisModifier())
    return pipeline.compute()


def by_hand(edges):
    box = freud.box.Box.from_matrix(edges.T)
    return box, fractions @ box.to_matrix().T


def by_mdanalysis(edges):
    universe = MDAnalysis.Universe.empty(len(fractions), trajectory=True)
    universe.atoms.positions = fractions @ edges
    universe.dimensions = triclinic_box(*edges)
    return universe.trajectory.ts


def volumes(system):
    return np.array(freud.locality.Voronoi().compute(system).volumes)


tilted = np.array([[10, 0, 0], [4.5, 9, 0], [2, -2.4, 8]])
primitive = 6. * np.array([[0, 1, 1], [1, 0, 1], [1, 1, 0]])
changed = False
for name, edges, make in (("MDAnalysis", tilted, by_mdanalysis), ("OVITO", primitive, by_ovito)):
    frame = by_ovito(edges)  # the oracle: OVITO's own Voronoi analysis
    right = np.array(frame.particles["Atomic Volume"])
    seen, hand = volumes(make(edges)), volumes(by_hand(edges))
    wrong = np.mean(abs(seen / right - 1) > .01)
    same = wrong > .5 and np.allclose(seen.sum(), right.sum(), rtol=1e-4) and np.allclose(hand, right, rtol=1e-3)
    changed |= not same
    print(f"{name} -> freud: {wrong:.0%} of the volumes are off by more than 1 %, up to a factor {max(seen / right):.3g}; sum "
          f"{seen.sum():.2f} of {right.sum():.2f}; with box and points passed by hand: {abs(hand / right - 1).max():.1e}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

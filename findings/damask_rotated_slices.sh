#!/usr/bin/env bash
# DAMASK rotates grids by cells and not by lengths: a cube of slices becomes a box of 1 by 0.5 by 2.
#
# Surprise: a grid of DAMASK has a size and a number of cells along each axis. In serial sections the distance of the slices differs from
#   the step within them, so cells are no cubes. GeomGrid.rotate() turns the array and keeps the lengths of its cells, axis by axis.
#   A Voronoi polycrystal in a unit cube of 40 by 40 by 20 cells, turned by 90 degrees about x, has the size 1, 0.5, 2. Seven of ten
#   cells inside of the cube are of another grain than the rotated seeds give. By 30 degrees the grid is sheared. Nothing warns.
#   Cubes as cells are right, and so are rotations about an axis whose other two have equal steps.
# Versions: DAMASK 3.1.0, SciPy 1.17.1
# Seen: 2026-11
# Do: make cells cubes first, grid.scale(cells), then rotate.
# Source: DAMASK documentation, GeomGrid.rotate: "Rotate grid (possibly extending its bounding box)", and GeomGrid: "size: Physical size
#   of grid in meter". Neither asks for cubes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet damask==3.1.0 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import damask
import numpy as np
from scipy.spatial import cKDTree

print({name: version(name) for name in ("damask", "scipy")})
seeds = np.random.default_rng(1).random((60, 3))
tree = cKDTree(seeds)


def measures(grid, rotation):
    """Returns the size of the grid, and the share of its cells inside of the rotated cube that belong to another grain."""
    centers = damask.grid_filters.coordinates0_point(grid.cells, grid.size, grid.origin).reshape(-1, 3)
    before = (centers - .5) @ rotation.as_matrix().T + .5
    inside = ((before > 0) & (before < 1)).all(axis=1)
    return grid.size.round(4).tolist(), np.mean(tree.query(before[inside])[1] != grid.material.ravel()[inside])


changed = False
for cells, axis, angle, size, wrong in (((40, 40, 40), (1, 0, 0), 90, (1, 1, 1), 0), ((40, 40, 40), (0, 0, 1), 30, (1.375, 1.375, 1), .09),
                                        ((40, 40, 20), (0, 0, 1), 90, (1, 1, 1), 0), ((40, 40, 20), (1, 0, 0), 90, (1, .5, 2), .72),
                                        ((40, 20, 20), (0, 0, 1), 30, (1.125, 1.85, 1), .63)):
    grid = damask.GeomGrid.from_Voronoi_tessellation(cells=cells, size=(1, 1, 1), seeds=seeds, periodic=False)
    rotation = damask.Rotation.from_axis_angle(n_omega=[*axis, angle], degrees=True)
    first = measures(grid, damask.Rotation())
    found = measures(grid.rotate(rotation, fill=len(seeds)), rotation)
    mended = measures(grid.scale((40, 40, 40)).rotate(rotation, fill=len(seeds)), rotation)
    same = first == ([1, 1, 1], 0) and np.allclose(found[0], size) and abs(found[1] - wrong) < .03 and mended[1] < .15
    changed |= not same
    print(f"{cells} cells, {angle} degrees about {axis}: size {found[0]}, cells of another grain {found[1]:.1%}; with cubes first {mended[0]}, "
          f"{mended[1]:.1%}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

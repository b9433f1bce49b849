#!/usr/bin/env bash
# Half of the Delaunay tetrahedra of VTK's new Voronoi filter are inside out, and their volumes cancel.
#
# Surprise: vtkVoronoiFlower3D returns Voronoi cells, which agree with SciPy's, or the Delaunay tetrahedra. The latter are right
#   as sets of points, but 50 % are listed in mirrored order: PyVista's volume of 1000 random points in a cube is -0.01, SciPy's
#   hull 0.92. Contours, probes and meshers that need positive tetrahedra fail. 18 % are missing, those whose center lies
#   beyond the padded bounds; of 6322 tetrahedra 395 are still missing with ten times the bounds.
# Versions: VTK 9.7.2, PyVista 0.49.1, SciPy 1.17.1
# Seen: 2026-11
# Do: scipy.spatial.Delaunay; or swap two corners of each tetrahedron of negative volume, and check the sum against the hull.
# Source: VTK class reference, vtkTetra (the fourth point lies on the side of the normal of the first three) and
#   vtkVoronoiFlower3D (output types VORONOI and DELAUNAY).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet vtk==9.7.2 pyvista==0.49.1 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import pyvista
import vtk
from scipy.spatial import ConvexHull, Delaunay, Voronoi

print({name: version(name) for name in ("vtk", "pyvista", "scipy")})
points = np.random.default_rng(1).random((1000, 3))


def made(output, padding):
    flower = vtk.vtkVoronoiFlower3D()
    flower.SetInputData(pyvista.PolyData(points))
    flower.SetPadding(padding)
    getattr(flower, "SetOutputTypeTo" + output)()
    flower.Update()
    return pyvista.wrap(flower.GetOutputDataObject(0))


right = set(map(tuple, np.sort(Delaunay(points).simplices).tolist()))
hull = ConvexHull(points).volume
changed = False
for padding, stated in ((.001, 5165), (1, 5927), (10, 5927)):
    grid = made("Delaunay", padding)
    rows = grid.cells.reshape(-1, 5)[:, 1:]
    volumes = np.linalg.det(points[rows[:, 1:]] - points[rows[:, :1]]) / 6
    inverted = np.mean(volumes < 0)
    same = set(map(tuple, np.sort(rows).tolist())) <= right and len(rows) == stated and .45 < inverted < .55 and \
        abs(grid.volume) < .03
    changed |= not same
    print(f"padding {padding}: {len(rows)} of {len(right)} tetrahedra, {inverted:.1%} inverted; volume by PyVista "
          f"{grid.volume:.4f}, of their absolute values {abs(volumes).sum():.4f}, of the hull {hull:.4f}",
          "" if same else "CHANGED")

voronoi, grid, error, count = Voronoi(points), made("Voronoi", .001), 0, 0
for i, region in enumerate(voronoi.point_region):
    corners = voronoi.vertices[voronoi.regions[region]]
    if -1 not in voronoi.regions[region] and (corners > points.min(0)).all() and (corners < points.max(0)).all():
        error = max(error, abs(ConvexHull(grid.get_cell(i).points).volume / ConvexHull(corners).volume - 1))
        count += 1
same = error < 1e-10 and count > 100
changed |= not same
print(f"Voronoi: hulls of {count} inner cells agree with SciPy to {error:.1g}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

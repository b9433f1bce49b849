#!/usr/bin/env bash
# UXarray's Voronoi cells around stations of one continent have areas that sum to one and a half spheres.
#
# Surprise: Grid.from_points(method="spherical_voronoi") takes its cells from SciPy. SciPy's areas of them are right, as counts of
#   the nearest station show. Outer cells of stations in Europe span much of the globe, though less than a half-sphere. UXarray
#   integrates over triangles by a rule for small ones. So face_areas sums to 1.5 times the sphere, and one cell has 1.6 times its
#   area. integrate() and weighted means inherit it. The rules of higher order give 0.98 to 1.08 times the sphere, so each gives
#   another answer. Nothing warns. Stations all over the globe are right to 1e-5.
# Versions: UXarray 2026.10.0, SciPy 1.16.3
# Seen: 2026-11
# Do: add far points before the diagram and drop their cells, or take SphericalVoronoi.calculate_areas().
# Source: UXarray manual, Grid.from_points ("constructs a spherical Voronoi diagram") and Grid.face_areas ("area of each face").
#   SciPy manual, SphericalVoronoi.calculate_areas.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet uxarray==2026.10.0 scipy==1.16.3 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import uxarray
from scipy.spatial import SphericalVoronoi, cKDTree

print({name: version(name) for name in ("uxarray", "scipy")})
rng = np.random.default_rng(1)
everywhere = rng.normal(size=(400_000, 3))
everywhere /= np.linalg.norm(everywhere, axis=1)[:, None]


def stations(count, longitudes, latitudes):
    """Returns points, evenly spread between longitudes and latitudes in degrees."""
    l = np.radians(rng.uniform(*longitudes, count))
    z = rng.uniform(*np.sin(np.radians(latitudes)), count)
    return np.c_[np.sqrt(1 - z * z) * np.cos(l), np.sqrt(1 - z * z) * np.sin(l), z]


changed = False
for name, points, stated in (("globe", stations(400, (0, 360), (-90, 90)), 1), ("Europe", stations(40, (-10, 30), (35, 70)), 1.53),
                             ("North America", stations(60, (-125, -70), (25, 50)), 1.44)):
    diagram = SphericalVoronoi(points)
    diagram.sort_vertices_of_regions()
    areas = diagram.calculate_areas()
    counted = np.bincount(cKDTree(points).query(everywhere)[1], minlength=len(points)) * 4 * np.pi / len(everywhere)
    grid = uxarray.Grid.from_points(tuple(points.T), method="spherical_voronoi")
    faces = np.asarray(grid.face_areas)
    others = [np.asarray(grid.compute_face_areas(rule, order)).sum() / (4 * np.pi) for rule, order in (("triangular", 12), ("gaussian", 10))]
    whole, most = faces.sum() / (4 * np.pi), (faces / areas).max()
    same = abs(areas.sum() / (4 * np.pi) - 1) < 1e-9 and abs(counted - areas).max() < .03 and abs(whole - stated) < (.03 if stated > 1 else 1e-4) and \
        ((most < 1.01) if stated == 1 else most > 1.5) and \
        ((max(others) - min(others) < 1e-4) if stated == 1 else max(others) - min(others) > .02)
    changed |= not same
    print(f"{name}: {len(points)} cells; sum over sphere: SciPy {areas.sum() / (4 * np.pi):.6f}, UXarray {whole:.4f}, by other rules "
          f"{others[0]:.4f}, {others[1]:.4f}; largest ratio {most:.3f}; counting is off by {abs(counted - areas).max():.3f} of "
          f"{areas.max():.2f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

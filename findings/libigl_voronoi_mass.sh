#!/usr/bin/env bash
# libigl's Voronoi masses cancel for the tetrahedra of SciPy, half of which are mirrored: total mass 0.02 for 0.86.
#
# Surprise: SciPy orients triangles in the plane and no tetrahedra. libigl's voronoi_mass() of the Delaunay tetrahedra of 400
#   random points sums to 0.015 for a volume of 0.863, and some masses are negative, where its manual promises positive ones. Its
#   massmatrix() of the Voronoi type has the same values, and its barycentric type the right sum for either order. With all
#   tetrahedra turned alike the sum is right. Diffusion and smoothing by such a matrix run backward at some vertices.
# Versions: libigl 2.6.3, SciPy 1.17.1, NumPy 2.4.6
# Seen: 2026-11
# Do: swap two corners of each tetrahedron of SciPy with a negative determinant before libigl gets them.
# Source: libigl manual, voronoi_mass ("positive for non-degenerate tets"). SciPy manual, scipy.spatial.Delaunay, simplices: "for
#   2-D, the triangle points are oriented counterclockwise", and nothing of 3D.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet libigl==2.6.3 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import igl
import numpy as np
from scipy.spatial import ConvexHull, Delaunay

print({name: version(name) for name in ("libigl", "scipy")})
points = np.random.default_rng(0).random((400, 3))
tetrahedra = Delaunay(points).simplices.astype(np.int64)
signs = np.linalg.det(points[tetrahedra[:, 1:]] - points[tetrahedra[:, :1]])
turned = tetrahedra.copy()
turned[signs < 0] = turned[signs < 0][:, [1, 0, 2, 3]]
right = ConvexHull(points).volume
print(f"volume {right:.4f}, {np.mean(signs < 0):.0%} of SciPy's tetrahedra are mirrored")
totals = {}
for name, cells in (("as of SciPy", tetrahedra), ("turned alike", turned)):
    masses = igl.voronoi_mass(points, cells)
    matrix = {kind: igl.massmatrix(points, cells, getattr(igl, f"MASSMATRIX_TYPE_{kind}")).diagonal()
              for kind in ("VORONOI", "BARYCENTRIC")}
    totals[name] = [masses.sum(), matrix["VORONOI"].sum(), matrix["BARYCENTRIC"].sum()]
    print(f"{name}: voronoi_mass() sums to {masses.sum():.4f}, {np.sum(masses < 0)} of {len(masses)} are negative; massmatrix() "
          f"Voronoi {matrix['VORONOI'].sum():.4f}, barycentric {matrix['BARYCENTRIC'].sum():.4f}")
    totals[name].append(int(np.sum(masses < 0)))
first, second = totals["as of SciPy"], totals["turned alike"]
same = abs(first[0]) < 0.1 * right and np.isclose(first[0], first[1]) and np.isclose(first[2], right) and first[3] > 50 and \
    np.allclose(second, [right, right, right, 0])
print("as stated" if same else "CHANGED")
sys.exit(not same)
EOF

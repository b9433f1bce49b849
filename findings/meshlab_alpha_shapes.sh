#!/usr/bin/env bash
# MeshLab's alpha shapes have triangles that belong to no alpha complex, and lack some of the boundary.
#
# Surprise: 400 random points in a cube. PyMeshLab's filter returns each Delaunay triangle of circumradius up to alpha, also
#   where another point lies in its circumsphere, which its own manual excludes: 193 of 1005 triangles at an alpha of 8 % of the
#   diagonal, 247 of 580 at 15 %. Of the boundary 6 and 10 triangles are missing. So the surface is not closed, and has flaps.
#   The setting "Alpha Complex" returns the same flaps. GUDHI's alpha complex agrees with the definition, checked by brute force.
# Versions: PyMeshLab 2025.7.post1, GUDHI 3.13.0, SciPy 1.17.1
# Seen: 2026-11
# Do: gudhi.AlphaComplex, or the border of the tetrahedra of scipy.spatial.Delaunay with circumradius below alpha.
# Source: PyMeshLab manual, generate_alpha_shape: the complex has the simplices "which have an empty circumsphere with radius
#   equal or smaller than 'alpha'", the shape is its boundary. GUDHI manual, "Alpha complex" (filtration values are squared
#   radii).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pymeshlab==2025.7.post1 gudhi==3.13.0 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - 2>qhull.txt <<'EOF'
import itertools
import sys
from importlib.metadata import version

import gudhi
import numpy as np
import pymeshlab
from scipy.spatial import Delaunay, cKDTree

print({name: version(name) for name in ("pymeshlab", "gudhi", "scipy")})
points = np.random.default_rng(1).random((400, 3))
diagonal = np.linalg.norm(np.ptp(points, axis=0))


def sphere(corners):  # center and radius of the smallest sphere through the corners
    a = points[list(corners)]
    edges = a[1:] - a[0]
    center = a[0] + np.linalg.lstsq(edges, (edges**2).sum(axis=1) / 2, rcond=None)[0]
    return center, np.linalg.norm(a[0] - center)


def is_empty(corners):
    center, radius = sphere(corners)
    return (np.delete(np.linalg.norm(points - center, axis=1), list(corners)) > radius).all()


tetrahedra = [tuple(sorted(t)) for t in Delaunay(points).simplices.tolist()]
radii = {t: sphere(t)[1] for t in tetrahedra}
sides = {}
for t in tetrahedra:
    for triangle in itertools.combinations(t, 3):
        sides.setdefault(triangle, []).append(t)
changed = False
for percent, stated in ((8, (1005, 193, 6)), (15, (580, 247, 10))):
    alpha = percent / 100 * diagonal
    inside = {f: sum(radii[t] <= alpha for t in of) for f, of in sides.items()}
    alone = {f for f, k in inside.items() if k == 0 and sphere(f)[1] <= alpha and is_empty(f)}
    boundary = {f for f, k in inside.items() if k == 1} | alone
    whole = {f for f, k in inside.items() if k > 0} | alone
    tree = gudhi.AlphaComplex(points=points.tolist()).create_simplex_tree(max_alpha_square=alpha**2)
    of_gudhi = {tuple(sorted(s)) for s, _ in tree.get_skeleton(2) if len(s) == 3}
    found = {}
    for setting in ("Alpha Shape", "Alpha Complex"):
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(points))
        meshes.generate_alpha_shape(alpha=pymeshlab.PercentageValue(percent), filtering=setting)
        mesh = meshes.current_mesh()
        index = cKDTree(points).query(mesh.vertex_matrix())[1]
        found[setting] = {tuple(sorted(index[f].tolist())) for f in mesh.face_matrix()}
    shape, complex_ = found["Alpha Shape"], found["Alpha Complex"]
    flaps = shape - boundary
    seen = len(shape), len(flaps), len(boundary - shape)
    same = seen == stated and of_gudhi == whole and flaps == complex_ - whole and \
        all(sphere(f)[1] <= alpha and not is_empty(f) for f in flaps)
    changed |= not same
    print(f"alpha {percent} %: MeshLab's shape has {seen[0]} triangles, {seen[1]} of them in no alpha complex, and lacks "
          f"{seen[2]} of the {len(boundary)} of the boundary; its complex has {len(complex_ - whole)} such flaps; GUDHI's complex "
          f"is as defined: {of_gudhi == whole}", "" if same else "CHANGED")
sys.exit(changed)
EOF

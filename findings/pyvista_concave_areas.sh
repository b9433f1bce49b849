#!/usr/bin/env bash
# VTK's area of a concave polygon is too large: PyVista's .area and compute_cell_sizes() of country borders and clipped cells.
#
# Surprise: a U of area 10 has 19 in vtkCellSizeFilter and in PyVista's mesh.area, as polygon of a surface or of a grid. The
#   filter adds the areas of a fan of triangles without their signs; a star of 20 points has 4.2 times its area. Voronoi cells
#   that Shapely clipped at the border of that star sum to 125 % of it. Integrals by vtkIntegrateAttributes have the same fault.
#   mesh.triangulate() cuts such polygons rightly, so drawings look as they should.
# Versions: VTK 9.7.2, PyVista 0.49.1, Shapely 2.2.0
# Seen: 2026-11
# Do: mesh.triangulate() before areas and integrals, or take areas from Shapely.
# Source: PyVista manual, PolyData.area ("surface area of the mesh") and compute_cell_sizes. VTK class reference,
#   vtkCellSizeFilter (computes the area of 2D cells), and vtkPolygon ("n-sided polygon", which may be concave).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet vtk==9.7.2 pyvista==0.49.1 shapely==2.2.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import pyvista
import shapely
import vtk

print({name: version(name) for name in ("vtk", "pyvista", "shapely")})


def surface(polygons):
    rings = [shapely.get_coordinates(p.exterior)[:-1] for p in polygons]
    places = np.concatenate(rings)
    starts = np.cumsum([0] + [len(r) for r in rings])
    faces = np.concatenate([[len(r), *range(a, a + len(r))] for r, a in zip(rings, starts)])
    return pyvista.PolyData(np.column_stack([places, np.zeros(len(places))]), faces)


def areas(mesh):
    integral = vtk.vtkIntegrateAttributes()
    integral.SetInputData(mesh)
    integral.Update()
    return {"area": mesh.area, "compute_cell_sizes": mesh.compute_cell_sizes()["Area"].sum(),
            "as a grid": mesh.cast_to_unstructured_grid().compute_cell_sizes()["Area"].sum(),
            "vtkIntegrateAttributes": integral.GetOutput().GetCellData().GetArray("Area").GetValue(0),
            "triangulated": mesh.triangulate().area}


u = shapely.Polygon([(0, 0), (4, 0), (4, 4), (3, 4), (3, 1), (1, 1), (1, 4), (0, 4)])
star = shapely.Polygon([(r * np.cos(t), r * np.sin(t)) for t, r in zip(np.arange(40) * np.pi / 20, [2, 1] * 20)])
points = shapely.MultiPoint(np.random.default_rng(1).uniform(-2, 2, (30, 2)))
cells = [c.intersection(star) for c in shapely.voronoi_polygons(points, extend_to=star.buffer(1)).geoms]
parts = [p for c in cells for p in shapely.get_parts(c) if p.area > 0]
changed = False
for name, polygons, stated in (("a U", [u], 1.9), ("a star", [star], 4.186),
                               (f"{len(parts)} parts of Voronoi cells in the star", parts, 1.251)):
    right = sum(p.area for p in polygons)
    seen = areas(surface(polygons))
    same = np.allclose(np.array(list(seen.values())) / right, [stated] * 4 + [1], rtol=1e-3)
    changed |= not same
    print(f"{name} of area {right:.4f}:", {k: round(float(v), 4) for k, v in seen.items()}, "" if same else "CHANGED")
sys.exit(changed)
EOF

#!/usr/bin/env bash
# VTK finds the wrong polyhedron for half of the points in a Voronoi tessellation, and measures a few polyhedra wrongly.
#
# Surprise: the cells are those of SciPy, convex, oriented outward, and fill a cube. Three cell locators and PyVista's sample()
#   name a wrong cell for half of random points or more. EvaluatePosition accepts every point inside of the bounds of a
#   polyhedron. IsInside is right. The volumes of vtkCellSizeFilter are exact except in a few cells, by up to 2 %, so that
#   their sum is not the volume of the cube.
# Versions: VTK 9.7.2, PyVista 0.49.1, SciPy 1.17.1
# Seen: 2026-11
# Do: find a Voronoi cell by its nearest seed, or check candidates with IsInside. Sum volumes from the faces, or store them
#   as an array when the file is written.
# Source: VTK class reference: vtkCell::EvaluatePosition (1 is inside, 0 is outside), vtkCellSizeFilter (volume of 3D cells).
#   SciPy manual, scipy.spatial.Voronoi and ConvexHull, as the oracle.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet vtk==9.7.2 pyvista==0.49.1 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys

import numpy as np
import pyvista
import scipy
import vtk
from scipy.spatial import ConvexHull, Voronoi, cKDTree

print("VTK", vtk.vtkVersion.GetVTKVersion(), "PyVista", pyvista.__version__, "SciPy", scipy.__version__)
rng = np.random.default_rng(1)
seeds = rng.random((300, 3))
mirrored = [seeds]  # seeds beyond each side make the cells end at the sides of the cube
for axis in range(3):
    for side in (0, 1):
        copy = seeds.copy()
        copy[:, axis] = 2 * side - copy[:, axis]
        mirrored.append(copy)
voronoi = Voronoi(np.concatenate(mirrored))
faces = [[] for _ in seeds]
for pair, ridge in zip(voronoi.ridge_points, voronoi.ridge_vertices):
    for seed in pair[pair < len(seeds)]:
        corners = voronoi.vertices[ridge]
        normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        faces[seed].append(ridge if normal @ (corners.mean(axis=0) - seeds[seed]) > 0 else ridge[::-1])
right = np.array([ConvexHull(voronoi.vertices[voronoi.regions[voronoi.point_region[k]]]).volume for k in range(len(seeds))])

points = vtk.vtkPoints()
points.SetDataTypeToDouble()
for vertex in voronoi.vertices:
    points.InsertNextPoint(vertex)
grid = vtk.vtkUnstructuredGrid()
grid.SetPoints(points)
for cell in faces:
    stream = vtk.vtkIdList()
    for number in [len(cell)] + [n for face in cell for n in [len(face), *face]]:
        stream.InsertNextId(int(number))
    grid.InsertNextCell(vtk.VTK_POLYHEDRON, stream)
grid = pyvista.wrap(grid)

changed = False


def check(text, same):
    global changed
    changed |= not same
    print(text, "" if same else "CHANGED")


volumes = grid.compute_cell_sizes()["Volume"]
errors = abs(volumes / right - 1)
check(f"volumes: {sum(errors > 1e-6)} of {len(seeds)} are wrong, by up to {errors.max():.1e}; sum {volumes.sum():.6f}, "
      f"right {right.sum():.6f}", 0 < sum(errors > 1e-6) < 30 and errors.max() > 1e-3)

places = rng.random((500, 3))
nearest = cKDTree(seeds).query(places)[1]
for make in (vtk.vtkCellLocator, vtk.vtkStaticCellLocator, vtk.vtkCellTreeLocator):
    locator = make()
    locator.SetDataSet(grid)
    locator.BuildLocator()
    wrong = np.mean([locator.FindCell(place) for place in places] != nearest)
    check(f"{make.__name__}: {wrong:.0%} of the points in a wrong cell", wrong > .3)
grid["seed"] = np.arange(len(seeds))
wrong = np.mean(pyvista.PolyData(places).sample(grid)["seed"] != nearest)
check(f"PyVista's sample(): {wrong:.0%} wrong", wrong > .3)


def evaluates(cell, place):
    return cell.EvaluatePosition(place, [0] * 3, vtk.reference(0), [0] * 3, vtk.reference(0.), [0.] * 64) == 1


accepted = bounded = inside = 0
for place in places[:20]:
    for k in range(len(seeds)):
        cell = grid.GetCell(k)
        low, high = np.array(cell.GetBounds()).reshape(3, 2).T
        accepted += evaluates(cell, place)
        bounded += bool(np.all((low <= place) & (place <= high)))
        inside += bool(cell.IsInside(place, 1e-9))
check(f"20 points: EvaluatePosition accepts {accepted} cells, the bounds of {bounded} hold one, IsInside accepts {inside}",
      accepted == bounded > 20 and inside == 20)
sys.exit(bool(changed))
EOF

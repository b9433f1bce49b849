#!/usr/bin/env bash
# PyVista hides the wrong layers of a GRDECL grid: where the top is inactive, the bottom vanishes and the top is shown.
#
# Surprise: PyVista turns depths into elevations and the order of the layers with them, and so the properties. It forgets the flags of
#   ACTNUM. A grid with an inactive layer at the top is shown with that layer and without the lowest one, and its pore volume is
#   12,000 instead of 16,800 cubic meters. Flags that differ within a layer hide cells of the mirrored layer. With elevation = False the
#   same file is right. Besides, the axes of the grid on the map, MAPAXES, are only shifted and not turned: a grid that is turned by
#   30 degrees lies along the map, a corner 81 meters away. xtgeo reads all of it right. Nothing warns.
# Versions: PyVista 0.49.1, xtgeo 4.27.0
# Seen: 2026-11
# Do: read with GRDECLReader and elevation = False, then turn and move the points by MAPAXES, or take the geometry from xtgeo.
# Source: OPM Flow reference manual, ACTNUM (1 active, 0 inactive, in the order of the cells), MAPAXES (points on the y axis, at the
#   origin and on the x axis of the grid) and GRIDUNIT. PyVista manual, GRDECLReader.elevation: "Convert depths to elevations and flip
#   grid along Z axis".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pyvista==0.49.1 vtk==9.7.2 xtgeo==4.27.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import logging
import sys
from importlib.metadata import version

import numpy as np
import pyvista
import xtgeo

print({name: version(name) for name in ("pyvista", "xtgeo")})
logging.disable(logging.CRITICAL)
shape, step = (12, 10, 5), (10, 10, 2)
layers = np.broadcast_to(np.arange(5), shape)
checks = np.where((np.indices(shape).sum(axis=0) % 2 == 0) & (layers < 2), 0, 1)
changed = False


def write(active, head=""):
    grid = xtgeo.create_box_grid(shape, increment=step, origin=(0, 0, 1000))
    flags = grid.get_actnum()
    flags.values = active
    grid.set_actnum(flags)
    grid.to_file("grid.grdecl", fformat="grdecl")
    with open("grid.grdecl") as file:
        text = file.read()
    with open("grid.grdecl", "w") as file:
        file.write(head + text + "\nPORO\n" + " ".join(f"{.05 * (k + 1):.2f}" for k in layers.ravel(order="F")) + "\n/\n")


def by_pyvista(elevation):
    """Returns the centers of the cells that are shown, depth down, and the pore volume."""
    reader = pyvista.GRDECLReader("grid.grdecl")
    reader.elevation = elevation
    grid = reader.read()
    shown = grid.cell_data["vtkGhostType"] == 0 if "vtkGhostType" in grid.cell_data else np.ones(grid.n_cells, bool)
    return grid.cell_centers().points * (1, 1, -1 if elevation else 1), grid["PORO"][shown].sum() * np.prod(step)


def sorted_rows(points):
    return points[np.lexsort(points.round(3).T)]


for name, active, stated in (("all active", np.ones(shape), (0, 18000, 18000)), ("top inactive", np.where(layers < 1, 0, 1), (120, 16800, 12000)),
                             ("chessboard in two layers", checks, (120, 16200, 12600))):
    write(active)
    grid = xtgeo.grid_from_file("grid.grdecl", fformat="grdecl")
    found = np.stack([each.values.filled(np.nan) for each in grid.get_xyz()], axis=-1)
    found = sorted_rows(found[np.isfinite(found[..., 0])])
    poro = xtgeo.gridproperty_from_file("grid.grdecl", fformat="grdecl", name="PORO", grid=grid).values
    right = poro.sum() * np.prod(step)
    turned, kept = by_pyvista(True), by_pyvista(False)
    wrong = len({tuple(row) for row in turned[0].round(3)} - {tuple(row) for row in found.round(3)})
    same = np.allclose(sorted_rows(kept[0]), found, atol=1e-3) and len(turned[0]) == len(found) and wrong == stated[0] and \
        np.allclose((right, kept[1], turned[1]), (stated[1], stated[1], stated[2]))
    changed |= not same
    depths = [sorted(set(each[:, 2].round(1).tolist())) for each in (turned[0], found)]
    print(f"{name}: depths shown {depths[0]}, by xtgeo {depths[1]}; inactive cells shown {wrong} of {len(found)}; pore volume by PyVista "
          f"{turned[1]:.0f}, with elevation = False {kept[1]:.0f}, by xtgeo {right:.0f}", "" if same else "CHANGED")

for turn in (0, 30):
    cosine, sine = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    x, y = 460_000, 5_900_000
    ends = f"{x - 100 * sine:.4f} {y + 100 * cosine:.4f} {x} {y} {x + 100 * cosine:.4f} {y + 100 * sine:.4f}"
    write(np.ones(shape), f"MAPUNITS\n 'METRES' /\nMAPAXES\n {ends} /\nGRIDUNIT\n 'METRES' /\n")
    grid = xtgeo.grid_from_file("grid.grdecl", fformat="grdecl", relative_to=xtgeo.GridRelative.MAP)
    found = np.stack([each.values.filled(np.nan) for each in grid.get_xyz()], axis=-1).reshape(-1, 3, order="F")
    true = np.indices(shape).reshape(3, -1).T.reshape(*shape, 3).reshape(-1, 3, order="F") * step + np.array(step) / 2
    true = true @ np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]]) + (x, y, 1000)
    away = np.linalg.norm(by_pyvista(False)[0] - true, axis=1).max()
    by_xtgeo = np.linalg.norm(found - true, axis=1).max()
    same = by_xtgeo < .5 and abs(away - (0 if turn == 0 else 77.2)) < .1
    changed |= not same
    print(f"MAPAXES turned by {turn} degrees: centers off by {away:.1f} m, by xtgeo {by_xtgeo:.2f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

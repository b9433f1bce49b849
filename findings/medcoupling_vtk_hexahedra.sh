#!/usr/bin/env bash
# MEDCoupling writes hexahedra of 27 points to VTK with the centers of their faces exchanged: a cube has two thirds of its volume.
#
# Surprise: MEDCoupling finds a volume of 1 for a unit cube, whatever its cells. The .vtu files of its own writeVTK keep the
#   order of the MED format. In VTK the volumes are then negative, -1 for tetrahedra and hexahedra of 8 or 20 points. For those
#   of 27 points they are -0.667, because MED lists the centers of faces from the bottom up, and VTK along x, y and z. Each cell
#   is folded, and points in it get values of other faces. The picture of the surface shows nothing. Nothing warns.
# Versions: MEDCoupling 9.15.0, VTK 9.7.2, PyVista 0.49.1
# Seen: 2026-12
# Do: put the points of each cell into VTK's order after reading; the script has it for 27 points.
# Source: MEDCoupling manual, MEDCouplingUMesh::writeVTK (writes a file for VTK) and getMeasureField. VTK class reference,
#   vtkTriQuadraticHexahedron, order of the points.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet medcoupling==9.15.0 vtk==9.7.2 pyvista==0.49.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import medcoupling
import numpy as np
import pyvista

print({name: version(name) for name in ("medcoupling", "vtk", "pyvista")})
vtk_order = [0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17, 21, 23, 24, 22, 20, 25, 26]


def volume(grid):
    return grid.compute_cell_sizes().cell_data["Volume"].sum()


changed = False
for name, split, more, stated in (("tetrahedra of 4 points", True, None, -1), ("tetrahedra of 10 points", True, 0, -1),
                                  ("hexahedra of 8 points", False, None, -1), ("hexahedra of 20 points", False, 0, -1),
                                  ("hexahedra of 27 points", False, 1, -2 / 3)):
    lattice = medcoupling.MEDCouplingCMesh()
    lattice.setCoords(*[medcoupling.DataArrayDouble([0., .5, 1.])] * 3)
    mesh = lattice.buildUnstructured()
    if split:
        mesh.simplexize(medcoupling.PLANAR_FACE_5)
    if more is not None:
        mesh.convertLinearCellsToQuadratic(more)
    mesh.checkConsistency()
    measured = mesh.getMeasureField(False).accumulate(0)
    mesh.writeVTK("a.vtu")
    grid = pyvista.read("a.vtu")
    found, sorted_ = volume(grid), None
    if more == 1:
        cells = grid.cells.reshape(-1, 28).copy()
        cells[:, 1:] = cells[:, 1:][:, vtk_order]
        sorted_ = volume(pyvista.UnstructuredGrid(cells.ravel(), grid.celltypes, np.array(grid.points)))
    same = abs(measured - 1) < 1e-9 and abs(found - stated) < 1e-6 and (sorted_ is None or abs(sorted_ - 1) < 1e-9)
    changed |= not same
    print(f"{name}: volume by MEDCoupling {measured:.4f}, by VTK {found:.4f}",
          "" if sorted_ is None else f"and in VTK's order {sorted_:.4f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

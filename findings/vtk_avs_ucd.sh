#!/usr/bin/env bash
# VTK reads the hexahedra and tetrahedra of AVS UCD files inside out; meshio reads and writes them in the order of AVS.
#
# Surprise: AVS lists the upper face of a hexahedron first, and the apex of a tetrahedron or pyramid. VTK's reader turns
#   pyramids only. A hexahedron of volume 1 has -1 in PyVista, a tetrahedron of 1/6 has -1/6, and all faces of the surface
#   point inward. Where a file has pyramids too, signs are mixed and the sum of volumes is wrong. meshio reads all of them right
#   and writes files that VTK turns over. Wedges are omitted, since VTK changed their order (vtk_wedges).
# Versions: VTK 9.7.2, PyVista 0.49.1, meshio 5.3.5
# Seen: 2026-11
# Do: read .inp files of AVS by meshio (file_format="avsucd"), or reverse the cells whose volume is negative.
# Source: the sample of AVS, https://www.csee.umbc.edu/~squire/download/ucd1.inp: the first four points of its hexahedron are
#   those of z = 1 and go round it counterclockwise seen from above, so that VTK's order has a negative volume; so has its
#   tetrahedron. VTK file formats, figure of linear cells (VTK_HEXAHEDRON, VTK_TETRA).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet vtk==9.7.2 pyvista==0.49.1 meshio==5.3.5 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import meshio
import numpy as np
import pyvista

print({name: version(name) for name in ("vtk", "pyvista", "meshio")})
hexahedron = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
shapes = {"hexahedron": hexahedron, "tetra": hexahedron[[0, 1, 3, 4]], "pyramid": hexahedron[[0, 1, 2, 3, 4]]}  # in VTK's order
of_avs = {"hexahedron": ("hex", [4, 5, 6, 7, 0, 1, 2, 3]), "tetra": ("tet", [3, 0, 1, 2]), "pyramid": ("pyr", [4, 0, 1, 2, 3])}
right = {"hexahedron": 1, "tetra": 1 / 6, "pyramid": 1 / 3}
stated = {"hexahedron": -1, "tetra": -1 / 6, "pyramid": 1 / 3}


def by_hand(name):
    """Writes the file in the order of AVS's sample, without a library."""
    points = shapes[name]
    rows = [f"{len(points)} 1 0 0 0"]
    rows += [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(points, 1)]
    rows.append(f"1 1 {of_avs[name][0]} " + " ".join(str(i + 1) for i in of_avs[name][1]))
    with open("cell.inp", "w") as file:
        file.write("\n".join(rows) + "\n")


def by_meshio(name):
    mesh = meshio.Mesh(shapes[name], [(name, [list(range(len(shapes[name])))])])
    meshio.write("cell.inp", mesh, file_format="avsucd")


def outward(grid):
    """Returns whether the faces of the surface, in their own order, enclose a positive volume, by the divergence theorem."""
    surface = grid.extract_surface(algorithm=None).triangulate()
    a, b, c = np.asarray(surface.points, float)[surface.regular_faces].swapaxes(0, 1)
    return bool(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0)


changed = False
for text, write in (("by hand", by_hand), ("by meshio", by_meshio)):
    for name in shapes:
        write(name)
        read = meshio.read("cell.inp", file_format="avsucd")
        again = pyvista.from_meshio(read)
        of_meshio = again.compute_cell_sizes()["Volume"][0]
        grid = pyvista.read("cell.inp")
        of_vtk = grid.compute_cell_sizes()["Volume"][0]
        same = np.allclose(of_meshio, right[name]) and np.allclose(of_vtk, stated[name]) and outward(again) and \
            outward(grid) == (stated[name] > 0)
        changed |= not same
        print(f"{name:10} written {text:9}: right {right[name]:.3f}, meshio {of_meshio:.3f}, VTK {of_vtk:.3f}; faces outward: "
              f"meshio {outward(again)}, VTK {outward(grid)}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

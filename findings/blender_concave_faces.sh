#!/usr/bin/env bash
# Blender writes concave polygons in .obj and .ply; trimesh and PyVista fan them, and meshio refuses the .obj.
#
# Surprise: a solid of the shape U has area 34. trimesh reads Blender's .obj and ASCII .ply with area 50. Triangles of a fan
#   cross the notch, and more than a tenth of the points sampled on the surface lie there. It calls the .ply watertight. PyVista
#   gives 50 until triangulate(), which cuts rightly. The signed volume is 8 in all, so a check of the volume passes. meshio
#   takes the list of normals for one by point and refuses the .obj. trimesh refuses the binary .ply, whose polygons have four
#   and eight corners. Blender cuts the polygons of its .stl itself, and they are right.
# Versions: Blender 5.0.1 (bpy, needs Python 3.11), trimesh 5.2.0, PyVista 0.49.1, meshio 5.3.5
# Seen: 2026-11
# Do: export with "Triangulated Mesh" (export_triangulated_mesh=True), or as .stl; in PyVista call triangulate() first.
# Source: Wavefront OBJ format, element f: three or more vertices, each with its own index of a normal. Blender manual,
#   "Wavefront OBJ", export, Triangulated Mesh.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/python -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' ||
    { echo "bpy needs Python 3.11: name one in the variable PYTHON"; exit 1; }
venv/bin/pip install --quiet bpy==5.0.1 trimesh==5.2.0 pyvista==0.49.1 meshio==5.3.5 numpy==1.26.4

cat > write.py <<'EOF'
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
outline = [(0, 0), (4, 0), (4, 3), (3, 3), (3, 1), (1, 1), (1, 3), (0, 3)]
n = len(outline)
vertices = [(x, y, z) for z in (0, 1) for x, y in outline]
faces = [tuple(range(n))[::-1], tuple(range(n, 2 * n))] + [(k, (k + 1) % n, n + (k + 1) % n, n + k) for k in range(n)]
mesh = bpy.data.meshes.new("U")
mesh.from_pydata(vertices, [], faces)
bpy.context.collection.objects.link(bpy.data.objects.new("U", mesh))
axes = dict(forward_axis="Y", up_axis="Z")
bpy.ops.wm.obj_export(filepath="U.obj", **axes)
bpy.ops.wm.obj_export(filepath="cut.obj", export_triangulated_mesh=True, **axes)
bpy.ops.wm.ply_export(filepath="binary.ply", **axes)
bpy.ops.wm.ply_export(filepath="ascii.ply", ascii_format=True, **axes)
bpy.ops.wm.stl_export(filepath="U.stl", **axes)
EOF
venv/bin/python write.py > log 2>&1 || { cat log; exit 1; }
head -n 1 U.obj

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import meshio
import numpy as np
import pyvista
import trimesh

print({name: version(name) for name in ("bpy", "trimesh", "pyvista", "meshio")})
changed = False


def check(text, seen, stated):
    global changed
    same = np.allclose(seen, stated, rtol=1e-5) if not isinstance(stated, str) else seen == stated
    changed |= not same
    print(f"{text}: {seen}", "" if same else f"CHANGED, was {stated}")


for name, area in (("U.obj", 50), ("ascii.ply", 50), ("U.stl", 34), ("cut.obj", 34)):
    mesh = trimesh.load(name, force="mesh")
    check(f"{name}, trimesh, volume and area", [float(mesh.volume), float(mesh.area)], [8, area])
    if name == "ascii.ply":
        check(f"{name}, trimesh, watertight", mesh.is_watertight, True)
    points = trimesh.sample.sample_surface(mesh, 20000, seed=1)[0]
    off = np.mean((points[:, 0] > 1.001) & (points[:, 0] < 2.999) & (points[:, 1] > 1.001))
    check(f"{name}, trimesh, share of samples in the notch is above 0.1", bool(off > .1), area == 50)
    mesh = pyvista.read(name)
    check(f"{name}, PyVista, area, and after triangulate()", [float(mesh.area), float(mesh.triangulate().area)], [area, 34])
for name, module, read in (("U.obj", "meshio", meshio.read), ("binary.ply", "trimesh", trimesh.load)):
    try:
        read(name)
        seen = "read"
    except Exception as error:
        seen = f"{type(error).__name__}: {error}"
    check(f"{name}, {module}", seen.split(":")[0], "ValueError")
    print(f"    {seen}")
sys.exit(bool(changed))
EOF

#!/usr/bin/env bash
# trimesh gives Manifold single precision: booleans of parts far from the origin have wrong volumes, and are watertight.
#
# Surprise: two boxes of edge 1 at 5,000,000 m, a usual northing of a map, have an intersection of 0.042 for 0.328 and a
#   union of 1.917 for 1.672. At 500,000 m another pair is wrong in the third digit. The results are closed, trimesh calls them
#   volumes, and nothing warns. trimesh keeps vertices in double precision, and the volumes of the parts are right. Manifold has
#   a second mesh type, in double precision, by which all results are right.
# Versions: trimesh 5.2.0, manifold3d 3.5.4
# Seen: 2026-11
# Do: move the parts to the origin first and the result back, or give Manifold its Mesh64.
# Source: trimesh manual, "trimesh.boolean", which names no precision; trimesh.Trimesh.vertices, of type float64. Manifold
#   manual, MeshGL (single precision) and MeshGL64 (double precision, in Python Mesh64).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet trimesh==5.2.0 manifold3d==3.5.4 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import manifold3d
import numpy as np
import trimesh

print({name: version(name) for name in ("trimesh", "manifold3d")})


def by_manifold(parts, name):
    first, second = (manifold3d.Manifold(manifold3d.Mesh64(part.vertices, part.faces.astype(np.uint64))) for part in parts)
    mesh = {"union": first + second, "intersection": first ^ second, "difference": first - second}[name].to_mesh64()
    return trimesh.Trimesh(mesh.vert_properties[:, :3], mesh.tri_verts.astype(int), process=False)


def volume(mesh, far):
    a, b, c = (mesh.vertices - far)[mesh.faces].swapaxes(0, 1)
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


stated = {  # union, intersection, difference by trimesh; None: right
    (0, .5): None,
    (500_000, .5): None,
    (500_000, .53): (1.6924, .3076, .6924),
    (5_000_000, .5): (1.9167, .0417, .5),
}
changed = False
for (far, shift), wrong in stated.items():
    parts = [trimesh.creation.box((1, 1, 1)), trimesh.creation.box((1, 1, 1))]
    parts[1].apply_translation([shift, .25, .125])
    for part in parts:
        part.apply_translation([far, far, far])
    common = (1 - shift) * .75 * .875
    right = 2 - common, common, 1 - common
    names = "union", "intersection", "difference"
    by_trimesh = [getattr(trimesh.boolean, name)(parts, engine="manifold") for name in names]
    volumes = [volume(mesh, far) for mesh in by_trimesh]
    in_double = [volume(by_manifold(parts, name), far) for name in names]
    of_parts = [volume(part, far) for part in parts]
    closed = all(mesh.is_watertight and mesh.is_volume for mesh in by_trimesh)
    same = closed and np.allclose(of_parts, 1, atol=1e-6) and np.allclose(in_double, right, atol=1e-5) and \
        np.allclose(volumes, wrong or right, atol=2e-4 if wrong else 1e-6)
    changed |= not same
    print(f"boxes at {far}, shifted by {shift}: right {np.round(right, 4)}, trimesh {np.round(volumes, 4)}, Manifold in double "
          f"precision {np.round(in_double, 4)}; closed: {closed}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF

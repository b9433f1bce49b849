#!/usr/bin/env bash
# meshio refuses Gmsh's own files where some entities belong to a physical group and others do not.
#
# Surprise: a cube with its volume as the one physical group, saved by Gmsh with Mesh.SaveAll=1. meshio stops: "Incompatible cell
#   data 'gmsh:physical'. 27 cell blocks, but 'gmsh:physical' has 1 blocks." It keeps a list of groups without the blocks
#   that have none, and then compares the lengths. Format 4.1 states for each entity how many groups it has, 0 too, and Gmsh reads
#   its file. If all entities have a group, or none has one, meshio reads it too. In format 2.2, where an element without a group
#   has the tag 0, all are read.
# Versions: Gmsh 4.15.2, meshio 5.3.5
# Seen: 2026-11
# Do: leave Mesh.SaveAll at 0, name groups for all entities, or save with Mesh.MshFileVersion=2.2 for meshio.
# Source: Gmsh manual, "MSH file format", section $Entities: numPhysicalTags; options Mesh.SaveAll and Mesh.MshFileVersion.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gmsh==4.15.2 meshio==5.3.5 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import contextlib
import io
import sys
from importlib.metadata import version

import gmsh
import meshio

print({name: version(name) for name in ("gmsh", "meshio")})


def start():
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)


def make(dimensions, save_all, file_version):
    start()
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    for dimension in dimensions:
        gmsh.model.addPhysicalGroup(dimension, [tag for _, tag in gmsh.model.getEntities(dimension)], dimension + 1)
    gmsh.option.setNumber("Mesh.SaveAll", save_all)
    gmsh.option.setNumber("Mesh.MshFileVersion", file_version)
    gmsh.model.mesh.generate(3)
    gmsh.write("cube.msh")
    gmsh.finalize()


def by_gmsh():
    start()
    gmsh.open("cube.msh")
    count = sum(map(len, gmsh.model.mesh.getElements(3)[1]))
    gmsh.finalize()
    return count


def by_meshio():
    with contextlib.redirect_stdout(io.StringIO()):
        try:
            return sum(len(block.data) for block in meshio.read("cube.msh").cells if block.dim == 3)
        except ValueError as error:
            return str(error)


changed = False
for groups, save_all, file_version, refused in (("none", 1, 4.1, False), ("volume", 0, 4.1, False), ("volume", 1, 4.1, True),
                                                ("all", 1, 4.1, False), ("volume", 1, 2.2, False)):
    make({"none": (), "volume": (3,), "all": range(4)}[groups], save_all, file_version)
    count, read = by_gmsh(), by_meshio()
    same = count > 100 and (isinstance(read, str) and "27 cell blocks, but 'gmsh:physical' has 1" in read if refused
                            else read == count)
    changed |= not same
    print(f"format {file_version}, groups: {groups}, SaveAll={save_all}: Gmsh reads {count} tetrahedra, meshio: {read}",
          "" if same else "CHANGED")
sys.exit(changed)
EOF

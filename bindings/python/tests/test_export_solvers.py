"""Meshes for solvers and meshers: .foam, .tess and .msh, read back by plain code, VTK and Gmsh, and their quality."""

import re
import shutil
import subprocess
import unittest
import warnings

import numpy as np
from helpers import CELL, CUBE, ELL, UNIT_BOX, Folder, cells, enclosed, have, is_closed, lattice, uniform

import pyvotess as vt

WANT = "faces,volumes,centroids,areas"


def domains():
    """Yields results in one domain of each kind, with duplicates and cells without a place."""
    points = np.concatenate((uniform(30), uniform(2)))
    radii = 0.3 * np.random.default_rng(5).random(32)
    for options in (
        {},
        {"periodic": True},
        {"periodic": "x", "radii": radii},
        {"box": None, "cell": CELL, "periodic": True},
        {"box": None, "cell": CELL, "periodic": "y", "outside": "drop"},
        {"walls": vt.walls.sphere((0.5, 0.5, 0.5), 0.45, 20), "outside": "keep", "radii": radii},
    ):
        yield vt.tessellate(points, **{"box": UNIT_BOX, "want": WANT, **options})
    yield vt.tessellate(lattice(3), box=(0, 0, 0, 3, 3, 3), want=WANT)  # each vertex is a tie
    yield vt.tessellate(lattice(3), box=(0, 0, 0, 3, 3, 3), periodic=True, want=WANT)
    yield vt.tessellate(uniform(2), box=UNIT_BOX, periodic=True, want=WANT)  # cells that touch their own images


def area_and_center(corners):
    """Returns the area vector and the centroid of a flat polygon."""
    a, b = corners[1:-1] - corners[0], corners[2:] - corners[0]
    areas = np.cross(a, b) / 2
    area = areas.sum(axis=0)
    shares = areas @ area / (area @ area)
    return area, corners[0] + shares @ (a + b) / 3


def read_msh(path):
    """Returns names, the physical group of each surface, the group and surfaces of each volume, nodes and triangles."""
    with open(path) as file:
        sections = {m[1]: m[2].split("\n") for m in re.finditer(r"\$(\w+)\n(.*?)\n\$End\1\n", file.read(), re.S)}
    assert sections["MeshFormat"] == ["4.1 0 8"]
    names = {tuple(map(int, line.split(" ", 2)[:2])): line.split('"')[1] for line in sections["PhysicalNames"][1:]}
    points, curves, surfaces, volumes = map(int, sections["Entities"][0].split())
    rows = [line.split() for line in sections["Entities"][1:]]
    assert len(rows) == points + curves + surfaces + volumes
    groups = {int(row[0]): int(row[8]) for row in rows[points + curves : points + curves + surfaces]}
    hulls = {int(row[0]): (int(row[8]), [int(x) for x in row[10:]]) for row in rows[points + curves + surfaces :]}
    lines = sections["Nodes"][1:]
    nodes = np.array([lines[k].split() for k in range(2, len(lines), 3)], float)
    triangles, k = {}, 1
    while k < len(sections["Elements"]):
        dimension, entity, kind, count = map(int, sections["Elements"][k].split())
        part = [[int(x) - 1 for x in line.split()[1:]] for line in sections["Elements"][k + 1 : k + 1 + count]]
        assert kind == (15, 1, 2)[dimension]
        if dimension == 2:
            triangles[entity] = np.array(part)
        k += 1 + count
    return names, groups, hulls, nodes, triangles


class FoamFolder(Folder):
    def read(self):
        """Returns points, faces, owner, neighbour, and the patches as a dict of dicts."""
        content = {}
        for name in ("points", "faces", "owner", "neighbour", "boundary"):
            text = (self.folder / "constant/polyMesh" / name).read_text()
            head, body = re.fullmatch(r"//.*?\nFoamFile\n\{(.*?)\}\n(.*)", text, re.S).groups()
            self.assertIn(f"object {name};", head)
            count, rows = re.fullmatch(r"(\d+)\n\(\n(.*)\)\n", body, re.S).groups()
            content[name] = rows
            content[name + "_count"] = int(count)
        points = np.array([row[1:-1].split() for row in content["points"].splitlines()], float).reshape(-1, 3)
        faces = [re.fullmatch(r"(\d+)\((.*)\)", row).groups() for row in content["faces"].splitlines()]
        self.assertTrue(all(int(n) == len(c.split()) for n, c in faces))
        faces = [np.array(c.split(), int) for _, c in faces]
        owner, neighbour = (np.array(content[name].split(), int) for name in ("owner", "neighbour"))
        patches = {
            name: dict(line.strip().rstrip(";").split(" ", 1) for line in body.splitlines())
            for name, body in re.findall(r"    (\S+)\n    \{\n(.*?)    \}\n", content["boundary"], re.S)
        }
        self.assertEqual((len(points), len(faces), len(owner), len(neighbour), len(patches)), tuple(
            content[name + "_count"] for name in ("points", "faces", "owner", "neighbour", "boundary")))  # fmt: skip
        return points, faces, owner, neighbour, patches


    def closed_cells(self, mesh, places):
        """Returns the volume of each cell by fans seen from its place, and its directed edges, which cancel out."""
        points, faces, owner, neighbour, _ = mesh
        volumes, edges = np.zeros(len(places)), [[] for _ in places]
        for cell, sign, count in ((owner, 1, len(faces)), (neighbour, -1, len(neighbour))):
            for i, face in zip(cell[:count], faces):
                corners = points[face] - places[i]
                volumes[i] += sign * (np.cross(corners[1:-1], corners[2:]) @ corners[0]).sum() / 6
                edges[i] += [e[::sign] for e in zip(face.tolist(), np.roll(face, -1).tolist())]
        for own in edges:
            self.assertEqual(sorted(own), sorted((b, a) for a, b in own), "closed")
        return volumes, edges

    def check_twins(self, patch, patches, points, faces, atol):
        """A periodic patch has the faces of its twin, moved, in the other direction from the same corner."""
        begin = int(patch["startFace"])
        twin = int(patches[patch["neighbourPatch"]]["startFace"])
        apart = np.array(patch["separationVector"][1:-1].split(), float)  # from here to the twin
        for k in range(int(patch["nFaces"])):
            other = faces[twin + k]
            there = np.concatenate((other[:1], other[:0:-1]))  # the same corners, the first first
            np.testing.assert_allclose(points[faces[begin + k]] + apart, points[there], atol=atol)


class Foam(FoamFolder):
    def check(self, t):
        """Checks the rules of checkMesh, and the volumes. Returns what read() does."""
        t.save(self.path("case.foam"))
        self.assertEqual((self.folder / "case.foam").read_bytes(), b"")
        points, faces, owner, neighbour, patches = mesh = self.read()
        held = np.flatnonzero(t.volumes > 0)
        inner = len(neighbour)
        self.assertEqual(sorted(set(owner) | set(neighbour)), list(range(len(held))))
        self.assertEqual(len(np.unique(np.concatenate(faces))), len(points), "all points are used")
        pairs = list(zip(owner[:inner].tolist(), neighbour.tolist()))
        self.assertEqual(pairs, sorted(set(pairs)), "upper-triangular order")
        self.assertTrue((owner[:inner] < neighbour).all())
        rows = {(i, j, tuple(s)) for i, row in enumerate(held) for j, s in zip(
            t.neighbors[row], (t.shifts if t.shifts is not None else np.zeros((t.indptr[-1], 3), int))[t.indptr[row]:].tolist())}  # fmt: skip
        place = {row: i for i, row in enumerate(held)}
        expected = sorted((i, place[j]) for i, j, s in rows if j >= 0 and not any(s) and i < place[j])
        self.assertEqual(pairs, expected)

        measures = [area_and_center(points[face]) for face in faces]
        areas, centers = (np.array([m[k] for m in measures]) for k in (0, 1))
        self.assertTrue((np.linalg.norm(areas, axis=1) > 0).all())
        closure = np.zeros((len(held), 3))
        np.add.at(closure, owner, areas)
        np.add.at(closure, neighbour, -areas[:inner])
        np.testing.assert_allclose(closure, 0, atol=1e-14 * t.box[1].max() ** 2)
        volumes, edges = self.closed_cells(mesh, t.centroids[held])
        np.testing.assert_allclose(volumes, t.volumes[held], rtol=1e-12)
        for own in edges:
            self.assertEqual(len(own), len(set(own)))

        end = inner
        for name, patch in patches.items():
            self.assertEqual(int(patch["startFace"]), end)
            begin, end = end, end + int(patch["nFaces"])
            if patch["type"] == "patch":
                corners = points[np.unique(np.concatenate(faces[begin:end]))]
                if name.startswith("wall"):
                    *normal, offset = t.walls[int(name[4:]) - 7]
                    np.testing.assert_allclose(corners @ normal, offset, atol=1e-14)
                else:
                    side = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax").index(name)
                    if t.cell is None:
                        np.testing.assert_allclose(corners[:, side // 2], t.box[side % 2, side // 2], atol=1e-14)
                continue
            twin = patches[patch["neighbourPatch"]]
            self.assertEqual((patch["type"], patch["transform"], twin["nFaces"]), ("cyclic", "translational", patch["nFaces"]))
            self.check_twins(patch, patches, points, faces, 1e-13)
        self.assertEqual(end, len(faces))
        self.check_quality(t, mesh, held, areas, centers)
        return mesh

    def check_quality(self, t, mesh, held, areas, centers):
        points, faces, owner, neighbour, patches = mesh
        angles, skewness = [], []

        def add(k, own, other):
            d, n = other - own, areas[k]
            angles.append(np.degrees(np.arccos(min(1.0, n @ d / np.linalg.norm(n) / np.linalg.norm(d)))))
            off = centers[k] - own - (n @ (centers[k] - own)) / (n @ d) * d
            size = 0.2 * np.linalg.norm(d)
            if off.any():
                size = max(size, np.abs((points[faces[k]] - centers[k]) @ (off / np.linalg.norm(off))).max())
            skewness.append(np.linalg.norm(off) / size)

        places = t.centroids[held]
        for k in range(len(neighbour)):
            add(k, places[owner[k]], places[neighbour[k]])
        for patch in patches.values():
            for k in range(int(patch["startFace"]), int(patch["startFace"]) + int(patch["nFaces"])):
                if patch["type"] == "cyclic":
                    if patch["separationVector"].split()[0].startswith("(-"):
                        continue  # most of the twins
                    apart = np.array(patch["separationVector"][1:-1].split(), float)
                    twin = int(patches[patch["neighbourPatch"]]["startFace"]) + k - int(patch["startFace"])
                    add(k, places[owner[k]], places[owner[twin]] - apart)
                else:
                    n = areas[k] / np.linalg.norm(areas[k])
                    off = (centers[k] - places[owner[k]]) - n @ (centers[k] - places[owner[k]]) * n
                    size = 0.4 * (n @ (centers[k] - places[owner[k]]))
                    if np.linalg.norm(off) > 1e-12:
                        size = max(size, np.abs((points[faces[k]] - centers[k]) @ (off / np.linalg.norm(off))).max())
                    skewness.append(np.linalg.norm(off) / size)
        q = t.mesh_quality()
        self.assertEqual((q.cells, q.faces, q.internal_faces, q.vertices),
                         (len(held), len(faces), len(neighbour), len(points)))  # fmt: skip
        self.assertEqual((q.wrong_faces, q.wrong_cells), (0, 0))
        np.testing.assert_allclose(q.max_non_orthogonality, max(angles), atol=2e-6)
        np.testing.assert_allclose(q.max_skewness, max(skewness), rtol=1e-5, atol=1e-7)
        np.testing.assert_allclose(q.min_area, np.linalg.norm(areas, axis=1).min(), rtol=1e-5)
        np.testing.assert_allclose(q.min_volume, t.volumes[held].min(), rtol=1e-9)
        lengths = [np.linalg.norm(points[f] - points[np.roll(f, -1)], axis=1).min() for f in faces]
        np.testing.assert_allclose(q.min_edge, min(lengths), rtol=1e-12)

    def test_rules_of_checkmesh(self):
        for t in domains():
            with self.subTest(t):
                self.check(t)

    def test_short_edges_are_collapsed(self):
        """Cells stay closed polyhedra, boundaries stay flat or periodic, and volumes sum to the box."""
        for t in domains():
            if not len(t.walls):
                with self.subTest(t), warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    before = t.mesh_quality()
                    length = 0.05 * t.box[1].max()
                    t.save(self.path("case.foam"), min_edge=length)
                    points, faces, owner, neighbour, patches = mesh = self.read()
                    inner, q = len(neighbour), t.mesh_quality(min_edge=length)
                    self.assertEqual((q.wrong_faces, q.wrong_cells, q.faces, q.vertices), (0, 0, len(faces), len(points)))
                    ends = np.array([(a, b) for f in faces for a, b in zip(f, np.roll(f, -1))])
                    lengths = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
                    short = {tuple(sorted(e)) for e in ends[lengths < length].tolist()}
                    self.assertEqual(q.short_edges, len(short))
                    self.assertEqual([str(w.message) for w in caught], [
                        f"{len(short)} edges below min_edge={length} stay: cells would not remain polyhedra of about their volumes, or "
                        "vertices would leave their walls"] * bool(short))  # fmt: skip
                    if before.min_edge < length:
                        self.assertLess(q.vertices, before.vertices)
                        self.assertLess(len(short), 0.3 * (before.vertices - q.vertices))
                    moved = np.array(sorted(set(map(tuple, points)) - set(map(tuple, t.vertices)))).reshape(-1, 3)
                    if not any(t.periodic):
                        self.assertEqual(len(moved), 0, "vertices of cells, as they were")
                    period = np.diag(t.box[1] - t.box[0]) if t.cell is None else np.array(t.cell)
                    images = (t.vertices[:, None] + (np.indices((3, 3, 3)).reshape(3, -1).T - 1) @ period).reshape(-1, 3)
                    for x in moved:
                        self.assertLess(np.linalg.norm(images - x, axis=1).min(), 1e-13, "or images of them")
                    pairs = list(zip(owner[:inner].tolist(), neighbour.tolist()))
                    self.assertEqual(pairs, sorted(set(pairs)))
                    volumes, edges = self.closed_cells(mesh, np.broadcast_to(points[faces[0][0]], (q.cells, 3)))
                    self.assertTrue((volumes > 0).all())
                    size = t.volumes.sum()
                    np.testing.assert_allclose(volumes.sum(), size, rtol=1e-12)
                    for own in edges:
                        self.assertEqual(len(own), len(set(own)))
                    for name, patch in patches.items():
                        part = range(int(patch["startFace"]), int(patch["startFace"]) + int(patch["nFaces"]))
                        if patch["type"] == "cyclic":
                            self.check_twins(patch, patches, points, faces, 1e-13)
                        elif t.cell is None:
                            side = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax").index(name)
                            corners = points[np.unique(np.concatenate([faces[k] for k in part]))]
                            np.testing.assert_allclose(corners[:, side // 2], t.box[side % 2, side // 2], atol=1e-14)
        t = cells(30)
        t.save(self.path("a.tess"), min_edge=0.05)
        self.assertIn("1", np.array(read_tess(self.path("a.tess"))["**vertex"][1:]).reshape(-1, 5)[:, 4])
        for name, given, message in (("a.vtu", 0.1, ".vtu keeps all edges"), ("a.msh", -1, "min_edge is -1.0: give a length"),
                                     ("a.msh", np.nan, "min_edge is nan")):  # fmt: skip
            with self.assertRaisesRegex(ValueError, message):
                t.save(self.path(name), min_edge=given)

    def check_triangles(self, file):
        """No triangle is there twice, and each edge of a cell has two triangles of it."""
        *_, hulls, _, triangles = read_msh(file)
        everything = [tuple(sorted(triangle)) for face in triangles.values() for triangle in face.tolist()]
        self.assertEqual(len(everything), len(set(everything)))
        for _, faces in hulls.values():
            self.assertTrue(is_closed(np.concatenate([triangles[abs(f)][:, :: 1 if f > 0 else -1] for f in faces])))

    def test_triangles_of_collapsed_cells(self):
        """Relaxed sets have many short edges. Their faces share more than a side where one vanished between them."""
        for seed, domain in ((3, {"box": UNIT_BOX}), (4, {"box": UNIT_BOX}), (5, {"box": UNIT_BOX, "periodic": True}), (2, {"mesh": CUBE})):
            points = vt.lloyd(uniform(60, seed), steps=8, **domain).points
            t = vt.tessellate(points, **domain) if "mesh" in domain else vt.tessellate(points, want=WANT, **domain)
            for length in (0.02, 0.05, 0.08):
                with self.subTest(seed=seed, length=length), warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    t.save(self.path("a.msh"), min_edge=length)
                    self.check_triangles(self.path("a.msh"))

    def test_cells_that_reach_infinity(self):
        t = vt.tessellate(uniform(60), box="none", want="faces,volumes")
        with self.assertRaisesRegex(ValueError, "reach infinity"):
            t.save(self.path("case.foam"))
        t.save(self.path("case.foam"), open="skip")
        points, faces, owner, neighbour, patches = self.read()
        self.assertEqual(list(patches), ["open"])
        self.assertEqual(owner.max() + 1, (~t.open_cells).sum())

    @have("vtk")
    def test_vtk(self):
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOGeometry import vtkOpenFOAMReader

        for t in (cells(30), cells(30, periodic=True)):
            t.save(self.path("case.foam"))
            reader = vtkOpenFOAMReader()
            reader.SetFileName(self.path("case.foam"))
            reader.Update()
            grid = reader.GetOutput().GetBlock(0)
            points = self.read()[0]  # VTK rounds them to float32
            np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), points.astype(np.float32))
            volumes = np.zeros(grid.GetNumberOfCells())
            for i in range(len(volumes)):
                cell = grid.GetCell(i)
                for f in range(cell.GetNumberOfFaces()):
                    face = cell.GetFace(f)
                    corners = points[[face.GetPointId(k) for k in range(face.GetNumberOfPoints())]] - t.centroids[i]
                    area, center = area_and_center(corners)
                    volumes[i] += abs(area @ center) / 3  # the centroid is inside
            np.testing.assert_allclose(volumes, t.volumes[t.volumes > 0], rtol=1e-12)

    @have("h5py")
    def test_cgns(self):
        for t in domains():
            t.save(self.path("a.cgns"))
            self.check_cgns(t, t.volumes, np.flatnonzero(t.volumes))

    def check_cgns(self, t, volumes, rows):
        """Checks a file of volumes[rows] against those of its polyhedra, and its boundaries."""
        import h5py

        with h5py.File(self.path("a.cgns"), "r") as file:
            zone = file["Base/Zone"]

            def data(name, label):
                self.assertEqual(zone[name].attrs["label"].decode(), label)
                return zone[name + "/ data"][...]

            places = np.stack([data(f"GridCoordinates/Coordinate{axis}", "DataArray_t") for axis in "XYZ"], axis=1)
            starts, corners, cell_starts, sides = (
                data(f"{section}/{array}", "DataArray_t")
                for section in ("Faces", "Cells") for array in ("ElementStartOffset", "ElementConnectivity")
            )  # fmt: skip
            np.testing.assert_array_equal(data("Faces/ElementRange", "IndexRange_t"), [1, len(starts) - 1])
            np.testing.assert_array_equal(zone[" data"][:, 0], [len(places), len(rows), 0])
            np.testing.assert_array_equal(data("Rows/Row", "DataArray_t"), rows)
            moments = []
            for begin, end in zip(starts, starts[1:]):
                area, center = area_and_center(places[corners[begin:end] - 1])
                moments.append((area, area @ center))
            for k, row in enumerate(rows):
                own = sides[cell_starts[k] : cell_starts[k + 1]]
                self.assertLess(np.linalg.norm(sum(np.sign(s) * moments[abs(s) - 1][0] for s in own)), 1e-13 * np.ptp(places))
                volume = sum(np.sign(s) * moments[abs(s) - 1][1] for s in own) / 3
                np.testing.assert_allclose(volume, volumes[row], rtol=1e-9, atol=1e-14)
            self.assertEqual(set(np.unique(np.abs(sides))), set(range(1, len(starts))))
            outer = np.flatnonzero(np.bincount(np.abs(sides))[1:] == 1) + 1
            ranges = [zone[f"{group}/{name}/PointRange/ data"][:, 0] for group in ("ZoneBC", "ZoneGridConnectivity")
                      for name in zone.get(group, {})]  # fmt: skip
            np.testing.assert_array_equal(np.sort(np.concatenate([np.arange(a, b + 1) for a, b in ranges])), outer)
            for connection in zone.get("ZoneGridConnectivity", {}).values():
                own = np.arange(connection["PointRange/ data"][0, 0], connection["PointRange/ data"][1, 0] + 1)
                step = connection["GridConnectivityProperty/Periodic/Translation/ data"][...]
                for a, b in zip(own, connection["PointListDonor/ data"][:, 0]):
                    here, there = (places[corners[starts[f - 1] : starts[f]] - 1].mean(axis=0) for f in (a, b))
                    np.testing.assert_allclose(here + step, there, atol=1e-6)

    @have("vtk")
    def test_cgns_by_vtk(self):
        try:
            from vtkmodules.vtkIOCGNSReader import vtkCGNSReader
        except ImportError:
            self.skipTest("this VTK reads no CGNS")
        t = cells(30)
        t.save(self.path("a.cgns"))
        reader = vtkCGNSReader()
        reader.SetFileName(self.path("a.cgns"))
        reader.UpdateInformation()
        reader.EnableAllBases()
        reader.EnableAllCellArrays()
        reader.Update()
        grid = reader.GetOutput().GetBlock(0).GetBlock(0)
        for i in range(30):
            cell, volume = grid.GetCell(i), 0
            for f in range(cell.GetNumberOfFaces()):
                points = cell.GetFace(f).GetPoints()
                corners = np.array([points.GetPoint(k) for k in range(points.GetNumberOfPoints())]) - t.centroids[i]
                area, center = area_and_center(corners)
                volume += area @ center / 3
            # VTK before 9.2 turns all faces inward.
            np.testing.assert_allclose(abs(volume), t.volumes[i], rtol=1e-12)

    def test_refusals(self):
        for t, message in (
            (cells(min_face=0.1), "cell .* is not closed, because it lacks a face: leave out min_face= and min_area="),
            (vt.tessellate(uniform(20)[:, :2], want="faces"), "three dimensions"),
            (cells(want="volumes"), "put 'faces' into want"),
            (cells(only=[3, 4]), "only="),
        ):
            for save in (t.save, lambda _, t=t: t.mesh_quality()):
                with self.assertRaisesRegex(ValueError, message if save == t.save else "faces|whole|only|space|three|closed"):
                    save(self.path("case.foam"))
        self.assertEqual([p.name for p in self.folder.rglob("*") if p.is_file()], [])


def torus(n, m):
    """Returns a torus of triangles around (1, 1, 0.4), with a hole along z."""
    u, v = (2 * np.pi * np.arange(k) / k for k in (n, m))
    r = 0.7 + 0.29 * np.cos(v)
    places = np.stack((np.outer(np.cos(u), r), np.outer(np.sin(u), r), np.outer(np.ones(n), 0.29 * np.sin(v))), axis=-1)
    at = np.arange(n * m).reshape(n, m)
    right, up, both = np.roll(at, -1, 0), np.roll(at, -1, 1), np.roll(at, (-1, -1), (0, 1))
    triangles = [np.stack((at, right, both), -1), np.stack((at, both, up), -1)]
    return places.reshape(-1, 3) + [1, 1, 0.4], np.concatenate(triangles).reshape(-1, 3)


def solids():
    """Yields results in meshes: with flat and round surfaces, a cavity, cells in several pieces, images, and ties."""
    radii = 0.3 * np.random.default_rng(5).random(40)
    yield vt.tessellate(uniform(40), mesh=CUBE)
    yield vt.tessellate(np.concatenate((uniform(40), uniform(2))), mesh=CUBE, radii=np.append(radii, radii[:2]))
    yield vt.tessellate(2 * uniform(40), mesh=ELL)
    yield vt.tessellate(2 * uniform(12, 4), mesh=torus(24, 10))
    yield vt.tessellate(2 * uniform(2), mesh=torus(24, 10))
    inner = 0.25 + CUBE[0] / 2
    hollow = (np.concatenate((CUBE[0], inner)), np.concatenate((CUBE[1], CUBE[1][:, ::-1] + 8)))
    yield vt.tessellate(uniform(40), mesh=hollow)
    yield vt.tessellate(np.array([(0.5, 0.5, 0.5)]), mesh=hollow)
    yield vt.tessellate(uniform(6), mesh=CUBE, box=(-0.5, -0.5, -0.5, 1.1, 1.1, 1.1), periodic=True)
    yield vt.tessellate(uniform(1), mesh=(0.9 * CUBE[0], CUBE[1]), box=UNIT_BOX, periodic=True)
    yield vt.tessellate(lattice(2) / 2, mesh=CUBE)  # planes meet on diagonals of faces
    yield vt.tessellate(lattice(4) / 4, mesh=CUBE)
    yield vt.tessellate(lattice(3) / 1.5, mesh=ELL)


class FoamOfPieces(FoamFolder):
    def check(self, t):
        """Checks closed cells, their volumes, pairs and patches. Returns what read() does."""
        t.save(self.path("case.foam"))
        points, faces, owner, neighbour, patches = mesh = self.read()
        pieces = t.pieces()
        inner, rows = len(neighbour), pieces.cells
        self.assertEqual(sorted(set(owner) | set(neighbour)), list(range(len(pieces))))
        pairs = list(zip(owner[:inner].tolist(), neighbour.tolist()))
        self.assertEqual(pairs, sorted(pairs), "upper-triangular order")
        self.assertTrue((owner[:inner] < neighbour).all())
        areas = []
        for face in faces:
            area, center = area_and_center(points[face])
            areas.append(area)
            self.assertEqual(len(set(face.tolist())), len(face))
            np.testing.assert_allclose((points[face] - center) @ area, 0, atol=1e-9 * np.linalg.norm(area), err_msg="flat")
        volumes, _ = self.closed_cells(mesh, pieces.centroids)
        np.testing.assert_allclose(volumes, pieces.volumes, rtol=1e-11)
        areas = np.linalg.norm(areas, axis=1)
        self.assertGreater(areas.min(), 0)
        # Pieces touch as their triangles say, and share as much.
        of_pieces = np.repeat(np.arange(len(pieces)), np.diff(pieces.triangle_offsets))
        corners = pieces.vertices[pieces.triangles + pieces.vertex_offsets[of_pieces][:, None]]
        sizes = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        expected = np.zeros((2, len(pieces), len(t)))
        between = ~pieces.on_surface
        np.add.at(expected[0], (of_pieces[between], pieces.sources[between]), sizes[between])
        for k, (i, j) in enumerate(pairs):
            expected[1, i, rows[j]] += areas[k]
            expected[1, j, rows[i]] += areas[k]
        np.testing.assert_allclose(expected[1], expected[0], atol=1e-11)
        end = inner
        for patch in patches.values():
            self.assertEqual((patch["type"], int(patch["startFace"])), ("patch", end))
            end += int(patch["nFaces"])
        self.assertEqual(end, len(faces))
        np.testing.assert_allclose(areas[inner:].sum(), sizes[pieces.on_surface].sum(), rtol=1e-11)
        q = t.mesh_quality()
        self.assertEqual((q.cells, q.faces, q.internal_faces, q.vertices),
                         (len(pieces), len(faces), inner, len(points)))  # fmt: skip
        return mesh

    def test_pieces(self):
        names = []
        for number, t in enumerate(solids()):
            with self.subTest(number):
                names.append(list(self.check(t)[-1]))
        self.assertEqual([len(n) for n in names], [1, 1, 1, 1, 1, 2, 2, 1, 1, 1, 1, 1])
        self.assertEqual(names[5], ["surface1", "surface2"])

    def test_short_edges_are_collapsed(self):
        t = vt.tessellate(uniform(60), mesh=CUBE)
        before = t.mesh_quality()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            t.save(self.path("case.foam"), min_edge=0.03)
        points, faces, owner, neighbour, _ = self.read()
        q = t.mesh_quality(min_edge=0.03)
        self.assertEqual((q.vertices, q.faces, q.wrong_faces, q.wrong_cells), (len(points), len(faces), 0, 0))
        self.assertLess(q.vertices, 0.95 * before.vertices)
        self.assertEqual(len(caught), q.short_edges > 0)
        self.assertTrue(set(map(tuple, CUBE[0])) <= set(map(tuple, points)), "corners of the mesh stay")
        for face in faces[len(neighbour) :]:
            on_side = [np.abs(points[face, k] - side).max() < 1e-13 for k in range(3) for side in (0, 1)]
            self.assertTrue(any(on_side), "the surface stays flat")
        fans = [np.cross(points[f[1:-1]], points[f[2:]]) @ points[f[0]] for f in faces[len(neighbour) :]]
        np.testing.assert_allclose(np.concatenate(fans).sum() / 6, 1, rtol=1e-12)

    def test_refusals(self):
        t = vt.tessellate(uniform(20), mesh=CUBE)
        some = vt.tessellate(uniform(20), mesh=CUBE, only=[3, 4])
        step = np.array([(0.5, 0.5, 0.5), (0.5, 1.5, 0.5)])  # the plane between them lies in the surface
        for save, message in (
            (lambda: t.save(self.path("a.tess")), "holds polygons of whole cells"),
            (lambda: t.pieces(gap=0.01).save(self.path("a.foam")), "do not share the face .* without a gap"),
            (lambda: t.pieces(gap=0.01).mesh_quality(), "do not share the face"),
            (lambda: some.pieces().save(self.path("a.msh")), "pieces of all cells: leave out only="),
            (lambda: t.pieces().save(self.path("a.msh"), ids=range(20)), "leave out ids"),
            (lambda: t.pieces().save(self.path("a.glb"), min_edge=1), ".glb keeps all edges"),
            (lambda: t.pieces().save(self.path("a.msh"), min_edge=-1), "pieces.min_edge is -1"),
            (lambda: vt.tessellate(step, mesh=ELL).save(self.path("a.foam")), "lies in the surface"),
        ):
            with self.assertRaisesRegex(ValueError, message):
                save()
        self.assertEqual([p.name for p in self.folder.rglob("*") if p.is_file()], [])


@unittest.skipIf(shutil.which("checkMesh") is None, "OpenFOAM is not installed")
class CheckMesh(Folder):
    def check(self, t):
        t.save(self.path("case.foam"), min_edge=0.02)
        system = self.folder / "system"
        system.mkdir(exist_ok=True)
        for name, content in (
            ("controlDict", "startTime 0; endTime 1; deltaT 1; writeInterval 1;"),
            ("fvSchemes", "ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {} interpolationSchemes {} snGradSchemes {}"),
            ("fvSolution", ""),
        ):  # fmt: skip
            head = f"FoamFile {{ version 2.0; format ascii; class dictionary; object {name}; }}\n"
            (system / name).write_text(head + content)
        done = subprocess.run(["checkMesh", "-case", str(self.folder)], capture_output=True, text=True)
        self.assertIn("\nMesh OK.\n", done.stdout, done.stdout + done.stderr)
        angle = float(re.search(r"non-orthogonality Max: (\S+)", done.stdout)[1])
        np.testing.assert_allclose(t.mesh_quality(min_edge=0.02).max_non_orthogonality, angle, rtol=1e-4)

    def test_cells_pass(self):
        for options in ({}, {"periodic": True}, {"mesh": CUBE}):
            domain = {"box": UNIT_BOX, **options} if "mesh" not in options else options
            relaxed = vt.lloyd(uniform(100), steps=10, **domain).points
            more = {} if "mesh" in options else {"want": WANT}
            with self.subTest(options), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self.check(vt.tessellate(relaxed, **domain, **more))


def read_tess(path):
    """Returns the sections of a .tess as lists of words, by name."""
    sections, name = {}, ""
    with open(path) as file:
        for line in file:
            if line.lstrip().startswith("*"):
                word = line.strip()
                name = word if word.startswith("**") else name.split("/")[0] + "/" + word
                sections[name] = []
            else:
                sections[name] += line.split()
    return sections


class Tess(Folder):
    def check(self, t):
        t.save(self.path("a.tess"))
        s = read_tess(self.path("a.tess"))
        held = np.flatnonzero(t.volumes > 0)
        self.assertEqual((s["**format"], s["**general"], s["**cell"]), (["3.5"], ["3", "standard"], [str(len(held))]))
        if len(held) < len(t):
            self.assertEqual([int(x) for x in s["**cell/*id"]], (held + 1).tolist())
        seeds = np.array(s["**cell/*seed"], float).reshape(-1, 5)
        np.testing.assert_array_equal(seeds[:, 1:4], t.points[held])
        weights = np.zeros(len(t)) if t.weights is None else t.weights
        np.testing.assert_allclose(seeds[:, 4] ** 2, weights[held] - min(weights.min(), 0), rtol=1e-15, atol=1e-300)
        vertices = np.array(s["**vertex"][1:], float).reshape(-1, 5)[:, 1:4]
        edges = np.array(s["**edge"][1:], int).reshape(-1, 4)[:, 1:3]
        self.assertEqual(len(np.unique(edges, axis=0)), len(edges))
        words, faces = iter(s["**face"][1:]), []
        for number in range(int(s["**face"][0])):
            self.assertEqual(int(next(words)), number + 1)
            corners = [int(next(words)) for _ in range(int(next(words)))]
            signed = [int(next(words)) for _ in range(int(next(words)))]
            ends = [edges[abs(e) - 1][:: 1 if e > 0 else -1].tolist() for e in signed]
            self.assertEqual(ends, [[a, b] for a, b in zip(corners, corners[1:] + corners[:1])])
            d, *normal = (float(next(words)) for _ in range(4))
            self.assertEqual([next(words) for _ in range(5)], ["0"] * 5)
            area, _ = area_and_center(vertices[np.array(corners) - 1])
            np.testing.assert_allclose(normal, area / np.linalg.norm(area), atol=1e-6)
            np.testing.assert_allclose(vertices[np.array(corners) - 1] @ normal, d, atol=1e-9)
            faces.append(np.array(corners) - 1)
        words = iter(s["**polyhedron"][1:])
        for i in held:
            next(words)
            volume = 0.0
            for face in [int(next(words)) for _ in range(int(next(words)))]:
                area, center = area_and_center(vertices[faces[abs(face) - 1]])
                volume += np.sign(face) * area @ (center - t.centroids[i]) / 3
            np.testing.assert_allclose(volume, t.volumes[i], rtol=1e-12)
        self.check_domain(s, vertices, edges, faces)
        return s

    def check_domain(self, s, vertices, edges, faces):
        words = iter(s["**domain/*vertex"][1:])
        corners = []
        for _ in range(int(s["**domain/*vertex"][0])):
            next(words)
            place = [float(next(words)) for _ in range(3)]
            next(words)
            self.assertEqual(next(words), "1")
            np.testing.assert_allclose(place, vertices[int(next(words)) - 1], atol=1e-15)
            corners.append(place)
        corners = np.array(corners)
        words = iter(s["**domain/*edge"][1:])
        ends = []
        for _ in range(int(s["**domain/*edge"][0])):
            next(words)
            ends.append([int(next(words)) for _ in range(int(next(words)))])
            next(words)
            a, b = corners[np.array(ends[-1]) - 1]
            parts = [edges[int(next(words)) - 1] - 1 for _ in range(int(next(words)))]
            lengths = sum(np.linalg.norm(vertices[p[0]] - vertices[p[1]]) for p in parts)
            np.testing.assert_allclose(lengths, np.linalg.norm(a - b), rtol=1e-12)
        words = iter(s["**domain/*face"][1:])
        held = []
        for _ in range(int(s["**domain/*face"][0])):
            next(words)
            loop = [int(next(words)) for _ in range(int(next(words)))]
            around = [int(next(words)) for _ in range(int(next(words)))]
            for k, e in enumerate(around):
                self.assertEqual(sorted(ends[e - 1]), sorted((loop[k], loop[(k + 1) % len(loop)])))
            self.assertEqual([next(words), next(words)], ["plane", "4"])
            d, *normal = (float(next(words)) for _ in range(4))
            next(words)
            parts = [int(next(words)) - 1 for _ in range(int(next(words)))]
            held += parts
            for f in parts:
                np.testing.assert_allclose(vertices[faces[f]] @ normal, d, atol=1e-13)
            inside = corners.mean(axis=0)
            self.assertGreater(inside @ normal, d, "normals lead inward")
            whole = np.linalg.norm(area_and_center(corners[np.array(loop) - 1])[0])
            np.testing.assert_allclose(sum(np.linalg.norm(area_and_center(vertices[faces[f]])[0]) for f in parts), whole)
        self.assertEqual(len(held), len(set(held)))
        self.assertEqual(len(corners) - len(ends) + int(s["**domain/*face"][0]), 2)

    def test_tessellations(self):
        kinds = []
        for t in domains():
            if any(t.periodic):
                with self.assertRaisesRegex(ValueError, "no periodic boundary here: .*leave|without periodic="):
                    t.save(self.path("a.tess"))
            else:
                kinds.append(self.check(t)["**domain/*general"])
        self.assertEqual(kinds, [["cube"], ["poly"], ["cube"]])
        self.check(vt.tessellate(uniform(30), cell=CELL, periodic=False, outside="drop", want=WANT))
        self.check(vt.tessellate(uniform(30), box=UNIT_BOX, weights=uniform(30)[:, 0] - 0.5, want=WANT))
        self.check(vt.tessellate(uniform(1), box=UNIT_BOX, want=WANT))

    def test_walls_are_read_again(self):
        """Planes of walls come from rounded corners: those along an axis must stay so."""
        for seed in range(12):
            points = np.random.default_rng(seed).random((3, 3))
            t = vt.tessellate(points, box=UNIT_BOX, walls=[(1, 1, 1, 2.25)], outside="keep", want=WANT)
            t.save(self.path("a.tess"))
            frame, = vt.read_frames(self.path("a.tess"))
            again = frame.tessellate(outside="keep", want="volumes")
            held = np.flatnonzero(t.volumes > 0)
            np.testing.assert_allclose(again.volumes, t.volumes[held], rtol=1e-9)


class Stl(Folder):
    def test_solids(self):
        for t in domains():
            t.save(self.path("a.stl"))
            text = (self.folder / "a.stl").read_text()
            solids = re.findall(r"solid (\d+)\n(.*?)endsolid \1\n", text, re.S)
            held = np.flatnonzero(t.volumes > 0)
            self.assertEqual([int(name) for name, _ in solids], held.tolist())
            seen = {}
            for (name, facets), i in zip(solids, held):
                numbers = np.array(re.findall(r"(?:normal|vertex) (\S+) (\S+) (\S+)", facets), float).reshape(-1, 4, 3)
                normals, corners = numbers[:, 0], numbers[:, 1:]
                area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                np.testing.assert_allclose(np.linalg.norm(area, axis=1)[:, None] * normals, area, atol=1e-14)
                np.testing.assert_allclose(enclosed(corners), t.volumes[i], rtol=1e-12)
                numbers = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)[1]
                self.assertTrue(is_closed(numbers.reshape(-1, 3)))
                places = [tuple(map(tuple, f)) for f in corners]
                for f in places:
                    seen.setdefault(frozenset(f), []).append(i)
            if not any(t.periodic):
                inner = sum((np.asarray(row) >= 0).sum() for row in t.neighbors) // 2
                shared = [pair for pair in seen.values() if len(pair) == 2]
                self.assertEqual(len({tuple(pair) for pair in shared}), inner, "two cells have the same triangles")
                self.assertLessEqual(max(map(len, seen.values())), 2)


    def volumes_of_solids(self, t, length):
        """Returns the volumes in a file, after checks of mesh_quality() against it."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            t.save(self.path("a.stl"), min_edge=length)
        volumes = []
        for facets in re.findall(r"solid \d+\n(.*?)endsolid", (self.folder / "a.stl").read_text(), re.S):
            corners = np.array(re.findall(r"vertex (\S+) (\S+) (\S+)", facets), float).reshape(-1, 3, 3)
            volumes.append(enclosed(corners))
        q = t.mesh_quality(min_edge=length)
        self.assertEqual(q.wrong_cells, sum(v <= 0 for v in volumes))
        self.assertLessEqual(q.min_volume, min(volumes) + 1e-14)
        return np.array(volumes), q

    def test_short_edges_leave_no_cell_inside_out(self):
        """Cells thinner than the length: the quadrangles between them bend, and no fan turns a cell inside out."""
        rng = np.random.default_rng(1)
        line, plane = np.full((38, 3), 0.5), np.full((40, 3), 0.5)
        line[:, 0] = np.random.default_rng(1).random(38)
        plane[:, :2] = rng.random((40, 2))
        skew = line + 1e-3 * rng.random((38, 3))
        for points in (line, plane, skew):
            for length in (0.01, 0.05, 0.2):
                with self.subTest(points=points[0], length=length):
                    t = vt.tessellate(points, box=UNIT_BOX, want=WANT)
                    volumes, _ = self.volumes_of_solids(t, length)
                    share = volumes / t.volumes
                    self.assertTrue(((share >= 0.5 - 1e-9) & (share <= 1.5 + 1e-9)).all(), (share.min(), share.max()))
                    np.testing.assert_allclose(volumes.sum(), 1, rtol=1e-12)

    def test_rounded_lattices(self):
        """Corners that rounding sets apart become one: the cells are those of the lattice."""
        half = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]])
        rng = np.random.default_rng(1)
        for m in (3, 4, 5, 6, 7):
            grid = np.stack(np.meshgrid(*3 * [np.arange(m) / m], indexing="ij"), -1).reshape(-1, 3)
            for name, cell, faces in (("fcc", half, 12), ("bcc", np.array([[0, 0, 0], [0.5, 0.5, 0.5]]), 14), ("cubic", half[:1], 6)):
                points = np.concatenate([grid + offset / m for offset in cell])
                if name == "cubic":
                    points = points + rng.integers(-2, 3, points.shape) * 2.0**-52
                with self.subTest(name=name, m=m):
                    t = vt.tessellate(points, box=UNIT_BOX, periodic=True, want=WANT)
                    volumes, q = self.volumes_of_solids(t, 1e-6)
                    self.assertEqual((q.short_edges, q.wrong_faces, q.wrong_cells), (0, 0, 0))
                    self.assertEqual(q.faces + q.internal_faces, faces * len(points))
                    np.testing.assert_allclose(volumes, 1 / len(points), rtol=1e-9)


class Msh(Folder):
    def test_surfaces(self):
        for t in domains():
            t.save(self.path("a.msh"))
            names, groups, hulls, nodes, triangles = read_msh(self.path("a.msh"))
            held = np.flatnonzero(t.volumes > 0)
            self.assertEqual([group for group, _ in hulls.values()], (held + 1).tolist())
            every = np.concatenate(list(triangles.values()))
            self.assertEqual(len(np.unique(np.sort(every, axis=1), axis=0)), len(every), "each triangle once")
            for i, (group, hull) in zip(held, hulls.values()):
                self.assertEqual(names[3, group], f"cell {i}")
                corners = np.concatenate([triangles[abs(s)][:, :: 1 if s > 0 else -1] for s in hull])
                self.assertTrue(is_closed(corners))
                np.testing.assert_allclose(enclosed(nodes[corners]), t.volumes[i], rtol=1e-12)
                for s in hull:
                    if re.fullmatch(r"\d+ \d+", names[2, groups[abs(s)]]):
                        self.assertIn(str(i), names[2, groups[abs(s)]].split())

    def test_both_sides_of_a_period_have_the_same_triangles(self):
        t = cells(30, periodic="z")
        t.save(self.path("a.msh"))
        names, groups, _, nodes, triangles = read_msh(self.path("a.msh"))
        sides = {}
        for surface, corners in triangles.items():
            name = names[2, groups[surface]]
            if name.startswith("periodic"):
                shift = int(name.split("_")[3])
                places = nodes[corners] - [0, 0, max(shift, 0)]
                sides.setdefault(shift, []).append(np.sort(np.round(places, 9), axis=1).reshape(-1, 9))
        up, down = (np.unique(np.concatenate(sides[s]) + 0.0, axis=0) for s in (1, -1))
        np.testing.assert_allclose(up, down, atol=1e-8)

    @have("gmsh")
    def test_gmsh(self):
        self.mesh_by_gmsh(cells(12))
        self.mesh_by_gmsh(vt.tessellate(2 * uniform(8), mesh=ELL))

    def mesh_by_gmsh(self, t):
        import gmsh

        t.save(self.path("a.msh"))
        gmsh.initialize(interruptible=False)
        try:
            gmsh.option.setNumber("General.Verbosity", 1)
            gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
            gmsh.open(self.path("a.msh"))
            gmsh.model.mesh.createGeometry()
            gmsh.model.mesh.generate(3)
            tags, places, _ = gmsh.model.mesh.getNodes()
            nodes = np.zeros((int(tags.max()) + 1, 3))
            nodes[tags.astype(int)] = places.reshape(-1, 3)
            volumes, inside = np.zeros(len(t)), []
            for _, group in gmsh.model.getPhysicalGroups(3):
                for entity in gmsh.model.getEntitiesForPhysicalGroup(3, group):
                    for corners in gmsh.model.mesh.getElements(3, entity)[2]:
                        corners = corners.reshape(-1, 4).astype(int)
                        inside.append(corners)
                        a, b, c, d = (nodes[corners[:, k]] for k in range(4))
                        volumes[group - 1] += np.abs(np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a))).sum() / 6
            np.testing.assert_allclose(volumes, t.volumes, rtol=1e-10)
            # Conforming: a triangle has two tetrahedra, or one on a wall.
            corners = np.sort(np.concatenate(inside), axis=1)
            faces = np.concatenate([np.delete(corners, k, axis=1) for k in range(4)])
            unique, counts = np.unique(faces, axis=0, return_counts=True)
            self.assertLessEqual(counts.max(), 2)
            alone = nodes[unique[counts == 1]]
            on_wall = [np.isclose(alone[:, :, k], side, rtol=0, atol=1e-9).all(axis=1) for k in range(3) for side in (0, 1, 2)]
            self.assertTrue(np.any(on_wall, axis=0).all())
        finally:
            gmsh.finalize()


if __name__ == "__main__":
    unittest.main()

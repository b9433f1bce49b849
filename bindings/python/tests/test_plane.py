"""Two dimensions: points of shape (N, 2)."""

import os
import pickle
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
from helpers import have

import pyvotess as vt

POINTS = np.random.default_rng(5).random((400, 2))
BOX = (0, 0, 1, 1)
EVERYTHING = "neighbors,volumes,centroids,counts,areas,normals,surfaces,radii,faces"


def area_and_centroid(polygon):
    x, y = polygon.T
    after_x, after_y = np.roll(x, -1), np.roll(y, -1)
    cross = x * after_y - after_x * y
    area = cross.sum() / 2
    return area, np.array([((x + after_x) * cross).sum(), ((y + after_y) * cross).sum()]) / (6 * area)


class Plane(unittest.TestCase):
    def test_measures_are_those_of_the_polygons(self):
        for domain in ({"box": BOX}, {"box": BOX, "periodic": True}, {"box": BOX, "periodic": "y"}, {}):
            with self.subTest(**domain):
                t = vt.tessellate(POINTS, want=EVERYTHING, list_walls=True, **domain)
                self.assertTrue(t.planar)
                self.assertEqual((t.centroids.shape, t.vertices.shape[1], t.box.shape), ((400, 2), 2, (2, 2)))
                self.assertEqual(t.face_normals.shape, (len(t.indices), 2))
                for i, polygon in enumerate(t.polygons):
                    area, centroid = area_and_centroid(polygon)
                    self.assertAlmostEqual(area, t.volumes[i], delta=1e-12)
                    np.testing.assert_allclose(centroid, t.centroids[i], atol=1e-9)
                    sides = np.linalg.norm(polygon - np.roll(polygon, -1, axis=0), axis=1)
                    self.assertAlmostEqual(sides.sum(), t.surface_areas[i], delta=1e-12)
                    self.assertEqual(len(polygon), t.face_counts[i])
                self.assertTrue(t.verify())

    @have("scipy")
    def test_neighbors_are_those_of_qhull(self):
        from scipy.spatial import Voronoi

        # Far walls cut no ridge between two cells, except those that leave the box.
        t = vt.tessellate(POINTS, box=(-1e6, -1e6, 1e6, 1e6))
        ours = {(i, j) for i in range(400) for j in t.neighbors[i] if i < j}
        diagram = Voronoi(POINTS)
        theirs = {tuple(sorted(pair)) for pair in diagram.ridge_points.tolist()}
        infinite = {
            tuple(sorted(pair))
            for pair, ends in zip(diagram.ridge_points.tolist(), diagram.ridge_vertices)
            if -1 in ends
        }
        self.assertLessEqual(ours ^ theirs, infinite)
        self.assertLess(len(ours ^ theirs), 3)

    def test_domains(self):
        oblique = POINTS @ [[1, 0], [0.3, 1]]
        t = vt.tessellate(oblique, cell=((1, 0), (0.3, 1)))
        self.assertEqual((t.cell.shape, t.origin.shape, t.periodic), ((2, 2), (2,), (True, True)))
        self.assertAlmostEqual(t.volumes.sum(), 1, delta=1e-12)
        t = vt.tessellate(oblique, cell=((1, 0), (0.3, 1)), origin=(0.25, -0.5), periodic="x", outside="drop")
        self.assertEqual(t.periodic, (True, False))
        t = vt.tessellate(POINTS, box=BOX, walls=[(1, 1, 1.5)], outside="drop", list_walls=True)
        self.assertAlmostEqual(t.volumes.sum(), 1 - 0.125, delta=1e-12)
        np.testing.assert_array_equal(t.walls, [(1, 1, 1.5)])
        self.assertEqual(min(row.min() for row in t.neighbors if len(row)), -7)
        t = vt.tessellate(np.float32(POINTS), box=BOX, periodic=(True, False), radii=np.full(400, 0.01))
        self.assertAlmostEqual(t.volumes.sum(), 1, delta=1e-12)

    def test_kept_objects_and_files(self):
        with vt.Tessellator(device="cpu") as tessellator:
            first = tessellator.tessellate(POINTS, box=BOX, periodic=True, want="neighbors,volumes,vertices")
            solid = tessellator.tessellate(np.random.default_rng(1).random((50, 3)))
            again = tessellator.tessellate(POINTS, box=BOX, periodic=True, want="neighbors,volumes,vertices")
        self.assertFalse(solid.planar)
        np.testing.assert_array_equal(first.indices, again.indices)
        copy = pickle.loads(pickle.dumps(first))
        np.testing.assert_array_equal(copy.volumes, first.volumes)
        self.assertTrue(copy.verify())
        moved = POINTS + [3, -2]
        t = vt.tessellate(moved, box=BOX, periodic=True)
        np.testing.assert_allclose(t.wrapped_points, POINTS, atol=1e-15)
        pairs = t.pairs()
        self.assertEqual(pairs.vector.shape[1], 2)
        self.assertLess(pairs.distance.max(), 0.5)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "plane.npz")
            first.save(path)
            with np.load(path) as arrays:
                self.assertEqual((arrays["box"].shape, arrays["vertices"].shape[1]), ((2, 2), 2))

    def test_files_of_clvotess_are_the_same(self):
        program = os.environ.get("VOTESS_CLI")
        if not program:
            self.skipTest("VOTESS_CLI names no clvotess")
        cases = (
            (["--box", "0,0,1,1", "--periodic", "y"], {"box": BOX, "periodic": "y"}),
            (["--cell", "1,0,0.25,1", "--origin", "0.5,-1"], {"cell": ((1, 0), (0.25, 1)), "origin": (0.5, -1)}),
            (["--box", "0,0,1,1", "--wall", "1,1,1.5", "--outside", "keep"], {"box": BOX, "walls": [(1, 1, 1.5)], "outside": "keep"}),
            ([], {}),
        )
        with tempfile.TemporaryDirectory() as folder:
            np.save(Path(folder, "points.npy"), POINTS)
            for options, domain in cases:
                with self.subTest(**domain):
                    vt.tessellate(POINTS, want=EVERYTHING, list_walls=True, device="cpu", **domain).save(Path(folder, "ours.npz"))
                    command = [program, "points.npy", *options, "-x", "cpu", "--list-walls", "--want", EVERYTHING, "-o", "theirs.npz", "-q"]
                    subprocess.run(command, cwd=folder, check=True)
                    with np.load(Path(folder, "ours.npz")) as ours, np.load(Path(folder, "theirs.npz")) as theirs:
                        self.assertEqual(set(ours.files), set(theirs.files))
                        for name in set(ours.files) - {"domain_from", "periodic_from"}:
                            np.testing.assert_array_equal(ours[name], theirs[name], name)
                            self.assertEqual(ours[name].dtype, theirs[name].dtype, name)

    def test_frames_of_files(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "plane.npz")
            t = vt.tessellate(POINTS, cell=((1, 0), (0.25, 1)), origin=(0.5, -1), periodic="x", outside="drop")
            t.save(path, columns={"points": POINTS})
            frame, = vt.read_frames(path, columns=())
            np.testing.assert_array_equal(frame.points, POINTS)
            self.assertEqual(frame.domain["periodic"], (True, False))
            again = frame.tessellate(outside="drop")
            self.assertTrue(again.planar)
            np.testing.assert_array_equal(again.volumes, t.volumes)
            path = Path(folder, "plane.txt")
            path.write_text("".join(f"{x!r} {y!r}\n" for x, y in POINTS.tolist()))
            np.testing.assert_array_equal(next(vt.read_frames(path)).points, POINTS)

    @have("matplotlib")
    def test_a_plot_fills_the_box(self):
        import matplotlib

        matplotlib.use("Agg")
        axes = vt.tessellate(POINTS, box=BOX, periodic=True, want="volumes,vertices").plot()
        polygons = [path.vertices[:-1] for path in axes.collections[0].get_paths()]
        inside = [np.clip(polygon, 0, 1) for polygon in polygons]
        self.assertGreater(len(polygons), 400)
        self.assertGreaterEqual(sum(abs(area_and_centroid(p)[0]) for p in inside if np.ptp(p, axis=0).min() > 0), 1 - 1e-9)
        with self.assertRaisesRegex(ValueError, "vertices"):
            vt.tessellate(POINTS, box=BOX).plot()

    def test_boxes_as_limits(self):
        """((x0, x1), (y0, y1)) as in space; what may also be two corners is refused."""
        points = np.array([(0.25, 2.25), (0.75, 2.75), (0.5, 2.5)])
        for box, corners in (
            (((0, 1), (2, 3)), None),
            (((0, 2), (1, 3)), None),  # area 1 as corners, 4 as limits
            (((0, 2), (1, 4)), None),
            (((0, 2), (2, 3)), (0, 2, 2, 3)),
            (((0, 1), (1, 3)), (0, 1, 1, 3)),  # the same in both ways
            (((0, 2), (2.0, 3)), (0, 2, 2, 3)),
            (((-1, 2), (-1, 3)), (-1, -1, 2, 3)),
            (((-1, -1), (1, 3)), (-1, -1, 1, 3)),
            ((-1, -1, 1, 3), (-1, -1, 1, 3)),
            (((0, 4), (1.5, 3)), (0, 1.5, 4, 3)),
        ):
            with self.subTest(box):
                if corners is None:
                    with self.assertRaisesRegex(ValueError, r"may be two corners or the limits.*\(x0, y0, x1, y1\)"):
                        vt.tessellate(points, box=box)
                    continue
                t = vt.tessellate(points, box=box, outside="keep")
                x0, y0, x1, y1 = corners
                self.assertAlmostEqual(t.volumes.sum(), (x1 - x0) * (y1 - y0))

    def test_refusals(self):
        for text, arguments in (
            ("box has shape", {"box": (0, 0, 0, 1, 1, 1)}),
            ("cell", {"cell": np.eye(3)}),
            ("walls", {"walls": [(1, 0, 0, 1)]}),
            ("z repeats", {"box": BOX, "periodic": "xz"}),
        ):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                vt.tessellate(**{"points": POINTS, **arguments})
        t = vt.tessellate(POINTS, box=BOX, want="faces,volumes,areas")
        for call in (t.delaunay, t.voronoi_indices, lambda: t.save("x.vtu")):
            with self.subTest(call), self.assertRaisesRegex(ValueError, "three dimensions"):
                call()
        with self.assertRaises(AttributeError):
            vt.tessellate(np.zeros((1, 3))).polygons  # noqa: B018
        with self.assertRaises(ValueError):
            vt.Diagram(POINTS)


if __name__ == "__main__":
    unittest.main()

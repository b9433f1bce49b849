"""Copies and pickles of results."""

import copy
import os
import pickle
import subprocess
import sys
import unittest

import numpy as np
from helpers import CELL, PACKAGE_PARENT, UNIT_BOX, uniform

import pyvotess as vt

EVERYTHING = "neighbors,volumes,centroids,counts,areas,normals,surfaces,radii,vertices,faces"
ARRAYS = (
    "volumes", "centroids", "face_areas", "face_normals", "surface_areas", "security_radii", "vertices", "face_counts",
    "edge_counts", "vertex_counts", "status", "duplicate_of", "shifts", "box", "cell", "origin", "walls", "weights",
    "points", "wrapped_points",
)


def results():
    points = uniform(80)
    twice = np.concatenate((points, points[:2]))
    yield vt.tessellate(twice, box=UNIT_BOX, want=EVERYTHING)
    yield vt.tessellate(twice.astype(np.float32), want=EVERYTHING)
    yield vt.tessellate(3 * points - 1, box=UNIT_BOX, periodic=True, want=EVERYTHING)
    yield vt.tessellate(points, cell=CELL, periodic="xy", outside="drop", want=EVERYTHING)
    yield vt.tessellate(points, walls=[(1, 1, 1, 2)], outside="drop", want=EVERYTHING)
    yield vt.tessellate(points, box=UNIT_BOX, radii=0.2 * uniform(80, 5)[:, 0], want=EVERYTHING)
    yield vt.tessellate(points, want=())
    yield vt.tessellate(points[:0], want=EVERYTHING)


class Pickles(unittest.TestCase):
    def same(self, t, other):
        self.assertEqual((len(t), repr(t), t.stats, t.periodic, t.wanted), (len(other), repr(other), other.stats,
                                                                           other.periodic, other.wanted))
        self.assertEqual((t.lists_walls, t.least_face), (other.lists_walls, other.least_face))
        for name in ARRAYS:
            if not hasattr(t, name):
                self.assertFalse(hasattr(other, name))
                continue
            ours, theirs = getattr(t, name), getattr(other, name)
            if ours is None:
                self.assertIsNone(theirs)
                continue
            np.testing.assert_array_equal(theirs, ours, name)
            self.assertEqual((theirs.dtype, theirs.shape), (ours.dtype, ours.shape))
            self.assertEqual(theirs.flags.writeable, ours.flags.writeable, name)
        for name in ("neighbors", "faces", "cell_vertices"):
            if hasattr(t, name):
                for part in ("indptr", "indices"):
                    np.testing.assert_array_equal(getattr(getattr(other, name), part), getattr(getattr(t, name), part))
                self.assertIs(type(getattr(other, name)), type(getattr(t, name)))

    def test_all_arrays(self):
        for t in results():
            for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
                self.same(t, pickle.loads(pickle.dumps(t, protocol)))
            for function in (copy.copy, copy.deepcopy):
                self.same(t, function(t))
            self.same(t, pickle.loads(pickle.dumps(copy.deepcopy(pickle.loads(pickle.dumps(t))))))

    def test_buffers_beside_the_pickle(self):
        t = next(results())
        buffers = []
        content = pickle.dumps(t, 5, buffer_callback=buffers.append)
        self.assertLess(len(content), 5000)
        self.same(t, pickle.loads(content, buffers=buffers))

    def test_what_is_derived(self):
        for t in results():
            other = pickle.loads(pickle.dumps(t))
            self.assertIsNone(other._result)
            if not t.wanted:
                continue
            for name in ("i", "j", "shift", "vector", "distance", "area"):
                np.testing.assert_array_equal(getattr(other.pairs(), name), getattr(t.pairs(), name))
            np.testing.assert_array_equal(other.voronoi_indices(0.01), t.voronoi_indices(0.01))
            self.assertIsNone(other._result, "the arrays are enough")

    def test_what_needs_the_library(self):
        for t in results():
            other = pickle.loads(pickle.dumps(t))
            ours, theirs = t.verify(), other.verify()
            self.assertTrue(theirs, theirs.failure)
            self.assertEqual(theirs, ours)
            if not t.wanted:
                continue
            ours, theirs = t.delaunay(), pickle.loads(pickle.dumps(t)).delaunay()
            for name in ("tetrahedra", "centers", "polytope_centers", "shifts", "polytope_shifts"):
                np.testing.assert_array_equal(getattr(theirs, name), getattr(ours, name))
            np.testing.assert_array_equal(other.wrapped_points, t.wrapped_points)
            self.same(t, pickle.loads(pickle.dumps(other)))

    def test_dropped_faces(self):
        t = vt.tessellate(uniform(200), want="faces,volumes", min_face=0.2)
        other = pickle.loads(pickle.dumps(t))
        self.same(t, other)
        self.assertGreater(other.least_face, 0)
        self.assertTrue(other.verify())
        with self.assertRaisesRegex(ValueError, "min_face"):
            other.delaunay()  # kept faces would collapse

    def test_a_changed_pickle_is_found(self):
        t = vt.tessellate(uniform(50), box=UNIT_BOX, want="faces,volumes")
        for name in ("indices", "volumes", "face_vertices"):
            other = pickle.loads(pickle.dumps(t))
            changed = other._data.arrays[name].copy()
            changed[3] += 1
            other._data.arrays[name] = changed
            report = other.verify()
            self.assertFalse(report)
            self.assertIn(name, report.failure)
            with self.assertRaisesRegex(vt.VotessError, name) as caught:
                other.delaunay()
            self.assertEqual(caught.exception.code, vt.ErrorCode.INVALID_USE)

    def test_a_changed_number_is_found_by_the_size_of_its_cell(self):
        """Also beside infinite numbers, much larger cells, and far from the origin."""
        points = uniform(60)
        points[30:] = 0.3 + 1e-5 * points[30:]
        sets = [(points, {"box": "none"}), (points, {"box": UNIT_BOX}), (points[:, :2], {"box": (0, 0, 1, 1)}),
                (points + 2.0**20, {"box": 2.0**20 + np.array(UNIT_BOX)}), (points, {"box": UNIT_BOX, "periodic": True}),
                (points, {"box": UNIT_BOX, "only": range(20, 50), "weights": np.full(60, 0.5)})]  # fmt: skip
        for given, domain in sets:
            for instructions in ("baseline", ""):  # other last digits
                t = vt.tessellate(given, **domain, want=EVERYTHING, instructions=instructions)
                self.assertTrue(pickle.loads(pickle.dumps(t)).verify())
            small = int(np.argmin(t.volumes))
            entry, corner = int(t.neighbors.indptr[small + 1]) - 1, int(t.cell_vertices[small][0])
            size = t.volumes[small] ** (1 / t.points.shape[1])
            places = (("volumes", small), ("surface_areas", small), ("security_radii", small), ("face_areas", entry))
            for name, place in (*places, ("centroids", (small, 0)), ("vertices", (corner, 0)), ("face_normals", (entry, 0))):
                with self.subTest(name, domain=domain):
                    other = pickle.loads(pickle.dumps(t))
                    changed = other._data.arrays[name].copy()
                    if name == "face_areas":
                        place = int(t.neighbors.indptr[small]) + int(np.argmax(changed[t.neighbors.indptr[small] : entry + 1]))
                    changed[place] += 0.01 * (size if name in ("centroids", "vertices") else 1 if name == "face_normals" else changed[place])
                    other._data.arrays[name] = changed
                    report = other.verify()
                    self.assertFalse(report)
                    self.assertIn(f"different {name}", report.failure)

    def test_a_pickle_that_no_run_gives_is_found(self):
        t = vt.tessellate(uniform(50), box=UNIT_BOX, only=[3, 5, 7], want="neighbors,volumes")
        for ids, says in (([3, 3, 7], "seed 3 at place 1 was named before"), ([3, 5, 50], "50"), ([-1, 5, 7], "-1"), ([5, 3, 7], "different")):
            other = pickle.loads(pickle.dumps(t))
            other._data.arrays["ids"] = np.array(ids, np.int32)
            report = other.verify()
            self.assertFalse(report)
            self.assertRegex(report.failure, says)

    def test_a_copy_shares_and_a_deep_copy_does_not(self):
        t = vt.tessellate(uniform(50))
        self.assertIs(copy.copy(t).volumes, t.volumes)
        self.assertFalse(np.shares_memory(copy.deepcopy(t).volumes, t.volumes))

    def test_in_another_process(self):
        t = vt.tessellate(uniform(50), want="faces,volumes")
        code = (
            "import pickle, sys, pyvotess\n"
            "t = pickle.load(sys.stdin.buffer)\n"
            "print(len(t), t.delaunay().tetrahedra.shape[0], bool(t.verify()))\n"
        )
        done = subprocess.run([sys.executable, "-c", code], input=pickle.dumps(t), capture_output=True, check=True,
                              env=dict(os.environ, PYTHONPATH=PACKAGE_PARENT))
        self.assertEqual(done.stdout.decode().split(), ["50", str(len(t.delaunay().tetrahedra)), "True"])


if __name__ == "__main__":
    unittest.main()

"""Diagram: locate() and probe()."""

import _thread
import copy
import io
import os
import pickle
import subprocess
import sys
import threading
import time
import unittest
from contextlib import redirect_stderr

import numpy as np
from helpers import CELL, CUBE, PACKAGE_PARENT, UNIT_BOX, lattice, uniform

import pyvotess as vt  # noqa: E402


class Diagrams(unittest.TestCase):
    def test_domain(self):
        points = uniform(20)
        slanted = vt.Domain.cell([(1, 0.1, 0.2), (0.3, 0.9, 0), (0, 0, 0)])
        for given, domain in ((None, vt.Domain.space()), (slanted, slanted), (vt.Domain.hull(), vt.Domain.hull()),
                              (vt.Domain.mesh(CUBE), vt.Domain.mesh(CUBE))):
            d = vt.Diagram(points, given)
            self.assertEqual(d.domain, domain)
            np.testing.assert_array_equal(vt.Diagram(points, d.domain).locate(points + 0.1), d.locate(points + 0.1))
        self.assertEqual(vt.Diagram(points[:, :2]).domain, vt.Domain.space())

    def test_slab_without_end(self):
        """Answers are those of the seeds among their images."""
        rng = np.random.default_rng(8)
        points, queries = (np.floor(rng.random((count, 3)) * 2**20) / 2**20 for count in (200, 60))
        queries[:20, 2] = 40 * queries[:20, 2] - 20
        queries[20:, 2] = 0.25 + 0.5 * queries[20:, 2]  # others may meet their own images
        shifts = [(0, 0, 0), *((i, j, 0) for i in range(-2, 3) for j in range(-2, 3) if i or j)]
        slab = vt.Diagram(points, box=((0, 1), (0, 1), (-np.inf, np.inf)), periodic="xy")
        images = vt.Diagram(np.concatenate([points + shift for shift in shifts]), box="none")
        np.testing.assert_array_equal(slab.locate(queries), images.locate(queries) % 200)
        ours, theirs = (d.probe(queries[20:], want="volumes,neighbors") for d in (slab, images))
        np.testing.assert_allclose(ours.volumes, theirs.volumes, rtol=1e-9)
        for row, other in zip(ours.neighbors, theirs.neighbors):
            self.assertEqual(sorted(row), sorted(j % 200 for j in other))
        values = rng.random(200)
        expected = images.interpolate(np.tile(values, 25), queries[20:])
        np.testing.assert_allclose(slab.interpolate(values, queries[20:]), expected, rtol=1e-9)
        with self.assertRaisesRegex(vt.VotessError, "meets its own image"):
            slab.interpolate(values, queries)

    def test_locate(self):
        points, queries = uniform(2000), uniform(3000, seed=2)
        d = vt.Diagram(points, box=UNIT_BOX, radii=0.05 * uniform(2000, seed=3)[:, 0])
        self.assertEqual(len(d), 2000)
        found = d.locate(queries)
        self.assertEqual((found.dtype, found.shape), (np.int32, (3000,)))
        powers = ((queries[:, None] - points) ** 2).sum(axis=2) - (0.05 * uniform(2000, seed=3)[:, 0]) ** 2
        np.testing.assert_array_equal(found, powers.argmin(axis=1))
        self.assertEqual(d.locate(np.empty((0, 3))).shape, (0,))
        with self.assertRaisesRegex(ValueError, r"values has shape \(2000, 0\): give"):
            d.interpolate(np.empty((2000, 0)), queries)

    def test_refused(self):
        points = uniform(5)
        d = vt.Diagram(points, box=UNIT_BOX)
        for queries, says in [
            ([(0.5, np.nan, 0.5)], "query 0"),
            ([0.5, 0.5, 0.5], "queries has shape"),
            (np.zeros((2, 2)), "queries has shape"),
        ]:
            with self.assertRaisesRegex(ValueError, says):
                d.locate(queries)
        with self.assertRaisesRegex(ValueError, r"^points\[0\]"):
            vt.Diagram([(2, 0, 0)], box=UNIT_BOX)
        with self.assertRaisesRegex(ValueError, "weights"):
            vt.Diagram(points, box=UNIT_BOX, weights=[1, 2])
        for copied in (copy.copy, copy.deepcopy, pickle.dumps):
            with self.assertRaises(TypeError):
                copied(d)


EVERYTHING = "neighbors,volumes,centroids,counts,areas,normals,surfaces,radii,vertices,faces"


def row(cells, i):
    """Returns all data of cell i; polygons by the coordinates of their corners."""
    entries = slice(*cells.neighbors.indptr[i : i + 2])
    exact = [cells.neighbors[i], cells.face_counts[i], cells.edge_counts[i], cells.vertex_counts[i]]
    exact.append(None if cells.shifts is None else cells.shifts[entries])
    exact.append([len(face) for face in cells.faces[entries]])
    near = [cells.volumes[i], cells.centroids[i], cells.surface_areas[i], cells.security_radii[i]]
    near += [cells.face_areas[entries], cells.face_normals[entries]]
    near += [cells.vertices[face] for face in cells.faces[entries]]
    near.append(cells.vertices[cells.cell_vertices[i]].sum(axis=0))
    return exact, near


class Probing(unittest.TestCase):
    def check(self, points, queries, weights=None, of_queries=None, **domain):
        """Compares with tessellations of the points and each query. Returns the probes."""
        probes = vt.Diagram(points, weights=weights, outside="drop", **domain).probe(queries, EVERYTHING, of_queries)
        self.assertEqual(len(probes), len(queries))
        for q, query in enumerate(queries):
            if weights is not None:
                domain["weights"] = np.append(weights, 0 if of_queries is None else of_queries[q])
            t = vt.tessellate(np.vstack((points, query)), outside="drop", device="cpu", want=EVERYTHING, **domain)
            self.assertEqual(probes.status[q], t.status[-1])
            there = len(points)
            if t.status[-1] == vt.CellStatus.DUPLICATE:  # the cell of the seed there is the answer
                there = t.duplicate_of[-1]
                self.assertEqual(probes.duplicate_of[q], there)
            exact, near = row(probes, q)
            exact_there, near_there = row(t, there)
            for ours, theirs in zip(exact, exact_there):
                np.testing.assert_array_equal(ours, theirs)
            for ours, theirs in zip(near, near_there):
                np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-10)
        return probes

    def test_domains(self):
        points, queries = uniform(40), uniform(8, seed=2)
        queries[1] = points[9]
        probes = self.check(points, np.vstack((queries, (2, 0.5, 0.5))), box=UNIT_BOX)
        self.assertEqual(probes.status.tolist()[-1], vt.CellStatus.OUTSIDE)
        self.assertEqual((probes.status[1], probes.duplicate_of[1]), (vt.CellStatus.DUPLICATE, 9))
        cell, weights = np.asarray(CELL, float), 0.05 * uniform(40, seed=3)[:, 0]
        self.check(points @ cell, queries @ cell, weights, weights[:8], cell=cell, periodic="xy")

    def test_what_it_returns(self):
        points, queries = uniform(300), uniform(200, seed=2)
        d = vt.Diagram(points, box=UNIT_BOX, threads=2)
        probes = d.probe(queries)
        self.assertIsInstance(probes, vt.Probes)
        self.assertEqual(probes.wanted, ("neighbors", "volumes"))
        self.assertIs(type(probes.neighbors), vt.Lists)
        self.assertEqual(
            repr(probes), "<pyvotess.Probes of 200 queries in a box (0, 0, 0) to (1, 1, 1): neighbors, volumes>"
        )
        self.assertFalse(probes.lists_walls)
        self.assertTrue(d.probe(queries, list_walls=True).lists_walls)
        self.assertEqual(probes.stats.points, 200)
        self.assertIsNone(probes.duplicate_of)
        with self.assertRaisesRegex(AttributeError, "put 'faces' into want"):
            _ = probes.faces
        with self.assertRaises(ValueError):
            probes.volumes[0] = 1
        for missing in ("pairs", "derivatives", "delaunay", "verify", "wrapped_points", "points", "save", "plot"):
            self.assertFalse(hasattr(probes, missing), missing)
        self.assertEqual(len(d.probe(np.empty((0, 3)), EVERYTHING)), 0)
        none = vt.Diagram(np.empty((0, 3)), weights=[], box=UNIT_BOX)
        self.assertEqual(none.probe([(0.5, 0.5, 0.5)], weights=[2.0]).volumes.tolist(), [1.0])
        # Results outlive the diagram, and can be copied.
        expected = probes.volumes.copy()
        del d
        for copied in (copy.copy, copy.deepcopy, lambda probes: pickle.loads(pickle.dumps(probes))):
            other = copied(probes)
            np.testing.assert_array_equal(other.volumes, expected)
            np.testing.assert_array_equal(other.neighbors.indices, probes.neighbors.indices)
            self.assertFalse(other.volumes.flags.writeable)

    def test_voronoi_indices(self):
        probes = vt.Diagram(lattice(2), box=(0, 0, 0, 2, 2, 2)).probe([(1, 1, 1)], "faces")
        self.assertEqual(probes.voronoi_indices().tolist(), [[8]])  # an octahedron

    def test_refused(self):
        points = uniform(5)
        d = vt.Diagram(points, box=UNIT_BOX)
        for arguments, says in [
            (([(0.5, np.nan, 0.5)],), "query 0"),
            (([0.5, 0.5, 0.5],), "queries has shape"),
            ((points, "cells"), "want has 'cells'"),
            ((points, "volumes", [1, 2]), "weights has shape"),
            ((points, "volumes", np.zeros(5)), "the seeds have none"),
        ]:
            with self.assertRaisesRegex(ValueError, says):
                d.probe(*arguments)
        with self.assertRaisesRegex(ValueError, r"^weights\[1\] = nan"):
            vt.Diagram(points, box=UNIT_BOX, weights=np.zeros(5)).probe(points, weights=[0, np.nan, 0, 0, 0])

    def test_areas_of_the_far_box_alone(self):
        """The near box has no entries then."""
        one = vt.Diagram([(0, 0, 0)], box="none", weights=[0.1])
        cells = one.probe([(1, 0, 0)], want="neighbors,areas,normals", weights=[0.0])
        self.assertEqual((cells.indices.tolist(), cells.face_areas.tolist()), ([0], [np.inf]))
        np.testing.assert_allclose(cells.face_normals, [(-1, 0, 0)], atol=1e-15)



class NaturalNeighbors(unittest.TestCase):
    def setUp(self):
        self.points = uniform(600)
        self.diagram = vt.Diagram(self.points, box=UNIT_BOX)
        self.queries = 0.25 + 0.5 * uniform(900, seed=2)

    def test_coordinates(self):
        c = self.diagram.natural_neighbors(self.queries)
        self.assertIsNone(c.gradients)
        self.assertEqual(repr(c), "<pyvotess.NaturalCoordinates of 900 queries>")

    def test_fields(self):
        slope = np.array((1.0, -2.0, 0.5))
        values = np.column_stack((self.points @ slope, uniform(600, seed=3)[:, 0]))
        field, gradient = self.diagram.interpolate(values, self.queries, gradient=True)
        self.assertEqual((field.shape, gradient.shape), ((900, 2), (900, 2, 3)))
        np.testing.assert_allclose(field[:, 0], self.queries @ slope, rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(gradient[:, 0], np.tile(slope, (900, 1)), rtol=1e-6)
        one = self.diagram.interpolate(values[:, 1], self.queries)
        np.testing.assert_array_equal(one, field[:, 1])
        c = self.diagram.natural_neighbors(self.queries, gradient=True)
        query = np.repeat(np.arange(900), np.diff(c.neighbors.indptr))
        summed = np.zeros((900, 3))
        np.add.at(summed, query, c.gradients * values[c.neighbors.indices, 1][:, None])
        np.testing.assert_allclose(gradient[:, 1], summed, rtol=1e-9, atol=1e-9)
        try:
            matrix = c.to_scipy(600)
        except ImportError:
            return
        np.testing.assert_allclose(matrix @ values[:, 1], one, rtol=1e-13)

    def test_without_a_box(self):
        d = vt.Diagram(self.points)
        queries = np.vstack((self.queries, self.points[:1] + 10))
        values = self.points @ (1, 2, 3)
        field, slope = d.interpolate(values, queries, gradient=True)
        known = ~np.isnan(field)
        self.assertTrue(0 < np.count_nonzero(~known) < len(queries) / 2)
        np.testing.assert_allclose(field[known], queries[known] @ (1, 2, 3), atol=6e-12)
        np.testing.assert_array_equal(np.diff(d.natural_neighbors(queries).neighbors.indptr) > 0, known)
        np.testing.assert_array_equal(np.isinf(d.probe(queries).volumes), ~known)
        everywhere, slopes = d.interpolate(values, queries, gradient=True, beyond="nearest")
        np.testing.assert_array_equal(everywhere[known], field[known])
        np.testing.assert_array_equal(everywhere[~known], values[d.locate(queries[~known])])
        np.testing.assert_array_equal(slopes[~known], 0)
        np.testing.assert_array_equal(slopes[known], slope[known])
        # A value that is NaN stays so, where there are coordinates and for the nearest seed.
        for columns in ((), (1,), (2,)):
            with_gaps = np.broadcast_to(values.reshape(-1, *([1] * len(columns))), (len(values), *columns)).copy()
            with_gaps[::2] = np.nan
            field = d.interpolate(with_gaps, queries)
            everywhere, slopes = d.interpolate(with_gaps, queries, gradient=True, beyond="nearest")
            self.assertEqual((everywhere.shape, slopes.shape), ((len(queries), *columns), (len(queries), *columns, 3)))
            self.assertTrue(np.isnan(field[known]).any())
            np.testing.assert_array_equal(everywhere[known], field[known])
            np.testing.assert_array_equal(everywhere[~known], with_gaps[d.locate(queries[~known])])
        with self.assertRaisesRegex(ValueError, "beyond"):
            d.interpolate(values, queries, beyond="far")

    def test_refusals(self):
        d, q = self.diagram, self.queries
        for call, what in (
            (lambda: d.natural_neighbors(q, "linear"), "sibson"),
            (lambda: d.natural_neighbors(q, "laplace", gradient=True), "Sibson"),
            (lambda: d.natural_neighbors(q, weights=np.zeros(900)), "weights"),
            (lambda: d.interpolate(np.zeros(599), q), "599"),
            (lambda: d.interpolate(np.zeros((600, 1, 1)), q), "shape"),
            (lambda: d.interpolate(np.zeros((600, 0)), q), r"values has shape \(600, 0\)"),
        ):
            with self.assertRaisesRegex(ValueError, what):
                call()
        with self.assertRaises(vt.VotessError) as raised:
            vt.Diagram([(0.5, 0.5, 0.5)], box=UNIT_BOX, periodic=True).natural_neighbors([(0.1, 0.2, 0.3)])
        self.assertEqual(raised.exception.code, vt.ErrorCode.UNSUPPORTED)


class Stops(unittest.TestCase):
    def queries(self, d, points):
        return {
            "Diagram": lambda progress: vt.Diagram(points, box=UNIT_BOX, progress=progress),
            "locate": lambda progress: d.locate(points, progress=progress),
            "probe": lambda progress: d.probe(points, progress=progress).volumes,
            "natural_neighbors": lambda progress: d.natural_neighbors(points, progress=progress).weights,
            "interpolate": lambda progress: d.interpolate(points, points, progress=progress),
            "to_grid": lambda progress: d.to_grid(points, 5, progress=progress),
        }

    def test_progress(self):
        points = uniform(500)
        d = vt.Diagram(points, box=UNIT_BOX)
        for name, query in self.queries(d, points).items():
            with self.subTest(name):
                fractions = []
                found = query(fractions.append)
                self.assertEqual((fractions[0], fractions[-1]), (0, 1))
                self.assertEqual(fractions, sorted(fractions))
                for last in (1, 3):
                    calls = []

                    def stop(fraction):
                        calls.append(fraction)
                        if len(calls) < last:
                            time.sleep(0.101)  # so that the next check calls
                        return len(calls) < last

                    with self.assertRaises(vt.VotessError) as raised:
                        query(stop)
                    self.assertEqual(raised.exception.code, vt.ErrorCode.CANCELLED)
                    self.assertEqual(len(calls), last)
                with self.assertRaisesRegex(ZeroDivisionError, "mine"):
                    query(lambda fraction: (_ for _ in ()).throw(ZeroDivisionError("mine")))
                if name != "Diagram":
                    np.testing.assert_array_equal(query(None), found)
                shown = io.StringIO()
                with redirect_stderr(shown):
                    query(True)
                self.assertIn("100", shown.getvalue())
        with self.assertRaises(vt.VotessError) as raised:
            d.probe(points, progress=lambda fraction: time.sleep(0.101) or d.locate(points) is not None)
        self.assertEqual(raised.exception.code, vt.ErrorCode.INVALID_USE)

    def test_interrupt(self):
        points = uniform(2000)
        d = vt.Diagram(points, box=UNIT_BOX, threads=1)
        many = uniform(1_000_000, seed=5)
        for query in (lambda: d.to_grid(points, 250, "nearest"), lambda: d.natural_neighbors(many, "laplace")):
            timer = threading.Timer(0.2, _thread.interrupt_main)
            start = time.perf_counter()
            timer.start()
            try:
                with self.assertRaises(KeyboardInterrupt):
                    query()
            finally:
                timer.join()
            self.assertLess(time.perf_counter() - start, 5)
        self.assertEqual(len(d.locate(points)), 2000)

    @unittest.skipIf("VOTESS_TEST_REDUCED" in os.environ, "a sanitizer takes all addresses")
    def test_threads_that_the_system_does_not_give(self):
        program = (
            "import pyvotess as vt, resource\n"
            "resource.setrlimit(resource.RLIMIT_AS, (1 << 31, 1 << 31))\n"
            "try:\n"
            "    vt.tessellate([(0.0, 0.0, 0.0)], threads=1024, device='cpu')\n"
            "except vt.VotessError as error:\n"
            "    print(error.code.name, error)\n"
        )
        environment = dict(os.environ, PYTHONPATH=PACKAGE_PARENT, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
        done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
        self.assertRegex(done.stdout, r"\ANO_THREADS threads=1024, but the system gives only \d+: request fewer", done.stderr)


if __name__ == "__main__":
    unittest.main()

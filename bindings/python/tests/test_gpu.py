"""vt.gpu.Frames: arguments; on the device that VOTESS_TEST_DEVICE names, cells against those of tessellate()."""

import copy
import inspect
import os
import pathlib
import pickle
import re
import subprocess
import sys
import threading
import unittest

import numpy as np
from helpers import CELL, CUBE, PACKAGE_PARENT, UNIT_BOX, have, uniform
from test_wrong_values import RIGHT, VALUES

import pyvotess as vt
from pyvotess import autodiff

ALL = "neighbors,volumes,centroids,areas"
DEVICE = os.environ.get("VOTESS_TEST_DEVICE")


class Arguments(unittest.TestCase):
    """None of them opens a device."""

    def test_wrong_values_are_refused_by_name(self):
        right = {
            **RIGHT,
            "max_points": {"1", "3"}, "max_entries": {"0", "1", "3"}, "max_images": {"0", "1", "3"},
            "margin": {"0", "1", "3", "2**32 + 1", "2**70", "0.5", "0-d"}, "share": {"None"}, "weights": {"None", "[1, 2]"},
            "device": set(), "box": set(), "gradients": RIGHT["list_walls"],
            "follow": RIGHT["list_walls"],
        }  # fmt: skip
        wrong = []
        for name in inspect.signature(vt.gpu.Frames).parameters:
            for label, value in VALUES.items():
                given = {"max_points": 10, "box": UNIT_BOX, "device": "cpu", name: value}
                with self.assertRaises((ValueError, TypeError, vt.VotessError), msg=f"{name}={label}") as raised:
                    vt.gpu.Frames(**given)
                message = str(raised.exception)
                names = "device" if label in right.get(name, ()) else name.rstrip("s")
                if "\n" in message or not re.search(rf"\b{names}|\bmesh_repair", message):
                    wrong.append(f"{name}={label}: {message}")
        self.assertFalse(wrong, "\n".join(wrong))

    def test_what_frames_do_not_have(self):
        for words, given in {
            "finite": {"box": "none"}, "box is missing": {}, "2 dimensions": {"box": (0, 0, 1, 1)}, "mesh is given": {"mesh": CUBE},
            'outside="keep"': {"box": UNIT_BOX, "outside": "keep"}, "want has more": {"box": UNIT_BOX, "want": "faces"},
            "walls= and periodic=": {"box": UNIT_BOX, "periodic": True, "walls": [(1, 0, 0, 0.5)]},
            "134217728": {"box": UNIT_BOX, "max_points": 2**27 + 1}, "least and the largest": {"box": UNIT_BOX, "weights": (0, 1, 2)},
        }.items():  # fmt: skip
            with self.assertRaisesRegex(ValueError, words):
                vt.gpu.Frames(**{"max_points": 10, "device": "cpu", **given})

    def test_tensors_that_require_gradients(self):
        class Tensor:
            requires_grad = True

        with self.assertRaisesRegex(ValueError, r"points\.detach\(\), or use pyvotess\.autodiff\.torch"):
            vt.tessellate(Tensor())

    def test_import_finds_no_device(self):
        code = "import pyvotess, sys; sys.exit('libvulkan' in open('/proc/self/maps').read())"
        if sys.platform.startswith("linux"):
            subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "PYTHONPATH": PACKAGE_PARENT})


def vectors_for(cells, seed=5):
    """Returns random vectors for the arrays of cells."""
    rng = np.random.default_rng(seed)
    return {name: rng.normal(size=getattr(cells, name).shape).astype(np.float32) for name in ("volumes", "centroids", "face_areas")}


def vjp_on_cpu(points, weights, vectors, kept=slice(None), **domain):
    """Returns the gradients by pyvotess.autodiff of the points that are kept, 0 for others. Rows have walls, or not."""
    domain.pop("list_walls", None)
    weights = None if weights is None else weights[kept]
    t = vt.tessellate(points[kept], weights=weights, want=ALL + ",faces", device="cpu", precision="double", **domain)
    given = {name: values if name == "face_areas" else values[kept] for name, values in vectors.items()}
    if "face_areas" in given:
        of_rows = given.pop("face_areas")
        given["areas"] = np.zeros(len(t.indices))
        given["areas"][t.indices >= 0 if len(of_rows) < len(t.indices) else slice(None)] = of_rows
    found = np.zeros((len(points), 3)), np.zeros(len(points))
    for array, of_kept in zip(found, autodiff.vjp(t, **given)):
        array[kept] = of_kept
    return found


def centroids_near(t, points):
    """Returns the centroids of the cells around the points as given, which lie outside of a periodic box."""
    return t.centroids + (points - t.wrapped_points)


@unittest.skipUnless(DEVICE, "VOTESS_TEST_DEVICE names no device")
class OnDevice(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = vt.gpu.Frames(1, box=UNIT_BOX, want=ALL, device=DEVICE, gradients=True)

    def frames(self, max_points, **options):
        return vt.gpu.Frames(max_points, share=self.shared, **{"want": ALL, **options})

    def compare(self, cells, points, weights=None, **domain):
        """Compares all arrays with those of tessellate(), without points outside."""
        outside = cells.status == vt.CellStatus.OUTSIDE
        kept = np.flatnonzero(~outside)
        weights = None if weights is None else weights[kept]
        t = vt.tessellate(points[kept], weights=weights, want=ALL, device="cpu", **domain)
        np.testing.assert_array_equal(cells.status[kept], t.status)
        np.testing.assert_array_equal(np.diff(cells.indptr)[kept], np.diff(t.indptr))
        np.testing.assert_array_equal(np.diff(cells.indptr)[outside], 0)
        np.testing.assert_array_equal(cells.indices, np.where(t.indices < 0, t.indices, kept[t.indices]))
        if any(t.periodic):
            np.testing.assert_array_equal(cells.shifts, t.shifts)
        np.testing.assert_allclose(cells.volumes[kept], t.volumes, rtol=1e-5)
        size = np.cbrt(t.volumes.max(initial=0))
        np.testing.assert_allclose(cells.centroids[kept], centroids_near(t, points[kept]), atol=1e-4 * size)
        np.testing.assert_allclose(cells.face_areas, t.face_areas, atol=1e-5 * 6 * size**2)
        self.assertTrue(np.isnan(cells.centroids[outside]).all())
        self.assertEqual(cells.volumes[outside].tolist(), [0] * outside.sum())
        self.assertEqual(cells.centroids.dtype, points.dtype)
        for array, dtype in ((cells.indptr, "i4"), (cells.indices, "i4"), (cells.status, "i4"), (cells.volumes, "f4"), (cells.face_areas, "f4")):
            self.assertEqual(array.dtype, np.dtype(dtype))

    def test_domains(self):
        points, rng = uniform(150, seed=7), np.random.default_rng(8)
        moved = points.copy()
        moved[::9] += (1, -1, 0)
        jobs = [
            ({"box": UNIT_BOX}, points, False),
            ({"box": UNIT_BOX}, points.astype(np.float32), False),
            ({"box": (0, 0, 0, 1, 1, 2), "periodic": "xy", "list_walls": True}, moved, False),
            ({"box": UNIT_BOX, "periodic": True}, points, True),
            ({"cell": CELL, "origin": (1, 2, 3)}, points @ CELL + (1, 2, 3), False),
            ({"box": UNIT_BOX, "walls": [(1, 1, 0, 1.9), (0, 0.3, 1, 1.2)], "list_walls": True}, points, False),
            ({"box": UNIT_BOX, "walls": [(1, 1, 0, 1.9), (0, 0.3, 1, 1.2)], "list_walls": True}, points[:20] / 2, False),
            ({"box": UNIT_BOX}, points[:1], False),
        ]
        for domain, given, weighted in jobs:
            with self.subTest(domain=domain, dtype=given.dtype):
                weights = rng.uniform(-0.001, 0.002, len(given)) if weighted else None
                limits = {"weights": (-0.001, 0.002)} if weighted else {}
                frames = self.frames(200, **domain, **limits, gradients=True)
                cells = frames(given, weights).resolve()
                self.assertEqual(cells.unresolved, 0)
                self.compare(cells, given, weights, **domain)
                self.compare_gradients(cells, given, weights, **domain)

    def compare_gradients(self, cells, points, weights, **domain):
        """Compares them with those of the CPU, of which the formulas and the way through the faces are others."""
        vectors = vectors_for(cells)
        kept = np.flatnonzero(cells.status != vt.CellStatus.OUTSIDE)
        for names, tolerance in ((["volumes"], 1e-12), (["face_areas"], 1e-10), (["centroids"], 1e-5), (list(vectors), 1e-5)):
            given = {name: vectors[name] for name in names}
            for by, found, expected in zip(("points", "weights"), cells.vjp(**given), vjp_on_cpu(points, weights, given, kept, **domain)):
                scale = np.abs(expected).max(initial=1e-6)
                np.testing.assert_allclose(found, expected, atol=tolerance * scale, err_msg=f"{names} by {by}")
                self.assertFalse(found[cells.status != 0].any())

    def test_gradients_follow_differences(self):
        points, rng = uniform(60, seed=3), np.random.default_rng(4)
        weights = rng.uniform(0, 0.002, 60)
        frames = self.frames(60, box=UNIT_BOX, periodic=True, weights=(-1, 1), gradients=True)
        cells = frames(points, weights).resolve()
        vectors = vectors_for(cells)
        by_points, by_weights = cells.vjp(**vectors)

        def number(points, weights):
            t = vt.tessellate(points, weights=weights, box=UNIT_BOX, periodic=True, want=ALL, device="cpu", precision="double")
            np.testing.assert_array_equal(t.indices, cells.indices)
            return sum((vectors[name].astype(float) * getattr(t, name)).sum() for name in vectors)

        way, way_of_weights = 1e-6 * rng.normal(size=points.shape), 1e-6 * rng.normal(size=60)
        for change, expected in (
            ((by_points * way).sum(), number(points + way, weights) - number(points - way, weights)),
            ((by_weights * way_of_weights).sum(), number(points, weights + way_of_weights) - number(points, weights - way_of_weights)),
        ):
            self.assertAlmostEqual(change, expected / 2, delta=2e-5 * max(1e-6, abs(change)))

    def test_gradients_where_cells_meet_their_own_images(self):
        """At edges of a cell and two or three of its images, which move together."""
        rng = np.random.default_rng(9)
        thin = np.array(CELL) * [[1], [0.4], [1]]
        for domain, size in (({"box": (0, 0, 0, 1, 2, 0.3), "periodic": True}, np.diag((1, 2, 0.3))), ({"cell": thin}, thin),
                             ({"box": (0, 0, 0, 0.1, 0.2, 1), "periodic": "xy"}, np.diag((0.1, 0.2, 1)))):  # fmt: skip
            frames = self.frames(4, **domain, weights=(0, 0.001), gradients=True)
            for count in (1, 2, 4):
                points, weights = rng.random((count, 3)) @ size, rng.uniform(0, 0.001, count)
                cells = frames(points, weights).resolve()
                vectors = vectors_for(cells)["face_areas"]

                def rows(found, areas):  # by seed, neighbor and shift
                    at = np.repeat(np.arange(count), np.diff(found.indptr)).tolist()
                    return dict(zip(zip(at, found.indices.tolist(), map(tuple, found.shifts.tolist())), areas.tolist()))

                given = rows(cells, vectors)

                def number(points, weights):
                    t = vt.tessellate(points, weights=weights, want="neighbors,areas", device="cpu", **domain)
                    return sum(given.get(entry, 0) * area for entry, area in rows(t, t.face_areas).items())

                by_points, by_weights = cells.vjp(face_areas=vectors)
                for way, way_of_weights in zip(1e-6 * rng.normal(size=(4, count, 3)), 1e-7 * rng.normal(size=(4, count))):
                    change = (by_points * way).sum() + (by_weights * way_of_weights).sum()
                    expected = (number(points + way, weights + way_of_weights) - number(points - way, weights - way_of_weights)) / 2
                    self.assertAlmostEqual(change, expected, delta=1e-4 * np.abs(vectors).max() * 1e-6, msg=f"{domain}, {count}")

    def test_gradients_of_points_without_a_cell(self):
        points = uniform(100)
        points[3], points[4], points[50, 1] = points[9], (2, 0, 0), np.nan
        frames = self.frames(100, box=UNIT_BOX, max_entries=500, gradients=True)
        cells = frames(points)
        with self.assertRaisesRegex(vt.VotessError, f"{cells.unresolved} cells are unresolved.*resolve"):
            cells.vjp(volumes=cells.volumes)
        cells.resolve()
        vectors = vectors_for(cells)
        vectors["centroids"][4] = np.nan  # as is the centroid
        self.compare_gradients(cells, points, None, box=UNIT_BOX)
        before = cells.vjp(**vectors)
        cells.indices[:] = 10**9  # the arrays belong to the user
        for found, expected in zip(cells.vjp(**vectors), before):
            np.testing.assert_array_equal(found, expected)
            self.assertTrue(np.isfinite(found).all())
        self.assertEqual([len(array) for array in frames(points[:0]).vjp()], [0, 0])

    def test_gradients_of_a_cell_with_many_faces(self):
        """The planes of the first one do not fit into shared memory. The driver ends the loops of the second one early."""
        for count in (150, 600):
            way = np.random.default_rng(5).normal(size=(count, 3))
            points = np.concatenate(([[0.5, 0.5, 0.5]], 0.5 + 0.4 * way / np.linalg.norm(way, axis=1, keepdims=True)))
            cells = self.frames(count + 1, box=UNIT_BOX, gradients=True)(points).resolve()
            self.assertGreater(cells.indptr[1], 0.9 * count)
            vectors = vectors_for(cells)
            if count == 150:
                for found, expected in zip(cells.vjp(**vectors), vjp_on_cpu(points, None, vectors, box=UNIT_BOX)):
                    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
            elif DEVICE == "lavapipe":
                with self.assertRaisesRegex(vt.VotessError, r"ended the loops for point 0 early, whose cell has \d+ entries"):
                    cells.vjp(**vectors)

    @have("torch")
    def test_torch(self):
        import torch

        from pyvotess.autodiff.torch import measure

        start, spread = uniform(60, seed=3), np.random.default_rng(4).uniform(0, 0.002, 60)
        frames = self.frames(60, box=UNIT_BOX, periodic=True, weights=(0, 0.002), gradients=True)
        points, weights = (torch.from_numpy(array).requires_grad_() for array in (start, spread))
        m = measure(frames, points, weights)
        t = vt.tessellate(start, weights=spread, box=UNIT_BOX, periodic=True, want=ALL, device="cpu")
        np.testing.assert_array_equal(m.adjacency.numpy(), t.indices)
        np.testing.assert_array_equal(m.offsets.numpy(), t.indptr)
        self.assertEqual([m.volumes.dtype, m.centroids.dtype, m.areas.dtype], [torch.float32, torch.float64, torch.float32])
        ((m.volumes**2).sum() + ((m.centroids - points) ** 2).sum() + (m.areas**2).sum()).backward()
        away = t.centroids - start
        given = {"volumes": 2 * t.volumes, "centroids": 2 * away, "face_areas": 2 * t.face_areas}
        by_points, by_weights = vjp_on_cpu(start, spread, given, box=UNIT_BOX, periodic=True)
        np.testing.assert_allclose(points.grad, by_points - 2 * away, atol=1e-5 * np.abs(by_points).max())
        np.testing.assert_allclose(weights.grad, by_weights, atol=1e-5 * np.abs(by_weights).max())
        narrow = points.detach().to(torch.float32).requires_grad_()
        lists = self.frames(60, box=UNIT_BOX, want="neighbors,volumes", gradients=True)
        m = measure(lists, narrow)
        self.assertEqual([m.centroids, m.areas], [None, None])
        measure(lists, narrow)
        with self.assertRaisesRegex(ValueError, "the last call"):
            m.volumes.sum().backward()
        measure(lists, narrow).volumes[3].backward()
        self.assertEqual(narrow.grad.dtype, torch.float32)

    def test_wrong_gradients(self):
        points = uniform(50)
        cells = self.frames(50, box=UNIT_BOX)(points)
        with self.assertRaisesRegex(ValueError, "compute no gradient: set that option"):
            cells.vjp(volumes=cells.volumes)
        frames = self.frames(50, box=UNIT_BOX, want="neighbors,volumes", gradients=True)
        cells = frames(points).resolve()
        self.assertEqual([values.any() for values in cells.vjp()], [False, False])
        with self.assertRaisesRegex(ValueError, r"volumes has shape \(49,\): it must be \(50,\)"):
            cells.vjp(volumes=cells.volumes[1:])
        with self.assertRaisesRegex(AttributeError, "put 'centroids' into want"):
            cells.vjp(centroids=points)
        few = self.frames(50, box=UNIT_BOX, periodic=True, gradients=True)(points[:1]).resolve()
        self.assertLess(np.abs(few.vjp(volumes=[2.0])[0]).max(), 1e-12)
        self.assertLess(np.abs(few.vjp(face_areas=few.face_areas)[0]).max(), 1e-12)
        frames(points)
        with self.assertRaisesRegex(ValueError, "the last call"):
            cells.vjp(volumes=cells.volumes)
        with self.assertRaisesRegex(ValueError, "gradients follow the rows"):
            self.frames(50, box=UNIT_BOX, want="volumes", gradients=True)
        with self.assertRaisesRegex(ValueError, "centroids, which need volumes too"):
            self.frames(50, box=UNIT_BOX, want="neighbors,centroids", gradients=True)(points).resolve().vjp(centroids=points)

    def test_points_without_a_cell_and_rows_that_do_not_fit(self):
        points = uniform(100)
        points[3], points[4], points[50, 1] = points[9], (2, 0, 0), np.nan
        frames = self.frames(100, box=UNIT_BOX, max_entries=500)
        cells = frames(points)
        self.assertEqual(np.flatnonzero(cells.status == vt.CellStatus.OUTSIDE).tolist(), [4, 50])
        self.assertGreater(cells.unresolved, 30)
        self.assertLessEqual(len(cells.indices), 500)
        before = cells.indices
        first = before.copy()
        self.assertIs(cells.resolve(), cells)
        np.testing.assert_array_equal(before, first)
        self.assertEqual(cells.status[9], vt.CellStatus.DUPLICATE)
        self.compare(cells, points, box=UNIT_BOX)
        self.assertEqual([len(frames(points[:0]).resolve()), frames(points[:0]).indptr.tolist()], [0, [0]])

    def test_arrays_outlive_calls_and_frames(self):
        points = uniform(100)
        frames = self.frames(100, box=UNIT_BOX, max_entries=500)
        cells = frames(points)
        kept, volumes = cells.indices.copy(), cells.volumes
        frames(points[:50])
        with self.assertRaisesRegex(ValueError, "the last call"):
            cells.resolve()
        frames.close()
        frames.close()
        np.testing.assert_array_equal(cells.indices, kept)
        cells.volumes[0] = 2  # they belong to the user
        self.assertEqual(volumes[0], 2)
        if hasattr(np, "from_dlpack"):
            self.assertTrue(np.shares_memory(np.from_dlpack(cells.indices), cells.indices))
        with self.assertRaisesRegex(ValueError, "closed"):
            frames(points)
        for use in (pickle.dumps, copy.deepcopy):
            with self.assertRaisesRegex(TypeError, "copied or pickled"):
                use(cells)

    def test_kept_cells(self):
        """Frames that follow, beside frames that do not: the same arrays, for moves of all sizes and other numbers of points."""
        rng, points = np.random.default_rng(6), uniform(400, seed=5)
        weights = rng.uniform(-0.001, 0.002, 400)
        for domain, limits in (({"box": UNIT_BOX}, {}), ({"box": UNIT_BOX, "periodic": True, "list_walls": True}, {"weights": (-0.001, 0.002)})):
            follows, fresh = (self.frames(400, **domain, **limits, follow=follow) for follow in (True, False))
            places, kept = points.copy(), []
            for count, by in ((400, 0), (400, 0), (400, 1e-5), (300, 0), (300, 1e-5), (400, 0.3), (0, 0), (400, 0), (400, 0)):
                places = np.abs(places + by * rng.uniform(-1, 1, places.shape)) % 1
                given = places[:count], weights[:count] if limits else None
                cells, expected = follows(*given), fresh(*given)
                kept.append(cells.kept_cells)
                self.assertEqual(expected.kept_cells, 0)
                for name in ("status", "indptr", "indices", "volumes", "centroids", "face_areas"):
                    np.testing.assert_array_equal(getattr(cells.resolve(), name), getattr(expected.resolve(), name), name)
                self.assertEqual(cells.kept_cells, kept[-1])
            self.assertEqual([kept[0], kept[6], kept[7]], [0, 0, 0])
            self.assertGreater(min(kept[1], kept[8]), 390)
            self.assertGreater(kept[2], 200)
        with self.assertRaisesRegex(ValueError, "chunk_size"):
            self.frames(400, box=UNIT_BOX, follow=True, chunk_size=64)

    def test_refusals(self):
        frames = self.frames(10, box=UNIT_BOX, want="neighbors,volumes")
        cells = frames(uniform(10))
        for call, words in (
            (lambda: frames(uniform(11)), "11 points are more than max_points = 10"),
            (lambda: frames(uniform(10), np.ones(10)), "weights are given"),
            (lambda: frames(uniform(10), stream=0), "stream is of CUDA"),
            (lambda: frames(uniform(10), np.ones(9)), r"weights has shape \(9,\)"),
            (lambda: frames(np.ones((3, 2))), r"\(N, 3\)"),
            (lambda: self.frames(10, box=UNIT_BOX, weights=(2, 1)), "weights from 2 to 1 are no range"),
        ):
            with self.assertRaisesRegex(ValueError, words):
                call()
        with self.assertRaisesRegex(AttributeError, "put 'centroids' into want"):
            cells.centroids
        with self.assertRaisesRegex(AttributeError, "periodic"):
            cells.shifts
        self.assertIn("10 points", repr(cells))
        self.assertIn("up to 10 points", repr(frames))
        with self.assertRaises(vt.VotessError) as raised, frames._lock:
            frames(uniform(10))
        self.assertEqual(raised.exception.code, vt.ErrorCode.INVALID_USE)

    def test_page(self):
        """The code of the page, which tests of pages do not run: they have no device."""
        page = pathlib.Path(PACKAGE_PARENT) / "docs/pages/tensors.md"
        if not page.exists():
            self.skipTest("the pages are not installed")
        names = {}
        for code in re.findall(r"```python\n(.*?)```", page.read_text(), re.S):
            if "import torch" not in code:
                exec(code.replace('"auto"', f'"{DEVICE}"'), names)  # noqa: S102

    def test_threads(self):
        """Each thread with frames of its own on one device."""
        self.frames(50, box=UNIT_BOX)
        wrong = []

        def work(seed):
            points = uniform(50, seed)
            frames = self.frames(50, box=UNIT_BOX)
            for _ in range(3):
                if frames(points).resolve().indices.tolist() != vt.tessellate(points, box=UNIT_BOX, device="cpu").indices.tolist():
                    wrong.append(seed)

        threads = [threading.Thread(target=work, args=(seed,)) for seed in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    unittest.main()

"""pyvoro2's compute: against pyvoro2 where it is installed, and by what must hold anyway."""

import copy
import pickle
import unittest
import warnings

import numpy as np
from helpers import uniform
from pyvotess.compat import pyvoro2 as ours

try:
    import pyvoro2 as peer
except ImportError:
    peer = None

needs_pyvoro2 = unittest.skipUnless(peer, "pyvoro2 is not installed")
COUNT = 80
UNIT = ((0, 1), (0, 1), (0, 1))
VECTORS = ((10.0, 0, 0), (2.0, 9.0, 0), (1.0, 0.5, 8.0))


def turned_vectors():
    axes, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
    return (np.array(VECTORS) @ (axes * np.sign(np.linalg.det(axes)))).tolist()


def scenes():
    """Name, what makes the domain out of a module, points."""
    spread = uniform(COUNT, seed=3) * 6 - 3
    inside = uniform(COUNT, seed=4)
    yield "box", lambda m: m.Box(UNIT), inside
    yield "slab", lambda m: m.OrthorhombicCell(((0, 1), (-1, 2), (0, 1)), (True, False, True)), np.column_stack(
        (spread[:, 0], inside[:, 1], spread[:, 2])
    )
    yield "orthorhombic", lambda m: m.OrthorhombicCell(((0, 1), (0, 2), (-1, 1))), spread
    yield "triclinic", lambda m: m.PeriodicCell(VECTORS, origin=(1, 1, 1)), spread * 8
    yield "triclinic, turned", lambda m: m.PeriodicCell(turned_vectors(), origin=(1, -1, 1)), spread * 8


WAYS = (
    {},
    {"ids": list(range(1000, 1000 - COUNT, -1))},
    {"mode": "power", "radii": 0.3 * uniform(COUNT)[:, 0], "include_empty": True},
    {"mode": "power", "weights": 0.03 * uniform(COUNT)[:, 1] - 0.01},
)


def ring(ids):
    first = ids.index(min(ids))
    return tuple(ids[first:] + ids[:first])


def sorted_faces(cell, place):
    return sorted(
        (f["adjacent_cell"], f.get("adjacent_shift"), ring([place[v] for v in f["vertices"]])) for f in cell["faces"]
    )


class Compute(unittest.TestCase):
    @needs_pyvoro2
    def test_equals_pyvoro2(self):
        for name, make, points in scenes():
            for way in WAYS:
                with self.subTest(name, way=sorted(way)):
                    words = dict(way, return_diagnostics=True, return_face_shifts=name != "box")
                    self.compare(*(module.compute(points, domain=make(module), **words) for module in (ours, peer)))

    def compare(self, mine, theirs):
        np.testing.assert_allclose(mine.cell_measures, theirs.cell_measures, atol=1e-10)
        for name in ("sites", "ids", "empty_mask", "input_weights", "backend_radii"):
            self.assertEqual(getattr(mine, name) is None, getattr(theirs, name) is None, name)
            if getattr(mine, name) is not None:
                np.testing.assert_allclose(getattr(mine, name), getattr(theirs, name), rtol=1e-14)
                self.assertFalse(getattr(mine, name).flags.writeable)
        for name in (
            "dimension", "mode", "representation_shift", "measure_kind", "boundary_kind", "has_boundaries",
            "has_periodic_shifts", "has_tessellation_diagnostics", "has_normalized_vertices", "global_vertices",
        ):  # fmt: skip
            self.assertEqual(getattr(mine, name), getattr(theirs, name), name)
        a, b = mine.require_tessellation_diagnostics(), theirs.require_tessellation_diagnostics()
        for name in a.__dataclass_fields__:
            if name == "issues":
                self.assertEqual([i.code for i in a.issues], [i.code for i in b.issues])
            else:
                np.testing.assert_allclose(getattr(a, name), getattr(b, name), atol=1e-9, err_msg=name)
        cells = {cell["id"]: cell for cell in mine.cells}
        self.assertEqual(sorted(cells), sorted(cell["id"] for cell in theirs.cells))
        for other in theirs.cells:
            cell = cells[other["id"]]
            self.assertEqual({*cell}, {*other})
            np.testing.assert_allclose(cell["site"], other["site"], atol=1e-9)
            if other.get("empty"):
                self.assertEqual({**cell, "site": 0}, {**other, "site": 0})
                continue
            distance = np.linalg.norm(np.array(other["vertices"])[:, None] - np.array(cell["vertices"]), axis=2)
            place = distance.argmin(axis=1).tolist()
            self.assertEqual(sorted(place), list(range(len(cell["vertices"]))))
            self.assertLess(distance.min(axis=1).max(), 1e-8)
            # pyvoro2 marks faces that its diagnostics have seen.
            self.assertEqual(sorted_faces(cell, range(len(place))), sorted_faces(other, place))
            for vertex, around in enumerate(other["adjacency"]):
                self.assertEqual(ring(cell["adjacency"][place[vertex]]), ring([place[v] for v in around]))

    def test_shifts_carry_the_sites(self):
        for name, make, points in scenes():
            if name == "box":
                continue
            domain = make(ours)
            edges = np.array(domain.vectors if hasattr(domain, "vectors") else domain.lattice_vectors)
            result = ours.compute(points, domain=domain, return_face_shifts=True)
            sites = {cell["id"]: np.array(cell["site"]) for cell in result.cells}
            np.testing.assert_allclose(list(sites.values()), domain.remap_cart(points), atol=1e-12)
            faces = {(c["id"], f["adjacent_cell"], f["adjacent_shift"]) for c in result.cells for f in c["faces"]}
            for i, j, shift in faces:
                if j >= 0:
                    self.assertIn((j, i, tuple(-s for s in shift)), faces)
            for cell in result.cells[:20]:
                for face in cell["faces"]:
                    if face["adjacent_cell"] < 0:
                        self.assertEqual(face["adjacent_shift"], (0, 0, 0))
                        continue
                    image = sites[face["adjacent_cell"]] + np.array(face["adjacent_shift"]) @ edges
                    corners = np.array(cell["vertices"])[face["vertices"]]
                    near, far = (np.linalg.norm(corners - place, axis=1) for place in (cell["site"], image))
                    np.testing.assert_allclose(near, far, atol=1e-9)

    def test_fewer_points_than_walls(self):
        for count in (1, 2, 3, 5):
            points = uniform(count, seed=count) * (4, 3, 2) - (1, 1, 0)
            ids = np.arange(count) * 7 + 3
            for periodic in ((True, True, False), (False, True, False), (False, False, True)):
                bounds = [(-2, -1) if repeats else (-9, 9) for repeats in periodic]
                slab = ours.OrthorhombicCell(bounds, periodic)
                cells = ours.compute(points, domain=slab, ids=ids, output="cells", return_face_shifts=True)
                plain = ours.compute(points, domain=slab, output="cells", return_face_shifts=True)
                site = {cell["id"]: np.array(cell["site"]) for cell in cells}
                for cell, same in zip(cells, plain):
                    corners = np.array(cell["vertices"])
                    for face, as_index in zip(cell["faces"], same["faces"]):
                        neighbor, shift = face["adjacent_cell"], np.array(face["adjacent_shift"])
                        if neighbor < 0:
                            self.assertEqual((as_index["adjacent_cell"], shift.tolist()), (neighbor, [0, 0, 0]))
                            continue
                        self.assertEqual(ids[as_index["adjacent_cell"]], neighbor)
                        middle = corners[face["vertices"]].mean(axis=0)
                        other = site[neighbor] + shift * np.ptp(slab.bounds, axis=1)
                        self.assertAlmostEqual(np.linalg.norm(middle - site[cell["id"]]), np.linalg.norm(middle - other))

    def test_documented_calls(self):
        points = np.random.default_rng(0).uniform(-1.5, 1.5, size=(10, 3))
        box = ours.Box(((-2, 2), (-2, 2), (-2, 2)))
        result = ours.compute(points, domain=box, mode="standard")
        self.assertAlmostEqual(sum(cell["volume"] for cell in result.cells), 64)
        self.assertIs(type(result.cells), list)
        self.assertIs(result.cells, result.cells)

        weights = np.linspace(-0.2, 0.2, len(points))
        result = ours.compute(points, domain=box, mode="power", weights=weights, include_empty=True)
        self.assertEqual(len(result.cells), 10)
        self.assertAlmostEqual(result.cell_measures.sum(), 64)
        shifted = ours.compute(points, domain=box, mode="power", weights=weights + 5)
        np.testing.assert_allclose(shifted.cell_measures, result.cell_measures)

        cell = ours.PeriodicCell(vectors=VECTORS)
        result = ours.compute(points, domain=cell, return_face_shifts=True)
        self.assertEqual({*result.require_boundaries()[0][0]}, {"adjacent_cell", "adjacent_shift", "vertices"})
        with self.assertRaises(ours.DuplicateError):
            points = np.concatenate((points, points[:1] + 1e-4))
            ours.compute(points, domain=cell, duplicate_check="raise", duplicate_threshold=1e-3)

    def test_what_is_returned(self):
        box = ours.Box(UNIT)
        points = uniform(30)
        cells = ours.compute(points, domain=box, output="cells", return_adjacency=False)
        self.assertEqual([{*cell} for cell in cells], [{"id", "volume", "site", "vertices", "faces"}] * 30)
        cells, diagnostics = ours.compute(
            points, domain=box, output="cells", return_diagnostics=True, return_vertices=False, return_adjacency=False,
            return_faces=False,
        )  # fmt: skip
        self.assertTrue(diagnostics.ok)
        self.assertEqual(cells[3], {"id": 3, "volume": cells[3]["volume"], "site": points[3].tolist()})
        result = ours.compute(points, domain=box, return_faces=False)
        self.assertNotIn("faces", result.cells[0])
        for missing in (result.require_boundaries, result.require_tessellation_diagnostics,
                        result.require_normalized_topology, result.require_normalized_vertices):
            with self.assertRaises(ValueError):
                missing()
        result = ours.compute(points, domain=box)
        for other in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result), copy.copy(result)):
            self.assertEqual(other.cells, result.cells)
            np.testing.assert_array_equal(other.cell_measures, result.cell_measures)
        self.assertEqual(len(ours.compute(np.zeros((0, 3)), domain=box).cells), 0)
        hidden = ours.compute(points, domain=box, mode="power", radii=[2.0] + [0.0] * 29)
        self.assertEqual([cell["id"] for cell in hidden.cells], [0])
        self.assertEqual(len(hidden.require_boundaries()), 30)

    def test_what_is_refused(self):
        box, points = ours.Box(UNIT), uniform(20)
        wrong = (
            {"mode": "laguerre"}, {"output": "table"}, {"duplicate_check": "maybe"}, {"tessellation_check": "maybe"},
            {"radii": [1.0] * 20}, {"mode": "power"}, {"mode": "power", "radii": [1.0] * 20, "weights": [1.0] * 20},
            {"return_face_shifts": True}, {"ids": [1] * 20}, {"ids": [-1, *range(19)]}, {"ids": [1, 2]},
            {"ids": [0.5] * 20}, {"mode": "power", "radii": [-1.0] * 20}, {"mode": "power", "weights": [np.nan] * 20},
        )  # fmt: skip
        for words in wrong:
            with self.assertRaises(ValueError, msg=words):
                ours.compute(points, domain=box, **words)
        with self.assertRaises(ValueError):
            ours.compute(points, domain=ours.OrthorhombicCell(UNIT), return_face_shifts=True, return_vertices=False)
        with self.assertRaises(ValueError):
            ours.compute(points + 0.5, domain=box)
        with self.assertRaises(TypeError):
            ours.compute(points, domain=UNIT)
        with self.assertRaises(ours.TessellationError) as caught:
            ours.compute(points, domain=box, tessellation_check="raise", tessellation_volume_tol_rel=-1,
                         tessellation_volume_tol_abs=-1)  # fmt: skip
        self.assertFalse(caught.exception.diagnostics.ok)
        with self.assertWarnsRegex(UserWarning, "volumes sum to"):
            ours.compute(points, domain=box, tessellation_check="warn", tessellation_volume_tol_rel=-1,
                         tessellation_volume_tol_abs=-1)  # fmt: skip

    def test_what_is_not_there_says_what_to_use(self):
        from pyvotess.compat.pyvoro2 import ghost_cells, locate

        for missing in (locate, ghost_cells, ours.validate_tessellation, ours.annotate_face_properties):
            with self.assertRaisesRegex(NotImplementedError, "use instead"):
                missing(uniform(3), uniform(3))
        with self.assertRaisesRegex(NotImplementedError, "three dimensions"):
            ours.planar
        with self.assertRaises(AttributeError):
            ours.unknown

    def test_duplicates(self):
        points = np.concatenate((uniform(20), uniform(20)[4:6] + [[0, 0, 1e-3], [0, 0, 0]]))
        with self.assertRaises(ours.DuplicateError) as caught:
            ours.compute(points, domain=ours.Box(((0, 2),) * 3))
        self.assertEqual(caught.exception.pairs, (ours.DuplicatePair(5, 21, 0.0),))
        pairs = ours.duplicate_check(points, threshold=0.01, mode="return")
        self.assertEqual([(p.i, p.j) for p in pairs], [(5, 21), (4, 20)])
        self.assertAlmostEqual(pairs[1].distance, 1e-3)
        with self.assertRaises(ours.DuplicateError):
            ours.duplicate_check(points)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertEqual(ours.duplicate_check(points[:20], mode="warn"), ())
            with self.assertRaisesRegex(RuntimeWarning, "points 4 and 20 are 0.001 apart"):
                box = ours.Box(((0, 2),) * 3)
                ours.compute(points[:21], domain=box, duplicate_check="warn", duplicate_threshold=0.01)
        across = np.array([(0.001, 0.5, 0.5), (0.999, 0.5, 0.5)])
        cell = ours.OrthorhombicCell(UNIT)
        self.assertEqual(len(ours.duplicate_check(across, threshold=0.01, domain=cell, mode="return")), 1)
        self.assertEqual(ours.duplicate_check(across, threshold=0.01, domain=cell, wrap=False), ())
        self.assertEqual(ours.duplicate_check(across[:1]), ())


class Domains(unittest.TestCase):
    def test_wrapping(self):
        far = uniform(200, seed=5) * 100 - 50
        for name, make, _ in scenes():
            if name == "box":
                continue
            domain = make(ours)
            edges = np.array(domain.vectors if hasattr(domain, "vectors") else domain.lattice_vectors)
            places, shifts = domain.remap_cart(far, return_shifts=True)
            np.testing.assert_allclose(places + shifts @ edges, far, atol=1e-12)
            np.testing.assert_allclose(domain.remap_cart(places), places, atol=1e-12)
            if peer:
                expected, expected_shifts = make(peer).remap_cart(far, return_shifts=True)
                np.testing.assert_allclose(places, expected, atol=1e-11)
                np.testing.assert_array_equal(shifts, expected_shifts)
        cell = ours.OrthorhombicCell(UNIT, periodic=(True, False, True))
        places, shifts = cell.remap_cart([(1.0, 1.0, -1e-14), (-3.0, 5.0, 0.5)], return_shifts=True)
        self.assertEqual(places.tolist(), [[0, 1, 0], [0, 5, 0.5]])
        self.assertEqual(shifts.tolist(), [[1, 0, 0], [-3, 0, 0]])

    def test_internal_axes(self):
        cell = ours.PeriodicCell(turned_vectors(), origin=(1, 2, 3))
        bx, bxy, by, bxz, byz, bz = cell.to_internal_params()
        np.testing.assert_allclose((bx, bxy, by, bxz, byz, bz), (10, 2, 9, 1, 0.5, 8), atol=1e-12)
        points = uniform(10)
        np.testing.assert_allclose(cell.internal_to_cart(cell.cart_to_internal(points)), points, atol=1e-14)
        plain = ours.PeriodicCell.from_params(10, 2, 9, 1, 0.5, 8)
        self.assertEqual(plain, ours.PeriodicCell(VECTORS))
        np.testing.assert_allclose(plain.remap_internal([(11, 10, 9)]), [(8, 0.5, 1)])
        np.testing.assert_array_equal(plain.wrap_internal([(11, 10, 9)]), plain.remap_internal([(11, 10, 9)]))
        self.assertEqual(hash(plain), hash(ours.PeriodicCell(np.array(VECTORS))))

    def test_boxes(self):
        box = ours.Box.from_points(uniform(10), padding=1.0)
        np.testing.assert_allclose(np.array(box.bounds).T, [uniform(10).min(axis=0) - 1, uniform(10).max(axis=0) + 1])
        for wrong in (((0, 1), (0, 1)), ((1, 0),) * 3, ((0, np.nan),) * 3):
            with self.assertRaises(ValueError):
                ours.Box(wrong)
            with self.assertRaises(ValueError):
                ours.OrthorhombicCell(wrong)
        with self.assertRaises(ValueError):
            ours.OrthorhombicCell(UNIT, (True, False))
        for wrong in (np.zeros((3, 3)), VECTORS[::-1], VECTORS[:2], np.full((3, 3), np.nan)):
            with self.assertRaises(ValueError):
                ours.PeriodicCell(wrong)
        for wrong in (
            lambda: ours.Box.from_points(np.zeros((0, 3))),
            lambda: ours.Box.from_points(uniform(3), padding=-1),
            lambda: ours.PeriodicCell.from_params(0, 0, 1, 0, 0, 1),
        ):
            with self.assertRaises(ValueError):
                wrong()

    def test_weights_and_radii(self):
        np.testing.assert_array_equal(ours.radii_to_weights([1, 2.0]), [1, 4])
        radii, shift = ours.weights_to_radii([-1.0, 3.0])
        self.assertEqual((radii.tolist(), shift), ([0, 2], 1))
        self.assertEqual(ours.weights_to_radii([-1.0, 3.0], r_min=2)[0][0], 2)
        self.assertEqual(ours.weights_to_radii([0.0, 3.0], weight_shift=1)[0].tolist(), [1, 2])
        for wrong in (
            lambda: ours.radii_to_weights([-1]),
            lambda: ours.weights_to_radii([np.inf]),
            lambda: ours.weights_to_radii([-1.0], weight_shift=0),
            lambda: ours.weights_to_radii([1], r_min=-1),
            lambda: ours.weights_to_radii([1], r_min=1, weight_shift=1),
        ):
            with self.assertRaises(ValueError):
                wrong()


if __name__ == "__main__":
    unittest.main()

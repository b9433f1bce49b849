"""tessellate_stream(): its rows equal those of tessellate()."""

import tempfile
import unittest

import numpy as np
from helpers import EVERYTHING, UNIT_BOX, uniform, vt

LITTLE = 1_000_000


class Rows:
    """Concatenates rows."""

    def __init__(self):
        self.pieces = []

    def __call__(self, rows):
        self.pieces.append(rows)

    def all(self, name):
        arrays = [getattr(rows, name) for rows in self.pieces]
        return None if arrays[0] is None else np.concatenate(arrays)


class Stream(unittest.TestCase):
    def check(self, points, pieces, **options):
        rows = Rows()
        beside = options.pop("beside", None)
        numbers = {beside: options.pop("numbers")} if beside else {}
        result = vt.tessellate_stream(pieces, rows, memory=LITTLE, beside=beside, **options)
        whole = vt.tessellate(points, device="cpu", **options, **numbers)
        self.assertGreater(result.blocks, 2)
        self.assertEqual([r.first for r in rows.pieces], [0, *np.cumsum([len(r) for r in rows.pieces])[:-1]])
        np.testing.assert_array_equal(rows.all("indices"), whole.neighbors.indices)
        np.testing.assert_array_equal(rows.pieces[0].neighbors[5], whole.neighbors[5])
        np.testing.assert_array_equal(rows.pieces[-1].neighbors[-2], whole.neighbors[-2])
        np.testing.assert_array_equal(rows.all("status"), whole.status)
        for name in ("volumes", "centroids", "face_areas"):
            if rows.all(name) is not None:
                np.testing.assert_allclose(rows.all(name), getattr(whole, name), rtol=2e-10, atol=1e-12)
        self.assertEqual((result.stats.points, result.stats.faces), (len(points), whole.stats.faces))
        return rows, result, whole

    def test_pieces(self):
        points = uniform(5000)
        for pieces in (np.split(points, 5), [points], (piece for piece in np.split(points, 50))):
            rows, result, _ = self.check(points, pieces, box=UNIT_BOX, want=EVERYTHING)
            np.testing.assert_array_equal(result.box, [[0, 0, 0], [1, 1, 1]])
            self.assertIsNone(rows.pieces[0].shifts)
            self.assertIsNone(rows.pieces[0].duplicate_of)
        self.assertIsNone(result.verified)
        verified = vt.tessellate_stream([points], lambda rows: None, memory=LITTLE, box=UNIT_BOX, verify=True).verified
        self.assertEqual(verified, vt.VerifyReport(True, "", ("euler",), proven=True))
        single = points.astype("f4")
        _, result, whole = self.check(single, np.split(single, 2))
        np.testing.assert_array_equal(result.box, whole.box)

    def test_repr(self):  # short, whatever the arrays hold
        rows = Rows()
        points = uniform(5000)
        result = vt.tessellate_stream([points], rows, memory=LITTLE, box=UNIT_BOX, want="volumes,centroids", verify=True)
        first = rows.pieces[1]
        self.assertEqual(repr(first), f"<pyvotess.StreamRows of {len(first)} seeds from {first.first} on: no rows, volumes, centroids>")
        self.assertEqual(repr(result), f"<pyvotess.StreamResult of 5000 seeds in {result.blocks} blocks, the largest of "
                                       f"{result.largest_block}, verified>")
        rows = Rows()
        vt.tessellate_stream([points], rows, memory=LITTLE, box=UNIT_BOX, want="neighbors")
        first = rows.pieces[0]
        self.assertEqual(repr(first), f"<pyvotess.StreamRows of {len(first)} seeds from 0 on: {len(first.indices)} neighbors, no measures>")

    def test_too_little_memory(self):
        with self.assertRaisesRegex(ValueError, "^memory=5 bytes is too little: give at least 1000000$"):
            vt.tessellate_stream([uniform(10)], print, memory=5)

    def test_plane(self):
        points = uniform(5000)[:, :2]
        for pieces in (np.split(points, 5), (piece for piece in np.split(points, 50))):
            rows, result, _ = self.check(points, pieces, box=(0, 0, 1, 1), periodic=True, want=EVERYTHING)
            np.testing.assert_array_equal(result.box, [[0, 0], [1, 1]])
            self.assertEqual((rows.pieces[0].centroids.shape[1], rows.pieces[0].shifts.shape[1]), (2, 2))
        self.check(points, [points], box="hull")
        with self.assertRaisesRegex(ValueError, r"one of pieces has shape \(5000, 3\): it must be \(n, 2\)"):
            vt.tessellate_stream([points, uniform(5000)], print, memory=LITTLE)

    def test_hull_and_space(self):
        points = uniform(5000)
        for box in ("hull", "none"):
            rows, result, whole = self.check(points, np.split(points, 5), box=box, want=EVERYTHING)
            np.testing.assert_array_equal(result.box, whole.box)
            np.testing.assert_array_equal(rows.all("face_areas"), whole.face_areas)
        with self.assertRaisesRegex(ValueError, "all points lie in one plane"):
            vt.tessellate_stream([points * (1, 1, 0)], print, memory=LITTLE, box="hull")
        with self.assertRaisesRegex(ValueError, "hull and walls= are both given"):
            vt.tessellate_stream([points], print, memory=LITTLE, box="hull", walls=[(1, 0, 0, 2)])

    def test_pieces_without_entries(self):
        """An array that is wanted is there, also where no cell of the piece has a neighbor."""
        points, weights = uniform(40), np.zeros(40)
        weights[:39], weights[39] = -9, 1  # the last seed hides all others
        for periodic, wanted in ((True, ["neighbors", "areas", "normals"]), (False, ["neighbors"]), (True, ["volumes"])):
            rows = Rows()
            vt.tessellate_stream([(points, weights)], rows, memory=LITTLE, beside="weights", box=UNIT_BOX, periodic=periodic,
                                 want=wanted, outside="drop")  # fmt: skip
            whole = vt.tessellate(points, box=UNIT_BOX, periodic=periodic, weights=weights, want=wanted)
            for piece in rows.pieces:
                self.assertEqual(piece.indices is None, "neighbors" not in wanted)
                self.assertEqual(piece.shifts is None, not periodic or "neighbors" not in wanted)
                self.assertEqual(piece.face_areas is None, "areas" not in wanted)
                self.assertEqual(piece.face_normals is None, "normals" not in wanted)
            if "areas" in wanted:
                np.testing.assert_array_equal(rows.all("shifts"), whole.shifts)
                self.assertEqual(rows.all("face_normals").shape, (len(whole.indices), 3))
        nothing = Rows()
        vt.tessellate_stream([np.empty((0, 3))], nothing, memory=LITTLE, box=UNIT_BOX, periodic=True, want="areas")
        for piece in nothing.pieces:
            self.assertEqual(piece.shifts.shape, (0, 3))

    def test_periodic_and_weights(self):
        points = uniform(5000)
        points[-9:] = points[:9]
        rows, _, whole = self.check(points, np.split(points, 2), box=UNIT_BOX, periodic="xz")
        np.testing.assert_array_equal(rows.all("shifts"), whole.shifts)
        np.testing.assert_array_equal(rows.all("duplicate_of")[-9:], range(9))
        radii = 0.05 * np.random.default_rng(2).random(5000)
        pairs = list(zip(np.split(points, 4), np.split(radii, 4)))
        self.check(points, pairs, box=UNIT_BOX, beside="radii", numbers=radii)

    def test_errors(self):
        points = uniform(3000)
        points[2222, 1] = np.nan
        with self.assertRaisesRegex(ValueError, r"^points\[2222\]: y = nan is not finite$"):
            vt.tessellate_stream(np.split(points, 3), print, memory=LITTLE)
        points[2222, 1] = 0.5

        def broken(rows):
            raise KeyError(rows.first)

        with self.assertRaisesRegex(KeyError, "^0$"):
            vt.tessellate_stream([points], broken, memory=LITTLE)
        with self.assertRaisesRegex(ZeroDivisionError, "division"):
            vt.tessellate_stream((points / (1 // k) for k in (1, 0)), print, memory=LITTLE)
        with self.assertRaises(vt.VotessError) as caught:
            vt.tessellate_stream([points], print, memory=LITTLE, progress=lambda fraction: False)
        self.assertEqual(caught.exception.code, vt.ErrorCode.CANCELLED)
        with tempfile.TemporaryDirectory() as folder:
            for options, error, says in [
                ({"memory": 7}, ValueError, "memory=7 bytes"),
                ({"temporary": folder + "/absent"}, ValueError, "absent"),
                ({"want": "faces"}, vt.VotessError, "vertices and faces"),
                ({"beside": "mass"}, ValueError, "beside is 'mass'"),
                ({"rows": 5}, TypeError, "rows must be callable"),
            ]:
                with self.assertRaisesRegex(error, says):
                    vt.tessellate_stream(**{"pieces": [points], "rows": print, "memory": LITTLE, **options})


if __name__ == "__main__":
    unittest.main()

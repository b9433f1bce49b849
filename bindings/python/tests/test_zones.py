"""watershed(): merging, walls, views and pickles, bad input."""

import copy
import gc
import pickle
import unittest

import numpy as np
from helpers import UNIT_BOX, cells, uniform

import pyvotess as vt


class Zones(unittest.TestCase):
    def test_merge(self):
        t = vt.tessellate(uniform(2000, seed=7), box=UNIT_BOX, periodic=True)
        values = np.log(1 / t.volumes)
        zones = t.watershed(values)
        self.assertIsNone(zones.at_walls)
        self.assertTrue(t.watershed(values, maxima=True).maxima)
        merged = zones.merge(np.inf)
        self.assertEqual(len(merged), 1)
        self.assertEqual(merged.pairs.shape, (0, 2))
        self.assertEqual(repr(merged), "<pyvotess.Zones: 1 zone of 2000 cells>")

    def test_seeds_without_a_cell(self):
        t = cells()
        values = np.append(uniform(60, seed=8)[:, 0], (np.nan, np.inf))
        labels = t.watershed(values).labels
        np.testing.assert_array_equal(labels < 0, np.isin(np.arange(62), (60, 61)))
        self.assertEqual(len(vt.tessellate(np.empty((0, 3))).watershed([])), 0)

    def test_arrays_live_and_are_read_only(self):
        labels = vt.tessellate(uniform(3000)).watershed(np.arange(3000)).merge(np.inf).labels
        gc.collect()
        self.assertEqual((labels.min(), labels.max(), labels.dtype), (0, 0, np.int32))
        with self.assertRaises(ValueError):
            labels[0] = 1

    def test_pickles(self):
        t = vt.tessellate(uniform(500), list_walls=True)
        zones = t.watershed(1 / t.volumes)
        for other in (pickle.loads(pickle.dumps(zones)), copy.deepcopy(zones)):
            for name in ("labels", "cores", "pairs", "saddles", "passes", "parents", "persistence", "at_walls"):
                np.testing.assert_array_equal(getattr(other, name), getattr(zones, name), name)
            self.assertEqual((len(other), other.maxima), (len(zones), False))
            with self.assertRaisesRegex(ValueError, "a pickle or deep copy holds no object of the library"):
                other.merge(1)
        shared = copy.copy(zones)
        self.assertIs(shared.labels, zones.labels)
        np.testing.assert_array_equal(shared.merge(0.5).labels, zones.merge(0.5).labels)
        again = pickle.loads(pickle.dumps(t)).watershed(1 / t.volumes)
        np.testing.assert_array_equal(again.labels, zones.labels)

    def test_refusals(self):
        t = vt.tessellate(uniform(50))
        values = np.ones(50)
        values[17] = np.nan
        for call, message in (
            (lambda: t.watershed(values), "value of seed 17 is nan"),
            (lambda: t.watershed(np.ones(49)), r"values has shape \(49,\) for 50 cells"),
            (lambda: t.watershed(np.ones((50, 2))), "shape"),
            (lambda: t.watershed(np.ones(50)).merge(np.nan), "threshold is nan"),
            (lambda: vt.tessellate(uniform(50), only=[1, 2]).watershed([1, 2]), "only"),
        ):
            with self.assertRaisesRegex(ValueError, message):
                call()
        with self.assertRaisesRegex(AttributeError, "neighbors"):
            vt.tessellate(uniform(50), want="volumes").watershed(np.ones(50))


if __name__ == "__main__":
    unittest.main()

"""pyvotess.autodiff: products with derivatives against central differences, identities and matrices; JAX and PyTorch."""

import unittest
import unittest.mock

import numpy as np
from helpers import CELL, CUBE, UNIT_BOX, have, lattice, uniform

import pyvotess as vt
from pyvotess import _motion, autodiff

SEEDS = 100
SQUARE = (0, 0, 1, 1)
NAMES = ("volumes", "centroids", "areas")
TOLERANCE = 1e-6


def cotangents(t, seed=5):
    rng = np.random.default_rng(seed)
    return {name: rng.normal(size=getattr(t, name).shape) for name in NAMES}


class Differences(unittest.TestCase):
    """Derivatives along random directions against differences of two more tessellations."""

    def compare(self, points, weights=None, **domain):
        rng = np.random.default_rng(4)
        t = autodiff.forward(points, weights=weights, **domain)
        given = cotangents(t)
        start = {"points": points, "weights": np.zeros(len(points)) if weights is None else weights}
        for by, step in (("points", 1e-7), ("weights", 1e-8)):
            way = rng.normal(size=start[by].shape)
            ends = [
                autodiff.forward(**{"points": points, "weights": weights, by: start[by] + s * step * way}, **domain)
                for s in (1, -1)
            ]
            together = 0
            for name in NAMES:
                for end in ends:
                    np.testing.assert_array_equal(end.indices, t.indices)
                rate = (getattr(ends[0], name) - getattr(ends[1], name)) / (2 * step)
                products = np.nan_to_num(given[name] * rate)  # centroids without cells are NaN
                gradient = getattr(autodiff.vjp(t, **{name: given[name]}), by)
                error = abs(products.sum() - (gradient * way).sum()) / (0.1 + np.sqrt((products**2).sum()))
                self.assertLess(error, TOLERANCE, f"{name} by {by}, {domain}")
                together = together + gradient
            np.testing.assert_allclose(getattr(autodiff.vjp(t, **given), by), together, rtol=1e-10, atol=1e-10)

    def test_space(self):
        points, weights = uniform(SEEDS, seed=6), 0.004 * uniform(SEEDS, seed=7)[:, 0]
        cell = np.asarray(CELL, float)
        for given in (None, weights):
            self.compare(points, given, box=UNIT_BOX)
            self.compare(points, given, box=UNIT_BOX, periodic="xy")
            self.compare(points @ cell, given, cell=cell)
        self.compare(0.95 * points, weights, box=UNIT_BOX, walls=[(1, 1, 1, 2.86), (-1, 2, 0, 1.92)])
        self.compare(points + (3, -2, 0), None, box=UNIT_BOX, periodic=True)
        self.compare(1.2 * points - 0.1, None, box=UNIT_BOX, outside="keep")

    def test_units(self):
        """The range of float64 ends at 2^-1074 and 2^1024: volumes, and products of three lengths, are 0 or infinite."""
        for size, box in ((2, SQUARE), (3, UNIT_BOX)):
            points, weights = uniform(SEEDS, seed=6)[:, :size], 0.002 * uniform(SEEDS, seed=7)[:, 0]
            near = autodiff.forward(points, weights=weights, box=box)
            given = cotangents(near)
            for unit in 2.0 ** np.array([-480, -360, -345, -100, 100, 345, 360, 480]):
                far = autodiff.forward(points * unit, weights=weights * unit**2, box=np.asarray(box) * unit)
                np.testing.assert_array_equal(far.indices, near.indices)
                for name, power in (("volumes", size), ("centroids", 1), ("areas", size - 1)):
                    found, expected = autodiff.vjp(far, **{name: given[name]}), autodiff.vjp(near, **{name: given[name]})
                    for by, less in (("points", 1), ("weights", 2)):
                        scale = unit ** (power - less)
                        np.testing.assert_allclose(getattr(found, by) / scale, getattr(expected, by), rtol=1e-9, atol=1e-9, err_msg=f"{name} by {by}, {unit}")

    def test_plane(self):
        points, weights = uniform(SEEDS, seed=6)[:, :2], 0.004 * uniform(SEEDS, seed=7)[:, 0]
        cell = np.array([(1, 0), (0.3, 1)])
        for given in (None, weights):
            self.compare(points, given, box=SQUARE)
            self.compare(points, given, box=SQUARE, periodic="x")
            self.compare(points @ cell, given, cell=cell)
        self.compare(0.9 * points, weights, box=SQUARE, walls=[(1, 1, 1.7)])

    def test_few_seeds(self):
        for count in (1, 2, 3, 5):
            self.compare(uniform(count, seed=count), None, box=UNIT_BOX, periodic="xy")
            self.compare(uniform(count, seed=count)[:, :2], None, box=SQUARE, periodic=True)

    def test_hidden_and_dropped_seeds(self):
        points = uniform(SEEDS)
        points[7] = points[3]
        weights = np.zeros(SEEDS)
        weights[:4] = 0.1
        t = autodiff.forward(points, weights=weights, box=UNIT_BOX)
        lost = t.status != 0
        self.assertGreater(lost.sum(), 5)
        given = cotangents(t)
        given["centroids"][lost] = np.nan  # as are their centroids
        for by, values in zip(("points", "weights"), autodiff.vjp(t, **given)):
            self.assertTrue(np.isfinite(values).all(), by)
            self.assertFalse(values[lost].any(), by)
        self.compare(uniform(SEEDS), weights, box=UNIT_BOX)

    def test_lattice(self):
        """Volumes and centroids have derivatives where many cells meet: faces of area 0 add nothing."""
        points = lattice(4)
        way = np.random.default_rng(2).normal(size=points.shape)
        box = (0, 0, 0, 4, 4, 4)
        t, after, before = (autodiff.forward(points + s * 1e-6 * way, box=box) for s in (0, 1, -1))
        for name in ("volumes", "centroids"):
            given = cotangents(t)[name]
            rate = (given * (getattr(after, name) - getattr(before, name))).sum() / 2e-6
            self.assertAlmostEqual((autodiff.vjp(t, **{name: given}).points * way).sum(), rate, delta=1e-4)


class Identities(unittest.TestCase):
    @have("scipy")
    def test_matrices(self):
        for points, options in (
            (uniform(SEEDS), {"box": UNIT_BOX, "periodic": "x"}),
            (uniform(SEEDS)[:, :2], {"box": SQUARE, "periodic": "x"}),
        ):
            t = autodiff.forward(points, **options)
            given = cotangents(t)
            for of in ("volumes", "areas"):
                for by, values in zip(("points", "weights"), autodiff.vjp(t, **{of: given[of]})):
                    expected = t.derivatives(of, by).T @ given[of]
                    np.testing.assert_allclose(values.ravel(), expected, rtol=1e-10, atol=1e-10, err_msg=f"{of} by {by}")

    def test_blocks(self):
        """The faces are read in blocks of cells, whose size changes nothing."""
        t = autodiff.forward(uniform(SEEDS), box=UNIT_BOX)
        whole = autodiff.vjp(t, **cotangents(t))
        for corners in (1, 500):
            with unittest.mock.patch.object(_motion, "_CORNERS", corners):
                for values, expected in zip(autodiff.vjp(t, **cotangents(t)), whole):
                    np.testing.assert_allclose(values, expected, rtol=1e-12, atol=1e-12)

    def test_no_seeds(self):
        t = autodiff.forward(np.empty((0, 3)), box=UNIT_BOX)
        by_points, by_weights = autodiff.vjp(t, **cotangents(t))
        self.assertEqual((by_points.shape, by_weights.shape), ((0, 3), (0,)))

    def test_refused(self):
        points = uniform(20)
        for says, call in (
            ("box is None, which has no fixed ends", lambda: autodiff.forward(points)),
            ("box is 'hull'", lambda: autodiff.forward(points, box="hull")),
            ("give weights, the squares", lambda: autodiff.forward(points, box=UNIT_BOX, radii=np.ones(20))),
            ("volumes has shape .3,.: it must be .20,.", lambda: autodiff.vjp(t, volumes=np.ones(3))),
            ("areas has shape", lambda: autodiff.vjp(t, areas=np.ones(3))),
            ("whole cells", lambda: autodiff.vjp(autodiff.forward(points, box=UNIT_BOX, min_face=0.5))),
            ("leave out only=", lambda: autodiff.vjp(vt.tessellate(points, box=UNIT_BOX, want="faces", only=[1]))),
            ("infinity", lambda: autodiff.vjp(vt.tessellate(points, box="none", want="faces"), areas=())),
        ):
            t = autodiff.forward(points, box=UNIT_BOX)
            with self.subTest(says), self.assertRaisesRegex(ValueError, says):
                call()
        with self.assertRaisesRegex(AttributeError, "put 'faces' into want"):
            autodiff.vjp(vt.tessellate(points), np.ones(20))
        with self.assertRaisesRegex(vt.VotessError, "mesh: the parts of cells have no vertices, faces"):
            autodiff.forward(points, box=UNIT_BOX, mesh=CUBE)


class Jax(unittest.TestCase):
    @classmethod
    @have("jax")
    def setUpClass(cls):
        import jax

        jax.config.update("jax_enable_x64", True)

    def setUp(self):
        from pyvotess.autodiff.jax import tessellate

        self.tessellate = tessellate
        self.points, self.weights = uniform(40), 0.004 * uniform(40, seed=7)[:, 0]

    def test_check_grads(self):
        import jax
        from jax.test_util import check_grads

        def measures(points, weights):
            m = self.tessellate(points, weights=weights, box=UNIT_BOX, periodic="xy", max_rows=1000)
            return m.volumes, m.centroids, m.areas

        for function in (measures, jax.jit(measures)):
            check_grads(function, (self.points, self.weights), order=1, modes=["rev"], eps=1e-7)
        check_grads(lambda p: self.tessellate(p, box=SQUARE)[:2], (self.points[:, :2],), order=1, modes=["rev"], eps=1e-7)

    def test_arrays(self):
        import jax
        import jax.numpy as jnp

        m = self.tessellate(self.points, box=UNIT_BOX, max_rows=1000)
        t = autodiff.forward(self.points, box=UNIT_BOX)
        rows = t.rows()
        end = len(t.areas)
        for name, expected in (*((name, getattr(t, name)) for name in NAMES), *rows._asdict().items()):
            found = np.asarray(getattr(m, name))
            if name in ("areas", "adjacency"):
                self.assertTrue((found[end:] == (0 if name == "areas" else np.iinfo(np.int32).min)).all())
                found = found[:end]
            np.testing.assert_array_equal(found, expected)
            self.assertEqual(found.dtype, expected.dtype)
        self.assertIsNone(self.tessellate(self.points, box=UNIT_BOX).areas)
        narrow = jnp.asarray(self.points, jnp.float32)
        self.assertEqual(jax.grad(lambda p: self.tessellate(p, box=UNIT_BOX).volumes[3])(narrow).dtype, jnp.float32)

    def test_transforms(self):
        import jax

        def volumes(points):
            return self.tessellate(points, box=UNIT_BOX, periodic=True).volumes

        matrix = jax.jacrev(volumes)(self.points)
        t = autodiff.forward(self.points, box=UNIT_BOX, periodic=True)
        np.testing.assert_allclose(matrix[3], autodiff.vjp(t, volumes=np.eye(40)[3]).points, rtol=1e-12, atol=1e-14)
        pair = np.stack((self.points, self.points[::-1]))
        np.testing.assert_allclose(jax.vmap(volumes)(pair)[1], t.volumes[::-1], rtol=1e-12)

    def test_compiled_once(self):
        """Other calls with equal options compile nothing, and free the cells of the call before."""
        import jax

        from pyvotess.autodiff import jax as module

        for shift in (0, 0.1, 0.2):
            jax.grad(lambda p: self.tessellate(p, box=list(UNIT_BOX), periodic=True).volumes[0])(self.points + shift)
        made = module._cells_of.cache_info().misses
        jax.grad(lambda p: self.tessellate(p, box=list(UNIT_BOX), periodic=True).volumes[0])(self.points)
        self.assertEqual(module._cells_of.cache_info().misses, made)

    def test_refused(self):
        import jax

        with self.assertRaisesRegex(ValueError, "points has dtype int64"):
            self.tessellate(np.ones((2, 3), np.int64), box=UNIT_BOX)
        with self.assertRaisesRegex(ValueError, "points has dtype float16"):
            self.tessellate(self.points.astype(np.float16), box=UNIT_BOX)
        with self.assertRaisesRegex(TypeError, "progress is of type function, which cannot be pickled"):
            self.tessellate(self.points, box=UNIT_BOX, progress=lambda fraction: None)
        with self.assertRaisesRegex(ValueError, "only is not an option of derivatives"):
            self.tessellate(self.points, box=UNIT_BOX, only=[1])
        self.tessellate(self.points, box=UNIT_BOX, min_face=0.1)
        with self.assertRaisesRegex(ValueError, "derivatives need whole cells: leave out min_face and min_area"):
            jax.grad(lambda p: self.tessellate(p, box=UNIT_BOX, min_face=0.1).volumes[0])(self.points)
        with self.assertLogs("jax"), self.assertRaisesRegex(Exception, "max_rows is 5, but the rows have"):
            self.tessellate(self.points, box=UNIT_BOX, max_rows=5).areas.block_until_ready()


class Torch(unittest.TestCase):
    @classmethod
    @have("torch")
    def setUpClass(cls):
        pass

    def setUp(self):
        import torch

        from pyvotess.autodiff.torch import tessellate

        self.tessellate = tessellate
        self.points = torch.from_numpy(uniform(30)).requires_grad_()
        self.weights = torch.from_numpy(0.004 * uniform(30, seed=7)[:, 0]).requires_grad_()

    def test_gradcheck(self):
        import torch

        def measures(points, weights):
            m = self.tessellate(points, weights=weights, box=UNIT_BOX, periodic="xy")
            return m.volumes, m.centroids, m.areas

        self.assertTrue(torch.autograd.gradcheck(measures, (self.points, self.weights), eps=1e-7, atol=1e-5))

    def test_tensors(self):
        import torch

        m = self.tessellate(self.points, box=UNIT_BOX)
        t = autodiff.forward(self.points.detach(), box=UNIT_BOX)
        for name, expected in (*((name, getattr(t, name)) for name in NAMES), *t.rows()._asdict().items()):
            found = getattr(m, name).detach().numpy()
            np.testing.assert_array_equal(found, expected)
            self.assertEqual(found.dtype, expected.dtype)
        narrow = self.points.detach().to(torch.float32).requires_grad_()
        self.tessellate(narrow, box=UNIT_BOX).volumes[3].backward()
        self.assertEqual(narrow.grad.dtype, torch.float32)

    def test_refused(self):
        with self.assertRaisesRegex(ValueError, "points is torch.float16"):
            self.tessellate(self.points.detach().half(), box=UNIT_BOX)
        with self.assertRaisesRegex(ValueError, "points is torch.int64"):
            self.tessellate(self.points.detach().long(), box=UNIT_BOX)
        with self.assertRaisesRegex(ValueError, "points is on meta: give points.cpu"):
            self.tessellate(self.points.detach().to("meta"), box=UNIT_BOX)
        volume = self.tessellate(self.points, box=UNIT_BOX).volumes[0]
        with self.assertRaisesRegex(RuntimeError, "modified by an inplace operation"):
            self.points.detach().add_(0.001)
            volume.backward()


if __name__ == "__main__":
    unittest.main()

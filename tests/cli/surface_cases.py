"""--surface and --remesh: cells on a triangle mesh, its dual, its new mesh, and what is refused."""

import numpy as np

from cli_test import CliTest, random_points, text_of

# A box of 2 x 1 x 1 in twelve triangles.
CORNERS = np.array([(x, y, z) for x in (0.0, 2.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
OFF = f"OFF\n8 12 0\n{text_of(CORNERS)}" + "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)


def read_mesh(path):
    """Returns vertices and triangles of .obj, .off, .ply and .stl as clvotess writes them."""
    data = path.read_bytes()
    if path.suffix == ".ply":
        head, _, body = data.partition(b"end_header\n")
        vertices, faces = (int(line.split()[2]) for line in head.splitlines() if line.startswith(b"element"))
        x = np.frombuffer(body, "<f8", 3 * vertices).reshape(-1, 3)
        rows = np.frombuffer(body, [("n", "u1"), ("v", "<i4", 3)], faces, 24 * vertices)
        assert (rows["n"] == 3).all() and len(body) == 24 * vertices + 13 * faces
        return x, rows["v"]
    words = [line.split() for line in data.decode().splitlines()]
    if path.suffix == ".stl":
        x = np.array([w[1:] for w in words if w[0] == "vertex"], float)
        return np.unique(x, axis=0), np.unique(x, axis=0, return_inverse=True)[1].reshape(-1, 3)
    if path.suffix == ".off":
        count = int(words[1][0])
        return np.array(words[2 : 2 + count], float), np.array([w[1:] for w in words[2 + count :]], int)
    return np.array([w[1:] for w in words if w[0] == "v"], float), np.array([w[1:] for w in words if w[0] == "f"], int) - 1


def volume(vertices, triangles):
    x = vertices[triangles]
    return float((x[:, 0] * np.cross(x[:, 1], x[:, 2])).sum() / 6)


class OnSurface(CliTest):
    def setUp(self):
        super().setUp()
        self.put("box.off", OFF)

    def test_cells(self):
        points = random_points(60) * (2, 1, 1)
        self.put("in.csv", "id,x,y,z\n" + "".join(f"{7 * i},{x!r},{y!r},{z!r}\n" for i, (x, y, z) in enumerate(points.tolist())))
        summary = self.json("in.csv", "--surface", "box.off", "-o", "out.csv", "-o", "out.npz", "-o", "dual.obj", "-o", "dual.ply")
        self.assertEqual((summary["points"], summary["surface_triangles"], summary["border"]), (60, 12, 0))
        self.assertAlmostEqual(summary["area"], 10, delta=1e-12)
        arrays = np.load(self.folder / "out.npz")
        self.assertListEqual(arrays["ids"].tolist(), list(range(0, 420, 7)))
        self.assertListEqual(arrays["points"].ravel().tolist(), points.ravel().tolist())
        rows = np.genfromtxt(self.folder / "out.csv", delimiter=",", names=True)
        self.assertListEqual(rows["id"].tolist(), arrays["ids"].tolist())
        self.assertListEqual(rows["area"].tolist(), arrays["areas"].tolist())
        self.assertListEqual(rows["neighbors"].astype(int).tolist(), np.diff(arrays["indptr"]).tolist())
        lengths = np.add.reduceat(np.append(arrays["lengths"], 0), arrays["indptr"][:-1]) * (np.diff(arrays["indptr"]) > 0)
        np.testing.assert_allclose(rows["perimeter"], lengths, rtol=1e-14)
        np.testing.assert_array_equal(rows["perimeter"], arrays["perimeters"])
        # Random places of the surface have the areas of the cells as shares.
        ends = np.cumsum([np.linalg.norm(np.cross(*(CORNERS[list(f[1:])] - CORNERS[f[0]]))) / 2 for f in FACES])
        rng = np.random.default_rng(1)
        face = np.searchsorted(ends, rng.random(20000) * ends[-1])
        a, b = np.sqrt(rng.random((20000, 1))), rng.random((20000, 1))
        x = CORNERS[np.array(FACES)[face]]
        places = (1 - a) * x[:, 0] + a * (1 - b) * x[:, 1] + a * b * x[:, 2]
        owner = ((places[:, None] - points) ** 2).sum(axis=2).argmin(axis=1)
        np.testing.assert_allclose(np.bincount(owner, minlength=60) / 2000, arrays["areas"], atol=0.06)
        for name in ("dual.obj", "dual.ply"):
            vertices, triangles = read_mesh(self.folder / name)
            self.assertListEqual(vertices.ravel().tolist(), points.ravel().tolist())
            self.assertListEqual(triangles.ravel().tolist(), arrays["dual"].ravel().tolist())

    def test_weights_and_random(self):
        self.put("two.txt", "0.5 0.5 0.5 0\n1.5 0.5 0.5 0.5\n")  # the plane between them moves by 0.25
        self.run_cli("two.txt", "--surface", "box.off", "--weights", 4, "-o", "w.npz")
        np.testing.assert_allclose(np.load(self.folder / "w.npz")["areas"], [1 + 4 * 0.75, 1 + 4 * 1.25], rtol=1e-14)
        self.put("radii.txt", f"0.5 0.5 0.5 0\n1.5 0.5 0.5 {0.5 ** 0.5!r}\n")
        self.run_cli("radii.txt", "--surface", "box.off", "--radii", 4, "-o", "r.csv")
        np.testing.assert_allclose(np.loadtxt(self.folder / "r.csv", delimiter=",", skiprows=1)[:, 4], [4, 6], rtol=1e-14)
        for name in ("a.npz", "b.npz"):
            self.run_cli("--random", "1e2", "--rng-seed", 3, "--surface", "box.off", "-o", name, "-t", 1 + (name == "b.npz"))
        a, b = (np.load(self.folder / name) for name in ("a.npz", "b.npz"))
        self.assertEqual(sorted(a.files), sorted(b.files))
        for name in a.files:
            np.testing.assert_array_equal(a[name], b[name])
        gap = np.minimum(np.abs(a["points"]), np.abs(a["points"] - (2, 1, 1))).min(axis=1)
        self.assertEqual(len(gap), 100)
        self.assertLess(gap.max(), 1e-15)  # on the surface

    def test_remesh(self):
        names = ["new" + extension for extension in (".obj", ".off", ".ply", ".stl")]
        outputs = [word for name in names for word in ("-o", name)]
        summary = self.json("--surface", "box.off", "--remesh", 400, *outputs, "-o", "new.npz")
        self.assertEqual([summary[name] for name in ("vertices", "triangles", "border_edges", "crowded_edges", "faults")],
                         [400, 796, 0, 0, 0])
        self.assertGreater(summary["min_angle"], 15)
        self.assertLess(summary["distance"], 0.08)
        arrays = np.load(self.folder / "new.npz")
        for name in names:
            vertices, triangles = read_mesh(self.folder / name)
            self.assertAlmostEqual(volume(vertices, triangles), 2, delta=2e-3)
            self.assertEqual((len(vertices), len(triangles)), (400, 796))
            if not name.endswith(".stl"):
                self.assertListEqual(vertices.ravel().tolist(), arrays["vertices"].ravel().tolist())
                self.assertListEqual(triangles.ravel().tolist(), arrays["triangles"].ravel().tolist())
        edges = np.sort(arrays["triangles"][:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1)
        self.assertEqual(set(np.unique(edges, axis=0, return_counts=True)[1].tolist()), {2})
        for corner in CORNERS:  # kept
            self.assertTrue((arrays["vertices"] == corner).all(axis=1).any())

    def test_hdf5(self):
        self.run_cli("--random", 20, "--surface", "box.off", "-o", "out.h5", "-o", "out.npz")
        try:
            import h5py
        except ImportError:
            return
        arrays = np.load(self.folder / "out.npz")
        with h5py.File(self.folder / "out.h5") as file:
            self.assertEqual(sorted(file), sorted(arrays.files))
            for name in arrays.files:
                np.testing.assert_array_equal(file[name][()], arrays[name])

    def test_refusals(self):
        on = ("--random", 5, "--surface", "box.off")
        self.put("flat.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        mesh = ("--surface", "box.off", "-o", "a.obj", "--remesh")
        for arguments, says in (
            (("--surface", "box.off"), "there is no input"),
            ((*on, "--box", "0,0,0,1,1,1"), "--box does not go with --surface"),
            ((*on, "--2d"), "--2d does not go with --surface"),
            ((*on, "--locate", "q.txt"), "--surface is for cells of the points"),
            ((*on, "-o", "a.vtu"), "--surface writes .csv, .npz, .h5, .obj, .ply, .off and .stl, not 'a.vtu'"),
            ((*on, "-o", "-"), "not '-'"),
            ((*on, "-o", "box.off"), "output 'box.off' is the input"),
            (("--random", 5, "--remesh", 5), "--remesh goes with --surface FILE only"),
            (("--random", 5, "--surface", "a.geojson"), "give a triangle mesh"),
            (("--random", 5, "--surface", "none.off"), "cannot open 'none.off'"),
            (("--random", 0, "--surface", "box.off"), "there are no points"),
            ((*mesh, 0), "the number of vertices is 0"),
            ((*mesh, 2**31 - 1), "from 0 to 268435456, not"),
            ((*mesh, 5, "--random", 5), "--remesh chooses its own points"),
            (("--surface", "flat.off", "-o", "a.obj", "--remesh", 1), "--remesh 1 makes no triangle: give more points"),
            ((*mesh, 5, "--weights", 4), "--weights goes with INPUT"),
            ((*mesh, 5, "--sharp", 0), "--sharp is 0: give an angle above 0"),
            ((*mesh, 5, "-o", "a.csv"), "--remesh writes .npz, .h5, .obj, .ply, .off and .stl, not 'a.csv'"),
            (("--surface", "box.off", "--remesh", 5), "--remesh makes a mesh: add -o FILE"),
        ):
            self.refuse(*arguments, says=says)

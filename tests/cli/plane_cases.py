"""Two dimensions: --2d, and files whose points have two coordinates. Cells are compared with their polygons."""

import numpy as np

from cli_test import CliTest, text_of

try:
    import h5py
except ImportError:
    h5py = None

SQUARE = "0,0,1,1"


def plane_points(count=200, seed=3):
    return np.random.default_rng(seed).random((count, 2))


def area_and_perimeter(corners):
    x, y = corners.T
    sides = np.roll(corners, -1, axis=0) - corners
    return (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2, np.hypot(*sides.T).sum()


class Plane(CliTest):
    def areas(self, *arguments, **options):
        rows = self.rows(*arguments, "--format", "%i %v", **options)
        return [row.split()[1] for row in rows]

    def test_text_has_the_polygons(self):
        points = plane_points()
        self.put("a.txt", text_of(points))
        for domain in [["--box", SQUARE], ["--2d", "--box", SQUARE, "--periodic"], ["--box", SQUARE, "--periodic", "y"],
                       ["--cell", "1,0,0.25,1", "--origin", "0.5,0"], ["--2d"],
                       ["--box", SQUARE, "--wall", "1,1,1.5", "--wall", "-1,0,0", "--outside", "keep"]]:
            self.assertTrue(self.json("a.txt", *domain, "--verify")["verified"])
            rows = self.rows("a.txt", *domain, "--list-walls", "--format", "%q;%v;%F;%s;%w;%P;%p;%f;%n;%l;%c;%C;%m")
            lists = self.rows("a.txt", *domain)
            total = 0
            for i, row in enumerate(rows):
                place, area, perimeter, sides, corners, polygon, relative, lengths, names, normals, offset, centroid, radius = row.split(";")
                np.testing.assert_array_equal(np.array(place.split(), float), points[i])
                if sides == "0":
                    self.assertEqual((area, names, polygon), ("0", "", ""))
                    continue
                polygon, relative, normals = (np.array([word[1:-1].split(",") for word in text.split()], float)
                                              for text in (polygon, relative, normals))
                expected = area_and_perimeter(polygon)  # positive: counterclockwise
                np.testing.assert_allclose([float(area), float(perimeter)], expected, rtol=1e-11)
                self.assertEqual((len(polygon), corners, len(names.split())), (int(sides), sides, int(sides)))
                self.assertAlmostEqual(sum(map(float, lengths.split())), expected[1], places=11)
                seed = polygon[0] - relative[0]  # the image inside the domain
                np.testing.assert_allclose(polygon - seed, relative, atol=1e-14)
                self.assertAlmostEqual(max(np.sum(relative**2, axis=1)), float(radius), places=12)
                np.testing.assert_allclose(np.array(centroid.split(), float) - seed, np.array(offset.split(), float), atol=1e-14)
                # Outward unit normals, weighted with the lengths, sum to zero.
                np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-14)
                np.testing.assert_allclose(np.array(lengths.split(), float) @ normals, 0, atol=1e-11)
                self.assertEqual(lists[i].split()[1:], [name for name in names.split() if int(name) >= 0])
                total += expected[0]
            if "--wall" in domain:
                self.assertAlmostEqual(total, 0.875, places=12)
                self.assertTrue({"-7", "-2"} <= set(" ".join(rows).replace(";", " ").split()))
            elif domain != ["--2d"]:
                self.assertAlmostEqual(total, 1, places=12)

    def test_all_formats_hold_the_same_points(self):
        points = plane_points()
        expected = self.areas(self.put("a.txt", text_of(points)), "--2d")
        self.put("ids.txt", "".join(f"{i + 7} {row}\n" for i, row in enumerate(text_of(points).splitlines())))
        self.put("a.csv", "x,y\n" + text_of(points, ","))
        self.put("more.csv", "id,m,y,x\n" + "".join(f"{i},{2 * i},{y!r},{x!r}\n" for i, (x, y) in enumerate(points.tolist())))
        self.put("a.npy", points)
        np.save(self.folder / "flat.npy", np.column_stack((points, np.full(len(points), 2.5))))
        np.save(self.folder / "columns.npy", np.asfortranarray(points))
        np.savez(self.folder / "points.npz", points=points)
        np.savez(self.folder / "only.npz", a=points, b=points[:, 0])
        np.savez(self.folder / "axes.npz", x=points[:, 0], y=points[:, 1])
        atoms = "".join(f"{i} 1 {row}\n" for i, row in enumerate(text_of(points).splitlines()))
        head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n200\nITEM: BOX BOUNDS ff ff pp\n-9 9\n-9 9\n-0.5 0.5\nITEM: ATOMS id type x y"
        self.put("a.dump", head + "\n" + atoms)
        self.put("z.dump", head + " z\n" + atoms.replace("\n", " 0\n"))
        ply = "ply\nformat ascii 1.0\nelement vertex 200\nproperty double x\nproperty double y\nend_header\n"
        self.put("a.ply", ply + text_of(points))
        files = [("a.txt",), ("-",), ("a.csv",), ("a.npy",), ("columns.npy",), ("points.npz",), ("only.npz",), ("axes.npz",)]
        if h5py:
            with h5py.File(self.folder / "a.h5", "w") as file:
                file["here/points"] = points
            files.append(("a.h5",))
        for name, *options in files:
            stdin = text_of(points) if name == "-" else ""
            self.assertEqual(self.areas(name, *options, stdin=stdin), expected, name)
            self.assertEqual(self.areas(name, "--2d", stdin=stdin), expected, name)
            summary = self.run_cli(name, stdin=stdin).stdout
            self.assertRegex(summary, "(?m)^dimensions +2, assumed: the points have two coordinates$")
            self.assertRegex(summary, r"(?m)^domain +box -?\d[^ ,]*,[^ ,]+ to [^ ,]+,[^ ,]+, not periodic, around the points; default$")
        for name, *options in [("ids.txt", "--2d"), ("more.csv", "--2d"), ("more.csv", "--columns", "x,y"), ("more.csv", "--columns", "4,3"),
                               ("flat.npy", "--2d"), ("a.ply", "--2d"), ("axes.npz", "--columns", "x,y")]:
            self.assertEqual(self.areas(name, *options), expected, (name, options))
            self.assertRegex(self.run_cli(name, *options).stdout, "(?m)^dimensions +2, option$")
        boxed = self.areas("a.txt", "--box", "-9,-9,9,9")
        for name in ["a.dump", "z.dump"]:  # their box is that of the file
            self.assertEqual(self.areas(name, "--2d"), boxed, name)
        self.assertEqual(self.rows("ids.txt", "--2d", "--format", "%i")[:2], ["7", "8"])
        done = self.json("a.txt", "--box", SQUARE, "--periodic", "x")
        self.assertEqual((done["dimensions"], done["dimensions_from"], done["volume_sum"]), (2, "assumed", 1))
        self.assertEqual({k: done["domain"][k] for k in ("lower", "upper", "periodic", "c")},
                         {"lower": [0, 0], "upper": [1, 1], "periodic": [True, False], "c": None})
        self.assertNotIn("dimensions", self.json("--random", "9"))

    def test_random_points_fill_the_square(self):
        rows = self.rows("--random", 500, "--2d", "--periodic", "--format", "%q %v")
        numbers = np.array([row.split() for row in rows], float)
        self.assertEqual(numbers.shape, (500, 3))
        self.assertTrue((numbers[:, :2].min() >= 0) and (numbers[:, :2].max() < 1))
        self.assertAlmostEqual(numbers[:, 2].sum(), 1, places=12)

    def test_weights_and_subsets(self):
        points = plane_points()
        radii = np.linspace(0, 0.05, len(points))
        self.put("a.csv", "x,y,r\n" + text_of(np.column_stack((points, radii)), ","))
        self.put("a.txt", text_of(np.column_stack((points, radii))))
        expected = self.areas("a.csv", "--radii", "r", "--box", SQUARE)
        self.assertNotEqual(expected, self.areas("a.csv", "--2d", "--box", SQUARE))
        self.assertEqual(self.areas("a.txt", "--2d", "--radii", "3", "--box", SQUARE), expected)
        self.put("w.txt", text_of(np.column_stack((points, radii**2))))
        self.assertEqual(self.areas("w.txt", "--2d", "--weights", "3", "--box", SQUARE), expected)
        self.assertEqual(self.areas("a.csv", "--radii", "r", "--box", SQUARE, "--only", "5:50:7"), expected[5:50:7])
        longer = self.rows("a.csv", "--2d", "--min-area", "0.02", "--format", "%f")
        self.assertGreaterEqual(min(float(length) for row in longer for length in row.split()), 0.02)

    def test_arrays_and_tables(self):
        points = plane_points()
        self.put("a.txt", text_of(points))
        cell = ["--cell", "1,0,0.25,1", "--periodic", "x", "--outside", "drop"]
        self.run_cli("a.txt", *cell, "-o", "a.npz", "-o", "a.csv", "-o", "a.xyz", "-o", "a.dump", "--want",
                     "neighbors,volumes,centroids,normals,surfaces,faces")
        arrays = dict(np.load(self.folder / "a.npz"))
        for name, shape in [("box", (2, 2)), ("cell", (2, 2)), ("origin", (2,)), ("periodic", (2,)), ("centroids", (200, 2)),
                            ("shifts", (len(arrays["indices"]), 2)), ("face_normals", (len(arrays["indices"]), 2)),
                            ("vertices", (len(arrays["vertices"]), 2)), ("face_vertices", (2 * len(arrays["indices"]),))]:
            self.assertEqual(arrays[name].shape, shape, name)
        np.testing.assert_array_equal(arrays["cell"], [(1, 0), (0.25, 1)])
        # A file of clvotess states its domain.
        np.savez(self.folder / "again.npz", points=points, **arrays)
        self.assertRegex(self.run_cli("again.npz", "--outside", "drop").stdout, "(?m)^domain +cell 1,0 0.25,1 at 0,0, periodic a; stated$")
        whole = {**arrays, "cell": np.array([(1, 0), (0, 1)]), "origin": np.array([0, 0]), "box": np.array([(0, 0), (1, 1)]), "periodic": np.array([1.0, 0.0])}
        np.savez(self.folder / "whole.npz", points=points, **whole)
        self.assertRegex(self.run_cli("whole.npz", "--outside", "drop").stdout, "(?m)^domain +cell 1,0 0,1 at 0,0, periodic a; stated$")
        for name, value, says in [("cell", np.eye(3), "cell does not hold numbers with shape (2, 2)"), ("origin", None, "there is a cell, and no origin"),
                                  ("box", np.ones(4), "box does not hold"), ("periodic", np.array(True), "periodic does not hold"),
                                  ("walls", np.array(["a"]), "walls does not hold"), ("ids", np.full(200, 0.5), "ids are not whole numbers")]:
            damaged = {k: v for k, v in {**arrays, name: value}.items() if v is not None}
            np.savez(self.folder / "damaged.npz", points=points, **damaged)
            self.refuse("damaged.npz", says=says)
        table = np.genfromtxt(self.folder / "a.csv", delimiter=",", names=True)
        self.assertEqual(table.dtype.names, ("id", "x", "y", "area", "neighbors", "centroid_x", "centroid_y", "perimeter"))
        np.testing.assert_array_equal(table["area"], arrays["volumes"])
        np.testing.assert_array_equal(table["perimeter"], arrays["surface_areas"])
        beside = np.column_stack((table["centroid_x"], table["centroid_y"]))  # the listed points, also those outside of the cell
        moved = beside - arrays["centroids"]
        np.testing.assert_allclose(moved, np.column_stack((np.round(moved[:, 0]), np.zeros(200))), rtol=0, atol=1e-15)
        inside = arrays["status"] == 0
        self.assertLess(np.abs(beside - points)[inside, 0].max(), 0.5)
        self.assertGreater(np.count_nonzero(moved[inside, 0]), 9)
        # Tables with z are read back as the same plane, with their cell.
        for name in ["a.xyz", "a.dump"]:
            self.assertEqual(self.areas(name, "--2d", "--outside", "drop"), self.areas("a.txt", *cell), name)

    def test_frames(self):
        frames = [plane_points(40, seed) for seed in range(3)]
        singles = [self.areas(self.put("one.txt", text_of(points))) for points in frames]
        atoms = "".join(f"40\nProperties=species:S:1:pos:R:3\n{''.join(f'A {row} 1.5{chr(10)}' for row in text_of(points).splitlines())}"
                        for points in frames)
        names = [(self.put("a.xyz", atoms), "--2d")]
        if h5py:
            with h5py.File(self.folder / "a.h5", "w") as file:
                file["points"] = np.array(frames)
            names += [("a.h5",), ("a.h5", "--2d")]
        for name, *options in names:
            rows = self.rows(name, *options, "--frames", "all", "--format", "%v")
            expected = [row for k, areas in enumerate(singles) for row in [f"# frame {k}, 40 points", *areas]]
            self.assertEqual(rows, expected, name)
            self.assertEqual(self.areas(name, *options, "--frame", 1), singles[1])
            done = self.json(name, *options, "--frames", "1:", "--verify", "-o", "out.csv")
            self.assertEqual((done["frames"], done["dimensions"], done["verified"]), (2, 2, True))
            table = np.genfromtxt(self.folder / "out.csv", delimiter=",", names=True)
            np.testing.assert_array_equal(table["area"], np.array(singles[1] + singles[2], float))
            if h5py:
                self.run_cli(name, *options, "--frames", "all", "-o", "out.h5", "--want", "volumes,centroids")
                with h5py.File(self.folder / "out.h5") as file:
                    last = file[max(file)]
                    np.testing.assert_array_equal(last["volumes"], np.array(singles[2], float))
                    self.assertEqual((last["centroids"].shape, last.attrs["box"].shape), ((40, 2), (2, 2)))

    def test_areas_that_the_file_gives(self):
        points = plane_points(50)
        areas = np.random.default_rng(4).random(50) + 0.5
        areas /= areas.sum()
        self.put("a.csv", "x,y,part\n" + text_of(np.column_stack((points, areas)), ","))
        done = self.json("a.csv", "--volumes", "part", "--box", SQUARE, "--periodic", "-o", "a.npz", "--verify")
        self.assertLess(done["fit"]["residual"], 1e-9)
        with np.load(self.folder / "a.npz") as arrays:
            np.testing.assert_allclose(arrays["volumes"], areas, rtol=1.001e-9)
            weights = arrays["weights"]
        self.put("w.txt", text_of(np.column_stack((points, weights))))
        again = self.areas("w.txt", "--2d", "--weights", "3", "--box", SQUARE, "--periodic")
        np.testing.assert_allclose(np.array(again, float), areas, rtol=1.01e-9)

    def test_alpha_and_vtu(self):
        points = plane_points(50)
        self.put("a.txt", text_of(points))
        self.run_cli("a.txt", "--box", SQUARE, "--periodic", "--alpha", "1", "-o", "a.npz", "-o", "a.vtu", "-q")
        with np.load(self.folder / "a.npz") as arrays:
            counts = [len(arrays[f"alpha_values_{k}"]) for k in range(3)]
            self.assertEqual(counts, [50, 150, 100])
            self.assertEqual((arrays["alpha_seeds_2"].shape, arrays["alpha_shifts_2"].shape), ((100, 3), (100, 6)))
            self.assertNotIn("alpha_values_3", arrays)
        content = (self.folder / "a.vtu").read_bytes()
        self.assertIn(b'NumberOfCells="50"', content)
        self.assertNotIn(b"faceoffsets", content)

    def test_pictures(self):
        """Each pixel between the axes has the color of the nearest point's cell."""
        from picture_cases import colored, read_png

        points = plane_points(12)
        self.put("a.txt", text_of(points))
        for options in (["--box", SQUARE, "--periodic"], ["--box", SQUARE]):
            self.run_cli("a.txt", *options, "--image", "a.png", "--color", "index", "--image-size", "640x480", "-q")
            image = read_png(self.folder / "a.png").astype(int)
            wide = colored(image)
            wide[:, 520:] = False  # the color bar
            rows, columns = np.nonzero(wide)
            top, bottom, left, right = rows.min(), rows.max(), columns.min(), columns.max()
            self.assertLess(abs((bottom - top) - (right - left)), 4)
            colors, agree = {}, []
            for y in range(top + 5, bottom - 5, 7):
                for x in range(left + 5, right - 5, 7):
                    place = np.array([(x + 0.5 - left) / (right + 1 - left), (bottom + 0.5 - y) / (bottom + 1 - top)])
                    away = place - points
                    if "--periodic" in options:
                        away -= np.round(away)
                    distance = np.sort(np.hypot(*away.T))
                    if distance[1] - distance[0] < 0.02:  # near a line
                        continue
                    cell = int(np.argmin(np.hypot(*away.T)))
                    agree.append(np.abs(image[y, x] - colors.setdefault(cell, image[y, x])).max() < 3)
            self.assertEqual(len(colors), 12)
            self.assertEqual(len({tuple(color) for color in colors.values()}), 12)
            self.assertTrue(all(agree))
        self.run_cli("a.txt", "--image", "seeds.png", "--seeds", "--color", "area", "-q")
        self.refuse("--random", 9, "--image", "seeds.png", "--seeds", says="add --slice")

    def test_queries(self):
        points, queries = plane_points(), plane_points(30, seed=4)
        self.put("a.txt", text_of(points))
        self.put("q.txt", text_of(queries))
        self.put("flat.npy", np.column_stack((queries, np.full(30, 2.5))))
        away = queries[:, None] - points
        nearest = (away**2).sum(axis=2).argmin(axis=1)
        for asked in (["a.txt", "--locate", "q.txt"], ["a.txt", "--2d", "--locate", "flat.npy"], ["a.txt", "--box", SQUARE, "--locate", "q.txt"]):
            np.testing.assert_array_equal(np.array(self.rows(*asked), int), nearest)
        # The cell of a probe is that of the last of the points.
        domain = ["--box", SQUARE, "--periodic", "y", "--list-walls", "--format", "%v;%F;%s;%n;%P;%c"]
        probed = self.rows("a.txt", "--probe", "q.txt", *domain)
        for q in range(3):
            self.put("more.txt", text_of(np.vstack((points, queries[q]))))
            expected = self.rows("more.txt", *domain)[-1].split(";")
            row = probed[q].split(";")
            self.assertEqual(row[2:4], expected[2:4])
            for k in (0, 1, 4, 5):
                numbers = [np.array(text[k].replace("(", " ").replace(")", " ").replace(",", " ").split(), float) for text in (row, expected)]
                np.testing.assert_allclose(*numbers, rtol=1e-9, atol=1e-12)
        self.put("v.csv", "x,y,f\n" + text_of(np.column_stack((points, 1 + points @ [2, -3])), ","))
        field = np.array(self.rows("v.csv", "--columns", "x,y", "--values", "f", "--interpolate", "q.txt"), float)
        known = ~np.isnan(field)
        self.assertGreater(known.sum(), 20)
        np.testing.assert_allclose(field[known], (1 + queries @ [2, -3])[known], rtol=1e-10)
        rays = np.column_stack((queries, np.ones((30, 2)), np.full(30, 0.5)))
        self.put("rays.txt", text_of(rays))
        self.put("rays.npy", rays)
        rows = self.rows("a.txt", "--trace", "rays.txt", "--box", SQUARE, "--periodic")
        self.assertEqual(rows, self.rows("a.txt", "--trace", "rays.npy", "--box", SQUARE, "--periodic"))
        for q, row in enumerate(rows):
            self.assertAlmostEqual(sum(map(float, row.split()[1::2])), 0.5, 12)
            self.assertEqual(int(row.split()[0]), ((away[q] - np.round(away[q]))**2).sum(axis=1).argmin())
        self.refuse("a.txt", "--trace", "q.txt", "-o", "r.txt", says="expected the 5 of a ray")

    def test_grids(self):
        points = plane_points()
        self.put("v.csv", "x,y,f\n" + text_of(np.column_stack((points, np.arange(200.0))), ","))
        asked = ["v.csv", "--2d", "--box", "0,0,1,2", "--values", "f", "--to-grid", "mean", "--shape", "4,3"]
        done = self.run_cli(*asked, "-o", "g.npy", "-o", "g.vti", "--image", "g.png")
        self.assertEqual(done.stdout, "a grid of 4, 3 cells by mean from 200 seeds\n")
        grid = np.load(self.folder / "g.npy")
        self.assertEqual(grid.shape, (4, 3))
        areas = np.array(self.rows("v.csv", "--2d", "--box", "0,0,1,2", "--format", "%v"), float)
        self.assertAlmostEqual(grid.sum() * (2 / 12), areas @ np.arange(200.0), places=9)
        data = (self.folder / "g.vti").read_bytes()
        self.assertIn(b'WholeExtent="0 4 0 3 0 0" Origin="0 0 0" Spacing="0.25 0.6666666666666666 1"', data)
        np.testing.assert_array_equal(np.frombuffer(data[data.index(b"\n_") + 10:][:96]).reshape(3, 4).T, grid)
        self.assertEqual((self.folder / "g.png").read_bytes()[16:24], (4).to_bytes(4, "big") + (3).to_bytes(4, "big"))
        # Without a box the grid covers the default one.
        self.run_cli("v.csv", "--2d", "--values", "f", "--to-grid", "nearest", "--shape", "2", "-o", "d.vti")
        lower, upper = points.min(0) - 0.5 * np.ptp(points, axis=0).max() / 200**0.5, points.max(0) + 0.5 * np.ptp(points, axis=0).max() / 200**0.5
        head = (self.folder / "d.vti").read_bytes().split(b'"')
        np.testing.assert_allclose(np.array(head[13].split(), float), (*lower, 0), rtol=1e-12)
        np.testing.assert_allclose(np.array(head[15].split(), float), (*(upper - lower) / 2, 1), rtol=1e-12)
        self.run_cli(*asked, "--project", "y", "-o", "p.npy")
        np.testing.assert_allclose(np.load(self.folder / "p.npy"), grid.sum(1) * (2 / 3), rtol=1e-12)

    def test_refusals(self):
        self.put("a.txt", text_of(plane_points(20)))
        self.put("solid.txt", "1 0 0\n0 1 0\n0 0 1\n")
        self.put("a.csv", "x,y,m\n0,0,1\n1,1,1\n")
        self.put("z.npy", np.random.default_rng(1).random((9, 3)))
        walls = {"walls": np.ones((3, 3))}  # of a plane: they look like points of space
        np.savez(self.folder / "walls.npz", **walls)
        np.savez(self.folder / "domain.npz", box=np.eye(2), cell=np.eye(2), volumes=np.ones(2))
        if h5py:
            with h5py.File(self.folder / "walls.h5", "w") as file:
                file.update(walls)
        for arguments, says in [
                (["a.txt", "--2d", "--box", "0,0,0,1,1,1"], "--box must be 4 numbers x0,y0,x1,y1, not '0,0,0,1,1,1': --2d"),
                (["a.txt", "--2d", "--cell", "1,0,0,0,1,0,0,0,1"], "--cell must be 4 numbers ax,ay,bx,by"),
                (["a.txt", "--2d", "--wall", "1,0,0,1"], "--wall must be 3 numbers nx,ny,d"),
                (["a.txt", "--box", SQUARE, "--wall", "1,0,0,1"], "--box 0,0,1,1 means two dimensions"),
                (["a.txt", "--cell", "1,0,0,1", "--origin", "0,0,0"], "--origin must be 2 numbers x,y"),
                (["a.txt", "--box", "0,0,0,1,1,1"], "2 columns, expected 3 (x y z) or 4 (id x y z); for two dimensions add --2d"),
                (["a.txt", "--2d", "--box", SQUARE, "--periodic", "xz"], "--periodic xz needs three dimensions, but --2d"),
                
                (["solid.txt", "--box", SQUARE], "the points have three coordinates: add --2d"),
                (["z.npy", "--2d"], ["point 1 has z", "points of the plane"]),
                (["z.npy", "--columns", "1,2"], "--columns goes with"), (["walls.npz"], "no array of floats with shape"),
                (["domain.npz"], "no array of floats with shape"),
                *([(["walls.h5"], "no dataset of floats with shape")] if h5py else []),
                (["a.csv"], ["lacks 'z'", "--2d"]), (["solid.txt", "--radii", "3"], ["in addition to the named ones", "--2d"]), (["a.csv", "--2d", "--columns", "x,y,m"], "--columns x,y,m needs three dimensions"),
                (["a.txt", "--columns", "1"], "X,Y in two dimensions"), (["--random", 9, "--box", SQUARE], "for two dimensions add --2d"),
                (["--random", 9, "--2d", "--image", "a.png", "--slice", "z=0"], "--slice needs three dimensions, but --2d means two: leave one of them out"),
                (["--random", 9, "--2d", "--image", "a.png", "--cut", "none"], "--cut needs three"), (["--random", 9, "--2d", "--image", "a.png", "--color", "z"], "--color z: points of the plane have no z"),
                (["a.txt", "--box", SQUARE, "-o", "a.ply"], ["'a.ply' needs three dimensions", "--box 0,0,1,1"]),
                (["a.txt", "--2d", "-o", "a.txt.txt", "--format", "%i %t"], "--format with %t needs three"),
                (["a.txt", "--locate", "solid.txt", "-o", "q.txt"], "three coordinates, but the points of a.txt two: add --2d"),
                (["solid.txt", "--locate", "a.txt", "-o", "q.txt"], "expected 3 (x y z)"),
                (["a.csv", "--2d", "--to-grid", "mean", "--values", "m", "--shape", "2,2,2", "-o", "g.npy"], "--shape has 3 numbers, but the points 2"),
                (["solid.txt", "--to-grid", "dtfe", "--shape", "2,2", "-o", "g.npy"], "give NX,NY,NZ or N"),
                (["a.csv", "--2d", "--to-grid", "mean", "--values", "m", "--shape", "2", "--project", "z", "-o", "g.npy"], "--project z needs three"),
                (["z.npy", "--2d", "--memory", "1G", "-o", "a.h5"], ["point 1 has z", "points of the plane"]),
                (["solid.txt", "--box", SQUARE, "--memory", "1G", "-o", "a.h5"], "the points have three coordinates: add --2d"),
                (["a.txt", "--2d", "--wall-sphere", "0,0,0,1,9"], "--wall-sphere needs three"),
                (["a.txt", "--2d", "--box", "none", "-o", "a.vtu"], "leave out cells that reach infinity by --open skip")]:
            with self.subTest(arguments):
                self.refuse(*arguments, says=says)

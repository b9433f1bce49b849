#!/usr/bin/env python3
"""clvotess-mpi against clvotess: the same datasets and attributes, to the last bit, whatever the ranks.

VOTESS_CLI and VOTESS_CLI_MPI name the programs, MPIEXEC and MPIEXEC_FLAG what starts ranks.
"""
import json
import os
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cli"))
from cli_test import JSON_KEYS, CliTest, random_points, text_of  # noqa: E402

try:
    import h5py
except ImportError:
    print("NO h5py: clvotess-mpi IS NOT TESTED (Debian: python3-h5py)")
    sys.exit(0)

CLI_MPI = os.environ["VOTESS_CLI_MPI"]
MPIEXEC = [os.environ.get("MPIEXEC", "mpirun"), os.environ.get("MPIEXEC_FLAG", "-np")]
ALL = "neighbors,volumes,centroids,counts,areas,normals,surfaces,radii"


class RanksTest(CliTest):
    def on_ranks(self, ranks, *arguments, code=0, stdin="", program=(CLI_MPI,), **options):
        command = [*MPIEXEC, str(ranks), *program, *map(str, arguments)]
        done = subprocess.run(command, cwd=self.folder, input=stdin, text=True, capture_output=True, timeout=120,
                              check=False, **options)
        self.assertEqual(done.returncode, code, f"{command}\nstdout: {done.stdout}\nstderr: {done.stderr}")
        return done


class SameFile(RanksTest):
    def assert_same(self, *arguments, ranks=(3,), stdin=""):
        """Returns the file of clvotess as a dict."""
        self.run_cli(*[word for word in arguments if word != "--verify"], "-x", "cpu", "-q", "-o", "one.h5", stdin=stdin)
        with h5py.File(self.folder / "one.h5") as one:
            arrays = {name: one[name][()] for name in one}
            attributes = dict(one.attrs)
        for count in ranks:
            done = self.on_ranks(count, *arguments, "--json", "-o", "ranks.h5", stdin=stdin)
            summary = json.loads(done.stdout)
            self.assertEqual(summary["verified"], True if "--verify" in arguments else None)
            self.assertEqual(summary["ranks"], count)
            self.assertEqual(summary["points"], len(arrays["status"]))
            with h5py.File(self.folder / "ranks.h5") as file:
                self.assertEqual(sorted(file), sorted(arrays))
                self.assertEqual(sorted(file.attrs), sorted(attributes))
                for name, value in attributes.items():
                    self.assertTrue(np.array_equal(file.attrs[name], value), name)
                for name, array in arrays.items():
                    self.assertEqual((file[name].dtype, file[name].shape), (array.dtype, array.shape), name)
                    self.assertEqual(file[name][()].tobytes(), array.tobytes(), name)
        self.assertEqual(self.files_like(".clvotess"), [])
        return arrays

    def files_like(self, start):
        return [name for name in self.files() if name.startswith(start)]

    def test_npy(self):
        points = random_points(3000)
        self.put("a.npy", points)
        self.assert_same("a.npy", "--want", ALL, "--list-walls", ranks=(1, 2, 4))
        self.put("f.npy", np.asfortranarray(points.astype("f4")))
        self.assert_same("f.npy", "--box", "0,0,0,1,1,1", "--periodic", "xz", "--want", ALL)
        self.put("three.npy", points[:3])
        self.assert_same("three.npy", "--want", ALL, ranks=(4,))
        self.put("none.npy", points[:0])
        self.assert_same("none.npy", ranks=(2,))

    def test_random(self):
        self.assert_same("--random", 2000, "--rng-seed", 5, "--periodic", ranks=(2, 4))

    def test_text(self):
        points = random_points(500)
        rows = "".join(f"{7 * i + 3} " + line + f" {0.02 * (i % 5)}\n"
                       for i, line in enumerate(text_of(points).splitlines()))
        self.put("a.txt", rows)
        arrays = self.assert_same("a.txt", "--radii", 5, "--density", 5, "--copy", 5, "--verify")
        self.assertEqual(arrays["ids"][2], 17)
        self.assert_same("-", "--weights", 5, "--box", "0,0,0,1,1,1", "--periodic", stdin=rows)
        self.put("a.xyz", '2\nLattice="1 0 0 0.3 1 0 0 0.2 1" Properties=species:S:1:pos:R:3\nH 0 0 0\nH 0.5 0.5 0.4\n')
        arrays = self.assert_same("a.xyz", "--want", ALL, ranks=(3,))
        self.assertGreater(len(arrays["shifts"]), 0)
        # Ranks hand over the mass of duplicates.
        points[300:400] = points[100:200]
        points[450:] = points[:50]
        mass = np.random.default_rng(3).random(500)
        self.put("d.csv", "x,y,z,m\n" + "".join(f"{line.replace(' ', ',')},{m!r}\n"
                                               for line, m in zip(text_of(points).splitlines(), mass.tolist())))
        arrays = self.assert_same("d.csv", "--density", "m", "--copy", "m", ranks=(4,))
        self.assertAlmostEqual(np.nansum(arrays["density"] * arrays["volumes"]), mass.sum(), places=10)

    def test_dropped(self):
        """The seeds of one rank are all dropped."""
        points = random_points(60)
        points[20:40] += 2
        self.put("a.txt", text_of(points))
        arrays = self.assert_same("a.txt", "--box", "0,0,0,1,1,1", "--outside", "drop", "--want", ALL)
        self.assertTrue(np.isnan(arrays["centroids"][20:40]).all())

    def test_snapshot(self):
        """Several files, one of them without particles, columns that travel."""
        points, begin = 10 * random_points(900), [0, 300, 300, 900]
        for part in range(3):
            own = slice(begin[part], begin[part + 1])
            with h5py.File(self.folder / f"snap.{part}.hdf5", "w") as file:
                header = file.create_group("Header").attrs
                header["BoxSize"], header["NumFilesPerSnapshot"] = 10.0, 3
                header["NumPart_Total"] = np.array([900, 0])
                header["NumPart_ThisFile"] = np.array([len(points[own]), 0])
                header["Redshift"] = 0.5
                if part == 1:
                    continue
                file["PartType0/Coordinates"] = points[own]
                file["PartType0/ParticleIDs"] = np.arange(900, 0, -1)[own]
                file["PartType0/Masses"] = points[own, 0]
                file["PartType0/Velocities"] = points[own].astype("f4")
        arrays = self.assert_same("snap", "--dataset", "PartType0/Coordinates", "--periodic", "--copy", "all", "--density",
                                  "Masses", ranks=(2, 4))
        self.assertEqual(arrays["Velocities"].shape, (900, 3))
        # Files of clvotess state their domain.
        with h5py.File(self.folder / "one.h5", "a") as file:
            file["points"] = points
        (self.folder / "one.h5").rename(self.folder / "again.h5")
        self.assert_same("again.h5", "--dataset", "points")

    def test_domains(self):
        points = random_points(1000)
        points[600:700] = points[:100]
        self.put("a.npy", points)
        arrays = self.assert_same("a.npy", "--cell", "1,0,0,0.4,1,0,-0.3,0.2,1", "--want", ALL)
        self.assertEqual(int(np.sum(arrays["duplicate_of"] >= 0)), 100)
        walls = [word for sign in np.ndindex(2, 2, 2) for word in
                 ("--wall", ",".join(str(2 * s - 1) for s in sign) + f",{sum(sign) - 0.9}")]
        arrays = self.assert_same("a.npy", *walls, "--outside", "drop", "--list-walls", "--want", ALL, "--verify")
        self.assertGreater(int(np.sum(arrays["status"] == 7)), 100)

    def test_points_without_a_box(self):
        """The hull, all of space, and the plane."""
        points = random_points(600)
        self.put("a.npy", points)
        for box in ("hull", "none"):
            self.assert_same("a.npy", "--box", box, "--want", ALL, "--list-walls", "--verify")
        self.put("flat.npy", points[:, :2])
        self.assert_same("flat.npy", "--box", "hull", "--want", ALL, "--verify")
        self.assert_same("flat.npy", "--box", "0,0,1,1", "--periodic", "--want", ALL, ranks=(2,))
        self.put("flat.csv", "x,y,m\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist()))
        self.assert_same("flat.csv", "--2d", "--copy", "m", ranks=(2,))
        points[:, 2] = 0.5
        self.put("level.npy", points)
        self.assert_same("level.npy", "--2d", ranks=(2,))
        points[400:, 2] = 0.25
        self.put("levels.npy", points)
        done = self.on_ranks(2, "levels.npy", "--2d", "-o", "out.h5", code=2)
        self.assertIn("levels.npy: a point has z = 0.25, another has 0.5", done.stderr)

    def test_several_threads(self):
        self.put("a.npy", random_points(5000))
        self.assert_same("a.npy", "--threads", 2, ranks=(2,))


class Refusals(RanksTest):
    def refuse_on(self, ranks, *arguments, says, stdin=""):
        before = self.files()
        # Open MPI would wait for a second before it ends the others, which have ended.
        done = self.on_ranks(ranks, *arguments, code=2, stdin=stdin,
                             env={**os.environ, "OMPI_MCA_odls_base_sigkill_timeout": "0"})
        own = [line for line in done.stderr.splitlines() if line.startswith("clvotess-mpi: ")]
        self.assertEqual(len(own), 1, done.stderr)
        self.assertEqual(done.stdout.strip(), "")
        self.assertIn(says, own[0])
        self.assertEqual(self.files(), before)

    def test_bad_rows(self):
        points = random_points(1000)
        bad = points.copy()
        bad[700, 1] = np.nan
        self.put("nan.npy", bad)
        self.refuse_on(4, "nan.npy", "-o", "out.h5", says="rank 2: point 700: y = nan is not finite")
        bad[700, 1] = 1.5
        self.put("outside.npy", bad)
        self.refuse_on(3, "outside.npy", "--box", "0,0,0,1,1,1", "-o", "out.h5",
                       says="rank 2: point 700: y = 1.5 is outside the box")
        bad[700] = bad[3]
        self.put("twice.npy", bad)
        self.refuse_on(2, "twice.npy", "--duplicates", "error", "-o", "out.h5", says="point 700 is a duplicate of point 3")
        self.refuse_on(2, "-", "-o", "out.h5", stdin="0 0 0\n1 1\n", says="clvotess-mpi: stdin:2:")
        self.refuse_on(2, "missing.npy", "-o", "out.h5", says="clvotess-mpi: cannot open 'missing.npy'")
        with h5py.File(self.folder / "radii.h5", "w") as file:
            file["points"], file["r"] = points, -points[:, 0] - (np.arange(1000) < 500) * -2
        self.refuse_on(2, "radii.h5", "--radii", "r", "-o", "out.h5", says="rank 1: radius 500 = -")

    def test_what_ranks_cannot(self):
        for option, says in [(["-x", "gpu"], "--device gpu"), (["-o", "a.txt"], "'a.txt'"), (["-o", "a.vtu"], "'a.vtu'"),
                             (["--want", "faces"], "--want vertices and faces"), (["--min-area", "1"], "--min-area"),
                             (["-o", "a.h5", "-o", "b.h5"], "-o once"), (["--locate", "q.npy"], "--locate"),
                             (["--man"], "run clvotess"), (["--nothing"], "unknown option")]:
            with self.subTest(option):
                self.refuse_on(2, "--random", 10, *option, says=says)
        self.refuse_on(2, "--random", 10, "-o", "no/folder.h5", says="there is no folder")

    def test_disk_full(self):
        # Only of the ranks, for mpirun has large files too, as would have ranks that share memory.
        limited = ["sh", "-c", "trap '' XFSZ; ulimit -f 2000; exec \"$0\" \"$@\"", CLI_MPI]
        done = self.on_ranks(2, "--random", 20000, "-o", "out.h5", code=1, program=limited,
                             env={**os.environ, "OMPI_MCA_btl": "self,tcp"})
        own = [line for line in done.stderr.splitlines() if line.startswith("clvotess-mpi: ")]
        self.assertEqual(len(own), 1, done.stderr)
        self.assertIn("cannot write 'out.h5'", own[0])
        self.assertEqual(self.files(), [])

    def test_answers(self):
        done = self.on_ranks(2, "--help")
        self.assertEqual(done.stdout.count("usage: "), 1)
        self.assertRegex(self.on_ranks(2, "--version").stdout, r"\Aclvotess-mpi [0-9.]+\n\Z")
        done = self.on_ranks(2, "--random", 100)
        self.assertEqual(done.stdout.count("points        100\n"), 1)
        self.assertIn("ranks         2", done.stdout)
        summary = json.loads(self.on_ranks(2, "--random", 3000, "--json").stdout)
        self.assertEqual(list(summary), JSON_KEYS + ["ranks", "rounds", "ghosts_received", "ghosts_needed"])
        alone = self.json("--random", 3000, "-x", "cpu")
        for key in ("points", "domain", "faces", "mean_faces", "box_volume", "duplicates", "empty_cells"):
            self.assertEqual(summary[key], alone[key], key)
        self.assertLessEqual(summary["rounds"], 4)
        self.assertLess(0, summary["ghosts_needed"])
        self.assertLessEqual(summary["ghosts_received"], 3 * summary["ghosts_needed"])


class Killed(RanksTest):
    def ranks_of(self, process):
        """Process ids."""
        listed = subprocess.run(["ps", "-o", "pid=,args=", "--ppid", str(process.pid)], capture_output=True, text=True,
                                check=False)
        return [int(line.split(None, 1)[0]) for line in listed.stdout.splitlines() if "clvotess-mpi" in line]

    def are_at_work(self, process):
        """Whether all ranks have begun to clip: mpirun may hang when one dies while MPI begins."""
        try:
            ticks = [Path(f"/proc/{rank}/stat").read_text().rsplit(")", 1)[1].split()[11]
                     for rank in self.ranks_of(process)]
        except FileNotFoundError:  # it has ended
            return False
        return len(ticks) == 3 and min(map(int, ticks)) >= 0.2 * os.sysconf("SC_CLK_TCK")

    def kill_one(self, which, when, count):
        command = [*MPIEXEC, "3", CLI_MPI, "--random", str(count), "--want", "neighbors,areas,normals", "-o", "out.h5"]
        with subprocess.Popen(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
            try:
                ranks = []
                while len(ranks) < 3 or not when(run):
                    self.assertIsNone(run.poll(), "it ended before a rank could be killed")
                    ranks = ranks if len(ranks) == 3 else self.ranks_of(run)
                    time.sleep(0.001)
                os.kill(ranks[which], signal.SIGKILL)  # at once: the file may soon be whole
                self.assertNotEqual(run.wait(timeout=60), 0)
            finally:
                run.kill()
        self.assertEqual(self.files(), [])

    def test_while_it_writes(self):
        self.kill_one(-1, lambda run: self.files() != [], 200000)

    def test_while_it_clips(self):
        self.kill_one(0, self.are_at_work, 2000000)  # they clip ten times as long as they are watched


if __name__ == "__main__":
    unittest.main()

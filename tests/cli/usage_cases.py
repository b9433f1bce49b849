"""Options, domain, duplicates, help, summary and verification."""

import json
import os
import re
import shutil
import subprocess
import time
import unittest

import numpy as np

from cli_test import (CLI, ROOT, JSON_KEYS, SECONDS_KEYS, OPTIONS, SHORT_OPTIONS, CUBE, CUBE_BOX, CliTest,
                      random_points)


class Usage(CliTest):
    def test_bad_usage(self):
        self.put("a.txt", CUBE)
        self.put("b.txt", CUBE)
        for arguments, says in [([], "INPUT"), (["a.txt", "b.txt"], "'b.txt'"), (["a.txt", "--random", "5"], "not both"),
                                (["a.txt", "--rng-seed", "5"], "--rng-seed"), (["--rng-seed", "5"], "--random"),
                                (["--random", "-5"], "'-5'"), (["--random", "x"], "'x'"), (["--random", "1.5"], "'1.5'"),
                                (["--random", "2147483648"], "'2147483648'"),
                                (["--random", "3e9"], "'3e9'"), (["--random", "1e-1"], "'1e-1'"), (["--random"], "--random"),
                                (["--random", "5", "--rng-seed", "-1"], "'-1'"),
                                (["a.txt", "--box", "0,0,0,1,1"], "--box"), (["a.txt", "--box", "0,0,0,1,1,z"], "'z'"),
                                (["a.txt", "--box", "0,0,0,1,1,1,1"], "--box"), (["a.txt", "--box", ""], "--box"),
                                (["a.txt", "--box", "none", "-o", "a.ply"], "--open skip"),
                                (["a.txt", "--box", "none", "--image", "a.png"], "--open skip"),
                                (["a.txt", "--box", "none", "--periodic"], "no end along it"),
                                (["a.txt", "--open", "no"], "'no'"),
                                (["a.txt", "--box", "hull", "--wall", "1,0,0,9"], "hull"),
                                (["a.txt", "--box", "hull", "--periodic"], "hull"),
                                (["a.txt", "--box"], "--box"), (["a.txt", "--box", "0,0,0,1,,1"], "''"),
                                (["a.txt", "-x", "toaster"], ["'toaster'", "auto, cpu, gpu, lavapipe", "index"]),
                                (["a.txt", "-x", "GPU"], "'GPU'"), (["a.txt", "-x", ""], "''"),
                                (["a.txt", "-x", "-1"], "'-1'"), (["a.txt", "--device=+1"], "'+1'"),
                                (["a.txt", "-x", "0x1"], "'0x1'"), (["a.txt", "-x", "1000000"], "'1000000'"),
                                (["a.txt", "-x", "cpu "], "'cpu '"), (["a.txt", "-x", "cpu", "-x", "cpu"], "device"),
                                (["a.txt", "-k", "-1"], ["--k-init", "'-1'"]), (["a.txt", "-k", "1025"], "1024"),
                                (["a.txt", "--k-init", "1.5"], "'1.5'"), (["a.txt", "-k"], "k-init"),
                                (["a.txt", "--chunk-size", "-1"], ["--chunk-size", "'-1'"]),
                                (["a.txt", "--chunk-size", "4294967296"], "4294967295"),
                                (["a.txt", "--chunk-size", "1e6"], "'1e6'"),
                                (["a.txt", "--instructions", "sse"],
                                 ["instructions", "baseline, avx2 or avx512", "'sse'"]),
                                (["a.txt", "--precision", "half"], ["--precision", "single or double", "'half'"]),
                                (["a.txt", "--precision", "Single"], "'Single'"),
                                (["a.txt", "--precision", ""], "''"), (["a.txt", "--precision"], "precision"),
                                (["a.txt", "-t", "-1"], "'-1'"), (["a.txt", "-t", "two"], "'two'"),
                                (["a.txt", "-t", "1025"], "1024"), (["a.txt", "-t", "1", "-t", "2"], "threads"),
                                (["a.txt", "-g", "-1"], "--grid-resolution"), (["a.txt", "-g", "1048577"], "1048576"),
                                (["a.txt", "-g", "99999999999999999999"], "--grid-resolution"),
                                (["a.txt", "--duplicates", "maybe"], "'maybe'"),
                                (["a.txt", "--want", "cells"], ["'cells'", "neighbors, volumes, centroids, counts"]),
                                (["a.txt", "--want", "volumes,face_area"], ["--want has 'face_area'", "did you mean face_areas?"]),
                                (["a.txt", "--want", "volumes,edges"], "'edges'"), (["a.txt", "--want", ""], "''"),
                                (["a.txt", "--weights", "4", "--radii", "4"], "not both"),
                                (["--random", "5", "--radii", "4"], "--random"), (["a.txt", "--weights", ""], "--weights"),
                                (["a.txt", "--dataset", "a"], "--dataset"), (["a.txt", "--dataset", ""], "--dataset"),
                                (["--random", "5", "--dataset", "a"], "--random"), (["a.txt", "--frame", "x"], "'x'"),
                                (["a.txt", "--frame", "1"], "LAMMPS"), (["--random", "5", "--frame", "1"], "--random"),
                                (["a.txt", "--format", "%i"], "text output"),
                                (["a.txt", "-o", "c.npz", "--format", "%i"], "text output"),
                                (["a.txt", "--box", "0", "0", "0", "1", "1", "1"], "commas, as in --box 0,0,0,1,1,1"),
                                (["a.txt", "-o", "-", "--json"], "stdout"), (["a.txt", "-o", "-", "-o", "-"], "twice"),
                                (["a.txt", "--quiet=maybe"], "quiet"), (["a.txt", "-o"], "output")]:
            with self.subTest(arguments):
                self.refuse(*arguments, says=says)

    def test_options_and_outputs_that_do_not_exist(self):
        self.put("a.txt", CUBE)
        for option in ["--bogus", "-z", "--walls", "--kernel"]:
            with self.subTest(option):
                self.refuse("a.txt", option, "-o", "out.txt", says=["unknown option", option.split("=")[0]])
        for typed, meant in [("--periodc", "periodic"), ("--periodic-xy", None), ("--dnesity=m", "density"),
                             ("--wall-sphre", "wall-sphere"), ("-periodic", "periodic"), ("--outsid", "outside"),
                             ("--inter", "interpolate"), ("--image_size", "image-size"), ("--Box", "box"),
                             ("--seed", "seeds or --rng-seed"), ("--resolution", "grid-resolution"),
                             ("--x", None), ("--qwertyuiop", None), ("--" + "periodic" * 9, None), ("--=", None)]:
            message = self.refuse("a.txt", typed, "-o", "out.txt", says=f"unknown option '{typed[:60]}")
            self.assertIn(f": did you mean --{meant}?\n" if meant else ": clvotess --help-all lists all options\n", message)
        for arguments, says in [(["--box"], "--box needs a value: --box x0,y0,z0,x1,y1,z1"),
                                (["-t", "1", "-t", "2"], "--threads is given 2 times: give it once"),
                                (["-o"], "--output needs a value: -o, --output FILE"),
                                (["--json=1"], "--json takes no value"),
                                (["--voro++"], "--voro++ must be the first argument")]:
            self.refuse("a.txt", *arguments, says=says)
        for name in ["a.vtp", "a.step", "out", "out.tsv"]:
            self.refuse("a.txt", "-o", name, says=[f"'{name}'", ".npz"])

    def test_bad_domain(self):
        self.put("a.txt", CUBE)
        message = self.refuse("a.txt", "-o", "out.npz", "--box", "-0.5,-0.5,-0.5,1.5,0.75,1.5", says="1")
        self.assertRegex(message, r"\b2\b")  # the first point outside
        for box in ["0,0,0,0,1,1", "0,0,0,1,-1,1", "0,0,nan,1,1,1", "0,0,0,1,1,-inf", "0,0,0,1e999,nan,1"]:
            self.refuse("a.txt", "-o", "out.npz", "--box", box, says="box")
            self.refuse("--random", "0", "-o", "out.npz", f"--box={box}", says="box")
        cell = ["--cell", "2,0,0,0.5,2,0,0,0,2"]
        for periodic, axes in [([], "xyz"), (["--periodic"], "xyz"), (["--periodic", "zx"], "xz"), (["--periodic=none"], "")]:
            summary = self.json("--random", "10", *cell, *periodic, "--outside", "drop")
            self.assertEqual(summary["box_volume"], 8)
            self.assertEqual(summary["domain"], {
                "kind": "cell", "lower": [0, 0, 0], "upper": [2.5, 2, 2], "origin": [0, 0, 0], "a": [2, 0, 0],
                "b": [0.5, 2, 0], "c": [0, 0, 2], "periodic": [axis in axes for axis in "xyz"], "from": "option",
                "periodic_from": "option" if periodic else "default"})
        self.refuse("a.txt", *cell, "--periodic=none", "-o", "out.npz", says=["point", "outside of the cell"])
        self.refuse("a.txt", *cell, "--box", CUBE_BOX, "-o", "out.npz", says="--box and --cell")
        self.refuse("a.txt", *cell, "--wall", "1,0,0,1", "-o", "out.npz", says="--wall and --cell")
        round_walls = ["--wall-sphere=0.5,0.5,0.5,1,100", "--wall-cylinder=0.5,0.5,0.5,0,0,1,0.6,30",
                       "--wall-cone=0.5,0.5,-1,0,0,2,0.4,20"]
        summary = self.run_cli("--random", "60", *round_walls, "--wall", "1,1,1,2.5", "--outside", "drop", "--verify").stdout
        self.assertIn("cut by 151 walls", summary)
        self.refuse("a.txt", "--wall-sphere=0,0,0,1,3.5", says=["--wall-sphere", "whole number"])
        self.refuse("a.txt", "--wall-sphere=0,0,0,1,2", says="2 faces")
        self.refuse("a.txt", "--wall-cone=0,0,0,1,2", says="x,y,z,ax,ay,az,ANGLE,FACES")
        for periodic in [["--periodic"], ["--periodic", "y"]]:
            self.refuse("a.txt", *periodic, "-o", "out.npz", says="--periodic needs a box")
        self.refuse("a.txt", "--periodic", "abc", says=["--periodic", "none", "'abc'"])
        domain = self.json("a.txt", "--periodic=none")["domain"]
        self.assertEqual((domain["kind"], domain["from"], domain["a"]), ("box", "default", None))
        self.assertRegex(self.run_cli("--random", "9", "--periodic", "xy").stdout,
                         "(?m)^domain +box 0,0,0 to 1,1,1, periodic xy; option$")
        self.assertRegex(self.run_cli("--random", "9", *cell, "--periodic", "xz").stdout,
                         "(?m)^domain +cell 2,0,0 0.5,2,0 0,0,2 at 0,0,0, periodic ac; option$")
        self.assertRegex(self.run_cli("a.txt", "--wall", "1,1,1,9").stdout,
                         "(?m)^domain +box .* to .*, cut by 1 wall, not periodic, around the points; default$")
        self.assertEqual(self.json("a.txt", f"--box={CUBE_BOX}")["box_volume"], 8)
        self.assertEqual(self.json("a.txt", "--box", CUBE_BOX)["box_volume"], 8)
        self.assertEqual(self.json("a.txt", "--box", "0,0,0,1,1,1")["box_volume"], 1)

    def test_default_box(self):
        points = random_points(64) * [2, 1, 1]
        self.put("a.npy", points)
        sides = np.ptp(points, axis=0) + np.ptp(points, axis=0).max() / 4
        self.assertAlmostEqual(self.json("a.npy")["box_volume"], sides.prod(), places=12)

    def test_duplicates(self):
        self.put("a.txt", CUBE + "0 1 0\n0 0 0\n")
        summary = self.json("a.txt", "-o", "out.npz", "--box", CUBE_BOX)
        self.assertEqual((summary["duplicates"], summary["empty_cells"]), (2, 2))
        with np.load(self.folder / "out.npz") as arrays:
            self.assertEqual(arrays["duplicate_of"].tolist(), [-1] * 8 + [2, 0])
            self.assertEqual(arrays["duplicate_of"].dtype, np.int32)
            self.assertEqual(arrays["status"].tolist(), [0] * 8 + [5, 5])
            self.assertEqual(arrays["volumes"].tolist(), [1] * 8 + [0, 0])
        rows = self.rows("a.txt", "--box", CUBE_BOX, "--format", "%i|%n|%v|%s|%w|%c")
        self.assertEqual(rows[0], "0|1 2 4|1|6|8|0 0 0")
        self.assertEqual(rows[8], "8||0|0|0|nan nan nan")
        (self.folder / "out.npz").unlink()
        message = self.refuse("a.txt", "-o", "out.npz", "--duplicates", "error")
        self.assertRegex(message, r"\b8\b")
        self.assertRegex(message, r"\b2\b")
        self.assertEqual(self.rows("a.txt", "--duplicates", "merge"), self.rows("a.txt"))

    def test_tuning_never_changes_the_answer(self):
        arguments = ["--random", "3000", "--format", "%i %n"]
        expected = self.rows(*arguments)
        for option in [["-t", "1"], ["--threads=3"], ["-t0"], ["-g", "1"], ["--grid-resolution", "40"], ["-g", "0"],
                       ["-x", "cpu"], ["--device", "auto"], ["-xauto"], ["-k", "1"], ["--k-init=1024"], ["-k0"],
                       ["--chunk-size", "1000"], ["--chunk-size=0"], ["--chunk-size", "4294967295"],
                       ["--precision", "single"], ["--precision=double"], ["--instructions", "baseline"]]:
            self.assertEqual(self.rows(*arguments, *option), expected, option)
        self.assertEqual(self.json("--random", "3000", "-t", "1")["threads"], 1)

    @unittest.skipUnless(hasattr(os, "sched_setaffinity"), "needs affinity masks")
    def test_threads_are_those_of_the_affinity_mask(self):
        processors = sorted(os.sched_getaffinity(0))
        for mask in (processors[:1], processors[-1:], processors[:2], processors):
            limited = {"preexec_fn": lambda mask=mask: os.sched_setaffinity(0, mask)}
            self.assertEqual(self.json("--random", "3000", **limited)["threads"], min(len(mask), 1024))
            self.assertRegex(self.run_cli("--list-devices", **limited).stdout, rf"\b{len(mask)} threads?,")

    def test_help_is_true_and_complete(self):
        for option in ["-h", "--help"]:
            done = self.run_cli(option)
            self.assertEqual(done.stderr, "")
        usual = done.stdout
        rows = [line for line in usual.splitlines() if re.match(r"  [-I]", line)]
        self.assertTrue(10 <= len(rows) <= 12, usual)
        text = self.run_cli("--help-all").stdout
        self.assertEqual(set(re.findall(r"(?<![\w-])--[a-z0-9][a-z-]*(?:\+\+)?", text)), set(OPTIONS))
        for option in SHORT_OPTIONS:
            self.assertRegex(text, rf"(?m)^  {option}, --")
        for code in "ixyzqrwpPomgEesFAaftlnvcC%":
            self.assertIn("%" + code, text)
        for word in ["units", "exit codes", ".xyz", ".txt", ".dat ", ".csv", ".npy", ".npz", ".h5", ".hdf5", ".dump",
                     ".lammpstrj", ".data", ".lmp", ".ply", ".vtu", ".obj", ".glb", "stdin", "stdout", "default"]:
            self.assertIn(word, text)
        for page in [usual, text]:
            self.assertLessEqual(max(map(len, page.splitlines())), 100)
        # The example runs unchanged, with fewer points.
        example = next(line for line in text.splitlines() if line.startswith("  clvotess --random 1e6"))
        example = example.strip().replace("1e6", "1e3").replace("clvotess", f'"{CLI}"', 1)
        subprocess.run(example, shell=True, cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(len((self.folder / "cells.txt").read_text().splitlines()), 1000)

    def test_manual_page(self):
        page = self.run_cli("--man").stdout
        self.assertTrue(page.startswith(".TH CLVOTESS 1"))
        for option in OPTIONS:
            self.assertIn(option.replace("-", "\\-"), page)
        if shutil.which("groff"):
            done = subprocess.run(["groff", "-man", "-Tascii", "-ww", "-z"], input=page, text=True, capture_output=True,
                                  check=True)
            self.assertEqual(done.stderr, "")

    def test_completion(self):
        for shell in ["bash", "zsh", "fish"]:
            script = self.run_cli("--completion", shell).stdout
            for option in OPTIONS:
                self.assertIn(option if shell != "fish" else "-l " + option[2:], script)
        self.refuse("--completion", "tcsh", says="'tcsh'")
        ask = f"""source <("{CLI}" --completion bash)
            COMP_WORDS=(clvotess a.txt --dev); COMP_CWORD=2; _clvotess; echo "${{COMPREPLY[*]}}"
            COMP_WORDS=(clvotess -x l); COMP_CWORD=2; _clvotess; echo "${{COMPREPLY[*]}}"
            COMP_WORDS=(clvotess some); COMP_CWORD=1; _clvotess; echo "${{COMPREPLY[*]}}" """
        self.put("something.xyz", "")
        done = subprocess.run(["bash", "-euc", ask], cwd=self.folder, text=True, capture_output=True, check=True)
        self.assertEqual(done.stdout.splitlines(), ["--device", "lavapipe", "something.xyz"])

    def test_documentation_names_only_options_that_exist(self):
        readme = ROOT / "README.md"
        if not readme.exists():
            self.skipTest("no README.md")
        pages = (ROOT / "bindings/python/docs/pages").glob("*.md")
        commands = [c for page in (readme, *pages) for c in re.findall(r"clvotess [^\n`]*", page.read_text("utf-8"))]
        self.assertTrue(commands)
        for command in commands:
            for option in re.findall(r"(?<=\s)--[a-z0-9][a-z-]*(?:\+\+)?", command):
                self.assertIn(option, OPTIONS, command)

    def test_version(self):
        done = self.run_cli("--version")
        self.assertRegex(done.stdout, r"\Aclvotess \d+\.\d+\.\d+\n\Z")
        self.assertEqual(done.stdout.split()[1], self.json("--random", "5")["version"])

    def test_list_devices(self):
        heads, *rows = self.run_cli("--list-devices").stdout.splitlines()
        self.assertEqual(heads.split(), ["device", "name", "description"])
        columns = [heads.index(head) for head in heads.split()]
        ids = []
        for row in rows:
            for column in columns[1:]:
                self.assertEqual((row[column - 2:column], row[column:column + 1].isspace()), ("  ", False), row)
            ids.append(row.split()[0])
        self.assertEqual(ids.count("cpu"), 1)
        self.assertEqual([i for i in ids if i != "cpu"], [str(i) for i in range(len(ids) - 1)])
        for device in ids:
            self.assertEqual(self.json("--random", "50", "-x", device)["points"], 50)

    def test_devices_that_may_be_missing(self):
        for device in ["gpu", "lavapipe", "0", "999999"]:
            with self.subTest(device):
                done = subprocess.run([CLI, "--random", "50", "-x", device, "-q", "-o", "out.txt"], cwd=self.folder,
                                      text=True, capture_output=True, timeout=300, check=False)
                self.assertIn(done.returncode, [0, 2])
                self.assertRegex(done.stderr, r"\A(clvotess: [^\n]+\n)?\Z")
                self.assertEqual(done.stderr != "", done.returncode == 2)
                self.assertEqual(self.files(), ["out.txt"] if done.returncode == 0 else [])
                shutil.rmtree(self.folder)
                self.folder.mkdir()

    def test_summary_on_stdout(self):
        text = self.run_cli("--random", "1000").stdout
        for word in ["points        1000\n", "mean faces", "volume sum", "exact", "thread", "seconds", "peak memory"]:
            self.assertIn(word, text)
        self.assertLess(len(text.splitlines()), 16)
        self.assertNotIn("volume sum", self.run_cli("--random", "9", "--want", "neighbors").stdout)
        quiet = self.run_cli("--random", "1000", "-q")
        self.assertEqual(quiet.stdout + quiet.stderr, "")
        self.assertEqual(self.run_cli("--random", "1000", "--quiet").stdout, "")

    def test_summary_gives_way_to_text_on_stdout(self):
        done = self.run_cli("--random", "10", "-o", "-")
        self.assertEqual(len(done.stdout.splitlines()), 10)
        self.assertIn("mean faces", done.stderr)

    def test_json(self):
        started = time.monotonic()
        done = self.run_cli("--random", "20000", "--json", "-q", "-o", "out.txt")
        elapsed = time.monotonic() - started
        self.assertEqual(done.stdout.count("\n"), 1)
        self.assertEqual(done.stderr, "")
        summary = json.loads(done.stdout)
        self.assertEqual(list(summary), JSON_KEYS)
        self.assertEqual(list(summary["seconds"]), SECONDS_KEYS)
        seconds = summary["seconds"]
        self.assertTrue(all(isinstance(value, (int, float)) and value >= 0 for value in seconds.values()))
        stages = sum(value for key, value in seconds.items() if key != "total")
        self.assertLessEqual(stages, seconds["total"] * 1.001 + 1e-4)
        self.assertLessEqual(seconds["total"], elapsed)
        self.assertGreater(seconds["clip"], 0)
        self.assertGreater(seconds["write"], 0)
        self.assertEqual((summary["points"], summary["duplicates"], summary["empty_cells"], summary["fallback_cells"]),
                         (20000, 0, 0, 0))
        self.assertAlmostEqual(summary["volume_sum"], 1, places=10)
        self.assertAlmostEqual(summary["mean_faces"], summary["faces"] / 20000)
        self.assertTrue(14 < summary["mean_faces"] < 15.6)
        self.assertIsNone(summary["verified"])
        self.assertIsNone(summary["proven"])
        self.assertIsNone(summary["unproven"])
        self.assertIsNone(summary["verified_cells"])
        self.assertGreater(summary["peak_memory_bytes"], 1e6)
        self.assertGreaterEqual(summary["threads"], 1)
        self.assertIsInstance(summary["device"], str)
        self.assertIsNone(self.json("--random", "9", "--want", "neighbors")["volume_sum"])
        self.assertIsNone(self.json("--random", "9", "--want", "neighbors", "--verify")["volume_sum"])

    def test_lattice_needs_exact_arithmetic(self):
        self.put("a.txt", CUBE)
        self.assertGreater(self.json("a.txt", "--box", CUBE_BOX)["exact_cells"], 0)

    def test_verify(self):
        for extra in [[], ["--list-walls"], ["--want", "neighbors"], ["--want", "volumes", "-o", "out.npz"], ["-t", "1"]]:
            summary = self.json("--random", "5000", "--verify", *extra)
            self.assertEqual([summary[key] for key in ("verified", "proven", "unproven", "verified_cells")],
                             [True, True, None, 5000])
        for want in ["volumes", "volumes,faces"]:
            self.assertRegex(self.run_cli("--random", "500", "--verify", "--want", want).stdout,
                             "(?m)^verified +yes, all cells proven$")
        dropped = ["--random", "500", "--verify", "--min-face", "1e-3"]
        summary = self.json(*dropped)
        self.assertEqual([summary[key] for key in ("verified", "proven", "unproven", "verified_cells")],
                         [True, True, None, 500])
        self.assertRegex(self.run_cli(*dropped).stdout, "(?m)^verified +yes, all cells proven$")
        with np.load(self.folder / "out.npz") as arrays:
            self.assertNotIn("indices", arrays.files)  # computed for the check, not requested

    def test_exit_codes_of_library_errors(self):
        environment = self.preloading(
            "#include <cstdlib>\n"
            "votess::Tessellation votess::tessellate(std::span<const double>, const Options&)"
            "{ throw Error(static_cast<ErrorCode>(std::atoi(std::getenv(\"ERROR\"))), \"device 'gpu':\\nno luck\"); }\n")
        # As votess_status in C; invalid_argument, unsupported, out_of_memory, internal, device_lost.
        for error, code in [(1, 2), (4, 2), (2, 1), (5, 1), (6, 1)]:
            done = self.run_cli("--random", "50", "-x", "gpu", "-o", "out.txt", code=code, env={**environment, "ERROR": str(error)})
            self.assertEqual((done.stdout, done.stderr), ("", "clvotess: device 'gpu': no luck\n"))
            self.assertEqual(self.files(), [])

    def test_options_reach_the_library(self):
        environment = self.preloading(
            "votess::Tessellation votess::tessellate(std::span<const double>, const Options& o) {"
            "  throw Error(ErrorCode::internal, o.device + ' ' + std::to_string(o.threads) + ' ' +"
            "    std::to_string(o.grid_resolution) + ' ' + std::to_string(o.k_init) + ' ' +"
            "    std::to_string(o.chunk_size) + ' ' + o.instructions + (o.precision == Precision::double_ ? \" double\" : \" single\")); }\n")
        for options, told in [([], "auto 0 0 0 0  single"),
                              (["-x", "lavapipe", "-t", "2", "-g", "3", "-k", "1024", "--chunk-size", "4294967295",
                                "--precision", "double", "--instructions", "baseline"],
                               "lavapipe 2 3 1024 4294967295 baseline double"),
                              (["-x", "999999", "--precision", "single"], "999999 0 0 0 0  single")]:
            done = self.run_cli("--random", "50", *options, code=1, env=environment)
            self.assertEqual(done.stderr, f"clvotess: {told}\n")

    def test_failed_verification(self):
        # The library's report for a wrong result.
        environment = self.preloading(
            "votess::VerifyReport votess::verify(const Tessellation&, std::span<const double>, const VerifyOptions&)"
            "{ return {false, \"seed 3 lists 5\\nbut not back\", {}, 7}; }\n")
        done = self.run_cli("--random", "50", "--verify", "--json", "-o", "out.txt", "-o", "out.npz", code=3,
                            env=environment)
        self.assertIs(json.loads(done.stdout)["verified"], False)
        self.assertEqual(json.loads(done.stdout)["verified_cells"], 7)
        self.assertRegex(done.stderr, r"\Aclvotess: verification failed[^\n]*seed 3 lists 5 but not back\n\Z")
        self.assertEqual(self.files(), [])


class Words(CliTest):
    """Refusals name options of the command line, whatever the library calls them."""

    OPTIONS = [
        ["--2d"], ["--box", "none"], ["--box", "hull"], ["--box", "0,0,0,1,1,1"], ["--box", "0,0,0,1,1,0"], ["--periodic"],
        ["--periodic", "x"], ["--cell", "2,0,0,0.5,2,0,0,0,2"], ["--cell", "1,0,0,2,0,0,0,0,1"], ["--wall", "1,0,0,0.5"],
        ["--wall", "0,0,0,1"], ["--wall-sphere", "0.5,0.5,0.5,0.1,2"], ["--mesh", "cube.off"], ["--mesh", "hole.off"],
        ["--outside", "drop"], ["--outside", "keep"], ["--only", "0:2"], ["--only", "99"], ["--min-face", "0.1"],
        ["--min-face=-1"], ["--min-area", "0.1"], ["--weights", "5"], ["--radii", "5"], ["--volumes", "4"],
        ["--volumes", "4", "--normalize", "--tolerance", "0"], ["--volumes", "4", "--normalize", "--max-steps", "0"],
        ["--watershed", "4"], ["--watershed", "5", "--merge", "nan"], ["--alpha", "1"], ["--alpha", "2"],
        ["--duplicates", "error"], ["--want", "vertices"], ["--want", "radii,counts"], ["--want", "none"], ["--device", "none"],
        ["--threads", "5000"], ["--memory", "1000"], ["--memory", "2M"], ["--instructions", "none"],
        ["--image", "p.png", "--slice", "z=9"], ["--probe", "q.txt"], ["--locate", "q.txt"], ["--trace", "rays.txt"],
        ["--interpolate", "q.txt", "--values", "4"], ["--to-grid", "dtfe", "--values", "4", "--shape", "2"],
    ]  # fmt: skip
    # One of a pair is among these.
    FIRST = [["--box", "none"], ["--box", "hull"], ["--periodic"], ["--cell", "2,0,0,0.5,2,0,0,0,2"], ["--mesh", "cube.off"],
             ["--only", "0:2"], ["--min-face", "0.1"], ["--volumes", "4"]]
    ARRAYS = re.compile(r"\b(face_areas|face_normals|surface_areas|mesh_areas|security_radii|cell_vertices|duplicate_of"
                        r"|(face|edge|vertex)_counts|cell_vertex_\w+|face_offsets|face_vertices)\b")

    def test_pairs_of_options(self):
        rows = np.column_stack((2 * random_points(8) - 0.5, np.linspace(0.1, 0.2, 8), -random_points(8)[:, 0]))
        self.put("a.txt", "".join(" ".join(map(repr, row)) + "\n" for row in rows.tolist()))
        self.put("q.txt", CUBE)
        self.put("rays.txt", "0 0 0 0 0 0 1\n")
        faces = ["0 1 3", "0 3 2", "4 6 7", "4 7 5", "0 4 5", "0 5 1", "2 3 7", "2 7 6", "0 2 6", "0 6 4", "1 5 7", "1 7 3"]
        for name, some in (("cube.off", faces), ("hole.off", faces[1:])):
            corners = "".join(f"{x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
            self.put(name, f"OFF\n8 {len(some)} 0\n{corners}" + "".join(f"3 {face}\n" for face in some))
        names = "|".join(name[2:] for name in OPTIONS)
        foreign = re.compile(rf"::|\w\(\)|`|[a-z]_[a-z]|\b(leave out|set|raise|give|use|without|with) ({names}|walls|planar)\b")
        refusals = {}
        for some in [*([one] for one in self.OPTIONS), *([a, b] for a in self.FIRST for b in self.OPTIONS if a[0] != b[0])]:
            words = [word for one in some for word in one]
            for_numbers = {"--locate", "--interpolate", "--to-grid"} & {*words}
            columns = [] if {"--weights", "--radii", "--volumes", "--watershed", "--values"} & {*words} else ["--copy", "4,5"]
            output = "o.h5" if "--memory" in words else "o.npy" if for_numbers else "o.npz"
            command = [CLI, "a.txt", *words, *columns, "-q", "-x", "cpu", "-t", "1", "-o", output]
            if "--device" in words or "--threads" in words:
                command = command[:-6] + command[-2:]
            done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
            if done.returncode not in (0, 3):
                refusals.setdefault(done.stderr, " ".join(command[1:]))
        wrong = [f"{text}  of {words}" for text, words in refusals.items() if foreign.search(self.ARRAYS.sub("", text))]
        self.assertFalse(wrong, "\n" + "\n".join(wrong))
        self.assertGreater(len(refusals), 40)

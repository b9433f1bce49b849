"""Files that appear whole or not at all, signals, progress."""

import os
import pty
import re
import select
import signal
import subprocess
import time
import unittest
from pathlib import Path

from cli_test import CLI, CUBE, CliTest


class Files(CliTest):
    def test_several_outputs(self):
        self.run_cli("--random", "20", "-o", "a.txt", "--output", "b.npz", "--output=c.TXT", "-od.txt")
        self.assertEqual(self.files(), ["a.txt", "b.npz", "c.TXT", "d.txt"])
        self.assertEqual((self.folder / "a.txt").read_text(), (self.folder / "c.TXT").read_text())
        done = self.run_cli("--random", "20", "-o", "-", "-o", "e.txt", "-q")
        self.assertEqual(done.stdout, (self.folder / "e.txt").read_text())

    def test_replaces_whole_and_keeps_permissions(self):
        self.put("out.txt", "old\n" * 100000)
        (self.folder / "out.txt").chmod(0o640)
        self.run_cli("--random", "5", "-o", "out.txt")
        self.assertEqual(len((self.folder / "out.txt").read_text().splitlines()), 5)
        self.assertEqual((self.folder / "out.txt").stat().st_mode & 0o777, 0o640)
        umask = os.umask(0)
        os.umask(umask)
        self.run_cli("--random", "5", "-o", "new.txt")
        self.assertEqual((self.folder / "new.txt").stat().st_mode & 0o777, 0o666 & ~umask)
        (self.folder / "link.txt").symlink_to("out.txt")
        self.run_cli("--random", "6", "-o", "link.txt")
        self.assertTrue((self.folder / "link.txt").is_symlink())
        self.assertEqual(len((self.folder / "out.txt").read_text().splitlines()), 6)

    def test_links_to_files_that_are_still_to_be_made(self):
        """The link stays one, its target is made; relative to the folder of the link, and through a chain of links."""
        (self.folder / "there").mkdir()
        for name, target in [("a.txt", "real.txt"), ("b.npz", "there/b"), ("c.txt", "there/c1.txt"),
                             ("there/c1.txt", "../c2.txt"), ("d.vtu", str(self.folder / "there" / "d"))]:
            (self.folder / name).symlink_to(target)
        for name, target in [("a.txt", "real.txt"), ("b.npz", "there/b"), ("c.txt", "c2.txt"), ("d.vtu", "there/d")]:
            self.run_cli("--random", "6", "-o", name, "-q")
            self.assertTrue((self.folder / name).is_symlink(), name)
            self.assertTrue((self.folder / target).is_file() and not (self.folder / target).is_symlink(), target)
        self.assertEqual(len((self.folder / "c2.txt").read_text().splitlines()), 6)
        (self.folder / "e.txt").symlink_to("absent/e.txt")
        self.refuse("--random", "6", "-o", "e.txt", says=["'e.txt'", "no folder"])
        (self.folder / "f.txt").symlink_to("g.txt")
        self.refuse("--random", "6", "-o", "f.txt", "-o", "g.txt", says="twice")
        (self.folder / "g.txt").symlink_to("f.txt")
        self.refuse("--random", "6", "-o", "f.txt", says=["'f.txt'", "symbolic links"])

    def test_working_directory_that_is_gone(self):
        gone = self.folder / "gone"
        for arguments, code, says in [(["-o", "out.txt"], 2, "'out.txt' lies, for the working directory is gone"),
                                      (["-o", str(self.folder / "out.txt")], 0, ""), (["-o", "-"], 0, "")]:
            gone.mkdir()
            done = subprocess.run(["sh", "-c", 'rmdir "$PWD" && exec "$0" "$@"', CLI, "--random", "5", "-q", *arguments],
                                  cwd=gone, capture_output=True, text=True, timeout=300, check=False)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(says, done.stderr)
            self.assertNotIn("filesystem", done.stderr)
            self.assertLessEqual(done.stderr.count("\n"), code // 2)

    def test_bad_input_leaves_old_output_alone(self):
        self.put("out.txt", "old\n")
        self.put("a.txt", "1 2 3\n1 2\n")
        self.refuse("a.txt", "-o", "out.txt")
        self.put("a.txt", "1 2 3\n1 2 nan\n")
        self.refuse("a.txt", "-o", "out.txt")
        self.assertEqual((self.folder / "out.txt").read_text(), "old\n")

    def test_bad_outputs(self):
        self.put("a.txt", CUBE)
        (self.folder / "folder.txt").mkdir()
        self.refuse("a.txt", "-o", "absent/out.txt", says=["absent/out.txt", "no folder"])
        self.refuse("a.txt", "-o", "folder.txt", says=["folder.txt", "folder"])
        self.refuse("a.txt", "-o", "a.txt/out.txt", says="a.txt/out.txt")
        self.refuse("a.txt", "-o", "out.npz", "-o", "./out.npz", says="twice")
        self.refuse("a.txt", "-o", "a.txt", says=["a.txt", "is the input"])
        self.refuse("a.txt", "-o", "folder.txt/../a.txt", says="is the input")
        self.refuse("a.txt", "-o", "", says="''")
        self.assertEqual((self.folder / "a.txt").read_text(), CUBE)
        if os.geteuid() != 0:
            self.put("closed.txt", "old")
            (self.folder / "closed.txt").chmod(0o400)
            self.refuse("a.txt", "-o", "closed.txt", says=["closed.txt", "Permission"])

    def test_special_files(self):
        self.run_cli("--random", "20", "-o", "/dev/null")
        self.assertEqual(self.run_cli("--random", "20", "-q", "-o", "/dev/stdout").stdout.count("\n"), 20)
        self.assertTrue(Path("/dev/null").is_char_device())

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_full_disk(self):
        for extra in [[], ["-o", "out.npz"], ["--format", "%q"]]:
            message = self.refuse("--random", "50", *extra, "-o", "/dev/full", code=1)
            self.assertIn("/dev/full", message)
            self.assertIn("No space", message)
        (self.folder / "full.npz").symlink_to("/dev/full")
        self.refuse("--random", "50", "-o", "full.npz", code=1, says="No space")
        with open("/dev/full", "w") as full:
            for arguments in [["-o", "-"], ["--json"], []]:
                done = subprocess.run([CLI, "--random", "50", *arguments], stdout=full, stderr=subprocess.PIPE, text=True,
                                      check=False)
                self.assertEqual(done.returncode, 1)
                self.assertIn("clvotess: cannot write to stdout: No space", done.stderr.splitlines()[-1])

    def test_disk_that_fills_up(self):
        # A limit on the size of files stands in for a small disk; its signal is ignored, so that write() fails.
        def limit():
            import resource
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        for name in ["out.txt", "out.npz"]:
            done = self.run_cli("--random", "2000", "-o", name, code=1, preexec_fn=limit, restore_signals=False)
            self.assertRegex(done.stderr, rf"\Aclvotess: cannot write '{name}'[^\n]*\n\Z")
            self.assertEqual(self.files(), [])

    def test_reader_that_leaves(self):
        process = self.start("--random", "50000", "-q", "-o", "-", "-o", "out.txt", stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE)
        process.stdout.readline()
        process.stdout.close()
        message = process.stderr.read().decode()
        process.stderr.close()
        self.assertEqual((process.wait(60), message), (128 + signal.SIGPIPE, ""))  # as head leaves others
        self.assertEqual(self.files(), [])

    def test_closed_stdout_does_not_spoil_files(self):
        command = f'"{CLI}" --random 20 -o out.txt >&-'
        done = subprocess.run(["sh", "-c", command], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("stdout", done.stderr)
        for line in (self.folder / "out.txt").read_text().splitlines():
            self.assertRegex(line, r"\A[0-9 ]+\Z")

    def interrupt(self, process, ready):
        deadline = time.monotonic() + 60
        while not ready() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        self.addCleanup(process.kill)
        process.send_signal(signal.SIGINT)
        error = process.communicate(timeout=60)[1].decode()
        self.assertEqual(process.returncode, 130, error)
        self.assertRegex(error, r"\Aclvotess: [^\n]*\n\Z")

    def test_interrupt_while_tessellating(self):
        process = self.start("--random", self.count_lasting(20), "-t", "1", "-q", "-o", "out.npz", stderr=subprocess.PIPE)
        began = time.monotonic()
        self.interrupt(process, lambda: time.monotonic() - began > 1.5)
        self.assertLess(time.monotonic() - began, 10)
        self.assertEqual(self.files(), [])

    def test_interrupt_while_writing(self):
        os.mkfifo(self.folder / "pipe")  # without a reader: opening it waits
        process = self.start("--random", "1000", "-q", "-o", "out.txt", "-o", "pipe", stderr=subprocess.PIPE)
        self.interrupt(process, lambda: len(self.files()) > 1 and time.sleep(0.3) is None)
        self.assertEqual(self.files(), ["pipe"])

    def count_lasting(self, seconds):
        """How many points keep one thread busy for about this long."""
        return int(20000 * seconds / self.json("--random", "20000", "-t", "1")["seconds"]["total"])

    def progress_of(self, *arguments):
        """What a terminal on stderr is shown."""
        terminal, stderr = pty.openpty()
        process = self.start(*arguments, stdout=subprocess.DEVNULL, stderr=stderr)
        os.close(stderr)
        shown = b""
        while True:
            try:
                select.select([terminal], [], [], 60)
                piece = os.read(terminal, 65536)
            except OSError:  # the other end is closed
                break
            if not piece:
                break
            shown += piece
        os.close(terminal)
        self.assertEqual(process.wait(60), 0)
        return shown.decode()

    def test_progress(self):
        long = ["--random", self.count_lasting(4), "-t", "1", "--want", "volumes"]
        shown = self.progress_of(*long)
        self.assertRegex(shown, r"\r\[#*\.*\] +\d+ % \d+ s left\x1b\[K")
        percents = [int(text) for text in re.findall(r"(\d+) %", shown)]
        self.assertEqual(percents, sorted(percents))
        self.assertTrue(shown.endswith("\r\x1b[K"))
        self.assertEqual(self.progress_of("--random", "1000"), "")
        self.assertEqual(self.progress_of(*long, "-q"), "")
        self.assertEqual(self.run_cli(*long).stderr, "")

"""Files that appear whole or not at all, signals, progress."""

import contextlib
import errno
import os
import pty
import re
import select
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np

from cli_test import CLI, CUBE, SANITIZED, CliTest


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
        """A link stays a link, and its target is written: relative to the folder of the link, and through a chain."""
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
        for arguments, code, says in [(["-o", "out.txt"], 2, "'out.txt': the working directory was deleted"),
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
        # A limit on the size of files simulates a full disk. Its signal is ignored, so that write() fails.
        def limit():
            import resource
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        for name in ["out.txt", "out.npz", "case.foam"]:
            done = self.run_cli("--random", "2000", "-o", name, code=1, preexec_fn=limit, restore_signals=False)
            self.assertRegex(done.stderr, rf"\Aclvotess: cannot write '{name.replace('case.foam', '.*/constant/polyMesh/points')}'[^\n]*\n\Z")
            self.assertEqual(self.files(), [])

    def test_reader_that_leaves(self):
        process = self.start("--random", "50000", "-q", "-o", "-", "-o", "out.txt", stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE)
        process.stdout.readline()
        process.stdout.close()
        message = process.stderr.read().decode()
        process.stderr.close()
        self.assertEqual((process.wait(60), message), (128 + signal.SIGPIPE, ""))  # as after head
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
        os.mkfifo(self.folder / "pipe")  # without a reader, so opening it waits
        process = self.start("--random", "1000", "-q", "-o", "out.txt", "-o", "pipe", stderr=subprocess.PIPE)
        self.interrupt(process, lambda: self.open_files(process) and time.sleep(0.3) is None)
        self.assertEqual(self.files(), ["pipe"])

    def open_files(self, process):
        """Returns the number of files in the folder that the process has open, also without a name. A file counts once,
        also while it is open twice, as HDF5 opens it again."""
        files = set()
        for link in Path(f"/proc/{process.pid}/fd").glob("*"):
            with contextlib.suppress(OSError):
                if os.readlink(link).startswith(str(self.folder.resolve()) + "/"):
                    files.add(os.stat(link).st_ino)
        return len(files)

    def has_unnamed_files(self):
        with contextlib.suppress(OSError):
            os.close(os.open(self.folder, os.O_TMPFILE | os.O_RDWR))
            return True
        return False

    def test_killed(self):
        """SIGKILL leaves the folder unchanged, when all files except one are complete, and at random moments."""
        if not self.has_unnamed_files():
            self.skipTest("this file system has no unnamed files")
        names = ["out.txt", "out.npz", "out.glb"] + ([] if SANITIZED else ["out.h5"])
        outputs = [word for name in names for word in ("-o", name)]
        os.mkfifo(self.folder / "pipe")  # without a reader: opening it waits
        for old in [[], names]:
            for name in old:
                self.put(name, "old")
            process = self.start("--random", "300", "-q", *outputs, "-o", "pipe")
            deadline = time.monotonic() + 60
            while self.open_files(process) < len(names) and time.monotonic() < deadline:
                time.sleep(0.005)
            self.assertEqual(self.open_files(process), len(names))
            time.sleep(0.05)
            process.kill()
            process.wait()
            self.assertEqual(self.files(), sorted([*old, "pipe"]))
        for name in names:
            self.assertEqual((self.folder / name).read_text(), "old")
        began = time.monotonic()
        self.run_cli("--random", "2000", "-q", *outputs)
        lasts = time.monotonic() - began
        for share in np.random.default_rng(6).random(3 if SANITIZED else 8):
            for name in names:
                self.put(name, "old")
            process = self.start("--random", "2000", "-q", *outputs)
            time.sleep(share * lasts)
            process.kill()
            process.wait()
            self.assertEqual(self.files(), sorted([*names, "pipe"]))
            new = [(self.folder / name).stat().st_size > 3 for name in names]
            self.assertEqual(new, sorted(new, reverse=True))  # published in this order, each whole or old

    SHIM = r"""
        #define _GNU_SOURCE
        #include <dlfcn.h>
        #include <errno.h>
        #include <fcntl.h>
        #include <stdarg.h>
        #include <stdio.h>
        #include <stdlib.h>
        #include <string.h>
        #include <sys/stat.h>
        #include <unistd.h>
        static void note(const char* what) { dprintf(atoi(getenv("SHIM_LOG")), "%s\n", what); }
        static int fails(const char* call) {
            const char* const wish = getenv("SHIM_FAIL");
            const size_t length = strlen(call);
            if (!wish || strncmp(wish, call, length) != 0 || wish[length] != '=') return 0;
            errno = atoi(wish + length + 1);
            return 1;
        }
        int fsync(int descriptor) {
            struct stat what;
            fstat(descriptor, &what);
            const char* const call = S_ISDIR(what.st_mode) ? "sync folder" : "sync file";
            note(call);
            return fails(call) ? -1 : 0;
        }
        int linkat(int a, const char* from, int b, const char* to, int flags) {
            note(strstr(to, ".tmp") ? "link temporary" : "link target");
            return ((int (*)(int, const char*, int, const char*, int))dlsym(RTLD_NEXT, "linkat"))(a, from, b, to, flags);
        }
        int rename(const char* from, const char* to) {
            note("rename");
            return ((int (*)(const char*, const char*))dlsym(RTLD_NEXT, "rename"))(from, to);
        }
        int open(const char* path, int flags, ...) {
            va_list list;
            va_start(list, flags);
            const int mode = va_arg(list, int);
            va_end(list);
            if ((flags & O_TMPFILE) == O_TMPFILE && fails("unnamed")) return -1;
            return ((int (*)(const char*, int, ...))dlsym(RTLD_NEXT, "open"))(path, flags, mode);
        }
        """

    def test_power_loss(self):
        """The bytes are synced before the file gets its name, the name before the run ends."""
        compiler = shutil.which(os.environ.get("CC", "cc"))
        if SANITIZED or not compiler:
            self.skipTest("needs a C compiler and no sanitizer")
        build = tempfile.TemporaryDirectory()
        self.addCleanup(build.cleanup)
        source, library = Path(build.name) / "shim.c", Path(build.name) / "shim.so"
        source.write_text(self.SHIM)
        subprocess.run([compiler, "-w", "-shared", "-fPIC", str(source), "-o", str(library), "-ldl"], check=True)

        def run(fail="", name="out.txt", **options):
            reader, writer = os.pipe()
            done = self.run_cli("--random", "9", "-q", "-o", name, pass_fds=[writer], env=dict(
                os.environ, LD_PRELOAD=str(library), SHIM_LOG=str(writer), SHIM_FAIL=fail), **options)
            os.close(writer)
            with os.fdopen(reader) as log:
                return log.read().splitlines(), done.stderr

        end = ["sync folder"]
        named = ["sync file", "rename", *end]
        without = f"unnamed={errno.EOPNOTSUPP}"
        if self.has_unnamed_files():
            self.assertEqual(run()[0], ["sync file", "link target", *end])
            self.assertEqual(run()[0], ["sync file", "link target", "link temporary", "rename", *end])
        for name in ["out.txt", "out.h5", "out.npz"]:
            self.assertEqual(run(without, name)[0], named, name)
            self.assertEqual(run(without, name)[0], named, name)
        self.assertEqual(self.files(), ["out.h5", "out.npz", "out.txt"])
        for unknown in [errno.EINVAL, errno.EROFS]:
            run(f"sync file={unknown}")
            run(f"sync folder={unknown}")
        self.put("out.txt", "old")
        for fail in [f"sync file={errno.EIO}", f"sync file={errno.ENOSPC}"]:
            log, error = run(fail, code=1)
            self.assertEqual((log, (self.folder / "out.txt").read_text()), (["sync file"], "old"))
            self.assertRegex(error, r"\Aclvotess: cannot write 'out.txt': [^\n]+\n\Z")
        error = run(f"sync folder={errno.EIO}", code=1)[1]
        self.assertIn("'out.txt' is written, but its folder could not be synced", error)
        self.assertNotEqual((self.folder / "out.txt").read_text(), "old")
        self.assertEqual(self.files(), ["out.h5", "out.npz", "out.txt"])

    def count_lasting(self, seconds):
        """Returns a number of points that keeps one thread busy for about this time."""
        return int(20000 * seconds / self.json("--random", "20000", "-t", "1")["seconds"]["total"])

    def progress_of(self, *arguments):
        """Returns the output on stderr to a terminal."""
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

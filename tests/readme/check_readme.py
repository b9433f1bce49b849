"""Runs the examples of README.md or of pages of the documentation.

A fenced block runs if the line before it is <!-- tested -->. Blocks of a file run in order in one empty directory:
  sh        with the build's bin directory on PATH
  python    with pyvotess importable
  cpp, c    compiled as a whole program against the build
A line "# prints: text" or "// prints: text" in a block demands that the output contains the text.

Named files are pages, or notebooks, whose cells of code are all run. The python blocks of a page are one session.
<!-- tested, needs ase --> skips a block if the package is missing, unless --all. Every block must be tested, or have the
language text, or follow <!-- not run: reason -->. --keep DIR copies the pictures and .html of page.md to DIR/page, and
writes the output of its blocks, by line, to DIR/page/outputs.json.

Without pages, relative links in README.md and in other Markdown files outside the pages must name a file.
"""

import argparse
import importlib.util
import json
import os
import re
import select
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

FENCED = re.compile(r"^(?:<!-- ([^\n]*) -->\n)?```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
TESTED = re.compile(r"tested(?:, needs ([\w, ]+))?")
PRINTS = re.compile(r"^\s*(?:#|//) prints: (.*)$", re.MULTILINE)
LINK = re.compile(r"\]\((?!\w+:|#)([^)#]+)")
LANGUAGES = {"sh", "python", "cpp", "c"}
PICTURES = {".png", ".svg", ".jpg", ".html"}
TIMEOUT = 120

# Runs blocks in one namespace. A line of input has the code and the file for its output; the reply is 1 or 0.
SESSION = """
import json, os, sys, traceback
replies = os.fdopen(os.dup(1), "w")
names = {"__name__": "__main__"}
for line in iter(sys.stdin.readline, ""):
    code, path = json.loads(line)
    file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(file, 1)
    os.dup2(file, 2)
    os.close(file)
    passed = True
    try:
        exec(compile(code, "block", "exec"), names)
    except BaseException:
        traceback.print_exc()
        passed = False
    sys.stdout.flush()
    sys.stderr.flush()
    print(int(passed), file=replies, flush=True)
"""


class Block(NamedTuple):
    line: int
    mark: str  # the comment on the line before, "" when there is none
    language: str
    code: str


class Session:
    """A Python process that runs the blocks of a page in one namespace."""

    def __init__(self, directory, environment):
        self.output = directory.parent / f"{directory.name}.output"
        self.process = subprocess.Popen([sys.executable, "-c", SESSION], cwd=directory, env=environment, text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def run(self, code):
        """Returns whether the code raised no exception, and its output."""
        reply = ""
        try:
            print(json.dumps([code, str(self.output)]), file=self.process.stdin, flush=True)
            if select.select([self.process.stdout], [], [], TIMEOUT)[0]:
                reply = self.process.stdout.readline()
        except BrokenPipeError:
            pass
        output = self.output.read_text() if self.output.exists() else ""
        if not reply:
            self.process.kill()
            output += f"the session ended, or took more than {TIMEOUT} s\n"
        return reply.strip() == "1", output

    def close(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


def compile_command(language, source, program, args):
    includes = [f"-I{args.source / 'include'}", f"-I{args.build / 'include'}"]
    library = [f"-L{args.lib}", f"-Wl,-rpath,{args.lib}", "-lvotess"]
    compiler = [os.environ.get("CXX", "c++"), "-std=c++20"] if language == "cpp" else [os.environ.get("CC", "cc"), "-std=c11"]
    return [*compiler, "-Wall", "-Wextra", "-Werror", *includes, str(source), "-o", str(program), *library]


def commands(language, code, directory, args):
    """Returns the commands that run one block, each an argument list."""
    if language == "sh":
        return [["bash", "-euo", "pipefail", "-c", code]]
    if language == "python":
        return [[sys.executable, "-c", code]]
    source = directory / f"example.{language}"
    source.write_text(code)
    program = directory / "example"
    return [compile_command(language, source, program, args), [str(program)]]


def run(block, directory, environment, args):
    """Returns whether the commands of a block succeeded, and their output."""
    output = ""
    for command in commands(block.language, block.code, directory, args):
        done = subprocess.run(command, cwd=directory, env=environment, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=TIMEOUT, check=False)
        output += done.stdout
        if done.returncode != 0:
            return False, f"{output}exit code {done.returncode}\n"
    return True, output


def read(path):
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        codes = [("".join(cell["source"]), k) for k, cell in enumerate(cells) if cell["cell_type"] == "code"]
        return "", [Block(number, "tested", "python", code) for code, number in codes]
    blocks = [Block(text.count("\n", 0, m.start(3)) + 1, m[1] or "", m[2], m[3]) for m in FENCED.finditer(text)]
    return text, blocks


def complaints(text, blocks, is_page):
    """Yields the errors in the marks of a file."""
    tested = [block for block in blocks if TESTED.fullmatch(block.mark)]
    if len(tested) != len(re.findall("<!-- tested", text)):
        yield "every <!-- tested --> must be on the line before a fenced block"
    for block in tested:
        if block.language not in LANGUAGES:
            yield f"line {block.line}: {block.language!r} cannot be run, only {', '.join(sorted(LANGUAGES))}"
    if not is_page:
        if not {"sh", "python", "cpp"} <= {block.language for block in tested}:
            yield "each of cpp, python, sh must have a tested block"
        return
    if 2 * len(blocks) != len(re.findall(r"^\s*```", text, re.MULTILINE)):
        yield "a fence begins no block, or a block is indented"
    for paragraph in re.findall(r"(?:\A|\n\n)((?:    |\t).*)", FENCED.sub("", text)):
        yield f"a block without fences is not tested; add fences: {paragraph.strip()}"
    for block in blocks:
        if block not in tested and block.language != "text" and not block.mark.startswith("not run: "):
            yield f"line {block.line}: mark this block as tested or not run, or give it the language text"


def check(path, is_page, args, environment):
    """Runs the blocks of a file; returns the number of failures."""
    name = os.path.relpath(path, args.source)
    text, blocks = read(path)
    failures = 0
    for complaint in complaints(text, blocks, is_page) if text else ():
        print(f"{name}: {complaint}")
        failures += 1
    with tempfile.TemporaryDirectory() as folder:
        directory = Path(folder) / path.stem
        directory.mkdir()
        session = Session(directory, environment) if is_page else None
        outputs = {}
        for block in blocks:
            tested = TESTED.fullmatch(block.mark)
            if not tested or block.language not in LANGUAGES:
                if block.mark.startswith("not run: "):
                    print(f"{name}:{block.line}: {block.language}: {block.mark}")
                continue
            needs = re.findall(r"\w+", tested[1] or "")
            missing = [package for package in needs if importlib.util.find_spec(package) is None]
            if missing and not args.all:
                print(f"{name}:{block.line}: {block.language}: skipped, {' '.join(missing)} is missing")
                continue
            if session and block.language == "python":
                passed, output = session.run(block.code)
            else:
                passed, output = run(block, directory, environment, args)
            outputs[block.line] = output
            absent = [wanted for wanted in PRINTS.findall(block.code) if wanted not in output]
            print(f"{name}:{block.line}: {block.language}: {'ok' if passed and not absent else 'FAILED'}", flush=True)
            if not passed or absent:
                failures += 1
                print(output)
                for wanted in absent:
                    print(f"the output does not contain: {wanted}")
        if session:
            session.close()
        if args.keep:
            target = args.keep / path.stem
            target.mkdir(parents=True, exist_ok=True)
            (target / "outputs.json").write_text(json.dumps(outputs))
            for file in sorted(directory.iterdir()):
                if file.suffix in PICTURES:
                    shutil.copy(file, target)
    return failures


def dead_links(source):
    """Yields the links to missing files in Markdown files of the repository outside the pages."""
    trees = [tree for tree in source.iterdir() if tree.is_dir() and tree.name not in (".git", "build", "dist")]
    for file in sorted([*source.glob("*.md"), *(file for tree in trees for file in tree.rglob("*.md"))]):
        if "/docs/pages/" not in file.as_posix():
            for link in LINK.findall(file.read_text(encoding="utf-8")):
                if not file.parent.joinpath(link).exists():
                    yield f"{file.relative_to(source)}: there is no {link}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--source", type=Path, required=True, help="root of the repository")
    parser.add_argument("--build", type=Path, required=True, help="build tree")
    parser.add_argument("--bin", type=Path, required=True, help="directory of clvotess")
    parser.add_argument("--lib", type=Path, required=True, help="directory of libvotess")
    parser.add_argument("--all", action="store_true", help="run blocks even if their packages are missing")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="folder for pictures and outputs")
    parser.add_argument("pages", type=Path, nargs="*", help="Markdown files; default: README.md")
    args = parser.parse_args()

    for name in ("source", "build", "bin", "lib"):
        setattr(args, name, getattr(args, name).resolve())
    environment = dict(os.environ, PATH=f"{args.bin}{os.pathsep}{os.environ['PATH']}", MPLBACKEND="agg")
    failures = sum(check(page, True, args, environment) for page in map(Path.resolve, args.pages))
    if not args.pages:
        failures += check(args.source / "README.md", False, args, environment)
        dead = list(dead_links(args.source))
        print("".join(f"{line}\n" for line in dead), end="")
        failures += len(dead)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

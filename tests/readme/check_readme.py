"""Runs the examples of README.md, so that what it promises stays true.

A fenced block counts when the line before it is <!-- tested -->. Blocks run in order in one empty directory: sh with
the build's bin directory on PATH, python with pyvotess importable, cpp and c compiled as whole programs against the
build and run. A line "# prints: text" or "// prints: text" in a block demands that the output contains the text.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

BLOCK = re.compile(r"^<!-- tested -->\n```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PRINTS = re.compile(r"^\s*(?:#|//) prints: (.*)$", re.MULTILINE)
LANGUAGES = {"sh", "python", "cpp", "c"}


def compile_command(language, source, program, args):
    includes = [f"-I{args.source / 'include'}", f"-I{args.build / 'include'}"]
    library = [f"-L{args.lib}", f"-Wl,-rpath,{args.lib}", "-lvotess"]
    compiler = [os.environ.get("CXX", "c++"), "-std=c++20"] if language == "cpp" else [os.environ.get("CC", "cc"), "-std=c11"]
    return [*compiler, "-Wall", "-Wextra", "-Werror", *includes, str(source), "-o", str(program), *library]


def commands(language, code, directory, args):
    """The commands that run one block, each an argument list."""
    if language == "sh":
        return [["bash", "-euo", "pipefail", "-c", code]]
    if language == "python":
        return [[sys.executable, "-c", code]]
    source = directory / f"example.{language}"
    source.write_text(code)
    program = directory / "example"
    return [compile_command(language, source, program, args), [str(program)]]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--source", type=Path, required=True, help="root of the repository")
    parser.add_argument("--build", type=Path, required=True, help="build tree")
    parser.add_argument("--bin", type=Path, required=True, help="directory of clvotess")
    parser.add_argument("--lib", type=Path, required=True, help="directory of libvotess")
    args = parser.parse_args()

    text = (args.source / "README.md").read_text()
    blocks = [(text.count("\n", 0, m.start(2)) + 1, m[1], m[2]) for m in BLOCK.finditer(text)]
    environment = dict(os.environ, PATH=f"{args.bin}{os.pathsep}{os.environ['PATH']}")
    failures = 0
    if len(blocks) != text.count("<!-- tested -->") or {language for _, language, _ in blocks} != LANGUAGES:
        print("README.md: every <!-- tested --> must stand on the line before a fenced block, and each of",
              ", ".join(sorted(LANGUAGES)), "must have one")
        failures += 1

    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        for line, language, code in blocks:
            output = ""
            code_ok = True
            for command in commands(language, code, directory, args):
                done = subprocess.run(command, cwd=directory, env=environment, text=True, stdout=subprocess.PIPE,
                                      stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=120, check=False)
                output += done.stdout
                if done.returncode != 0:
                    code_ok = False
                    output += f"exit code {done.returncode}\n"
                    break
            absent = [wanted for wanted in PRINTS.findall(code) if wanted not in output]
            print(f"README.md:{line}: {language}: {'ok' if code_ok and not absent else 'FAILED'}")
            if not code_ok or absent:
                failures += 1
                print(output)
                for wanted in absent:
                    print(f"the output does not contain: {wanted}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

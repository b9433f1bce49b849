#!/usr/bin/env python3
"""Makes a folder from which GCC links for an older Linux than this one: g++ -B FOLDER.

old_linux.py FOLDER g++ x86_64                          needs readelf and the ziglang package
old_linux.py FOLDER aarch64-linux-gnu-g++ aarch64

Start files and stubs of glibc 2.28 come from zig. Stubs of libstdc++ and libgcc_s hold the symbols that these libraries
had in 2018, as manylinux_2_28 demands (PEP 600). What is newer in libstdc++ is linked statically, so a C++ program and
libvotess still share one libstdc++ at run time, as exceptions and std::string demand.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

GLIBC = "2.28"
# The newest versions of symbols that manylinux_2_28 allows.
NEWEST = {"GLIBCXX": "3.4.24", "CXXABI": "1.3.11", "GCC": "7.0.0"}
# Functions that headers of a newer glibc call. A clock of a condition variable is that of its deadline.
NEWER = r"""
#include <pthread.h>
#include <time.h>
__attribute__((visibility("hidden"))) char __libc_single_threaded = 0;
__attribute__((visibility("hidden"))) int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                                                                 clockid_t clock, const struct timespec* deadline) {
    struct timespec now, at;
    clock_gettime(clock, &now);
    clock_gettime(CLOCK_REALTIME, &at);
    at.tv_sec += deadline->tv_sec - now.tv_sec;
    at.tv_nsec += deadline->tv_nsec - now.tv_nsec;
    if (at.tv_nsec < 0) at.tv_nsec += 1000000000, --at.tv_sec;
    if (at.tv_nsec >= 1000000000) at.tv_nsec -= 1000000000, ++at.tv_sec;
    return pthread_cond_timedwait(condition, mutex, &at);
}
"""


def output(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True).stdout


def number(version):
    return [int(part) for part in version.split(".")]


def old_symbols(library):
    """Returns the newest allowed version of each symbol, with its type and size."""
    symbols = {}
    for line in output("readelf", "--dyn-syms", "--wide", library).splitlines():
        match = re.search(r"\s(\d+|0x[0-9a-f]+) (\w+) +\w+ +\w+ +\w+ (\S+?)@@?([A-Z]+)_([\d.]+)$", line)
        if not match or " UND " in line:
            continue
        size, kind, name, family, version = match.groups()
        if family not in NEWEST or number(version) > number(NEWEST[family]):
            continue
        if name not in symbols or number(version) > number(symbols[name][1]):
            symbols[name] = (family, version, kind, int(size, 0))
    return symbols


def write_stub(library, folder, compiler):
    symbols = old_symbols(library)
    assembly = ['.section .note.GNU-stack,"",%progbits']
    sections = {"OBJECT": (".data", "object"), "TLS": ('.section .tdata,"awT",%progbits', "tls_object")}
    for place, (name, (family, version, kind, size)) in enumerate(sorted(symbols.items())):
        section, form = sections.get(kind, (".text", "function"))
        assembly += [section, f".globl stub_{place}", f".type stub_{place}, %{form}", f"stub_{place}: .skip {max(size, 1)}",
                     f".size stub_{place}, {size}", f".symver stub_{place}, {name}@@{family}_{version}"]
    nodes = sorted({symbol[:2] for symbol in symbols.values()}, key=lambda node: (node[0], number(node[1])))
    script = "".join(f"{family}_{version} {{ {'' if k else 'local: stub_*;'} }};\n" for k, (family, version) in enumerate(nodes))
    source, versions = folder / "stub.s", folder / "stub.map"
    source.write_text("\n".join(assembly) + "\n")
    versions.write_text(script)
    soname = re.search(r"SONAME.*\[(.*)\]", output("readelf", "--dynamic", library))[1]
    output(compiler, "-shared", "-nostdlib", str(source), f"-Wl,--version-script={versions},-soname,{soname}",
           "-o", str(folder / soname))
    source.unlink()
    versions.unlink()
    return soname


def main():
    folder, compiler, machine = Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3]
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    program = folder / "newer.c"
    program.write_text("int main(void) { return 0; }\n")
    # The linker's command line names all files.
    command = output(sys.executable, "-m", "ziglang", "cc", "-target", f"{machine}-linux-gnu.{GLIBC}", "-pie", "-v",
                     "-o", str(folder / "program"), str(program))
    for name in ("Scrt1.o", "libc_nonshared.a", "libld.so.2", "libc.so.6"):
        source = Path(re.search(rf"\S+/{re.escape(name)}", command)[0])
        shutil.copy(source, folder)
    shutil.copy(folder / "Scrt1.o", folder / "crt1.o")
    for name in ("libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1"):
        shutil.copy(source.parent / name, folder)
        (folder / (name.split(".")[0] + ".so")).symlink_to(name)
    program.write_text(NEWER)
    output(compiler, "-O2", "-fPIC", "-c", str(program), "-o", str(folder / "newer.o"))
    libc = ["libc.so.6", "libld.so.2", "newer.o", "libc_nonshared.a"]
    (folder / "libc.so").write_text(f"GROUP({' '.join(str(folder / name) for name in libc)})\n")

    def of_compiler(name):
        return output(compiler, f"-print-file-name={name}").strip()

    gcc = write_stub(of_compiler("libgcc_s.so.1"), folder, compiler)
    # ARM's atomics are functions of the static part. Code of libstdc++.a calls them.
    (folder / "libgcc_s.so").write_text(f"GROUP({folder}/{gcc} -lgcc)\n")
    cxx = write_stub(of_compiler("libstdc++.so.6"), folder, compiler)
    (folder / "libstdc++.so").write_text(f"INPUT({folder}/{cxx} {of_compiler('libstdc++.a')})\n")


main()

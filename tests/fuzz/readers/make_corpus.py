#!/usr/bin/env python3
"""Writes the corpus of the reader targets: small valid files of every kind, and files that once failed.

    make_corpus.py [FOLDER]      default: corpus/ beside this file

Needs NumPy and h5py. The files are kept in the repository, so that tests need neither.
"""
import gzip
import io
import json
import pathlib
import struct
import sys
import tempfile
import zipfile

import h5py
import numpy as np

POINTS = np.random.default_rng(1).random((6, 3)).round(3)
ROWS = [" ".join(map(str, row)) for row in POINTS]
FOLDER = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent / "corpus")


def put(reader, name, content):
    folder = FOLDER / reader
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


def rows(form):
    return "".join(form.format(i=i + 1, row=row, r=round(0.1 * i, 1)) + "\n" for i, row in enumerate(ROWS))


def number():
    for name, text in {"plain": "-12.5e-3", "denormal": "4.9406564584124654e-324", "largest": "1.7976931348623157e308",
                       "zeros": "0." + "0" * 400 + "1", "far": "0." + "0" * 400 + "1e401", "huge": "1" + "0" * 400,
                       "exponent": "1e-99999999999999999999", "tie": "9007199254740993", "nan": "-nan",
                       "long": "0.3" + "0123456789" * 30 + "e5"}.items():
        put("number", name, text)


def text():
    put("text", "rows", "# six points\n" + rows("{row}"))
    put("text", "ids", rows("{i} {row} # {r}"))
    put("text", "radii", rows("{row} {r}"))
    put("text", "commas", rows("{row}").replace(" ", ", "))
    put("text", "decimal_comma", "0,5 0 1\n1 2 3\n")
    put("text", "line_ends", "\n" * 300 + "\r\n \n" + rows("{row}"))
    put("csv", "names", "id,z,y,my r,x\n" + rows("{i},{row},{r}").replace(" ", ","))
    put("csv", "semicolons", '"x";"y";"z";"name"\n' + rows("{row} a{i}").replace(" ", ";"))
    put("csv", "decimal_comma", "x;y;z\n" + rows("{row}").replace(" ", ";").replace(".", ","))
    put("gz", "rows", gzip.compress(rows("{row}").encode(), mtime=0))
    put("gz", "members", gzip.compress(b"1 2 3\n", mtime=0) + gzip.compress(b"", mtime=0) + gzip.compress(b"4 5 6\n", mtime=0))
    put("gz", "line_ends", gzip.compress(b"\n" * 20000, mtime=0))


def atoms():
    put("xyz", "classic", "6\n\n" + rows("H {row}") + "6\nsecond\n" + rows("O {row}"))
    put("xyz", "extended", '6\nLattice="1 0 0 0 1 0 0.2 0 1" Properties=species:S:1:pos:R:3:id:I:1:v:R:2 '
        'pbc="T F T" Origin="0 0 0"\n' + rows("H {row} {i} {r} 2"))
    put("xyz", "wide", "1\nProperties=" + "a:R:1000:" * 50 + "pos:R:3\nH 1 2 3\n")
    put("poscar", "direct", "H2 O\n1.0\n1 0 0\n0 1 0\n0.2 0 1\nH O\n4 2\nSelective dynamics\nDirect\n" + rows("{row} T T F"))
    put("poscar", "cartesian", "x\n-8.0\n2 0 0\n0 2 0\n0 0 2\n6\nCartesian\n" + rows("{row}"))
    put("poscar", "wraps", "x\n1\n1 0 0\n0 1 0\n0 0 1\n" + "1099511627776 " * 200 + "\nDirect\n0 0 0\n")
    put("poscar", "cif", "data_quartz\n_cell_length_a 4.9\nloop_\n_atom_site_label\nSi\n")
    tess = "***tess\n **format\n   3.4\n **general\n   3 standard\n **cell\n  6\n  *id\n   1 2 3\n   4 5 9\n  *seed\n" + rows(
        "   {i} {row} {r}") + " **vertex\n 1\n   1 0 0 0 0\n **domain\n  *general\n   {}\n  *vertex\n   2\n   1 0 0 0 x0y0z0\n" \
        "      1 1\n   2 1 2 1 x1y1z1\n      1 1\n  *face\n   1\n   1 3 1 2 1\n     3 1 1 1\n     {}\n     4 0 1 0 0\n     x0\n" \
        "     2 1 1\n **periodicity\n  *general\n   1 0 1\n   1 2 1\n***end\n"
    put("tess", "cube", tess.replace("{}", "cube", 1).replace("{}", "plane"))
    put("tess", "poly", tess.replace("{}", "poly", 1).replace("{}", "plane"))
    put("tess", "counts", "***tess **general 3 standard **cell 99999999 *seed 1 0 0 0 0\n")
    box = "ITEM: BOX BOUNDS {}\n0 1{}\n0 1{}\n0 1{}\n"
    frame = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n6\n{}ITEM: ATOMS {}\n{}"
    put("lammps_dump", "flags", "ITEM: UNITS\nmetal\n" + frame.format(0, box.format("pp pp ff", "", "", ""), "id type x y z radius",
                                                                       rows("{i} 1 {row} {r}")) +
        frame.format(10, box.format("pp ff ff", "", "", ""), "x y z id", rows("{row} {i}")))
    put("lammps_dump", "tilted", frame.format(5, box.format("xy xz yz pp pp pp", " 0.1", " 0", " -0.1"), "id xs ys zs element",
                                              rows("{i} {row} H")))
    put("lammps_dump", "no_flags", frame.format(5, box.format("", "", "", ""), "id xu yu zu", rows("{i} {row}")))
    general = "ITEM: BOX BOUNDS abc origin pp pp ff\n0.6 0.8 0 0\n-0.8 0.6 0 0\n0 0 1 -2\n"
    put("lammps_dump", "general", frame.format(5, general, "id xs ys zs", rows("{i} {row}")))
    head = "by hand, units = metal\n\n6 atoms\n1 atom types\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n{}\nMasses\n\n1 1.0\n\nAtoms{}\n\n{}"
    put("lammps_data", "full", head.format("0.1 0 -0.1 xy xz yz\n", " # full", rows("{i} 1 1 {r} {row} 0 0 -1")))
    put("lammps_data", "sphere", head.format("", " # sphere", rows("{i} 1 {r} 1.5 {row}")))
    put("lammps_data", "any_words", head.format("", " # made by hand", rows("{i} 1 {row}")))
    put("lammps_data", "general", "by hand\n\n6 atoms\n1 0 0.1 avec\n0 1 0 bvec\n-0.1 0 1 cvec\n0 0 -2 abc origin\n\nAtoms\n\n"
        + rows("{i} 1 {row}"))
    put("lammps_data", "names", head.format("", "", "# id type q x y z\n" + rows("{i} 1 {r} {row}")))


def ply():
    head = "ply\nformat {} 1.0\ncomment c\nelement other 2\nproperty list uchar int l\nelement vertex 6\nproperty double x\n" \
           "property float r\nproperty double y\nproperty double z\nproperty int id\nend_header\n"
    put("ply", "ascii", head.format("ascii") + "2 1 2\n0\n" + rows("{row} {i}").replace(" ", " 0.5 ", 1))
    for name, order in [("binary_little_endian", "<"), ("binary_big_endian", ">")]:
        content = struct.pack(order + "BiiB", 2, 1, 2, 0)
        content += b"".join(struct.pack(order + "dfddi", p[0], 0.5, p[1], p[2], i) for i, p in enumerate(POINTS))
        put("ply", name, head.format(name).encode() + content)


def meshes():
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    plain = "".join("{} {} {}\n".format(*x) for x in corners)
    put("off", "plain", "OFF # c\n4 4 6\n" + plain + "".join("3 {} {} {}\n".format(*f) for f in faces))
    put("off", "colors", "COFF\n\n4 1 0\n" + plain.replace("\n", " 255 0 0 1\n") + "4 0 1 2 3 0.5 0.5 0.5\n")
    put("obj", "plain", "# c\ng a\n" + "".join("v {} {} {}\n".format(*x) for x in corners) + "vn 0 0 1\nf 1/1/1 3//1 2\nf -4 -3 -1\n")
    loops = "".join("facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*corners[v]) for v in f) +
                    "endloop\nendfacet\n" for f in faces)
    put("stl", "text", "solid a b\n" + loops + "endsolid a b\nsolid\nendsolid\n")
    put("stl", "binary", b"solid".ljust(80, b"\0") + struct.pack("<I", 4) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for v in f for x in corners[v]), 0) for f in faces))
    data = b"".join(struct.pack("<3f", *x) for x in corners) + struct.pack("<12B", *(v for f in faces for v in f))
    text = json.dumps({
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "scale": [1, 2, 3], "children": [1]}, {"rotation": [0, 0, 0, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}], "buffers": [{"byteLength": len(data)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}]}).encode()
    put("glb", "plain", struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(data), len(text), b"JSON") + text +
        struct.pack("<I4s", len(data), b"BIN\0") + data)
    head = "ply\nformat {} 1.0\nelement face 4\nproperty uchar red\nproperty list uchar int vertex_indices\nelement vertex 4\n" \
           "property double x\nproperty double y\nproperty double z\nend_header\n"
    put("ply_mesh", "ascii", head.format("ascii") + "".join("9 3 {} {} {}\n".format(*f) for f in faces) + plain)
    for name, order in [("binary_little_endian", "<"), ("binary_big_endian", ">")]:
        put("ply_mesh", name, head.format(name).encode() + b"".join(struct.pack(order + "BB3i", 9, 3, *f) for f in faces) +
            b"".join(struct.pack(order + "3d", *x) for x in corners))


def npy_of(array):
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def arrays():
    put("npy", "float64", npy_of(POINTS))
    put("npy", "float32", npy_of(POINTS.astype("f4")))
    put("npy", "columns", npy_of(np.asfortranarray(POINTS)))
    put("npy", "shape", npy_of(POINTS).replace(b"(6, 3)", b"(9999999999999999999, 3)"))
    for save in [np.savez, np.savez_compressed]:
        file = io.BytesIO()
        save(file, points=POINTS, ids=np.arange(6), r=POINTS[:, 0], v=POINTS, box=np.array([[0, 0, 0], [1, 1, 1.0]]),
             periodic=np.array([1, 0, 1], "u1"))
        put("npz", save.__name__, file.getvalue())
    file = io.BytesIO()
    np.savez(file, x=POINTS[:, 0], y=POINTS[:, 1].astype("f4"), z=POINTS[:, 2])
    put("npz", "axes", file.getvalue())
    # Two names for one member.
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", npy_of(np.zeros((200, 3))))
        again = zipfile.ZipInfo("b.npy")
        for key in ["header_offset", "CRC", "compress_size", "file_size", "compress_type"]:
            setattr(again, key, getattr(archive.infolist()[0], key))
        archive.filelist.append(again)
        archive.NameToInfo["b.npy"] = again
    put("npz", "overlapping", file.getvalue())


def hdf5():
    def save(name, fill, **options):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.h5"
            with h5py.File(path, "w", **options) as file:
                fill(file)
            put("hdf5", name, path.read_bytes())

    def own(file):
        file["points"], file["ids"], file["r"] = POINTS, np.arange(6), POINTS[:, 0]
        file.attrs.update(box=np.array([[0, 0, 0], [1, 1, 1.0]]), periodic=np.array([1, 0, 1], "u1"))

    def snapshot(file):
        header = file.create_group("Header")
        header.attrs.update(BoxSize=1.0, NumPart_ThisFile=[6, 0], NumPart_Total=[6, 0], NumFilesPerSnapshot=1, Time=0.5)
        group = file.create_group("PartType0")
        group.create_dataset("Coordinates", data=POINTS, compression="gzip", chunks=(4, 3))
        group["ParticleIDs"] = np.arange(6, dtype="u8")
        group["Masses"] = np.ones(6, "f4")

    def nested(file):
        group = file
        for _ in range(70):
            group = group.create_group("g")
        group["points"] = POINTS

    def h5md(file):
        atoms = file.create_group("particles/all")
        atoms["position/value"] = np.stack([POINTS, POINTS + 0.01])
        atoms["position/step"] = [0, 5]
        atoms["velocity/value"] = np.stack([POINTS, POINTS])
        atoms["id/value"] = np.tile(np.arange(6), (2, 1))
        atoms["mass"] = np.ones(6)
        box = atoms.create_group("box")
        box.attrs["boundary"] = ["periodic", "none", "periodic"]
        box["edges/value"] = np.tile(np.eye(3), (2, 1, 1))

    def mdtraj(file):
        file["coordinates"] = np.stack([POINTS, POINTS]).astype("f4")
        file["cell_lengths"], file["cell_angles"] = np.ones((2, 3), "f4"), np.tile(np.float32([90, 90, 60]), (2, 1))

    def ring(file):
        file["a/points"] = POINTS
        file["a/again"] = file["/"]

    save("own", own)
    save("snapshot", snapshot)
    save("newest", snapshot, libver="latest")
    save("nested", nested, libver="latest")
    save("ring", ring)
    save("h5md", h5md)
    save("mdtraj", mdtraj)


for make in [number, text, atoms, ply, meshes, arrays, hdf5]:
    make()

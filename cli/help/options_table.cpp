#include "help/options_table.hpp"

namespace clvotess {

// Lines of at most 75 characters, so that the text stands beside the names in 100 columns.
const std::vector<HelpSection>& help_sections() {
    static const std::vector<HelpSection> sections{
        {"input",
         {
             {"INPUT", "points: text, .xyz, .npy, .npz, .h5, .ply, LAMMPS, POSCAR; - is stdin",
              R"(.xyz .txt .dat .csv  text rows `x y z` or `id x y z`, separated by blanks,
                tabs, commas or semicolons; # begins a comment; ids are
                whole numbers. A .csv may begin with a line of names that
                says where x, y, z and id are; an .xyz may be frames of a
                count, a comment and rows `Element x y z`, also extended:
                the comment says Properties=, Lattice=, Origin= and pbc=
.extxyz         the same as .xyz
.npy .npz       NumPy arrays (N, 3), float64 or float32; in .npz the array
                `points`, the only one that fits, or x, y and z; ids
.h5 .hdf5       a dataset (N, 3) of floats. Snapshots of Gadget and AREPO
                in several files by NAME.0.hdf5 or NAME; ParticleIDs, ids
.dump .lammpstrj  LAMMPS dump in text, also called dump.NAME
.data .lmp      LAMMPS data file, its section Atoms; also data.NAME. The
                atom style (`Atoms # full`) or a line of names says where
                the columns are, or in common styles their number; other
                words behind the # are a comment
POSCAR CONTCAR .vasp  of VASP
.ply            element vertex: x y z, id
NAME, -         text without an extension; on stdin
Any text also packed: .xyz.gz, .dump.gz, ...)"},
             {"--dataset NAME", "", R"(which dataset of .h5 or array of .npz; default the only one that fits)"},
             {"--frame N", "", R"(which frame of a LAMMPS dump or .xyz, from 0; default the first)"},
             {"--random N", "N uniform points in the unit box instead of INPUT",
              R"(N uniform points in the box 0..1, such as 100000 or 1e6 (domain: that box,
unless --box is given))"},
             {"--rng-seed S", "", R"(which random points; default 1, the same points on every machine)"},
         }},
        {"domain",
         {
             {"--box x0,y0,z0,x1,y1,z1", "the domain; default: around the points, or what the file states",
              R"(default: bounds of the points, each side moved out by half of
(longest side / cbrt(N)); a point outside a given box is an error)"},
             {"--periodic [xyz|none]", "axes along which the domain repeats; alone: all three",
              R"(the box repeats along these axes; alone: along all three. Points beyond it
are wrapped into it. It needs a box, by --box, --cell or the file)"},
             {"--cell ax,ay,az,bx,by,bz,cx,cy,cz", "a triclinic box, periodic along its edges",
              R"(a triclinic box instead of --box, periodic along its edges a, b and c, or
along those that --periodic names as x, y and z; across the others it
ends at the planes of its faces, walls -1 to -6)"},
             {"--origin x,y,z", "",
              R"(the corner of --cell; default 0,0,0
Unless --box or --cell is given, a file that states its domain gives it:
LAMMPS, extended XYZ, POSCAR, BoxSize of a snapshot, .npz and .h5 of
clvotess. Axes that the file does not state are assumed periodic for
LAMMPS without boundary flags, POSCAR and XYZ without pbc, and not for
snapshots. --periodic then says which axes of that box repeat)"},
             {"--wall nx,ny,nz,d", "",
              R"(keep where nx x + ny y + nz z <= d; repeatable: a convex polyhedron, whose
walls are -7, -8, ...)"},
             {"--wall-sphere x,y,z,r,FACES", "", R"()"},
             {"--wall-cylinder x,y,z,ax,ay,az,r,FACES", "", R"()"},
             {"--wall-cone x,y,z,ax,ay,az,ANGLE,FACES", "",
              R"(as many walls as FACES that touch a sphere, a cylinder without ends or a
cone (apex, axis into it, radians from axis to surface) from outside:
its volume grows by some 3 / FACES, else by some 3 / FACES^2. After --wall)"},
             {"--outside error|drop", "",
              R"(a point outside of --box or a --wall is an error (default), or dropped: it
gets an empty cell)"},
             {"--min-face A", "", R"(drop faces smaller than A times the mean face area of the run; default 0)"},
             {"--min-area A", "", R"(the same for faces below the area A)"},
             {"--weights COL", "", R"(power diagram with a column of the input as weights ...)"},
             {"--radii COL", "power diagram: a column of the input holds radii (--weights: their squares)",
              R"(... or as radii, whose squares are the weights. COL is a name (.csv with a
line of names, LAMMPS, .ply, PointData, an array or dataset of N numbers;
of atom style sphere also `radius`) or the number of a column from 1)"},
             {"--copy COLS", "",
              R"(columns of the input that go into the output, with commas between them, or
all that hold numbers: in text at the end of the row, else as arrays)"},
             {"--density COL", "", R"(the array `density`: COL divided by the volume. A duplicate adds its number
to the point that keeps the cell; where there is no cell, density is nan)"},
             {"--duplicates merge|error", "",
              R"(points of equal coordinates: the first keeps the cell, the others get an
empty one (merge, the default), or the input is refused (error))"},
         }},
        {"output",
         {
             {"-o, --output FILE", ".txt .npz .h5 .vtu .ply .obj .glb, or - for text on stdout; repeatable",
              R"(.txt   one row per point, in the order of the input, see --format
.npz   NumPy arrays: indptr, indices (row i of the neighbor lists is
       indices[indptr[i]:indptr[i+1]]), shifts in periodic domains, what
       --want names, status, duplicate_of when there are duplicates, ids,
       the domain (box, periodic, cell, origin, walls) and its source
       (domain_from, periodic_from: option, stated, assumed, default),
       units that the file states, version
.h5    HDF5: the same (also .hdf5), the domain and units as attributes
.vtu   the cells as polyhedra for ParaView, PyVista and meshio, with id,
       volume, neighbors, centroid and status; without empty cells,
       ascending by their number of vertices: id says which is which
.ply   the faces, each once, with its two cells (rows from 0, walls < 0)
.obj   the faces, each once
.glb   glTF: the cells as solids in flat colors by --color, for Blender
       and browsers, about 830 bytes a cell, 4 GiB at most; the
       attribute _CELL is the row of the input
-      text on stdout
Repeatable. A file is written whole or not at all. A device or a pipe
without an extension, such as /dev/null, gets text.)"},
             {"--format FMT", "rows of text with the codes of Voro++, such as \"%i %q %v %n\"",
              R"(text row, with the codes of Voro++; default "%i %n"
  %i  id: that of the input, else the index from 0
  %x %y %z  coordinates of the input  %q  the three: "x y z"
  %r  radius, of --radii; without it 0.5, as Voro++ prints
  %w  number of vertices        %o  number of edges at each vertex
  %p  vertices relative to the point "(x,y,z) ..."    %P  absolute
  %m  largest squared distance of a vertex from the point
  %g  number of edges           %E  sum of their lengths
  %s  number of faces, walls included
  %n  neighbors of the faces, ids ascending, walls first; in this order:
  %f  areas     %e  perimeters  %a  numbers of edges  %l  outward normals
  %t  vertices of each face "(0,3,1) ...", numbers into %p, clockwise
      seen from outside
  %A  how many faces have 0, 1, 2, ... edges
  %F  area of the surface       %v  volume
  %c  centroid relative to the point "x y z"          %C  absolute
  (a point beyond a periodic box counts where it lies inside)
  %%  a percent sign
Numbers have the fewest digits that read back as the same float64.)"},
             {"--want LIST", "which arrays: neighbors,volumes (default),centroids,face_areas,faces, ...",
              R"(names of arrays, such as face_areas,security_radii, or groups of them:
neighbors (indptr, indices, shifts), volumes, centroids, counts (of faces,
edges, vertices), areas (face_areas), normals (face_normals), surfaces
(surface_areas), radii (security_radii), vertices (vertices,
cell_vertex_*), faces (face_offsets, face_vertices). An array brings its
group. Default neighbors,volumes; an output that needs more adds it.
Polygons (faces, %a %A %e %E %o %t, .vtu, .ply, .obj) add --list-walls)"},
             {"--list-walls", "",
              R"(list the walls of the box too, as neighbors -1 to -6 = xmin, xmax, ymin,
ymax, zmin, zmax)"},
             {"--json", "", R"(the summary as one JSON object on stdout)"},
             {"-q, --quiet", "", R"(no summary, no progress bar)"},
         }},
        {"picture",
         {
             {"--image FILE.png", "a picture of the cells, cut open; --slice z=0.5 for a section",
              R"(the cells, cut open, drawn by the CPU. Cells at the walls that dwarf
the others are left out, with their neighbors)"},
             {"--slice x=VALUE", "", R"(a plane section instead, with axes; y=VALUE or z=VALUE too)"},
             {"--color COLUMN", "",
              R"(volume (default), neighbors, area, x, y, z, index or a column of --copy or
--density; on a logarithmic scale where values differ widely)"},
             {"--colormap tide|ember|gray", "", R"(of the picture, and of .glb)"},
             {"--cut corner|half|cells|none", "",
              R"(what is taken away: the octant in front (corner, the default), the half in
front, or the whole cells whose points lie in that octant)"},
             {"--view AZIMUTH,ELEVATION", "", R"(where the camera stands, in degrees; default 36,27)"},
             {"--seeds", "", R"(with --slice: the points near the plane as dots)"},
             {"--image-size WxH", "", R"(pixels; default 1600x1200)"},
         }},
        {"queries",
         {
             {"--locate QUERIES", "",
              R"(no cells: the seed in whose cell each point of the file QUERIES lies, by
its index in the input from 0; exactly, of several that meet there the
lowest; -1 outside of the domain. Into -o FILE.npy (int32), FILE.txt or -
(a line each). In a periodic domain queries are wrapped)"},
             {"--probe QUERIES", "",
              R"(the cell that each point of the file QUERIES would have if it alone were
added to the points: a row or polyhedron each, by --want, --list-walls and
--format, into text, .npz, .h5 or .vtu. Neighbors are points by their index
in the input from 0; their number is the query itself. Status 7: outside
of the domain; 5: at the place of a point, which duplicate_of names; 6:
heavier points leave no cell. With --weights or --radii the column of that
name or number is taken out of QUERIES too, 0 where it has none)"},
             {"--interpolate QUERIES", "",
              R"(the field of --values at each point of the file QUERIES, from its natural
neighbors among the points, into -o FILE.npy (float64), FILE.txt or - (a
line each); nan where it has none, such as outside of the domain. Linear
fields come back where the cell of a query has no wall; cells end at walls,
as if the points had mirror images behind. Weights and radii as for --probe)"},
             {"--values COLUMN[,COLUMN]", "",
              R"(what --interpolate and --to-grid look at: columns of INPUT, by name or
number as for --weights)"},
             {"--natural sibson|laplace", "",
              R"(by the volumes that the cell of a query takes from its neighbors (Sibson
1980, the default), or by areas over distances)"},
             {"--to-grid mean|dtfe|nearest|sibson", "",
              R"(the field of --values on a regular grid over the domain, into -o FILE.npy,
FILE.h5 or FILE.vti (a triclinic box not into .vti), whose cells hold
mean      the exact average of what is constant in the cell of each point
dtfe      the average density, linear in Delaunay tetrahedra, where values
          are masses (Schaap and van de Weygaert 2000), without --values 1
          each; the mass of points in no tetrahedron is left out
nearest   the value of the cell that holds the center
sibson    what --interpolate finds there
and 0 beyond walls)"},
             {"--shape NX,NY,NZ", "",
              R"(how many grid cells along x, y and z, or a, b and c of a triclinic box; N
stands for N,N,N)"},
             {"--project x|y|z", "",
              R"(sum the grid along that axis, or edge a, b or c, times the length of a grid
cell: a column density. With --image FILE.png it is drawn, a pixel for each
number, the first axis to the right; --colormap as for pictures)"},
         }},
        {"run",
         {
             {"-x, --device auto|cpu|gpu|lavapipe|INDEX", "where to run; default the first GPU, else the CPU",
              R"(auto      the first GPU, else the CPU (default); for fewer than 10,000 points the
          CPU, which is done before a GPU is found
gpu       the first GPU; without one an error, never the CPU instead
lavapipe  the first Vulkan device that is software
INDEX     that Vulkan device, a number of --list-devices)"},
             {"--precision single|double", "",
              R"(of volumes, centroids and areas from a GPU: relative error 1e-5 (single,
the default) or 1e-10 (double). The CPU always gives 1e-10; the
neighbors are exact either way)"},
             {"--memory SIZE", "",
              R"(for points larger than memory: take no more than SIZE bytes, such as 500M,
4G or (powers of 1024) 4Gi, by clipping blocks one after the other on the
CPU, with the rest in temporary files. From .npy, .h5 (snapshots too) and
rows of text into .h5, which is the file of a run in memory. Not with
vertices and faces, --min-face, --min-area, --duplicates error and
--image)"},
             {"--temporary DIR", "",
              R"(where --memory keeps them; default beside the first output. How much room
they take is said first. They have no names, and go when the run ends)"},
             {"--verify", "check the result; exit code 3 if that fails",
              R"(check the result: volume sum, symmetry of the neighbors, Euler's formula,
and a sample of cells against every point, as many as take about a second
but at least 64 or all; the summary says how many. If it fails, no file
is written and the exit code is 3)"},
         }},
        {"tuning: changes speed and memory, never the answer; default 0 = automatic",
         {
             {"-t, --threads N", "", R"(CPU threads; 0 = all)"},
             {"-g, --grid-resolution N", "", R"(blocks along an axis of the sorting grid, at most 1048576)"},
             {"-k, --k-init N", "", R"(GPU: nearest neighbors tried first for each cell, at most 1024)"},
             {"--chunk-size N", "", R"(GPU: cells in flight at once)"},
             {"--instructions NAME", "", R"(CPU: baseline, avx2 or avx512; default the best that the processor has)"},
         }},
        {"else",
         {
             {"--list-devices", "", R"(the devices of this machine: what -x accepts, name, description)"},
             {"--version", "", R"(the version)"},
             {"-h, --help", "", R"(the usual options)"},
             {"--help-all", "", R"(this text)"},
             {"--man", "", R"(this text as a manual page, for man -l)"},
             {"--completion bash|zsh|fish", "",
              R"(what completes these options in that shell:
source <(clvotess --completion bash))"},
             {"--voro++ ARGUMENTS", "",
              R"(as first argument: all that follow are those of voro++, and FILE.vol is
written as it does. Taken are -c -l -m -n -o -p -px -py -pz -r -v, the box
and FILE)"},
         }},
    };
    return sections;
}

}  // namespace clvotess

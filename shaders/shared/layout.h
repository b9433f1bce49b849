// Structures of shaders and engine: push constants and small state buffers. std430 and C++ have the same layout: no
// member needs padding (tests/stages/gpu/gpu_layout.cpp checks it). GLSL and C++ include this.
#ifndef VOTESS_SHADERS_LAYOUT_H
#define VOTESS_SHADERS_LAYOUT_H

#include "shared/config.h"

#ifdef __cplusplus
#include <cstdint>
#include <glm/vec2.hpp>
namespace votess::gpu {
using uint = std::uint32_t;
using uvec2 = glm::uvec2;  // a number of 64 bits: x is its low word
#endif

struct UploadPush {
    uvec2 origin[3];  // the box's lower corner in units, modulo 2^64
    uint first;       // first point of the raw buffer
    uint count;
    int shift;       // a point's coordinate times 2^shift is in units
    uint format;     // of the raw buffer: POINTS_
    uvec2 lower[3];  // the box as float64 bits, in an order of whole numbers: see ordered_bits()
    uvec2 upper[3];
    uint stride;  // numbers from point to point
    uint check;   // bits of CHECK_
    uint begin;   // index of the first point's first number in the raw buffer
    uint total;   // points of the run, places of images included
};

struct ImagesPush {
    uvec2 lower[3];   // of the periodic box, from the lower corner of the larger one
    uvec2 side[3];    // of the periodic box
    uvec2 extent[3];  // of the larger one
    uint periodic;    // a bit an axis
    uint count;       // of seeds
    uint total;       // of them and of places for images
};

struct SortPush {
    uint count;
    uint tiles;
    uint shift;      // of the digit in its key word
    uint high_word;  // 1: the digit is in the second key word
};

struct KeyPush {
    uint total;             // points, those without coordinates included
    uint bits;              // per axis, 1 .. KEY_BITS_PER_AXIS
    float blocks_per_unit;  // of the high words: 2^bits over the box's longest side
};

struct ScanPush {
    uint count;
};

struct BoxesPush {
    uint seed_count;
    uint level;  // to make
    uint first;  // node of the level in the node buffer
    uint count;
    uint below_first;
    uint below_count;
};

struct ReachPush {
    uvec2 lower[3];  // as in KnnPush
    uvec2 upper[3];
    uvec2 side[3];  // of the periodic box
    uint bounded;
    uint periodic;  // a bit an axis
    uint seed_count;
    uint own_count;
    uint level_count;
    uint node_count;  // of level 1
    uint max_visits;
};

struct KnnPush {
    uvec2 lower[3];  // all seeds within these bounds are known, where a bit of `bounded` is set
    uvec2 upper[3];
    uint bounded;     // bit a: lower[a] counts; bit 3 + a: upper[a]
    uint first_cell;  // first sorted seed of the chunk
    uint cell_count;  // of the chunk
    uint seed_count;
    uint own_count;  // input indices from here on are seeds beside the part: they get no cell
    uint level_count;
    uint max_visits;  // boxes visited before the search gives up
    uint keeps;       // as in ClipPush
    uint level_first[MAX_LEVELS];
};

struct ClipPush {
    uvec2 extent[3];  // of the box in units
    uint first_cell;
    uint cell_count;
    uint seed_count;
    uint own_count;  // as in KnnPush
    uint row_stride;
    uint walls;              // 1: wall ids are in the rows
    uint neighbors;          // 1: rows are requested
    float volume_tolerance;  // relative
    uint max_visits;         // boxes visited before a walk gives up
    uint bounded;            // as in KnnPush
    uint keeps;              // where in the rows the columns of kept cells begin; 0: there are none
    float kept_reach;        // units: a periodic cell is not kept if it reaches farther
    uint level_count;
    uint level_first[MAX_LEVELS];
};

// Search and clip in one pass, of the first tier, with a subgroup per cell.
struct CellsPush {
    uvec2 extent[3];  // as in ClipPush
    uvec2 lower[3];   // as in KnnPush
    uvec2 upper[3];
    uint bounded;
    uint first_cell;
    uint cell_count;
    uint seed_count;
    uint own_count;
    uint level_count;
    uint max_visits;
    uint row_stride;
    uint walls;
    uint neighbors;
    float volume_tolerance;
    uint keeps;
};

// The passes between frames, and between the rounds of a frame.
struct KeptPush {
    uint cell_count;
    uint own_count;    // as in KnnPush
    uint image_count;  // places for images
    uint keeps;        // as in ClipPush
    uint capacity;     // records in the store
    uint max_pending;  // of kept_drop
};

// Counts the kept cells over a place.
struct CoverPush {
    uvec2 extent[3];   // as in ClipPush
    float vectors[9];  // along which the box repeats, in units
    uint periodic;     // a bit a vector
    uint bounded;
    uint cell_count;
    uint seed_count;
    uint own_count;
    uint keeps;
    uint root;  // node of the root of the hierarchy
};

struct TodoPush {
    uint cell_count;
    uint max_of_tile;  // cells of TILE_ITEMS that the second tier takes
    uint group;        // invocations of a work-group of the second tier, one a cell
    uint places;       // 0: counts tiles; 1: writes the list
    uint keeps;        // not 0: cells are kept
};

struct RowsPush {
    uint first_cell;
    uint cell_count;
    uint row_stride;         // of the first tier
    uint second_row_stride;  // of the second tier
    uint second_first;       // where rows of the second tier begin, behind those of the first
    uint capacity;           // entries of the rows out
    uint window;             // of the rows out, which this dispatch writes
    uint window_bits;        // it has 2^window_bits entries
    uint named_from;         // ids from here on have names
    uint shifts;             // 1: shifts are requested, relative to the cell's own
    int shift;               // of areas in frames, as in UploadPush
};

struct GatherPush {
    uint first_cell;   // member
    uint cell_count;   // of the slice
    uint first_entry;  // sum of the lengths before
    uint entry_count;  // of the slice
    uint areas;        // 1: requested
    uint shifts;       // 1: requested
};

struct FramePush {
    uint first_cell;
    uint cell_count;
    uint capacity;   // as in RowsPush
    uint neighbors;  // 1: there are rows
    uint geometry;   // 1: there are volumes and centroids
    int shift;       // as in UploadPush
    uint seed_count;
    uint own_count;  // as in KnnPush
    uint keeps;      // not 0: cells are kept
};

// A node of the hierarchy: bounds of the seeds below it, in units. A node without seeds has the largest numbers as
// lower bounds.
struct Node {
    uvec2 lower[3];
    uvec2 upper[3];
};

// The weights below a node, see shaders/search/power.glsl.
struct NodeWeights {
    uvec2 largest;
    float tilt[3];      // units
    float drop;         // squared units
    float image_reach;  // of a group, in units: no unknown image cuts off vertices nearer to the centers of its cells
    float stretch;      // of a node of level 1: squared, by how much lengths shrink from seeds to centers
};

// A wall of any direction, behind the run state. The normal has length 1; the offset along it is from the box's lower
// corner, in units. Both are times 2^WALL_BITS; `rough` has both as floats. The rough offset of a missing wall is far
// away.
struct WallPlane {
    uvec2 normal[3];
    uvec2 offset[2];  // 128 bits, low words first, plus half a unit
    float rough[4];
};

// A triclinic box, relative to the lower corner of the box around it and its images. Numbers are in two's complement.
struct LatticeData {
    uvec2 vector[9];  // a, b, c in units, to nearest
    uvec2 dual[9];    // rows: a fraction is dual . (x - origin) / 2^(to_fraction + FRACTION_BITS)
    uvec2 origin[3];
    uvec2 unsure;      // a fraction this near to a whole number may be beyond it
    uint to_fraction;  // 33 to 63
    uint zeros;        // bit 3 j + k: the dual of edge j is exactly 0 along axis k
    uint lossy;        // 1: vectors were rounded
    int least[3];      // steps along the edges to images
    int last[3];
};

// What upload and sort found out about the points.
struct RunState {
    uint lossy;           // LOSSY_ bits: coordinates that are not whole numbers of units
    uint suspects;        // 1: there may be duplicates that were not marked
    uint duplicates;      // marked
    uint incomplete;      // 1: images are missing
    int weight_exponent;  // see WEIGHT_BITS
    uint lossy_weights;   // 1: some weights were rounded
    uvec2 heaviest;       // weight of seeds that are not in a part
    uint present;         // points of a frame, where the device alone knows their number
    uint unused;
};

// Cells that the first tier left, and the arguments of the indirect dispatches for them: of subgroups, which try first,
// and of invocations.
struct ChunkState {
    uint todo_count;
    uint groups_x, groups_y, groups_z;
    uint subgroups_x, subgroups_y, subgroups_z;
    uint left_count;  // by the first tier; cells beyond todo_count go to the CPU
    uint row_base;    // first entry of the chunk's rows in the rows out
    // For kept cells, which match up to the last round:
    uint kept_pending;    // after the test their number; then not 0: some did not match in this round
    uint kept_over;       // cells over the place of a seed
    uint kept_over_cell;  // one of them
    uint kept_failed;     // not 0: all must be made
    uint unknown_count;   // cells that no column describes, though they may have faces
    uint kept_point;      // the seed; 0xffffffff if no cell is kept
    uint unknown[KEPT_UNKNOWN];
    uint unused[9];  // arrays follow (WORDS_), 256 bytes from the front, where any device can bind them
};

// votess::vulkan::Header and Cell.
struct FrameHeader {
    uint seeds, certified, unresolved, duplicates, outside, entries, faces, images, empty, kept;
};
struct FrameCell {
    uint status, row_begin, row_length, faces;
};

#ifdef __cplusplus
}  // namespace votess::gpu
#endif

#endif

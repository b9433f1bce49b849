// Ids of specialization constants and of bindings of set 0. GLSL and C++ include this. A pass sets the constants and
// binds the buffers that its shader declares (engine/gpu/vulkan/pass.cpp).
#ifndef VOTESS_SHADERS_INTERFACE_H
#define VOTESS_SHADERS_INTERFACE_H

#define CONSTANT_LOCAL_SIZE 0     // all passes: invocations of a work-group
#define CONSTANT_K 1              // knn: most neighbors listed
#define CONSTANT_MAX_PLANES 2     // clip: a multiple of 32
#define CONSTANT_MAX_VERTICES 3   // clip: a multiple of 32
#define CONSTANT_TIER 4           // clip: 0 or 1
#define CONSTANT_GEOMETRY 5       // clip: 1 computes volume and centroid, 2 areas too
#define CONSTANT_UNIT_ROUNDOFF 6  // clip: float32's, as float bits
#define CONSTANT_LANES 7          // clip_subgroup: invocations of a subgroup, 8 to 64
#define CONSTANT_SUBGROUPS 8      // clip_subgroup: subgroups of a work-group
#define CONSTANT_LOCKSTEP 9       // clip_subgroup: 1 where lanes cannot run ahead of each other
#define CONSTANT_FIRST_COUNT 10   // clip_subgroup: seeds that the first search aims at
#define CONSTANT_WALLS 11         // clip: 1 when there are walls of any direction
#define CONSTANT_WEIGHTS 12       // sort, knn, clip: 1 in a power diagram
#define CONSTANT_WRITES_SUMS 13   // clip in float64: 1 when measures are written as sums of two float32
#define CONSTANT_COUNT 14

// N points, M items to sort or scan, C cells of a chunk, P members of a part. A pass binds at most eight, which all but
// the smallest devices can. So arrays of the same kind share a buffer.
#define BINDING_RAW 0      // upload: 3 float64 or float32 a point
#define BINDING_POINTS 1   // uvec2, input order: N x, N y and N z in units; in a power diagram, N weights too
#define BINDING_LATTICE 2  // LatticeData of a frame in a triclinic box
#define BINDING_KEYS_IN 3  // N uvec2
#define BINDING_KEYS_OUT 4
#define BINDING_INDEX_IN 5  // N uint, input index
#define BINDING_INDEX_OUT 6
#define BINDING_SCAN_DATA 7    // M uint; sort: items of each digit in each tile, digit-major
#define BINDING_SCAN_SUMS 8    // totals of blocks of TILE_ITEMS
#define BINDING_SEEDS 9        // as POINTS, in sorted order
#define BINDING_SEED_INPUT 10  // N uint, input index, with DUPLICATE_BIT
#define BINDING_RUN_STATE 11   // RunState and the walls of any direction
#define BINDING_NODES 12       // all levels of the hierarchy: Node; in a power diagram, Node and NodeWeights in turn
#define BINDING_CHUNK 13       // ChunkState and arrays of C uint, see WORDS_ in config.h
#define BINDING_ROWS 14        // face x C int, face-major: neighbor's input index or wall id; then of the second tier
#define BINDING_AREAS 15       // as ROWS: areas, units of the cell squared; float32, or float64 as geometry is
#define BINDING_GEOMETRY 16    // C x 4: volume and centroid, units of the cell, relative to the seed
#define BINDING_NAMES 17       // uvec2: input index and shift, see SHIFT_NONE, of images or members
// A window of 2^RowsPush.window_bits entries.
#define BINDING_ROWS_OUT 18    // int: the chunk's rows one after the other, each ascending
#define BINDING_AREAS_OUT 19   // beside ROWS_OUT
#define BINDING_SHIFTS_OUT 20  // int8 x y z 0, beside ROWS_OUT
// A frame.
#define BINDING_HEADER 21        // FrameHeader
#define BINDING_CELLS 22         // N FrameCell, input order
#define BINDING_GEOMETRY_OUT 23  // N vec4, input order: centroid relative to the seed, volume
// The cells of a part, by member; it has P members of its own.
#define BINDING_PART_INFO 24      // P uint, as WORDS_INFO
#define BINDING_PART_LENGTH 25    // P uint: of the row that is among the rows out
#define BINDING_PART_BEGIN 26     // P uint: entry of the rows out with which it begins
#define BINDING_PART_OFFSETS 27   // P uint: sums of the lengths before
#define BINDING_PART_GEOMETRY 28  // P x 4, as GEOMETRY
// Rows of some of them, in their order.
#define BINDING_SLICE_ROWS 29    // int
#define BINDING_SLICE_AREAS 30   // beside the rows
#define BINDING_SLICE_SHIFTS 31  // int8 x y z, without gaps, beside the rows
// Gradients of a frame.
#define BINDING_GRADIENT 32         // 3 numbers a seed, then one a seed: by points and by weights; float32 or float64
#define BINDING_SLOPES 33           // N dvec4, see gradient_cells.comp
#define BINDING_GIVEN_VOLUMES 34    // N float
#define BINDING_GIVEN_CENTROIDS 35  // 3N numbers, as RAW
#define BINDING_GIVEN_AREAS 36      // float, beside the rows of SLICE_ROWS
// A frame that keeps cells.
#define BINDING_KEPT 37    // records of M seeds, M the capacity: word k of seed i is at k M + i, see KEPT_ in config.h
#define BINDING_PLACES 38  // N uint: the sorted seed of each point
#define BINDING_COUNT 39
#define MAX_BINDINGS 8  // of a pass

#endif

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

// N points, M items to sort or scan, C cells of a chunk, T cells of the second tier.
#define BINDING_RAW 0       // upload: 3 float64 or float32 a point
#define BINDING_POINTS_X 1  // N uvec2, units, input order
#define BINDING_POINTS_Y 2
#define BINDING_POINTS_Z 3
#define BINDING_KEYS_IN 4  // N uvec2
#define BINDING_KEYS_OUT 5
#define BINDING_INDEX_IN 6  // N uint, input index
#define BINDING_INDEX_OUT 7
#define BINDING_SCAN_DATA 8  // M uint; sort: items of each digit in each tile, digit-major
#define BINDING_SCAN_SUMS 9  // totals of blocks of TILE_ITEMS
#define BINDING_SEEDS_X 10   // N uvec2, units, sorted order
#define BINDING_SEEDS_Y 11
#define BINDING_SEEDS_Z 12
#define BINDING_SEED_INPUT 13  // N uint, input index, with DUPLICATE_BIT
#define BINDING_RUN_STATE 14
#define BINDING_NODES 15       // boxes of the hierarchy, all levels
#define BINDING_LIST 16        // k x C uint, neighbor-major: sorted seeds, nearest first
#define BINDING_LIST_INFO 17   // C ListInfo
#define BINDING_INFO 18        // C uint, see INFO_ in config.h
#define BINDING_ROW_LENGTH 19  // C uint
#define BINDING_ROW_PLACE 20   // C uint: column in the rows, with SECOND_TIER_BIT
#define BINDING_ROWS 21        // face x C int, face-major: neighbor's input index or wall id
#define BINDING_GEOMETRY 22    // C x 4: volume and centroid, units of the cell, relative to the seed
#define BINDING_TODO 23        // T uint: cells (in the chunk) that the first tier left to the second
#define BINDING_CHUNK_STATE 24
#define BINDING_SECOND_ROWS 25   // as ROWS, of the second tier
#define BINDING_ROW_OFFSETS 26   // C uint
#define BINDING_ROWS_OUT 27      // int: the chunk's rows one after the other, each ascending
#define BINDING_AREAS 28         // as ROWS: areas, units of the cell squared; float32, or float64 as geometry is
#define BINDING_SECOND_AREAS 29  // as AREAS, of the second tier
#define BINDING_AREAS_OUT 30     // beside ROWS_OUT
#define BINDING_HEADER 31        // FrameHeader of a frame
#define BINDING_CELLS 32         // N FrameCell, input order
#define BINDING_GEOMETRY_OUT 33  // N vec4, input order: centroid relative to the seed, volume
// The rows out are bound as windows. All except the last have 2^RowsPush.window_bits entries.
#define BINDING_ROWS_OUT_1 34
#define BINDING_ROWS_OUT_2 35
#define BINDING_ROWS_OUT_3 36
#define BINDING_NAMES 37       // uvec2: input index and shift, see SHIFT_NONE, of images or members
#define BINDING_SHIFTS_OUT 38  // int8 x y z 0, beside ROWS_OUT and in as many windows
#define BINDING_SHIFTS_OUT_1 39
#define BINDING_SHIFTS_OUT_2 40
#define BINDING_SHIFTS_OUT_3 41
// The cells of a part, by member; it has P members of its own.
#define BINDING_PART_INFO 42      // P uint, as INFO
#define BINDING_PART_LENGTH 43    // P uint: of the row that is among the rows out
#define BINDING_PART_BEGIN 44     // P uint: entry of the rows out with which it begins
#define BINDING_PART_OFFSETS 45   // P uint: sums of the lengths before
#define BINDING_PART_GEOMETRY 46  // P x 4, as GEOMETRY
// Rows of some of them, in their order.
#define BINDING_SLICE_ROWS 47    // int
#define BINDING_SLICE_AREAS 48   // beside the rows
#define BINDING_SLICE_SHIFTS 49  // int8 x y z, without gaps, beside the rows
#define BINDING_LATTICE 50       // LatticeData of a frame in a triclinic box
#define BINDING_POINTS_W 51      // N uvec2, weights, input order; this and the next two only in a power diagram
#define BINDING_SEEDS_W 52       // N uvec2, sorted order
#define BINDING_NODE_WEIGHTS 53  // NodeWeights, beside NODES
#define BINDING_COUNT 54

#endif

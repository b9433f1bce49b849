// Constants of shaders and engine. GLSL and C++ include this.
#ifndef VOTESS_SHADERS_CONFIG_H
#define VOTESS_SHADERS_CONFIG_H

// Coordinates are whole numbers of 64 bits: the longest side of the box is in [2^61, 2^62) units, the box begins at 0.
#define COORDINATE_BITS 62

// UploadPush.format
#define POINTS_FLOAT64 0u
#define POINTS_FLOAT32 1u
#define POINTS_UNITS 2u  // whole numbers of units already, modulo 2^64

// What upload checks of each point.
#define CHECK_BOX 1u    // points outside of the box, or not finite, get no coordinates
#define CHECK_COUNT 2u  // points from RunState.present on are not read and get no coordinates

// RunState.lossy
#define LOSSY_POINTS 1u
#define LOSSY_BOX 2u
#define LOSSY_WALLS 4u    // their places have been rounded
#define LOSSY_IMAGES 16u  // vectors of a triclinic box have been rounded

#define MAX_WALL_ERROR 4  // units, of the distance to a wall of any direction (clip/wall_distance.glsl)
#define WALL_BITS 62      // normals of walls of any direction are right to half of 2^-WALL_BITS

// Triclinic boxes of frames: fractional bits of a fraction; the largest sum of steps along the edges between a seed and
// a neighbor of its cell.
#define FRACTION_BITS 60
#define MAX_STEPS_APART 128

// Weights of a power diagram are whole numbers below 2^62, in 2^RunState.weight_exponent squared units. The lightest is
// 0.
#define WEIGHT_BITS 62

// A tilt (shaders/search/power.glsl) is a whole number of 2^TILT_BITS units along each axis, less than 2^MAX_TILT_BITS
// units.
#define TILT_BITS 31
#define MAX_TILT_BITS 59
#define MIN_TILTED_SEEDS 8

// sort: a stable radix sort, 8 bits at a time, of keys that hold a Hilbert index of 20 bits per axis in two words.
#define KEY_BITS_PER_AXIS 20
#define KEY_WORD_BITS 30
#define DIGIT_BITS 8  // a tile sorts them in two halves
#define DIGITS (1 << DIGIT_BITS)
#define TILE_GROUP 128     // invocations per tile, in sort and scan; every Vulkan device has 128
#define TILE_ITEMS_EACH 8  // items of one invocation, the digits of half of four bits
#define TILE_ITEMS (TILE_GROUP * TILE_ITEMS_EACH)
#define MAX_LOOK_BACK 64  // seeds of equal key compared in search of a duplicate

// knn: boxes over groups of consecutive sorted seeds, each level above covers FAN nodes of the level below.
#define GROUP_SEEDS 8
#define FAN_BITS 3
#define FAN (1 << FAN_BITS)
#define MAX_LEVELS 12
#define UNBOUNDED 3.0e38  // beyond all squared distances, which are below 2^126 units

// Replaces the coordinates of a seed that loses its place to another; no coordinate is this large. For a lighter seed,
// which is not a duplicate, y is 0.
#define NO_COORDINATE 0xffffffffu
#define DUPLICATE_BIT 0x80000000u  // in the input index of a sorted seed
#define INDEX_MASK 0x7fffffffu

#define EXPECTED_REACH 0.002  // cubed radius of the first search over volume of 64 seeds' box and k
#define BUCKET_SHIFT 19       // of a float's bits: lists are sorted by squared distance to 16 buckets an octave
// Squared distances in a bucket differ by at most the factor 16/17. This is smaller by 8e-5, because distances are
// right to 1e-6, or from coarse_from on to 1.4e-5 (search/distances.glsl).
#define BUCKET_SLACK 0.9411

// clip: a cell's unit of length is 2^k units; its nearest neighbor is 0.9 to 4 of these away. In a box of 2^25 such
// lengths no product of a vertex (five lengths) leaves the range of float32.
#define SMALLEST_CELL_EXPONENT 37

// clip_subgroup: words of shared memory of a subgroup, see search/subgroup_state.glsl.
#define SUBGROUP_PLANES 32    // in float32; in float64 and in the second tier twice as many
#define SUBGROUP_STORE 64     // candidates; a power of two
#define SUBGROUP_NODES 76     // boxes to open
#define SUBGROUP_GROUPS 72    // groups to look into, at least 64 + 64 / GROUP_SEEDS
#define SUBGROUP_SEARCHES 96  // searches for a cell in a tier

// clip: the place of a row. Rows of the second tier have this bit set.
#define SECOND_TIER_BIT 0x80000000u

// Shifts of periodic images, in one word of their lexicographic order: x + 128, y + 128 and z + 128, a byte each.
#define SHIFT_NONE 0x808080u

// download: entries of the rows that an invocation moves.
#define GATHER_ENTRIES 4

// Arrays of one word for each cell of a chunk. They lie one after the other behind its ChunkState (shared/chunk.glsl).
#define WORDS_ROW_OFFSET 0u  // sums of the lengths before
#define WORDS_ROW_LENGTH 1u
#define WORDS_ROW_PLACE 2u     // column in the rows, with SECOND_TIER_BIT
#define WORDS_INFO 3u          // see INFO_
#define WORDS_TODO 4u          // cells that the first tier left to the second; not all are used
#define WORDS_KEPT 5u          // see KEPT_; of frames that keep cells
#define WORDS_OF_CELLS 6u      // without lists
#define WORDS_LIST_LENGTHS 6u  // of a list; in the high half, of its first bucket, which is not sorted
#define WORDS_LIST_REACH 7u    // float: squared distance in units (weights: rank) up to which a list is complete
#define WORDS_LIST_BOUND 8u    // float: squared distance beyond which seeds are unknown
#define WORDS_LIST 9u          // k arrays: sorted seeds, nearest first

// Frames that keep cells (kept/kept_column.glsl). Each cell of the chunk has a column of KEPT_WORDS in the rows: its
// reach in units as a float, planes, corners. Larger cells have none. A stored record has a head, planes, their shifts
// in a periodic plan, and corners in pairs.
#define KEPT_PLANES 32
#define KEPT_CORNERS 64
#define KEPT_WORDS (1 + KEPT_PLANES + KEPT_CORNERS)
#define KEPT_STORED_WORDS (1 + KEPT_PLANES + KEPT_CORNERS / 2)
#define KEPT_STORED_SHIFTS KEPT_PLANES
#define KEPT_ROUNDS 3  // in which cells may be made until all match
#define KEPT_UNKNOWN 40
// The word of a cell: the number of its planes, then of corners, and
#define KEPT_CORNERS_SHIFT 8
#define KEPT_MADE 0x10000u         // it has a column
#define KEPT_HELD 0x20000u         // planes and corners are those of the last frame
#define KEPT_TRIED 0x40000u        // it was clipped in this frame
#define KEPT_TRIED_AGAIN 0x80000u  // by the second tier too, if that was needed

// Statuses, equal to votess::CellStatus.
#define STATUS_CERTIFIED 0u
#define STATUS_NEEDS_EXACT 1u
#define STATUS_PLANE_OVERFLOW 2u
#define STATUS_VERTEX_OVERFLOW 3u
#define STATUS_CANDIDATES_EXHAUSTED 4u
#define STATUS_DUPLICATE 5u
#define STATUS_EMPTY 6u
#define STATUS_OUTSIDE 7u

// Cell info word: status, faces, vertices, binary exponent of the cell's unit of length.
#define INFO_FACES_SHIFT 8
#define INFO_VERTICES_SHIFT 16
#define INFO_EXPONENT_SHIFT 24

#endif

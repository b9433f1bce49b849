// The state that search, clip and measure share when a subgroup makes a cell: seed, status and words of shared memory.
#ifndef VOTESS_SEARCH_SUBGROUP_STATE_GLSL
#define VOTESS_SEARCH_SUBGROUP_STATE_GLSL

#include "clip/plane_set.glsl"
#include "invocations/subgroup.glsl"
#include "numbers/real.glsl"
#include "shared/config.h"

uint self;  // sorted seed
uint status;

// The words of a subgroup have several users in turn. A search has keys and seeds of its candidates in the store, and two
// stacks in scratch memory. Then the sorted seeds replace these, behind the words of cuts: the killed vertices and the
// edges of the horizon. The store is free for planes to test. A measured cell has the numbers of its planes in the store
// and behind it, and the list of its vertices in scratch memory. The first nodes of the levels stay.
#ifdef GEOMETRY_FLOAT64
const uint vertex_words = 0u;
#else
const uint vertex_words = 4u * max_planes;  // the list of vertices and a coordinate of each
#endif
const uint first_plane_word = 2u * SUBGROUP_STORE,
           first_scratch_word = max(first_plane_word + 4u * max_planes * words_of_real, 8u * max_planes),
           first_level_word = max(SUBGROUP_NODES + SUBGROUP_GROUPS, max(2u * max_planes + SUBGROUP_STORE, vertex_words)),
           words_of_subgroup = first_scratch_word + first_level_word + MAX_LEVELS;
shared uint words[words_of_subgroup * subgroups];

// Terms of a sum are added from the left.
#define WORD(sum) words[words_of_subgroup * SUBGROUP + sum]
#define SCRATCH(sum) WORD(first_scratch_word + sum)
#define CANDIDATE_KEY(i) WORD((i))  // squared distance; the last bits are the index
#define CANDIDATE_SEED(i) WORD(SUBGROUP_STORE + (i))
#define NODE_STACK(i) SCRATCH((i))
#define GROUP_STACK(i) SCRATCH(SUBGROUP_NODES + (i))
#define KILLED(i) SCRATCH((i))
#define HORIZON(i) SCRATCH(max_planes + (i))
#define SORTED_SEED(i) SCRATCH(2u * max_planes + (i))
#define VERTEX_LIST(i) SCRATCH((i))
#define LEVEL_FIRST(level) SCRATCH(first_level_word + (level))

#endif

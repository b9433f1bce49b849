// The state that search, clip and measure share when a subgroup makes a cell: seed, status and words of shared memory.
#ifndef VOTESS_SEARCH_SUBGROUP_STATE_GLSL
#define VOTESS_SEARCH_SUBGROUP_STATE_GLSL

#include "invocations/subgroup.glsl"
#include "shared/config.h"

uint self;  // sorted seed
uint status;

// Each subgroup of the work-group has a part of these arrays.
shared uint store[2 * SUBGROUP_STORE * subgroups];
shared uint scratch[SUBGROUP_SCRATCH * subgroups];

// The words of the store and of scratch memory have several users in turn. A search has keys and seeds of its candidates
// in the store, and two stacks. Then the sorted seeds replace the groups, behind the words of cuts: the killed vertices,
// and the edges of the horizon. The store is free for planes to test. A measured cell has its planes in the store, and
// the list of its vertices instead of the killed ones. The first nodes of the levels stay.
#define STORE_WORD(sum) store[2 * SUBGROUP_STORE * SUBGROUP + sum]  // its terms are added from the left
#define CANDIDATE_KEY(i) STORE_WORD((i))  // squared distance; the last bits are the index
#define CANDIDATE_SEED(i) STORE_WORD(SUBGROUP_STORE + (i))
#define SCRATCH(sum) scratch[SUBGROUP_SCRATCH * SUBGROUP + sum]  // its terms are added from the left
#define NODE_STACK(i) SCRATCH((i))
#define GROUP_STACK(i) SCRATCH(SUBGROUP_NODES + (i))
#define KILLED(i) SCRATCH((i))
#define HORIZON(i) SCRATCH(2u * SUBGROUP_PLANES + (i))
#define SORTED_SEED(i) SCRATCH(3u * SUBGROUP_PLANES + (i))
#define VERTEX_LIST(i) SCRATCH((i))
#define LEVEL_FIRST(level) SCRATCH(3u * SUBGROUP_PLANES + SUBGROUP_STORE + (level))

#endif

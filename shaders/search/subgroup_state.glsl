// The state that search, clip and measure share when a subgroup makes a cell: seed, status and words of shared memory.
#ifndef VOTESS_SEARCH_SUBGROUP_STATE_GLSL
#define VOTESS_SEARCH_SUBGROUP_STATE_GLSL

#include "invocations/subgroup.glsl"
#include "shared/config.h"

uint self;  // sorted seed
uint status;

// Each subgroup of the work-group has a part of these arrays.
shared uint candidate_key[SUBGROUP_STORE * subgroups];  // squared distance; the last bits are the index
shared uint candidate_seed[SUBGROUP_STORE * subgroups];
shared uint scratch[SUBGROUP_SCRATCH * subgroups];

// The words of scratch memory have several users in turn. A search has two stacks. Then the order of the sorted store
// replaces the groups, behind the words of cuts. Cuts have three words a plane a: the planes b with an edge (a, b) of a
// killed vertex, the planes b with (b, a), and the edges of the horizon. A measured cell has the list of its vertices
// there. The first nodes of the levels stay.
#define SCRATCH(sum) scratch[SUBGROUP_SCRATCH * SUBGROUP + sum]  // its terms are added from the left
#define NODE_STACK(i) SCRATCH((i))
#define GROUP_STACK(i) SCRATCH(SUBGROUP_NODES + (i))
#define EDGES_FROM(a) SCRATCH(2u * (a))
#define EDGES_TO(a) SCRATCH(2u * (a) + 1u)
#define HORIZON(i) SCRATCH(2u * SUBGROUP_PLANES + (i))
#define SORTED(i) SCRATCH(3u * SUBGROUP_PLANES + (i))
#define VERTEX_LIST(i) SCRATCH((i))
#define LEVEL_FIRST(level) SCRATCH(3u * SUBGROUP_PLANES + SUBGROUP_STORE + (level))

#endif

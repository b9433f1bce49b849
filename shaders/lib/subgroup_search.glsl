// The seeds around one, by a subgroup: all whose squared distance is at least `done` and below `next` and that can cut
// the cell, put into the store and sorted. The lanes test boxes and seeds side by side: first the siblings of the seed's group and of all
// that holds it, then the children of boxes that are near, GROUP_SEEDS lanes for each, groups of seeds before boxes.
//
// The store is sorted whole (bitonic, in shared memory): by unique keys, so that the order does not depend on which
// lane came first, as places in buckets taken by atomics would.
//
// Needs self, status, first_count, the shared arrays, and what lib/subgroup.glsl and lib/reach.glsl define.

float done, next;
bool coarse;  // high words are enough
uint candidate_count;
uint visits;
float nearest_beyond;  // of this lane: at most the squared distance of any seed left out for being too far
// Bounds, relative to the seed, of all places whose seeds can cut the cell. Where a cell is long, most of its security
// sphere lies beyond them.
vec3 reach_lower, reach_upper;
uint node_count, group_count;

const uint lanes_each = FAN;  // of a box and of a group
const uint side_by_side = uint(lanes) / lanes_each;
const uint key_place_mask = SUBGROUP_STORE - 1u;

#define NODE_STACK(i) scratch[SUBGROUP_SCRATCH * SUBGROUP + (i)]
#define GROUP_STACK(i) scratch[SUBGROUP_SCRATCH * SUBGROUP + SUBGROUP_NODES + (i)]
#define LEVEL_FIRST(level) scratch[SUBGROUP_SCRATCH * SUBGROUP + SUBGROUP_NODES + SUBGROUP_GROUPS + (level)]
#define NODE_BITS 28

uint nodes_of(uint level) {
    return ((push.seed_count - 1u) >> (FAN_BITS * (level + 1u))) + 1u;
}

// Candidate i of the sorted store.
uint candidate_at(uint i) {
    const uint base = SUBGROUP_STORE * SUBGROUP;
    return candidate_seed[base + (candidate_key[base + i] & key_place_mask)];
}

float distance_of(uint key) {
    return uintBitsToFloat(key & ~key_place_mask);
}

void begin_search() {
    done = 0.0;
    visits = 0u;
    for (uint level = lane; level < push.level_count; level += uint(lanes)) {
        uint first = 0u;
        for (uint below = 0u; below < level; ++below) first += nodes_of(below);
        LEVEL_FIRST(level) = first;
    }
    share();
    reach_lower = vec3(-UNBOUNDED);
    reach_upper = vec3(UNBOUNDED);
    next = UNBOUNDED;
    if (push.level_count >= 3u) next = expected_reach_in(nodes[LEVEL_FIRST(1) + self / (GROUP_SEEDS * FAN)], first_count);
    coarse = next >= coarse_from;
}

void search_again_finely() {
    coarse = false;
    done = 0.0;
}

// Bounds of the balls around vertices that go through the seed: lengths in units, along each axis, down and up.
void set_reach(vec3 down, vec3 up) {
    const float slack = coarse ? 3.5e10 : 0.0;  // 2^35, of the high words
    reach_lower = -(down * 1.0001 + slack);
    reach_upper = up * 1.0001 + slack;
}

// Outwards, at most to where no seed can cut the cell.
void search_on(float needed) {
    next = min(needed, done * (candidate_count < 16u ? 4.0 : 2.0));
    if (!(next < UNBOUNDED)) next = UNBOUNDED;
}

float offset(uvec2 q, uvec2 p) {
    return coarse ? coarse_offset(q.y, p.y) : rough_difference(q, p);
}

// Whether a box may hold candidates.
bool is_near(uint level, uint node) {
    const uint n = LEVEL_FIRST(level) + node;
    if (nodes[n].lower[0].y == NO_COORDINATE) return false;
    const vec3 lower = vec3(offset(nodes[n].lower[0], px), offset(nodes[n].lower[1], py), offset(nodes[n].lower[2], pz));
    const vec3 upper = vec3(offset(nodes[n].upper[0], px), offset(nodes[n].upper[1], py), offset(nodes[n].upper[2], pz));
    if (any(greaterThan(lower, reach_upper)) || any(lessThan(upper, reach_lower))) return false;
    const vec3 gap = max(max(lower, -upper), vec3(0.0));
    const float d = dot(gap, gap) * box_slack;
    if (d < next) return true;
    nearest_beyond = min(nearest_beyond, d);
    return false;
}

// Whether a seed is a candidate, and its squared distance.
bool is_candidate(uint seed, out float d) {
    d = 0.0;
    const uint high = seeds_x[seed].y;
    if (seed == self || high == NO_COORDINATE) return false;
    const float dx = offset(seeds_x[seed], px), dy = offset(seeds_y[seed], py), dz = offset(seeds_z[seed], pz);
    // The same in every search of the cell, or one would see a seed twice or never.
    precise const float square = dx * dx + dy * dy + dz * dz;
    d = square;
    const vec3 at = vec3(dx, dy, dz);
    if (any(greaterThan(at, reach_upper)) || any(lessThan(at, reach_lower))) return false;
    if (d >= next) nearest_beyond = min(nearest_beyond, d);
    return d >= done && d < next;
}

// Boxes that are near, one a lane at most; false when there are too many.
bool push_near(bool near, uint level, uint node) {
    uint groups, boxes;
    const uint group_rank = rank_among(near && level == 0u, groups);
    const uint box_rank = rank_among(near && level != 0u, boxes);
    if (node_count + boxes > SUBGROUP_NODES || group_count + groups > SUBGROUP_GROUPS) return false;
    if (near && level == 0u) GROUP_STACK(group_count + group_rank) = node;
    if (near && level != 0u) NODE_STACK(node_count + box_rank) = (level << NODE_BITS) | node;
    group_count += groups;
    node_count += boxes;
    share();
    return true;
}

bool look_into_groups() {
    const uint taken = min(group_count, side_by_side), which = lane / lanes_each;
    group_count -= taken;
    float d = 0.0;
    uint seed = 0u;
    bool candidate = false;
    if (which < taken) {
        seed = GROUP_STACK(group_count + which) * GROUP_SEEDS + lane % lanes_each;
        candidate = seed < push.seed_count && is_candidate(seed, d);
    }
    uint count;
    const uint place = candidate_count + rank_among(candidate, count);
    if (candidate && place < SUBGROUP_STORE) {
        candidate_key[SUBGROUP_STORE * SUBGROUP + place] = (floatBitsToUint(d) & ~key_place_mask) | place;
        candidate_seed[SUBGROUP_STORE * SUBGROUP + place] = seed;
    }
    candidate_count = min(candidate_count + count, SUBGROUP_STORE + 1u);
    return candidate_count <= SUBGROUP_STORE;
}

bool open_boxes() {
    const uint taken = min(node_count, side_by_side), which = lane / lanes_each;
    node_count -= taken;
    visits += taken * FAN;
    uint level = 0u, node = 0u;
    bool near = false;
    if (which < taken) {
        const uint parent = NODE_STACK(node_count + which);
        level = (parent >> NODE_BITS) - 1u;
        node = (parent & ((1u << NODE_BITS) - 1u)) * FAN + lane % lanes_each;
        near = node < nodes_of(level) && is_near(level, node);
    }
    share();  // read before it is written over
    return push_near(near, level, node);
}

// False when a stack or the store is full.
bool collect() {
    const uint own = self / GROUP_SEEDS, steps = (push.level_count - 1u) * FAN;
    visits += steps;
    group_count = 1u;
    share();  // the last cut may still read what lies there
    if (lane == 0u) GROUP_STACK(0) = own;
    share();
    for (uint first = 0u; first < steps; first += uint(lanes)) {
        const uint level = (first + lane) / FAN;
        bool near = false;
        uint node = 0u;
        if (first + lane < steps) {
            node = (own >> (FAN_BITS * (level + 1u))) * FAN + lane % FAN;
            near = node != own >> (FAN_BITS * level) && node < nodes_of(level) && is_near(level, node);
        }
        if (!push_near(near, level, node)) return false;
    }
    while (group_count + node_count > 0u) {
        const bool groups_first = group_count >= side_by_side || node_count == 0u;
        if (groups_first ? !look_into_groups() : !open_boxes()) return false;
        if (visits > push.most_visits) {
            status = STATUS_CANDIDATES_EXHAUSTED;
            return false;
        }
    }
    return true;
}

// By distance. Keys beyond the last candidate are the largest of numbers.
void sort_candidates() {
    const uint base = SUBGROUP_STORE * SUBGROUP;
    if (candidate_count < 2u) {
        share();
        return;
    }
    const uint size = 2u << uint(findMSB(candidate_count - 1u));
    for (uint i = candidate_count + lane; i < size; i += uint(lanes)) candidate_key[base + i] = 0xffffffffu;
    share();
    for (uint run = 2u; run <= size; run <<= 1)
        for (uint stride = run >> 1; stride > 0u; stride >>= 1) {
            for (uint i = lane; i < size / 2u; i += uint(lanes)) {
                const uint a = base + 2u * i - (i & (stride - 1u)), b = a + stride;
                const uint key_a = candidate_key[a], key_b = candidate_key[b];
                if ((key_a > key_b) == (((a - base) & run) == 0u)) {
                    candidate_key[a] = key_b;
                    candidate_key[b] = key_a;
                }
            }
            share();
        }
}

// False when the store does not hold them: then `next` is shorter, or the status tells why that is of no use.
bool search() {
    candidate_count = 0u;
    node_count = 0u;
    nearest_beyond = UNBOUNDED;
    const bool complete = collect();
    if (status != STATUS_CERTIFIED) return false;
    if (complete) {
        const float beyond = smallest(nearest_beyond);
        done = beyond >= UNBOUNDED ? UNBOUNDED : max(next, beyond * reach_slack);
        return true;
    }
    // Those found first are near.
    candidate_count = min(candidate_count, SUBGROUP_STORE);
    sort_candidates();
    const float shorter =
        candidate_count == 0u
            ? 0.5 * (done + next)
            : distance_of(candidate_key[SUBGROUP_STORE * SUBGROUP + candidate_count * uint(first_count) / 160u]);
    if (shorter > done && shorter < next)
        next = shorter;
    else
        status = STATUS_CANDIDATES_EXHAUSTED;
    if (done == 0.0) coarse = coarse && next >= coarse_from;
    return false;
}

// What the lanes of a subgroup do together. To be called by all of them.
//
// Variant: LANES_OF_WORK_GROUP takes the invocations of a work-group instead, by shared memory, and any number of them;
// so a device tests the kernels for subgroups that it does not have.
//
// Needs lanes, subgroups, lockstep and numbers/number.glsl.

uint lane;

#ifdef LANES_OF_WORK_GROUP

#define SUBGROUP 0u
shared uint exchange[64];
shared Number exchange_numbers[64];

bool enter_subgroup() {
    lane = gl_LocalInvocationID.x;
    return gl_WorkGroupSize.x == uint(lanes) && subgroups == 1;
}

void share() {
    memoryBarrierShared();
    barrier();
}

void put(uint value) {
    share();
    exchange[lane] = value;
    share();
}

bool any_lane(bool yes) {
    put(yes ? 1u : 0u);
    uint all = 0u;
    for (uint i = 0u; i < uint(lanes); ++i) all |= exchange[i];
    return all != 0u;
}

uint rank_among(bool yes, out uint count) {
    put(yes ? 1u : 0u);
    uint rank = 0u;
    count = 0u;
    for (uint i = 0u; i < uint(lanes); ++i) {
        if (i < lane) rank += exchange[i];
        count += exchange[i];
    }
    return rank;
}

uint sum(uint value) {
    put(value);
    uint all = 0u;
    for (uint i = 0u; i < uint(lanes); ++i) all += exchange[i];
    return all;
}

uint all_bits(uint value) {
    put(value);
    uint all = 0u;
    for (uint i = 0u; i < uint(lanes); ++i) all |= exchange[i];
    return all;
}

float largest(float number) {
    put(floatBitsToUint(number));
    float all = 0.0;
    for (uint i = 0u; i < uint(lanes); ++i) all = max(all, uintBitsToFloat(exchange[i]));
    return all;
}

float smallest(float number) {
    put(floatBitsToUint(number));
    float all = number;
    for (uint i = 0u; i < uint(lanes); ++i) all = min(all, uintBitsToFloat(exchange[i]));
    return all;
}

float sum(float value) {
    put(floatBitsToUint(value));
    float all = 0.0;
    for (uint i = 0u; i < uint(lanes); ++i) all += uintBitsToFloat(exchange[i]);
    return all;
}

Number sum(Number value) {
    share();
    exchange_numbers[lane] = value;
    share();
    Number all = number(0.0);
    for (uint i = 0u; i < uint(lanes); ++i) all = plus(all, exchange_numbers[i]);
    return all;
}

#else

// Of the work-group. Its lanes take the number of the first one: compilers that reckon gl_SubgroupID from the
// invocation cannot know that it is the same in all, and then take every branch on what is read from shared memory for
// one that may part the lanes.
uint subgroup_index;
#define SUBGROUP subgroup_index

// False when subgroups are not those that the kernel was made for: so many, of so many invocations in a row.
bool enter_subgroup() {
    lane = gl_SubgroupInvocationID;
    const uint mine = gl_LocalInvocationID.x / uint(lanes);
    subgroup_index = subgroups == 1 ? 0u : subgroupBroadcastFirst(mine);
    return subgroupAll(mine == subgroup_index && gl_SubgroupSize == uint(lanes) && gl_NumSubgroups == uint(subgroups));
}

// What the lanes have written to shared memory becomes visible to all of the subgroup.
void share() {
    if (lockstep)
        subgroupMemoryBarrierShared();
    else
        subgroupBarrier();  // of control and of memory
}

bool any_lane(bool yes) {
    return subgroupAny(yes);
}

// How many lanes before this one say so, and how many in all.
uint rank_among(bool yes, out uint count) {
    const uvec4 ballot = subgroupBallot(yes);
    count = subgroupBallotBitCount(ballot);
    return subgroupBallotExclusiveBitCount(ballot);
}

uint sum(uint value) {
    return subgroupAdd(value);
}

uint all_bits(uint value) {
    return subgroupOr(value);
}

// Of numbers that are not negative; their bits are in the same order, and whole numbers are quicker on some devices.
float largest(float number) {
    return uintBitsToFloat(subgroupMax(floatBitsToUint(number)));
}

float smallest(float number) {
    return uintBitsToFloat(subgroupMin(floatBitsToUint(number)));
}

float sum(float value) {
    return subgroupAdd(value);
}

// In pairs of lanes, then of pairs: a sum of two does not depend on their order, so it is the same in all lanes.
Number sum(Number value) {
    for (uint step = 1u; step < uint(lanes); step *= 2u) {
        const uvec2 words = words_of(value);
        value = plus(value, of_words(uvec2(subgroupShuffleXor(words.x, step), subgroupShuffleXor(words.y, step))));
    }
    return value;
}

#endif

// Operations that the lanes of a subgroup do together; all of them must call them. The .comp enables the GL_KHR_shader_subgroup
// extensions.
//
// Variant: LANES_OF_WORK_GROUP takes the invocations of a work-group instead, by shared memory, and any number of them;
// so a device tests the kernels for subgroups that it does not have.
#ifndef VOTESS_INVOCATIONS_SUBGROUP_GLSL
#define VOTESS_INVOCATIONS_SUBGROUP_GLSL

#include "numbers/number.glsl"
#include "shared/interface.h"

layout(constant_id = CONSTANT_LANES) const int lanes = 32;
layout(constant_id = CONSTANT_SUBGROUPS) const int subgroups = 2;
layout(constant_id = CONSTANT_LOCKSTEP) const bool lockstep = false;

uint lane;

#ifdef LANES_OF_WORK_GROUP

#define SUBGROUP 0u
shared uint exchange[lanes];
shared Number exchange_numbers[lanes];

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

uvec2 from_first_lane(uvec2 value) {
    put(value.x);
    const uint low = exchange[0];
    put(value.y);
    return uvec2(low, exchange[0]);
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

uint first_lane(bool yes) {
    put(yes ? 1u : 0u);
    uint first = 0u;
    while (first < uint(lanes) && exchange[first] == 0u) ++first;
    return first;
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

uint smallest(uint number) {
    put(number);
    uint all = number;
    for (uint i = 0u; i < uint(lanes); ++i) all = min(all, exchange[i]);
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

// The subgroup's number in the work-group. All lanes take that of the first one: compilers that reckon gl_SubgroupID from
// the invocation cannot know that it is the same in all, and then take every branch on what is read from shared memory
// for one that may part the lanes.
uint subgroup_index;
#define SUBGROUP subgroup_index

// False when subgroups are not as many, or not of as many invocations in a row, as the kernel was made for.
bool enter_subgroup() {
    lane = gl_SubgroupInvocationID;
    const uint mine = gl_LocalInvocationID.x / uint(lanes);
    subgroup_index = subgroups == 1 ? 0u : subgroupBroadcastFirst(mine);
    return subgroupAll(mine == subgroup_index && gl_SubgroupSize == uint(lanes) && gl_NumSubgroups == uint(subgroups));
}

// Makes what the lanes have written to shared memory visible to all of the subgroup.
void share() {
    if (lockstep)
        subgroupMemoryBarrierShared();
    else
        controlBarrier(gl_ScopeSubgroup, gl_ScopeSubgroup, gl_StorageSemanticsShared, gl_SemanticsAcquireRelease);
}

uvec2 from_first_lane(uvec2 value) {
    return subgroupBroadcastFirst(value);
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

// The first lane that says so; `lanes` when there is none.
uint first_lane(bool yes) {
    const uvec4 ballot = subgroupBallot(yes);
    const uint low = uint(bitCount(~ballot.x & (ballot.x - 1u)));
    if (lanes == 32) return low;
    if (lanes < 32) return min(low, uint(lanes));
    return ballot.x != 0u ? low : 32u + uint(bitCount(~ballot.y & (ballot.y - 1u)));
}

uint sum(uint value) {
    return subgroupAdd(value);
}

uint all_bits(uint value) {
    return subgroupOr(value);
}

// The numbers must not be negative, nor -0: sums of squares never are. Then their bits are in the same order, and whole
// numbers are quicker on some devices.
float largest(float number) {
    return uintBitsToFloat(subgroupMax(floatBitsToUint(number)));
}

float smallest(float number) {
    return uintBitsToFloat(subgroupMin(floatBitsToUint(number)));
}

uint smallest(uint number) {
    return subgroupMin(number);
}

float sum(float value) {
    return subgroupAdd(value);
}

// Lanes are summed in pairs, then in pairs of pairs: a sum of two does not depend on their order, so that all lanes get
// the same one.
Number sum(Number value) {
    for (uint step = 1u; step < uint(lanes); step *= 2u) {
        const uvec2 words = words_of(value);
        value = plus(value, of_words(uvec2(subgroupShuffleXor(words.x, step), subgroupShuffleXor(words.y, step))));
    }
    return value;
}

#endif

#endif

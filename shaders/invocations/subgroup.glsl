// Operations of a subgroup. All lanes must call them. The .comp enables the GL_KHR_shader_subgroup extensions.
//
// Variant: LANES_OF_WORK_GROUP uses the invocations of a work-group instead, any number of them, through shared memory.
// So a device tests kernels for sizes of subgroups that it lacks.
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

uint from_lane(uint value, uint from) {
    put(value);
    return exchange[from];
}

bool alike(bool condition) {
    return condition;
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

// A function of the values of all lanes. bits, value_of: between a value and its word; both: of `all` before and `one`.
#define OVER_LANES(Value, function, bits, value_of, both)   \
    Value function(Value value) {                           \
        put(bits(value));                                   \
        Value all = value_of(exchange[0]);                  \
        for (uint i = 1u; i < uint(lanes); ++i) {           \
            const Value one = value_of(exchange[i]);        \
            all = both;                                     \
        }                                                   \
        return all;                                         \
    }
OVER_LANES(uint, sum, uint, uint, all + one)
OVER_LANES(uint, all_bits, uint, uint, all | one)
OVER_LANES(uint, smallest, uint, uint, min(all, one))
OVER_LANES(float, sum, floatBitsToUint, uintBitsToFloat, all + one)
OVER_LANES(float, largest, floatBitsToUint, uintBitsToFloat, max(all, one))
OVER_LANES(float, smallest, floatBitsToUint, uintBitsToFloat, min(all, one))

bool any_lane(bool yes) {
    return all_bits(yes ? 1u : 0u) != 0u;
}

float sum_in_pairs(float value) {
    return sum(value);
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

// The subgroup's number in the work-group, that of the first lane in all. Some compilers compute gl_SubgroupID from the
// invocation and do not know that it is the same in all lanes. They then treat every branch on shared memory as one
// that may part the lanes.
uint subgroup_index;
#define SUBGROUP subgroup_index

// Returns false when the kernel was made for another number of subgroups, or for another number of invocations in a
// row.
bool enter_subgroup() {
    lane = gl_SubgroupInvocationID;
    const uint mine = gl_LocalInvocationID.x / uint(lanes);
    subgroup_index = subgroups == 1 ? 0u : subgroupBroadcastFirst(mine);
    return subgroupAll(mine == subgroup_index && gl_SubgroupSize == uint(lanes) && gl_NumSubgroups == uint(subgroups));
}

// Makes the lanes' writes to shared memory visible to the whole subgroup.
void share() {
    if (lockstep)
        subgroupMemoryBarrierShared();
    else
        controlBarrier(gl_ScopeSubgroup, gl_ScopeSubgroup, gl_StorageSemanticsShared, gl_SemanticsAcquireRelease);
}

uvec2 from_first_lane(uvec2 value) {
    return subgroupBroadcastFirst(value);
}

uint from_lane(uint value, uint from) {
    return subgroupShuffle(value, from);
}

bool any_lane(bool yes) {
    return subgroupAny(yes);
}

// Returns a condition that is the same in all lanes. The vote proves that to compilers. Behind a branch on values from
// memory NVIDIA's compiler computes the set of active lanes before each operation of the subgroup.
bool alike(bool condition) {
    return subgroupAny(condition);
}

// Returns how many lanes before this one have a true condition; `count` is that of all lanes.
uint rank_among(bool yes, out uint count) {
    const uvec4 ballot = subgroupBallot(yes);
    count = subgroupBallotBitCount(ballot);
    return subgroupBallotExclusiveBitCount(ballot);
}

// Returns the first lane with a true condition; `lanes` when there is none.
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

// The numbers must not be negative or -0; sums of squares never are. Their bits then have the same order, and whole
// numbers are faster on some devices.
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

float sum_in_pairs(float value) {
    for (uint step = 1u; step < uint(lanes); step *= 2u) value += subgroupShuffleXor(value, step);
    return value;
}

// Sums lanes in pairs, then pairs of pairs. A sum of two does not depend on their order, so all lanes get the same sum.
Number sum(Number value) {
    for (uint step = 1u; step < uint(lanes); step *= 2u) {
        const uvec2 words = words_of(value);
        value = plus(value, of_words(uvec2(subgroupShuffleXor(words.x, step), subgroupShuffleXor(words.y, step))));
    }
    return value;
}

#endif

float from_lane(float value, uint from) {
    return uintBitsToFloat(from_lane(floatBitsToUint(value), from));
}
#ifdef CLIP_FLOAT64
double from_lane(double value, uint from) {
    const uvec2 both = unpackDouble2x32(value);
    return packDouble2x32(uvec2(from_lane(both.x, from), from_lane(both.y, from)));
}
#endif

#endif

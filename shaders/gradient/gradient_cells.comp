// gradient: what a frame's volumes and centroids contribute to the product of their derivatives with given vectors.
//
// A number L changes by g.dV + G.dC, where a cell has the volume V and the centroid C. When a face of the cell moves
// outward, L changes by the integral over the face of the motion times c + s.y, with y relative to the seed,
// s = G / V and c = g - s.(C - p). This pass writes s and c, and begins the gradient: 0, or NaN for cells whose rows
// are missing.
//
// Variant: FLOAT64 reads points, centroids and vectors for centroids in float64.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/gradient.h"
#include "shared/interface.h"

#ifdef FLOAT64
#define REAL double
#else
#define REAL float
#endif

layout(push_constant) uniform Push { GradientPush push; };
layout(std430, binding = BINDING_RAW) readonly buffer Raw { REAL raw[]; };
layout(std430, binding = BINDING_PART_INFO) readonly buffer Statuses { uint statuses[]; };
layout(std430, binding = BINDING_GEOMETRY) readonly buffer Volumes { float volumes[]; };
layout(std430, binding = BINDING_PART_GEOMETRY) readonly buffer Centroids { REAL centroids[]; };
layout(std430, binding = BINDING_GIVEN_VOLUMES) readonly buffer GivenVolumes { float given_volumes[]; };
layout(std430, binding = BINDING_GIVEN_CENTROIDS) readonly buffer GivenCentroids { REAL given_centroids[]; };
layout(std430, binding = BINDING_SLOPES) writeonly buffer Slopes { dvec4 slopes[]; };
layout(std430, binding = BINDING_GRADIENT) writeonly buffer Gradient { uint gradient[]; };

bool has(uint bit) {
    return (push.bits & bit) != 0u;
}

// In float64 the high word of a number is the second one.
void begin(uint number, uint high) {
    if (has(GRADIENT_FLOAT64)) {
        gradient[2u * number] = 0u;
        gradient[2u * number + 1u] = high;
    } else {
        gradient[number] = high;
    }
}

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.count) return;
    const uint status = statuses[cell];
    const bool has_none = status == STATUS_DUPLICATE || status == STATUS_EMPTY || status == STATUS_OUTSIDE;
    dvec4 slope = dvec4(0.0LF);
    if (has(GRADIENT_OF_VOLUMES)) slope.w = double(given_volumes[cell]);
    if (has(GRADIENT_OF_CENTROIDS)) {
        dvec3 given, from_seed;
        for (uint k = 0u; k < 3u; ++k) {
            given[k] = double(given_centroids[3u * cell + k]);
            from_seed[k] = double(centroids[3u * cell + k]) - double(raw[3u * cell + k]);
        }
        // A cell that is missing spoils its neighbors only where the number depends on its centroid, which is NaN.
        if (given != dvec3(0.0LF) && !has_none) {
            slope.xyz = given / double(volumes[cell]);
            slope.w -= dot(slope.xyz, from_seed);
        }
    }
    slopes[cell] = slope;
    const uint high = status == STATUS_CERTIFIED || has_none ? 0u : (has(GRADIENT_FLOAT64) ? 0x7ff80000u : 0x7fc00000u);
    for (uint k = 0u; k < 3u; ++k) begin(3u * cell + k, high);
    begin(push.weights_at + cell, high);
}

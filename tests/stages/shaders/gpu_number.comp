// For tests/stages/gpu/gpu_number.cpp: the arithmetic of shaders/numbers/number.glsl on given numbers.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "numbers/number.glsl"

layout(local_size_x_id = 0) in;
layout(push_constant) uniform Push { uint count; };
layout(std430, set = 0, binding = 2) readonly buffer Operands { Number operands[]; };
layout(std430, set = 0, binding = 5) writeonly buffer Results { Number results[]; };

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    const Number a = operands[2u * i], b = operands[2u * i + 1u];
    results[6u * i] = plus(a, b);
    results[6u * i + 1u] = minus(a, b);
    results[6u * i + 2u] = times(a, b);
    results[6u * i + 3u] = reciprocal(b);
    results[6u * i + 4u] = root(times(a, a));
    results[6u * i + 5u] = times_power(number64(words_of(a)), 0.25);
}

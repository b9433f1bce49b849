// For tests/stages/gpu/vulkan_layer.cpp. Variants: SCALE scales and adds; ARGUMENTS writes the group counts of an
// indirect dispatch; DOUBLES scales in double precision.
#version 450

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint factor = 1;
layout(constant_id = 2) const uint divisor = 1;

layout(push_constant) uniform Push {
    uint count;
    uint addend;
};
layout(std430, set = 0, binding = 2) readonly buffer Source { uint source[]; };
layout(std430, set = 0, binding = 5) buffer Target { uint target[]; };

void main() {
    const uint group = gl_WorkGroupID.x + gl_NumWorkGroups.x * (gl_WorkGroupID.y + gl_NumWorkGroups.y * gl_WorkGroupID.z);
    const uint i = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
#if defined(ARGUMENTS)
    if (i > 0) return;
    target[0] = (count + gl_WorkGroupSize.x - 1) / gl_WorkGroupSize.x;
    target[1] = 1;
    target[2] = 1;
#elif defined(DOUBLES)
    if (i >= count) return;
    target[i] = uint(double(source[i]) * (double(factor) / double(divisor))) + addend;
#else
    if (i >= count) return;
    // Adds to the buffer: an invocation that runs twice shows.
    target[i] += source[i] * factor / divisor + addend;
#endif
}

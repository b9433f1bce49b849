// clip: writes the arguments of the second tier's indirect dispatches.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(constant_id = CONSTANT_TODO_GROUP) const uint group = 64u;
layout(push_constant) uniform Push { ClipPush push; };
layout(std430, binding = BINDING_CHUNK_STATE) buffer Chunk { ChunkState chunk; };

void main() {
    if (gl_GlobalInvocationID.x != 0u) return;
    const uint cells = min(chunk.todo_count, push.todo_capacity);
    const uint groups = (cells + group - 1u) / group;
    chunk.groups_x = min(groups, 65535u);  // what every device can do
    chunk.groups_y = (groups + 65534u) / 65535u;
    chunk.groups_z = 1u;
}

// The size of work-groups, and the linear index of a work-group and of an invocation. Work-groups of a dispatch extend
// over x, y and z.
#ifndef VOTESS_INVOCATIONS_INDEX_GLSL
#define VOTESS_INVOCATIONS_INDEX_GLSL

#include "shared/interface.h"

layout(local_size_x_id = CONSTANT_LOCAL_SIZE) in;

uint linear_group() {
    return gl_WorkGroupID.x + gl_NumWorkGroups.x * (gl_WorkGroupID.y + gl_NumWorkGroups.y * gl_WorkGroupID.z);
}

uint linear_invocation() {
    return linear_group() * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}

#endif

// Number of this invocation in a dispatch whose work-groups are spread over x, y and z.
uint linear_group() {
    return gl_WorkGroupID.x + gl_NumWorkGroups.x * (gl_WorkGroupID.y + gl_NumWorkGroups.y * gl_WorkGroupID.z);
}

uint linear_invocation() {
    return linear_group() * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}

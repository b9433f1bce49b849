// A check that the driver ran all loops to their end.
#ifndef VOTESS_INVOCATIONS_LOOP_GUARD_GLSL
#define VOTESS_INVOCATIONS_LOOP_GUARD_GLSL

// Some drivers end loops early without an error. llvmpipe (Mesa 22.3) allows 65,535 iterations to all loops of an
// invocation together, then ends each after its first. After that this loop ends early too. Call it after the last loop
// whose result matters, with a number of at least 2 that the compiler does not know.
bool loops_were_cut_short(uint at_least_two) {
    uint iterations = 0u;
    for (uint i = 0u; i < at_least_two; ++i) ++iterations;
    return iterations != at_least_two;
}

#endif

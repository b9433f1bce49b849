// A check that the driver has run all loops to their end.
#ifndef VOTESS_INVOCATIONS_LOOP_GUARD_GLSL
#define VOTESS_INVOCATIONS_LOOP_GUARD_GLSL

// Some drivers end loops early without a word: llvmpipe (Mesa 22.3) lets all loops of an invocation together have 65,535
// iterations, then leaves each after its first. Once that has happened this loop is cut short too. Call it after the
// last loop whose result matters, with a number of at least 2 that the compiler cannot know.
bool loops_were_cut_short(uint at_least_two) {
    uint iterations = 0u;
    for (uint i = 0u; i < at_least_two; ++i) ++iterations;
    return iterations != at_least_two;
}

#endif

// Functions that are compiled for a set of instructions of their own, in the words of each compiler.
#pragma once

#ifdef __clang__
#define VOTESS_TARGET_512(instructions) __attribute__((target(instructions), min_vector_width(512)))
#else  // whose usual tuning would split vectors of 512 bits
#define VOTESS_TARGET_512(instructions) __attribute__((target(instructions ",prefer-vector-width=512")))
#endif

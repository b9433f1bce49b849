// What the process takes from the system.
#pragma once

#include <sys/resource.h>

#include <cstdint>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace votess {

// Largest resident memory of the process so far, in bytes.
inline std::uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
#if defined(__APPLE__)
    return static_cast<std::uint64_t>(usage.ru_maxrss);
#else
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
#endif
}

// Gives back what has been freed. Without it memory of one size is kept while that of the next is taken.
inline void give_back_memory() {
#if defined(__GLIBC__)
    (void)malloc_trim(0);
#endif
}

}  // namespace votess

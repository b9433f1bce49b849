#pragma once

#include <sys/resource.h>

#include <cstdint>

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

}  // namespace votess

// The identity and the memory of the process.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>
#include <unistd.h>

#include <cstdint>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace votess {

// The process that made an object. A child made by fork() has its memory but not its threads and devices, and may
// neither use nor end them.
class HomeProcess {
public:
    [[nodiscard]] bool is_this() const { return id_ == ::getpid(); }

private:
    pid_t id_ = ::getpid();
};

// In bytes, resident.
inline std::uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
#if defined(__APPLE__)
    return static_cast<std::uint64_t>(usage.ru_maxrss);
#else
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
#endif
}

// Returns freed memory to the system. Otherwise memory of one size is kept while another size is allocated.
inline void give_back_memory() {
#if defined(__GLIBC__)
    (void)malloc_trim(0);
#endif
}

}  // namespace votess

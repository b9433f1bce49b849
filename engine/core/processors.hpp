#pragma once

namespace votess::system {

// Returns the number of logical processors that the calling thread may use, at least 1: those of its affinity mask
// (taskset, cpusets of containers, MPI's binding). Defined in system.cpp.
[[nodiscard]] unsigned processors();

}  // namespace votess::system

// Disk space of files.
#pragma once

#include <cstdint>

#include "core/system.hpp"

namespace votess::system {

// Returns the disk space of some bytes, which read as 0 then. From any thread. Returns false where that is not
// possible: on some systems and file systems.
[[nodiscard]] bool release_disk_space(const File& file, std::uint64_t position, std::uint64_t bytes);

}  // namespace votess::system

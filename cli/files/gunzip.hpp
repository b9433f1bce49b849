// Files packed by gzip.
#pragma once

#include <string>
#include <string_view>

namespace clvotess {

// Returns what all members of the file hold, one after the other. Throws Failure, which names the file, when it is
// damaged.
[[nodiscard]] std::string gunzip(std::string_view packed, const std::string& name);

}  // namespace clvotess

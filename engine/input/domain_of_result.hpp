// The domain of a result, for functions that take one.
#pragma once

#include <string>

#include "votess/votess.hpp"

namespace votess {

// Returns box or cell, periodic axes and walls, without weights. Seeds outside are dropped.
Options domain_options(const Tessellation& tessellation);

// Throws invalid_argument for the cells of probes, which do not form a diagram. function: for the message.
void require_whole_diagram(const Tessellation& tessellation, const std::string& function);

}  // namespace votess

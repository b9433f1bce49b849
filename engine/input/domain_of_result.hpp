// What functions of a result ask about where it comes from.
#pragma once

#include <string>

#include "votess/votess.hpp"

namespace votess {

// Box or cell, periodic axes and walls; seeds outside are dropped, as they were if there were any. Without weights.
Options domain_options(const Tessellation& tessellation);

// Throws invalid_argument for the cells of probes, which do not fit together. function: for the message.
void require_whole_diagram(const Tessellation& tessellation, const std::string& function);

}  // namespace votess

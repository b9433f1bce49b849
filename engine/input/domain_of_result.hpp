// The domain of a result, as options of another run.
#pragma once

#include "votess/votess.hpp"

namespace votess {

// Box or cell, periodic axes and walls; seeds outside are dropped, as they were if there were any. Without weights.
Options domain_options(const Tessellation& tessellation);

}  // namespace votess

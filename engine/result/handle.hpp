// The result behind a handle.
#pragma once

#include <memory>

#include "result/result.hpp"

namespace votess::detail {

// Returns the result, or one without cells for null: a handle that was moved from has none. Throws bad_alloc only at
// the first call of the process.
[[nodiscard]] const Result& result_of(const std::shared_ptr<const Result>& handle);

}  // namespace votess::detail

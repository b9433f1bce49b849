// The result behind a handle.
#pragma once

#include <memory>

#include "result/result.hpp"

namespace votess::detail {

// Returns the result, or one without cells for null: a handle that was moved from has none. Throws bad_alloc only at
// the first call of the process.
[[nodiscard]] inline const Result& result_of(const std::shared_ptr<const Result>& handle) {
    static const Result none = [] {
        Result empty;
        empty.indptr.resize_uninitialized(1);
        empty.indptr[0] = 0;
        return empty;
    }();
    return handle ? *handle : none;
}

}  // namespace votess::detail

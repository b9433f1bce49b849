// The result behind a handle.
#pragma once

#include "result/result.hpp"

namespace votess::detail {

struct ResultOf {
    // Returns the result, or one without cells for a handle that was moved from. Throws bad_alloc only at the first
    // call of the process.
    [[nodiscard]] static const Result& handle(const Tessellation& tessellation) {
        static const Result none = [] {
            Result empty;
            empty.indptr.resize_uninitialized(1);
            empty.indptr[0] = 0;
            return empty;
        }();
        return tessellation.result_ ? *tessellation.result_ : none;
    }
};
[[nodiscard]] inline const Result& result_of(const Tessellation& tessellation) {
    return ResultOf::handle(tessellation);
}

}  // namespace votess::detail

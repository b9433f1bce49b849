#include "result/handle.hpp"

namespace votess::detail {

const Result& result_of(const std::shared_ptr<const Result>& handle) {
    static const Result none = [] {
        Result empty;
        empty.indptr.resize_uninitialized(1);
        empty.indptr[0] = 0;
        return empty;
    }();
    return handle ? *handle : none;
}

}  // namespace votess::detail

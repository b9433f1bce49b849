// The rows of the last call. Most rows of kept cells are the same, so that many are copied at once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/buffer.hpp"

namespace votess::cpu {

class KeptRows {
public:
    void clear() { exist_ = false; }
    // Whether there are rows of so many seeds, which list walls or not.
    [[nodiscard]] bool are_of(std::size_t seeds, bool list_walls) const {
        return exist_ && indptr_.size() == seeds + 1 && list_walls_ == list_walls;
    }
    void store(std::span<const std::int64_t> indptr, std::span<const std::int32_t> indices,
               std::span<const std::int8_t> shifts, bool list_walls) {
        copy(indptr, indptr_);
        copy(indices, indices_);
        copy(shifts, shifts_);
        list_walls_ = list_walls;
        exist_ = true;
    }
    [[nodiscard]] std::uint32_t length(std::size_t seed) const {
        return static_cast<std::uint32_t>(indptr_[seed + 1] - indptr_[seed]);
    }
    struct Rows {
        std::span<const std::int32_t> ids;
        std::span<const std::int8_t> shifts;  // three of each id, in a periodic domain
    };
    // Returns the rows of some seeds, in input order.
    [[nodiscard]] Rows rows(std::size_t begin, std::size_t end) const {
        const auto first = static_cast<std::size_t>(indptr_[begin]),
                   size = static_cast<std::size_t>(indptr_[end]) - first;
        const std::span<const std::int8_t> shifts = shifts_;
        return {std::span<const std::int32_t>(indices_).subspan(first, size),
                shifts.empty() ? shifts : shifts.subspan(3 * first, 3 * size)};
    }

private:
    template <class T>
    static void copy(std::span<const T> from, Buffer<T>& to) {
        to.resize_uninitialized(from.size());
        std::ranges::copy(from, to.begin());
    }

    bool exist_ = false, list_walls_ = false;
    Buffer<std::int64_t> indptr_{Buffer<std::int64_t>::Pages::huge};
    Buffer<std::int32_t> indices_{Buffer<std::int32_t>::Pages::huge};
    Buffer<std::int8_t> shifts_{Buffer<std::int8_t>::Pages::huge};
};

}  // namespace votess::cpu

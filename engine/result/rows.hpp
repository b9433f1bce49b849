// The rows of a result as lists of named faces.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>

namespace votess {

// The name of a face in a row. Rows are ordered by it.
struct FaceLabel {
    std::int32_t id = 0;  // of the neighbor, or a wall
    std::array<std::int8_t, 3> shift{};

    friend auto operator<=>(const FaceLabel&, const FaceLabel&) = default;
    // Returns the label of the same face in the row of the neighbor, if this is a label of cell i.
    [[nodiscard]] FaceLabel seen_from_behind(std::size_t i) const {
        FaceLabel back{static_cast<std::int32_t>(i), {}};
        for (std::size_t k = 0; k < 3; ++k) back.shift[k] = static_cast<std::int8_t>(-shift[k]);
        return back;
    }
};

// Arrays as those of Tessellation.
struct Rows {
    std::span<const std::int64_t> indptr;
    std::span<const std::int32_t> indices;
    std::span<const std::int8_t> shifts;  // empty when not periodic

    [[nodiscard]] std::size_t begin(std::size_t row) const { return static_cast<std::size_t>(indptr[row]); }
    [[nodiscard]] std::size_t end(std::size_t row) const { return static_cast<std::size_t>(indptr[row + 1]); }
    [[nodiscard]] FaceLabel label(std::size_t entry) const {
        FaceLabel label{indices[entry], {}};
        if (!shifts.empty()) std::ranges::copy(shifts.subspan(3 * entry, 3), label.shift.begin());
        return label;
    }
    // The entry of a row with that label, or the row's end.
    [[nodiscard]] std::size_t find(std::size_t row, const FaceLabel& wanted) const {
        std::size_t low = begin(row), high = end(row);
        while (low < high) {
            const std::size_t half = (low + high) / 2;
            if (label(half) < wanted)
                low = half + 1;
            else
                high = half;
        }
        return low < end(row) && label(low) == wanted ? low : end(row);
    }
};

}  // namespace votess

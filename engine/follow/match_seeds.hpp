// Which points are seeds of an earlier call, where some have come or gone, or rows have changed places.
//
// The choice is a guess by their places. Matched cells are tested as all others, so a wrong guess costs time only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "follow/sign_test.hpp"

namespace votess::cpu {

struct KeptSeeds {                       // of the earlier call, by sorted seed
    std::span<std::byte* const> cells;   // records, or null
    std::span<const std::int32_t> rows;  // indices in the input
    const SignFrame& frame;              // with their places, and the present domain
};

struct MatchedSeeds {
    std::vector<std::int32_t> order;   // rows of the points, in the order of the earlier seeds; new ones beside them
    std::vector<std::int32_t> number;  // by earlier seed: its place in `order`, or -1
};

// rows: of the points in the domain. now: their places. same_rows: those of the earlier seeds. Returns none where a
// sample shows that points are not near seeds, or that they are so in the same rows.
[[nodiscard]] std::optional<MatchedSeeds> match_seeds(const KeptSeeds& before, std::span<const std::int32_t> rows,
                                                      bool same_rows,
                                                      const std::function<std::array<double, 3>(std::size_t row)>& now);

}  // namespace votess::cpu

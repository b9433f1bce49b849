// Whole steps that cover a length.
#pragma once

#include <concepts>
#include <type_traits>

namespace votess {

template <std::integral A, std::integral B>
constexpr std::common_type_t<A, B> ceil_div(A length, B step) {
    return length / step + (length % step != 0);
}
template <std::integral A, std::integral B>
constexpr std::common_type_t<A, B> round_up(A length, B step) {
    return ceil_div(length, step) * step;
}

}  // namespace votess

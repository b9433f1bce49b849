// A long list is made in pieces, between which the user may stop.
#pragma once

#include <cstddef>
#include <vector>

#include "core/progress.hpp"

namespace votess {

// Appends copies of `value` until the list has `size` elements.
template <class T>
void lengthen(std::vector<T>& list, std::size_t size, const T& value = {}) {
    list.reserve(size);
    const std::size_t first = list.size();
    if (first < size) in_pieces(size - first, [&](std::size_t, std::size_t end) { list.resize(first + end, value); });
}

}  // namespace votess

// Vectors in huge pages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/system.hpp"

namespace votess {

// Reserves room for `count` elements. Where that is much, huge pages save most of the time of the page faults.
template <class T>
void reserve_in_huge_pages(std::vector<T>& values, std::size_t count) {
    values.reserve(count);
    const auto begin = reinterpret_cast<std::uintptr_t>(values.data());
    const std::uintptr_t first = round_up(begin, system::huge_page), end = begin + sizeof(T) * values.capacity();
    if (first + system::huge_page <= end)
        system::prefer_huge_pages(reinterpret_cast<void*>(first),
                                  (end - first) / system::huge_page * system::huge_page);
}

template <class T>
void resize_in_huge_pages(std::vector<T>& values, std::size_t count) {
    reserve_in_huge_pages(values, count);
    values.resize(count);
}

}  // namespace votess

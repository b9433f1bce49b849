// Comparisons and copies of the arrays of results, by the table of the library: a new array is in all of them.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <votess/row_arrays.hpp>

namespace test {

// Whether two numbers are equal; NaN equals NaN.
inline constexpr auto same_number = [](auto a, auto b) { return a == b || (a != a && b != b); };
// Whether they are equal bit for bit.
inline constexpr auto same_bits = [](auto a, auto b) {
    if constexpr (std::is_same_v<decltype(a), double>)
        return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
    else
        return a == b;
};

// Calls visit(array) for the arrays that both have. Each is a Tessellation, or has RowArrays or more of them.
template <class A, class B, class Visit>
void for_common_arrays(A& a, B& b, const Visit& visit) {
    votess::for_all_arrays([&](const auto& array) {
        if constexpr (requires { array.of(a), array.of(b); }) visit(array);
    });
}

// Returns the name of the first array that differs, "" for none.
template <class A, class B, class Same = decltype(same_number)>
std::string different_array(const A& a, const B& b, const Same& same = same_number) {
    std::string differs;
    for_common_arrays(a, b, [&](const auto& array) {
        if (differs.empty() && !std::ranges::equal(array.of(a), array.of(b), same)) differs = array.name;
    });
    return differs;
}

// Returns the name of the first array of cells or entries that differs between cell k of some rows and cell i of a
// whole result, "" for none.
template <class Rows>
std::string different_cell(const Rows& rows, std::size_t k, const votess::Tessellation& t, std::size_t i) {
    const auto starts_of = [](const auto& of) {
        if constexpr (requires { of.indptr(); })
            return of.indptr();
        else
            return std::span<const std::int64_t>(of.indptr);
    };
    const auto part = [&](const auto& array, const auto& of, std::size_t cell) {
        const std::span values(array.of(of));
        const std::size_t each = components_of(array, t.planar());
        if (values.empty()) return values;
        if (array.per == votess::Per::cell) return values.subspan(each * cell, each);
        const auto begin = static_cast<std::size_t>(starts_of(of)[cell]),
                   end = static_cast<std::size_t>(starts_of(of)[cell + 1]);
        return values.subspan(each * begin, each * (end - begin));
    };
    std::string differs;
    for_common_arrays(rows, t, [&](const auto& array) {
        if (!differs.empty() || array.name == "ids") return;
        if (array.per != votess::Per::cell && array.per != votess::Per::entry) return;
        const auto a = part(array, rows, k);
        const auto b = part(array, t, i);
        // Without duplicates the array may be empty.
        const bool equal = array.name == "duplicate_of" ? same_number(a.empty() ? -1 : static_cast<std::int64_t>(a[0]),
                                                                      b.empty() ? -1 : static_cast<std::int64_t>(b[0]))
                                                        : std::ranges::equal(a, b, same_number);
        if (!equal) differs = array.name;
    });
    return differs;
}

// Copies the arrays that both have.
template <class To>
void copy_arrays(const votess::Tessellation& from, To& to) {
    for_common_arrays(from, to, [&](const auto& array) {
        const auto values = array.of(from);
        auto& copy = array.of(to);
        if constexpr (requires { copy.resize_uninitialized(0); })
            copy.resize_uninitialized(values.size());
        else
            copy.resize(values.size());
        std::ranges::copy(values, copy.begin());
    });
}

}  // namespace test

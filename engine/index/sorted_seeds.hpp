#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/buffer.hpp"
#include "index/lift.hpp"

namespace votess::cpu {

inline constexpr std::size_t group_size = 8;  // consecutive seeds that share a candidate window

class SeedImages;

struct SortedSeeds {
    // Scaled coordinates of M seeds without duplicates, then those of images, each padded to whole groups. Accessed at
    // random, hence huge pages.
    static constexpr auto pages = Buffer<double>::Pages::huge;
    Buffer<double> x{pages}, y{pages}, z{pages};
    Buffer<std::int32_t> input;              // M: index in the input
    std::vector<std::int32_t> duplicate_of;  // N if there are duplicates, else empty; -1 for seeds that have a cell
    std::size_t duplicates = 0;
    const SeedImages* images = nullptr;  // of a periodic domain, else null
    std::size_t images_end = 0;          // behind the last image, in a periodic domain
    std::vector<double> weights;         // of all places in a power diagram, padding too; else empty
    Lift lift;                           // of the weights, if some seeds lie outside of the domain
    std::vector<bool> beyond;            // M if some lie outside of the domain: whether a seed does

    [[nodiscard]] std::size_t size() const { return input.size(); }  // M
    [[nodiscard]] std::size_t places() const { return x.size(); }
    [[nodiscard]] bool is_beyond(std::size_t seed) const { return !beyond.empty() && beyond[seed]; }
    [[nodiscard]] std::size_t group_end(std::size_t begin) const {
        const std::size_t end = begin + group_size;
        return begin < size() ? std::min(end, size()) : std::min(end, images_end);
    }
};

}  // namespace votess::cpu

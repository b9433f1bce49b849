// The host's work on a part's cells: converts measures to the units of the input and gives rows to the result builder.
// Knows no Vulkan, so that tools/bench/gpu/gpu_host.cpp can feed it with made-up cells.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "output/exact_clipper.hpp"
#include "output/result_builder.hpp"
#include "shared/config.h"

namespace votess::gpu {

// An array of Number, see shaders/numbers/number.glsl.
struct Numbers {
    std::span<const std::byte> bytes;
    bool float64 = true;

    static constexpr std::size_t each = 8;  // bytes
    [[nodiscard]] double operator[](std::size_t i) const;
    [[nodiscard]] Numbers from(std::size_t first) const { return {bytes.subspan(first * each), float64}; }
};

// Rows of consecutive members, one after the other.
struct DeviceRows {
    std::size_t first = 0;                   // member
    std::span<const std::uint32_t> lengths;  // of each
    std::span<const std::int32_t> ids;
    Numbers areas;                        // of each id when requested, in squares of the cells' own units
    std::span<const std::int8_t> shifts;  // 3 of each id in a periodic domain
};

// Cells in the order of their part's members.
class HostCells {
public:
    static constexpr std::size_t numbers_each = 4;  // of the geometry of a cell: volume and centroid

    // The input of all calls, which must outlive them. members: input indices; empty when they are 0, 1 ...
    struct Source {
        const Job* job = nullptr;
        ResultBuilder* result = nullptr;
        ThreadPool* pool = nullptr;
        std::span<const std::int32_t> members;
        std::span<const std::array<double, 3>> wraps;  // by input index: translation of a centroid; or empty
        int shift = 0;                                 // Units::shift
        std::span<const std::uint32_t> info;           // by member, see INFO_ in config.h
    };
    explicit HostCells(const Source& source)
        : s_(source), flat_(s_.job->region.thickness > 0 ? std::ilogb(s_.job->region.thickness) : 0) {}

    // Reports the cells that are certainly empty.
    void set_empty() const;
    // Stores volumes, centroids and counts of the certified cells among `count` members from `first` on. geometry:
    // theirs, when requested.
    void finish(std::size_t first, std::size_t count, const Numbers& geometry) const;
    // Copies rows to their final place, after ResultBuilder::settle(); members must be 0, 1 ...
    void place(const DeviceRows& rows) const;
    // Gives rows to the builder, which keeps them until it has all.
    void keep(const DeviceRows& rows) const;
    // Makes the certified cells from their rows by the exact clipper.
    void clip(const DeviceRows& rows, ExactClipper& clipper, const Share& share) const;

private:
    [[nodiscard]] std::int32_t input_of(std::size_t member) const {
        return s_.members.empty() ? static_cast<std::int32_t>(member) : s_.members[member];
    }
    [[nodiscard]] bool is_certified(std::size_t member) const { return (s_.info[member] & 0xff) == STATUS_CERTIFIED; }
    [[nodiscard]] int exponent_of(std::size_t member) const {
        return static_cast<int>(s_.info[member] >> INFO_EXPONENT_SHIFT) - s_.shift;
    }
    void measure(std::size_t member, const Numbers& geometry) const;
    // Calls task(first, lengths, ids, values) for some rows at a time, on all threads.
    void for_blocks_of(const DeviceRows& rows, const auto& task) const;

    Source s_;
    int flat_;  // exponent of the thickness of a sheet, see MeasureUnit
};

}  // namespace votess::gpu

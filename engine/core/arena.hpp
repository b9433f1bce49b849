// Memory allocated piece by piece from large segments and freed all at once.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/buffer.hpp"

namespace votess {

class Arena {
public:
    // Frees all pieces. New segments have at least this size.
    void reset(std::size_t segment_bytes) {
        segment_bytes_ = segment_bytes;
        current_ = used_ = 0;
    }
    // Returns uninitialized memory, aligned for any number, valid until reset().
    [[nodiscard]] std::byte* allocate(std::size_t bytes) {
        while (current_ < segments_.size() && segments_[current_].size() - used_ < bytes) {
            ++current_;
            used_ = 0;
        }
        if (current_ == segments_.size()) {
            Buffer<std::byte> segment(Buffer<std::byte>::Pages::huge);
            // room for a slightly larger piece in the next use
            segment.resize_uninitialized(std::max(segment_bytes_, std::bit_ceil(bytes + bytes / 8)));
            segments_.push_back(std::move(segment));
        }
        std::byte* const place = segments_[current_].data() + used_;
        constexpr std::size_t alignment = 8;
        used_ = std::min(segments_[current_].size(), round_up(used_ + bytes, alignment));
        return place;
    }

    // Returns large memory to the system but keeps its addresses. The contents are lost.
    void release_pages() {
        std::size_t bytes = 0;
        for (const auto& segment : segments_) bytes += segment.size();
        for (auto& segment : segments_) segment.release_pages(bytes >= Buffer<std::byte>::min_released ? 0 : bytes + 1);
    }

private:
    std::vector<Buffer<std::byte>> segments_;
    std::size_t segment_bytes_ = 0;
    std::size_t current_ = 0, used_ = 0;
};

}  // namespace votess

// Memory allocated piece by piece from large segments and freed all at once.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/buffer.hpp"
#include "core/page_stock.hpp"

namespace votess {

class Arena {
public:
    // Frees all pieces. New segments have at least this size. stock: where they come from while it has some; may be
    // null.
    void reset(std::size_t segment_bytes, PageStock* stock = nullptr) {
        segment_bytes_ = segment_bytes;
        stock_ = stock;
        next_own_ = 0;
        used_.clear();
        room_ = {};
    }
    // Returns uninitialized memory, aligned for any number, valid until reset().
    [[nodiscard]] std::byte* allocate(std::size_t bytes) {
        if (room_.size() < bytes) used_.push_back(room_ = next_segment(bytes));
        std::byte* const place = room_.data();
        constexpr std::size_t alignment = 8;
        room_ = room_.subspan(std::min(room_.size(), round_up(bytes, alignment)));
        return place;
    }

    // Gives the room behind the last piece to the stock. No more pieces until reset().
    void give_rest() {
        if (room_.empty()) return;
        used_.back() = used_.back().first(used_.back().size() - room_.size());
        stock_->put(std::exchange(room_, {}));
    }
    // Gives all pieces.
    void give_all() {
        give_rest();
        for (const auto& segment : used_) stock_->put(segment);
        used_.clear();
    }

    // Returns large memory to the system but keeps its addresses. The contents are lost.
    void release_pages() {
        std::size_t bytes = 0;
        for (const auto& segment : segments_) bytes += segment.size();
        for (auto& segment : segments_) segment.release_pages(bytes >= system::min_released ? 0 : bytes + 1);
    }

private:
    std::span<std::byte> next_segment(std::size_t bytes) {
        while (next_own_ < segments_.size() && segments_[next_own_].size() < bytes) ++next_own_;
        if (next_own_ == segments_.size()) {
            if (stock_ != nullptr)
                if (const auto taken = stock_->take(std::max(segment_bytes_, bytes), bytes); !taken.empty())
                    return taken;
            Buffer<std::byte> segment(Buffer<std::byte>::Pages::huge);
            // room for a slightly larger piece in the next use
            segment.resize_uninitialized(std::max(segment_bytes_, std::bit_ceil(bytes + bytes / 8)));
            segments_.push_back(std::move(segment));
        }
        return segments_[next_own_++];
    }

    std::vector<Buffer<std::byte>> segments_;  // its own
    std::size_t next_own_ = 0;
    std::vector<std::span<std::byte>> used_;  // segments with pieces
    std::span<std::byte> room_;               // behind the last piece
    std::size_t segment_bytes_ = 0;
    PageStock* stock_ = nullptr;
};

}  // namespace votess

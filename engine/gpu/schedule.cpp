#include "gpu/schedule.hpp"

#include <algorithm>

#include "shared/config.h"

namespace votess::gpu {
namespace {

constexpr double hopeless = 0.9;    // share of the cells left to the CPU
constexpr double many_ties = 0.02;  // share of uncertain cells: without ties far fewer are
constexpr std::uint32_t max_skipped = 31, enough_to_judge = 256;

bool is_many(std::uint64_t ties, std::uint64_t cells) {
    return static_cast<double>(ties) > many_ties * static_cast<double>(cells);
}

}  // namespace

Schedule::Schedule(std::uint32_t seeds, std::uint32_t window) : seeds_(seeds), window_(std::max(window, 1u)) {}

std::optional<Piece> Schedule::next(std::uint32_t most) {
    if (first_ == seeds_) return std::nullopt;
    const std::uint32_t at = first_ % window_;
    if (at == 0 && !repeated_) begin_window();
    repeated_ = false;
    const std::uint32_t rest = std::min(window_ - at, seeds_ - first_);
    Piece piece{first_, rest, !leave_, trial_ && at == 0, second_tier_, ties_};
    if (piece.trial)
        piece.count = std::min(rest, trial_cells);
    else if (piece.on_device)  // tiles of the second tier's list begin with a piece
        piece.count = std::min(rest, most > TILE_ITEMS ? most / TILE_ITEMS * TILE_ITEMS : std::max(most, 1u));
    first_ += piece.count;
    return piece;
}

bool Schedule::repeat_with_ties(const Piece& piece, std::size_t uncertain) {
    if (!piece.trial || piece.ties || !is_many(uncertain, piece.count)) return false;
    first_ = piece.first;
    return ties_ = repeated_ = true;
}

void Schedule::note(const Piece& piece, std::size_t cells, std::size_t left_by_first, std::size_t left,
                    std::size_t uncertain) {
    const Tally tally{cells, left_by_first, left, uncertain, piece.second_tier, piece.ties};
    if (piece.trial) {
        judge_second_tier(tally);
        judge(tally);
        leave_ = skip_ > 0;
        return;
    }
    Tally& sum = tallies_[piece.first / window_];
    sum.cells += tally.cells;
    sum.left_by_first += tally.left_by_first;
    sum.left += tally.left;
    sum.uncertain += tally.uncertain;
    sum.second_tier = tally.second_tier;
    sum.ties = tally.ties;
}

void Schedule::begin_window() {
    // Not the last window, at which the device may still work.
    if (tallies_.size() >= 2 && tallies_[tallies_.size() - 2].cells > 0) {
        const Tally& done = tallies_[tallies_.size() - 2];
        if (!done.ties && is_many(done.uncertain, done.cells)) ties_ = true;
        if (done.ties == ties_) {
            judge_second_tier(done);
            if (skip_ == 0) judge(done);
        }
    }
    tallies_.emplace_back();
    leave_ = skipped_ < skip_;
    trial_ = !leave_ && (skip_ > 0 || first_ == 0);
    skipped_ = leave_ ? skipped_ + 1 : 0;
}

void Schedule::judge(const Tally& tally) {
    const bool is_hopeless = static_cast<double>(tally.left) > hopeless * static_cast<double>(tally.cells);
    skip_ = is_hopeless ? std::min(2 * skip_ + 1, max_skipped) : 0;
}

void Schedule::judge_second_tier(const Tally& tally) {
    const auto of_first = static_cast<double>(tally.left_by_first);
    if (tally.second_tier && tally.cells >= enough_to_judge && of_first > 0.5 * static_cast<double>(tally.cells) &&
        static_cast<double>(tally.left) > hopeless * of_first)
        second_tier_ = false;
}

}  // namespace votess::gpu

// Rows of sorted seeds in half the memory. Neighbors are near along the curve too, so most are a difference of 16 bits.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/buffer.hpp"

namespace votess {

// Rows of one or more entries. A row is the step from the place of the last row's seed to that of its own, at first
// from 0, then the steps from there to its neighbors. Where a step is `far`, the next of `others` is in its place: the
// place of the seed, or the name of the neighbor (an input index or wall).
struct NearRows {
    static constexpr std::int16_t far = std::numeric_limits<std::int16_t>::min();
    static constexpr std::int32_t longest_step = std::numeric_limits<std::int16_t>::max();

    std::span<const std::int16_t> steps;
    std::span<const std::int32_t> others;
    const std::int32_t* input = nullptr;  // names by place
};

class NearReader {
public:
    explicit NearReader(const NearRows& rows)
        : step_(rows.steps.data()), other_(rows.others.data()), input_(rows.input) {}
    // Writes the names of the next row.
    void read(std::int32_t* names, std::size_t length) {
        const std::int16_t by = *step_++;
        place_ = by == NearRows::far ? *other_++ : place_ + by;
        const std::int32_t *const near = input_ + place_, *other = other_;  // `names` might be members
        const std::int16_t* const steps = step_;
        for (std::size_t j = 0; j < length; ++j) names[j] = steps[j] == NearRows::far ? *other++ : near[steps[j]];
        step_ += length;
        other_ = other;
    }

private:
    const std::int16_t* step_;
    const std::int32_t *other_, *input_;
    std::int32_t place_ = 0;
};

class NearWriter {
public:
    void clear() {
        size_ = 0;
        others_.clear();
        place_ = 0;
    }
    // Returns room for the steps of the next row, to be filled before any other call except add_other().
    std::int16_t* add_row(std::int32_t place, std::size_t length) {
        if (size_ + length + 1 > steps_.size()) grow(size_ + length + 1);
        const std::int32_t by = place - place_;
        place_ = place;
        steps_[size_] = step(by);
        if (steps_[size_] == NearRows::far) others_.push_back(place);
        std::int16_t* const row = steps_.data() + size_ + 1;
        size_ += length + 1;
        return row;
    }
    // The name that belongs to the next step that is `far`.
    void add_other(std::int32_t name) { others_.push_back(name); }
    [[nodiscard]] static std::int16_t step(std::int32_t by) {
        const bool is_near = by >= -NearRows::longest_step && by <= NearRows::longest_step;
        return is_near ? static_cast<std::int16_t>(by) : NearRows::far;
    }
    [[nodiscard]] NearRows rows(const std::int32_t* input) const {
        return {std::span(steps_).first(size_), others_, input};
    }

private:
    void grow(std::size_t size) {
        Buffer<std::int16_t> larger;
        larger.resize_uninitialized(std::max(first_size, 2 * size));
        std::copy_n(steps_.data(), size_, larger.data());
        steps_ = std::move(larger);
    }

    static constexpr std::size_t first_size = std::size_t{1} << 17;  // memory costs nothing until it is touched
    Buffer<std::int16_t> steps_;
    std::size_t size_ = 0;
    std::vector<std::int32_t> others_;
    std::int32_t place_ = 0;  // of the last row
};

}  // namespace votess

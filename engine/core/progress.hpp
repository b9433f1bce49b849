// The user's progress callback as engines call it: at most some ten times a second, with growing fractions.
#pragma once

#include <algorithm>
#include <chrono>
#include <utility>

#include "votess/votess.hpp"

namespace votess {

// A part of a run, as fractions of the whole.
struct Share {
    double begin = 0, end = 1;
    [[nodiscard]] double at(std::size_t done, std::size_t total) const {
        return begin + (end - begin) * static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(total, 1));
    }
};

inline constexpr Share clipping{0.05, 0.95};  // of a run: before it seeds are sorted, after it rows are put in place

class Progress {
public:
    Progress() = default;
    explicit Progress(ProgressCallback callback) : callback_(std::move(callback)) {}

    // Whether anybody listens.
    explicit operator bool() const { return static_cast<bool>(callback_); }
    // False when the user asks to stop. Costs a look at the clock when called too often.
    [[nodiscard]] bool going_on(double fraction) {
        if (!callback_) return true;
        const auto now = std::chrono::steady_clock::now();
        if (now - last_ < interval) return true;
        last_ = now;
        return callback_(fraction);
    }
    // Calls in any case: for the beginning, the end and between stages.
    void report(double fraction) {
        if (!callback_) return;
        last_ = std::chrono::steady_clock::now();
        require(callback_(fraction));
    }
    static void require(bool going_on) {
        if (!going_on) throw Error(ErrorCode::cancelled, "cancelled by the progress callback");
    }

private:
    static constexpr std::chrono::milliseconds interval{100};
    ProgressCallback callback_;
    std::chrono::steady_clock::time_point last_{};  // long ago: the first call goes through, however short the run
};

}  // namespace votess

// The user's progress callback, and how long loops learn that the user wants to stop.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

// A part of a run, as fractions of the whole.
struct Share {
    double begin = 0, end = 1;
    [[nodiscard]] double at(double fraction) const { return begin + (end - begin) * fraction; }
    [[nodiscard]] double at(std::size_t done, std::size_t total) const {
        return at(static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(total, 1)));
    }
    [[nodiscard]] Share part(double from, double to) const { return {at(from), at(to)}; }
};

inline constexpr Share clipping{0.05, 0.95};  // of a run: seeds are sorted before it, rows put in place after it

class Progress {
public:
    Progress() = default;
    explicit Progress(ProgressCallback callback) : callback_(std::move(callback)) {}

    explicit operator bool() const { return static_cast<bool>(callback_); }
    // Returns false when the user asks to stop. Calls back about ten times a second, with fractions that never fall.
    // Other calls cost a look at the clock.
    [[nodiscard]] bool going_on(double fraction);
    // Makes going_on() wait an interval, as after a call.
    void postpone() { last_ = std::chrono::steady_clock::now(); }
    // Calls back unconditionally: at the beginning, the end and between stages. Throws `cancelled`.
    void report(double fraction);
    // Returns the callback for a run within this one, whose fractions lie in `share`; empty without a callback. This
    // object must outlive it.
    [[nodiscard]] ProgressCallback within(const Share& share);
    static void require(bool going_on);

private:
    [[nodiscard]] bool call(double fraction);

    static constexpr std::chrono::milliseconds interval{100};
    ProgressCallback callback_;
    double fraction_ = 0;
    std::chrono::steady_clock::time_point last_{};  // long ago, so that the first call goes through in the shortest run
};

// Lets the user stop a call. While it lives, check_stop() calls the progress callback when due, in this thread and its
// tasks. In other threads of a pool it reads a flag. A progress without a callback leaves an outer object in charge.
// `stage`: the part of the run that report_stage() speaks of. The default reports no advance.
class Stoppable {
public:
    explicit Stoppable(Progress& progress, const Share& stage = {0, 0});
    ~Stoppable();
    Stoppable(const Stoppable&) = delete;
    Stoppable& operator=(const Stoppable&) = delete;

    // Sets this thread's object, which may be null. may_call: call back, or only read the flag.
    class Scope {
    public:
        Scope(Stoppable* to, bool may_call) noexcept;
        ~Scope();
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        Stoppable* outer_;
        bool outer_may_call_;
    };
    // May be null.
    [[nodiscard]] static Stoppable* current() noexcept;
    [[nodiscard]] static Share stage() noexcept;
    static void enter_stage(const Share& share) noexcept;
    // See Progress::within().
    [[nodiscard]] static ProgressCallback within(const Share& share);

private:
    friend void check_stop();
    friend void report_stage(std::size_t done, std::size_t total);
    void check(double fraction);

    Progress& progress_;
    Share stage_;
    std::atomic<bool> stopped_{false};
    Scope scope_;
};

// Throws `cancelled` when the user asks to stop. Long loops call it at intervals of a few microseconds or more.
void check_stop();
// Also reports how much of the current stage is done.
void report_stage(std::size_t done, std::size_t total);

// Calls work(begin, end) for pieces of 0 .. count-1, and check_stop() between them.
template <class Work>
void in_pieces(std::size_t count, const Work& work) {
    constexpr std::size_t piece = std::size_t{1} << 14;
    for (std::size_t begin = 0; begin < count; begin += piece) {
        check_stop();
        work(begin, std::min(count, begin + piece));
    }
}

// Appends copies of `value` until the list has `size` elements, in pieces.
template <class T>
void lengthen(std::vector<T>& list, std::size_t size, const T& value = {}) {
    list.reserve(size);
    const std::size_t first = list.size();
    if (first < size) in_pieces(size - first, [&](std::size_t, std::size_t end) { list.resize(first + end, value); });
}

}  // namespace votess

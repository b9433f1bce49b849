// A queue of few values between two threads.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

namespace clvotess {

template <class Value>
class Relay {
public:
    // Adds a value, and waits while the queue is full. Returns false after stop().
    bool push(Value value) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return stopped_ || values_.size() < room; });
        if (stopped_) return false;
        values_.push_back(std::move(value));
        changed_.notify_all();
        return true;
    }
    // Returns the next value, or nothing after the last. Throws the exception of end().
    std::optional<Value> pop() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return ended_ || !values_.empty(); });
        if (values_.empty()) {
            if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
            return std::nullopt;
        }
        std::optional<Value> value(std::move(values_.front()));
        values_.pop_front();
        changed_.notify_all();
        return value;
    }
    // Ends the values: no push() may follow.
    void end(std::exception_ptr failure = nullptr) {
        const std::lock_guard lock(mutex_);
        ended_ = true;
        failure_ = std::move(failure);
        changed_.notify_all();
    }
    // Makes push() return false.
    void stop() {
        const std::lock_guard lock(mutex_);
        stopped_ = true;
        changed_.notify_all();
    }

private:
    static constexpr std::size_t room = 2;

    std::mutex mutex_;  // of all that follows
    std::condition_variable changed_;
    std::deque<Value> values_;
    std::exception_ptr failure_;
    bool ended_ = false, stopped_ = false;
};

}  // namespace clvotess

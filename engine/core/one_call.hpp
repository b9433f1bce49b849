#pragma once

#include <atomic>

#include "votess/votess.hpp"

namespace votess {

// Allows one call at a time. It is a flag, not a mutex, because the second call may come from a callback of the first.
class OneCall {
public:
    // message: of the error for another call.
    OneCall(std::atomic_flag& at_work, const char* message) : at_work_(at_work) {
        if (at_work_.test_and_set(std::memory_order_acquire)) throw Error(ErrorCode::invalid_use, message);
    }
    ~OneCall() { at_work_.clear(std::memory_order_release); }
    OneCall(const OneCall&) = delete;
    OneCall& operator=(const OneCall&) = delete;

private:
    std::atomic_flag& at_work_;
};

}  // namespace votess

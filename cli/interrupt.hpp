// Ctrl-C and similar signals, checked where it is safe to stop.
#pragma once

#include <exception>

#include "core/system.hpp"

namespace clvotess {

using InterruptGuard = votess::system::SignalGuard;

// Thrown after a signal, and with that of a closed pipe when the reader of stdout closed it.
class Interrupted : public std::exception {
public:
    explicit Interrupted(int signal) : signal_(signal) {}
    [[nodiscard]] int signal() const noexcept { return signal_; }
    [[nodiscard]] const char* what() const noexcept override { return "stopped, no file was written"; }

private:
    int signal_;
};

// Returns the received signal, or 0.
[[nodiscard]] inline int interrupting_signal() noexcept {
    return votess::system::received_signal();
}

inline void throw_if_interrupted() {
    if (const int signal = interrupting_signal()) throw Interrupted(signal);
}

}  // namespace clvotess

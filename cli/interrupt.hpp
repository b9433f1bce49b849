// Ctrl-C and its kin, asked for at points where it is safe to stop.
#pragma once

#include <array>
#include <csignal>
#include <exception>

namespace clvotess {

// While it lives, SIGINT, SIGTERM and SIGHUP only set a flag; a second one ends the program at once.
class InterruptGuard {
public:
    InterruptGuard();
    ~InterruptGuard();
    InterruptGuard(const InterruptGuard&) = delete;
    InterruptGuard& operator=(const InterruptGuard&) = delete;

    static constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};

private:
    std::array<struct sigaction, signals.size()> old_{};
};

// Also thrown, with SIGPIPE, when the reader of stdout has left.
class Interrupted : public std::exception {
public:
    explicit Interrupted(int signal) : signal_(signal) {}
    [[nodiscard]] int signal() const noexcept { return signal_; }
    [[nodiscard]] const char* what() const noexcept override { return "stopped, no file was written"; }

private:
    int signal_;
};

// The signal that came, 0 when none did.
[[nodiscard]] int interrupting_signal() noexcept;
void throw_if_interrupted();

}  // namespace clvotess

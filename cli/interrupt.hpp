// Ctrl-C and similar signals, checked where it is safe to stop.
#pragma once

#include <array>
#include <csignal>
#include <exception>

namespace clvotess {

// During its lifetime SIGINT, SIGTERM and SIGHUP set a flag. A second signal ends the program at once.
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

// Thrown after a signal, and with SIGPIPE when the reader of stdout closed it.
class Interrupted : public std::exception {
public:
    explicit Interrupted(int signal) : signal_(signal) {}
    [[nodiscard]] int signal() const noexcept { return signal_; }
    [[nodiscard]] const char* what() const noexcept override { return "stopped, no file was written"; }

private:
    int signal_;
};

// Returns the received signal, or 0.
[[nodiscard]] int interrupting_signal() noexcept;
void throw_if_interrupted();

}  // namespace clvotess

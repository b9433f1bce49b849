#include "interrupt.hpp"

namespace clvotess {
namespace {

volatile std::sig_atomic_t signal_that_came = 0;  // a handler can reach nothing but a global

void remember(int signal) {
    signal_that_came = signal;
}

}  // namespace

InterruptGuard::InterruptGuard() {
    for (std::size_t i = 0; i < signals.size(); ++i) {
        struct sigaction action {};
        action.sa_handler = remember;
        // The default action comes back after the first signal: an impatient second Ctrl-C always works.
        action.sa_flags = static_cast<int>(SA_RESETHAND);
        sigemptyset(&action.sa_mask);
        sigaction(signals[i], &action, &old_[i]);
        // Started with the signal ignored (nohup, a job in the background): keep it so.
        if (old_[i].sa_handler == SIG_IGN) sigaction(signals[i], &old_[i], nullptr);
    }
}

InterruptGuard::~InterruptGuard() {
    for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &old_[i], nullptr);
}

int interrupting_signal() noexcept {
    return signal_that_came;
}

void throw_if_interrupted() {
    if (const int signal = interrupting_signal()) throw Interrupted(signal);
}

}  // namespace clvotess

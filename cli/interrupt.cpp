#include "interrupt.hpp"

namespace clvotess {
namespace {

volatile std::sig_atomic_t signal_that_came = 0;  // a handler can only reach a global

void remember(int signal) {
    signal_that_came = signal;
}

}  // namespace

InterruptGuard::InterruptGuard() {
    for (std::size_t i = 0; i < signals.size(); ++i) {
        struct sigaction action {};
        action.sa_handler = remember;
        // The first signal restores the default action, so a second Ctrl-C always ends the program.
        action.sa_flags = static_cast<int>(SA_RESETHAND);
        sigemptyset(&action.sa_mask);
        sigaction(signals[i], &action, &old_[i]);
        // Keeps a signal ignored that was ignored at the start (nohup, a background job).
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

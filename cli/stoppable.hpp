// A call of the library that shows how far it is, and that Ctrl-C stops.
#pragma once

#include <votess/votess.hpp>

#include "interrupt.hpp"
#include "progress.hpp"

namespace clvotess {

// Returns work(callback), whose callback is for the library. Throws Interrupted when a signal came.
template <class Work>
auto run_stoppable(Progress& progress, const Work& work) {
    const InterruptGuard guard;
    const votess::ProgressCallback callback = [&progress](double fraction) {
        progress.show(fraction);
        return interrupting_signal() == 0;
    };
    try {
        auto result = work(callback);
        throw_if_interrupted();
        return result;
    } catch (const votess::Error& error) {
        if (error.code() == votess::ErrorCode::cancelled) throw_if_interrupted();
        throw;
    }
}

}  // namespace clvotess

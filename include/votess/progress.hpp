// Stops calls that take no progress callback of their own.
#pragma once

#include <memory>

#include "votess/votess.hpp"

namespace votess {

// While it lives, calls of this thread use this callback where they have none: delaunay(), network(), largest_free(),
// alpha_complex(), watershed(), verify() and all others. It is called about ten times a second. A call for which it
// returns false throws `cancelled`; what the callback throws passes through. Fractions are those of parts of a call.
// Objects nest: the newest is in charge.
class VOTESS_API ProgressScope {
public:
    explicit ProgressScope(ProgressCallback callback);
    ~ProgressScope();
    ProgressScope(const ProgressScope&) = delete;
    ProgressScope& operator=(const ProgressScope&) = delete;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace votess

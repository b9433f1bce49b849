// The process that made something. A child made by fork() has a copy of its memory, but not its threads and devices:
// the child may neither use nor end them, and lets their memory lie.
#pragma once

#include <sys/types.h>
#include <unistd.h>

namespace votess {

class HomeProcess {
public:
    [[nodiscard]] bool is_this() const { return id_ == ::getpid(); }

private:
    pid_t id_ = ::getpid();
};

}  // namespace votess

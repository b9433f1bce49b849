#include "fuzz/isolate.hpp"

#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <stdexcept>

#include "fuzz/judge.hpp"
#include "support/check.hpp"

namespace test::fuzz {

void start_limits(const Limits& limits) {
    itimerval timer{};
    // A software device compiles its pipelines in each process.
    const unsigned seconds = limits.device == "cpu" ? limits.seconds : 3 * limits.seconds;
    timer.it_value.tv_sec = seconds;
    setitimer(ITIMER_PROF, &timer, nullptr);
    alarm(10 * seconds);
}

void limit_memory(const Limits& limits) {
    // Sanitizers reserve, and lavapipe maps, more addresses than they use.
    if (limits.device != "cpu" || reduced()) return;
    const rlimit most{rlim_t{3} << 30, rlim_t{3} << 30};
    setrlimit(RLIMIT_AS, &most);
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
}

std::string describe_end(int status) {
    if (WIFSIGNALED(status)) {
        const int by = WTERMSIG(status);
        if (by == SIGPROF) return "hang: too much processor time";
        if (by == SIGALRM) return "hang: no end, and little processor time";
        return std::string("crash: ") + strsignal(by);
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? "" : "crash: the process ended with an error";
}

std::string judge_apart(const Case& c, const Limits& limits) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("no process");
    if (child == 0) {
        close(ends[0]);
        limit_memory(limits);
        start_limits(limits);
        votess::Tessellator kept;
        const std::string failure = judge(c, limits.device, limits.device == "cpu" && !reduced(), kept).failure;
        (void)!::write(ends[1], failure.data(), std::min<std::size_t>(failure.size(), 60000));
        _exit(0);
    }
    close(ends[1]);
    std::string failure;
    char part[4096];
    for (ssize_t n; (n = ::read(ends[0], part, sizeof part)) > 0;) failure.append(part, static_cast<std::size_t>(n));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    const std::string end = describe_end(status);
    return end.empty() ? failure : end;
}

}  // namespace test::fuzz

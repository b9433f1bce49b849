#include "support/child.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <exception>

namespace test {

std::string in_child(const std::function<std::string()>& work) {
    constexpr unsigned seconds = 60;
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) return "no pipe";
    const pid_t child = fork();
    if (child < 0) return "no fork";
    if (child == 0) {
        alarm(seconds);
        std::string failure;
        try {
            failure = work();
        } catch (const std::exception& error) {
            failure = std::string("threw: ") + error.what();
        }
        failure.resize(std::min<std::size_t>(failure.size(), 1000));  // what a pipe takes at once
        const bool told = write(ends[1], failure.data(), failure.size()) == static_cast<ssize_t>(failure.size());
        _exit(told ? 0 : 1);
    }
    close(ends[1]);
    std::array<char, 1000> text{};
    std::string failure;
    for (ssize_t n = 0; (n = read(ends[0], text.data(), text.size())) > 0;)
        failure.append(text.data(), static_cast<std::size_t>(n));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) failure += "the child ended by signal " + std::to_string(WTERMSIG(status));
    if (WIFEXITED(status) && WEXITSTATUS(status) != 0) failure += "the child exited";
    return failure;
}

}  // namespace test

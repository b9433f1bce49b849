#include "system/memory.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <stdexcept>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "system/machine.hpp"

namespace bench {
namespace {

// The child's report.
struct Peak {
    bool able = true;                     // whether the peer can serve the request
    std::uint64_t points = 0, bytes = 0;  // bytes beyond the input
    char failure[200] = "no answer";      // empty: none
};

// A line of /proc/self/status, in bytes.
std::uint64_t resident(const std::string& key) {
    std::ifstream in("/proc/self/status");
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with(key + ':')) {
            return std::strtoull(line.c_str() + key.size() + 1, nullptr, 10) * 1024;
        }
    }
    throw std::runtime_error("--memory reads /proc/self/status of Linux");
}

Peak measure(const Peer& peer, const std::string& input_name, std::size_t n, std::uint64_t rng_seed, Want want,
             unsigned threads) {
    Peak peak;
    try {
        const Input input = make_input(input_name, n, rng_seed);
        peak.able = peer.can(input, want);
        if (!peak.able) {
            return peak;
        }
#if defined(__GLIBC__)
        malloc_trim(0);  // else the peer would reuse memory that making the input left behind
#endif
        std::ofstream("/proc/self/clear_refs") << "5";  // resets the peak
        const std::uint64_t before = resident("VmRSS");
        static_cast<void>(peer.run(input, want, threads));
        peak.points = input.size();
        peak.bytes = std::max(before, resident("VmHWM")) - before;
        peak.failure[0] = '\0';
    } catch (const std::exception& error) {
        std::snprintf(peak.failure, sizeof peak.failure, "failed: %s", error.what());
    }
    return peak;
}

template <class Work>
Peak in_child(const Work& work) {
    int ends[2];
    std::fflush(nullptr);
    if (pipe(ends) != 0) {
        throw std::runtime_error("no pipe to a child process");
    }
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        const Peak peak = work();
        const bool told = write(ends[1], &peak, sizeof peak) == static_cast<ssize_t>(sizeof peak);
        _exit(told ? 0 : 1);
    }
    close(ends[1]);
    Peak peak;
    if (child < 0 || read(ends[0], &peak, sizeof peak) != static_cast<ssize_t>(sizeof peak)) {
        peak = {};  // it was killed, most likely for want of memory
    }
    close(ends[0]);
    if (child > 0) {
        waitpid(child, nullptr, 0);
    }
    return peak;
}

// Prints the row and returns it as an object of the JSON file.
std::string report(const std::string& label, std::size_t n, Want want, const Peer& peer, unsigned threads,
                   const Peak& peak) {
    const std::string name = peer.name(), note = peak.failure;
    std::printf("%-24s %9zu %-9s %-15s %7u ", label.c_str(), n, std::string(name_of(want)).c_str(), name.c_str(),
                threads);
    std::string row = "{\"input\": " + in_quotes(label) + ", \"n\": " + std::to_string(n) +
                      ", \"want\": " + in_quotes(name_of(want)) + ", \"peer\": " + in_quotes(name) +
                      ", \"threads\": " + std::to_string(threads);
    if (!note.empty()) {
        std::printf("%s\n", note.c_str());
        row += ", \"note\": " + in_quotes(note);
    } else {
        const double bytes = static_cast<double>(peak.bytes) / static_cast<double>(n);
        std::printf("%11.0f\n", bytes);
        row += ", \"bytes_per_point\": " + std::to_string(bytes);
    }
    std::fflush(stdout);
    return row + '}';
}

}  // namespace

int run_memory_table(const MemoryTable& table, const Peers& peers, const std::vector<PeerVersion>& versions) {
    std::printf(
        "\nPeak of resident memory beyond the input, each in a process of its own.\n%-24s %9s %-9s %-15s %7s %s\n",
        "input", "n", "want", "", "threads", "bytes/point");
    static_cast<void>(resident("VmHWM"));  // throws now rather than in every child
    Section section{"memory", {}};
    bool good = true;
    const auto measure_all = [&](const std::string& name, std::size_t n, Want want) {
        for (const auto& peer : peers) {
            for (const unsigned threads : peer->threads(table.threads)) {
                const Peak peak = in_child([&] { return measure(*peer, name, n, table.rng_seed, want, threads); });
                if (!peak.able) {
                    break;
                }
                const bool failed = peak.failure[0] != '\0';
                good = good && !failed;
                section.items.push_back(report(label_of(name), failed ? n : peak.points, want, *peer, threads, peak));
            }
        }
    };
    for (const std::string& name : table.inputs) {
        for (const std::size_t n : is_file(name) ? std::vector<std::size_t>{0} : table.sizes) {
            for (const std::string& want : table.wants) {
                measure_all(name, n, want == "full" ? Want::full : Want::neighbors);
            }
        }
    }
    if (!table.json.empty()) {
        write_json(table.json, versions, {section});
    }
    return good ? 0 : 1;
}

}  // namespace bench

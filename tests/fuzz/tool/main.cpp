// votess_fuzz: proves the library's answers to random inputs, on all cores. tools/fuzz.sh builds and starts it.
//   votess_fuzz HOURS|--sets N [KIND...] [--device cpu|lavapipe] [--seed N] [--findings FOLDER] [--jobs N]
//   votess_fuzz --replay FILE... [--device cpu|lavapipe]
// --sets tries N sets of each kind, numbered from the seed. Exits 0 when all answers were right, 1 when one was wrong,
// 2 when the arguments are wrong.
#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "core/processors.hpp"
#include "fuzz/judge.hpp"
#include "fuzz/kinds/kinds.hpp"
#include "fuzz/tool/reduce.hpp"
#include "support/check.hpp"

namespace {

using namespace test::fuzz;
using Clock = std::chrono::steady_clock;

constexpr std::size_t max_kinds = 32;
constexpr int kept_of_a_sort = 3;

struct Arguments {
    double hours = 0;
    std::uint64_t sets = 0;  // of each kind; 0: any number
    std::vector<const Kind*> kinds;
    std::uint64_t first = std::random_device{}() * 1000000ull;
    std::vector<std::string> replay;
    std::string findings = "build/fuzz";
    Limits limits;
    unsigned jobs = votess::system::processors();
};

Arguments parse(int count, char** values) {
    Arguments arguments;
    const auto number = [](const std::string& name, const std::string& text) {
        std::size_t used = 0;
        double x = -1;
        try {
            x = std::stod(text, &used);
        } catch (const std::exception&) {
        }
        if (used != text.size() || !(x >= 0)) throw std::invalid_argument(name + ": '" + text + "' is not a number");
        return x;
    };
    bool has_hours = false;
    for (int k = 1; k < count; ++k) {
        const std::string word = values[k];
        const auto value = [&]() -> std::string {
            if (++k == count) throw std::invalid_argument(word + " needs a value");
            return values[k];
        };
        const auto kind = std::ranges::find(all_kinds(), word, &Kind::name);
        if (word == "--replay") {
            arguments.replay.push_back(value());
            while (k + 1 < count && !std::string_view(values[k + 1]).starts_with("--"))
                arguments.replay.emplace_back(values[++k]);
        } else if (word == "--sets") {
            arguments.sets = static_cast<std::uint64_t>(number(word, value()));
        } else if (word == "--device") {
            arguments.limits.device = value();
        } else if (word == "--seed") {
            arguments.first = static_cast<std::uint64_t>(number(word, value()));
        } else if (word == "--findings") {
            arguments.findings = value();
        } else if (word == "--jobs") {
            arguments.jobs = std::clamp(static_cast<unsigned>(number(word, value())), 1u, 256u);
        } else if (kind != all_kinds().end()) {
            arguments.kinds.push_back(&*kind);
        } else if (!has_hours) {
            arguments.hours = number("HOURS", word);
            has_hours = true;
        } else {
            std::string names;
            for (const Kind& k : all_kinds()) names += ' ' + std::string(k.name);
            throw std::invalid_argument("'" + word + "' is not a kind; use" + names);
        }
    }
    if (!has_hours && arguments.sets == 0 && arguments.replay.empty())
        throw std::invalid_argument("give HOURS, --sets N or --replay FILE");
    if (arguments.kinds.empty())
        for (const Kind& kind : all_kinds()) arguments.kinds.push_back(&kind);
    return arguments;
}

// Written by a worker, read by its parent.
struct Progress {
    std::atomic<std::uint64_t> kind, number, next, cells, fallback_cells;
    std::atomic<std::uint64_t> tried[max_kinds], jobs[max_kinds], refused[max_kinds], milliseconds[max_kinds];
};

struct Worker {
    pid_t id = -1;
    int reports = -1;  // -1 once it has tried all its sets
    std::string text;  // of reports, up to the last whole line
};

struct Finding {
    std::uint64_t kind, number;
    std::string failure;
};

class Fuzz {
public:
    explicit Fuzz(const Arguments& arguments) : arguments_(arguments), workers_(arguments.jobs) {
        void* shared = mmap(nullptr, sizeof(Progress) * workers_.size(), PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (shared == MAP_FAILED) throw std::runtime_error("no shared memory");
        progress_ = static_cast<Progress*>(shared);
        std::filesystem::create_directories(arguments_.findings);
    }

    int run() {
        const auto end =
            Clock::now() + std::chrono::duration<double>(arguments_.sets > 0 ? 1e9 : arguments_.hours * 3600);
        std::printf("fuzz: %u processes, seed %llu, device %s\n", arguments_.jobs,
                    static_cast<unsigned long long>(arguments_.first), arguments_.limits.device.c_str());
        for (std::size_t w = 0; w < workers_.size(); ++w) start(w);
        while (Clock::now() < end && std::ranges::any_of(workers_, [](const Worker& w) { return w.reports >= 0; })) {
            std::vector<pollfd> waiting;
            for (const Worker& worker : workers_) waiting.push_back({worker.reports, POLLIN, 0});
            poll(waiting.data(), waiting.size(), 200);
            for (std::size_t w = 0; w < workers_.size(); ++w)
                if (waiting[w].revents != 0) hear(w);
        }
        for (Worker& worker : workers_) {
            if (worker.reports < 0) continue;
            kill(worker.id, SIGKILL);
            waitpid(worker.id, nullptr, 0);
        }
        return summarize();
    }

private:
    void start(std::size_t w) {
        int ends[2];
        if (pipe(ends) != 0) throw std::runtime_error("no pipe");
        std::fflush(stdout);
        const pid_t child = fork();
        if (child < 0) throw std::runtime_error("no process");
        if (child == 0) {
            close(ends[0]);
            limit_memory(arguments_.limits);
            work(w, ends[1]);
        }
        close(ends[1]);
        workers_[w] = {child, ends[0], ""};
    }

    // Chooses the next kind and number. Without --sets all kinds get the same time.
    bool choose(std::size_t w, Progress& mine) const {
        const std::uint64_t next = w + workers_.size() * mine.next++;
        std::size_t kind = 0;
        for (std::size_t k = 1; k < arguments_.kinds.size(); ++k)
            if (mine.milliseconds[k] < mine.milliseconds[kind]) kind = k;
        mine.kind = arguments_.sets > 0 ? next / arguments_.sets : kind;
        mine.number = arguments_.first + (arguments_.sets > 0 ? next % arguments_.sets : next);
        return mine.kind < arguments_.kinds.size();
    }

    // Returns the case after it was written and read, and a failure when that changed it.
    static std::pair<Case, std::string> read_again(const Case& c) {
        std::stringstream text, same;
        write(c, text);
        std::pair<Case, std::string> again{read(text), ""};
        write(again.first, same);
        if (text.str() != same.str()) again.second = "text: another case when it is read";
        return again;
    }

    [[noreturn]] void work(std::size_t w, int reports) {
        Progress& mine = progress_[w];
        const bool on_cpu = arguments_.limits.device == "cpu", measure = on_cpu && !test::reduced();
        votess::Tessellator device;  // a new one for each set would take long to open it
        while (choose(w, mine)) {
            const std::size_t kind = mine.kind;
            const auto begin = Clock::now();
            start_limits(arguments_.limits);
            const auto [set, wrong] = read_again(make_case(*arguments_.kinds[kind], mine.number));
            votess::Tessellator fresh;
            Judgement judgement = judge(set, arguments_.limits.device, measure, on_cpu ? fresh : device);
            if (!wrong.empty()) judgement.failure = wrong;
            ++mine.tried[kind];
            mine.jobs[kind] += judgement.jobs;
            mine.refused[kind] += judgement.refused;
            mine.cells += judgement.cells;
            mine.fallback_cells += judgement.fallback_cells;
            mine.milliseconds[kind] +=
                static_cast<std::uint64_t>(std::chrono::duration<double, std::milli>(Clock::now() - begin).count() + 1);
            if (judgement.right()) continue;
            std::string line = std::to_string(kind) + ' ' + std::to_string(mine.number) + ' ' + judgement.failure;
            std::ranges::replace(line, '\n', ' ');
            line.resize(std::min<std::size_t>(line.size(), 3000));
            line += '\n';
            (void)!::write(reports, line.data(), line.size());
            // Only a new process has another peak of memory.
            if (judgement.failure.starts_with("memory")) _exit(0);
        }
        _exit(finished);
    }

    void hear(std::size_t w) {
        Worker& worker = workers_[w];
        char part[8192];
        const ssize_t n = ::read(worker.reports, part, sizeof part);
        if (n > 0) {
            worker.text.append(part, static_cast<std::size_t>(n));
            for (std::size_t end; (end = worker.text.find('\n')) != std::string::npos;) {
                std::istringstream line(worker.text.substr(0, end));
                worker.text.erase(0, end + 1);
                Finding finding{};
                line >> finding.kind >> finding.number >> std::ws;
                std::getline(line, finding.failure);
                keep(finding);
            }
            return;
        }
        int status = 0;
        waitpid(worker.id, &status, 0);
        close(worker.reports);
        Progress& of = progress_[w];
        if (WIFEXITED(status) && WEXITSTATUS(status) == finished) {
            worker.reports = -1;
            return;
        }
        const std::string end = describe_end(status);
        const Finding finding{of.kind, of.number, end};
        if (!end.empty()) {
            ++of.tried[finding.kind];
            of.milliseconds[finding.kind] += 1000;
        }
        start(w);
        if (!end.empty()) keep(finding);
    }

    void keep(const Finding& finding) {
        const Kind& kind = *arguments_.kinds[finding.kind];
        const std::string sort = std::string(kind.name) + ' ' + sort_of(finding.failure);
        if (++found_[sort] > kept_of_a_sort) return;
        const Case whole = make_case(kind, finding.number);
        const Case least = reduce(whole, finding.failure, arguments_.limits);
        const std::string failure = judge_apart(least, arguments_.limits);
        const auto path = std::filesystem::path(arguments_.findings) /
                          (std::string(kind.name) + '-' + std::to_string(finding.number) + ".txt");
        std::ofstream out(path);
        out << "# " << finding.failure << "\n# reduced: " << failure << "\n# device " << arguments_.limits.device
            << '\n';
        test::fuzz::write(least, out);
        std::size_t seeds = 0;
        for (const Job& job : least.jobs) seeds += job.size();
        std::printf("found: %s\n  %s, %zu seeds: %.300s\n", path.c_str(), std::string(kind.name).c_str(), seeds,
                    failure.c_str());
        std::fflush(stdout);
    }

    int summarize() {
        std::uint64_t all = 0;
        std::printf("%-10s %12s %10s %10s %8s\n", "kind", "sets tried", "runs", "refused", "found");
        for (std::size_t k = 0; k < arguments_.kinds.size(); ++k) {
            std::uint64_t tried = 0, jobs = 0, refused = 0;
            int found = 0;
            for (std::size_t w = 0; w < workers_.size(); ++w)
                tried += progress_[w].tried[k], jobs += progress_[w].jobs[k], refused += progress_[w].refused[k];
            const std::string name(arguments_.kinds[k]->name);
            for (const auto& [sort, times] : found_)
                if (sort.starts_with(name + ' ')) found += times;
            all += tried;
            std::printf("%-10s %12llu %10llu %10llu %8d\n", name.c_str(), static_cast<unsigned long long>(tried),
                        static_cast<unsigned long long>(jobs), static_cast<unsigned long long>(refused), found);
        }
        for (const auto& [sort, times] : found_) std::printf("found %d times: %s\n", times, sort.c_str());
        std::printf("fuzz: %llu sets tried by %u processes, findings in %s\n", static_cast<unsigned long long>(all),
                    arguments_.jobs, arguments_.findings.c_str());
        bool right = found_.empty() && (arguments_.sets == 0 || all == arguments_.sets * arguments_.kinds.size());
        if (arguments_.limits.device != "cpu") {
            std::uint64_t cells = 0, fallback_cells = 0;
            for (std::size_t w = 0; w < workers_.size(); ++w)
                cells += progress_[w].cells, fallback_cells += progress_[w].fallback_cells;
            std::printf("fuzz: the device made %llu of %llu cells\n",
                        static_cast<unsigned long long>(cells - fallback_cells),
                        static_cast<unsigned long long>(cells));
            right = right && 50 * (cells - fallback_cells) >= cells;
        }
        return right ? 0 : 1;
    }

    static constexpr int finished = 17;  // the exit status of a worker that has tried all its sets

    const Arguments& arguments_;
    std::vector<Worker> workers_;
    Progress* progress_ = nullptr;
    std::map<std::string, int> found_;  // kind and sort of failure
};

int replay(const Arguments& arguments) {
    int wrong = 0;
    for (const std::string& file : arguments.replay) {
        std::ifstream in(file);
        if (!in) throw std::runtime_error(file + " cannot be read");
        const std::string failure = judge_apart(read(in), arguments.limits);
        std::printf("%s: %s\n", file.c_str(), failure.empty() ? "right" : failure.c_str());
        wrong += failure.empty() ? 0 : 1;
    }
    return wrong == 0 ? 0 : 1;
}

}  // namespace

int main(int count, char** values) {
    try {
        const Arguments arguments = parse(count, values);
        return arguments.replay.empty() ? Fuzz(arguments).run() : replay(arguments);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "fuzz: %s\n", error.what());
        return 2;
    }
}

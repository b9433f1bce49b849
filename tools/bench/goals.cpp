#include "goals.hpp"

#include <algorithm>
#include <cstdio>
#include <list>
#include <thread>

#include "system/machine.hpp"

namespace bench {
namespace {

// The time per cell of one contestant divided by that of another, both given by their place in the round.
struct Goal {
    std::string text;
    std::size_t dividend, divisor;
    double bound;
    bool at_least;
};

constexpr std::size_t nobody = static_cast<std::size_t>(-1);

// Contestants that take turns, and the goals among them.
class Round {
public:
    explicit Round(const Peers& peers) : peers_(peers) {}

    // The place of a new contestant, or nobody when there is no such peer.
    std::size_t add(std::string_view name, const Input& input, Want want, unsigned threads = 1) {
        const auto peer = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->name() == name; });
        if (peer == peers_.end()) {
            return nobody;
        }
        contestants_.push_back({peer->get(), &input, want, threads});
        return contestants_.size() - 1;
    }
    void at_least(double bound, const std::string& text, std::size_t dividend, std::size_t divisor) {
        goals_.push_back({text, dividend, divisor, bound, true});
    }
    void at_most(double bound, const std::string& text, std::size_t dividend, std::size_t divisor) {
        goals_.push_back({text, dividend, divisor, bound, false});
    }
    [[nodiscard]] const std::vector<Contestant>& contestants() const { return contestants_; }
    [[nodiscard]] const std::vector<Goal>& goals() const { return goals_; }

private:
    const Peers& peers_;
    std::vector<Contestant> contestants_;
    std::vector<Goal> goals_;
};

std::string task(const Input& input, Want want) {
    return input.name + ' ' + short_number(input.size()) + ", " + std::string(name_of(want));
}

std::string microseconds(const Measurement& m) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g us", 1e6 * m.seconds_per_cell());
    return text;
}

// Measures the rounds one after the other and keeps what came of them.
class Scoreboard {
public:
    explicit Scoreboard(const Repeats& repeats) : timekeeper_(repeats) {
        std::printf("\nTime per cell of the first divided by that of the second, medians.\n%-52s %7s  %-8s\n", "",
                    "ratio", "goal");
        std::fflush(stdout);
    }

    void play(const Round& round) {
        const auto group = timekeeper_.measure(round.contestants());
        for (const Goal& goal : round.goals()) {
            judge(goal, group);
        }
        std::fflush(stdout);
        measurements_.insert(measurements_.end(), group.begin(), group.end());
    }

    [[nodiscard]] int met() const { return met_; }
    [[nodiscard]] int count() const { return static_cast<int>(lines_.items.size()); }
    [[nodiscard]] std::vector<Section> sections() const { return {lines_, section_of(measurements_)}; }

private:
    void judge(const Goal& goal, const std::vector<Measurement>& group) {
        const std::string bound = std::to_string(goal.bound).substr(0, goal.bound < 1 ? 4 : 3);
        std::printf("%-52s ", goal.text.c_str());
        std::string line = "{\"goal\": " + in_quotes(goal.text) + ", \"at_" + (goal.at_least ? "least" : "most") +
                           "\": " + bound + ", ";
        std::string missing;
        for (const std::size_t place : {goal.dividend, goal.divisor}) {
            if (place == nobody) {
                missing = "not measured: a program or a second core is missing";
            } else if (group[place].seconds.empty()) {
                missing = "not measured: " + group[place].peer + ' ' + group[place].note;
            }
        }
        if (!missing.empty()) {
            std::printf("%7s  %s %-5s %s\n", "-", goal.at_least ? ">=" : "<=", bound.c_str(), missing.c_str());
            lines_.items.push_back(line + "\"met\": false, \"note\": " + in_quotes(missing) + '}');
            return;
        }
        const Measurement &a = group[goal.dividend], &b = group[goal.divisor];
        const double ratio = a.seconds_per_cell() / b.seconds_per_cell();
        const bool met = goal.at_least ? ratio >= goal.bound : ratio <= goal.bound;
        met_ += met ? 1 : 0;
        std::printf("%7.2f  %s %-5s %-6s  %s : %s\n", ratio, goal.at_least ? ">=" : "<=", bound.c_str(),
                    met ? "met" : "MISSED", microseconds(a).c_str(), microseconds(b).c_str());
        lines_.items.push_back(line + "\"ratio\": " + std::to_string(ratio) + ", \"met\": " + (met ? "true" : "false") +
                               '}');
    }

    Timekeeper timekeeper_;
    std::vector<Measurement> measurements_;
    Section lines_{"goals", {}};
    int met_ = 0;
};

}  // namespace

int run_goals(const Goals& goals, const Peers& peers, const std::vector<PeerVersion>& versions) {
    const auto input = [&](std::string_view name, std::size_t n) { return make_input(name, n, goals.rng_seed); };
    Scoreboard scoreboard(goals.repeats);
    {
        const Input uniform = input("uniform", goals.small);
        std::list<Input> others;  // stay where they are
        for (const char* lattice : {"lattice", "bcc"}) {
            others.push_back(input(lattice, goals.small));
        }
        Round round(peers);
        const std::size_t votess = round.add("votess", uniform, Want::neighbors);
        const std::string of = task(uniform, Want::neighbors);
        round.at_least(8, of + ": Voro++ / votess", round.add("voro++", uniform, Want::neighbors), votess);
        round.at_least(4.5, of + ": CGAL / votess", round.add("cgal", uniform, Want::neighbors), votess);
        for (const Input& lattice : others) {
            round.at_least(0.25, of + " / " + lattice.name, votess, round.add("votess", lattice, Want::neighbors));
        }
        if (!goals.file.empty()) {
            others.push_back(input(goals.file, 0));
            round.at_most(1.6, others.back().name + " / " + of, round.add("votess", others.back(), Want::neighbors),
                          votess);
        }
        scoreboard.play(round);

        Round full(peers);
        const std::size_t votess_full = full.add("votess", uniform, Want::full);
        full.at_least(7, task(uniform, Want::full) + ": Voro++ / votess", full.add("voro++", uniform, Want::full),
                      votess_full);
        scoreboard.play(full);
    }
    {
        const Input sphere = input("sphere", std::max<std::size_t>(goals.small / 5, 20));
        Round round(peers);
        const std::size_t votess = round.add("votess", sphere, Want::neighbors);
        round.at_least(5, task(sphere, Want::neighbors) + ": Qhull / votess",
                       round.add("qhull", sphere, Want::neighbors), votess);
        scoreboard.play(round);
    }
    {
        const Input uniform = input("uniform", goals.large), clustered = input("clustered", goals.large);
        Round round(peers);
        const std::size_t votess = round.add("votess", uniform, Want::neighbors);
        const std::string of = task(uniform, Want::neighbors);
        const bool cores = std::thread::hardware_concurrency() > 1;
        round.at_least(8, of + ": Voro++ / votess", round.add("voro++", uniform, Want::neighbors), votess);
        round.at_least(4.5, of + ": CGAL / votess", round.add("cgal", uniform, Want::neighbors), votess);
        round.at_least(1.9, of + ": one thread / two", votess,
                       cores ? round.add("votess", uniform, Want::neighbors, 2) : nobody);
        round.at_most(1.4, "clustered / " + of, round.add("votess", clustered, Want::neighbors), votess);
        scoreboard.play(round);

        Round full(peers);
        const std::size_t votess_full = full.add("votess", uniform, Want::full);
        full.at_least(7, task(uniform, Want::full) + ": Voro++ / votess", full.add("voro++", uniform, Want::full),
                      votess_full);
        scoreboard.play(full);
    }
    std::printf("%d of %d goals met\n", scoreboard.met(), scoreboard.count());
    if (!goals.json.empty()) {
        write_json(goals.json, versions, scoreboard.sections());
    }
    return goals.strict && scoreboard.met() < scoreboard.count() ? 1 : 0;
}

}  // namespace bench

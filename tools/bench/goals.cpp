#include "goals.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <optional>
#include <thread>

#include "system/machine.hpp"

namespace bench {
namespace {

std::string size_of(const Input& input) {
    return input.name + ' ' + short_number(input.size());
}

// A contestant, as goals name it.
struct Player {
    std::string name;
    const Input* input;
    Want want;
    std::optional<std::size_t> place;  // among the measurements of the round; none when something is missing
};

// The time per cell of one player divided by that of another.
struct Goal {
    Player dividend, divisor;
    double bound;
    bool at_least;

    [[nodiscard]] std::string text() const {
        const std::string tail = ", " + std::string(name_of(dividend.want));
        if (dividend.input != divisor.input) {
            return size_of(*dividend.input) + " / " + size_of(*divisor.input) + tail;
        }
        return size_of(*dividend.input) + tail + ": " + dividend.name + " / " + divisor.name;
    }
};

// Contestants that take turns, and the goals among them. The inputs outlive it.
class Round {
public:
    explicit Round(const Peers& peers) : peers_(peers) {}

    Player add(const std::string& name, const Input& input, Want want, unsigned threads = 1) {
        Player player{name, &input, want, {}};
        if (threads > 1) {
            player.name += " on " + std::to_string(threads) + " threads";
        }
        const auto peer = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->name() == name; });
        if (peer != peers_.end() && threads <= std::max(1U, std::thread::hardware_concurrency())) {
            player.place = contestants_.size();
            contestants_.push_back({peer->get(), &input, want, threads});
        }
        return player;
    }
    void at_least(double bound, const Player& dividend, const Player& divisor) {
        goals_.push_back({dividend, divisor, bound, true});
    }
    void at_most(double bound, const Player& dividend, const Player& divisor) {
        goals_.push_back({dividend, divisor, bound, false});
    }
    [[nodiscard]] const std::vector<Contestant>& contestants() const { return contestants_; }
    [[nodiscard]] const std::vector<Goal>& goals() const { return goals_; }

private:
    const Peers& peers_;
    std::vector<Contestant> contestants_;
    std::vector<Goal> goals_;
};

std::string microseconds(const Measurement& m) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g us", 1e6 * m.seconds_per_cell());
    return text;
}

// Empty when both were measured.
std::string what_is_missing(const Goal& goal, const std::vector<Measurement>& group) {
    for (const Player& player : {goal.dividend, goal.divisor}) {
        if (!player.place) {
            return "not measured: a program or a second core is missing";
        }
        if (group[*player.place].seconds.empty()) {
            return "not measured: " + player.name + ' ' + group[*player.place].note;
        }
    }
    return "";
}

// Measures the rounds one after the other and keeps the results.
class Scoreboard {
public:
    explicit Scoreboard(bool checks) : checks_(checks) {
        std::printf("\nTime per cell of the first divided by that of the second, medians.\n%-56s %7s  %-8s\n", "",
                    "ratio", "goal");
        std::fflush(stdout);
    }

    void play(const Round& round, const Repeats& repeats) {
        const auto group = timekeeper_.measure(round.contestants(), repeats);
        for (const Goal& goal : round.goals()) {
            judge(goal, group);
        }
        std::fflush(stdout);
        complaints_ += checks_ ? check(group) : 0;
        measurements_.insert(measurements_.end(), group.begin(), group.end());
    }

    [[nodiscard]] int met() const { return met_; }
    [[nodiscard]] int count() const { return static_cast<int>(lines_.items.size()); }
    [[nodiscard]] int complaints() const { return complaints_; }
    [[nodiscard]] std::vector<Section> sections() const { return {lines_, section_of(measurements_)}; }

private:
    void judge(const Goal& goal, const std::vector<Measurement>& group) {
        char bound[32];
        std::snprintf(bound, sizeof bound, "%g", goal.bound);
        const char* sign = goal.at_least ? ">=" : "<=";
        std::printf("%-56s ", goal.text().c_str());
        std::string line = "{\"goal\": " + in_quotes(goal.text()) + ", \"at_" + (goal.at_least ? "least" : "most") +
                           "\": " + bound + ", ";
        const std::string missing = what_is_missing(goal, group);
        if (!missing.empty()) {
            std::printf("%7s  %s %-5s %s\n", "-", sign, bound, missing.c_str());
            lines_.items.push_back(line + "\"met\": false, \"note\": " + in_quotes(missing) + '}');
            return;
        }
        const Measurement &a = group[*goal.dividend.place], &b = group[*goal.divisor.place];
        const double ratio = a.seconds_per_cell() / b.seconds_per_cell();
        const bool met = goal.at_least ? ratio >= goal.bound : ratio <= goal.bound;
        met_ += met ? 1 : 0;
        std::printf("%7.2f  %s %-5s %-6s  %s : %s\n", ratio, sign, bound, met ? "met" : "MISSED",
                    microseconds(a).c_str(), microseconds(b).c_str());
        lines_.items.push_back(line + "\"ratio\": " + std::to_string(ratio) + ", \"met\": " + (met ? "true" : "false") +
                               '}');
    }

    bool checks_;
    Timekeeper timekeeper_;
    std::vector<Measurement> measurements_;
    Section lines_{"goals", {}};
    int met_ = 0, complaints_ = 0;
};

// A peer needs at least so many times the time of votess.
Round duel(const Peers& peers, double bound, const std::string& peer, const Input& input, Want want) {
    Round round(peers);
    const Player votess = round.add("votess", input, want);
    round.at_least(bound, round.add(peer, input, want), votess);
    return round;
}

// Neighbors of uniform seeds: the sets of instructions, each by itself, and CGAL. Returns votess as it runs by default.
Player add_uniform(Round& round, const Input& uniform) {
    const auto add = [&](const char* name) { return round.add(name, uniform, Want::neighbors); };
    const Player votess = add("votess"), voropp = add("voro++");
    const Player baseline = add("votess/baseline"), avx2 = add("votess/avx2"), avx512 = add("votess/avx512");
    round.at_least(7, voropp, avx2);
    round.at_least(11, voropp, avx512);
    round.at_most(1.3, avx2, avx512);
    round.at_most(2, baseline, avx2);
    round.at_least(4.5, add("cgal"), votess);
    return votess;
}

using MakeInput = std::function<Input(std::string_view, std::size_t)>;

// Weights as solvers of transport have them, and sets whose cells lie far from their seeds.
void play_other_inputs(const MakeInput& input, const Peers& peers, const Goals& goals, const Repeats& often,
                       Scoreboard& scoreboard) {
    const Input uniform = input("uniform", goals.small), periodic = input("periodic", goals.small);
    Round round(peers);
    const Player votess = round.add("votess", uniform, Want::neighbors),
                 votess_periodic = round.add("votess", periodic, Want::neighbors);
    const auto at_most = [&](double bound, const Player& divisor, const Input& other) {
        round.at_most(bound, round.add("votess", other, Want::neighbors), divisor);
    };
    const Input waves[] = {input("wave-0.5", goals.small), input("wave-1", goals.small), input("wave-2", goals.small),
                           input("wave-5", goals.small), input("transport", goals.small)};
    const double bounds[] = {1.2, 1.25, 1.3, 2, 2};
    for (std::size_t i = 0; i < std::size(waves); ++i) at_most(bounds[i], votess_periodic, waves[i]);
    const Input hidden = input("hidden", goals.small), heavy = input("heavy", goals.small),
                paraboloid = input("paraboloid", goals.small / 5), sheet = input("sheet", goals.small / 3);
    at_most(2, round.add("votess", heavy, Want::neighbors), hidden);
    // 0.2 s for 2e4 seeds, on a machine that takes 1.18 us for a uniform cell.
    at_most(8.5, votess, paraboloid);
    at_most(1.5, votess, sheet);
    scoreboard.play(round, often);
}

void play_table(const MakeInput& input, const Peers& peers, const Goals& goals, const Repeats& often,
                const Repeats& seldom, Scoreboard& scoreboard) {
    for (const std::size_t n : {goals.small, goals.large}) {
        const bool small = n == goals.small;
        const Input uniform = input("uniform", n), clustered = input("clustered", n);
        Round round(peers);
        const Player votess = round.add("votess", uniform, Want::neighbors),
                     in_clusters = round.add("votess", clustered, Want::neighbors);
        round.at_least(small ? 12 : 11, round.add("voro++", uniform, Want::neighbors), votess);
        if (small) round.at_least(30, round.add("voro++", clustered, Want::neighbors), in_clusters);
        round.at_most(1.15, in_clusters, votess);
        scoreboard.play(round, small ? often : seldom);
        if (small) scoreboard.play(duel(peers, 10, "voro++", uniform, Want::full), often);
    }
    play_other_inputs(input, peers, goals, often, scoreboard);
}

int finish(const Goals& goals, const std::vector<PeerVersion>& versions, const Scoreboard& scoreboard) {
    std::printf("%d of %d goals met\n", scoreboard.met(), scoreboard.count());
    if (!goals.json.empty()) {
        write_json(goals.json, versions, scoreboard.sections());
    }
    return scoreboard.complaints() > 0 || (goals.strict && scoreboard.met() < scoreboard.count()) ? 1 : 0;
}

}  // namespace

int run_goals(const Goals& goals, const Peers& peers, const std::vector<PeerVersion>& versions) {
    const auto input = [&](std::string_view name, std::size_t n) { return make_input(name, n, goals.rng_seed); };
    Repeats often = goals.repeats, seldom = goals.repeats;
    if (goals.repeats.count == 0) {
        often.count = 5;
        seldom.count = 3;
    }
    Scoreboard scoreboard(goals.check);
    if (goals.table) {
        play_table(input, peers, goals, often, seldom, scoreboard);
        return finish(goals, versions, scoreboard);
    }
    {
        const Input uniform = input("uniform", goals.small), lattice = input("lattice", goals.small),
                    bcc = input("bcc", goals.small);
        const Input file = goals.file.empty() ? Input{} : input(goals.file, 0);
        Round round(peers);
        const Player votess = add_uniform(round, uniform);
        for (const Input* ties : {&lattice, &bcc}) {
            round.at_least(0.25, votess, round.add("votess", *ties, Want::neighbors));
        }
        if (!goals.file.empty()) {
            round.at_most(1.4, round.add("votess", file, Want::neighbors), votess);
        }
        scoreboard.play(round, often);
        scoreboard.play(duel(peers, 7, "voro++", uniform, Want::full), often);
    }
    scoreboard.play(duel(peers, 7, "voro++", input("periodic", goals.small), Want::neighbors), often);
    scoreboard.play(duel(peers, 6, "voro++", input("triclinic", goals.small), Want::neighbors), often);
    scoreboard.play(
        duel(peers, 5, "qhull", input("sphere", std::max<std::size_t>(goals.small / 20, 20)), Want::neighbors), often);
    {
        const Input radii = input("radii", goals.small), heavy = input("heavy", goals.small),
                    fewer = input("heavy", std::max<std::size_t>(goals.small / 5, 20));
        Round round(peers);
        const Player votess = round.add("votess", radii, Want::neighbors);
        round.at_least(6, round.add("voro++", radii, Want::neighbors), votess);
        const Player votess_heavy = round.add("votess", heavy, Want::neighbors);
        round.at_most(3, votess_heavy, votess);
        round.at_most(1.3, votess_heavy, round.add("votess", fewer, Want::neighbors));
        scoreboard.play(round, often);
    }
    play_other_inputs(input, peers, goals, often, scoreboard);
    {
        const Input uniform = input("uniform", goals.large), clustered = input("clustered", goals.large);
        Round round(peers);
        const Player votess = add_uniform(round, uniform);
        round.at_least(1.9, votess, round.add("votess", uniform, Want::neighbors, 2));
        round.at_most(1.25, round.add("votess", clustered, Want::neighbors), votess);
        scoreboard.play(round, seldom);
        scoreboard.play(duel(peers, 7, "voro++", uniform, Want::full), seldom);
    }
    return finish(goals, versions, scoreboard);
}

}  // namespace bench

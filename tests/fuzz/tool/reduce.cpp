#include "fuzz/tool/reduce.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "fuzz/judge.hpp"

namespace test::fuzz {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto max_time = std::chrono::seconds(60);

class Reducer {
public:
    Reducer(Case c, const std::string& failure, const Limits& limits)
        : case_(std::move(c)), sort_(sort_of(failure)), limits_(limits) {
        // A hang need not be waited for as long as when it was found.
        limits_.seconds = std::min(limits_.seconds, 5u);
    }

    Case run() {
        for (bool changed = true; changed && in_time();) {
            changed = false;
            for (std::size_t k = case_.jobs.size(); k-- > 0 && case_.jobs.size() > 1;)
                changed |= attempt([&](Case& c) { c.jobs.erase(c.jobs.begin() + static_cast<std::ptrdiff_t>(k)); });
            for (std::size_t k = 0; k < case_.jobs.size(); ++k) {
                changed |= drop_seeds(k);
                changed |= simplify_options(k);
            }
        }
        for (std::size_t k = 0; k < case_.jobs.size(); ++k) round_numbers(k);
        return case_;
    }

private:
    [[nodiscard]] bool in_time() const { return Clock::now() - start_ < max_time; }

    template <class Change>
    bool attempt(Change change) {
        if (!in_time()) return false;
        Case c = case_;
        change(c);
        if (sort_of(judge_apart(c, limits_)) != sort_) return false;
        case_ = std::move(c);
        return true;
    }

    bool drop_seeds(std::size_t k) {
        bool changed = false;
        for (std::size_t step = (case_.jobs[k].size() + 1) / 2; step > 0; step /= 2)
            for (std::size_t end = case_.jobs[k].size(); end > 0 && case_.jobs[k].size() > 1;) {
                const std::size_t first = end > step ? end - step : 0;
                if (end <= case_.jobs[k].size() && end - first < case_.jobs[k].size())
                    changed |= attempt([&](Case& c) { c.jobs[k] = c.jobs[k].without(first, end); });
                end = first;
            }
        return changed;
    }

    bool simplify_options(std::size_t k) {
        bool changed = false;
        const auto reset = [&](auto Job::*member, const auto& to) {
            if (!(case_.jobs[k].*member == to)) changed |= attempt([&](Case& c) { c.jobs[k].*member = to; });
        };
        reset(&Job::weights, std::vector<double>{});
        reset(&Job::grid_resolution, 0u);
        reset(&Job::threads, 1u);
        reset(&Job::drop, false);
        reset(&Job::keep, false);
        reset(&Job::list_walls, false);
        reset(&Job::want, want_rows_and_volumes);
        if (case_.jobs[k].cell)
            for (std::size_t axis = 0; axis < 3; ++axis)
                if (!case_.jobs[k].cell->periodic[axis])
                    changed |= attempt([&](Case& c) { c.jobs[k].cell->periodic[axis] = true; });
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (case_.jobs[k].periodic[axis]) changed |= attempt([&](Case& c) { c.jobs[k].periodic[axis] = false; });
        // A domain that is left open is another matter.
        for (std::size_t w = case_.jobs[k].closed ? 0 : case_.jobs[k].walls.size(); w-- > 0;)
            changed |= attempt([&](Case& c) {
                auto& walls = c.jobs[k].walls;
                walls.erase(walls.begin() + static_cast<std::ptrdiff_t>(w));
            });
        for (std::size_t i = 0; i < case_.jobs[k].weights.size(); ++i)
            if (case_.jobs[k].weights[i] != 0) changed |= attempt([&](Case& c) { c.jobs[k].weights[i] = 0; });
        return changed;
    }

    // Each number to the fewest digits with which it still fails.
    void round_numbers(std::size_t k) {
        const auto numbers = [&](Job& job) {
            std::vector<double*> all;
            if (job.box)
                for (auto* v : {&job.box->lower, &job.box->upper})
                    for (double& x : *v) all.push_back(&x);
            if (job.cell)
                for (auto* v : {&job.cell->origin, &job.cell->a, &job.cell->b, &job.cell->c})
                    for (double& x : *v) all.push_back(&x);
            for (votess::Wall& wall : job.walls) {
                if (job.closed) break;
                for (double& x : wall.normal) all.push_back(&x);
                all.push_back(&wall.offset);
            }
            for (double& x : job.points) all.push_back(&x);
            for (double& x : job.weights) all.push_back(&x);
            return all;
        };
        const std::size_t count = numbers(case_.jobs[k]).size();
        if (count > 200) return;
        for (std::size_t n = 0; n < count; ++n)
            for (const int digits : {0, 1, 2, 4, 8, 12}) {
                const double before = *numbers(case_.jobs[k])[n];
                char text[40];
                std::snprintf(text, sizeof text, "%.*e", std::max(digits - 1, 0), before);
                const double after = digits == 0 ? 0 : std::strtod(text, nullptr);
                if (after == before) break;
                if (attempt([&](Case& c) { *numbers(c.jobs[k])[n] = after; })) break;
            }
    }

    Case case_;
    std::string sort_;
    Limits limits_;
    Clock::time_point start_ = Clock::now();
};

}  // namespace

Case reduce(Case c, const std::string& failure, const Limits& limits) {
    return Reducer(std::move(c), failure, limits).run();
}

}  // namespace test::fuzz

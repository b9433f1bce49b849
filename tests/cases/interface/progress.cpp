// The option `progress`: calls report it, stop when it returns false, and pass on its exceptions. Small enough for
// ThreadSanitizer.
#include "core/progress.hpp"

#include <doctest/doctest.h>
#include <votess/votess.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>
#include <votess/alpha.hpp>
#include <votess/diagram.hpp>
#include <votess/fit.hpp>
#include <votess/network.hpp>
#include <votess/progress.hpp>
#include <votess/zones.hpp>

#include "core/thread_pool.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"

namespace {

using votess::ProgressCallback;

struct Mine {};

// A call of the library that returns its numbers.
struct Call {
    const char* name;
    std::function<std::vector<double>(const ProgressCallback&)> run;
};

template <class Numbers>
std::vector<double> numbers(const Numbers& list) {
    return {list.begin(), list.end()};
}

// Returns each kind of call, and each query once for each of its methods.
std::vector<Call> calls_of(const votess::Diagram& diagram, const test::PointSet& set, const test::PointSet& queries) {
    const auto natural = [&diagram, &queries](const ProgressCallback& progress, votess::NaturalMethod method) {
        votess::NaturalOptions options;
        options.method = method;
        options.progress = progress;
        return numbers(diagram.natural_neighbors(queries.points, options).weights);
    };
    const auto tessellator = std::make_shared<votess::Tessellator>();
    std::vector<Call> calls{
        {"tessellate",
         [&set, tessellator](const ProgressCallback& progress) {
             votess::Options options = test::all_options(set.box);
             options.threads = 3;
             options.progress = progress;
             return numbers(tessellator->tessellate(set.points, options).volumes());
         }},
        {"tessellate without a box",
         [&set](const ProgressCallback& progress) {
             votess::Options options;
             constexpr double inf = std::numeric_limits<double>::infinity();
             options.box = votess::Box{{-inf, -inf, -inf}, {inf, inf, inf}};
             options.want.volumes = true;
             options.progress = progress;
             return numbers(votess::tessellate(set.points, options).volumes());
         }},
        {"Diagram",
         [&](const ProgressCallback& progress) {
             votess::Options options;
             options.progress = progress;
             return numbers(votess::Diagram(set.points, options).locate(queries.points));
         }},
        {"locate", [&](const ProgressCallback& p) { return numbers(diagram.locate(queries.points, p)); }},
        {"probe",
         [&](const ProgressCallback& p) {
             votess::ProbeOptions options;
             options.want.faces = true;
             options.progress = p;
             return numbers(diagram.probe(queries.points, options).vertices());
         }},
        {"natural", [=](const ProgressCallback& p) { return natural(p, votess::NaturalMethod::sibson); }},
        {"laplace", [=](const ProgressCallback& p) { return natural(p, votess::NaturalMethod::laplace); }},
        {"interpolate", [&](const ProgressCallback& p) {
             votess::NaturalOptions options;
             options.gradients = true;
             options.progress = p;
             return diagram.interpolate(set.points, 3, queries.points, options).values;
         }}};
    for (int method = 0; method < 4; ++method)
        calls.push_back({"to_grid", [&, method](const ProgressCallback& p) {
                             votess::GridOptions grid{{9, 7, 8}, static_cast<votess::GridMethod>(method), 3};
                             grid.progress = p;
                             std::vector<double> field(9 * 7 * 8 * 3);
                             (void)diagram.to_grid(set.points, grid, field);
                             return field;
                         }});
    calls.push_back({"fit_volumes", [&set](const ProgressCallback& progress) {
                         votess::Options options = test::all_options(set.box);
                         options.progress = progress;
                         const std::vector<double> shares(set.points.size() / 3, 1.0);
                         return votess::fit_volumes(set.points, shares, options, {.normalize = true}).weights;
                     }});
    return calls;
}

}  // namespace

TEST_SUITE("interface") {
    // A callback that takes as long as the pause between two calls is called at each look.
    constexpr std::chrono::milliseconds pause{101};

    TEST_CASE("progress: calls report from 0 to 1, stop, pass exceptions on, and answer the next call") {
        const test::PointSet set = test::uniform(600, 81), queries = test::uniform(700, 82);
        votess::Options options;
        options.threads = 3;
        options.box = set.box;
        const votess::Diagram diagram(set.points, options), other(set.points, options);
        const auto expected = calls_of(other, set, queries);
        const auto calls = calls_of(diagram, set, queries);
        for (std::size_t k = 0; k < calls.size(); ++k) {
            CAPTURE(calls[k].name);
            CAPTURE(k);
            // First, because the first of Sibson's calls makes the graph.
            int count = 0;
            const auto code = test::error_of([&] {
                (void)calls[k].run([&](double) {
                    if (++count == 3) return false;
                    std::this_thread::sleep_for(pause);
                    return true;
                });
            });
            CHECK(code == votess::ErrorCode::cancelled);
            CHECK(count == 3);
            count = 0;
            CHECK_THROWS_AS((void)calls[k].run([&](double) {
                if (++count == 2) throw Mine{};
                std::this_thread::sleep_for(pause);
                return true;
            }),
                            Mine);
            std::vector<double> fractions;
            const auto found = calls[k].run([&](double fraction) {
                fractions.push_back(fraction);
                return true;
            });
            CHECK(std::ranges::is_sorted(fractions));
            CHECK(fractions.size() >= 2);
            CHECK(fractions.front() == 0);
            CHECK(fractions.back() == 1);
            CHECK(found == expected[k].run({}));
        }
    }

    TEST_CASE("progress: fractions of a query that makes cells first grow within it") {
        const test::PointSet set = test::uniform(test::by_size(20000, 2000), 83),
                             queries = test::uniform(test::by_size(20000, 2000), 84);
        const votess::Diagram diagram(set.points);
        const auto calls = calls_of(diagram, set, queries);
        for (const Call& call : {calls[5], calls[8], calls[9]}) {
            CAPTURE(call.name);
            std::vector<double> fractions;
            (void)call.run([&](double fraction) {
                fractions.push_back(fraction);
                if (fractions.size() < 5) std::this_thread::sleep_for(pause);
                return true;
            });
            CHECK(std::ranges::is_sorted(fractions));
            CHECK(fractions.back() == 1);
            CHECK(std::ranges::count_if(fractions, [](double f) { return f > 0 && f < 1; }) > 0);
        }
    }

    TEST_CASE("progress: a callback that asks its own Diagram is refused; a call that waits for another can stop") {
        const test::PointSet set = test::uniform(300, 85);
        const votess::Diagram diagram(set.points), other(set.points);
        const auto expected = other.locate(set.points);
        CHECK(test::error_of([&] {
                  (void)diagram.locate(set.points, [&](double fraction) {
                      CHECK(other.locate(set.points) == expected);
                      return fraction == 0 || !diagram.locate(set.points).empty();
                  });
              }) == std::nullopt);  // the last callback of a query may ask again
        std::string message;
        const auto asks_itself = [&] {
            votess::ProbeOptions options;
            options.progress = [&, calls = 0](double) mutable {
                if (++calls == 3) return !diagram.locate(set.points).empty();
                std::this_thread::sleep_for(pause);
                return true;
            };
            (void)diagram.probe(set.points, options);
        };
        CHECK(test::error_of(asks_itself, &message) == votess::ErrorCode::invalid_use);
        CHECK(message.find("callback") != std::string::npos);

        std::atomic<bool> at_work = false, stopped = false;
        std::jthread worker([&] {
            (void)diagram.locate(set.points, [&, calls = 0](double) mutable {
                if (++calls == 1) std::this_thread::sleep_for(pause);
                if (calls != 2) return true;
                at_work = true;
                at_work.notify_all();
                stopped.wait(false);
                return true;
            });
        });
        at_work.wait(false);
        CHECK(test::error_of([&] {
                  (void)diagram.locate(set.points, [calls = 0](double) mutable { return ++calls < 2; });
              }) == votess::ErrorCode::cancelled);
        stopped = true;
        stopped.notify_all();
        worker.join();
        CHECK(diagram.locate(set.points) == expected);
    }

    TEST_CASE("progress: tessellate() stops in each stage, and the Tessellator serves on") {
        const test::PointSet set = test::uniform(3000, 86);
        votess::Options options = test::all_options(set.box);
        options.threads = 3;
        options.device = "cpu";
        options.want.faces = true;
        const auto expected = votess::tessellate(set.points, options);
        votess::Tessellator tessellator;
        for (const int last : {1, 3, 9}) {
            CAPTURE(last);
            int count = 0;
            options.progress = [&](double) {
                if (++count == last) return false;
                if (count > last - 3) std::this_thread::sleep_for(pause);  // else the earlier looks pass
                return true;
            };
            const auto code = test::error_of([&] { (void)tessellator.tessellate(set.points, options); });
            CHECK((code == votess::ErrorCode::cancelled) == (count >= last));
        }
        options.progress = nullptr;
        CHECK(test::check_identical(expected, tessellator.tessellate(set.points, options)) == "");
    }

    TEST_CASE("progress: a task of any thread stops soon, also while the calling thread only waits") {
        votess::ThreadPool pool(3);
        int calls = 0;
        votess::Progress progress([&](double) { return ++calls < 3; });
        std::atomic<int> running = 0, done = 0;
        const auto endless = [&](std::size_t, unsigned worker) {
            ++running;
            while (worker != 0 || running < 2) votess::check_stop(), std::this_thread::yield();
        };
        {
            const votess::Stoppable stoppable(progress);
            CHECK(test::error_of([&] { pool.run(2, endless); }) == votess::ErrorCode::cancelled);
        }
        CHECK(calls == 3);
        pool.run(5, [&](std::size_t, unsigned) { ++done; });
        CHECK(done == 5);
    }

    TEST_CASE("progress: work before a stage reports no advance, so that fractions never fall") {
        votess::ThreadPool pool(1);
        const auto slow = [](std::size_t, unsigned) { std::this_thread::sleep_for(std::chrono::milliseconds(60)); };
        std::vector<double> fractions;
        votess::Progress progress([&](double fraction) {
            fractions.push_back(fraction);
            return true;
        });
        {
            const votess::Stoppable reading(progress);
            pool.run_stage(4, slow);
        }
        CHECK(fractions.size() >= 2);
        CHECK(std::ranges::count(fractions, 0.0) == std::ssize(fractions));
        const votess::Stoppable clipping(progress, {0.25, 0.75});
        pool.run_stage(4, slow);
        CHECK(std::ranges::is_sorted(fractions));
        CHECK(fractions.back() > 0.25);
        CHECK(fractions.back() <= 0.75);
    }

    TEST_CASE("progress: a ProgressScope stops calls that take no callback") {
        const test::PointSet set = test::uniform(600, 87);
        votess::Options options = test::all_options(set.box);
        options.device = "cpu";
        options.want.faces = true;
        const auto inside = votess::tessellate(set.points, options);
        options.periodic = {true, true, true};
        const auto t = votess::tessellate(set.points, options);
        const votess::Network network = votess::network(t, set.points);
        const std::vector<double> values = numbers(t.volumes());
        const std::vector<std::pair<std::string, std::function<std::vector<double>()>>> all{
            {"delaunay", [&] { return numbers(votess::delaunay(t).tetrahedra); }},
            {"network", [&] { return votess::network(t, set.points).edge_radii; }},
            {"largest_free", [&] { return std::vector{network.largest_free().value().radius}; }},
            {"alpha_complex", [&] { return votess::alpha_complex(t, set.points).simplices[3].values; }},
            {"alpha_complex in a box", [&] { return votess::alpha_complex(inside, set.points).simplices[3].values; }},
            {"watershed", [&] { return numbers(votess::watershed(t, values).labels); }},
            {"verify", [&] { return std::vector{votess::verify(t, set.points).passed ? 1.0 : 0.0}; }}};
        for (const auto& [name, call] : all) {
            CAPTURE(name);
            const std::vector<double> expected = call();
            int count = 0;
            const auto stops = [&](int last) {
                return [&, last](double) {
                    if (++count == last) return false;
                    std::this_thread::sleep_for(pause);
                    return true;
                };
            };
            for (const int last : {1, 2}) {
                count = 0;
                const votess::ProgressScope scope(stops(last));
                CHECK(test::error_of([&] { (void)call(); }) == votess::ErrorCode::cancelled);
                CHECK(count == last);
            }
            {
                const votess::ProgressScope scope([](double) -> bool { throw Mine{}; });
                CHECK_THROWS_AS((void)call(), Mine);
                const votess::ProgressScope inner([](double) { return true; });
                CHECK(call() == expected);
            }
            CHECK(call() == expected);
        }
        // In C a callback of the thread does the same.
        votess_options c_options;
        REQUIRE(votess_options_init(&c_options, sizeof c_options) == VOTESS_OK);
        c_options.want = VOTESS_WANT_NEIGHBORS | VOTESS_WANT_FACES;
        votess_result* result = nullptr;
        votess_delaunay* dual = nullptr;
        REQUIRE(votess_tessellate(nullptr, set.points.data(), 600, &c_options, &result) == VOTESS_OK);
        const auto dual_status = [&] { return votess_delaunay_new(result, &dual); };
        int user = 0;
        votess_set_progress([](double, void* calls) { return ++*static_cast<int*>(calls) < 0 ? 1 : 0; }, &user);
        CHECK(dual_status() == VOTESS_ERROR_CANCELLED);
        CHECK(user == 1);
        votess_set_progress([](double, void*) -> int { throw Mine{}; }, nullptr);
        CHECK(dual_status() == VOTESS_ERROR_CANCELLED);
        CHECK(std::string(votess_last_error()) == "the callback progress threw an exception of unknown type");
        votess_set_progress(nullptr, nullptr);
        CHECK(dual_status() == VOTESS_OK);
        votess_delaunay_free(dual);
        votess_result_free(result);
    }

    TEST_CASE("progress: C reports what a callback throws") {
        const test::PointSet set = test::uniform(50, 88);
        votess_options options;
        REQUIRE(votess_options_init(&options, sizeof options) == VOTESS_OK);
        const auto said = [&](auto progress) {
            options.progress = progress;
            votess_result* result = nullptr;
            CHECK(votess_tessellate(nullptr, set.points.data(), 50, &options, &result) == VOTESS_ERROR_CANCELLED);
            CHECK(result == nullptr);
            const std::string first = votess_last_error();
            votess_diagram *diagram = nullptr, *view = nullptr;
            CHECK(votess_diagram_new(set.points.data(), 50, &options, &diagram) == VOTESS_ERROR_CANCELLED);
            CHECK(diagram == nullptr);
            CHECK(votess_diagram_new(set.points.data(), 50, nullptr, &diagram) == VOTESS_OK);
            CHECK(votess_diagram_view(diagram, &options, &view) == VOTESS_OK);
            std::vector<std::int32_t> seeds(50);
            CHECK(votess_diagram_locate(view, set.points.data(), 50, seeds.data()) == VOTESS_ERROR_CANCELLED);
            CHECK(first == votess_last_error());
            CHECK(votess_diagram_locate(diagram, set.points.data(), 50, seeds.data()) == VOTESS_OK);
            votess_diagram_free(view);
            votess_diagram_free(diagram);
            return first;
        };
        CHECK(said([](double, void*) -> int { throw std::runtime_error("no more"); }) ==
              "the callback progress threw an exception: no more");
        CHECK(said([](double, void*) -> int { throw Mine{}; }) ==
              "the callback progress threw an exception of unknown type");
    }
}

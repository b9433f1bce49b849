// What a child made by fork() does with the Tessellators and results of its parent, whose threads it has not.
#include <doctest/doctest.h>
#include <sys/resource.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "support/check.hpp"
#include "support/child.hpp"

namespace {

votess::Options with_threads(unsigned threads) {
    votess::Options options = test::all_options(test::unit_box());
    options.threads = threads;
    return options;
}

}  // namespace

TEST_SUITE("forks") {
    TEST_CASE("forks: the child uses and destroys the Tessellator of its parent, with threads of its own") {
        const test::PointSet set = test::uniform(5000, 171), other = test::uniform(300, 172);
        for (const unsigned threads : {1u, 2u, 4u}) {
            CAPTURE(threads);
            auto tessellator = std::make_unique<votess::Tessellator>();
            const auto options = with_threads(threads);
            const auto expected = tessellator->tessellate(set.points, options);
            const auto same = [&] {
                return test::check_identical(expected, tessellator->tessellate(set.points, options));
            };
            CHECK(test::in_child([&] {
                      auto failure = same();
                      if (failure.empty()) failure = same();
                      tessellator.reset();
                      return failure;
                  }) == "");
            CHECK(test::in_child([&] {  // unused
                      tessellator.reset();
                      return "";
                  }) == "");
            CHECK(test::in_child([&] {
                      votess::Tessellator moved = std::move(*tessellator);
                      *tessellator = votess::Tessellator();
                      moved = std::move(*tessellator);
                      return test::check_invariants(moved.tessellate(other.points, with_threads(3)), other.points);
                  }) == "");
            // And its child in turn.
            CHECK(test::in_child([&] {
                      if (auto failure = same(); !failure.empty()) return failure;
                      return test::in_child(same);
                  }) == "");
            CHECK(same() == "");
        }
    }

    TEST_CASE("forks: the child reads, checks and drops results of its parent") {
        const test::PointSet set = test::uniform(2000, 173);
        votess::Tessellator tessellator;
        auto t = tessellator.tessellate(set.points, with_threads(3));
        CHECK(test::in_child([&] {
                  auto failure = test::check_invariants(t, set.points);
                  if (failure.empty()) failure = votess::verify(t, set.points).failure;
                  t = {};
                  return failure;
              }) == "");
        CHECK(test::check_invariants(t, set.points) == "");
    }

    TEST_CASE("forks: a Tessellator that was at work during the fork refuses the child, which may destroy it") {
        const test::PointSet set = test::uniform(5000, 174);
        auto tessellator = std::make_unique<votess::Tessellator>();
        auto options = with_threads(2);
        const auto expected = tessellator->tessellate(set.points, options);
        std::atomic<bool> at_work = false, go_on = false;
        std::string failure;
        {
            std::jthread worker([&] {
                auto waiting = options;
                waiting.progress = [&](double) {
                    at_work = true;
                    at_work.notify_all();
                    go_on.wait(false);
                    return true;
                };
                failure = test::check_identical(expected, tessellator->tessellate(set.points, waiting));
            });
            at_work.wait(false);
            CHECK(test::in_child([&]() -> std::string {
                      try {
                          (void)tessellator->tessellate(set.points, options);
                          return "no error";
                      } catch (const votess::Error& error) {
                          if (error.code() != votess::ErrorCode::invalid_use) return error.what();
                      }
                      tessellator.reset();
                      return test::check_identical(expected, votess::Tessellator().tessellate(set.points, options));
                  }) == "");
            go_on = true;
            go_on.notify_all();
        }
        CHECK(failure == "");
    }

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they take all addresses
    TEST_CASE("forks: threads that the system does not give are named, and fewer do where none were requested") {
        const test::PointSet set = test::uniform(50, 87);
        const std::string failure = test::in_child([&]() -> std::string {
            const rlimit room{rlim_t{1} << 30, rlim_t{1} << 30};  // stacks of 8 MB each
            setrlimit(RLIMIT_AS, &room);
            std::string message;
            votess::Options options;
            options.device = "cpu";
            options.threads = 1024;
            votess::Tessellator tessellator;
            for (int repeat = 0; repeat < 2; ++repeat) {
                const auto code = test::error_of([&] { (void)tessellator.tessellate(set.points, options); }, &message);
                if (code != votess::ErrorCode::no_threads) return "no error: " + message;
            }
            if (!message.starts_with("Options::threads = 1024, but the system gives only ")) return message;
            for (const unsigned threads : {2u, 0u}) {
                options.threads = threads;
                if (tessellator.tessellate(set.points, options).size() != 50) return "no cells";
            }
            return "";
        });
        CHECK(failure == "");
    }
#endif
}

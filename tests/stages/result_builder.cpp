// The result builder beside the engines: how rows wait, and sums that do not depend on threads.
#include "result/result_builder.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "domain/domain.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

using votess::Arena;
using votess::ResultBuilder;
using votess::ThreadPool;

TEST_SUITE("stages") {
    TEST_CASE("arena: pieces do not overlap, and come from the same memory again") {
        Arena arena;
        test::Random random(2);
        for (int round = 0; round < 20; ++round) {
            arena.reset(std::size_t{1} << (6 + random.below(8)));
            std::vector<std::span<std::byte>> pieces;
            for (int i = 0; i < 200; ++i) {
                const std::size_t size = random.below(random.chance(0.1) ? 5000 : 50);
                pieces.emplace_back(arena.take(size), size);
                REQUIRE(reinterpret_cast<std::uintptr_t>(pieces.back().data()) % 8 == 0);
                std::memset(pieces.back().data(), i, size);
            }
            for (std::size_t i = 0; i < pieces.size(); ++i)
                REQUIRE(std::ranges::all_of(pieces[i], [&](std::byte b) { return b == std::byte(i); }));
        }
        arena.reset(1000);
        const std::byte* first = arena.take(10);
        arena.reset(1000);
        CHECK(arena.take(10) == first);
    }

    TEST_CASE("result builder: rows wait in any order and come to their places") {
        const std::size_t count = 1000;
        const std::vector<float> points(3 * count);
        votess::Job job;
        job.domain = std::make_shared<const votess::Domain>();
        job.points.f32 = points;
        job.options.want = {.neighbors = true, .volumes = false};
        ThreadPool pool(3);
        ResultBuilder builder;
        builder.begin(job, pool);
        const auto last = static_cast<std::int32_t>(count) - 1;
        const std::vector<std::int32_t> cells{last, 5, last - 1, 0};
        builder.add_rows(cells, std::vector<std::uint32_t>{3, 2, 0, 1},
                         std::vector<std::int32_t>{-6, 0, 5, -1, last, last});
        builder.copy_rows(std::span(cells).subspan(2, 1), std::vector<std::uint32_t>{1}, std::vector<std::int32_t>{7});
        votess::detail::Result result;
        builder.finish(result, pool);
        CHECK(std::ranges::equal(result.indices, std::vector<std::int32_t>{last, -1, last, 7, -6, 0, 5}));
        CHECK(result.indptr[1] == 1);
        CHECK(result.indptr[5] == 1);
        CHECK(result.indptr[6] == 3);
        CHECK(result.indptr[count - 2] == 3);
        CHECK(result.indptr[count - 1] == 4);
        CHECK(result.indptr[count] == 7);
    }

    TEST_CASE("result builder: the sum of volumes is that of any number of threads, and right to its last digits") {
        const std::size_t count = 300000;
        const std::vector<double> points(3 * count);
        votess::Job job;
        job.domain = std::make_shared<const votess::Domain>();
        job.points.f64 = points;
        job.options.want = {.neighbors = false, .volumes = true};
        test::Random random(3);
        std::vector<double> volumes(count);
        long double exact = 0;
        for (double& v : volumes) exact += v = std::exp(random.uniform(-30, 30));
        double first = 0;
        for (const unsigned threads : {1u, 2u, 5u}) {
            ThreadPool pool(threads);
            ResultBuilder builder;
            votess::detail::Result result;
            builder.begin(job, pool);
            std::ranges::copy(volumes, builder.volumes().begin());
            builder.finish(result, pool);
            if (threads == 1) first = result.stats.volume_sum;
            CHECK(result.stats.volume_sum == first);
            CHECK(std::abs(result.stats.volume_sum - static_cast<double>(exact)) <= 1e-15 * first);
            CHECK(std::ranges::equal(result.volumes, volumes));
            builder.begin(job, pool);
            std::ranges::fill(builder.volumes(), 1e306);
            builder.volumes()[70000] = HUGE_VAL;
            builder.finish(result, pool);
            CHECK(result.stats.volume_sum == HUGE_VAL);
        }
    }

    TEST_CASE("result builder: the first cell that was left over is named, whatever the threads") {
        const std::size_t count = 500000;
        const std::vector<double> points(3 * count);
        votess::Job job;
        job.domain = std::make_shared<const votess::Domain>();
        job.points.f64 = points;
        ThreadPool pool(4);
        for (int round = 0; round < 10; ++round) {
            ResultBuilder builder;
            votess::detail::Result result;
            builder.begin(job, pool);
            for (const std::size_t i : {123456, 499999, 300000, 123457})
                builder.status()[i] = votess::CellStatus::needs_exact;
            std::string message;
            try {
                builder.finish(result, pool);
            } catch (const votess::Error& error) {
                message = error.what();
            }
            CHECK(message.find("cell 123456 ") != std::string::npos);
        }
    }
}

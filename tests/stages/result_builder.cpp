// The result builder beside the engines: how rows wait, and sums that do not depend on threads.
#include "output/result_builder.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>

#include "domain/domain.hpp"
#include "exact/quad.hpp"
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
                pieces.emplace_back(arena.allocate(size), size);
                REQUIRE(reinterpret_cast<std::uintptr_t>(pieces.back().data()) % 8 == 0);
                std::memset(pieces.back().data(), i, size);
            }
            for (std::size_t i = 0; i < pieces.size(); ++i)
                REQUIRE(std::ranges::all_of(pieces[i], [&](std::byte b) { return b == std::byte(i); }));
        }
        arena.reset(1000);
        const std::byte* first = arena.allocate(10);
        arena.reset(1000);
        CHECK(arena.allocate(10) == first);
    }

    TEST_CASE("result builder: rows wait in any order and come to their places") {
        const std::size_t count = 1000;
        const std::vector<float> points(3 * count);
        votess::Job job;
        job.domain = std::make_shared<const votess::Domain>();
        job.points.f32 = points;
        job.want = {.neighbors = true, .volumes = false};
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

    TEST_CASE("result builder: shifts come to their entries, also in memory that was used") {
        const std::vector<float> points(3 * 7);
        auto domain = std::make_shared<votess::Domain>();
        domain->periodic = {true, true, true};
        votess::Job job;
        job.domain = domain;
        job.points.f32 = points;
        job.want = {.neighbors = true, .volumes = false};
        ThreadPool pool(2);
        ResultBuilder builder;
        votess::detail::Result result;
        const std::vector<std::int32_t> cells{6, 0, 5, 2};
        const std::vector<std::uint32_t> lengths{2, 3, 0, 1};
        const std::vector<std::int32_t> ids{1, 1, 2, 3, 4, 0};
        for (int call = 0; call < 2; ++call) {  // each of them has shifts where the other has none
            const auto other = static_cast<std::int8_t>(call), one = static_cast<std::int8_t>(1 - call);
            const std::vector<std::int8_t> shifts{0, other, 0,   one, 0, -2, 0,    0, other,
                                                  0, 0,     127, 0,   0, 0,  -128, 0, one};
            job.arrays = call == 0 ? nullptr : &result;
            builder.begin(job, pool);
            builder.add_rows(cells, lengths, ids, {{}, {}, shifts});
            builder.copy_rows(std::span(cells).subspan(2, 1), std::vector<std::uint32_t>{1},
                              std::vector<std::int32_t>{6}, {{}, {}, std::vector<std::int8_t>{0, 0, one}});
            votess::detail::Result next;
            builder.finish(next, pool);
            result = std::move(next);
            // The rows of 0, 2, 5, 6.
            CHECK(std::ranges::equal(result.indices, std::vector<std::int32_t>{2, 3, 4, 0, 6, 1, 1}));
            CHECK(std::ranges::equal(result.shifts,
                                     std::vector<std::int8_t>{0,   0, other, 0,   0, 127,   0, 0,   0, -128, 0,
                                                              one, 0, 0,     one, 0, other, 0, one, 0, -2}));
        }
    }

    TEST_CASE("result builder: rows in the order of the input go around those that waited") {
        const std::vector<float> points(3 * 7);
        votess::Job job;
        job.domain = std::make_shared<const votess::Domain>();
        job.points.f32 = points;
        job.want = {.neighbors = true, .volumes = false};
        ThreadPool pool(2);
        const std::vector<std::int32_t> waiting{0, 3, 4};
        const auto make = [&](const std::vector<std::uint32_t>& later, auto&& place) {
            ResultBuilder builder;
            builder.begin(job, pool);
            builder.add_rows(waiting, std::vector<std::uint32_t>{1, 2, 1}, std::vector<std::int32_t>{-1, -2, -3, -4});
            votess::detail::Result result;
            builder.settle(later, pool);
            place(builder);
            builder.finish(result, pool);
            return result;
        };
        const std::vector<std::uint32_t> later{0, 2, 1, 0, 0, 0, 3};
        const std::vector<std::int32_t> ids{11, 12, 21, 61, 62, 63};
        const auto all = make(later, [&](ResultBuilder& builder) {
            builder.place_rows(2, std::span(later).subspan(2), std::span(ids).subspan(2));
            builder.place_rows(0, std::span(later).first(2), std::span(ids).first(2));
        });
        CHECK(std::ranges::equal(all.indices, std::vector<std::int32_t>{-1, 11, 12, 21, -2, -3, -4, 61, 62, 63}));
        CHECK(std::ranges::equal(all.indptr, std::vector<std::int64_t>{0, 1, 3, 4, 6, 7, 7, 10}));
        const auto refused = [&](const std::vector<std::uint32_t>& told, std::size_t first, std::size_t count,
                                 std::size_t entries, const std::vector<std::uint32_t>& lengths) {
            try {
                make(told, [&](ResultBuilder& builder) {
                    builder.place_rows(first, std::span(lengths).subspan(first, count), std::span(ids).first(entries));
                });
            } catch (const votess::Error& error) {
                return error.code() == votess::ErrorCode::internal;
            }
            return false;
        };
        CHECK(!refused(later, 0, 7, 6, later));
        CHECK(refused({1, 2, 1, 0, 0, 0, 3}, 0, 1, 0, later));  // a cell with two rows
        CHECK(refused({0, 2}, 0, 1, 0, later));
        CHECK(refused(later, 0, 7, 5, later));
        CHECK(refused(later, 0, 3, 4, later));
        CHECK(refused(later, 0, 7, 6, {0, 1, 2, 0, 0, 0, 3}));
        CHECK(refused(later, 3, 5, 3, {0, 0, 0, 0, 0, 0, 3, 0}));
    }

    TEST_CASE("result builder: pages touched early change no row, for any number of expected rows") {
        const std::size_t count = 200000, length = 4;
        const std::vector<float> points(3 * count);
        votess::Job job;
        job.domain = std::make_shared<const votess::Domain>();
        job.points.f32 = points;
        job.want = {.neighbors = true, .volumes = true, .centroids = true};
        ThreadPool pool(3);
        ResultBuilder builder;
        std::vector<std::int32_t> ids(length * count);
        std::iota(ids.begin(), ids.end(), 0);
        const std::vector<std::uint32_t> lengths(count, length);
        for (const double expected : {0.0, 1.0, 4.0, 20.0}) {
            builder.begin(job, pool);
            builder.arrays().volumes[count - 1] = 7;
            builder.touch(0.3, 0, pool);
            builder.touch(0.6, expected, pool);
            builder.arrays().centroids[0] = 8;
            builder.touch(1, expected, pool);
            builder.settle(lengths, pool);
            builder.place_rows(0, lengths, ids);
            votess::detail::Result result;
            builder.finish(result, pool);
            CHECK(std::ranges::equal(result.indices, ids));
            CHECK(result.volumes[count - 1] == 7);
            CHECK(result.centroids[0] == 8);
        }
    }

    TEST_CASE("result builder: the sum of volumes is that of any number of threads, and right to its last digits") {
        const std::size_t count = 300000;
        const std::vector<double> points(3 * count);
        votess::Job job;
        job.domain = std::make_shared<const votess::Domain>();
        job.points.f64 = points;
        job.want = {.neighbors = false, .volumes = true};
        test::Random random(3);
        std::vector<double> volumes(count);
        votess::exact::Quad exact = 0;
        for (double& v : volumes) exact += (v = std::exp(random.uniform(-30, 30)));
        double first = 0;
        for (const unsigned threads : {1u, 2u, 5u}) {
            ThreadPool pool(threads);
            ResultBuilder builder;
            votess::detail::Result result;
            builder.begin(job, pool);
            std::ranges::copy(volumes, builder.arrays().volumes.begin());
            builder.finish(result, pool);
            if (threads == 1) first = result.stats.volume_sum;
            CHECK(result.stats.volume_sum == first);
            CHECK(std::abs(result.stats.volume_sum - static_cast<double>(exact)) <= 1e-15 * first);
            CHECK(std::ranges::equal(result.volumes, volumes));
            builder.begin(job, pool);
            std::ranges::fill(builder.arrays().volumes, 1e306);
            builder.arrays().volumes[70000] = HUGE_VAL;
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
                builder.arrays().status[i] = votess::CellStatus::needs_exact;
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

// The schedule of pieces: cells left to the CPU do not depend on the sizes of pieces.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/arithmetic.hpp"
#include "gpu/schedule.hpp"
#include "support/random.hpp"

using votess::gpu::Piece;
using votess::gpu::Schedule;

namespace {

constexpr std::uint32_t window = 10 * 1024;

// Returns a letter for each 1,024 seeds: left to the CPU, or clipped with one tier or two. Cell i is hopeless for the
// device where hard(i / 1024). Two pieces are in flight at a time, with random sizes.
std::string run(std::uint32_t seeds, auto hard, test::Random random) {
    Schedule schedule(seeds, window);
    std::string out(votess::ceil_div(seeds, 1024u), '?');
    std::vector<Piece> running;
    const auto finish = [&] {
        const Piece piece = running.front();
        running.erase(running.begin());
        std::size_t left = 0;
        for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i) left += hard(i / 1024) ? 1 : 0;
        schedule.note(piece, piece.count, left, left, 0);
    };
    std::uint32_t next = 0;
    const auto most = [&] { return static_cast<std::uint32_t>(random.uniform(1024, 12000)); };
    while (const auto piece = schedule.next(most())) {
        CHECK(piece->first == next);
        next += piece->count;
        for (std::uint32_t i = piece->first; i < next; i += 1024)
            out[i / 1024] = !piece->on_device ? 'c' : (piece->second_tier ? '2' : '1');
        if (piece->on_device) running.push_back(*piece);
        while (running.size() > (piece->trial ? 0u : 1u)) finish();
    }
    CHECK(next == seeds);
    return out;
}

std::string always_the_same(std::uint32_t seeds, auto hard) {
    test::Random random(61);
    const std::string first = run(seeds, hard, random);
    for (std::uint64_t round = 0; round < 20; ++round) CHECK(run(seeds, hard, test::Random(round)) == first);
    return first;
}

}  // namespace

TEST_SUITE("gpu schedule") {
    TEST_CASE("gpu schedule: all cells are the device's where it succeeds") {
        CHECK(always_the_same(45'000, [](std::uint32_t) { return false; }) == std::string(44, '2'));
    }

    TEST_CASE("gpu schedule: a hopeless part is left to the CPU after a trial") {
        // The first trial has both tiers. Trials follow after 1, 3 and 7 windows more.
        const std::string found = always_the_same(40 * window, [](std::uint32_t) { return true; });
        CHECK(found.substr(0, 10) == "22cccccccc");
        CHECK(std::ranges::count(found, '2') == 2);
        CHECK(std::ranges::count(found, '1') == 2 * 4);
        CHECK(found.substr(20, 3) == "11c");
    }

    TEST_CASE("gpu schedule: a trial with many ties begins anew") {
        Schedule schedule(3 * window, window);
        const auto piece = [&] { return schedule.next(window).value(); };
        const Piece trial = piece();
        CHECK(trial.trial);
        CHECK_FALSE(trial.ties);
        CHECK_FALSE(schedule.repeat_with_ties(trial, 20));
        CHECK(schedule.repeat_with_ties(trial, trial.count));
        const Piece again = piece();
        CHECK((again.first == 0 && again.count == trial.count && again.trial && again.ties));
        CHECK_FALSE(schedule.repeat_with_ties(again, trial.count));
        schedule.note(again, again.count, 0, 0, 0);
        CHECK((piece().first == again.count && piece().ties));
    }

    TEST_CASE("gpu schedule: windows with many ties are noticed") {
        Schedule schedule(5 * window, window);
        std::string found;
        while (const auto piece = schedule.next(window)) {
            found += piece->ties ? 't' : '-';
            schedule.note(*piece, piece->count, 0, 0, piece->ties ? 0 : piece->count / 10);
        }
        CHECK(found == "---ttt");  // a trial, two windows
    }

    TEST_CASE("gpu schedule: hopeless windows are noticed, and the end of them") {
        const std::string found = always_the_same(20 * window, [](std::uint32_t k) { return k >= 30 && k < 80; });
        CHECK(found.substr(0, 50) == std::string(50, '2'));  // it is known after two windows
        CHECK(found.substr(50, 10) == std::string(10, 'c'));
        CHECK(found.substr(100) == std::string(100, '1'));
    }
}

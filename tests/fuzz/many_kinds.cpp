// The kinds of kinds.hpp, with fixed numbers; each set in a process of its own, which may crash or hang.
// Findings of the long mode are kept in tests/fuzz/found, by what was wrong. VOTESS_FUZZ_PERCENT: of the usual count;
// VOTESS_FUZZ_SEED: the first number. tools/fuzz.sh runs the same for hours.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "fuzz/isolate.hpp"
#include "fuzz/kinds/kinds.hpp"
#include "support/check.hpp"

namespace {

using namespace test::fuzz;

std::uint64_t sets_of(const Kind& kind) {
    const std::uint64_t usual = kind.name == "many" ? 4 : kind.name == "jobs" ? 20 : kind.name == "wrapped" ? 200 : 60;
    return std::max<std::uint64_t>(
        1, test::by_size(usual, usual / 10) * test::environment("VOTESS_FUZZ_PERCENT", 100) / 100);
}

}  // namespace

TEST_SUITE("fuzz") {
    TEST_CASE("sets of many kinds are right cell by cell") {
        const std::uint64_t first = test::environment("VOTESS_FUZZ_SEED", 1);
        for (const Kind& kind : all_kinds()) {
            int failures = 0;
            for (std::uint64_t number = first; number < first + sets_of(kind) && failures < 3; ++number) {
                INFO(kind.name << ' ' << number);  // doctest prints it after a crash too
                const Case c = make_case(kind, number);
                const std::string failure = judge_apart(c, {});
                if (failure.empty()) continue;
                ++failures;
                std::ostringstream source;
                if (kind.name != "many") write(c, source);
                FAIL_CHECK(failure << '\n' << source.str());
            }
        }
    }

    TEST_CASE("what was once found stays right") {
        std::size_t found = 0;
        for (const auto& entry : std::filesystem::directory_iterator(VOTESS_FUZZ_FOUND)) {
            ++found;
            CAPTURE(entry.path().filename().string());
            std::ifstream in(entry.path());
            CHECK(judge_apart(read(in), {}) == "");
        }
        CHECK(found >= 12);
    }

    TEST_CASE("a case that is written and read again is the same") {
        for (const Kind& kind : all_kinds()) {
            std::stringstream first, second;
            write(make_case(kind, 7), first);
            write(read(first), second);
            CHECK(first.str() == second.str());
        }
    }
}

// Cells that a search proves only after it has tested very many seeds: those of seeds near a common sphere, where every
// cell reaches the center, and of hulls of clusters in a void. Their search is given up; after all other cells it goes
// on with more and more tests (clip_hard() of CpuClipper), or one triangulation of all seeds names the neighbors,
// whichever is cheaper.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>

namespace votess::cpu {

// What the cells of a block may cost. Where many are hard the later ones are hardly tried. A block begins anew, so what
// is hard does not depend on threads.
class SearchBudget {
public:
    static constexpr std::size_t max_tests = 2000;  // for one cell
    static constexpr std::size_t free_tests = 128;  // these are free
    static constexpr std::size_t tests_per_cell = 8, min_cells = 256;
    static constexpr std::size_t long_streak = 8;

    void begin(std::size_t cells) {
        left_ = tests_per_cell * std::max(cells, min_cells);
        streak_ = 0;
    }
    // Whether to try the cell as a star: the longer the streak of hard cells, the less often.
    [[nodiscard]] bool worth_a_star() const { return streak_ < long_streak || std::has_single_bit(streak_); }
    // Tests that the cell may take.
    [[nodiscard]] std::size_t tests() const { return left_ > 0 ? max_tests : 0; }

    void star_done() { streak_ = 0; }
    void searched(std::size_t tests, bool found) {
        left_ -= std::min(left_, tests - std::min(tests, free_tests));
        streak_ = found ? 0 : streak_ + 1;
    }

private:
    std::size_t left_ = 0, streak_ = 0;
};

}  // namespace votess::cpu

// The input of one fuzz case. It is written as text, so that a finding can be kept and replayed.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "support/generators.hpp"

namespace test::fuzz {

inline constexpr unsigned want_all = 0x3ff;  // the bits are the members of Want in their order
inline constexpr unsigned want_rows_and_volumes = 3;

struct Job {
    Coordinates points;
    std::vector<double> weights;
    std::optional<votess::Box> box;
    std::array<bool, 3> periodic{};
    std::optional<votess::TriclinicBox> cell;
    std::vector<votess::Wall> walls;
    bool drop = false, keep = false;  // seeds outside
    bool list_walls = false;
    bool follow = false;
    unsigned want = want_all;
    unsigned grid_resolution = 0, threads = 1;
    std::string instructions;  // used where the processor has them; "" = the best
    // Of GPUs.
    unsigned k_init = 0, chunk_size = 0;
    bool double_precision = false;
    bool by_subgroup = false;  // the kernel
    bool may_refuse = false;   // invalid_argument and unsupported are right answers too
    bool closed = false;       // only the walls bound the domain: those of the box touch no cell

    [[nodiscard]] std::size_t size() const { return points.size() / 3; }
    // The options refer to the weights of this job.
    [[nodiscard]] votess::Options options(const std::string& device) const;
    // Returns the job without these seeds.
    [[nodiscard]] Job without(std::size_t first, std::size_t end) const;
};

// Jobs for one Tessellator, in their order.
struct Case {
    std::string kind;
    std::uint64_t number = 0;
    std::vector<Job> jobs;
};

void write(const Case& c, std::ostream& out);
// Throws std::runtime_error that names the line.
Case read(std::istream& in);

}  // namespace test::fuzz

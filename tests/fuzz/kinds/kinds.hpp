// Kinds of inputs that bounds and roundings were derived for, each made from a number.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "fuzz/job.hpp"
#include "support/random.hpp"

namespace test::fuzz {

struct Kind {
    std::string_view name, what;
    std::vector<Job> (*make)(Random& random);
};

std::span<const Kind> all_kinds();
// The case of a kind's number; the same on every platform.
Case make_case(const Kind& kind, std::uint64_t number);

// ---- shared by the kinds ----

using Vector = std::array<double, 3>;

// 10^lower .. 10^upper, its logarithm uniform.
double decades(Random& random, double lower, double upper);
// x, or one or few representable numbers beside it.
double beside(double x, Random& random, double probability);
void add_seed(Job& job, const Vector& x);
void shuffle(Job& job, Random& random);
// A box of these sides somewhere, periodic along some axes, at least one when must_repeat.
void take_box(Job& job, const Vector& lower, const Vector& sides, Random& random, bool must_repeat);

// ---- the kinds, small but the last ----

std::vector<Job> wrapped_pairs(Random& random);
std::vector<Job> thin_cells(Random& random);
std::vector<Job> skewed_cells(Random& random);
std::vector<Job> tight_clusters(Random& random);
std::vector<Job> any_weights(Random& random);
std::vector<Job> walls_through(Random& random);
std::vector<Job> wedges(Random& random);
std::vector<Job> lattices(Random& random);
std::vector<Job> on_spheres(Random& random);
std::vector<Job> changing_jobs(Random& random);
std::vector<Job> many_seeds(Random& random);

}  // namespace test::fuzz

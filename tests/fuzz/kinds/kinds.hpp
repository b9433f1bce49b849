// Kinds of inputs near the limits of bounds and roundings, each made from a number.
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
// Returns the case of a kind with this number, the same on every platform.
Case make_case(const Kind& kind, std::uint64_t number);

// ---- shared by the kinds ----

using Vector = std::array<double, 3>;

// Returns a number from 10^lower to 10^upper with a uniform logarithm.
double decades(Random& random, double lower, double upper);
// Returns x, or with this probability a double few steps away.
double beside(double x, Random& random, double probability);
void add_seed(Job& job, const Vector& x);
void shuffle(Job& job, Random& random);
// Sets a box that is periodic along some axes, at least one when must_repeat.
void take_box(Job& job, const Vector& lower, const Vector& sides, Random& random, bool must_repeat);

// ---- the kinds ----

std::vector<Job> ties(Random& random);
std::vector<Job> extremes(Random& random);
std::vector<Job> wrapped_pairs(Random& random);
std::vector<Job> thin_cells(Random& random);
std::vector<Job> skewed_cells(Random& random);
std::vector<Job> tight_clusters(Random& random);
std::vector<Job> any_weights(Random& random);
std::vector<Job> smooth_weights(Random& random);
std::vector<Job> sheets(Random& random);
std::vector<Job> walls_through(Random& random);
std::vector<Job> wedges(Random& random);
std::vector<Job> lattices(Random& random);
std::vector<Job> on_spheres(Random& random);
std::vector<Job> changing_jobs(Random& random);
std::vector<Job> moving_seeds(Random& random);
std::vector<Job> long_histories(Random& random);
std::vector<Job> many_seeds(Random& random);
std::vector<Job> kept_outside(Random& random);

}  // namespace test::fuzz

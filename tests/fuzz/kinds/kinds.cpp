#include "fuzz/kinds/kinds.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace test::fuzz {
namespace {

constexpr Kind kinds[] = {
    {"ties", "few seeds on grids, spheres, planes and walls, and a hair off, at any scale", ties},
    {"extremes", "coordinates of one set that span hundreds of binary digits", extremes},
    {"wrapped", "seeds and their rounded translations by box vectors, or a unit in the last place beside",
     wrapped_pairs},
    {"thin", "few seeds in boxes whose sides differ by up to ten decades", thin_cells},
    {"skewed", "few seeds in thin triclinic cells, skewed by up to five decades", skewed_cells},
    {"clusters", "spacings down to 1e-13 of the coordinates, beside periodic faces and far from 0", tight_clusters},
    {"weights", "weights from 1e-30 to 1e6 of the squared spacing, and near-ties in power distance", any_weights},
    {"smooth", "weights that vary smoothly, so that cells lie up to some spacings beside their seeds", smooth_weights},
    {"sheets", "seeds on one or two planes or lines, in flat and tall boxes", sheets},
    {"walls", "walls through seeds and through vertices", walls_through},
    {"wedges", "thin polyhedra without a box", wedges},
    {"lattices", "lattices with ties, and one unit in the last place off", lattices},
    {"spheres", "seeds on a sphere, exactly and nearly", on_spheres},
    {"outside", "few seeds of these kinds, some beyond the walls, which are kept", kept_outside},
    {"jobs", "jobs of changing size and options that one Tessellator does", changing_jobs},
    {"moving", "seeds that one Tessellator follows", moving_seeds},
    {"histories", "few seeds that one Tessellator follows for long", long_histories},
    {"many", "thousands of seeds of these kinds", many_seeds},
};

}  // namespace

std::span<const Kind> all_kinds() {
    return kinds;
}

Case make_case(const Kind& kind, std::uint64_t number) {
    std::uint64_t of_kind = 0;
    for (const char letter : kind.name) of_kind = 31 * of_kind + static_cast<unsigned char>(letter);
    Random random(number ^ of_kind << 40);
    Case c{std::string(kind.name), number, kind.make(random)};
    constexpr const char* instructions[] = {"", "avx2", "baseline"};
    for (Job& job : c.jobs) {
        job.instructions = instructions[number % std::size(instructions)];
        // Rows without normals and polygons are written by another way.
        if (job.want == want_all && number % 4 == 0) job.want = want_rows_and_volumes;
        constexpr unsigned chunks[] = {0, 0, 0, 64, 150};
        job.chunk_size = chunks[number % std::size(chunks)];
        // New pipelines take long to make.
        const std::uint64_t group = number / 8;
        job.by_subgroup = group % 2 == 0;
        job.k_init = group % 4 == 1 ? 12 : 0;
        job.double_precision = group % 4 == 2;
    }
    return c;
}

double decades(Random& random, double lower, double upper) {
    const double at = random.uniform(lower, upper), whole = std::floor(at);
    // Powers of ten by multiplication: pow() differs by platform in its last digit.
    double x = 1 + 9 * (at - whole);
    for (double k = 0; k < std::abs(whole); ++k) x = whole < 0 ? x / 10 : x * 10;
    return x;
}

double beside(double x, Random& random, double probability) {
    if (!random.chance(probability)) return x;
    // The numbers beside 0 are beyond the scales of the rest.
    if (x == 0 && random.chance(0.999)) return random.chance(0.5) ? 0x1p-58 : -0x1p-58;
    const double towards = random.chance(0.5) ? 1e300 : -1e300;
    for (auto steps = random.chance(0.8) ? 1 : random.below(6); steps > 0; --steps) x = std::nextafter(x, towards);
    return x;
}

void add_seed(Job& job, const Vector& x) {
    job.points.insert(job.points.end(), x.begin(), x.end());
}

void shuffle(Job& job, Random& random) {
    const auto order = permutation(job.size(), random);
    const Job before = job;
    for (std::size_t i = 0; i < order.size(); ++i) {
        std::copy_n(&before.points[3 * order[i]], 3, &job.points[3 * i]);
        if (!job.weights.empty()) job.weights[i] = before.weights[order[i]];
    }
}

void take_box(Job& job, const Vector& lower, const Vector& sides, Random& random, bool must_repeat) {
    votess::Box box{lower, {}};
    for (std::size_t k = 0; k < 3; ++k) box.upper[k] = lower[k] + sides[k];
    job.box = box;
    for (bool& axis : job.periodic) axis = random.chance(0.6);
    if (must_repeat && job.periodic == std::array<bool, 3>{}) job.periodic[random.below(3)] = true;
}

}  // namespace test::fuzz

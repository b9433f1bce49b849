// The alpha complex against rational arithmetic: spheres of all simplices, all seeds and images against each sphere,
// and tetrahedra that fit together.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <vector>
#include <votess/alpha.hpp>

#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"
#include "support/vectors.hpp"

namespace {

using test::determinant;
using test::dot;
using test::minus;
using test::rational;
using Vector = test::RationalVector;
using Matrix = std::array<Vector, 3>;
using Ids = std::vector<std::int32_t>;
constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t index(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

votess::Options whole_space() {
    votess::Options options;
    options.box = votess::Box{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
    options.want.faces = true;
    return options;
}

votess::Options periodic_box(double side) {
    votess::Options options;
    options.box = test::cube(0, side);
    options.periodic = {true, true, true};
    options.want.faces = true;
    return options;
}

// The seeds of the complex, copies included, with their exact places.
class Space {
public:
    // reach: of images, in boxes with all copies.
    Space(const test::Coordinates& points, const votess::Options& options, const std::array<int, 3>& replicate,
          int reach)
        : periodic_(options.periodic[0] || options.cell) {
        const std::size_t count = points.size() / 3;
        Vector origin{};
        if (options.cell) {
            origin = rational(options.cell->origin.data());
            box_ = {rational(options.cell->a.data()), rational(options.cell->b.data()),
                    rational(options.cell->c.data())};
        } else if (periodic_) {
            origin = rational(options.box->lower.data());
            const Vector upper = rational(options.box->upper.data());
            for (std::size_t k = 0; k < 3; ++k) box_[k][k] = upper[k] - origin[k];
        }
        std::vector<Vector> inside;
        for (std::size_t i = 0; i < count; ++i) inside.push_back(wrapped(rational(&points[3 * i]), origin));
        for (int a = 0; a < replicate[0]; ++a)
            for (int b = 0; b < replicate[1]; ++b)
                for (int c = 0; c < replicate[2]; ++c)
                    for (std::size_t i = 0; i < count; ++i) {
                        seeds_.push_back(moved(inside[i], {a, b, c}));
                        if (!options.weights.empty()) weights_.emplace_back(options.weights[i]);
                    }
        for (std::size_t k = 0; k < 3; ++k)
            for (mpq_class& x : box_[k]) x *= replicate[k];
        if (!periodic_) reach = 0;
        for (int a = -reach; a <= reach; ++a)
            for (int b = -reach; b <= reach; ++b)
                for (int c = -reach; c <= reach; ++c)
                    for (std::size_t i = 0; i < size(); ++i) {
                        const Vector x = place(i, {a, b, c});
                        images_.push_back(
                            {x, weight(i), {x[0].get_d(), x[1].get_d(), x[2].get_d()}, weight(i).get_d()});
                    }
    }

    [[nodiscard]] bool periodic() const { return periodic_; }
    [[nodiscard]] std::size_t size() const { return seeds_.size(); }
    [[nodiscard]] const Matrix& box() const { return box_; }
    [[nodiscard]] mpq_class weight(std::size_t i) const { return weights_.empty() ? mpq_class(0) : weights_[i]; }
    [[nodiscard]] Vector place(std::size_t i, const std::array<int, 3>& shift) const { return moved(seeds_[i], shift); }
    // Returns whether no seed or image has a negative power distance to a sphere. Doubles skip those far away.
    [[nodiscard]] bool is_empty(const Vector& center, const mpq_class& square) const {
        const std::array<double, 3> c{center[0].get_d(), center[1].get_d(), center[2].get_d()};
        const double radius = square.get_d();
        return std::ranges::all_of(images_, [&](const Image& image) {
            double distance = 0;
            for (std::size_t k = 0; k < 3; ++k) distance += (image.x[k] - c[k]) * (image.x[k] - c[k]);
            if (distance - image.w > radius + 1e-6 * (std::abs(radius) + distance + std::abs(image.w))) return true;
            const Vector from = minus(image.place, center);
            return dot(from, from) - image.weight >= square;
        });
    }

private:
    [[nodiscard]] Vector moved(Vector x, const std::array<int, 3>& shift) const {
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k) x[k] += shift[j] * box_[j][k];
        return x;
    }
    [[nodiscard]] Vector wrapped(const Vector& x, const Vector& origin) const {
        if (!periodic_) return x;
        const Vector from = minus(x, origin);
        const mpq_class volume = determinant(box_[0], box_[1], box_[2]);
        std::array<int, 3> shift{};
        for (std::size_t j = 0; j < 3; ++j) {
            Matrix with = box_;
            with[j] = from;
            const mpq_class f = determinant(with[0], with[1], with[2]) / volume;
            mpz_class whole;
            mpz_fdiv_q(whole.get_mpz_t(), f.get_num_mpz_t(), f.get_den_mpz_t());
            shift[j] = -static_cast<int>(whole.get_si());
        }
        return moved(x, shift);
    }

    struct Image {
        Vector place;
        mpq_class weight;
        std::array<double, 3> x;
        double w;
    };

    bool periodic_;
    Matrix box_{};
    std::vector<Image> images_;
    std::vector<Vector> seeds_;
    std::vector<mpq_class> weights_;
};

struct Sphere {
    Vector center;
    mpq_class square;
};

// The smallest sphere orthogonal to seeds: its center is the first of them plus a combination of the differences, by
// elimination.
Sphere smallest_sphere(const std::vector<Vector>& places, const std::vector<mpq_class>& weights) {
    const std::size_t n = places.size() - 1;
    std::vector<Vector> d;
    std::vector<std::vector<mpq_class>> rows(n);
    for (std::size_t i = 0; i < n; ++i) d.push_back(minus(places[i + 1], places[0]));
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) rows[i].push_back(2 * dot(d[i], d[j]));
        rows[i].push_back(dot(d[i], d[i]) + weights[0] - weights[i + 1]);
    }
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) {
            if (j == i) continue;
            const mpq_class factor = rows[j][i] / rows[i][i];  // positive pivots: a Gram matrix
            for (std::size_t k = i; k <= n; ++k) rows[j][k] -= factor * rows[i][k];
        }
    Sphere sphere{places[0], 0};
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < 3; ++k) sphere.center[k] += rows[i][n] / rows[i][i] * d[i][k];
    const Vector from = minus(sphere.center, places[0]);
    sphere.square = dot(from, from) - weights[0];
    return sphere;
}

// A simplex of the answer.
struct Simplex {
    Ids seeds;
    std::vector<Vector> places;
    std::vector<mpq_class> weights;
    double value;
    bool gabriel;
};

std::vector<Simplex> simplices_of(const votess::AlphaComplex& complex, std::size_t k, const Space& space) {
    const votess::AlphaSimplices& all = complex.simplices[k];
    REQUIRE(all.seeds.size() == (k + 1) * all.values.size());
    REQUIRE(all.gabriel.size() == all.values.size());
    REQUIRE(all.shifts.size() == (space.periodic() ? 3 * all.seeds.size() : 0));
    std::vector<Simplex> out(all.values.size());
    for (std::size_t s = 0; s < out.size(); ++s) {
        out[s].value = all.values[s];
        out[s].gabriel = all.gabriel[s] != 0;
        for (std::size_t i = (k + 1) * s; i < (k + 1) * (s + 1); ++i) {
            std::array<int, 3> shift{};
            if (space.periodic()) std::copy_n(&all.shifts[3 * i], 3, shift.begin());
            if (i == (k + 1) * s) REQUIRE(shift == std::array<int, 3>{});
            out[s].seeds.push_back(all.seeds[i]);
            out[s].places.push_back(space.place(index(all.seeds[i]), shift));
            out[s].weights.push_back(space.weight(index(all.seeds[i])));
        }
        REQUIRE(std::ranges::adjacent_find(out[s].seeds, std::greater_equal()) == out[s].seeds.end());
        if (s > 0) REQUIRE(out[s - 1].seeds < out[s].seeds);
    }
    return out;
}

Ids without(const Ids& seeds, std::size_t i) {
    Ids face = seeds;
    face.erase(face.begin() + static_cast<std::ptrdiff_t>(i));
    return face;
}

long euler(const votess::AlphaComplex& complex) {
    long sum = 0;
    for (std::size_t k = 0; k < 4; ++k)
        sum += (k % 2 == 0 ? 1 : -1) * static_cast<long>(complex.simplices[k].values.size());
    return sum;
}

void check_value(double value, const mpq_class& expected) {
    const double rounded = expected.get_d();
    CHECK(std::abs(value - rounded) <= 1e-12 * std::abs(rounded));
}

// Checks everything that defines the complex. reach: see Space.
void check_alpha(const test::Coordinates& points, const votess::Options& options,
                 const std::array<int, 3>& replicate = {1, 1, 1}, int reach = 1) {
    const votess::Tessellation t = votess::tessellate(points, options);
    const votess::AlphaComplex complex = votess::alpha_complex(t, points, replicate);
    const Space space(points, options, replicate, reach);
    std::array<std::vector<Simplex>, 4> all;
    for (std::size_t k = 0; k < 4; ++k) all[k] = simplices_of(complex, k, space);
    CHECK(euler(complex) == (space.periodic() ? 0 : 1));

    // From above, values by definition.
    using Values = std::map<Ids, std::vector<std::pair<mpq_class, double>>>;  // exact and stored
    Values above;
    std::map<Ids, std::vector<mpq_class>> sides;  // of the tetrahedra at each triangle
    mpq_class volume = 0;
    for (std::size_t k = 4; k-- > 0;) {
        std::size_t found = 0;
        Values around;
        for (const Simplex& s : all[k]) {
            const Sphere sphere = smallest_sphere(s.places, s.weights);
            const bool gabriel = space.is_empty(sphere.center, sphere.square);
            REQUIRE(s.gabriel == gabriel);
            if (k == 3) REQUIRE(gabriel);
            const auto simplices = above.find(s.seeds);
            mpq_class value = sphere.square;
            if (simplices != above.end()) {
                ++found;
                const auto least = std::ranges::min_element(simplices->second)->first;
                if (!gabriel) value = least;
                CHECK(value <= least);
                bool equal = false;
                for (const auto& [exactly, stored] : simplices->second) {
                    REQUIRE(s.value <= stored);
                    equal = equal || s.value == stored;
                }
                if (value == least) CHECK(equal);
            }
            check_value(s.value, value);
            if (k == 0) continue;
            for (std::size_t i = 0; i <= k; ++i) around[without(s.seeds, i)].emplace_back(value, s.value);
            if (k < 3) continue;
            for (std::size_t i = 0; i < 4; ++i) {
                std::vector<Vector> d;  // from seed i
                for (std::size_t j = 0; j < 4; ++j)
                    if (j != i) d.push_back(minus(s.places[j], s.places[i]));
                const mpq_class turn = determinant(d[0], d[1], d[2]);
                REQUIRE(turn != 0);
                sides[without(s.seeds, i)].push_back(turn);
                if (i == 0) volume += abs(turn) / 6;
            }
        }
        if (k < 3) CHECK(found == above.size());  // no face is missing
        above = std::move(around);
    }
    for (const auto& [face, turns] : sides) {
        REQUIRE(turns.size() <= 2);
        if (turns.size() == 2) {
            REQUIRE((turns[0] > 0) != (turns[1] > 0));
        } else {
            REQUIRE(!space.periodic());
            std::array<Vector, 3> corner;
            for (std::size_t i = 0; i < 3; ++i) corner[i] = space.place(index(face[i]), {});
            for (std::size_t i = 0; i < space.size(); ++i) {
                const Vector seed = space.place(i, {});
                const mpq_class turn =
                    determinant(minus(corner[0], seed), minus(corner[1], seed), minus(corner[2], seed));
                REQUIRE((turns[0] > 0 ? turn >= 0 : turn <= 0));
            }
        }
    }
    if (space.periodic()) CHECK(volume == abs(determinant(space.box()[0], space.box()[1], space.box()[2])));
}

std::vector<double> random_weights(std::size_t count, double size, std::uint64_t seed) {
    test::Random random(seed);
    std::vector<double> weights(count);
    for (double& w : weights) w = random.uniform(-size, size);
    return weights;
}

// Points whose coordinates are small whole numbers, so that many are tied.
test::Coordinates whole_points(std::size_t count, int size, std::uint64_t seed) {
    test::Random random(seed);
    test::Coordinates points;
    for (std::size_t k = 0; k < 3 * count; ++k) points.push_back(static_cast<double>(random.integer(0, size)));
    return points;
}

}  // namespace

TEST_CASE("alpha complex: random points") {
    for (const std::size_t count : {4u, 5u, 30u}) check_alpha(test::uniform(count, count).points, whole_space());
    check_alpha(test::clustered(25, 3).points, whole_space());
    check_alpha(test::nested_clusters(25, 3).points, whole_space());
    check_alpha(test::near_duplicates(20, 4).points, whole_space());
    check_alpha(test::scaled(test::uniform(15, 5), 1e-120).points, whole_space());
}

TEST_CASE("alpha complex: ties") {
    for (const auto& set :
         {test::cubic(3), test::bcc(2), test::fcc(2), test::close_packed(2), test::cospherical(9),
          test::cospherical_and_center(6), test::on_sphere(20, 1), test::cubic(2), test::cubic(2, 0.1)})
        check_alpha(set.points, whole_space());
    for (const auto order : {test::Order::reversed, test::Order::shuffled})
        check_alpha(test::reordered(test::cubic(3), order).points, whole_space());
    for (std::uint64_t seed = 1; seed < 5; ++seed) check_alpha(whole_points(20, 3, seed), whole_space());
}

TEST_CASE("alpha complex: weights") {
    for (const double size : {0.01, 0.3}) {
        votess::Options options = whole_space();
        const std::vector<double> weights = random_weights(25, size, 6);
        options.weights = weights;
        check_alpha(test::uniform(25, 7).points, options);
    }
    for (std::uint64_t seed = 1; seed < 5; ++seed) {
        votess::Options options = whole_space();
        std::vector<double> weights;
        for (double w : random_weights(20, 3, seed)) weights.push_back(std::floor(w));
        options.weights = weights;
        check_alpha(whole_points(20, 3, seed), options);
    }
}

TEST_CASE("alpha complex: periodic") {
    check_alpha(test::uniform(60, 1).points, periodic_box(1));
    check_alpha(test::uniform(3, 2).points, periodic_box(1), {3, 3, 3});
    votess::Options options;
    options.cell = votess::TriclinicBox{{0.1, 0.2, 0.3}, {1, 0, 0}, {0.3, 1, 0}, {0.2, 0.4, 1.1}, {true, true, true}};
    options.want.faces = true;
    check_alpha(test::scaled(test::uniform(4, 3), 2).points, options, {3, 3, 3});
    const std::vector<double> weights = random_weights(6, 0.05, 8);
    options.weights = weights;
    check_alpha(test::uniform(6, 4).points, options, {4, 3, 3});
    // Cubes, tetrahedra and octahedra of ties, across the boundary.
    check_alpha(test::Coordinates{0, 0, 0}, periodic_box(1), {3, 3, 3});
    check_alpha(test::Coordinates{0, 0, 0, 1, 1, 0, 1, 0, 1, 0, 1, 1}, periodic_box(2), {3, 3, 3});
    check_alpha(test::cubic(3).points, periodic_box(3));
}

TEST_CASE("alpha complex: seeds in a plane or a line") {
    for (const std::size_t count : {2u, 3u}) check_alpha(test::uniform(count, 2).points, whole_space());
    for (const auto& set : {test::on_axis_plane(20, 1), test::on_oblique_plane(20, 1), test::cocircular(25, 1),
                            test::on_axis_line(9, 1), test::on_oblique_line(9, 1)}) {
        check_alpha(set.points, whole_space());
        votess::Options options = whole_space();
        const std::vector<double> weights = random_weights(set.size(), 0.01, 4);
        options.weights = weights;
        check_alpha(set.points, options);
    }
    const test::Coordinates line{0, 0, 0, 1, 1, 1, 3, 3, 3, 2, 2, 2};
    const auto complex = votess::alpha_complex(votess::tessellate(line, votess::Options{}), line);
    CHECK(complex.simplices[1].seeds == Ids{0, 1, 1, 3, 2, 3});
    CHECK(complex.simplices[1].values == std::vector<double>{0.75, 0.75, 0.75});
    CHECK(complex.simplices[2].seeds.empty());
}

// Exact orientation decides which simplices are flat. Squared radii reach 2^100 times the distances of the seeds.
TEST_CASE("alpha complex: seeds in a plane or a line up to rounding") {
    const auto decimal = [](test::Random& random) { return static_cast<double>(random.integer(0, 40)) * 0.1; };
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        CAPTURE(seed);
        test::Random random(seed);
        const bool line = seed % 2 == 0, decimals = seed % 4 < 2;
        const double turn = random.uniform(0, 3), c = std::cos(turn), s = std::sin(turn);
        std::set<std::array<double, 3>> places;
        const std::size_t count = line ? 3 + seed % 6 : 4 + seed % 14;
        for (std::size_t i = 0; i < count; ++i) {
            const double u = decimals ? decimal(random) : random.uniform(0, 1);
            const double v = line ? 2 * u : decimals ? decimal(random) : random.uniform(0, 1);
            places.insert({c * u - s * v, s * u + c * v, seed % 3 == 0 ? 0.1 : 0.3 * u + 0.7 * v});
        }
        test::Coordinates points;
        for (const auto& place : places) points.insert(points.end(), place.begin(), place.end());
        votess::Options options = whole_space();
        const std::vector<double> weights = random_weights(places.size(), 0.001, seed);
        if (seed % 5 == 0) options.weights = weights;
        check_alpha(points, options);
    }
    const test::Coordinates three{0.1, 0.2, 0.1 * 3, 0.2, 0.4, 0.3 * 2, 0.5, 1, 1.5};
    check_alpha(three, whole_space());
}

TEST_CASE("alpha complex: copies of a box") {
    const test::Coordinates points = whole_points(5, 3, 11);
    const votess::Options options = periodic_box(4);
    const auto copied = votess::alpha_complex(votess::tessellate(points, options), points, {3, 3, 4});
    test::Coordinates all;
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
            for (int c = 0; c < 4; ++c)
                for (std::size_t i = 0; i < points.size(); i += 3)
                    all.insert(all.end(), {points[i] + 4 * a, points[i + 1] + 4 * b, points[i + 2] + 4 * c});
    votess::Options large = options;
    large.box = votess::Box{{0, 0, 0}, {12, 12, 16}};
    const auto expected = votess::alpha_complex(votess::tessellate(all, large), all);
    for (std::size_t k = 0; k < 4; ++k) {
        CHECK(copied.simplices[k].seeds == expected.simplices[k].seeds);
        CHECK(copied.simplices[k].shifts == expected.simplices[k].shifts);
        CHECK(copied.simplices[k].values == expected.simplices[k].values);
        CHECK(copied.simplices[k].gabriel == expected.simplices[k].gabriel);
    }
}

TEST_CASE("alpha complex: box, walls, dropped faces and seeds change nothing") {
    const test::Coordinates points = test::uniform(60, 5).points;
    const auto expected = votess::alpha_complex(votess::tessellate(points, whole_space()), points);
    const auto same = [&](const votess::Options& options) {
        const auto complex = votess::alpha_complex(votess::tessellate(points, options), points);
        for (std::size_t k = 0; k < 4; ++k) {
            CHECK(complex.simplices[k].seeds == expected.simplices[k].seeds);
            CHECK(complex.simplices[k].values == expected.simplices[k].values);
        }
    };
    votess::Options options;
    same(options);
    options.want.faces = true;
    options.min_face = 0.1;
    same(options);
    options.walls = test::octahedron(0.4);
    options.outside = votess::Outside::keep;
    same(options);

    // Dropped seeds leave gaps in the ids; duplicates too.
    test::Coordinates more{9, 9, 9, points[0], points[1], points[2]};
    more.insert(more.end(), points.begin(), points.end());
    options = {};
    options.box = test::unit_box();
    options.outside = votess::Outside::drop;
    const auto complex = votess::alpha_complex(votess::tessellate(more, options), more);
    Ids seeds = expected.simplices[0].seeds;
    for (std::int32_t& id : seeds) id = id == 0 ? 1 : id + 2;
    CHECK(complex.simplices[0].seeds == seeds);
    CHECK(complex.simplices[3].values.size() == expected.simplices[3].values.size());
    std::vector<double> a = complex.simplices[2].values, b = expected.simplices[2].values;
    std::ranges::sort(a);
    std::ranges::sort(b);
    CHECK(a == b);
}

TEST_CASE("alpha complex: dropped seeds of a cell with ends take their weights along") {
    test::Random random(31);
    for (int trial = 0; trial < 8; ++trial) {
        CAPTURE(trial);
        votess::Options options;
        options.want.faces = true;
        options.cell = votess::TriclinicBox{{}, {1, 0, 0}, {trial % 2 * 0.2, 1, 0}, {0, trial % 2 * 0.1, 1}};
        options.cell->periodic = {true, false, trial % 4 < 2};
        options.outside = votess::Outside::drop;
        test::Coordinates points = test::uniform(40, 300 + static_cast<std::uint64_t>(trial)).points, kept;
        for (std::size_t k = 1; k < points.size(); k += 3) points[k] *= 1.3;
        std::vector<double> weights, kept_weights;
        for (std::size_t i = 0; i < 40; ++i) weights.push_back(random.uniform(0, 1e-3));
        const bool weighted = trial < 6;
        if (weighted) options.weights = weights;
        const auto t = votess::tessellate(points, options);
        for (std::size_t i = 0; i < 40; ++i) {
            if (t.status()[i] == votess::CellStatus::outside) continue;
            kept.insert(kept.end(), &points[3 * i], &points[3 * i] + 3);
            kept_weights.push_back(weights[i]);
        }
        CHECK(kept.size() < points.size());
        const std::array copies{3, 1, trial % 4 < 2 ? 3 : 1};
        const auto complex = votess::alpha_complex(t, points, copies);
        if (weighted) options.weights = kept_weights;
        const auto alone = votess::alpha_complex(votess::tessellate(kept, options), kept, copies);
        for (std::size_t k = 0; k < 4; ++k) {
            CHECK(complex.simplices[k].values == alone.simplices[k].values);
            CHECK(complex.simplices[k].shifts == alone.simplices[k].shifts);
        }
    }
}

TEST_CASE("alpha complex: bad input") {
    const auto message = [](const test::Coordinates& points, const votess::Options& options,
                            const std::array<std::int32_t, 3>& replicate = {1, 1, 1}) -> std::string {
        const auto t = votess::tessellate(points, options);
        try {
            (void)votess::alpha_complex(t, points, replicate);
        } catch (const votess::Error& error) {
            return error.what();
        }
        return "";
    };
    const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
    const test::Coordinates few = test::uniform(3, 2).points;
    CHECK(has(message(test::uniform(1, 2).points, periodic_box(1)), "joins seed 0 to its own image"));
    CHECK(has(message(test::uniform(12, 2).points, periodic_box(1)), "two edges join seeds"));
    CHECK(has(message(few, periodic_box(1), {1, 0, 1}), "replicate holds 0"));
    CHECK(has(message(few, whole_space(), {2, 1, 1}), "not periodic"));
    CHECK(has(message(few, periodic_box(1), {2000, 2000, 2000}), "2^31"));
    votess::Options options = periodic_box(1);
    options.periodic[1] = false;
    CHECK(has(message(few, options, {1, 2, 1}), "along axis 1, along which it does not repeat"));
    CHECK(has(message({}, periodic_box(1), {2000, 2000, 2000}), "2^31"));
    test::Coordinates flat = test::cubic(2).points;
    const auto cube = votess::tessellate(flat, whole_space());
    for (std::size_t k = 0; k < flat.size(); k += 3) flat[k] = 0;
    CHECK_THROWS_WITH_AS((void)votess::alpha_complex(cube, flat), "the points are not those of the tessellation",
                         votess::Error);
    CHECK(message({}, whole_space()).empty());
    const test::Coordinates one{1, 2, 3};
    const auto single = votess::alpha_complex(votess::tessellate(one, whole_space()), one);
    CHECK(single.simplices[0].seeds == Ids{0});
    CHECK(single.simplices[0].values == std::vector<double>{0});
    CHECK(single.simplices[1].seeds.empty());
}

// GEOGRAM: Delaunay and regular triangulations with exact predicates, one thread. Periodic in cubes.
#include <geogram/basic/common.h>
#include <geogram/basic/logger.h>
#include <geogram/basic/process.h>
#include <geogram/delaunay/periodic_delaunay_3d.h>

#include <algorithm>
#include <stdexcept>

#include "bench.hpp"

namespace bench {
namespace {

using GEO::index_t;

// Returns the neighbors of the first n vertices. Vertices from n on are images.
Rows rows_from_tetrahedra(std::size_t n, const GEO::Delaunay& delaunay) {
    const std::size_t tetrahedra = delaunay.nb_cells();
    const auto corner = [&](std::size_t cell, std::size_t k) {
        return static_cast<std::size_t>(delaunay.cell_vertex(static_cast<index_t>(cell), static_cast<index_t>(k)));
    };
    std::vector<std::size_t> end(n + 1, 0);
    for (std::size_t t = 0; t < tetrahedra; ++t)
        for (std::size_t k = 0; k < 4; ++k)
            if (corner(t, k) < n) end[corner(t, k) + 1] += 3;
    for (std::size_t i = 0; i < n; ++i) end[i + 1] += end[i];
    const std::vector<std::size_t> begin = end;
    std::vector<std::int32_t> all(end[n]);
    for (std::size_t t = 0; t < tetrahedra; ++t)
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t j = 0; j < 4 && corner(t, k) < n; ++j)
                if (j != k) all[end[corner(t, k)]++] = static_cast<std::int32_t>(corner(t, j));
    Rows rows{{0}, {}};
    rows.indptr.reserve(n + 1);
    for (std::size_t i = 0; i < n; ++i) {
        const auto at = [&](std::size_t k) { return all.begin() + static_cast<std::ptrdiff_t>(k); };
        std::sort(at(begin[i]), at(begin[i + 1]));
        const auto last = std::unique(at(begin[i]), at(begin[i + 1]));
        rows.indices.insert(rows.indices.end(), at(begin[i]), last);
        rows.indptr.push_back(static_cast<std::int64_t>(rows.indices.size()));
    }
    return rows;
}

class Geogram final : public Peer {
public:
    Geogram() {
        GEO::initialize(GEO::GEOGRAM_INSTALL_NONE);
        GEO::Logger::instance()->set_quiet(true);
        GEO::Process::set_max_threads(1);
    }
    [[nodiscard]] std::string name() const override { return "geogram"; }
    [[nodiscard]] std::string version() const override { return GEO::Environment::instance()->get_value("version"); }
    [[nodiscard]] bool can(const Input& input, Want want) const override {
        const auto lengths = input.lengths();
        const bool cube = lengths[0] == lengths[1] && lengths[0] == lengths[2];
        const bool open = input.periodic == std::array{false, false, false};
        return want == Want::neighbors && !input.cell && input.walls.empty() && (open || (periodic(input) && cube));
    }
    [[nodiscard]] bool bounded(const Input& input) const override { return periodic(input); }

    [[nodiscard]] Answer run(const Input& input, Want, unsigned) const override {
        std::vector<double> weights = input.weights;
        for (const double radius : input.radii) weights.push_back(radius * radius);
        const auto count = static_cast<index_t>(input.size());
        if (periodic(input)) {
            const Stopwatch stopwatch;
            GEO::PeriodicDelaunay3d delaunay(true, input.lengths()[0]);
            delaunay.set_vertices(count, input.points.data());
            if (!weights.empty()) delaunay.set_weights(weights.data());
            delaunay.compute();
            if (delaunay.has_empty_cells()) throw std::runtime_error("it stops at seeds without a cell");
            return answer(stopwatch, input, delaunay);
        }
        // A weight is the square of a fourth coordinate below that of the heaviest seed.
        std::vector<double> points = input.points;
        if (!weights.empty()) {
            points.clear();
            const double heaviest = *std::ranges::max_element(weights);
            for (std::size_t i = 0; i < input.size(); ++i) {
                points.insert(points.end(), &input.points[3 * i], &input.points[3 * i] + 3);
                points.push_back(std::sqrt(heaviest - weights[i]));
            }
        }
        const Stopwatch stopwatch;
        const GEO::Delaunay_var delaunay =
            weights.empty() ? GEO::Delaunay::create(3, "BDEL") : GEO::Delaunay::create(4, "BPOW");
        delaunay->set_vertices(count, points.data());
        return answer(stopwatch, input, *delaunay);
    }

private:
    static bool periodic(const Input& input) { return input.periodic == std::array{true, true, true}; }

    static Answer answer(const Stopwatch& stopwatch, const Input& input, const GEO::Delaunay& delaunay) {
        const Rows rows = rows_from_tetrahedra(input.size(), delaunay);
        return {stopwatch.seconds(), rows.indices.size(), 0};
    }
};

}  // namespace

std::unique_ptr<Peer> make_geogram() {
    return std::make_unique<Geogram>();
}

}  // namespace bench

// Lloyd's method on a surface, and the mesh of well-shaped triangles that it leads to.
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "core/at.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/vector3.hpp"
#include "input/settle.hpp"
#include "solid/closed_mesh.hpp"
#include "surface/features.hpp"
#include "surface/flips.hpp"
#include "surface/mesh_report.hpp"
#include "surface/nearest.hpp"
#include "surface/regions.hpp"

namespace votess {
namespace surface {
namespace {

constexpr std::size_t max_count = std::size_t{1} << 28;  // of places: corners of their cells have 32-bit numbers

// Steps go further than Lloyd's, and on by a part of the last move: 16 such steps lowered the energy more than 30 of
// his on ten models. The last ones are his, so that seeds end on the surface.
constexpr double longer = 1.5, onward = 0.5;
constexpr unsigned plain_steps = 2;

// Cells that fall into parts are counted after so many steps. Where these are more than the vertices by a share,
// relaxation begins again with fewer seeds.
constexpr unsigned trial_steps = 5, max_trials = 3;
constexpr double max_excess = 0.02;
// Seeds are added at faults in rounds, each with some steps; in all no more than the vertices requested.
constexpr unsigned max_rounds = 10, steps_of_round = 3;
// Those at parts that do not fit together are added in the first rounds. Later these are split: more seeds would mend
// some and make others, as where cells mix the sides of a thin sheet.
constexpr unsigned rounds_of_parts = 3;
constexpr std::size_t max_splits = 4;  // parts added, in units of the vertices requested
// First, seeds move to features that the mesh misses. Then they are added there: in the last rounds at borders alone,
// and without steps, which would move others off again.
constexpr unsigned moving_rounds = 4, still_rounds = 20;

// Returns value / scale. Throws invalid_argument if that loses bits.
template <class Name>
double divided(double value, double scale, const Name& name) {
    if (std::isfinite(value) && value / scale * scale != value)
        refuse(name() + " = " + number(value) +
               " is too small beside the others to represent both at one scale: move it to 0");
    return value / scale;
}

// The arrays of a mesh with coordinates of at most about 1, so that squares neither overflow nor vanish. largest: of
// other coordinates to be as small.
solid::MeshArrays near_unit(const solid::ClosedMesh& mesh, double& scale, double largest = 0) {
    for (const auto& triangle : mesh.given())
        for (const std::int32_t v : triangle)
            for (const double x : mesh.vertex(v)) largest = std::max(largest, std::abs(x));
    int exponent = 0;
    std::frexp(largest, &exponent);
    scale = std::ldexp(1.0, std::clamp(exponent, -1000, 1000));
    for (const auto& triangle : mesh.given())
        for (const std::int32_t v : triangle)
            for (std::size_t k = 0; k < 3; ++k)
                (void)divided(mesh.vertex(v)[k], scale,
                              [&] { return "surface: vertex " + std::to_string(v) + ": " + axis_name[k]; });
    return {mesh, scale};
}

void multiply(std::vector<double>& values, std::initializer_list<double> factors) {
    for (double& value : values)
        for (const double factor : factors) value *= factor;
}

// Turns what was made from the arrays of near_unit() into that of the given mesh.
template <class Made>  // SurfaceRelaxation or Remesh
void unscale(Made& made, double scale) {
    SurfaceCells& cells = made.cells;
    for (std::vector<double>* lengths :
         {&made.points, &cells.centroids, &cells.nearest, &cells.borders, &cells.lengths, &cells.vertices})
        multiply(*lengths, {scale});
    for (std::vector<double>* areas : {&cells.areas, &cells.polygon_areas}) multiply(*areas, {scale, scale});
    for (std::vector<double>* energies : {&made.energies, &cells.energies})
        multiply(*energies, {scale, scale, scale, scale});
}

std::vector<double> sample(const solid::MeshArrays& mesh, double scale, std::size_t count, std::uint64_t rng_seed) {
    const std::size_t triangles = mesh.triangles.size() / 3;
    const auto corner = [&](std::size_t t, std::size_t k) {
        const double* const x = &mesh.vertices[3 * at(mesh.triangles[3 * t + k])];
        return Vector3{x[0], x[1], x[2]};
    };
    std::vector<double> ends;
    std::size_t last = 0;  // triangle with an area
    for (std::size_t t = 0; t < triangles; ++t) {
        const Vector3 a = corner(t, 0), n = cross(minus(corner(t, 1), a), minus(corner(t, 2), a));
        const double area = length3(n[0], n[1], n[2]);
        ends.push_back((t == 0 ? 0 : ends.back()) + area);
        if (area > 0) last = t;
    }
    if (ends.empty() || !(ends.back() > 0)) refuse("surface: its triangles have no area");
    std::mt19937_64 bits(rng_seed);
    const auto uniform = [&bits] { return static_cast<double>(bits() >> 11) * 0x1p-53; };
    std::vector<double> places;
    places.reserve(3 * count);
    std::size_t t = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 4096 == 0) check_stop();
        const double at_area = (static_cast<double>(i) + uniform()) * ends.back() / static_cast<double>(count);
        while (t < last && ends[t] <= at_area) ++t;
        const double a = std::sqrt(uniform()), b = uniform();
        const Vector3 x = corner(t, 0), y = corner(t, 1), z = corner(t, 2);
        for (std::size_t k = 0; k < 3; ++k)
            places.push_back((x[k] + a * (1 - b) * (y[k] - x[k]) + a * b * (z[k] - x[k])) * scale);
    }
    return places;
}

Vector3 place_of(const std::vector<double>& places, std::size_t i) {
    return {places[3 * i], places[3 * i + 1], places[3 * i + 2]};
}

// Calls use(a, b, c) for triangles that make up a polygon.
template <class Use>
void each_triangle(const SurfaceCells& cells, std::size_t polygon, const Use& use) {
    const std::size_t begin = at(cells.polygon_offsets[polygon]), end = at(cells.polygon_offsets[polygon + 1]);
    const auto corner = [&](std::size_t c) { return place_of(cells.vertices, at(cells.corners[c])); };
    for (std::size_t c = begin + 1; c + 1 < end; ++c) use(corner(begin), corner(c), corner(c + 1));
}

// Fills the places of pieces of polygons that are NaN: with the one nearest to the centroid, if there is an area.
void find_middles(const SurfaceCells& cells, std::vector<Vector3>& places) {
    std::vector<std::uint8_t> is_known;
    for (const Vector3& place : places) is_known.push_back(std::isnan(place[0]) ? 0 : 1);
    std::vector<Vector3> centroids(places.size());
    std::vector<double> areas(places.size()), least(places.size(), std::numeric_limits<double>::infinity());
    for (std::size_t p = 0; p < cells.polygon_pieces.size(); ++p) {
        const std::size_t piece = at(cells.polygon_pieces[p]);
        if (is_known[piece] != 0) continue;
        each_triangle(cells, p, [&](const Vector3& a, const Vector3& b, const Vector3& c) {
            const Vector3 n = cross(minus(b, a), minus(c, a));
            const double area = length3(n[0], n[1], n[2]);
            areas[piece] += area;
            for (std::size_t k = 0; k < 3; ++k) centroids[piece][k] += area * (a[k] + b[k] + c[k]) / 3;
        });
    }
    for (std::size_t p = 0; p < cells.polygon_pieces.size(); ++p) {
        const std::size_t piece = at(cells.polygon_pieces[p]);
        if (is_known[piece] != 0 || !(areas[piece] > 0)) continue;
        const Vector3& sum = centroids[piece];
        const Vector3 centroid{sum[0] / areas[piece], sum[1] / areas[piece], sum[2] / areas[piece]};
        each_triangle(cells, p, [&](const Vector3& a, const Vector3& b, const Vector3& c) {
            const Vector3 place = nearest_on_triangle(centroid, a, b, c);
            if (const double far = distance(place, centroid); far < least[piece])
                least[piece] = far, places[piece] = place;
        });
    }
}

// Returns the place of each connected part that is nearest to its centroid; NaN without an area.
std::vector<Vector3> middles_of(const SurfaceCells& cells) {
    std::vector<Vector3> places;
    for (std::size_t i = 0; i < cells.size(); ++i)
        for (std::int32_t k = 0; k < cells.pieces[i]; ++k)
            places.push_back(cells.pieces[i] == 1 ? place_of(cells.nearest, i) : Vector3{nan, nan, nan});
    find_middles(cells, places);
    return places;
}

// Returns where seeds move to: the place of the largest part of their cell; NaN without one.
std::vector<double> goals_of(const SurfaceCells& cells, const std::vector<Vector3>& places) {
    std::vector<double> areas(places.size()), goals(3 * cells.size(), nan);
    for (std::size_t p = 0; p < cells.polygon_pieces.size(); ++p)
        areas[at(cells.polygon_pieces[p])] += cells.polygon_areas[p];
    std::size_t piece = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        double largest = 0;
        for (std::int32_t k = 0; k < cells.pieces[i]; ++k, ++piece) {
            if (!(areas[piece] > largest)) continue;
            largest = areas[piece];
            std::ranges::copy(places[piece], goals.begin() + static_cast<std::ptrdiff_t>(3 * i));
        }
    }
    return goals;
}

// Steps of a relaxation, on threads that each step makes again.
class Relaxation {
public:
    Relaxation(const TriangleMesh& mesh, unsigned threads, std::vector<double> points, SurfaceWant want)
        : mesh_(mesh), threads_(threads) {
        out_.points = std::move(points);
        measure(want);
    }

    // Moves seeds to their goals: three numbers each, NaN for those that stay. Returns the largest move. want: of the
    // cells after it.
    double step(std::span<const double> goals, SurfaceWant want) {
        double largest = 0;
        before_ = out_.points;
        for (std::size_t i = 0; i < out_.cells.size(); ++i) {
            const Vector3 from = place_of(out_.points, i), to{goals[3 * i], goals[3 * i + 1], goals[3 * i + 2]};
            if (std::isnan(to[0])) continue;
            largest = std::max(largest, distance(from, to));
            std::ranges::copy(to, out_.points.begin() + static_cast<std::ptrdiff_t>(3 * i));
        }
        const double area = std::accumulate(out_.cells.areas.begin(), out_.cells.areas.end(), 0.0);
        out_.moved.push_back(largest / std::sqrt(area / static_cast<double>(out_.cells.size())));
        measure(want);
        return out_.moved.back();
    }
    void add(std::span<const double> points) {
        out_.points.insert(out_.points.end(), points.begin(), points.end());
        measure(SurfaceWant::polygons);
    }
    // Makes all arrays of the cells.
    void complete() {
        if (!out_.cells.indptr.empty()) return;
        out_.energies.pop_back();
        measure(SurfaceWant::all);
    }
    [[nodiscard]] const SurfaceCells& cells() const { return out_.cells; }
    [[nodiscard]] const std::vector<double>& points() const { return out_.points; }
    // Returns the move of a seed in the last step.
    [[nodiscard]] Vector3 last_move(std::size_t i) const {
        return before_.empty() ? Vector3{} : minus(place_of(out_.points, i), place_of(before_, i));
    }
    [[nodiscard]] SurfaceRelaxation take() {
        complete();
        return std::move(out_);
    }

private:
    void measure(SurfaceWant want) {
        SurfaceOptions options;
        options.want = want;
        options.threads = threads_;
        out_.cells = surface_cells(out_.points, mesh_, options);
        out_.energies.push_back(std::accumulate(out_.cells.energies.begin(), out_.cells.energies.end(), 0.0));
    }

    const TriangleMesh& mesh_;
    unsigned threads_;
    std::vector<double> before_;  // points, one step earlier
    SurfaceRelaxation out_;
};

class Remeshing {
public:
    Remeshing(const solid::ClosedMesh& closed, std::size_t count, const RemeshOptions& options)
        : scaled_(near_unit(closed, scale_)),
          mesh_(scaled_.view()),
          features_(scaled_, options.sharp),
          count_(count),
          options_(options),
          all_steps_(options.steps + max_rounds) {}

    [[nodiscard]] Remesh make() {
        relax();
        mend();
        Remesh mesh;
        mesh.vertices = vertices_of_parts();
        Regions regions = regions_of_parts();
        split(regions, max_splits * (count_ - 1), mesh.vertices);
        close_gaps(regions, mesh.vertices);
        mesh.triangles = regions.triangles();
        flip_flat(mesh.vertices, options_.sharp, mesh.triangles);
        SurfaceRelaxation relaxed = relaxation_->take();
        mesh.points = std::move(relaxed.points);
        mesh.energies = std::move(relaxed.energies);
        mesh.cells = std::move(relaxed.cells);
        report_on_mesh(mesh, regions, features_, scaled_);
        unscale(mesh, scale_);
        multiply(mesh.vertices, {scale_});
        mesh.distance *= scale_;
        return mesh;
    }

private:
    // Returns the places of the connected parts.
    [[nodiscard]] std::vector<Vector3> places() const {
        const SurfaceCells& cells = relaxation_->cells();
        std::vector<Vector3> places = middles_of(cells);
        features_.attract(cells, places);
        return places;
    }

    // is_fast: moves seeds further, where one part has no feature.
    void step(bool is_fast = false) {
        const SurfaceCells& cells = relaxation_->cells();
        const std::vector<Vector3> middles = middles_of(cells);
        std::vector<Vector3> places = middles;
        features_.attract(cells, places);
        for (std::size_t i = 0, piece = 0; is_fast && i < cells.size(); piece += at(cells.pieces[i++])) {
            if (cells.pieces[i] != 1 || places[piece] != middles[piece]) continue;
            const Vector3 from = place_of(relaxation_->points(), i);
            places[piece] = along(along(from, minus(places[piece], from), longer), relaxation_->last_move(i), onward);
        }
        relaxation_->step(goals_of(cells, places), SurfaceWant::polygons);
        report_stage(std::min(++done_, all_steps_), all_steps_);
    }

    void relax() {
        std::size_t seeds = count_;
        const unsigned trial = std::min(trial_steps, options_.steps);
        for (unsigned attempt = 1;; ++attempt) {
            relaxation_.emplace(mesh_, options_.threads, sample(scaled_, 1, seeds, options_.rng_seed),
                                SurfaceWant::polygons);
            for (unsigned k = 0; k < trial; ++k) step(k + plain_steps < options_.steps);
            const auto& pieces = relaxation_->cells().pieces;
            const double all = std::accumulate(pieces.begin(), pieces.end(), 0.0), wanted = static_cast<double>(count_);
            if (all <= (1 + max_excess) * wanted || attempt == max_trials) break;
            seeds = std::max<std::size_t>(1, static_cast<std::size_t>(static_cast<double>(seeds) * wanted / all));
            done_ -= std::min<std::size_t>(done_, trial);
        }
        for (unsigned k = trial; k < options_.steps; ++k) step(k + plain_steps < options_.steps);
    }

    [[nodiscard]] Regions regions_of_parts() const {
        return Regions(whole_cells(relaxation_->points(), mesh_, options_.threads));
    }

    // Adds a seed to each faulty part, as far as possible from its vertex; and seeds on features that the mesh misses.
    void mend() {
        std::size_t added = 0, open = std::numeric_limits<std::size_t>::max();  // open: borders with gaps, before
        for (unsigned round = 0; round < max_rounds + still_rounds; ++round) {
            const SurfaceCells& cells = relaxation_->cells();
            const std::vector<double> vertices = vertices_of_parts();
            std::vector<std::uint8_t> bad(vertices.size() / 3);
            if (round < rounds_of_parts) bad = regions_of_parts().faults();
            std::vector<std::size_t> seeds;  // by part
            for (std::size_t i = 0; i < cells.size(); ++i) seeds.insert(seeds.end(), at(cells.pieces[i]), i);
            std::vector<double> far(bad.size(), -1);
            std::vector<std::int32_t> corners(bad.size(), -1);
            for (std::size_t p = 0; p < cells.polygon_pieces.size(); ++p) {
                const std::size_t piece = at(cells.polygon_pieces[p]);
                if (bad[piece] == 0) continue;
                for (std::int64_t c = cells.polygon_offsets[p]; c < cells.polygon_offsets[p + 1]; ++c) {
                    const std::int32_t corner = cells.corners[at(c)];
                    const double d = distance(place_of(cells.vertices, at(corner)), place_of(vertices, piece));
                    if (d > far[piece]) far[piece] = d, corners[piece] = corner;
                }
            }
            std::vector<double> more;
            const auto add = [&](const Vector3& place) {
                if (added == count_) return;
                more.insert(more.end(), place.begin(), place.end());
                ++added;
            };
            std::vector<Vector3> moved(bad.size(), Vector3{nan, nan, nan});
            bool is_moved = false;
            std::size_t at_borders = 0;
            std::vector<std::uint8_t> has_gap(cells.size());
            for (const Features::Gap& gap : features_.gaps(cells, vertices)) {
                const bool is_still = round >= max_rounds;
                at_borders += gap.is_border ? 1 : 0;
                bad[gap.piece] = 0;
                has_gap[seeds[gap.piece]] |= gap.is_border ? 1 : 0;
                if (gap.is_near && round < moving_rounds && cells.pieces[seeds[gap.piece]] == 1) {
                    moved[gap.piece] = gap.place;
                    is_moved = true;
                } else if (gap.is_corner || gap.is_border == is_still) {
                    add(gap.place);
                }
            }
            // A vertex in a gap may mend the parts beside it too.
            for (std::size_t p = 0; p < cells.polygon_pieces.size(); ++p) {
                std::uint8_t& is_bad = bad[at(cells.polygon_pieces[p])];
                if (is_bad != 0 && has_gap[at(cells.polygon_seeds[p])] != 0) is_bad = 0;
                for (std::int64_t c = cells.polygon_offsets[p]; is_bad != 0 && c < cells.polygon_offsets[p + 1]; ++c)
                    if (cells.beyond[at(c)] >= 0 && has_gap[at(cells.beyond[at(c)])] != 0) is_bad = 0;
            }
            for (std::size_t piece = 0; piece < bad.size(); ++piece)
                if (bad[piece] != 0 && corners[piece] >= 0) add(place_of(cells.vertices, at(corners[piece])));
            // More seeds at places that sheets of the surface share would not close them.
            if (round >= max_rounds && at_borders >= std::exchange(open, at_borders)) return;
            if (more.empty() && !is_moved) {
                if (at_borders == 0 || round >= max_rounds) return;
                round = max_rounds - 1;
                continue;
            }
            if (is_moved) relaxation_->step(goals_of(cells, moved), SurfaceWant::polygons);
            if (!more.empty()) relaxation_->add(more);
            for (unsigned k = 0; round < max_rounds && k < steps_of_round; ++k) step();
        }
    }

    // Splits parts that are still at fault into at most so many more, and adds a vertex for each.
    void split(Regions& regions, std::size_t max_more, std::vector<double>& vertices) const {
        const std::size_t parts = regions.size();
        regions.split(parts + max_more);
        if (regions.size() == parts) return;
        const SurfaceCells& faces = regions.faces();
        std::vector<Vector3> places(regions.size(), Vector3{nan, nan, nan});
        for (std::size_t i = 0; i < places.size(); ++i)
            if (!regions.is_cut(i)) places[i] = place_of(vertices, i);
        find_middles(faces, places);
        features_.attract(faces, places);
        // Without an area, a corner will do.
        for (std::size_t p = 0; p < faces.polygon_pieces.size(); ++p) {
            Vector3& place = places[at(faces.polygon_pieces[p])];
            if (std::isnan(place[0])) place = place_of(faces.vertices, at(faces.corners[at(faces.polygon_offsets[p])]));
        }
        vertices.resize(3 * places.size());
        for (std::size_t i = 0; i < places.size(); ++i)
            if (regions.is_cut(i)) std::ranges::copy(places[i], vertices.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }

    // Moves vertices onto features that the mesh would miss, where they are not seeds.
    void close_gaps(const Regions& regions, std::vector<double>& vertices) const {
        std::vector<std::uint8_t> is_seed;  // by region
        for (const std::int32_t pieces : relaxation_->cells().pieces)
            is_seed.insert(is_seed.end(), at(pieces), pieces == 1 ? 1 : 0);
        is_seed.resize(regions.size());
        std::vector<std::uint8_t> is_moved(regions.size());
        for (const Features::Gap& gap : features_.gaps(regions.faces(), vertices)) {  // corners first
            if ((is_seed[gap.piece] != 0 && !regions.is_cut(gap.piece)) || is_moved[gap.piece] != 0) continue;
            if (!gap.is_corner && !gap.is_near) continue;
            is_moved[gap.piece] = 1;
            std::ranges::copy(gap.place, vertices.begin() + static_cast<std::ptrdiff_t>(3 * gap.piece));
        }
    }

    // Returns the vertex of each connected part. A seed is the vertex of its only part.
    [[nodiscard]] std::vector<double> vertices_of_parts() const {
        const SurfaceCells& cells = relaxation_->cells();
        std::vector<double> vertices;
        const std::vector<Vector3> at_parts = places();
        for (std::size_t i = 0; i < cells.size(); ++i)
            for (std::int32_t k = 0; k < cells.pieces[i]; ++k) {
                const Vector3& place = at_parts[vertices.size() / 3];
                const bool is_seed = cells.pieces[i] == 1 || std::isnan(place[0]);
                const Vector3 x = is_seed ? place_of(relaxation_->points(), i) : place;
                vertices.insert(vertices.end(), x.begin(), x.end());
            }
        return vertices;
    }

    double scale_ = 1;
    solid::MeshArrays scaled_;
    TriangleMesh mesh_;
    Features features_;
    std::size_t count_;
    const RemeshOptions& options_;
    std::optional<Relaxation> relaxation_;
    std::size_t done_ = 0, all_steps_;
};

void check_count(std::size_t count, const char* what) {
    if (count == 0) refuse(std::string(what) + " is 0: give at least 1");
    if (count > max_count)
        refuse(std::string(what) + " is " + std::to_string(count) + ", which is too many: give at most " +
               std::to_string(max_count));
}

}  // namespace
}  // namespace surface

SurfaceRelaxation lloyd_on_surface(std::span<const double> points, const TriangleMesh& mesh,
                                   const SurfaceLloydOptions& options) {
    check_member("SurfaceLloydOptions::threads", options.threads);
    if (!options.fixed.empty() && options.fixed.size() != points.size() / 3)
        refuse("SurfaceLloydOptions::fixed has " + std::to_string(options.fixed.size()) + " values for " +
               std::to_string(points.size() / 3) + " points: give one for each");
    if (!(options.tolerance >= 0) || std::isinf(options.tolerance))
        refuse("SurfaceLloydOptions::tolerance is " + number(options.tolerance) +
               ": it must be finite and not negative");
    Progress progress(options.progress);
    const Stoppable stoppable(progress, {0, 1});
    double largest = 0, scale = 1;
    for (const double x : points)
        if (std::isfinite(x)) largest = std::max(largest, std::abs(x));
    const solid::MeshArrays scaled =
        surface::near_unit(solid::ClosedMesh::any_surface(mesh, "surface"), scale, largest);
    std::vector<double> seeds;
    for (std::size_t i = 0; i < points.size(); ++i)
        seeds.push_back(surface::divided(points[i], scale,
                                         [&] { return "point " + std::to_string(i / 3) + ": " + axis_name[i % 3]; }));
    const TriangleMesh view = scaled.view();
    surface::Relaxation relaxation(view, options.threads, std::move(seeds), SurfaceWant::nearest);
    for (unsigned step = 0; step < options.steps; ++step) {
        report_stage(step + 1, std::size_t{options.steps} + 1);
        std::vector<double> goals = relaxation.cells().nearest;
        for (std::size_t i = 0; i < options.fixed.size(); ++i)
            if (options.fixed[i] != 0) goals[3 * i] = surface::nan;
        if (relaxation.step(goals, SurfaceWant::nearest) <= options.tolerance) break;
    }
    SurfaceRelaxation relaxed = relaxation.take();
    surface::unscale(relaxed, scale);
    return relaxed;
}

std::vector<double> sample_surface(const TriangleMesh& mesh, std::size_t count, std::uint64_t rng_seed) {
    if (count == 0) return {};
    surface::check_count(count, "the number of places");
    const auto closed = solid::ClosedMesh::any_surface(mesh, "surface");
    double scale = 1;
    const solid::MeshArrays scaled = surface::near_unit(closed, scale);
    return surface::sample(scaled, scale, count, rng_seed);
}

Remesh remesh(const TriangleMesh& mesh, std::size_t count, const RemeshOptions& options) {
    check_member("RemeshOptions::threads", options.threads);
    surface::check_count(count, "the number of vertices");
    if (!(options.sharp > 0 && options.sharp <= 180))
        refuse("RemeshOptions::sharp is " + number(options.sharp) + ": give an angle above 0, up to 180 degrees");
    Progress progress(options.progress);
    const Stoppable stoppable(progress, {0, 1});
    return surface::Remeshing(solid::ClosedMesh::any_surface(mesh, "surface"), count, options).make();
}

}  // namespace votess

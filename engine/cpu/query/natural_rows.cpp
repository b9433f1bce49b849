#include "cpu/query/natural_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/vector3.hpp"
#include "cpu/sort/seed_images.hpp"

namespace votess::cpu {
namespace {

using Vector = Vector3;

}  // namespace

void NaturalRows::begin_job(const Job& job, const NaturalOptions& options) {
    domain_ = job.domain.get();
    options_ = options;
    unscale_ = 1 / job.scale;
    shape_.weighted = domain_->has_weights();
}

bool NaturalRows::take_by_graph(std::size_t k) {
    entries_.clear();
    if (!divider_.divide(probes_[k], options_.gradients, division_)) return false;
    give_division(k);
    return true;
}

bool NaturalRows::take(std::size_t k, Star& star) {
    if (!star.knows_vertices()) return false;
    ranks_.resize(star.faces().size());
    std::iota(ranks_.begin(), ranks_.end(), 0u);
    star.polygons(ranks_, shape_.polygons);
    read_planes(k, star);
    divide(k);
    return true;
}

void NaturalRows::take(std::size_t k, Cell& cell) {
    constexpr std::size_t least_faces = 4;
    if (!cell.empty()) cell.canonical_faces(faces_);
    if (cell.empty() || faces_.size() < least_faces) return out_->take(k, {});
    ranks_.resize(faces_.size());
    std::iota(ranks_.begin(), ranks_.end(), 0u);
    read_polygons(cell, faces_, ranks_, shape_.polygons);
    read_planes(cell, faces_);
    divide(k);
}

// All of the weight is the seed's.
void NaturalRows::taken(std::size_t k, std::size_t seed) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    entries_.clear();
    if (seeds_.weights.empty() || seeds_.weights[seed] == probes_[k].weight)
        entries_.push_back({seeds_.input[seed], 1, {unknown, unknown, unknown}});
    give(k);
}

void NaturalRows::read_planes(std::size_t k, Star& star) {
    const Probe& probe = probes_[k];
    const SeedImages* images = seeds_.images;
    shape_.planes.clear();
    const bool at_wall = std::ranges::any_of(star.faces(), [](std::int32_t id) { return id < 0; });
    if (at_wall) star.normals(normals_);
    for (const std::int32_t id : star.faces()) {
        ProbeShape::Plane plane{id, {}, 0};
        if (id < 0) {
            const CellPolygons& polygons = shape_.polygons;
            const std::size_t face = shape_.planes.size();
            plane.n = normals_[face];
            plane.h = dot(plane.n, polygons.positions[polygons.corners[polygons.offsets[face]]]);
        } else {
            const auto i = static_cast<std::size_t>(id);
            exact::Plane bisector = exact::Plane::bisector({seeds_.x[i], seeds_.y[i], seeds_.z[i]});
            if (images != nullptr) {
                plane.seed = images->home(id);
                bisector = images->bisector({probe.x, probe.place.by}, plane.seed, images->shift(id));
            }
            const auto d = exact::differences(probe.x, bisector).x;
            for (std::size_t c = 0; c < 3; ++c) plane.n[c] = d[c].high;
            plane.h = 0.5 * dot(plane.n, plane.n);
            if (!seeds_.weights.empty())
                plane.h += 0.5 * (probe.weight - seeds_.weights[static_cast<std::size_t>(plane.seed)]);
        }
        shape_.planes.push_back(plane);
    }
}

void NaturalRows::read_planes(Cell& cell, const CellFaces& faces) {
    shape_.planes.clear();
    for (const std::int32_t p : faces.planes) {
        const CellPlane& plane = cell.planes()[static_cast<std::size_t>(p)];
        if (plane.id == static_cast<std::int32_t>(seeds_.places()))
            throw Error(ErrorCode::unsupported,
                        "the periodic box holds so few seeds that the cell of a query meets its own image: natural "
                        "neighbors are not known there, repeat the seeds in a larger box");
        shape_.planes.push_back({plane.id, plane.n, plane.h});
    }
}

void NaturalRows::divide(std::size_t k) {
    entries_.clear();
    const auto& planes = shape_.planes;
    const bool at_wall = std::ranges::any_of(planes, [](const auto& plane) { return plane.seed < 0; });
    if (at_wall && !options_.at_walls) return give(k);
    const bool sibson = options_.method == NaturalMethod::sibson;
    if (sibson && sibson_.divide(shape_, options_.gradients, division_)) return give_division(k);
    if (sibson) sibson_.cut(shape_, volumes_);
    if (!sibson || options_.gradients) measure_faces();
    for (std::size_t f = 0; f < planes.size(); ++f) {
        if (planes[f].seed < 0) continue;
        const double distance = std::sqrt(dot(planes[f].n, planes[f].n));
        const double weight = sibson ? volumes_[f] : std::sqrt(dot(faces_of_[f].area, faces_of_[f].area)) / distance;
        add_entry(planes[f].seed, weight, sibson && options_.gradients ? faces_of_[f].moment : Vector{}, distance);
    }
    finish(k);
}

void NaturalRows::give_division(std::size_t k) {
    for (std::size_t a = 0; a < division_.size(); ++a) {
        const Vector n = division_.normal(a);
        add_entry(division_.seed(a), division_.volume(a), division_.moment(a),
                  options_.gradients ? std::sqrt(dot(n, n)) : 1);
    }
    finish(k);
}

// Sums up area vectors and moments of the polygons.
void NaturalRows::measure_faces() {
    const CellPolygons& polygons = shape_.polygons;
    faces_of_.assign(polygons.size(), {});
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        const auto corner = [&](std::uint32_t c) { return polygons.positions[polygons.corners[c]]; };
        const Vector first = corner(polygons.offsets[f]), n = shape_.planes[f].n;
        const double inverse = 1 / std::sqrt(dot(n, n));
        for (std::uint32_t c = polygons.offsets[f] + 1; c + 1 < polygons.offsets[f + 1]; ++c) {
            const Vector a = corner(c), b = corner(c + 1);
            Vector u, v, part;
            for (std::size_t i = 0; i < 3; ++i) u[i] = a[i] - first[i], v[i] = b[i] - first[i];
            for (std::size_t i = 0; i < 3; ++i)
                part[i] = 0.5 * (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
            const double size = dot(part, n) * inverse;
            for (std::size_t i = 0; i < 3; ++i) {
                faces_of_[f].area[i] += part[i];
                faces_of_[f].moment[i] += size * (first[i] + a[i] + b[i]) / 3;
            }
        }
    }
}

// moment: the integral of x over the face at that distance. The volume grows as the face moves, at each of its points x
// by (x - q) / d when the probe q does.
void NaturalRows::add_entry(std::int32_t seed, double weight, const Vector& moment, double distance) {
    Entry entry{seeds_.input[static_cast<std::size_t>(seed)], weight, {}};
    for (std::size_t i = 0; i < 3 && options_.gradients; ++i) entry.gradient[i] = moment[i] / distance;
    entries_.push_back(entry);
}

void NaturalRows::finish(std::size_t k) {
    double total = 0;
    for (const Entry& entry : entries_) total += entry.weight;
    if (!(total > 0)) entries_.clear();
    for (Entry& entry : entries_) entry.weight /= total;
    if (options_.gradients) add_gradients(total);
    give(k);
}

// The gradients of weights follow from those of volumes.
void NaturalRows::add_gradients(double total) {
    Vector sum{};
    for (const Entry& entry : entries_)
        for (std::size_t i = 0; i < 3; ++i) sum[i] += entry.gradient[i];
    for (Entry& entry : entries_)
        for (std::size_t i = 0; i < 3; ++i)
            entry.gradient[i] = (entry.gradient[i] - entry.weight * sum[i]) / (total * unscale_);
}

// In ascending order. A seed of which several images are neighbors has one entry.
void NaturalRows::give(std::size_t k) {
    order_.resize(entries_.size());
    for (std::size_t e = 0; e < order_.size(); ++e) {
        const std::uint64_t key = std::uint64_t{static_cast<std::uint32_t>(entries_[e].seed)} << 32 | e;
        std::size_t place = e;
        for (; place > 0 && order_[place - 1] > key; --place) order_[place] = order_[place - 1];
        order_[place] = key;
    }
    row_seeds_.clear();
    row_weights_.clear();
    row_gradients_.clear();
    for (const std::uint64_t key : order_) {
        const Entry& entry = entries_[static_cast<std::uint32_t>(key)];
        const bool again = !row_seeds_.empty() && row_seeds_.back() == entry.seed;
        if (!again) {
            row_seeds_.push_back(entry.seed);
            row_weights_.push_back(entry.weight);
        } else {
            row_weights_.back() += entry.weight;
        }
        if (!options_.gradients) continue;
        if (!again) row_gradients_.push_back({});
        for (std::size_t i = 0; i < 3; ++i) row_gradients_.back()[i] += entry.gradient[i];
    }
    out_->take(k, {row_seeds_, row_weights_, row_gradients_});
}

}  // namespace votess::cpu

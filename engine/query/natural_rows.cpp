#include "query/natural_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/vector3.hpp"
#include "index/seed_images.hpp"

namespace votess::cpu {
namespace {

using Vector = Vector3;

}  // namespace

void NaturalRows::begin_job(const Job& job, const NaturalOptions& options, const FieldEnds& ends) {
    domain_ = job.domain.get();
    options_ = options;
    ends_ = ends;
    unscale_ = 1 / job.scale;
    shape_.weighted = domain_->has_weights();
    divider_.begin_job(std::max(std::abs(domain_->min_weight), std::abs(domain_->largest_weight)));
    parts_.begin_job(*domain_);
}

bool NaturalRows::take_by_graph(std::size_t k) {
    entries_.clear();
    if (!divider_.divide(probes_[k], options_.gradients, division_)) return false;
    give_division(k);
    return true;
}

bool NaturalRows::take(std::size_t k, Star& star) {
    if (!star.knows_vertices()) return false;
    entries_.clear();
    if (std::ranges::any_of(star.faces(), [this](std::int32_t id) { return ends_.has(id); })) {
        give(k);
        return true;
    }
    read_shape(k, star);
    const bool known = shape_.find_corners();
    if (options_.method == NaturalMethod::laplace) return known && give_areas(k);
    neighbors_.clear();
    for (const std::int32_t id : star.faces()) {
        if (id < 0) continue;
        const SeedImages* images = seeds_.images;
        neighbors_.push_back(images == nullptr ? Member{id} : Member{images->home(id), images->shift(id)});
    }
    if (known && (!options_.gradients || knows_corners(0x1p-33)) &&
        sibson_.divide(shape_, options_.gradients, division_) && buries_none(k)) {
        give_division(k);
        return true;
    }
    give_parts(k);
    return true;
}

void NaturalRows::take(std::size_t k, Cell& cell) {
    constexpr std::size_t min_faces = 4;
    entries_.clear();
    if (!cell.empty()) cell.canonical_faces(faces_);
    if (cell.empty() || faces_.size() < min_faces) return give(k);
    neighbors_.clear();
    for (const std::int32_t p : faces_.planes) {
        const CellPlane& plane = cell.planes()[static_cast<std::size_t>(p)];
        if (plane.id == static_cast<std::int32_t>(seeds_.places()))
            throw Error(ErrorCode::unsupported,
                        "the periodic box holds so few seeds that the cell of a query meets its own image: natural "
                        "neighbors are not known there, repeat the seeds in a larger box");
        if (ends_.has(plane.id)) return give(k);
        if (plane.id >= 0) neighbors_.push_back({plane.id, plane.shift});
    }
    if (options_.method == NaturalMethod::sibson) return give_parts(k);
    give_areas(k, cell);
}

// After the division. Appends the seeds that the probe may bury to its neighbors.
bool NaturalRows::buries_none(std::size_t k) {
    if (!nearer_.may_bury()) return true;
    nearer_.begin(probes_[k]);
    sibson_.for_vertices(probes_[k].weight,
                         [this](const Vector& x, double power, double error) { nearer_.add_vertex(x, power, error); });
    const std::size_t neighbors = neighbors_.size();
    return nearer_.find(neighbors_) && neighbors_.size() == neighbors;
}

// All of the weight is the seed's.
bool NaturalRows::taken(std::size_t k, std::size_t seed) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    entries_.clear();
    if (seeds_.weights.empty() || seeds_.weights[seed] == probes_[k].weight)
        entries_.push_back({seeds_.input[seed], 1, {unknown, unknown, unknown}});
    give(k);
    return false;
}

void NaturalRows::read_shape(std::size_t k, Star& star) {
    ranks_.resize(star.faces().size());
    std::iota(ranks_.begin(), ranks_.end(), 0u);
    star.polygons(ranks_, shape_.polygons);
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
                bisector = images->bisector({probe.x, probe.place.shift}, plane.seed, images->shift(id));
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

void NaturalRows::give_division(std::size_t k) {
    for (std::size_t a = 0; a < division_.size(); ++a) {
        const Vector n = division_.normal(a);
        add_entry(division_.seed(a), division_.volume(a), division_.moment(a),
                  options_.gradients ? std::sqrt(dot(n, n)) : 1);
    }
    finish(k);
}

void NaturalRows::give_parts(std::size_t k) {
    for (const Part& part : parts_.divide(probes_[k], neighbors_, options_.gradients))
        add_entry(part.home, part.volume, part.moment, part.distance);
    finish(k);
}

// Returns whether each corner is known to a small part of the farthest distance. Such a corner lies near its planes,
// and they do not meet at a small angle.
bool NaturalRows::knows_corners(double accepted_error) const {
    constexpr double rounding = 0x1p-53;
    double farthest_squared = 0;
    for (const auto& corner : shape_.corners) farthest_squared = std::max(farthest_squared, dot(corner.x, corner.x));
    const double farthest = std::sqrt(farthest_squared);
    return std::ranges::all_of(shape_.corners, [&](const ProbeShape::Corner& corner) {
        double off = rounding * farthest, lengths = 1;
        for (const std::uint8_t p : corner.planes) {
            const ProbeShape::Plane& plane = shape_.planes[p];
            const double length = std::sqrt(dot(plane.n, plane.n));
            off = std::max(off, std::abs(plane.h - dot(plane.n, corner.x)) / length);
            lengths *= length;
        }
        const auto& [a, b, c] = corner.planes;
        const double volume = dot(shape_.planes[a].n, cross(shape_.planes[b].n, shape_.planes[c].n));
        return off * lengths <= accepted_error * farthest * std::abs(volume);
    });
}

bool NaturalRows::give_areas(std::size_t k) {
    if (!knows_corners(0x1p-41)) return false;
    constexpr double min_share = 1e-11;  // below it the sign of an area might be rounding
    const CellPolygons& polygons = shape_.polygons;
    double total = 0, least = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < shape_.planes.size(); ++f) {
        const auto& [seed, n, h] = shape_.planes[f];
        if (seed < 0) continue;
        const auto corner = [&](std::size_t c) { return polygons.positions[polygons.face(f)[c]]; };
        const Vector first = corner(0);
        Vector doubled{};
        for (std::size_t c = 1; c + 1 < polygons.face(f).size(); ++c) {
            const Vector part = cross(minus(corner(c), first), minus(corner(c + 1), first));
            for (std::size_t i = 0; i < 3; ++i) doubled[i] += part[i];
        }
        const double weight = 0.5 * dot(doubled, n) / dot(n, n);
        add_entry(seed, weight, {}, 1);
        total += weight;
        least = std::min(least, weight);
    }
    if (!(least > min_share * total)) {
        entries_.clear();
        return false;
    }
    finish(k);
    return true;
}

void NaturalRows::give_areas(std::size_t k, const Cell& cell) {
    constexpr double accepted_error = 0x1p-37;  // of the sum of all; bounds are some hundred times too large
    areas_.clear();
    double total = 0;
    const auto plane = [&](std::size_t f) -> const CellPlane& {
        return cell.planes()[static_cast<std::size_t>(faces_.planes[f])];
    };
    const auto measure = [&](std::size_t f, Precision precision) {
        const auto [value, error] = measure_face(cell, faces_, f, precision).area;
        return Measured{value / plane(f).norm, error / plane(f).norm};
    };
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        areas_.push_back(measure(f, Precision::cell));
        if (plane(f).id >= 0) total += areas_.back().value;
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        if (plane(f).id < 0) continue;
        for (const Precision precision : {Precision::quad, Precision::wide}) {
            if (areas_[f].error <= accepted_error * total && areas_[f].value > 2 * areas_[f].error) break;
            areas_[f] = measure(f, precision);
        }
        add_entry(plane(f).id, areas_[f].value, {}, 1);
    }
    finish(k);
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

// The gradients of weights follow from those of volumes, and sum to 0. Near a seed the terms of the largest weight
// cancel. So its gradient is minus the sum of the others.
void NaturalRows::add_gradients(double total) {
    if (entries_.empty()) return;
    Vector sum{}, left{};
    for (const Entry& entry : entries_)
        for (std::size_t i = 0; i < 3; ++i) sum[i] += entry.gradient[i];
    Entry& largest = *std::ranges::max_element(entries_, {}, &Entry::weight);
    for (Entry& entry : entries_)
        for (std::size_t i = 0; i < 3 && &entry != &largest; ++i) {
            entry.gradient[i] = (entry.gradient[i] - entry.weight * sum[i]) / (total * unscale_);
            left[i] -= entry.gradient[i];
        }
    largest.gradient = left;
}

// In ascending order. A seed of which several images are neighbors has one entry.
void NaturalRows::give(std::size_t k) {
    order_.resize(entries_.size());
    for (std::size_t e = 0; e < order_.size(); ++e)
        order_[e] = std::uint64_t{static_cast<std::uint32_t>(entries_[e].seed)} << 32 | e;
    std::ranges::sort(order_);
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

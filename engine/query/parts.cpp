#include "query/parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/vector3.hpp"
#include "exact/predicate.hpp"

namespace votess::cpu {
namespace {

// Accepted error of a volume, relative to the sum. Bounds are some hundred times larger than errors.
constexpr double accepted_sum_error = 0x1p-37;
constexpr double accepted_of_moments = 0x1p-34;  // of a volume and an area, of themselves, where moments are wanted
constexpr std::size_t min_faces = 4;
// Members from which on a triangulation costs less than to try each for each part.
constexpr std::size_t min_triangulated = 64;

exact::Shift difference(const exact::Shift& a, const exact::Shift& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

}  // namespace

SeedImages::Base Parts::base_of(std::int32_t home) const {
    const auto s = static_cast<std::size_t>(home);
    return seeds_.images == nullptr ? SeedImages::Base{{seeds_.x[s], seeds_.y[s], seeds_.z[s]}, {}}
                                    : seeds_.images->base(s);
}

PowerSites Parts::sites_of_members() const {
    std::vector<PowerSites::Site> sites;
    for (const auto& [home, shift] : members_) {
        const auto& [point, moved] = base_of(home);
        const double weight = seeds_.weights.empty() ? 0 : seeds_.weights[static_cast<std::size_t>(home)];
        sites.push_back({point, difference(shift, difference({}, moved)), weight});
    }
    return PowerSites(std::move(sites), seeds_.images == nullptr ? nullptr : &seeds_.images->domain().lattice);
}

// The bisector of a member and the probe, as the member sees it.
exact::Plane Parts::guard_of(const Member& member) const {
    exact::Plane guard = exact::Plane::bisector(probe_->x);
    if (seeds_.images != nullptr) {
        const exact::Shift by = difference(difference(probe_->place.shift, member.shift), base_of(member.home).shift);
        guard = exact::Plane::bisector(probe_->x, by, seeds_.images->domain().lattice);
    }
    if (!seeds_.weights.empty())
        guard.power = exact::two_sum(seeds_.weights[static_cast<std::size_t>(member.home)], -probe_->weight);
    guard.reverse();
    return guard;
}

Cell& Parts::build(std::size_t k, std::span<const exact::Plane> guards) {
    const auto home = static_cast<std::size_t>(members_[k].home);
    if (search_) return builder_.build(home, guards);
    homes_.clear();
    shifts_.clear();
    const auto add = [&](const Member& other) {
        homes_.push_back(other.home);
        shifts_.push_back(difference(other.shift, members_[k].shift));
    };
    if (triangulation_) {
        triangulation_->neighbors(k, around_, marks_);
        for (const std::int32_t other : around_) add(members_[static_cast<std::size_t>(other)]);
    } else {
        for (std::size_t other = 0; other < members_.size(); ++other)
            if (other != k) add(members_[other]);
    }
    clips_ += homes_.size();
    return builder_.build_from(home, homes_, shifts_, guards);
}

bool Parts::clip(std::size_t k) {
    if (!search_ && triangulation_ && triangulation_->is_hidden(k)) return false;
    const exact::Plane guard = guard_of(members_[k]);
    const auto apart = exact::differences(base_of(members_[k].home).point, guard).x;
    to_probe_ = {apart[0].high, apart[1].high, apart[2].high};
    // A heavier probe at the place of the seed is nearer everywhere.
    const bool same = std::ranges::all_of(apart, [](const auto& x) { return x.high == 0; });
    Cell& cell = build(k, std::span(&guard, same ? 0 : 1));
    cell_ = &cell;
    if (!cell.empty()) cell.canonical_faces(faces_);
    return !cell.empty() && faces_.size() >= min_faces;
}

void Parts::add(const Member& member) {
    if (found_.insert(member).second) members_.push_back(member);
}

// The seeds across the faces of the cell at hand.
void Parts::add_neighbors_of(std::size_t k) {
    const exact::Shift by = members_[k].shift;
    for (const std::int32_t p : faces_.planes) {
        const CellPlane& plane = cell_->planes()[static_cast<std::size_t>(p)];
        if (plane.id < 0 || static_cast<std::size_t>(plane.id) >= seeds_.size()) continue;
        add({plane.id, {plane.shift[0] + by[0], plane.shift[1] + by[1], plane.shift[2] + by[2]}});
    }
}

// The vertices of the cell at hand.
void Parts::add_vertices_of(std::size_t k) {
    const double weight = seeds_.weights.empty() ? 0 : seeds_.weights[static_cast<std::size_t>(members_[k].home)];
    for (int slot = 0; slot < cell_->slots(); ++slot) {
        if (!cell_->alive(slot)) continue;
        const Vector3 x = cell_->position(slot);
        nearer_.add_vertex(minus(x, to_probe_), dot(x, x) - weight, 3 * cell_->tolerance(slot));
    }
}

void Parts::triangulate() {
    triangulation_.reset();
    if (members_.size() < min_triangulated) return;
    triangulation_.emplace(members_.size(), sites_of_members());
    if (!triangulation_->valid()) triangulation_.reset();
}

void Parts::clip_all() {
    triangulate();
    known_.clear();
    if (nearer_.may_bury()) nearer_.begin(*probe_);
    for (std::size_t k = 0; k < members_.size(); ++k) {
        if (!clip(k)) continue;
        known_.push_back(measure(k, Precision::cell));
        if (nearer_.may_bury()) add_vertices_of(k);
    }
}

void Parts::clip_by_search() {
    known_.clear();
    found_.clear();
    const std::vector<Member> begin = std::exchange(members_, {});
    for (const Member& member : begin) add(member);
    // A cell without neighbors is the whole domain, and buries all seeds.
    if (begin.empty())
        for (std::size_t s = 0; s < seeds_.size(); ++s) add({static_cast<std::int32_t>(s)});
    for (std::size_t k = 0; k < members_.size(); ++k) {
        if (clip(k)) {
            known_.push_back(measure(k, Precision::cell));
            add_neighbors_of(k);
            continue;
        }
        // The bisector of the probe may be that of another seed, which has the part behind it.
        Cell& cell = build(k, {});
        if (!cell.empty()) cell.canonical_faces(faces_), add_neighbors_of(k);
    }
}

std::span<const Part> Parts::divide(const Probe& probe, std::span<const Member> neighbors, bool moments) {
    probe_ = &probe;
    moments_ = moments;
    members_.assign(neighbors.begin(), neighbors.end());
    search_ = members_.empty();
    // Each round adds seeds that may be nearer than those known.
    for (std::size_t known = 0; !search_ && known < members_.size();) {
        clip_all();
        known = members_.size();
        search_ = nearer_.may_bury() && !nearer_.find(members_);
    }
    if (search_) clip_by_search();
    double total = 0;
    for (const Known& known : known_) total += known.part.volume;
    parts_.clear();
    for (Known& known : known_) {
        const auto is_known = [&known, moments](double whole) {
            if (moments && !(known.error <= accepted_of_moments * known.part.volume &&
                             known.area.error <= accepted_of_moments * known.area.value))
                return false;
            return known.error <= accepted_sum_error * whole && known.part.volume > 2 * known.error;
        };
        for (const Precision precision : {Precision::quad, Precision::wide}) {
            if (is_known(precision == Precision::quad ? total : known.part.volume)) break;
            (void)clip(known.member);
            known = measure(known.member, precision);
        }
        parts_.push_back(known.part);
    }
    return parts_;
}

Parts::Known Parts::measure(std::size_t k, Precision precision) const {
    const auto [volume, error] = measure_volume(*cell_, faces_, precision);
    Known known{k, {members_[k].home, volume}, error, {}};
    const auto guard = static_cast<std::int32_t>(seeds_.places()) + 1;
    for (std::size_t f = 0; f < faces_.size() && moments_; ++f) {
        const CellPlane& plane = cell_->planes()[static_cast<std::size_t>(faces_.planes[f])];
        if (plane.id != guard) continue;
        const auto [area, moment] = measure_face(*cell_, faces_, f, precision);
        known.area = area;
        known.part.distance = plane.norm;
        // The probe lies at -n, as the seed sees it.
        for (std::size_t i = 0; i < 3; ++i) known.part.moment[i] = moment[i] + area.value * plane.n[i];
    }
    return known;
}

}  // namespace votess::cpu

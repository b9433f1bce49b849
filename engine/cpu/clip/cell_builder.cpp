#include "cpu/clip/cell_builder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>

namespace votess::cpu {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t first_window = 160;         // seeds loaded around a group at once
constexpr std::size_t most_window = 768;          // beyond this the far walk is cheaper
constexpr std::size_t most_tests_by_reach = 512;  // of images; then each is tested against the vertices themselves
constexpr double first_band = 0.8;                // of the squared reach expected
constexpr double band_growth = 1.6;               // of the squared distance from band to band
// Covers the rounding of squared distances and of 4 R^2 (a few units in 2^53 each).
constexpr double distance_slack = 1 + 1e-12;

bool farther(const QueueEntry& a, const QueueEntry& b) {
    return a.distance_squared > b.distance_squared;
}

bool farther_images(const FarEntry& a, const FarEntry& b) {
    return a.distance_squared > b.distance_squared;
}

double gap(double a_lower, double a_upper, double b_lower, double b_upper) {
    return std::max({0.0, a_lower - b_upper, b_lower - a_upper});
}

// Returns at most the squared distance between any point of a and any of b.
double box_distance(const Box& a, const Box& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double d = gap(a.lower[k], a.upper[k], b.lower[k], b.upper[k]);
        sum += d * d;
    }
    return sum * (1 - 1e-14);
}

// Opens the children of a node, or the root when level is above the top.
template <class Visit>
void for_each_child(const Hierarchy& hierarchy, const QueueEntry& entry, Visit visit) {
    const int level = entry.level - 1;
    const std::size_t begin = entry.node * Hierarchy::fan;
    const std::size_t end = std::min(begin + Hierarchy::fan, hierarchy.count(level));
    for (std::size_t node = begin; node < end; ++node) visit(level, node, hierarchy.box(level, node));
}

}  // namespace

CellBuilder::CellBuilder(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels)
    : kernels_(kernels), seeds_(seeds), hierarchy_(hierarchy), cell_(kernels) {}

void CellBuilder::begin_job(const Domain& domain) {
    domain_ = &domain;
    plain_ = !domain.is_periodic() && !domain.has_weights();
    rounding_ = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        place_rounding_[k] = seeds_.images == nullptr ? 0 : 8 * 0x1p-53 * seeds_.images->largest_rounded()[k];
        rounding_ = std::max(rounding_, place_rounding_[k]);
    }
    more_weight_ = 0;
    heaviest_ = -1;
    if (domain.is_periodic() && !seeds_.weights.empty())
        heaviest_ = static_cast<std::int32_t>(std::ranges::max_element(seeds_.weights) - seeds_.weights.begin());
    group_ = ~std::size_t{0};
    reach_ = 0;
}

void CellBuilder::start(std::size_t seed) {
    const exact::Point at{seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    base_ = seeds_.images == nullptr ? SeedImages::Base{at, {}} : seeds_.images->base(seed);
    if (!seeds_.weights.empty()) more_weight_ = domain_->most_more(seeds_.weights[seed]);
    cell_.start(base_.point, *domain_, static_cast<std::int32_t>(seed));
    seed_ = seed;
    if (heaviest_ >= 0) clip_by_heaviest(at);
}

// The heaviest seed has an image near any place. It buries what is much lighter, and after it no weight can reach a
// cell from far away.
void CellBuilder::clip_by_heaviest(const exact::Point& at) {
    const auto i = static_cast<std::size_t>(heaviest_);
    if (i == seed_) return;
    const auto f = domain_->reduced.fraction({at[0] - seeds_.x[i], at[1] - seeds_.y[i], at[2] - seeds_.z[i]});
    ShiftRange nearest;
    for (std::size_t j = 0; j < 3; ++j)
        if (domain_->periodic[j]) nearest.least[j] = static_cast<std::int32_t>(std::round(f[j]));
    clip_by_image(heaviest_, only_shift(*domain_, nearest));
}

void CellBuilder::clip_by(std::int32_t id, double x, double y, double z) {
    if (plain_)
        cell_.clip(id, {x, y, z});
    else if (seeds_.images == nullptr)
        clip_by_image(id, {});
    else
        clip_by_image(seeds_.images->home(id), seeds_.images->shift(id));
}

void CellBuilder::clip_by_image(std::int32_t home, const exact::Shift& shift) {
    const auto i = static_cast<std::size_t>(home);
    // The nearest of them are there from the start.
    if ((i == seed_ || home == heaviest_) && cell_.knows(home, shift)) return;
    exact::Plane plane = seeds_.images == nullptr ? exact::Plane::bisector({seeds_.x[i], seeds_.y[i], seeds_.z[i]})
                                                  : seeds_.images->bisector(base_, home, shift);
    if (!seeds_.weights.empty()) plane.power = exact::two_sum(seeds_.weights[seed_], -seeds_.weights[i]);
    cell_.clip(home, plane, shift);
}

// A seed of weight w cuts the cell of weight w_p only when it is nearer than R + sqrt(R^2 + w - w_p), where R is the
// distance to the farthest vertex.
double CellBuilder::reach_squared() {
    if (cell_.empty()) return 0;
    const double square = cell_.radius_squared();
    if (plain_) return 4 * square * distance_slack;
    const double reach = (std::sqrt(square) + std::sqrt(square + more_weight_)) * distance_slack + rounding_;
    return reach * reach;
}

void CellBuilder::open_window(std::size_t group) {
    group_ = group;
    home_ = hierarchy_.box(0, group);
    queue_.assign(1, {0, hierarchy_.top_level(), 0});
    covered_ = 0;
    for (auto* v : {&x_, &y_, &z_}) v->clear();
    index_.clear();
    // Groups that overlap the home box lie at distance 0: go on until the window proves anything.
    for (std::size_t least = first_window; least <= most_window; least *= 2) {
        extend_window(0, least);
        if (covered_ > 0) break;
    }
    // The neighbor in memory is a neighbor in space, its cell of about this size; but density may jump.
    reach_ = std::clamp(reach_, covered_, 8 * covered_);
}

void CellBuilder::pop_into_window() {
    std::pop_heap(queue_.begin(), queue_.end(), farther);
    const QueueEntry entry = queue_.back();
    queue_.pop_back();
    if (entry.level > 0) {
        for_each_child(hierarchy_, entry, [&](int level, std::size_t node, const Box& box) {
            queue_.push_back({box_distance(box, home_), level, static_cast<std::uint32_t>(node)});
            std::push_heap(queue_.begin(), queue_.end(), farther);
        });
    } else {
        const std::size_t begin = entry.node * group_size, end = begin + group_size;
        x_.insert(x_.end(), seeds_.x.begin() + begin, seeds_.x.begin() + end);
        y_.insert(y_.end(), seeds_.y.begin() + begin, seeds_.y.begin() + end);
        z_.insert(z_.end(), seeds_.z.begin() + begin, seeds_.z.begin() + end);
        for (std::size_t i = begin; i < end; ++i) index_.push_back(static_cast<std::int32_t>(i));
    }
}

void CellBuilder::extend_window(double distance_squared, std::size_t least_count) {
    while (!queue_.empty() && index_.size() < most_window &&
           (queue_.front().distance_squared < distance_squared || index_.size() < least_count))
        pop_into_window();
    covered_ = queue_.empty() ? infinity : queue_.front().distance_squared;
}

Cell* CellBuilder::build(std::size_t seed, std::size_t most_tests) {
    tests_ = 0;
    most_tests_ = most_tests;
    if (most_tests == 0) return nullptr;
    if (seed / group_size != group_) open_window(seed / group_size);
    start(seed);
    measured_ = 0;
    double from = 0;
    double to = first_band * reach_;
    for (;;) {
        if (to > covered_) {
            extend_window(to, 0);
            to = std::min(to, covered_);
        }
        if (to <= from && covered_ < infinity) {
            clip_far(seed, from);
            break;
        }
        if (clip_band(seed, from, to) || to == infinity) break;
        from = to;
        to = covered_ == infinity ? infinity : std::min(to * band_growth, reach_squared());
    }
    if (seeds_.images != nullptr) clip_far_images(seed);
    if (exhausted()) return nullptr;
    reach_ = reach_squared();
    return &cell_;
}

Cell& CellBuilder::build_from(std::size_t seed, std::span<const std::int32_t> candidates) {
    start(seed);
    const exact::Point p{seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    candidates_.clear();
    for (const std::int32_t i : candidates) {
        const double d[3] = {seeds_.x[i] - p[0], seeds_.y[i] - p[1], seeds_.z[i] - p[2]};
        candidates_.emplace_back(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], i);
    }
    std::sort(candidates_.begin(), candidates_.end());
    for (const auto& [distance, i] : candidates_) {
        if (distance >= reach_squared()) break;
        clip_by(i, seeds_.x[i], seeds_.y[i], seeds_.z[i]);
    }
    return cell_;
}

Cell& CellBuilder::build_from(std::size_t seed, std::span<const std::int32_t> candidates,
                              std::span<const exact::Shift> shifts) {
    start(seed);
    for (std::size_t k = 0; k < candidates.size(); ++k) clip_by_image(candidates[k], shifts[k]);
    return cell_;
}

Cell& CellBuilder::again(CellFaces& faces) {
    cell_.canonical_faces(faces);
    if (!plain_) return again_by_planes(faces);
    neighbors_.clear();
    for (const std::int32_t p : faces.planes)
        if (const std::int32_t id = cell_.planes()[p].id; id >= 0) neighbors_.push_back(id);
    return build_from(seed_, neighbors_);
}

Cell& CellBuilder::again_by_planes(const CellFaces& faces) {
    planes_.clear();
    for (const std::int32_t p : faces.planes)
        if (const CellPlane& plane = cell_.planes()[p]; plane.source.is_bisector()) planes_.push_back(plane);
    // A cell without volume has lost faces that bound it.
    constexpr std::size_t least_faces = 4;
    if (cell_.empty() || faces.size() < least_faces) return cell_;
    std::ranges::sort(planes_, [](const CellPlane& a, const CellPlane& b) {
        return std::tie(a.norm, a.id, a.shift) < std::tie(b.norm, b.id, b.shift);
    });
    start(seed_);
    for (const CellPlane& plane : planes_) {
        if (!cell_.knows(plane.id, plane.shift)) cell_.clip(plane.id, plane.source, plane.shift);
    }
    return cell_;
}

bool CellBuilder::clip_band(std::size_t seed, double from, double to) {
    const std::size_t count = index_.size();
    if (measured_ < count) {
        distance_.resize(count);
        const double p[3] = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
        kernels_.squared_distances(x_.data() + measured_, y_.data() + measured_, z_.data() + measured_,
                                   static_cast<int>(count - measured_), p, distance_.data() + measured_);
        // The home group comes first into the window, but equal distances may put another before it.
        for (std::size_t i = measured_; i < count; ++i)
            if (index_[i] == static_cast<std::int32_t>(seed)) distance_[i] = infinity;
        measured_ = count;
    }
    band_.resize(count + lanes);
    const int selected = kernels_.select_band(distance_.data(), static_cast<int>(count), from, to, band_.data());
    std::sort(band_.begin(), band_.begin() + selected);
    for (int k = 0; k < selected; ++k) {
        const std::uint64_t key = band_[k];
        const double at_least = std::bit_cast<double>(key & key_distance_bits);
        if (at_least >= reach_squared()) return true;
        if (++tests_ > most_tests_) return true;
        const auto i = static_cast<std::uint32_t>(key);
        clip_by(index_[i], x_[i], y_[i], z_[i]);
    }
    return to >= reach_squared();
}

void CellBuilder::clip_far(std::size_t seed, double from) {
    const exact::Point p{seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    const Box here{p, p};
    far_queue_.assign(1, {0, hierarchy_.top_level(), 0});
    while (!far_queue_.empty()) {
        std::pop_heap(far_queue_.begin(), far_queue_.end(), farther);
        const QueueEntry entry = far_queue_.back();
        far_queue_.pop_back();
        if (entry.distance_squared >= reach_squared()) return;
        if (++tests_ > most_tests_) return;
        if (!cell_.in_reach(seen_from(p, hierarchy_.box(entry.level, entry.node), place_rounding_), more_weight_))
            continue;
        if (entry.level > 0) {
            for_each_child(hierarchy_, entry, [&](int level, std::size_t node, const Box& box) {
                far_queue_.push_back({box_distance(box, here), level, static_cast<std::uint32_t>(node)});
                std::push_heap(far_queue_.begin(), far_queue_.end(), farther);
            });
            continue;
        }
        const std::size_t begin = entry.node * group_size, end = seeds_.group_end(begin);
        double distance[group_size];
        kernels_.squared_distances(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], static_cast<int>(end - begin),
                                   p.data(), distance);
        for (std::size_t i = begin; i < end; ++i) {
            if (distance[i - begin] < from || i == seed) continue;
            clip_by(static_cast<std::int32_t>(i), seeds_.x[i], seeds_.y[i], seeds_.z[i]);
            ++tests_;
        }
    }
}

void CellBuilder::push_far(const exact::Point& p, const ImageNode& node) {
    const Box images = seen_from({}, images_of(*domain_, box_of(node, seeds_, hierarchy_), node.shifts, p),
                                 seeds_.images->rounding_of_seeds());
    const double distance_squared = box_distance(images, {});
    if (distance_squared >= reach_squared()) return;
    far_images_.push_back({distance_squared, node, images});
    std::push_heap(far_images_.begin(), far_images_.end(), farther_images);
}

void CellBuilder::clip_far_group(const exact::Point& p, const FarEntry& entry, double from) {
    const exact::Shift shift = only_shift(*domain_, entry.at.shifts);
    const exact::Point by = domain_->translation(shift), moved{p[0] - by[0], p[1] - by[1], p[2] - by[2]};
    const std::size_t begin = entry.at.node * group_size, end = std::min(seeds_.group_end(begin), seeds_.size());
    double distance[group_size];
    kernels_.squared_distances(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], static_cast<int>(end - begin),
                               moved.data(), distance);
    for (std::size_t i = begin; i < end; ++i) {
        const auto id = static_cast<std::int32_t>(i);
        if (distance[i - begin] < from || cell_.knows(id, shift)) continue;
        clip_by_image(id, shift);
        ++tests_;
    }
}

void CellBuilder::clip_far_images(std::size_t seed) {
    const exact::Point p{seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    const double known = std::max(0.0, seeds_.images->reach(p) - rounding_);
    if (reach_squared() <= known * known) return;
    // Images surely nearer than that have been tried; bounds of images are rounded outward by more than coordinates
    // are.
    const double tried = std::max(0.0, known * (1 - 1e-9) - 64 * rounding_);
    const int top = hierarchy_.top_level();
    far_images_.clear();
    push_far(p, {top, 0, shifts_around(*domain_, hierarchy_.box(top, 0), p, std::sqrt(reach_squared()))});
    while (!far_images_.empty()) {
        std::pop_heap(far_images_.begin(), far_images_.end(), farther_images);
        const FarEntry entry = far_images_.back();
        far_images_.pop_back();
        const double reach = reach_squared();
        if (entry.distance_squared >= reach || reach <= known * known) return;
        if (++tests_ > most_tests_) return;
        if (!cell_.in_reach(entry.images, more_weight_)) continue;
        if (tests_ > most_tests_by_reach && !cell_.may_cut(entry.images, more_weight_)) continue;
        const bool single = entry.at.shifts.is_single();
        if (single && entry.at.shifts == ShiftRange{}) continue;  // the seeds themselves
        if (single && entry.at.level == 0) {
            clip_far_group(p, entry, tried * tried);
            continue;
        }
        if (!entry.at.is_single()) {
            for_each_part(entry.at, *domain_, seeds_, hierarchy_, [&](const ImageNode& part) { push_far(p, part); });
            continue;
        }
        const auto id = static_cast<std::int32_t>(entry.at.node);
        const exact::Shift shift = only_shift(*domain_, entry.at.shifts);
        if (entry.distance_squared < tried * tried || cell_.knows(id, shift)) continue;
        clip_by_image(id, shift);
    }
}

}  // namespace votess::cpu

#include "cpu/cell_builder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/box.hpp"
#include "core/progress.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t first_window = 160;        // seeds loaded around a group at once
constexpr std::size_t max_window = 768;          // beyond this the far search is cheaper
constexpr std::size_t max_tests_by_reach = 512;  // of images; then each is tested against the vertices themselves
constexpr double far_vertex = 0x1p20;            // times the squared distance of a box
constexpr std::size_t tests_of_owner = 16;       // of boxes; a seed that owns a place nearly is good enough
constexpr std::size_t tests_of_unowned = 1024;   // while none is found
constexpr int owners_of_hidden = 24;             // that clip a cell before it counts as not empty
constexpr int known_owners_of_hidden = 64;       // the same for owners that are found without a search
constexpr std::size_t kept_owners = 32;
constexpr double first_band = 0.8;            // of the squared reach expected
constexpr double smallest_band = 0.01;        // of the squared distance that the window covers
constexpr double band_growth = 1.6;           // of the squared distance from band to band
constexpr std::size_t enough_for_walls = 12;  // planes, of which six bound the domain
constexpr std::size_t max_idle = 24;          // seeds in a row that do not cut a cell that reaches far beyond them
constexpr double far_beyond = 16;             // times the squared distance
constexpr int cuts_in_a_row = 16, large_cell = 512;  // slots; see clip_far()
constexpr int slots_per_cut = 16;                    // after so many cuts of a cell its ball is found again
constexpr std::size_t slots_of_test = 64;            // a larger cell counts as several tests
// Covers the rounding of squared distances and of 4 R^2 (a few units in 2^53 each).
constexpr double distance_slack = 1 + 1e-12;
constexpr double coordinate_rounding = 0x1p-50;  // of differences of rounded places
constexpr std::size_t vertices_per_check = std::size_t{1} << 14;

bool farther(const QueueEntry& a, const QueueEntry& b) {
    return a.distance_squared > b.distance_squared;
}

bool farther_images(const FarEntry& a, const FarEntry& b) {
    return a.distance_squared > b.distance_squared;
}

// Returns a lower bound of the squared distance between any point of a and any of b.
double box_distance(const Box& a, const Box& b) {
    return distance_squared(a, b) * (1 - 1e-14);
}

// Visits the children of a node, or the root for a level above the top.
template <class Visit>
void for_each_child(const Hierarchy& hierarchy, const QueueEntry& entry, Visit visit) {
    const int level = entry.level - 1;
    const std::size_t begin = entry.node * Hierarchy::fan;
    const std::size_t end = std::min(begin + Hierarchy::fan, hierarchy.count(level));
    for (std::size_t node = begin; node < end; ++node) visit(level, node, hierarchy.box(level, node));
}

// Returns the least power |x - q|^2 - w that the bound of a box's weights allows, rounded.
double least_power(const Hierarchy& hierarchy, const Lift& lift, int level, std::size_t node, const Box& box,
                   const exact::Point& x) {
    if (!hierarchy.has_weights()) return box_distance(box, {x, x});
    if (lift.exists()) {
        double power = -hierarchy.largest_rest(level, node);
        for (std::size_t k = 0; k < 3; ++k) {
            const double c = lift.center[k], least = (x[k] - lift.curvature * c) / lift.shrink;
            const double q = std::clamp(least, box.lower[k], box.upper[k]);
            power += (q - x[k]) * (q - x[k]) - lift.curvature * (q - c) * (q - c);
        }
        return power;
    }
    const WeightBlock& bounds = hierarchy.weight_bounds(level, node / Hierarchy::fan);
    const std::size_t i = node % Hierarchy::fan;
    double power = -bounds.top[i];
    for (std::size_t k = 0; k < 3; ++k) {
        const double slope = bounds.slope[k][i], center = 0.5 * (box.lower[k] + box.upper[k]);
        const double q = std::clamp(x[k] + 0.5 * slope, box.lower[k], box.upper[k]);
        power += (q - x[k]) * (q - x[k]) - slope * (q - center);
    }
    return power;
}

// Vertices of a cell, or of what it was some cuts ago.
class Corners {
public:
    void take(const Cell& cell) {
        for (auto& axis : x_) axis.clear();
        error_ = 0;
        for (int slot = 0; slot < cell.slots(); ++slot) {
            if (!cell.alive(slot)) continue;
            const auto at = cell.position(slot);
            for (std::size_t k = 0; k < 3; ++k) x_[k].push_back(at[k]);
            error_ = std::max(error_, cell.tolerance(slot));
        }
        largest_ = {};
        for (std::size_t k = 0; k < 3; ++k)
            for (const double x : x_[k]) largest_[k] = std::max(largest_[k], std::abs(x));
    }
    // Returns false only if |n|^2 - 2 n.X > more for all n in a box and all vertices X, moved. Along each axis that is
    // least at n = X or at an end of the box; see Cell::may_cut().
    [[nodiscard]] bool may_lose(const Box& box, double more, const exact::Point& move) const {
        constexpr double rounding = 0x1p-46;
        double limit = more + rounding * std::abs(more) + std::numeric_limits<double>::min();
        for (std::size_t k = 0; k < 3; ++k) {
            const double far = std::max(std::abs(box.lower[k]), std::abs(box.upper[k]));
            limit += far * (2 * error_ * (1 + rounding) + rounding * (far + largest_[k] + std::abs(move[k])));
        }
        const std::size_t count = x_[0].size();
        const double *x = x_[0].data(), *y = x_[1].data(), *z = x_[2].data();
        const auto least = [&](double at, std::size_t k) {
            const double n = std::min(std::max(at, box.lower[k]), box.upper[k]);
            return n * (n - 2 * at);
        };
        double nearest = infinity;
        bool sure = true;  // false with NaN
        for (std::size_t i = 0; i < count; ++i) {
            const double sum = least(x[i] + move[0], 0) + least(y[i] + move[1], 1) + least(z[i] + move[2], 2);
            nearest = std::min(nearest, sum);
            sure &= sum == sum;
        }
        return !(sure && nearest > limit);
    }

private:
    std::array<std::vector<double>, 3> x_;
    double error_ = 0;
    exact::Point largest_{};
};

}  // namespace

CellBuilder::CellBuilder(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels)
    : kernels_(kernels), seeds_(seeds), hierarchy_(hierarchy), cell_(kernels) {}

void CellBuilder::begin_job(const Domain& domain) {
    domain_ = &domain;
    lattice_reach_ = LatticeReach(domain);
    plain_ = !domain.is_periodic() && !domain.has_weights();
    rounding_ = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        place_rounding_[k] = seeds_.images == nullptr ? 0 : coordinate_rounding * seeds_.images->largest_rounded()[k];
        rounding_ = std::max(rounding_, place_rounding_[k]);
    }
    more_weight_ = 0;
    heaviest_ = -1;
    own_images_.clear();
    forget_owners();
    // Not by the hierarchy: cells that are clipped from lists have none.
    if (domain.is_periodic() && !seeds_.weights.empty())
        heaviest_ = static_cast<std::int32_t>(std::ranges::max_element(seeds_.weights) - seeds_.weights.begin());
    group_ = ~std::size_t{0};
    reach_ = 0;
}

void CellBuilder::set_seed(std::size_t seed) {
    own_ = static_cast<std::int32_t>(seed);
    probing_ = false;
    guards_ = {};
    coincident_ = -1;
    at_ = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    base_ = seeds_.images == nullptr ? SeedImages::Base{at_, {}} : seeds_.images->base(seed);
    weight_ = seeds_.weights.empty() ? 0 : seeds_.weights[seed];
}

void CellBuilder::start() {
    if (!seeds_.weights.empty()) more_weight_ = std::max(0.0, domain_->max_heavier_by(weight_));
    if (const Lift& lift = seeds_.lift; lift.exists()) {
        view_ = {lift.move(at_), lift.shrink};
        rest_ = lift.min_rest(at_, weight_);
        more_rest_ = std::max(0.0, hierarchy_.largest_rest(hierarchy_.top_level(), 0) - rest_);
    }
    cell_.start_without_walls(base_.point, *domain_, own_);
    walls_postponed_ = !domain_->walls.empty();
    if (domain_->wall_tree.size() == 0) clip_walls();
    clipped_by_owner_ = false;
    vertex_owners_.clear();
    if (heaviest_ >= 0) clip_by_heaviest();
    if (probing_ && domain_->is_periodic()) clip_by_own_images();
    auto id = static_cast<std::int32_t>(seeds_.places());
    for (const exact::Plane& guard : guards_) cell_.clip(++id, guard, guard.shift);
}

void CellBuilder::clip_walls(const std::function<void()>& crowded) {
    if (std::exchange(walls_postponed_, false)) cell_.clip_walls(*domain_, crowded);
}

void CellBuilder::clip_walls_among_seeds() {
    clip_walls([this] { clip_by_owners_of_vertices(); });
}

void CellBuilder::clip_by_owners_of_vertices() {
    vertices_.clear();
    for (int slot = 0; slot < cell_.slots(); ++slot)
        if (cell_.alive(slot)) vertices_.push_back(cell_.position(slot));
    const std::size_t tests = tests_;  // those of owners do not count
    for (const auto& x : vertices_) {
        if (known_owner_of(x, vertex_owners_) >= 0) continue;
        const std::int32_t owner = owner_of(x);
        if (owner < 0) continue;
        clipped_by_owner_ = true;
        const bool cuts = clip_by(owner, seeds_.x[owner], seeds_.y[owner], seeds_.z[owner]);
        if (cuts && cell_.empty()) break;
        vertex_owners_.push_back(owner);
    }
    tests_ = tests;
}

// For probes. A seed's own images are among the other images.
void CellBuilder::clip_by_own_images() {
    if (own_images_.empty()) own_images_ = near_translations(*domain_);
    for (const exact::Shift& shift : own_images_) {
        const exact::Point by = domain_->translation(shift);
        if (by[0] * by[0] + by[1] * by[1] + by[2] * by[2] >= reach_squared()) return;
        if (cell_.has_plane(own_, shift)) continue;
        cell_.clip(own_, exact::Plane::bisector(base_.point, shift, domain_->lattice), shift);
    }
}

// The heaviest seed has an image near any place. It buries much lighter seeds, and after it no weight can reach a cell
// from far away.
void CellBuilder::clip_by_heaviest() {
    if (heaviest_ == own_) return;
    const auto i = static_cast<std::size_t>(heaviest_);
    const auto f = domain_->reduced.fraction({at_[0] - seeds_.x[i], at_[1] - seeds_.y[i], at_[2] - seeds_.z[i]});
    ShiftRange nearest;
    for (std::size_t j = 0; j < 3; ++j)
        if (domain_->periodic[j]) nearest.lower[j] = static_cast<std::int32_t>(std::round(f[j]));
    clip_by_image(heaviest_, only_shift(*domain_, nearest));
}

std::int32_t CellBuilder::owner_of(const std::array<double, 3>& x) {
    const exact::Point at{at_[0] + x[0], at_[1] + x[1], at_[2] + x[2]};
    std::int32_t owner = -1;
    double least = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] - weight_;
    owner_queue_.assign(1, {-infinity, hierarchy_.top_level(), 0});
    const std::size_t first = tests_;
    while (!owner_queue_.empty() && owner_queue_.front().distance_squared < least &&
           tests_ - first < (owner < 0 ? max_unowned_ : tests_of_owner)) {
        std::pop_heap(owner_queue_.begin(), owner_queue_.end(), farther);
        const QueueEntry entry = owner_queue_.back();
        owner_queue_.pop_back();
        ++tests_;
        if (entry.level > 0) {
            for_each_child(hierarchy_, entry, [&](int level, std::size_t node, const Box& box) {
                const double power = least_power(hierarchy_, seeds_.lift, level, node, box, at);
                if (!(power < least)) return;
                owner_queue_.push_back({power, level, static_cast<std::uint32_t>(node)});
                std::push_heap(owner_queue_.begin(), owner_queue_.end(), farther);
            });
            continue;
        }
        const std::size_t begin = entry.node * group_size, end = seeds_.group_end(begin);
        for (std::size_t i = begin; i < end; ++i) {
            const double d[3] = {seeds_.x[i] - at[0], seeds_.y[i] - at[1], seeds_.z[i] - at[2]};
            const auto id = static_cast<std::int32_t>(i);
            const double weight = seeds_.weights.empty() ? 0 : seeds_.weights[i];
            const double power = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - weight;
            if (!(power < least) || id == own_ || id == coincident_) continue;
            least = power;
            owner = id;
        }
    }
    return owner;
}

std::int32_t CellBuilder::known_owner_of(const std::array<double, 3>& x, std::span<const std::int32_t> owners) const {
    std::int32_t owner = -1;
    double least = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] - weight_;
    for (const std::int32_t id : owners) {
        const auto i = static_cast<std::size_t>(id);
        const double d[3] = {seeds_.x[i] - at_[0] - x[0], seeds_.y[i] - at_[1] - x[1], seeds_.z[i] - at_[2] - x[2]};
        const double power = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - (seeds_.weights.empty() ? 0 : seeds_.weights[i]);
        if (!(power < least) || id == own_ || id == coincident_) continue;
        least = power;
        owner = id;
    }
    return owner;
}

void CellBuilder::remember_owner(std::int32_t owner) {
    if (std::ranges::find(owners_, owner) != owners_.end()) return;
    if (owners_.size() < kept_owners) return owners_.push_back(owner);
    owners_[next_owner_++ % kept_owners] = owner;
}

std::array<double, 3> CellBuilder::way_into_domain() const {
    const bool lifted = seeds_.lift.exists();
    if (domain_->triclinic || (!domain_->walls.empty() && !lifted)) return cell_.middle();
    std::array<double, 3> way{};
    for (std::size_t k = 0; k < 3; ++k) {
        if (domain_->periodic[k]) continue;
        const double aim = lifted ? at_[k] - view_.move[k] : at_[k];
        way[k] = std::clamp(aim, domain_->box.lower[k], domain_->box.upper[k]) - at_[k];
    }
    return way;
}

void CellBuilder::clip_if_hidden(bool beyond) {
    if (cell_.empty()) return;
    std::array<double, 3> x = beyond || seeds_.lift.exists() ? way_into_domain() : std::array<double, 3>{};
    // The nearest seeds clip a cell that begins among them.
    if (seeds_.weights.empty() && x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < covered_) return;
    int known = 0;
    for (int owners = 0; owners < owners_of_hidden;) {
        std::int32_t owner = known < known_owners_of_hidden ? known_owner_of(x, owners_) : -1;
        const bool searched = owner < 0;
        if (searched) {
            owner = owner_of(x);
            if (owner < 0) break;
            remember_owner(owner);
            ++owners;
        } else {
            ++known;
        }
        clipped_by_owner_ = true;
        if (clip_by(owner, seeds_.x[owner], seeds_.y[owner], seeds_.z[owner])) {
            if (cell_.empty()) return;
            x = cell_.middle();
        } else if (searched) {
            break;  // rounding hides who owns the middle
        } else {
            known = known_owners_of_hidden;
        }
    }
    cell_.drop_if_flat();
}

void CellBuilder::poll_stop() {
    tested_vertices_ += static_cast<std::size_t>(cell_.slots());
    if (tested_vertices_ < vertices_per_check) return;
    tested_vertices_ = 0;
    check_stop();
}

bool CellBuilder::clip_by(std::int32_t id, double x, double y, double z) {
    poll_stop();
    if (plain_ && id != coincident_)
        return std::ranges::find(vertex_owners_, id) == vertex_owners_.end() && cell_.clip(id, {x, y, z});
    if (seeds_.images == nullptr) return clip_by_image(id, {});
    return clip_by_image(seeds_.images->home(id), seeds_.images->shift(id));
}

bool CellBuilder::clip_by_image(std::int32_t home, const exact::Shift& shift) {
    poll_stop();
    const auto i = static_cast<std::size_t>(home);
    // Their nearest images are clipped at the start.
    if ((home == own_ || home == heaviest_ || clipped_by_owner_) && cell_.has_plane(home, shift)) return false;
    exact::Plane plane = bisector(home, shift);
    if (home == coincident_ && coincides(plane)) return false;
    if (!seeds_.weights.empty()) plane.power = exact::two_sum(weight_, -seeds_.weights[i]);
    return cell_.clip(home, plane, shift);
}

bool CellBuilder::coincides(const exact::Plane& bisector) const {
    const auto d = exact::differences(base_.point, bisector).x;
    return std::ranges::all_of(d, [](const exact::DoubleDouble& x) { return x.high == 0 && x.low == 0; });
}

exact::Plane CellBuilder::bisector(std::int32_t home, const exact::Shift& shift) const {
    const auto i = static_cast<std::size_t>(home);
    return seeds_.images == nullptr ? exact::Plane::bisector({seeds_.x[i], seeds_.y[i], seeds_.z[i]})
                                    : seeds_.images->bisector(base_, home, shift);
}

// Returns the seed at the place of the probe, or -1.
std::int32_t CellBuilder::find_coincident() {
    const Box here{at_, at_};
    const double near = 4 * rounding_ * rounding_;
    far_queue_.assign(1, {0, hierarchy_.top_level(), 0});
    while (!far_queue_.empty()) {
        const QueueEntry entry = far_queue_.back();
        far_queue_.pop_back();
        if (entry.level > 0) {
            for_each_child(hierarchy_, entry, [&](int level, std::size_t node, const Box& box) {
                if (box_distance(box, here) <= near) far_queue_.push_back({0, level, static_cast<std::uint32_t>(node)});
            });
            continue;
        }
        const std::size_t begin = entry.node * group_size, end = seeds_.group_end(begin);
        for (std::size_t i = begin; i < end; ++i) {
            const auto id = static_cast<std::int32_t>(i);
            const double d[3] = {seeds_.x[i] - at_[0], seeds_.y[i] - at_[1], seeds_.z[i] - at_[2]};
            if (!(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= near)) continue;
            const std::int32_t home = seeds_.images == nullptr ? id : seeds_.images->home(id);
            const exact::Shift shift = seeds_.images == nullptr ? exact::Shift{} : seeds_.images->shift(id);
            if (coincides(bisector(home, shift))) return home;
        }
    }
    return -1;
}

// A seed of weight w cuts the cell of weight w_p only if it is nearer than R + sqrt(R^2 + w - w_p), where R is the
// distance to the farthest vertex.
double CellBuilder::reach_squared() {
    if (cell_.empty()) return 0;
    if (seeds_.lift.exists()) {
        const double reach = cell_.lifted_reach(view_, more_rest_) * distance_slack;
        return reach * reach;
    }
    const double square = cell_.radius_squared();
    if (plain_) return 4 * square * distance_slack;
    const double reach = (std::sqrt(square) + std::sqrt(square + more_weight_)) * distance_slack + rounding_;
    return reach * reach;
}

double CellBuilder::equal_reach_squared() {
    if (!seeds_.lift.exists()) return 4 * cell_.radius_squared();
    const double reach = cell_.lifted_reach(view_, 0);
    return reach * reach;
}

bool CellBuilder::node_may_cut(const QueueEntry& entry) {
    const Box seen = seen_from(at_, hierarchy_.box(entry.level, entry.node), place_rounding_);
    if (seeds_.lift.exists())
        return cell_.may_cut(seen, std::min(more_rest_, hierarchy_.largest_rest(entry.level, entry.node) - rest_),
                             view_);
    const double more = seeds_.weights.empty()
                            ? 0
                            : std::min(more_weight_, hierarchy_.largest_weight(entry.level, entry.node) - weight_);
    return may_cut(seen, more);
}

// Rounding of a far vertex hides whether a near box lies in its ball.
bool CellBuilder::may_cut(const Box& seen, double more) {
    if (!cell_.in_reach(seen, more)) return false;
    double farthest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double x = std::max(std::abs(seen.lower[k]), std::abs(seen.upper[k]));
        farthest += x * x;
    }
    return cell_.radius_squared() < far_vertex * farthest || cell_.may_cut(seen, more);
}

void CellBuilder::open_window(const Box& home) {
    home_ = home;
    queue_.assign(1, {0, hierarchy_.top_level(), 0});
    covered_ = 0;
    for (auto* v : {&x_, &y_, &z_}) v->clear();
    index_.clear();
    // Groups that overlap the home box are at distance 0. Continue until the window proves anything.
    for (std::size_t least = first_window; least <= max_window; least *= 2) {
        extend_window(0, least);
        if (covered_ > 0) break;
    }
    // The last cell is a neighbor in space and has about this size, but density may jump.
    reach_ = std::clamp(reach_, covered_, 8 * covered_);
}

void CellBuilder::open_window_of(std::size_t seed) {
    if (seed / group_size == group_) return;
    group_ = seed / group_size;
    open_window(hierarchy_.box(0, group_));
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

void CellBuilder::extend_window(double distance_squared, std::size_t min_count) {
    while (!queue_.empty() && index_.size() < max_window &&
           (queue_.front().distance_squared < distance_squared || index_.size() < min_count))
        pop_into_window();
    covered_ = queue_.empty() ? infinity : queue_.front().distance_squared;
}

// Hidden seeds of a power diagram need no window.
Cell* CellBuilder::build(std::size_t seed, std::size_t max_tests) {
    if (max_tests > 0 && seeds_.weights.empty()) open_window_of(seed);
    set_seed(seed);
    return search(max_tests);
}

Cell* CellBuilder::build_if_hidden(std::size_t seed) {
    set_seed(seed);
    tests_ = 0;
    max_unowned_ = tests_of_owner;
    start();
    clip_if_hidden(false);
    return cell_.empty() ? &cell_ : nullptr;
}

Cell& CellBuilder::build(std::size_t seed, std::span<const exact::Plane> guards) {
    open_window_of(seed);
    set_seed(seed);
    guards_ = guards;
    return *search(std::numeric_limits<std::size_t>::max());
}

Cell& CellBuilder::build(const Probe& probe) {
    own_ = static_cast<std::int32_t>(seeds_.places());
    probing_ = true;
    guards_ = {};
    coincident_ = -1;
    at_ = probe.place.at;
    base_ = {probe.x, probe.place.shift};
    weight_ = probe.weight;
    for (std::size_t k = 0; k < 3; ++k) {
        if (place_rounding_[k] == 0 && probe.place.low[k] == 0) continue;
        place_rounding_[k] = std::max(place_rounding_[k], coordinate_rounding * std::abs(at_[k]));
        rounding_ = std::max(rounding_, place_rounding_[k]);
    }
    if (seeds_.size() == 0) {
        start();
        clip_walls();
        return cell_;
    }
    coincident_ = find_coincident();
    group_ = ~std::size_t{0};
    open_window({at_, at_});
    return *search(std::numeric_limits<std::size_t>::max());
}

Cell* CellBuilder::search(std::size_t max_tests) {
    tests_ = 0;
    max_tests_ = max_tests;
    max_unowned_ = tests_of_unowned;
    if (max_tests == 0) return nullptr;
    start();
    const bool beyond = !probing_ && seeds_.is_beyond(static_cast<std::size_t>(own_));
    if (!seeds_.weights.empty() || beyond) clip_if_hidden(beyond);
    if (!cell_.empty() && !probing_) open_window_of(static_cast<std::size_t>(own_));
    const double from = cell_.empty() ? infinity : clip_window();
    clip_walls_among_seeds();
    if (from < infinity) clip_far(from, false);
    if (seeds_.images != nullptr) clip_far_images();
    if (exhausted()) return nullptr;
    if (!cell_.empty()) reach_ = equal_reach_squared() * distance_slack;
    return &cell_;
}

double CellBuilder::clip_window() {
    measured_ = 0;
    std::size_t idle = 0;
    double from = 0;
    // The cell before may have been far smaller.
    double to = first_band * (covered_ < infinity ? std::max(reach_, smallest_band * covered_) : reach_);
    for (;;) {
        if (to > covered_) {
            extend_window(to, 0);
            to = std::min(to, covered_);
        }
        if (to <= from && covered_ < infinity) return from;
        from = clip_band(from, to, idle);
        // Many walls all cut a cell that few seeds have cut.
        if (cell_.planes().size() >= enough_for_walls) clip_walls_among_seeds();
        if (from < to || from == infinity) return from;
        // Only a few seeds can be so heavy that they cut from beyond this. The weights of boxes lead to them.
        const double reach_of_most = equal_reach_squared();
        if (!seeds_.weights.empty() && from >= reach_of_most && reach_squared() > 4 * reach_of_most) return from;
        to = covered_ == infinity ? infinity : std::min(to * band_growth, reach_squared());
    }
}

Cell& CellBuilder::build_from(std::size_t seed, std::span<const std::int32_t> candidates) {
    set_seed(seed);
    return build_from(candidates);
}

Cell& CellBuilder::build_from(std::span<const std::int32_t> candidates) {
    start();
    candidates_.clear();
    for (const std::int32_t i : candidates) {
        const double d[3] = {seeds_.x[i] - at_[0], seeds_.y[i] - at_[1], seeds_.z[i] - at_[2]};
        candidates_.emplace_back(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], i);
    }
    std::sort(candidates_.begin(), candidates_.end());
    for (const auto& [distance, i] : candidates_) {
        if (distance >= reach_squared()) break;
        clip_by(i, seeds_.x[i], seeds_.y[i], seeds_.z[i]);
    }
    clip_walls();
    return cell_;
}

Cell& CellBuilder::build_from(std::size_t seed, std::span<const std::int32_t> candidates,
                              std::span<const exact::Shift> shifts, std::span<const exact::Plane> guards) {
    set_seed(seed);
    guards_ = guards;
    start();
    for (std::size_t k = 0; k < candidates.size(); ++k) clip_by_image(candidates[k], shifts[k]);
    clip_walls();
    return cell_;
}

Cell& CellBuilder::build_hidden(std::size_t seed) {
    set_seed(seed);
    start();
    exact::Plane plane = bisector(own_, {});
    plane.power = {-1, 0};  // a heavier seed at the same place
    cell_.clip(own_, plane);
    return cell_;
}

Cell& CellBuilder::build_among_images(std::size_t seed, std::span<const std::int32_t> candidates) {
    set_seed(seed);
    tests_ = 0;
    max_tests_ = std::numeric_limits<std::size_t>::max();
    start();
    for (const std::int32_t i : candidates) clip_by(i, seeds_.x[i], seeds_.y[i], seeds_.z[i]);
    clip_walls();
    if (cell_.empty()) return cell_;
    clip_far(0, true);
    clip_far_images();
    return cell_;
}

Cell& CellBuilder::build_among_images(std::size_t seed, std::span<const std::int32_t> candidates,
                                      const Unwrapped& unwrapped) {
    set_seed(seed);
    tests_ = 0;
    max_tests_ = std::numeric_limits<std::size_t>::max();
    start();
    for (const std::int32_t i : candidates) clip_far_image(i, {}, {seeds_, hierarchy_, {}, {}, 0, &unwrapped});
    clip_walls();
    if (!cell_.empty()) clip_images_of(unwrapped);
    return cell_;
}

Cell& CellBuilder::rebuild(CellFaces& faces) {
    cell_.canonical_faces(faces);
    if (!plain_ || cell_.empty() || !seeds_.beyond.empty()) return rebuild_by_planes(faces);
    neighbors_.clear();
    for (const std::int32_t p : faces.planes)
        if (const std::int32_t id = cell_.planes()[p].id; id >= 0) neighbors_.push_back(id);
    return build_from(neighbors_);
}

Cell& CellBuilder::rebuild_by_planes(const CellFaces& faces) {
    planes_.clear();
    for (const std::int32_t p : faces.planes)
        if (const CellPlane& plane = cell_.planes()[p]; plane.source.is_bisector()) planes_.push_back(plane);
    // A cell without volume has lost faces that bound it.
    constexpr std::size_t min_faces = 4;
    if (cell_.empty() || faces.size() < min_faces) return cell_;
    std::ranges::sort(planes_, [](const CellPlane& a, const CellPlane& b) {
        return std::tie(a.norm, a.id, a.shift) < std::tie(b.norm, b.id, b.shift);
    });
    start();
    for (const CellPlane& plane : planes_) {
        poll_stop();
        if (!cell_.has_plane(plane.id, plane.shift)) cell_.clip(plane.id, plane.source, plane.shift);
    }
    clip_walls();
    return cell_;
}

double CellBuilder::clip_band(double from, double to, std::size_t& idle) {
    const std::size_t count = index_.size();
    if (measured_ < count) {
        distance_.resize(count);
        kernels_.squared_distances(x_.data() + measured_, y_.data() + measured_, z_.data() + measured_,
                                   static_cast<int>(count - measured_), at_.data(), distance_.data() + measured_);
        // The home group enters the window first, but equal distances may put another before it.
        for (std::size_t i = measured_; i < count; ++i)
            if (index_[i] == own_) distance_[i] = infinity;
        measured_ = count;
    }
    band_.resize(count + lanes);
    const int selected = kernels_.select_band(distance_.data(), static_cast<int>(count), from, to, band_.data());
    std::sort(band_.begin(), band_.begin() + selected);
    for (int k = 0; k < selected; ++k) {
        const std::uint64_t key = band_[k];
        const double at_least = std::bit_cast<double>(key & key_distance_bits);
        const double reach = reach_squared();
        if (at_least >= reach || ++tests_ > max_tests_) return infinity;
        if (idle >= max_idle && far_beyond * at_least < reach) return at_least;
        const auto i = static_cast<std::uint32_t>(key);
        idle = clip_by(index_[i], x_[i], y_[i], z_[i]) ? 0 : idle + 1;
    }
    return to < reach_squared() ? to : infinity;
}

void CellBuilder::clip_far(double from, bool images_only) {
    if (!seeds_.weights.empty() && !seeds_.lift.exists()) return clip_by_power(from, images_only);
    const Box here{at_, at_};
    const std::size_t homes = images_only ? round_up(seeds_.size(), group_size) : 0;
    // A test of a large cell against a box takes longer than a cut. While most seeds cut it, they are not tested.
    int in_a_row = 0;
    const auto worth_a_test = [&] { return in_a_row < cuts_in_a_row || cell_.slots() < large_cell; };
    far_queue_.assign(1, {0, hierarchy_.top_level(), 0});
    while (!far_queue_.empty()) {
        std::pop_heap(far_queue_.begin(), far_queue_.end(), farther);
        const QueueEntry entry = far_queue_.back();
        far_queue_.pop_back();
        if (entry.distance_squared >= reach_squared()) return;
        // Vertices of a periodic domain have the last digits of the way in which a cell is found.
        tests_ += seeds_.images != nullptr ? 1 : 1 + static_cast<std::size_t>(cell_.slots()) / slots_of_test;
        if (tests_ > max_tests_) return;
        poll_stop();
        if (worth_a_test() && !node_may_cut(entry)) continue;
        if (entry.level > 0) {
            for_each_child(hierarchy_, entry, [&](int level, std::size_t node, const Box& box) {
                if (Hierarchy::first_seed(level, node + 1) <= homes) return;
                far_queue_.push_back({box_distance(box, here), level, static_cast<std::uint32_t>(node)});
                std::push_heap(far_queue_.begin(), far_queue_.end(), farther);
            });
            continue;
        }
        const std::size_t begin = entry.node * group_size, end = seeds_.group_end(begin);
        double distance[group_size];
        kernels_.squared_distances(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], static_cast<int>(end - begin),
                                   at_.data(), distance);
        for (std::size_t i = begin; i < end; ++i) {
            if (distance[i - begin] < from || static_cast<std::int32_t>(i) == own_) continue;
            const exact::Point x{seeds_.x[i], seeds_.y[i], seeds_.z[i]};
            const double excess = seeds_.weights.empty() ? 0 : seeds_.weights[i] - weight_;
            if (!seeds_.lift.exists() && worth_a_test() && !may_cut(seen_from(at_, {x, x}, place_rounding_), excess))
                continue;
            const bool cuts = clip_by(static_cast<std::int32_t>(i), x[0], x[1], x[2]);
            in_a_row = cuts ? in_a_row + 1 : 0;
            ++tests_;
        }
    }
}

void CellBuilder::enclose() {
    cuts_ = 0;
    center_ = cell_.middle();
    radius_ = 0;
    for (int slot = 0; slot < cell_.slots(); ++slot) {
        if (!cell_.alive(slot)) continue;
        const auto x = cell_.position(slot);
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) square += (x[k] - center_[k]) * (x[k] - center_[k]);
        radius_ = std::max(radius_, std::sqrt(square) * distance_slack + 2 * cell_.tolerance(slot));
    }
}

// A seed p + n of a node weighs at most w_p + more + 2 n.move, so it cuts off v only if |n|^2 - 2 n.(v + move) < more.
CellBuilder::WeightBound CellBuilder::weight_bound(int level, std::size_t node, const Box& box) const {
    const WeightBlock& bounds = hierarchy_.weight_bounds(level, node / Hierarchy::fan);
    const std::size_t i = node % Hierarchy::fan;
    WeightBound out{bounds.top[i] - weight_, {}};
    double size = std::abs(bounds.top[i]) + std::abs(weight_), rounding = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double slope = bounds.slope[k][i], center = 0.5 * (box.lower[k] + box.upper[k]);
        out.view.move[k] = 0.5 * slope;
        out.more += slope * (at_[k] - center);
        size += std::abs(slope) * (std::abs(at_[k]) + std::abs(center));
        rounding += std::abs(slope) * place_rounding_[k];
    }
    out.more += 0x1p-48 * size + 4 * rounding;
    return out;
}

// A ball around the cell stands for its vertices. gain: set to a lower bound of |n|^2 - 2 n.(center + move) - more.
bool CellBuilder::ball_may_lose(const Box& seen, const WeightBound& bound, double& gain) const {
    double sum = 0, size = std::abs(bound.more), far2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double x = center_[k] + bound.view.move[k];
        const double q = std::clamp(x, seen.lower[k], seen.upper[k]), term = q * (q - 2 * x);
        const double far = std::max(std::abs(seen.lower[k]), std::abs(seen.upper[k]));
        sum += term;
        size += std::abs(term) + q * q + far * std::abs(bound.view.move[k]);
        far2 += far * far;
    }
    gain = sum - bound.more;
    return !(gain > 2 * radius_ * std::sqrt(far2) * distance_slack + 0x1p-47 * size);
}

void CellBuilder::clip_by_power(double from, bool images_only) {
    const std::size_t homes = round_up(seeds_.size(), group_size);
    const auto push = [&](int level, std::size_t node, const Box& box) {
        if (images_only && Hierarchy::first_seed(level, node + 1) <= homes) return;
        double gain = 0;
        if (ball_may_lose(seen_from(at_, box, place_rounding_), weight_bound(level, node, box), gain)) {
            far_queue_.push_back({gain, level, static_cast<std::uint32_t>(node)});
            std::push_heap(far_queue_.begin(), far_queue_.end(), farther);
        }
    };
    far_queue_.clear();
    enclose();
    Corners corners;
    corners.take(cell_);
    // Needles that are far longer than a box is away are known well across only.
    const auto may_lose = [&](const Box& seen, const WeightBound& bound) {
        if (!corners.may_lose(seen, bound.more, bound.view.move)) return false;
        double far2 = 0;
        for (std::size_t k = 0; k < 3; ++k)
            far2 += std::max(seen.lower[k] * seen.lower[k], seen.upper[k] * seen.upper[k]);
        return cell_.radius_squared() < far_vertex * far2 || cell_.may_cut(seen, bound.more, bound.view);
    };
    const int top = hierarchy_.top_level();
    push(top, 0, hierarchy_.box(top, 0));
    while (!far_queue_.empty()) {
        std::pop_heap(far_queue_.begin(), far_queue_.end(), farther);
        const QueueEntry entry = far_queue_.back();
        far_queue_.pop_back();
        if (++tests_ > max_tests_) return;
        poll_stop();
        const Box box = hierarchy_.box(entry.level, entry.node), seen = seen_from(at_, box, place_rounding_);
        const WeightBound bound = weight_bound(entry.level, entry.node, box);
        double gain = 0;
        if (!ball_may_lose(seen, bound, gain) || !may_lose(seen, bound)) continue;
        if (entry.level > 0) {
            for_each_child(hierarchy_, entry, push);
            continue;
        }
        const std::size_t begin = entry.node * group_size, end = seeds_.group_end(begin);
        double distance[group_size];
        kernels_.squared_distances(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], static_cast<int>(end - begin),
                                   at_.data(), distance);
        for (std::size_t i = begin; i < end; ++i) {
            if (distance[i - begin] < from || static_cast<std::int32_t>(i) == own_) continue;
            const exact::Point x{seeds_.x[i], seeds_.y[i], seeds_.z[i]};
            const double rounding = 0x1p-50 * (std::abs(seeds_.weights[i]) + std::abs(weight_));
            const WeightBound own{seeds_.weights[i] - weight_ + rounding, {}};
            const Box there = seen_from(at_, {x, x}, place_rounding_);
            if (!ball_may_lose(there, own, gain) || !may_lose(there, own)) continue;
            ++tests_;
            if (!clip_by(static_cast<std::int32_t>(i), x[0], x[1], x[2])) continue;
            if (cell_.empty()) return;
            if (++cuts_ * slots_per_cut < cell_.slots()) continue;
            enclose();
            corners.take(cell_);
        }
    }
}

double CellBuilder::more_weight_of(const ImageNode& node) const {
    if (seeds_.weights.empty()) return 0;
    const double heaviest =
        node.level < 0 ? seeds_.weights[node.node] : hierarchy_.largest_weight(node.level, node.node);
    return std::min(more_weight_, heaviest - weight_);
}

void CellBuilder::push_far(const ImageNode& node, const Homes& homes) {
    const Box box = box_of(node, homes.seeds, homes.hierarchy);
    const Box images = seen_from({}, images_of(*domain_, box, node.shifts, homes.at), homes.rounding);
    const double distance_squared = box_distance(images, {});
    if (distance_squared >= reach_squared() || !lattice_reach_.may_touch(images)) return;
    if (homes.unwrapped == nullptr) {
        Box places = images;
        for (std::size_t k = 0; k < 3; ++k) places.lower[k] += at_[k], places.upper[k] += at_[k];
        if (seeds_.images->are_present(places)) return;  // clip_window() or clip_far() has tried them
    }
    far_images_.push_back({distance_squared, node, images});
    std::push_heap(far_images_.begin(), far_images_.end(), farther_images);
}

void CellBuilder::clip_far_image(std::int32_t home, const exact::Shift& shift, const Homes& homes) {
    const exact::Shift by = homes.unwrapped == nullptr ? shift : homes.unwrapped->shift_between(own_, home, shift);
    if (!cell_.has_plane(home, by)) clip_by_image(home, by);
}

void CellBuilder::clip_far_group(const FarEntry& entry, const Homes& homes, double from) {
    const exact::Shift shift = only_shift(*domain_, entry.at.shifts);
    const exact::Point by = domain_->translation(shift);
    const exact::Point moved{homes.at[0] - by[0], homes.at[1] - by[1], homes.at[2] - by[2]};
    const SortedSeeds& seeds = homes.seeds;
    const std::size_t begin = entry.at.node * group_size, end = std::min(seeds.group_end(begin), seeds.size());
    double distance[group_size];
    kernels_.squared_distances(&seeds.x[begin], &seeds.y[begin], &seeds.z[begin], static_cast<int>(end - begin),
                               moved.data(), distance);
    for (std::size_t i = begin; i < end; ++i) {
        if (distance[i - begin] < from) continue;
        clip_far_image(static_cast<std::int32_t>(i), shift, homes);
        ++tests_;
    }
}

void CellBuilder::clip_far_images() {
    const double known = std::max(0.0, seeds_.images->reach(at_) - rounding_);
    clip_far_images({seeds_, hierarchy_, at_, seeds_.images->rounding_of_seeds(), known});
}

void CellBuilder::clip_images_of(const Unwrapped& unwrapped) {
    const SortedSeeds& seeds = unwrapped.seeds;
    const auto own = static_cast<std::size_t>(own_);
    const exact::Point at{seeds.x[own], seeds.y[own], seeds.z[own]};
    clip_far_images({seeds, unwrapped.hierarchy, at, unwrapped.rounding, 0, &unwrapped});
}

void CellBuilder::clip_far_images(const Homes& homes) {
    const double known = homes.known;
    if (reach_squared() <= known * known) return;
    // Images that are certainly nearer have been tried. Bounds of images are rounded outward by more than coordinates.
    const double tried = std::max(0.0, known * (1 - 1e-9) - 64 * rounding_);
    const int top = homes.hierarchy.top_level();
    far_images_.clear();
    push_far({top, 0,
              shifts_around(*domain_, homes.hierarchy.box(top, 0), homes.at,
                            std::min(std::sqrt(reach_squared()), lattice_reach_.distance()))},
             homes);
    while (!far_images_.empty()) {
        std::pop_heap(far_images_.begin(), far_images_.end(), farther_images);
        const FarEntry entry = far_images_.back();
        far_images_.pop_back();
        const double reach = reach_squared();
        if (entry.distance_squared >= reach || reach <= known * known) return;
        if (++tests_ > max_tests_) return;
        poll_stop();
        const double more = more_weight_of(entry.at);
        if (!may_cut(entry.images, more)) continue;
        if (tests_ > max_tests_by_reach && !cell_.may_cut(entry.images, more)) continue;
        const bool single = entry.at.shifts.is_single();
        if (single && entry.at.shifts == ShiftRange{}) continue;  // the seeds themselves
        if (single && entry.at.level == 0) {
            clip_far_group(entry, homes, tried * tried);
            continue;
        }
        if (!entry.at.is_single()) {
            for_each_part(entry.at, *domain_, homes.seeds, homes.hierarchy,
                          [&](const ImageNode& part) { push_far(part, homes); });
            continue;
        }
        if (entry.distance_squared < tried * tried) continue;
        clip_far_image(static_cast<std::int32_t>(entry.at.node), only_shift(*domain_, entry.at.shifts), homes);
    }
}

}  // namespace votess::cpu

#include "query/ray_tracer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "index/seed_images.hpp"

namespace votess::cpu {
namespace {

constexpr double unit_roundoff = 0x1p-53;
constexpr double no_time = std::numeric_limits<double>::infinity();
constexpr double underflow = 1e-290;  // above the underflow of a product
constexpr std::int32_t farthest_shift = exact::max_shift / 2;
constexpr std::size_t steps_per_look = 1024;  // after which the user may stop

exact::Shift sum(const exact::Shift& a, const std::array<std::int8_t, 3>& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

RayTracer::Image follow(const RayTracer::Image& from, const CellGraph::Link& link) {
    return {static_cast<std::size_t>(link.seed), sum(from.shift, link.shift)};
}

void add_shift(const Domain& domain, const exact::Shift& shift, std::array<double, 3>& x) {
    for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k) x[k] += shift[j] * domain.vector[j][k];
}

double size_of(const std::array<double, 3>& x) {
    return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
}

}  // namespace

CellGraph::CellGraph(const Domain& domain, const SortedSeeds& seeds, const Tessellation& t) {
    std::vector<std::int32_t> sorted(t.size(), -1);
    for (std::size_t i = 0; i < seeds.size(); ++i)
        sorted[static_cast<std::size_t>(seeds.input[i])] = static_cast<std::int32_t>(i);
    const std::span<const std::int8_t> shifts = t.shifts();
    places_.resize_uninitialized(seeds.size());
    links_.resize_uninitialized(t.indices().size());
    std::size_t end = 0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        const auto input = static_cast<std::size_t>(seeds.input[i]);
        const exact::Point at = seeds.images == nullptr ? exact::Point{seeds.x[i], seeds.y[i], seeds.z[i]}
                                                        : seeds.images->place_in_domain(i);
        places_[i] = {at[0], at[1], at[2], seeds.weights.empty() ? 0 : seeds.weights[i], end, 0, 0, 0};
        max_weight_ = std::max(max_weight_, std::abs(places_[i].weight));
        size_ = std::max(size_, size_of(at));
        has_cell_.push_back(t.status()[input] == CellStatus::certified);
        if (has_cell_.back() && first_cell_ == none) first_cell_ = i;
        auto entry = static_cast<std::size_t>(t.indptr()[input]);
        for (const std::int32_t neighbor : t.neighbors(input)) {
            Link link{sorted[static_cast<std::size_t>(neighbor)], {}, false};
            for (std::size_t j = 0; j < 3 && !shifts.empty(); ++j) {
                link.shift[j] = shifts[3 * entry + j];
                max_shift_ = std::max(max_shift_, std::abs(int{link.shift[j]}));
                link.is_shifted = link.is_shifted || link.shift[j] != 0;
            }
            links_[end++] = link;
            ++entry;
        }
        places_[i].count = static_cast<std::uint32_t>(end - places_[i].begin) & 0x7fffffff;
        max_links_ = std::max(max_links_, end - places_[i].begin);
    }
    for (const auto& vector : domain.vector) period_ = std::max(period_, size_of(vector));
    for (Place& place : places_) {
        double reach = 0;
        for (std::size_t k = 0; k < place.count; ++k) {
            const Link& link = links_[place.begin + k];
            const Place& to = places_[static_cast<std::size_t>(link.seed)];
            Vector3 n{to.x - place.x, to.y - place.y, to.z - place.z};
            if (link.is_shifted) add_shift(domain, {link.shift[0], link.shift[1], link.shift[2]}, n);
            if (link.is_shifted) place.has_shifts = 1;
            reach = std::max(reach, std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]));
        }
        place.reach = static_cast<float>(reach * (1 + 0x1p-20)) + std::numeric_limits<float>::min();
    }
}

RayTracer::RayTracer(const Domain& domain, const SortedSeeds& seeds, const CellGraph& graph, bool has_box)
    : domain_(domain),
      seeds_(seeds),
      graph_(graph),
      walls_(domain.walls),
      slopes_(graph.max_links()),
      times_(graph.max_links()) {
    for (int wall = 0; wall < 6 && has_box; ++wall)
        if (domain.has_box_wall(wall)) walls_.push_back(domain.box_wall(wall));
    if (seeds.images == nullptr) return;
    if (seeds.images->any_wrapped()) place_error_ = 2 * unit_roundoff * graph.size();
    shift_error_ = 8 * unit_roundoff * (graph.size() + 3 * graph.max_shift() * graph.period());
}

exact::Plane RayTracer::plane_of(const Image& image) const {
    exact::Plane plane;
    if (seeds_.images == nullptr) {
        const CellGraph::Place& place = graph_.place(image.seed);
        plane = exact::Plane::bisector({place.x, place.y, place.z});
    } else {
        SeedImages::Base base = seeds_.images->base(image.seed);
        const exact::Shift moved =
            seeds_.images->shift_in_domain(static_cast<std::int32_t>(image.seed), exact::Shift{});
        for (std::size_t j = 0; j < 3; ++j) base.shift[j] += image.shift[j] - moved[j];
        plane = exact::Plane::bisector(base.point, base.shift, domain_.lattice);
    }
    if (!seeds_.weights.empty()) plane.power = {-seeds_.weights[image.seed], 0};
    return plane;
}

// Relative to the origin.
std::array<double, 3> RayTracer::position(const Image& image) const {
    const CellGraph::Place& place = graph_.place(image.seed);
    std::array<double, 3> x{place.x, place.y, place.z};
    if (image.shift != exact::Shift{}) add_shift(domain_, image.shift, x);
    return minus(x, ray_.origin);
}

std::array<double, 3> RayTracer::middle_of(const Piece& piece) const {
    const std::array<double, 3> p = position(piece.image);
    const double time = 0.5 * (piece.begin + piece.end);
    std::array<double, 3> middle;
    for (std::size_t k = 0; k < 3; ++k) middle[k] = time * ray_.direction[k] - p[k];
    return middle;
}

exact::Crossing RayTracer::exact_of(const Event& event) const {
    if (event.kind == exact::Crossing::Kind::time) return exact::Crossing::at(event.end);
    if (event.kind == exact::Crossing::Kind::wall) return exact::Crossing::through(*event.wall);
    return between(event.from, event.to);
}

bool RayTracer::later(const Event& a, const Event& b) const {
    if (a.least > b.most) return true;
    if (a.most < b.least) return false;
    return exact::later(ray_, exact_of(a), exact_of(b)) > 0;
}

// Fills the time and its bounds from integers.
void RayTracer::find_time(Event& event) const {
    set_time(event, 2 * exact::time_of(ray_, exact_of(event)));
}

// time: wrong by a few units in the last place.
void RayTracer::set_time(Event& event, double time) {
    event.time = time;
    const double error = 16 * unit_roundoff * std::abs(event.time) + underflow;
    event.least = event.time - error;
    event.most = event.time + error;
}

// Finds the earliest of the end and all walls. Returns false when that is never.
bool RayTracer::find_stop(double end) {
    stop_ = {};
    stop_.end = end;
    if (end == no_time)
        stop_.time = stop_.least = stop_.most = no_time;
    else
        find_time(stop_);
    for (const exact::Plane& wall : walls_) {
        Event event;
        event.kind = exact::Crossing::Kind::wall;
        event.wall = &wall;
        if (wall.is_oblique()) {
            if (exact::approach(ray_, exact_of(event)) <= 0) continue;
            find_time(event);
        } else {
            const auto axis = static_cast<std::size_t>(wall.axis);
            const double slope = ray_.direction[axis], way = wall.wall - ray_.origin[axis];
            if (wall.kind == exact::Plane::Kind::lower_wall ? slope >= 0 : slope <= 0) continue;
            set_time(event, way == 0 ? 0 : 2 * (way / slope));
        }
        if (stop_.time == no_time || later(stop_, event)) stop_ = event;
    }
    return stop_.time != no_time;
}

// Walks downhill to an image with a cell that holds the origin.
RayTracer::Image RayTracer::walk_to_origin(Image from) const {
    for (bool moved = true; moved;) {
        moved = false;
        check_stop();
        for (const CellGraph::Link& link : graph_.links(from.seed)) {
            const Image to = follow(from, link);
            if (exact::farther(ray_.origin, plane_of(from), plane_of(to)) <= 0) continue;
            from = to;
            moved = true;
            break;
        }
    }
    return from;
}

RayTracer::Errors RayTracer::errors_of(const CellGraph::Place& here, const std::array<double, 3>& p) const {
    const double delta = place_error_ + (here.has_shifts != 0 ? shift_error_ : 0), reach = here.reach + 3 * delta;
    const double middle = reach + 2 * (std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]));
    Errors errors;
    errors.rise =
        5 * error_ * (reach + 3 * delta) + 2 * delta * middle + 8 * unit_roundoff * graph_.max_weight() + underflow;
    errors.slope = 8 * unit_roundoff * reach + 4 * delta;
    errors.min_slope = std::max(64 * errors.slope, 0x1p-16 * reach);
    errors.constant = 1.1 * errors.rise / errors.min_slope;
    errors.relative = 1.1 * errors.slope / errors.min_slope + 4 * unit_roundoff;
    return errors;
}

// Finds where the ray leaves a cell. Returns false when it never does. Fills ties_ with neighbors of the same line.
bool RayTracer::find_next(const Image& from, Event& event) {
    const CellGraph::Place& here = graph_.place(from.seed);
    const std::array<double, 3> p = position(from);
    const Vector3 d = ray_.direction, twice{2 * p[0], 2 * p[1], 2 * p[2]};
    const std::span<const CellGraph::Link> links = graph_.links(from.seed);
    for (const CellGraph::Link& link : links) __builtin_prefetch(&graph_.place(static_cast<std::size_t>(link.seed)));
    const Errors errors = errors_of(here, p);
    double* const slopes = slopes_.data();
    double* const times = times_.data();
    double best = no_time;
    std::uint64_t any_grazes = 0;
    for (std::size_t i = 0; i < links.size(); ++i) {  // branches would be mispredicted
        const CellGraph::Link& link = links[i];
        const CellGraph::Place& place = graph_.place(static_cast<std::size_t>(link.seed));
        Vector3 n{place.x - here.x, place.y - here.y, place.z - here.z};
        if (link.is_shifted) add_shift(domain_, {link.shift[0], link.shift[1], link.shift[2]}, n);
        const double slope = dot(n, d);
        const double rise =
            dot(n, Vector3{n[0] + twice[0], n[1] + twice[1], n[2] + twice[2]}) - (place.weight - here.weight);
        const std::uint64_t approaches = slope > errors.min_slope;
        const auto bits = std::bit_cast<std::uint64_t>(rise / slope), other = std::bit_cast<std::uint64_t>(no_time);
        const auto time = std::bit_cast<double>(other ^ ((other ^ bits) & (0 - approaches)));
        any_grazes |= static_cast<std::uint64_t>(std::abs(slope) <= errors.min_slope);
        slopes[i] = slope;
        times[i] = time;
        best = std::min(best, time);
    }
    candidates_.clear();
    ties_.clear();
    for (std::size_t i = 0; i < links.size() && any_grazes != 0; ++i) {
        if (std::abs(slopes[i]) > errors.min_slope) continue;
        const Image image = follow(from, links[i]);
        const int approach = exact::approach(ray_, between(from, image));
        if (approach > 0) candidates_.push_back(image);
        if (approach == 0 && exact::farther(ray_.origin, plane_of(from), plane_of(image)) == 0) ties_.push_back(image);
    }
    std::size_t last = 0;
    // A time t comes first only if t - a - b |t| <= best + a + b |best|.
    const double bound = best + 2.2 * (errors.constant + errors.relative * std::abs(best));
    for (std::size_t i = 0; i < links.size() && best != no_time; ++i) {
        if (times[i] > bound) continue;
        candidates_.push_back(follow(from, links[i]));
        last = i;
    }
    if (candidates_.empty()) return false;
    event.kind = exact::Crossing::Kind::bisector;
    event.from = from;
    event.to = candidates_.front();
    for (std::size_t c = 1; c < candidates_.size(); ++c) {
        const Image& to = candidates_[c];
        if (exact::later(ray_, between(from, to), exact_of(event)) < 0) event.to = to;
    }
    __builtin_prefetch(graph_.links(event.to.seed).data());
    // A time among several candidates, or of a grazing crossing, is computed again.
    event.time = times[last];
    const double error = best == no_time ? no_time
                                         : 1.1 * (errors.rise + errors.slope * std::abs(event.time)) / slopes[last] +
                                               4 * unit_roundoff * std::abs(event.time);
    event.least = event.time - error;
    event.most = event.time + error;
    if (candidates_.size() > 1 || !(error <= 512 * error_ + 32 * unit_roundoff * std::abs(event.time)))
        find_time(event);
    return true;
}

bool RayTracer::is_same_line(const Image& a, const Image& b) const {
    return exact::approach(ray_, between(a, b)) == 0 && exact::farther(ray_.origin, plane_of(a), plane_of(b)) == 0;
}

// Returns the image of lowest index among those whose cells share the ray, then of lowest shift. ties_: those that are
// neighbors of `of`.
RayTracer::Image RayTracer::lowest_of_ties(const Image& of) {
    ties_.insert(ties_.begin(), of);
    Image lowest = of;
    const auto index = [&](const Image& i) { return std::pair{seeds_.input[i.seed], i.shift}; };
    for (std::size_t t = 0; t < ties_.size(); ++t) {
        const Image from = ties_[t];
        if (index(from) < index(lowest)) lowest = from;
        for (const CellGraph::Link& link : graph_.links(from.seed)) {
            const Image to = follow(from, link);
            const bool known =
                std::ranges::any_of(ties_, [&](const Image& i) { return i.seed == to.seed && i.shift == to.shift; });
            if (!known && is_same_line(of, to)) ties_.push_back(to);
        }
    }
    return lowest;
}

bool RayTracer::trace(const exact::Ray& ray, double end, const Image& start, std::vector<Piece>& out) {
    ray_ = ray;
    if (!find_stop(end)) return false;
    Image at = start;
    if (!graph_.has_cell(at.seed)) {
        if (graph_.first_cell() == CellGraph::none) return true;
        at = walk_to_origin({graph_.first_cell(), {}});
    }
    const double size = graph_.size() + size_of(ray.origin);
    Event from;  // time 0
    for (std::size_t step = 1; later(stop_, from); ++step) {
        if (step % steps_per_look == 0) check_stop();
        double shifts = 0;
        for (const std::int32_t s : at.shift) {
            if (std::abs(s) > farthest_shift)
                throw Error(ErrorCode::unsupported, "a ray passes more than 500 million periods: make it shorter");
            shifts += std::abs(s);
        }
        error_ = 16 * unit_roundoff * (size + (shifts + 3 * graph_.max_shift()) * graph_.period());
        Event next;
        const bool stops = !find_next(at, next) || !later(stop_, next);
        const Image to = next.to;
        if (stops) next = stop_;
        if (later(next, from)) {
            next.time = std::clamp(next.time, from.time, std::max(from.time, stop_.time));
            out.push_back({ties_.empty() ? at : lowest_of_ties(at), 0.5 * from.time, 0.5 * next.time});
            from = next;
        }
        if (stops) break;
        at = to;
    }
    return true;
}

}  // namespace votess::cpu

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
constexpr std::size_t cache_line = 64;
constexpr std::size_t steps_per_look = 1024;  // after which the user may stop

exact::Shift sum(const exact::Shift& a, const std::array<std::int8_t, 3>& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

RayTracer::Image follow(const RayTracer::Image& from, const CellGraph::Link& link) {
    return {link.seed, sum(from.shift, link.shift)};
}

template <class Shift>
void add_shift(const Domain& domain, const Shift& shift, std::array<double, 3>& x) {
    for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k) x[k] += shift[j] * domain.vector[j][k];
}

// Compares without a call of memcmp().
bool is_same(const exact::Shift& a, const exact::Shift& b) {
    return ((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) == 0;
}

double size_of(const std::array<double, 3>& x) {
    return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
}

std::int16_t rounded(double x) {
    return static_cast<std::int16_t>(x + (x < 0 ? -0.5 : 0.5));
}

// Far within the range of a float.
constexpr double max_sketched = 1e30;

}  // namespace

CellGraph::CellGraph(const Domain& domain, const SortedSeeds& seeds, const Tessellation& t) {
    std::vector<std::int32_t> sorted(t.size(), -1);
    for (std::size_t i = 0; i < seeds.size(); ++i)
        sorted[static_cast<std::size_t>(seeds.input[i])] = static_cast<std::int32_t>(i);
    const std::span<const std::int8_t> shifts = t.shifts();
    places_.resize_uninitialized(seeds.size());
    std::size_t end = 0;  // of the sketches
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        const auto input = static_cast<std::size_t>(seeds.input[i]);
        const exact::Point at = seeds.images == nullptr ? exact::Point{seeds.x[i], seeds.y[i], seeds.z[i]}
                                                        : seeds.images->place_in_domain(i);
        Place& place = places_[i] = {at[0], at[1], at[2], seeds.weights.empty() ? 0 : seeds.weights[i], end};
        const std::size_t count = t.neighbors(input).size();
        place.count = static_cast<std::uint32_t>(count) & 0x7fffffff;
        end += ceil_div(count, RaySketch::lanes);
        max_links_ = std::max(max_links_, count);
        max_weight_ = std::max(max_weight_, std::abs(place.weight));
        size_ = std::max(size_, size_of(at));
        has_cell_.push_back(t.status()[input] == CellStatus::certified);
        if (has_cell_.back() && first_cell_ == none) first_cell_ = i;
    }
    for (const auto& vector : domain.vector) period_ = std::max(period_, size_of(vector));
    sketches_.resize_uninitialized(end);
    if (!seeds.weights.empty()) constants_.resize_uninitialized(end);
    if (!shifts.empty()) shifts_.resize_uninitialized(end * RaySketch::lanes);
    std::vector<Vector3> ways;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        Place& place = places_[i];
        const auto input = static_cast<std::size_t>(seeds.input[i]);
        const auto entry = static_cast<std::size_t>(t.indptr()[input]);
        ways.clear();
        double reach = 0;
        for (std::size_t k = 0; k < place.count; ++k) {
            const auto neighbor = static_cast<std::size_t>(sorted[static_cast<std::size_t>(t.neighbors(input)[k])]);
            const std::size_t sketch = place.sketch + k / RaySketch::lanes, lane = k % RaySketch::lanes;
            sketches_[sketch].seed[lane] = static_cast<std::int32_t>(neighbor);
            const Place& there = places_[neighbor];
            Vector3& way = ways.emplace_back(Vector3{there.x - place.x, there.y - place.y, there.z - place.z});
            for (std::size_t j = 0; j < 3 && !shifts.empty(); ++j) {
                const std::int8_t shift = shifts[3 * (entry + k) + j];
                shifts_[sketch * RaySketch::lanes + lane][j] = shift;
                max_shift_ = std::max(max_shift_, std::abs(int{shift}));
                if (shift != 0) place.has_shifts = 1;
            }
            if (const Link to = link(place, k); to.is_shifted) add_shift(domain, to.shift, way);
            reach = std::max(reach, std::abs(way[0]) + std::abs(way[1]) + std::abs(way[2]));
        }
        place.reach = static_cast<float>(reach * (1 + 0x1p-20)) + std::numeric_limits<float>::min();
        draw(place, ways);
    }
}

// Fills the sketches.
void CellGraph::draw(Place& place, std::span<const Vector3> ways) {
    const double inverse_unit = std::ldexp(1.0, -std::ilogb(place.reach * (1 + 0x1p-12)) - 1);
    place.inverse_unit = static_cast<float>(inverse_unit);
    place.max_constant = constants_.empty() ? 1 : 0;
    for (std::size_t i = 0; i < round_up(ways.size(), RaySketch::lanes); ++i) {
        const std::size_t lane = i % RaySketch::lanes;
        RaySketch& sketch = sketches_[place.sketch + i / RaySketch::lanes];
        const Vector3 way = i < ways.size() ? ways[i] : Vector3{};
        for (std::size_t k = 0; k < 3; ++k) sketch.way[k][lane] = rounded(way[k] * inverse_unit * RaySketch::units);
        if (i >= ways.size()) sketch.seed[lane] = 0;
        if (constants_.empty()) continue;
        float& constant = constants_[place.sketch + i / RaySketch::lanes][lane];
        constant = 0;
        if (i >= ways.size()) continue;
        const double weight = places_[static_cast<std::size_t>(sketch.seed[lane])].weight - place.weight;
        const double exact = (dot(way, way) - weight) * inverse_unit * inverse_unit;
        const bool fits = std::abs(exact) < max_sketched;
        constant = fits ? static_cast<float>(exact) : 0;
        place.max_constant =
            std::max(place.max_constant, fits ? std::abs(constant) : std::numeric_limits<float>::infinity());
    }
}

RayTracer::RayTracer(const Domain& domain, const SortedSeeds& seeds, const CellGraph& graph,
                     std::vector<exact::Plane> walls, std::string_view instructions)
    : domain_(domain),
      seeds_(seeds),
      graph_(graph),
      select_crossings_(select_crossings(instructions)),
      walls_(std::move(walls)),
      scratch_(2 * round_up(graph.max_links(), RaySketch::lanes)),
      selected_(graph.max_links() + 1),
      slopes_(graph.max_links()),
      times_(graph.max_links()) {
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
    if (!is_same(image.shift, {})) add_shift(domain_, image.shift, x);
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
        const CellGraph::Place& here = graph_.place(from.seed);
        for (std::size_t i = 0; i < here.count; ++i) {
            const Image to = follow(from, graph_.link(here, i));
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

// Returns the arguments of select_crossings_. Let u be a unit, p the seed relative to the ray's place where the piece
// begins, n = N / u, and f = 2^-24. Then A / B is that place's plus u a / b, with b = n.d and a = n.n - (w_q - w_p) /
// u^2 + 2 n.p / u. A coordinate of n errs by 2^-16 and delta / u. Each sum rounds by less than 8 f of the sum of its
// terms' sizes.
//
// A slope b above 4 times its error errs by a third at most. So a / b errs by less than 1.34 (e_a + |a / b| e_b) / b.
// `constant` and `relative` are 4 times the error of A / B as double precision finds it.
SketchRay RayTracer::sketch_ray(const CellGraph::Place& here) const {
    constexpr double rounding = 8 * 0x1p-24;
    const double scale = here.inverse_unit, time = 0.5 * from_.time;
    Vector3 p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = (position_[k] - time * ray_.direction[k]) * scale;
    const double sum = std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]);
    const double delta = (place_error_ + (here.has_shifts != 0 ? shift_error_ : 0)) * scale;
    const double way = 1.01 * 0x1p-16 + delta, place = (1.1 * error_ + 4 * unit_roundoff * std::abs(time)) * scale;
    const double slope = 3 * way + rounding;
    const double rise = 2 * way * (sum + 3 * place) + 3 * place + rounding * (1 + here.max_constant + 2 * sum) +
                        2 * way + 3 * way * way + 8 * unit_roundoff * graph_.max_weight() * scale * scale + 0x1p-40;
    const double constant = (errors_.constant + errors_.relative * 2 * std::abs(time)) * scale;
    SketchRay ray{};
    // Skips no neighbor.
    ray.min_slope = std::numeric_limits<float>::infinity();
    if (!(sum + rise + constant < max_sketched)) return ray;
    for (std::size_t k = 0; k < 3; ++k) {
        ray.direction[k] = sketch_direction_[k];
        ray.twice_place[k] = static_cast<float>(2 / RaySketch::units * p[k]);
    }
    ray.min_slope = static_cast<float>(std::max(4 * slope, errors_.min_slope * scale + 2 * slope));
    ray.rise = static_cast<float>(1.5 * rise);
    ray.slope = static_cast<float>(1.5 * slope);
    ray.constant = static_cast<float>(4 * constant);
    ray.relative = static_cast<float>(4 * errors_.relative);
    ray.max_relative = static_cast<float>(4 * errors_.relative * (1 + here.max_constant + 2 * sum + rise));
    return ray;
}

void RayTracer::look() {
    const CellGraph::Place& here = graph_.place(at_.seed);
    position_ = position(at_);
    errors_ = errors_of(here, position_);
    selected_count_ = select_crossings_(graph_.sketched(here), sketch_ray(here), scratch_.data(), selected_.data());
    for (std::size_t i = 0; i < selected_count_; ++i)
        __builtin_prefetch(&graph_.place(graph_.link(here, selected_[i]).seed));
}

void RayTracer::set_error() {
    double shifts = 0;
    for (const std::int32_t s : at_.shift) {
        if (std::abs(s) > farthest_shift)
            throw Error(ErrorCode::unsupported, "a ray passes more than 500 million periods: make it shorter");
        shifts += std::abs(s);
    }
    error_ = 16 * unit_roundoff *
             (graph_.size() + size_of(ray_.origin) + (shifts + 3 * graph_.max_shift()) * graph_.period());
}

// Finds where the ray leaves a cell, after look(). Returns false when it never does. Fills ties_ with neighbors of the
// same line.
bool RayTracer::find_next(Event& event) {
    const Image& from = at_;
    const CellGraph::Place& here = graph_.place(from.seed);
    const Vector3 d = ray_.direction, twice{2 * position_[0], 2 * position_[1], 2 * position_[2]};
    const std::span<const std::uint32_t> selected{selected_.data(), selected_count_};
    const Errors& errors = errors_;
    double* const slopes = slopes_.data();
    double* const times = times_.data();
    double best = no_time;
    bool any_grazes = false;
    for (std::size_t i = 0; i < selected.size(); ++i) {
        const CellGraph::Link link = graph_.link(here, selected[i]);
        const CellGraph::Place& place = graph_.place(link.seed);
        Vector3 n{place.x - here.x, place.y - here.y, place.z - here.z};
        if (link.is_shifted) add_shift(domain_, link.shift, n);
        const double slope = dot(n, d);
        const double rise =
            dot(n, Vector3{n[0] + twice[0], n[1] + twice[1], n[2] + twice[2]}) - (place.weight - here.weight);
        any_grazes = any_grazes || std::abs(slope) <= errors.min_slope;
        slopes[i] = slope;
        times[i] = slope > errors.min_slope ? rise / slope : no_time;
        best = std::min(best, times[i]);
    }
    event.kind = exact::Crossing::Kind::bisector;
    event.from = from;
    ties_.clear();
    std::size_t last = 0;
    bool is_sure = selected.size() == 1 && best != no_time;
    if (is_sure) {
        event.to = follow(from, graph_.link(here, selected[0]));
    } else {
        candidates_.clear();
        for (std::size_t i = 0; i < selected.size() && any_grazes; ++i) {
            if (std::abs(slopes[i]) > errors.min_slope) continue;
            const Image image = follow(from, graph_.link(here, selected[i]));
            const int approach = exact::approach(ray_, between(from, image));
            if (approach > 0) candidates_.push_back(image);
            if (approach == 0 && exact::farther(ray_.origin, plane_of(from), plane_of(image)) == 0)
                ties_.push_back(image);
        }
        // A time t comes first only if t - a - b |t| <= best + a + b |best|.
        const double bound = best + 2.2 * (errors.constant + errors.relative * std::abs(best));
        for (std::size_t i = 0; i < selected.size() && best != no_time; ++i) {
            if (times[i] > bound) continue;
            candidates_.push_back(follow(from, graph_.link(here, selected[i])));
            last = i;
        }
        if (candidates_.empty()) return false;
        is_sure = candidates_.size() == 1 && best != no_time;
        event.to = candidates_.front();
        for (std::size_t c = 1; c < candidates_.size(); ++c) {
            const Image& to = candidates_[c];
            if (exact::later(ray_, between(from, to), exact_of(event)) < 0) event.to = to;
        }
    }
    if (is_sure) {
        event.time = times[last];
        const double time_error = 4 * unit_roundoff * std::abs(event.time);
        const double error = 1.1 * (errors.rise + errors.slope * std::abs(event.time)) / slopes[last] + time_error;
        event.least = event.time - error;
        event.most = event.time + error;
        is_sure = error <= 512 * error_ + 8 * time_error;
    }
    // A time among several candidates, or of a grazing crossing, is computed again.
    if (!is_sure) find_time(event);
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
        const CellGraph::Place& here = graph_.place(from.seed);
        for (std::size_t i = 0; i < here.count; ++i) {
            const Image to = follow(from, graph_.link(here, i));
            const bool known =
                std::ranges::any_of(ties_, [&](const Image& i) { return i.seed == to.seed && i.shift == to.shift; });
            if (!known && is_same_line(of, to)) ties_.push_back(to);
        }
    }
    return lowest;
}

bool RayTracer::start(const exact::Ray& ray, double end, const Image& start) {
    ray_ = ray;
    pieces_.clear();
    from_ = {};  // time 0
    steps_ = 0;
    is_under_way_ = false;
    if (!find_stop(end)) return false;
    at_ = start;
    if (!graph_.has_cell(at_.seed)) {
        if (graph_.first_cell() == CellGraph::none) return true;
        at_ = walk_to_origin({graph_.first_cell(), {}});
    }
    is_under_way_ = later(stop_, from_);
    set_error();
    for (std::size_t k = 0; k < 3; ++k) sketch_direction_[k] = static_cast<float>(ray_.direction[k] / RaySketch::units);
    return true;
}

void RayTracer::step() {
    if (++steps_ % steps_per_look == 0) check_stop();
    Event next;
    is_under_way_ = find_next(next) && later(stop_, next);
    const Event& end = is_under_way_ ? next : stop_;
    if (later(end, from_)) {
        const double time = std::clamp(end.time, from_.time, std::max(from_.time, stop_.time));
        pieces_.push_back({ties_.empty() ? at_ : lowest_of_ties(at_), 0.5 * from_.time, 0.5 * time});
        from_ = end;
        from_.time = time;
    }
    if (!is_under_way_) return;
    const bool is_shifted = !is_same(at_.shift, next.to.shift);
    at_ = next.to;
    if (is_shifted) set_error();
    const std::span<const RaySketch> sketches = graph_.sketched(graph_.place(at_.seed)).sketches;
    const auto* bytes = reinterpret_cast<const std::byte*>(sketches.data());
    for (std::size_t b = 0; b < sketches.size_bytes(); b += cache_line) __builtin_prefetch(bytes + b);
}

}  // namespace votess::cpu

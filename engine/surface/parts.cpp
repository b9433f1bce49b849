#include "surface/parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <span>
#include <unordered_set>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "index/sort_grid.hpp"
#include "surface/nearest.hpp"
#include "surface/triangle_cells.hpp"

namespace votess::surface {
namespace {

constexpr std::size_t triangles_per_task = 64, seeds_per_task = 128, parts_per_task = 1024;
// Parts of a triangle that one thread finds, before all threads do.
constexpr std::size_t max_alone = 4096;

// Finds the seed whose cell holds a place, by its number.
class Owner {
public:
    explicit Owner(const Surface& surface) : surface_(surface) {}

    [[nodiscard]] std::uint32_t of(const exact::Point& x) {
        double least = std::numeric_limits<double>::infinity();
        seen_.clear();
        const auto skip = [&](const SeedTree::Node& node) {
            const double weight = surface_.tree().weight(node);
            return node.square - weight - rounding * (node.square + std::abs(weight)) > least;
        };
        surface_.tree().visit_from(x, infinity, skip, [&](std::uint32_t number) {
            const Vector3 d = minus(surface_.tree().place(number), x);
            const double square = dot(d, d), weight = surface_.weight(surface_.tree().seed(number));
            const double power = square - weight, error = rounding * (square + std::abs(weight));
            if (power - error > least) return;
            least = std::min(least, power + error);
            seen_.push_back({power - error, number});
        });
        std::uint32_t best = ClippedTriangle::none;
        for (const auto& [lower, number] : seen_)
            if (lower <= least && (best == ClippedTriangle::none ||
                                   is_nearer(surface_.tree().seed(number), surface_.tree().seed(best), x)))
                best = number;
        return best;
    }

private:
    static constexpr double rounding = 0x1p-48;

    [[nodiscard]] bool is_nearer(std::int32_t id, std::int32_t than, const exact::Point& x) {
        const exact::Point& origin = surface_.seed(than);
        signs_.begin(origin, exact::Plane::bisector(origin), than);
        signs_.add(surface_.bisector(than, id), id);
        const auto place = signs_.place(x);
        auto value = signs_.value(0, place);
        signs_.find_sign(0, place, value);
        return value.sign > 0;
    }

    const Surface& surface_;
    solid::MeshSigns signs_;
    std::vector<std::pair<double, std::uint32_t>> seen_;
};

// A part, if only areas are wanted.
struct PartArea {
    double area, border;
    std::int32_t seed;
};

// Parts of some triangles, or of one.
struct Chunk {
    struct Run {
        std::int32_t triangle;
        std::size_t end;  // of its parts
    };
    std::vector<Part> parts;
    std::vector<PartArea> areas;  // instead of these
    std::vector<Run> runs;
    void end_run(std::int32_t triangle) { runs.push_back({triangle, parts.size() + areas.size()}); }
    std::vector<Side> sides;
    std::vector<std::uint8_t> without_length;
    std::vector<std::array<double, 2>> weights;
    std::vector<std::uint32_t> beyond;  // numbers of seeds beyond the sides of the last part; of a round: of all
};

// A triangle with many parts, and the seeds to clip it to next.
struct Large {
    std::int32_t triangle;
    std::unordered_set<std::uint32_t> seen;
    std::vector<std::uint32_t> pending;
};

class Distribution {
public:
    Distribution(const Surface& surface, SurfaceWant want, ThreadPool& pool)
        : surface_(surface), want_(want), pool_(pool), near_(surface.tree()) {
        for (unsigned i = 0; i < pool.size(); ++i) workers_.push_back(std::make_unique<Worker>(surface, near_));
    }

    [[nodiscard]] Parts make() {
        make_chunks();
        return join();
    }

    void sum(std::vector<double>& areas, std::vector<double>& borders) {
        make_chunks();
        areas.assign(surface_.seeds(), 0);
        borders.assign(surface_.seeds(), 0);
        // In the order of triangles, as join() puts them.
        std::vector<std::pair<std::int32_t, std::span<const PartArea>>> runs;
        for (const Chunk& chunk : chunks_)
            for (std::size_t begin = 0; const auto& [triangle, end] : chunk.runs) {
                runs.emplace_back(triangle, std::span(chunk.areas).subspan(begin, end - begin));
                begin = end;
            }
        std::ranges::stable_sort(runs, {}, [](const auto& run) { return run.first; });
        for (const auto& [triangle, parts] : runs)
            for (const PartArea& part : parts) {
                areas[at(part.seed)] += part.area;
                borders[at(part.seed)] += part.border;
            }
    }

private:
    // Clips all triangles, along a Hilbert curve, so that near ones need the same memory.
    void make_chunks() {
        const std::vector<std::int32_t> order = order_of_triangles();
        small_ = ceil_div(order.size(), triangles_per_task);
        chunks_.resize(small_);
        std::vector<std::vector<Large>> large(small_);
        pool_.run_stage(small_, [&](std::size_t index, unsigned worker) {
            const std::size_t end = std::min(order.size(), (index + 1) * triangles_per_task);
            workers_[worker]->cells.restart();
            for (std::size_t k = index * triangles_per_task; k < end; ++k)
                clip_all(order[k], *workers_[worker], chunks_[index], large[index]);
        });
        for (auto& of_task : large)
            for (Large& of : of_task) clip_large(of);
    }

    [[nodiscard]] std::vector<std::int32_t> order_of_triangles() const {
        const auto& triangles = surface_.triangles();
        const auto middle = [&](const Surface::Triangle& triangle) {
            Vector3 x{};
            for (const std::int32_t v : triangle.vertex)
                for (std::size_t k = 0; k < 3; ++k) x[k] += surface_.vertex(v)[k] / 3;
            return x;
        };
        cpu::Bounds bounds;
        for (const auto& triangle : triangles) {
            const Vector3 x = middle(triangle);
            bounds.add(x[0], x[1], x[2]);
        }
        const cpu::Grid grid(bounds);
        std::vector<std::pair<std::uint32_t, std::int32_t>> keys;
        keys.reserve(triangles.size());
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            if (!(triangles[t].area > 0)) continue;
            const Vector3 x = middle(triangles[t]);
            keys.push_back({grid.key(x[0], x[1], x[2]), static_cast<std::int32_t>(t)});
        }
        std::ranges::sort(keys);
        std::vector<std::int32_t> order;
        order.reserve(keys.size());
        for (const auto& [key, t] : keys) order.push_back(t);
        return order;
    }

    struct Worker {
        Worker(const Surface& surface, const NearSeeds& near) : cells(surface), part(surface, near), owner(surface) {}
        TriangleCells cells;
        ClippedTriangle part;
        Owner owner;
        std::unordered_set<std::uint32_t> seen;
        std::vector<std::uint32_t> pending;
    };

    // Returns the owner of a triangle's first vertex.
    [[nodiscard]] std::uint32_t owner(std::int32_t triangle, Worker& worker) const {
        return worker.owner.of(surface_.vertex(surface_.triangles()[at(triangle)].vertex[0]));
    }

    void clip_all(std::int32_t triangle, Worker& worker, Chunk& chunk, std::vector<Large>& large) const {
        const std::size_t first = chunk.parts.size();
        if (worker.cells.make(triangle, worker.part)) {
            const Surface::Triangle& of = surface_.triangles()[at(triangle)];
            const bool only_area = want_ == SurfaceWant::areas && !of.has_border;
            for (std::size_t i = 0; i < worker.cells.parts(); ++i) {
                if (only_area) {
                    chunk.areas.push_back({worker.cells.area(i, of.area), 0, worker.cells.seed(i)});
                    continue;
                }
                worker.cells.select(i);
                add_part(triangle, worker.cells, chunk);
            }
        } else {
            clip_each(triangle, worker, chunk, large);
        }
        chunk.end_run(triangle);
        if (want_ != SurfaceWant::areas)
            std::sort(chunk.parts.begin() + static_cast<std::ptrdiff_t>(first), chunk.parts.end(), is_before);
    }
    static bool is_before(const Part& a, const Part& b) { return a.seed < b.seed; }

    // Clips a triangle to one cell after the other, while they are not too many.
    void clip_each(std::int32_t triangle, Worker& worker, Chunk& chunk, std::vector<Large>& large) const {
        worker.part.set_triangle(triangle);
        worker.seen.clear();
        worker.pending.assign(1, owner(triangle, worker));
        worker.seen.insert(worker.pending[0]);
        for (std::size_t count = 0; !worker.pending.empty(); ++count) {
            if (count % 64 == 0) check_stop();
            if (count == max_alone) {
                large.push_back({triangle, worker.seen, worker.pending});
                return;
            }
            const std::uint32_t number = worker.pending.back();
            worker.pending.pop_back();
            chunk.beyond.clear();
            clip(triangle, number, worker.part, chunk);
            for (const std::uint32_t next : chunk.beyond)
                if (worker.seen.insert(next).second) worker.pending.push_back(next);
        }
    }

    // Clips a triangle on all threads: pending seeds at once, then those beyond the sides.
    void clip_large(Large& large) {
        std::vector<std::uint32_t>&round = large.pending, next;
        for (; !round.empty(); std::swap(round, next)) {
            const std::size_t first = chunks_.size();
            chunks_.resize(first + ceil_div(round.size(), seeds_per_task));
            pool_.run(chunks_.size() - first, [&](std::size_t index, unsigned worker) {
                check_stop();
                ClippedTriangle& part = workers_[worker]->part;
                part.set_triangle(large.triangle);
                const std::size_t end = std::min(round.size(), (index + 1) * seeds_per_task);
                for (std::size_t k = index * seeds_per_task; k < end; ++k)
                    clip(large.triangle, round[k], part, chunks_[first + index]);
                chunks_[first + index].end_run(large.triangle);
            });
            next.clear();
            for (std::size_t c = first; c < chunks_.size(); ++c) {
                for (const std::uint32_t number : chunks_[c].beyond)
                    if (large.seen.insert(number).second) next.push_back(number);
                chunks_[c].beyond = {};
            }
            std::ranges::sort(next);  // near ones need the same memory
        }
    }

    // Adds the part of a triangle in a cell to a chunk.
    void clip(std::int32_t triangle, std::uint32_t number, ClippedTriangle& clipped, Chunk& chunk) const {
        if (!clipped.clip(number))
            throw Error(ErrorCode::internal, "a triangle of a surface has no part beyond a bisector that cuts it");
        clipped.settle();
        clipped.find_ties();
        add_part(triangle, clipped, chunk);
        for (std::size_t i = 0; i < clipped.size(); ++i)
            if (clipped.side(i) >= 0) chunk.beyond.push_back(clipped.beyond(i));
    }

    // clipped: a ClippedTriangle or TriangleCells.
    template <class Clipped>
    void add_part(std::int32_t triangle, const Clipped& clipped, Chunk& chunk) const {
        const std::size_t size = clipped.size();
        Part part{triangle, clipped.seed(),    static_cast<std::uint32_t>(size), clipped.has_area(), 0, 0, {},
                  0,        chunk.sides.size()};
        measure(clipped, part);
        if (want_ == SurfaceWant::areas) {
            chunk.areas.push_back({part.area, part.border, part.seed});
            return;
        }
        chunk.parts.push_back(part);
        for (std::size_t i = 0; i < size; ++i) {
            chunk.sides.push_back(clipped.side(i));
            chunk.without_length.push_back(clipped.has_length(i) ? 0 : 1);
            chunk.weights.push_back(clipped.weights(i));
        }
    }

    template <class Clipped>
    void measure(const Clipped& clipped, Part& part) const {
        const Surface::Triangle& triangle = surface_.triangles()[at(part.triangle)];
        const std::size_t size = clipped.size();
        const auto& o = clipped.weights(0);
        for (std::size_t i = 1; part.has_area && i + 1 < size; ++i) {
            const auto &v = clipped.weights(i), &w = clipped.weights(i + 1);
            const double share = (v[0] - o[0]) * (w[1] - o[1]) - (v[1] - o[1]) * (w[0] - o[0]);
            const double piece = triangle.area * share;
            part.area += piece;
            if (want_ == SurfaceWant::areas) continue;
            const Vector3 &x = clipped.place(0), &y = clipped.place(i), &z = clipped.place(i + 1);
            const Vector3 sum{x[0] + y[0] + z[0], x[1] + y[1] + z[1], x[2] + y[2] + z[2]};
            for (std::size_t k = 0; k < 3; ++k) part.moment[k] += piece / 3 * sum[k];
            part.energy += piece / 12 * (dot(x, x) + dot(y, y) + dot(z, z) + dot(sum, sum));
        }
        part.area = std::max(part.area, 0.0);  // may be rounded to less
        if (!triangle.has_border) return;
        for (std::size_t i = 0; i < size; ++i) {
            const Side side = clipped.side(i);
            if (side >= 0 || surface_.edges()[at(triangle.edge[corner_of(side)])].triangles != 1) continue;
            if (!clipped.has_length(i)) continue;
            const auto &from = clipped.weights(i), &to = clipped.weights(i + 1 == size ? 0 : i + 1);
            const double s = to[0] - from[0], t = to[1] - from[1];
            const Vector3 u = surface_.vertex(triangle.vertex[0]);
            const Vector3 a = minus(surface_.vertex(triangle.vertex[1]), u),
                          b = minus(surface_.vertex(triangle.vertex[2]), u);
            part.border += length3(s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]);
        }
    }

    // Puts the parts of all chunks in order. Sides stay in theirs.
    [[nodiscard]] Parts join() const {
        check_stop();
        Parts parts;
        parts.of_triangle.assign(surface_.triangles().size() + 1, 0);
        std::vector<std::size_t> first_side{0};
        for (const Chunk& chunk : chunks_) {
            for (const Part& part : chunk.parts) ++parts.of_triangle[at(part.triangle) + 1];
            first_side.push_back(first_side.back() + chunk.sides.size());
        }
        std::partial_sum(parts.of_triangle.begin(), parts.of_triangle.end(), parts.of_triangle.begin());
        parts.list.resize(parts.of_triangle.back());
        parts.sides.resize(first_side.back());
        parts.without_length.resize(first_side.back());
        parts.weights.resize(first_side.back());
        std::vector<std::size_t> next = parts.of_triangle;
        const auto add = [&](std::size_t index, unsigned) {
            const Chunk& chunk = chunks_[index];
            for (const Part& part : chunk.parts) {
                Part& to = parts.list[next[at(part.triangle)]++];
                to = part;
                to.begin += first_side[index];
            }
            const auto begin = static_cast<std::ptrdiff_t>(first_side[index]);
            std::ranges::copy(chunk.sides, parts.sides.begin() + begin);
            std::ranges::copy(chunk.without_length, parts.without_length.begin() + begin);
            std::ranges::copy(chunk.weights, parts.weights.begin() + begin);
        };
        pool_.run(small_, add);  // each has its own triangles
        for (std::size_t index = small_; index < chunks_.size(); ++index) {
            add(index, 0);
            const auto triangle = at(chunks_[index].parts[0].triangle);
            if (index + 1 == chunks_.size() || at(chunks_[index + 1].parts[0].triangle) != triangle)
                std::sort(parts.list.begin() + static_cast<std::ptrdiff_t>(parts.of_triangle[triangle]),
                          parts.list.begin() + static_cast<std::ptrdiff_t>(parts.of_triangle[triangle + 1]), is_before);
        }
        return parts;
    }

    const Surface& surface_;
    SurfaceWant want_;
    ThreadPool& pool_;
    NearSeeds near_;
    std::vector<std::unique_ptr<Worker>> workers_;
    std::size_t small_ = 0;  // chunks, each of its own triangles; then those of large triangles
    std::vector<Chunk> chunks_;
};

class Numbering {
public:
    Numbering(Parts& parts, const Surface& surface, ThreadPool& pool) : parts_(parts), surface_(surface), pool_(pool) {}

    void number() {
        const std::size_t given = surface_.vertices().size();
        parts_.corners.resize(parts_.sides.size());
        for (std::size_t p = 0; p < parts_.size(); ++p)
            for (std::size_t c = parts_.begin(p); c < parts_.end(p); ++c) {
                const Side in = parts_.before(p, c), out = parts_.sides[c];
                if (in < 0 && out < 0) {
                    parts_.corners[c] = triangle_of(p).vertex[corner_of(out)];
                } else if (has_place(p, in, out)) {
                    parts_.corners[c] = static_cast<std::int32_t>(given + parts_.sources.size());
                    parts_.sources.push_back({p, c});
                } else {
                    parts_.corners[c] = -1;
                }
            }
        if (given + parts_.sources.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
            throw Error(ErrorCode::invalid_argument, "the cells cut the surface into more than 2147483647 vertices");
        pool_.run(ceil_div(parts_.size(), parts_per_task), [&](std::size_t index, unsigned) {
            check_stop();
            for (std::size_t p = index * parts_per_task; p < std::min(parts_.size(), (index + 1) * parts_per_task); ++p)
                for (std::size_t c = parts_.begin(p); c < parts_.end(p); ++c)
                    if (parts_.corners[c] < 0) parts_.corners[c] = corner_elsewhere(p, c);
        });
    }

private:
    [[nodiscard]] const Surface::Triangle& triangle_of(std::size_t p) const {
        return surface_.triangles()[at(parts_.list[p].triangle)];
    }
    // Returns whether a part has the place of the corner between two sides, not both of them edges.
    [[nodiscard]] bool has_place(std::size_t p, Side in, Side out) const {
        const std::int32_t seed = parts_.list[p].seed;
        if (in >= 0 && out >= 0) return seed < in && seed < out;
        const std::int32_t edge = triangle_of(p).edge[corner_of(std::min(in, out))];
        return seed < std::max(in, out) && surface_.edges()[at(edge)].first == parts_.list[p].triangle;
    }

    // Returns the vertex of a corner from the part that has its place.
    [[nodiscard]] std::int32_t corner_elsewhere(std::size_t p, std::size_t c) const {
        const Side in = parts_.before(p, c), out = parts_.sides[c];
        const auto [triangle, seed] = std::pair(parts_.list[p].triangle, parts_.list[p].seed);
        if (in >= 0 && out >= 0) {
            const std::int32_t lowest = std::min({seed, in, out});
            const std::size_t q = parts_.find(triangle, lowest);
            // Around the corner the cells follow in one order.
            const Side from = lowest == in ? out : seed, to = lowest == in ? seed : in;
            for (std::size_t d = parts_.begin(q); d < parts_.end(q); ++d)
                if (parts_.before(q, d) == from && parts_.sides[d] == to) return parts_.corners[d];
        } else {
            const std::int32_t other = std::max(in, out), lowest = std::min(seed, other),
                               higher = std::max(seed, other);
            const std::int32_t edge = surface_.triangles()[at(triangle)].edge[corner_of(std::min(in, out))];
            const std::int32_t first = surface_.edges()[at(edge)].first;
            const auto& edges = surface_.triangles()[at(first)].edge;
            const auto is_edge = [&](Side side) { return side < 0 && edges[corner_of(side)] == edge; };
            const std::size_t q = parts_.find(first, lowest);
            for (std::size_t d = parts_.begin(q); d < parts_.end(q); ++d) {
                const Side a = parts_.before(q, d), b = parts_.sides[d];
                if ((a == higher && is_edge(b)) || (b == higher && is_edge(a))) return parts_.corners[d];
            }
        }
        throw Error(ErrorCode::internal, "parts of a surface do not meet where three cells do");
    }

    Parts& parts_;
    const Surface& surface_;
    ThreadPool& pool_;
};

}  // namespace

std::size_t Parts::find(std::int32_t triangle, std::int32_t seed) const {
    const auto begin = list.begin() + static_cast<std::ptrdiff_t>(of_triangle[at(triangle)]);
    const auto end = list.begin() + static_cast<std::ptrdiff_t>(of_triangle[at(triangle) + 1]);
    const auto found = std::ranges::lower_bound(begin, end, seed, {}, &Part::seed);
    if (found == end || found->seed != seed)
        throw Error(ErrorCode::internal, "a part of a surface is missing beside another");
    return static_cast<std::size_t>(found - list.begin());
}

double Parts::share_on_edge(const Surface& surface, const Source& crossing) const {
    const Surface::Triangle& triangle = surface.triangles()[at(list[crossing.part].triangle)];
    const Side edge = std::min(before(crossing.part, crossing.corner), sides[crossing.corner]);
    const auto& w = weights[crossing.corner];
    std::size_t low = corner_of(edge), high = (low + 1) % 3;
    if (triangle.vertex[low] > triangle.vertex[high]) std::swap(low, high);
    return high > 0 ? w[high - 1] : 1 - w[low - 1];
}

std::array<double, 2> Parts::shared_weights(const Surface& surface, std::size_t p, std::size_t corner) const {
    const std::size_t given = surface.vertices().size();
    if (at(corners[corner]) < given) return weights[corner];
    const Source& source = sources[at(corners[corner]) - given];
    const std::int32_t own = list[p].triangle;
    if (list[source.part].triangle == own) return weights[source.corner];
    const Surface::Triangle& triangle = surface.triangles()[at(own)];
    std::size_t low = corner_of(std::min(before(p, corner), sides[corner])), high = (low + 1) % 3;
    if (triangle.vertex[low] > triangle.vertex[high]) std::swap(low, high);
    const double share = share_on_edge(surface, source);
    std::array<double, 3> of{};
    of[low] = 1 - share;
    of[high] = share;
    return {of[1], of[2]};
}

Parts find_parts(const Surface& surface, SurfaceWant want, ThreadPool& pool) {
    return Distribution(surface, want, pool).make();
}

void find_areas(const Surface& surface, ThreadPool& pool, std::vector<double>& areas, std::vector<double>& borders) {
    Distribution(surface, SurfaceWant::areas, pool).sum(areas, borders);
}

void number_corners(Parts& parts, const Surface& surface, ThreadPool& pool) {
    Numbering(parts, surface, pool).number();
}

}  // namespace votess::surface

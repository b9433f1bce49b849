#include "surface/parts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"

namespace votess::surface {
namespace {

constexpr std::size_t near_count = 20;  // seeds tried first
constexpr std::size_t pairs_per_task = 128, vertices_per_task = 256, seeds_per_task = 256, triangles_per_task = 1024;

// A triangle and a seed, in the order of parts.
using Pair = std::uint64_t;
Pair pair_of(std::int32_t triangle, std::int32_t seed) {
    return static_cast<Pair>(triangle) << 32 | static_cast<std::uint32_t>(seed);
}
std::int32_t triangle_of(Pair pair) {
    return static_cast<std::int32_t>(pair >> 32);
}
std::int32_t seed_of(Pair pair) {
    return static_cast<std::int32_t>(pair & 0xffffffff);
}

// Finds the seed whose cell holds a place.
class Owner {
public:
    explicit Owner(const Surface& surface) : surface_(surface) {}

    [[nodiscard]] std::int32_t of(const exact::Point& x) {
        double least = std::numeric_limits<double>::infinity();
        seen_.clear();
        const auto skip = [&](const SeedTree::Node& node, double square) {
            const double weight = surface_.has_weights() ? node.weight : 0;
            return square - weight - rounding * (square + std::abs(weight)) > least;
        };
        surface_.tree().visit_from(x, skip, [&](std::int32_t id, const exact::Point& place) {
            const Vector3 d = minus(place, x);
            const double square = dot(d, d), weight = surface_.weight(id), power = square - weight;
            const double error = rounding * (square + std::abs(weight));
            if (power - error > least) return;
            least = std::min(least, power + error);
            seen_.push_back({power - error, id});
        });
        std::int32_t best = -1;
        for (const auto& [lower, id] : seen_)
            if (lower <= least && (best < 0 || is_nearer(id, best, x))) best = id;
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
    std::vector<std::pair<double, std::int32_t>> seen_;
};

// Parts of some pairs, in their order.
struct Chunk {
    std::vector<std::uint8_t> without_area;
    std::vector<std::uint32_t> sizes;
    std::vector<Side> sides;
    std::vector<std::uint8_t> without_length;
    std::vector<std::array<double, 2>> places;
    std::vector<std::uint32_t> place_counts;  // by part
    std::vector<Pair> next;
};

// Returns whether a part has the place of the corner between two sides.
bool has_place(const Surface& surface, std::int32_t triangle, std::int32_t seed, Side in, Side out) {
    if (in < 0 && out < 0) return false;
    if (in >= 0 && out >= 0) return seed < in && seed < out;
    const std::int32_t edge = surface.triangles()[at(triangle)].edge[corner_of(std::min(in, out))];
    return seed < std::max(in, out) && surface.edges()[at(edge)].first == triangle;
}

class Distribution {
public:
    Distribution(const Surface& surface, ThreadPool& pool)
        : surface_(surface), pool_(pool), near_at_(surface.seeds(), unknown) {
        for (unsigned i = 0; i < pool.size(); ++i) workers_.push_back(std::make_unique<ClippedTriangle>(surface));
    }

    [[nodiscard]] Parts make() {
        std::vector<Pair> pairs = first_pairs(), last;
        while (!pairs.empty()) {
            find_near(pairs);
            std::vector<Pair> next = clip(pairs), fresh, fresher;
            std::ranges::sort(next);
            next.erase(std::unique(next.begin(), next.end()), next.end());
            // Beyond a side lies a part of the round before, this one or the next.
            std::ranges::set_difference(next, pairs, std::back_inserter(fresh));
            std::ranges::set_difference(fresh, last, std::back_inserter(fresher));
            last = std::move(pairs);
            pairs = std::move(fresher);
        }
        return join();
    }

private:
    // The part of each triangle at its first vertex.
    [[nodiscard]] std::vector<Pair> first_pairs() {
        const auto& triangles = surface_.triangles();
        std::vector<std::int32_t> owner(surface_.vertices().size(), -1);
        for (const auto& triangle : triangles)
            if (triangle.area > 0) owner[at(triangle.vertex[0])] = 0;
        pool_.run_stage(ceil_div(owner.size(), vertices_per_task), [&](std::size_t index, unsigned) {
            check_stop();
            Owner find(surface_);
            for (std::size_t v = index * vertices_per_task; v < std::min(owner.size(), (index + 1) * vertices_per_task);
                 ++v)
                if (owner[v] == 0) owner[v] = find.of(surface_.vertices()[v]);
        });
        std::vector<Pair> pairs;
        for (std::size_t t = 0; t < triangles.size(); ++t)
            if (triangles[t].area > 0)
                pairs.push_back(pair_of(static_cast<std::int32_t>(t), owner[at(triangles[t].vertex[0])]));
        return pairs;
    }

    // Finds the nearest seeds of those that are new.
    void find_near(const std::vector<Pair>& pairs) {
        std::size_t fresh = 0;
        for (const Pair pair : pairs) {
            std::int64_t& at_seed = near_at_[at(seed_of(pair))];
            if (at_seed == unknown) at_seed = wanted, ++fresh;
        }
        if (fresh == 0) return;
        std::vector<std::int32_t> seeds;  // in the order of the tree, because near ones need the same memory
        if (fresh < surface_.seeds() / 64) {
            for (const Pair pair : pairs)
                if (std::int64_t& at_seed = near_at_[at(seed_of(pair))]; at_seed == wanted)
                    at_seed = listed, seeds.push_back(seed_of(pair));
        } else {
            for (const std::int32_t seed : surface_.tree().order())
                if (near_at_[at(seed)] == wanted) seeds.push_back(seed);
        }
        const std::size_t count = std::min(near_count, surface_.tree().size() - 1), before = near_.size();
        near_.resize(before + count * seeds.size());
        for (std::size_t i = 0; i < seeds.size(); ++i)
            near_at_[at(seeds[i])] = static_cast<std::int64_t>(before + count * i);
        pool_.run(ceil_div(seeds.size(), seeds_per_task), [&](std::size_t index, unsigned) {
            check_stop();
            std::vector<std::pair<double, std::int32_t>> heap;
            for (std::size_t i = index * seeds_per_task; i < std::min(seeds.size(), (index + 1) * seeds_per_task);
                 ++i) {
                const exact::Point& x = surface_.seed(seeds[i]);
                heap.clear();
                const auto skip = [&](const SeedTree::Node&, double square) {
                    return count == 0 || (heap.size() == count && square > heap.front().first);
                };
                surface_.tree().visit_from(x, skip, [&](std::int32_t id, const exact::Point& place) {
                    const Vector3 d = minus(place, x);
                    const std::pair entry(dot(d, d), id);
                    if (id == seeds[i] || (heap.size() == count && !(entry < heap.front()))) return;
                    if (heap.size() == count) {
                        std::ranges::pop_heap(heap);
                        heap.pop_back();
                    }
                    heap.push_back(entry);
                    std::ranges::push_heap(heap);
                });
                std::ranges::sort_heap(heap);
                for (std::size_t k = 0; k < count; ++k) near_[before + count * i + k] = heap[k].second;
            }
        });
    }

    // Clips a round, and returns what lies beyond the sides.
    [[nodiscard]] std::vector<Pair> clip(const std::vector<Pair>& pairs) {
        const std::size_t first = chunks_.size(), count = std::min(near_count, surface_.tree().size() - 1);
        chunks_.resize(first + ceil_div(pairs.size(), pairs_per_task));
        pool_.run(chunks_.size() - first, [&](std::size_t index, unsigned worker) {
            Chunk& chunk = chunks_[first + index];
            ClippedTriangle& part = *workers_[worker];
            const std::size_t begin = index * pairs_per_task, end = std::min(pairs.size(), begin + pairs_per_task);
            for (std::size_t k = begin; k < end; ++k) {
                check_stop();
                const std::int32_t triangle = triangle_of(pairs[k]), seed = seed_of(pairs[k]);
                const std::int32_t* const near = near_.data() + near_at_[at(seed)];
                if (!part.clip(triangle, seed, {near, count}))
                    throw Error(ErrorCode::internal,
                                "a triangle of a surface has no part beyond a bisector that cuts it");
                part.find_ties();
                add(part, triangle, seed, chunk);
            }
        });
        std::vector<Pair> next;
        for (std::size_t c = first; c < chunks_.size(); ++c) {
            next.insert(next.end(), chunks_[c].next.begin(), chunks_[c].next.end());
            chunks_[c].next = {};
        }
        for (std::size_t k = 0; k < pairs.size(); ++k)
            order_.push_back({pairs[k], static_cast<std::uint32_t>(first + k / pairs_per_task)});
        return next;
    }

    void add(const ClippedTriangle& part, std::int32_t triangle, std::int32_t seed, Chunk& chunk) const {
        std::uint32_t places = 0;
        for (std::size_t i = 0; i < part.size(); ++i) {
            const Side in = part.side(i == 0 ? part.size() - 1 : i - 1), out = part.side(i);
            chunk.sides.push_back(out);
            chunk.without_length.push_back(part.has_length(i) ? 0 : 1);
            if (out >= 0) chunk.next.push_back(pair_of(triangle, out));
            if (!has_place(surface_, triangle, seed, in, out)) continue;
            chunk.places.push_back(part.place(i));
            ++places;
        }
        chunk.sizes.push_back(static_cast<std::uint32_t>(part.size()));
        chunk.place_counts.push_back(places);
        chunk.without_area.push_back(part.has_area() ? 0 : 1);
    }

    // Puts all parts in order, and numbers the vertices.
    [[nodiscard]] Parts join() {
        // Where each part lies in its chunk.
        struct Source {
            Pair pair;
            std::uint32_t chunk, part;
            std::size_t side, place;
        };
        std::vector<Source> sources;
        sources.reserve(order_.size());
        for (std::size_t k = 0; k < order_.size(); ++k) {
            const auto [pair, chunk] = order_[k];
            Source source{pair, chunk, 0, 0, 0};
            if (k > 0 && order_[k - 1].second == chunk) {
                const Source& before = sources.back();
                const Chunk& from = chunks_[chunk];
                source = {pair, chunk, before.part + 1, before.side + from.sizes[before.part],
                          before.place + from.place_counts[before.part]};
            }
            sources.push_back(source);
        }
        order_ = {};
        check_stop();
        std::ranges::sort(sources, {}, &Source::pair);
        Parts parts;
        parts.of_triangle.assign(surface_.triangles().size() + 1, 0);
        parts.offsets.assign(1, 0);
        std::vector<std::size_t> first_place{surface_.vertices().size()};
        for (const Source& source : sources) {
            const Chunk& from = chunks_[source.chunk];
            const auto size = from.sizes[source.part], places = from.place_counts[source.part];
            parts.triangles.push_back(triangle_of(source.pair));
            parts.seeds.push_back(seed_of(source.pair));
            parts.without_area.push_back(from.without_area[source.part]);
            const auto copy = [](const auto& list, std::size_t begin, std::size_t count, auto& to) {
                to.insert(to.end(), list.begin() + static_cast<std::ptrdiff_t>(begin),
                          list.begin() + static_cast<std::ptrdiff_t>(begin + count));
            };
            copy(from.sides, source.side, size, parts.sides);
            copy(from.without_length, source.side, size, parts.without_length);
            copy(from.places, source.place, places, parts.places);
            parts.offsets.push_back(static_cast<std::int64_t>(parts.sides.size()));
            first_place.push_back(first_place.back() + places);
            parts.of_triangle[at(parts.triangles.back()) + 1] = parts.size();
        }
        chunks_ = {};
        for (std::size_t t = 1; t < parts.of_triangle.size(); ++t)
            parts.of_triangle[t] = std::max(parts.of_triangle[t], parts.of_triangle[t - 1]);
        if (first_place.back() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
            throw Error(ErrorCode::invalid_argument, "the cells cut the surface into more than 2147483647 vertices");
        number_corners(parts, first_place);
        return parts;
    }

    void number_corners(Parts& parts, const std::vector<std::size_t>& first_place) const {
        parts.corners.resize(parts.sides.size());
        const auto for_each = [&](const auto& visit) {
            pool_.run(ceil_div(parts.size(), triangles_per_task), [&](std::size_t index, unsigned) {
                check_stop();
                for (std::size_t p = index * triangles_per_task;
                     p < std::min(parts.size(), (index + 1) * triangles_per_task); ++p)
                    visit(p);
            });
        };
        for_each([&](std::size_t p) {
            std::size_t place = first_place[p];
            for (std::size_t c = parts.begin(p); c < parts.end(p); ++c) {
                const Side in = parts.before(p, c), out = parts.sides[c];
                if (in < 0 && out < 0)
                    parts.corners[c] = surface_.triangles()[at(parts.triangles[p])].vertex[corner_of(out)];
                else if (has_place(surface_, parts.triangles[p], parts.seeds[p], in, out))
                    parts.corners[c] = static_cast<std::int32_t>(place++);
                else
                    parts.corners[c] = -1;
            }
        });
        for_each([&](std::size_t p) {
            for (std::size_t c = parts.begin(p); c < parts.end(p); ++c)
                if (parts.corners[c] < 0) parts.corners[c] = corner_elsewhere(parts, p, c);
        });
    }

    // Returns the vertex of a corner from the part that has its place.
    [[nodiscard]] std::int32_t corner_elsewhere(const Parts& parts, std::size_t p, std::size_t c) const {
        const Side in = parts.before(p, c), out = parts.sides[c];
        const std::int32_t seed = parts.seeds[p], triangle = parts.triangles[p];
        if (in >= 0 && out >= 0) {
            const std::int32_t lowest = std::min({seed, in, out});
            const std::size_t q = parts.find(triangle, lowest);
            // Around the corner the cells follow in one order.
            const Side from = lowest == in ? out : seed, to = lowest == in ? seed : in;
            for (std::size_t d = parts.begin(q); d < parts.end(q); ++d)
                if (parts.before(q, d) == from && parts.sides[d] == to) return parts.corners[d];
        } else {
            const std::int32_t other = std::max(in, out), lowest = std::min(seed, other),
                               higher = std::max(seed, other);
            const std::int32_t edge = surface_.triangles()[at(triangle)].edge[corner_of(std::min(in, out))];
            const std::int32_t first = surface_.edges()[at(edge)].first;
            const auto& edges = surface_.triangles()[at(first)].edge;
            const auto is_edge = [&](Side side) { return side < 0 && edges[corner_of(side)] == edge; };
            const std::size_t q = parts.find(first, lowest);
            for (std::size_t d = parts.begin(q); d < parts.end(q); ++d) {
                const Side a = parts.before(q, d), b = parts.sides[d];
                if ((a == higher && is_edge(b)) || (b == higher && is_edge(a))) return parts.corners[d];
            }
        }
        throw Error(ErrorCode::internal, "parts of a surface do not meet where three cells do");
    }

    const Surface& surface_;
    ThreadPool& pool_;
    std::vector<std::unique_ptr<ClippedTriangle>> workers_;
    static constexpr std::int64_t unknown = -1, wanted = -2, listed = -3;
    std::vector<std::int64_t> near_at_;  // by seed: offset into near_, if it is known
    std::vector<std::int32_t> near_;
    std::vector<Chunk> chunks_;
    std::vector<std::pair<Pair, std::uint32_t>> order_;  // of chunks: pairs, and their chunk
};

}  // namespace

std::size_t Parts::find(std::int32_t triangle, std::int32_t seed) const {
    const auto begin = seeds.begin() + static_cast<std::ptrdiff_t>(of_triangle[at(triangle)]);
    const auto end = seeds.begin() + static_cast<std::ptrdiff_t>(of_triangle[at(triangle) + 1]);
    const auto found = std::lower_bound(begin, end, seed);
    if (found == end || *found != seed)
        throw Error(ErrorCode::internal, "a part of a surface is missing beside another");
    return static_cast<std::size_t>(found - seeds.begin());
}

Parts find_parts(const Surface& surface, ThreadPool& pool) {
    return Distribution(surface, pool).make();
}

}  // namespace votess::surface

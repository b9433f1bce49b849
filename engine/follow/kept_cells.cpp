#include "follow/kept_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/arithmetic.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t task_seeds = 4096, chunk_bytes = std::size_t{1} << 20;
constexpr std::size_t min_tested = 512, min_sample = 32, sample_share = 64, max_sample = 4096;
// Shares of cells, from which on a fresh call is faster: of the sample, and of all pending ones.
constexpr double max_wrong = 0.04, max_pending = 0.2;
// The order gets worse as seeds move. After so many times the number of seeds, they are sorted again.
constexpr std::size_t made_until_sort = 16;
constexpr int max_shift = 2;  // of neighbors whose signs are tested

double determinant(const double* a, const double* b, const double* c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

}  // namespace

bool KeptCells::follows(const Job& job) {
    const Domain& domain = *job.domain;
    // Vertices are where the first cell of a stretch finds them.
    const bool plain = !job.want.vertices && !job.only && !job.probes_of && job.row_order.empty();
    return plain && job.outside.empty() && job.beyond.empty() && !domain.triclinic && domain.walls.empty() &&
           job.points.count() > 0;
}

void KeptCells::clear() {
    complete_ = sampled_ = false;
    count_ = 0;
    order_ = {};
    cells_ = {};
    workers_.clear();
    state_.reset();
    always_.reset();
    places_ = {};
}

void KeptCells::set_frame(const Job& job) {
    const Domain& domain = *job.domain;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    frame_ = {};
    frame_.places = places_.data();
    frame_.weighted = domain.has_weights();
    double largest = 0, longest = 0, shortest = infinity;
    for (std::size_t k = 0; k < 3; ++k) {
        frame_.lower[k] = domain.box.lower[k];
        frame_.upper[k] = domain.box.upper[k];
        const double side = frame_.upper[k] - frame_.lower[k];
        constexpr double share[3] = {0.5123456789, 0.4876543211, 0.5031415926};  // no place of a lattice
        frame_.point[k] = frame_.lower[k] + share[k] * side;
        largest = std::max({largest, std::abs(frame_.lower[k]), std::abs(frame_.upper[k])});
        longest = std::max(longest, side);
        if (!domain.periodic[k]) continue;
        frame_.vector[k][k] = frame_.period[k] = side;
        shortest = std::min(shortest, side);
    }
    frame_.reach_squared = infinity;
    if (!domain.is_periodic()) return;
    constexpr double u = 0x1p-53;
    frame_.slack = 32 * u * (largest + 2 * longest);
    // The distances of a corner from its seeds differ by their weights.
    const double heavier = domain.has_weights() ? domain.largest_weight - domain.min_weight : 0;
    frame_.reach_squared = (0.25 * shortest * shortest - heavier) * (1 - 0x1p-20);
}

// Places of the sample only; wrapped to rounding, which is enough for an estimate.
KeptCells::Plan KeptCells::plan(const Job& job, std::string_view instructions) {
    const Domain& domain = *job.domain;
    test_ = sign_tester(instructions);
    const std::size_t count = job.points.count();
    if (count != count_ || domain.periodic != periodic_ || !(complete_ || sampled_)) return Plan::record;
    if (complete_ && made_ > made_until_sort * count_) return Plan::record;
    set_frame(job);
    if (!(frame_.reach_squared > 0)) return Plan::none;
    const auto place = [&](std::size_t s) {
        const auto i = static_cast<std::size_t>(order_[s]);
        SeedPlace& at = places_[s];
        for (std::size_t k = 0; k < 3; ++k) {
            at.x[k] = job.points[3 * i + k] * job.scale;
            if (const double period = frame_.period[k]; period > 0)
                at.x[k] -= period * std::floor((at.x[k] - frame_.lower[k]) / period);
        }
        at.weight = frame_.weighted ? domain.weights[i] : 0;
    };
    std::size_t tested = 0, wrong = 0;
    auto signs = std::make_unique<SignTest>();
    // There is no need to build more than the sample, but all stored cells can be tested.
    const std::size_t step =
        complete_ ? std::min(sample_step_, std::max<std::size_t>(1, count / min_tested)) : sample_step_;
    for (std::size_t begin = 0; begin < count; begin += sample_block * step)
        for (std::size_t s = begin; s < std::min(count, begin + sample_block); ++s) {
            ++tested;
            const KeptCell cell = this->cell(s);
            if (!cell.exists() || cell.head().tied) {
                ++wrong;
                continue;
            }
            place(s);
            for (const std::int32_t id : cell.ids())
                if (id >= 0) place(static_cast<std::size_t>(id));
            wrong += test_(frame_, s, cell, *signs) ? 0 : 1;
        }
    const double expected = max_wrong * static_cast<double>(tested);
    if (static_cast<double>(wrong) > expected + std::sqrt(expected)) return Plan::sample;  // not by chance
    return complete_ ? Plan::repair : Plan::record;
}

void KeptCells::begin(Plan plan, const Job& job, const SortedSeeds& seeds, ThreadPool& pool) {
    plan_ = plan;
    complete_ = sampled_ = false;  // until commit()
    workers_.resize(std::max<std::size_t>(workers_.size(), pool.size()));
    for (Worker& worker : workers_) worker.over_point.clear();
    if (plan == Plan::repair) {
        set_frame(job);
        pool.run(ceil_div(count_, task_seeds), [&](std::size_t task, unsigned) {
            for (std::size_t s = task * task_seeds; s < std::min(count_, (task + 1) * task_seeds); ++s) {
                places_[s] = {{seeds.x[s], seeds.y[s], seeds.z[s]}, frame_.weighted ? seeds.weights[s] : 0};
                state_[s].store(kept, std::memory_order_relaxed);
            }
        });
        return;
    }
    if (count_ != seeds.size()) {
        count_ = seeds.size();
        state_ = std::make_unique<std::atomic<std::uint8_t>[]>(count_);
        always_ = std::make_unique<std::atomic<std::uint8_t>[]>(count_);
    }
    periodic_ = job.domain->periodic;
    made_ = 0;
    const std::size_t sample = std::clamp(count_ / sample_share, min_sample, max_sample);
    sample_step_ = std::max<std::size_t>(1, count_ / sample);
    order_.resize_uninitialized(count_);
    places_.resize_uninitialized(count_);
    cells_.assign(count_, nullptr);
    for (Worker& worker : workers_) worker.chunk = worker.used = 0;
    pool.run(ceil_div(count_, task_seeds), [&](std::size_t task, unsigned) {
        for (std::size_t s = task * task_seeds; s < std::min(count_, (task + 1) * task_seeds); ++s) {
            order_[s] = seeds.input[s];
            state_[s].store(made, std::memory_order_relaxed);
            always_[s].store(0, std::memory_order_relaxed);
        }
    });
}

void KeptCells::commit() {
    complete_ = plan_ != Plan::sample;
    sampled_ = !complete_;
}

std::byte* KeptCells::allocate(std::size_t bytes, Worker& worker) {
    if (worker.chunk < worker.chunks.size() && worker.used + bytes > chunk_bytes) {
        ++worker.chunk;
        worker.used = 0;
    }
    if (worker.chunk == worker.chunks.size())
        worker.chunks.push_back(std::make_unique_for_overwrite<std::byte[]>(chunk_bytes));
    std::byte* const at = worker.chunks[worker.chunk].get() + worker.used;
    worker.used += bytes;
    return at;
}

void KeptCells::store(unsigned index, std::size_t seed, std::span<const std::int32_t> ids,
                      std::span<const exact::Shift> shifts, std::span<const std::uint32_t> ranks,
                      const CellShape& shape, bool tied) {
    Worker& worker = workers_[index];
    const auto faces = ids.size(), corners = static_cast<std::size_t>(shape.corners);
    if (shape.corners > CellShape::max_corners) return store_large(seed, ids);
    KeptCell::Head head{0, static_cast<std::uint8_t>(faces), static_cast<std::uint8_t>(corners), 0, 0, false, tied};
    for (const exact::Shift& shift : shifts)
        for (const auto by : shift) {
            head.shifted |= by != 0;
            if (std::abs(by) > max_shift) return store_large(seed, ids);
        }
    std::array<std::int32_t, CellShape::max_planes> id;
    std::array<std::array<std::int8_t, 3>, CellShape::max_planes> by;
    for (std::size_t f = 0; f < faces; ++f) {
        id[ranks[f]] = ids[f];
        if (head.shifted)
            for (std::size_t j = 0; j < 3; ++j) by[ranks[f]][j] = static_cast<std::int8_t>(shifts[f][j]);
    }
    // A sign belongs to the lowest seed around it.
    std::array<bool, CellShape::max_planes> later;
    for (std::size_t f = 0; f < faces; ++f) later[f] = id[f] < 0 || id[f] >= static_cast<std::int32_t>(seed);
    std::array<KeptCell::Corner, CellShape::max_corners> corner;
    auto& corner_of = worker.corner_of;
    bool turned = false;  // the corners of a clipped cell may be clockwise
    for (std::size_t v = 0; v < corners; ++v) {
        auto a = shape.rank[shape.a[v]], b = shape.rank[shape.b[v]], c = shape.rank[shape.c[v]];
        if (v == 0) turned = determinant(shape.plane[a].n, shape.plane[b].n, shape.plane[c].n) < 0;
        if (turned) std::swap(b, c);
        corner[v] = {a, b, c};
        corner_of[a][b] = corner_of[b][c] = corner_of[c][a] = static_cast<std::uint8_t>(v);
    }
    std::array<std::uint8_t, CellShape::max_corners> number;  // among the used ones
    constexpr std::uint8_t unused = 255;
    std::array<std::uint8_t, CellShape::max_corners> order;
    number.fill(unused);
    std::size_t used = 0, tests = 0;
    const auto use = [&](std::size_t v) {
        if (number[v] == unused) order[number[v] = static_cast<std::uint8_t>(used++)] = static_cast<std::uint8_t>(v);
        return number[v];
    };
    for (std::size_t v = 0; v < corners; ++v)
        if (const auto& [a, b, c] = corner[v]; later[a] && later[b] && later[c]) use(v);
    std::array<KeptCell::Test, SignTest::max_tests> test;
    for (std::size_t v = 0; v < corners && !head.tied; ++v)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint8_t a = corner[v][k], b = corner[v][(k + 1) % 3];
            const std::size_t w = corner_of[b][a];
            std::size_t third = CellShape::max_planes;
            for (std::size_t j = 0; w < corners && j < 3; ++j)
                if (corner[w][j] == b && corner[w][(j + 1) % 3] == a) third = corner[w][(j + 2) % 3];
            head.tied |= third == CellShape::max_planes || tests == test.size();  // not a simple polytope
            if (head.tied) break;
            if (w < v || !later[a] || !later[b]) continue;
            // From either end; the corner that is used anyway.
            const std::uint8_t end = corner[v][(k + 2) % 3];
            test[tests++] = number[v] == unused && number[w] != unused
                                ? KeptCell::Test{use(w), end}
                                : KeptCell::Test{use(v), static_cast<std::uint8_t>(third)};
        }
    if (head.tied) tests = 0;
    head.used = static_cast<std::uint8_t>(used);
    head.tests = static_cast<std::uint8_t>(tests);
    for (std::size_t v = 0, next = used; v < corners; ++v)
        if (number[v] == unused) order[next++] = static_cast<std::uint8_t>(v);

    alignas(8) std::byte scratch[sizeof(KeptCell::Head) + 7 * CellShape::max_planes + 3 * CellShape::max_corners +
                                 2 * SignTest::max_tests + 8];
    const std::size_t bytes = round_up(KeptCell::bytes(head), 8);
    std::byte* to = scratch;
    const auto put = [&](const void* from, std::size_t size) {
        std::memcpy(to, from, size);
        to += size;
    };
    std::byte*& at = cells_[seed];
    const std::size_t room = at == nullptr ? 0 : 8 * std::size_t{KeptCell(at).head().room};
    head.room = static_cast<std::uint16_t>((room >= bytes ? room : bytes) / 8);
    put(&head, sizeof head);
    put(id.data(), 4 * faces);
    if (head.shifted) put(by.data(), 3 * faces);
    for (std::size_t v = 0; v < corners; ++v) put(&corner[order[v]], sizeof(KeptCell::Corner));
    put(test.data(), 2 * tests);
    if (plan_ == Plan::repair) {
        const KeptCell now(scratch);
        mark_changes(KeptCell(at), now, worker);
        if (head.tied)
            for (const std::int32_t other : now.ids()) mark(other);
        // A kept cell may have corners that only this cell compares with half a period.
        if (!head.tied && frame_.reach_squared < std::numeric_limits<double>::infinity() &&
            !test_(frame_, seed, now, worker.signs))
            mark_wrong(now, seed, worker.signs);
    }
    if (room < bytes) at = allocate(bytes, worker);
    std::memcpy(at, scratch, bytes);
}

void KeptCells::store_large(std::size_t seed, std::span<const std::int32_t> ids) {
    if (plan_ == Plan::repair && cells_[seed] != nullptr) {
        const KeptCell before(cells_[seed]);
        for (const std::int32_t id : before.ids()) mark(id);
    }
    cells_[seed] = nullptr;
    for (const std::int32_t id : ids) {
        if (id < 0) continue;
        mark(id);
        always_[static_cast<std::size_t>(id)].store(1, std::memory_order_relaxed);
    }
}

void KeptCells::store_none(std::size_t seed) {
    store_large(seed, {});
}

void KeptCells::mark_around(const KeptCell& cell, const KeptCell::Corner& corner) {
    for (const std::uint8_t f : corner) mark(cell.ids()[f]);
}

void KeptCells::mark_wrong(const KeptCell& cell, std::size_t seed, const SignTest& signs) {
    const KeptCell::Head& head = cell.head();
    const auto corners = cell.corners();
    const auto tests = cell.tests();
    mark(static_cast<std::int32_t>(seed));
    if (!signs.tested) {
        for (const std::int32_t id : cell.ids()) mark(id);
        return;
    }
    for (std::size_t v = 0; v < head.used; ++v)
        if (!(signs.corner_margin[v] > 0)) mark_around(cell, corners[v]);
    for (std::size_t t = 0; t < head.tests; ++t)
        if (!(signs.test_margin[t] > 0)) {
            mark_around(cell, corners[tests[t].corner]);
            mark(cell.ids()[tests[t].plane]);
        }
}

// Marks the cells around each corner that only one of the two has. A corner that is not found counts as one.
void KeptCells::mark_changes(const KeptCell& before, const KeptCell& now, Worker& worker) {
    if (!before.exists()) {
        for (const std::int32_t id : now.ids()) mark(id);
        return;
    }
    constexpr std::size_t none = CellShape::max_planes;
    std::array<std::size_t, CellShape::max_planes> old_face;
    const std::size_t faces = before.faces();
    for (std::size_t f = 0, hint = 0; f < now.faces(); ++f) {
        old_face[f] = none;
        for (std::size_t k = 0; k < faces && old_face[f] == none; ++k) {
            const std::size_t g = hint + k < faces ? hint + k : hint + k - faces;
            if (before.ids()[g] == now.ids()[f] && before.shift(g) == now.shift(f)) old_face[f] = g;
        }
        if (old_face[f] != none) hint = old_face[f] + 1 < faces ? old_face[f] + 1 : 0;
    }
    auto& corner_of = worker.corner_of;
    const auto old = before.corners();
    for (std::size_t v = 0; v < old.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k) corner_of[old[v][k]][old[v][(k + 1) % 3]] = static_cast<std::uint8_t>(v);
    std::array<bool, CellShape::max_corners> found{};
    for (const KeptCell::Corner& corner : now.corners()) {
        const std::size_t a = old_face[corner[0]], b = old_face[corner[1]], c = old_face[corner[2]];
        bool same = false;
        if (a != none && b != none && c != none) {
            const std::size_t v = corner_of[a][b];
            for (std::size_t k = 0; v < old.size() && k < 3 && !same; ++k)
                same = old[v][k] == a && old[v][(k + 1) % 3] == b && old[v][(k + 2) % 3] == c;
            if (same) found[v] = true;
        }
        if (!same) mark_around(now, corner);
    }
    for (std::size_t v = 0; v < old.size(); ++v)
        if (!found[v]) mark_around(before, old[v]);
}

void KeptCells::test(ThreadPool& pool) {
    const auto task = [&](std::size_t begin, std::size_t end, Worker& worker) {
        for (std::size_t s = begin; s < end; ++s) {
            if (state_[s].load(std::memory_order_relaxed) != kept) continue;
            const KeptCell cell = this->cell(s);
            if (!cell.exists() || cell.head().tied || always_[s].load(std::memory_order_relaxed) != 0) {
                mark(static_cast<std::int32_t>(s));
                continue;
            }
            if (!test_(frame_, s, cell, worker.signs))
                mark_wrong(cell, s, worker.signs);
            else if (worker.signs.may_hold)
                worker.over_point.push_back(s);
        }
    };
    pool.run(ceil_div(count_, task_seeds), [&](std::size_t index, unsigned worker) {
        task(index * task_seeds, std::min(count_, (index + 1) * task_seeds), workers_[worker]);
    });
    // What large cells of this call are next to is not known yet.
    for (std::size_t s = 0; s < count_; ++s) always_[s].store(0, std::memory_order_relaxed);
}

void KeptCells::take_pending(std::vector<std::int32_t>& out) {
    out.clear();
    for (std::size_t s = 0; s < count_; ++s) {
        if (state_[s].load(std::memory_order_relaxed) != pending) continue;
        state_[s].store(made, std::memory_order_relaxed);
        out.push_back(static_cast<std::int32_t>(s));
    }
    made_ += out.size();
}

bool KeptCells::pays(std::size_t pending) const {
    return static_cast<double>(pending) <= max_pending * static_cast<double>(count_);
}

// Seeds that share a bucket are compared.
bool KeptCells::any_equal() const {
    const std::size_t buckets = std::bit_ceil(16 * count_);
    const auto bucket = [&](const SeedPlace& at) {
        std::uint64_t hash = 0;
        for (const double x : at.x)
            hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15u, hash ^= hash >> 32;
        return hash & (buckets - 1);
    };
    std::vector<std::uint64_t> met(ceil_div(buckets, 64)), shared(met.size());
    const auto bit = [](std::uint64_t b) { return std::uint64_t{1} << b % 64; };
    for (std::size_t s = 0; s < count_; ++s) {
        const std::uint64_t b = bucket(places_[s]);
        shared[b / 64] |= met[b / 64] & bit(b);
        met[b / 64] |= bit(b);
    }
    std::vector<std::array<double, 3>> doubtful;
    for (std::size_t s = 0; s < count_; ++s)
        if (const std::uint64_t b = bucket(places_[s]); (shared[b / 64] & bit(b)) != 0)
            doubtful.push_back({places_[s].x[0], places_[s].x[1], places_[s].x[2]});
    std::ranges::sort(doubtful);
    return std::ranges::adjacent_find(doubtful) != doubtful.end();
}

std::array<double, 3> KeptCells::way_to_point(const SeedPlace& from) const {
    std::array<double, 3> way;
    for (std::size_t k = 0; k < 3; ++k) {
        way[k] = frame_.point[k] - from.x[k];
        if (const double period = frame_.period[k]; period > 0) way[k] -= period * std::round(way[k] / period);
    }
    return way;
}

// Made cells are right, so none of them is over the point if a kept one is and has less power there than all their
// seeds.
bool KeptCells::covers_once() const {
    std::vector<std::size_t> over;
    for (const Worker& worker : workers_)
        for (const std::size_t s : worker.over_point)
            if (is_kept(s)) over.push_back(s);
    if (over.size() > 1) return false;
    const auto power = [&](std::size_t s) {
        const auto [x, y, z] = way_to_point(places_[s]);
        return x * x + y * y + z * z - places_[s].weight;
    };
    const double least = over.empty() ? 0 : power(over[0]);
    bool any_made = false;
    for (std::size_t s = 0; s < count_; ++s) {
        if (is_kept(s)) continue;
        any_made = true;
        if (!over.empty() && !(power(s) > least + 0x1p-30 * std::abs(least))) return false;
    }
    return any_made || !over.empty();
}

}  // namespace votess::cpu

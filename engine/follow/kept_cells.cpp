#include "follow/kept_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "follow/hiding_seeds.hpp"
#include "follow/match_seeds.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t task_seeds = 4096, tasks_per_thread = 2, cells_per_check = 4096,
                      chunk_bytes = std::size_t{1} << 20;
constexpr double unit = 0x1p-53;
constexpr std::size_t max_tested = 512, min_sample = 32, sample_share = 256, max_sample = 1024;
// Shares of cells, from which on a fresh call is faster: those of a sample that have wrong signs, those of it that must
// be made again, and all pending ones.
constexpr double max_wrong = 0.2, max_made = 0.04, max_pending = 0.15;
// Seeds without a cell are made again, but not their neighbors: so much costs one of them, in cells with wrong signs.
constexpr double cost_of_hidden = 2;
// Going on costs less than beginning.
constexpr double gain_of_stored = 1.25;
// So much of the limits counts where seeds cross walls, because matching takes a tenth of a fresh call.
constexpr double share_of_matched = 0.5;
// Power cells beside their seeds take several times as long to find.
constexpr double max_wrong_beside = 0.7;
// The order gets worse as seeds move. After so many times the number of seeds, they are sorted again.
constexpr std::size_t made_until_sort = 16;
constexpr std::size_t rows_sample = 64;
constexpr unsigned unmatched_until_record = 16, max_skipped = 4;  // calls
constexpr std::size_t max_flips = 256;                            // for one cell and those that it changes

// Returns the numbers that make a box, and then those of its further walls.
constexpr std::size_t box_numbers = 18;
std::vector<double> numbers_of(const Domain& domain) {
    std::vector<double> numbers;
    const auto add = [&](const std::array<double, 3>& x) { numbers.insert(numbers.end(), x.begin(), x.end()); };
    add(domain.box.lower);
    add(domain.box.upper);
    add(domain.origin);
    for (const auto& vector : domain.vector) add(vector);
    for (const exact::Plane& wall : domain.walls) {
        add(wall.seed);
        numbers.push_back(wall.wall);
    }
    return numbers;
}

bool is_seed(const Job& job, std::size_t row) {
    return row < job.points.count() && (job.outside.empty() || job.outside[row] != CellStatus::outside);
}

double distance_from(const SignWall& wall, const double* x) {
    return wall.offset - (wall.n[0] * x[0] + wall.n[1] * x[1] + wall.n[2] * x[2]);
}

}  // namespace

bool KeptCells::follows(const Job& job) {
    const Domain& domain = *job.domain;
    // Vertices are where the first cell of a stretch finds them.
    const bool plain = !job.want.vertices && !job.only && !job.probes_of && job.row_order.empty();
    return plain && job.beyond.empty() && !domain.skewed && domain.walls.empty() == domain.facets.empty() &&
           job.points.count() > 0;
}

void KeptCells::clear() {
    complete_ = sampled_ = false;
    count_ = 0;
    order_ = {};
    cells_ = {};
    faces_ = {};
    hiding_ = {};
    workers_.clear();
    state_.reset();
    always_.reset();
    places_ = {};
    settled_ = false;
    rows_ = {};
    refusals_ = skipped_ = 0;
}

void KeptCells::set_frame(const Job& job) {
    const Domain& domain = *job.domain;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    frame_ = {};
    frame_.places = places_.data();
    frame_.weighted = domain.has_weights();
    double largest = 0, longest = 0, shortest = infinity;
    for (std::size_t k = 0; k < 3; ++k) {
        largest = std::max({largest, std::abs(domain.box.lower[k]), std::abs(domain.box.upper[k])});
        frame_.point[k] = domain.origin[k];
    }
    for (std::size_t j = 0; j < 3; ++j) {
        constexpr double share[3] = {0.5123456789, 0.4876543211, 0.5031415926};  // no place of a lattice
        const auto& edge = domain.edges.vector[j];
        longest += std::sqrt(edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]);
        for (std::size_t k = 0; k < 3; ++k) {
            frame_.point[k] += share[j] * edge[k];
            if (!domain.periodic[j]) continue;
            frame_.vector[j][k] = edge[k];
            frame_.short_vector[j][k] = domain.reduced.vector[j][k];
            frame_.dual[j][k] = domain.reduced.dual[j][k];
        }
        if (domain.periodic[j]) shortest = std::min(shortest, domain.reduced.width[j]);
    }
    frame_.reach_squared = infinity;
    if (domain.is_periodic()) frame_.slack = 32 * unit * (largest + 2 * longest);
    set_walls(domain, largest);
    if (!domain.is_periodic()) return;
    // The distances of a corner from its seeds differ by their weights.
    const double heavier = domain.has_weights() ? domain.largest_weight - domain.min_weight : 0;
    frame_.reach_squared = (0.25 * shortest * shortest - heavier) * (1 - 0x1p-20);
}

// The rounding errors of n, the offset and the distance are below 16 u of their terms. Within walls the point is
// rounded to floats, because the middle depends on a seed in its last digits.
void KeptCells::set_walls(const Domain& domain, double largest) {
    walls_.clear();
    frame_.wall_error = 0;
    const auto add = [&](const exact::Plane& wall, double sign) {
        SignWall& out = walls_.emplace_back();
        if (!wall.is_oblique()) {
            out.n[wall.axis] = sign;
            out.offset = sign * wall.wall;
            return;
        }
        const bool given = wall.kind == exact::Plane::Kind::wall;
        const exact::Point normal = given ? wall.seed : wall.rounded_normal();
        const double length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        out.offset = given ? wall.wall / length : 0;
        for (std::size_t k = 0; k < 3; ++k) {
            out.n[k] = normal[k] / length;
            if (!given) out.offset += out.n[k] * (wall.seed[k] + wall.shift[wall.axis] * domain.vector[wall.axis][k]);
        }
        const double terms = std::abs(out.offset) + 6 * largest;
        frame_.wall_error = std::max(frame_.wall_error, 16 * unit * terms + 2 * frame_.slack);
    };
    for (int wall = 0; wall < 6; ++wall)
        if (domain.has_box_wall(wall))
            add(domain.box_wall(wall), wall % 2 == 0 ? -1 : 1);
        else
            walls_.emplace_back();
    for (const exact::Plane& wall : domain.walls) add(wall, 1);
    frame_.walls = walls_.data();
    if (domain.walls.empty()) return;
    const auto clearance = [&](const double* x) {
        double least = std::numeric_limits<double>::infinity();
        for (const SignWall& wall : walls_) least = std::min(least, distance_from(wall, x));
        return least;
    };
    constexpr double share[3] = {0.3123456789, -0.2876543211, 0.2031415926};  // no place of a lattice
    const double away = clearance(domain.middle.data());
    for (std::size_t k = 0; k < 3; ++k) frame_.point[k] = static_cast<float>(domain.middle[k] + away * share[k]);
    if (!(clearance(frame_.point) > frame_.wall_error)) frame_.reach_squared = 0;
}

// Wrapped to rounding, which is enough for an estimate.
SeedPlace KeptCells::place_of(const Job& job, std::size_t row) const {
    const Domain& domain = *job.domain;
    exact::Point x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = job.points[3 * row + k] * job.scale;
    const auto fraction = domain.fraction(x);
    SeedPlace at;
    for (std::size_t k = 0; k < 3; ++k) {
        at.x[k] = x[k];
        for (std::size_t j = 0; j < 3; ++j) at.x[k] -= frame_.vector[j][k] * std::floor(fraction[j]);
    }
    at.weight = frame_.weighted ? domain.weights[row] : 0;
    return at;
}

// Whether some seeds of a sample went farther than their nearest neighbor was, as where rows change places.
bool KeptCells::rows_change(const Job& job) const {
    const auto square = [](const std::array<double, 3>& way) {
        return way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    };
    std::size_t tested = 0, far = 0;
    for (std::size_t s = 0; s < count_; s += std::max<std::size_t>(1, count_ / rows_sample)) {
        const KeptCell cell = this->cell(s);
        if (!cell.exists()) continue;
        const double* const before = places_[s].x;
        double nearest = std::numeric_limits<double>::infinity();
        for (const std::int32_t id : cell.ids())
            if (id >= 0)
                nearest =
                    std::min(nearest, square(nearest_way(frame_, before, places_[static_cast<std::size_t>(id)].x)));
        const SeedPlace now = place_of(job, static_cast<std::size_t>(order_[s]));
        far += square(nearest_way(frame_, before, now.x)) > nearest ? 1 : 0;
        ++tested;
    }
    return 16 * far > tested;
}

// Renumbers the stored cells for the points of the job. Returns false, and changes nothing, if these are not like the
// seeds of the last call, or are in the same rows.
bool KeptCells::match(const Job& job, bool same_rows) {
    if (count_ == 0) return false;
    std::vector<std::int32_t> rows;
    for (std::size_t row = 0; row < job.points.count(); ++row)
        if (is_seed(job, row)) rows.push_back(static_cast<std::int32_t>(row));
    const auto matched = match_seeds({cells_, order_, frame_}, rows, same_rows, [&](std::size_t row) {
        const SeedPlace at = place_of(job, row);
        return std::array{at.x[0], at.x[1], at.x[2]};
    });
    if (!matched) return false;
    complete_ = settled_ = false;  // until all is renumbered
    rows_.clear();
    const auto& [order, number] = *matched;
    std::vector<std::byte*> cells(order.size());
    std::vector<std::uint8_t> faces(order.size());
    Buffer<SeedPlace> places(Buffer<SeedPlace>::Pages::huge);
    places.resize_uninitialized(order.size());
    std::ranges::fill(places, SeedPlace{});
    Flags always = std::make_unique<std::atomic<std::uint8_t>[]>(order.size());
    Worker& worker = workers_.front();
    for (std::size_t s = 0; s < count_; ++s) {
        if (number[s] < 0) {
            ++made_;
            continue;
        }
        const auto to = static_cast<std::size_t>(number[s]);
        always[to].store(always_[s].load(std::memory_order_relaxed), std::memory_order_relaxed);
        std::byte* const at = cells[to] = cells_[s];
        faces[to] = faces_[s];
        places[to] = places_[s];
        if (at == nullptr) continue;
        bool sorted = true;
        for (std::int32_t last = KeptCell::no_seed; std::int32_t & id : KeptCell::ids_of(at)) {
            if (id < 0) continue;
            id = number[static_cast<std::size_t>(id)];
            if (id < 0) {
                id = KeptCell::no_seed;
                KeptCell::set_tied(at);
                continue;
            }
            sorted &= last <= order[static_cast<std::size_t>(id)];
            last = order[static_cast<std::size_t>(id)];
        }
        if (sorted || KeptCell(at).head().tied) continue;
        alignas(8) std::byte scratch[LooseCell::max_bytes];
        worker.loose.read(KeptCell(at));
        worker.loose.sort_faces(order);
        const std::size_t room = room_of(at), bytes = worker.loose.pack(room, scratch);
        if (room < bytes) cells[to] = allocate(bytes, worker);
        std::memcpy(cells[to], scratch, bytes);
    }
    made_ += order.size() - static_cast<std::size_t>(std::ranges::count_if(number, [](auto to) { return to >= 0; }));
    cells_ = std::move(cells);
    faces_ = std::move(faces);
    places_ = std::move(places);  // new seeds have none, and no cell
    always_ = std::move(always);
    hiding_.clear();
    count_ = order.size();
    state_ = std::make_unique<std::atomic<std::uint8_t>[]>(count_);
    order_.resize_uninitialized(count_);
    std::ranges::copy(order, order_.begin());
    frame_.places = places_.data();
    complete_ = true;
    return true;
}

bool KeptCells::sample_pays(const Job& job, double factor) {
    std::vector<std::pair<std::size_t, SeedPlace>> before;
    const auto place = [&](std::size_t s) {
        before.emplace_back(s, places_[s]);
        SeedPlace now = place_of(job, static_cast<std::size_t>(order_[s]));
        const auto way = nearest_way(frame_, places_[s].x, now.x);  // see cross()
        for (std::size_t k = 0; k < 3; ++k) now.x[k] = places_[s].x[k] + way[k];
        places_[s] = now;
    };
    std::size_t tested = 0, wrong = 0, made = 0, hidden = 0, beside = 0;
    auto signs = std::make_unique<SignTest>();
    hiding_.resize(count_);
    // There is no need to build more than the sample, but all stored cells can be tested.
    const std::size_t step = complete_ ? std::max<std::size_t>(1, count_ / max_tested) : sample_step_;
    const std::size_t total = std::max(count_ / step, min_sample);
    double cost = 0, expected = 0;
    const auto update = [&] {
        const double share =
            std::lerp(max_wrong, max_wrong_beside, static_cast<double>(beside) / static_cast<double>(tested));
        cost = static_cast<double>(wrong) + static_cast<double>(hidden) * cost_of_hidden +
               static_cast<double>(made) * (share / max_made);
        expected = share * static_cast<double>(total) * (complete_ ? gain_of_stored : 1);
        expected += std::sqrt(expected);  // by chance
    };
    for (std::size_t begin = 0; begin < count_ && cost <= 2 * expected; begin += sample_block * step) {
        for (std::size_t s = begin; s < std::min(count_, begin + sample_block); ++s) {
            ++tested;
            const KeptCell cell = this->cell(s);
            if (frame_.weighted && !cell.exists() && faces_[s] == 0) {
                place(s);
                if (hiding_[s] != nullptr)
                    for (const std::int32_t id : KeptCell(hiding_[s]).ids()) place(static_cast<std::size_t>(id));
                hidden += complete_ && hides(s, workers_.front()) ? 0 : 1;
                continue;
            }
            if (!cell.exists() || cell.head().tied) {
                ++made;
                continue;
            }
            place(s);
            bool lies_beside = false;
            for (const std::int32_t id : cell.ids()) {
                if (id < 0) continue;
                const auto other = static_cast<std::size_t>(id);
                place(other);
                const auto [x, y, z] = nearest_way(frame_, places_[s].x, places_[other].x);
                lies_beside |= x * x + y * y + z * z < places_[other].weight - places_[s].weight;
            }
            beside += lies_beside ? 1 : 0;
            wrong += test_(frame_, s, cell, *signs) ? 0 : 1;
        }
        update();
    }
    for (std::size_t k = before.size(); k > 0; --k) places_[before[k - 1].first] = before[k - 1].second;
    refusals_ = static_cast<double>(wrong) > 2 * expected ? refusals_ + 1 : 0;
    return cost <= factor * expected;
}

KeptCells::Plan KeptCells::plan(const Job& job, std::string_view instructions) {
    test_ = sign_tester(instructions);
    if (job.domain->periodic != periodic_ || !(complete_ || sampled_)) return Plan::record;
    if (complete_ && made_ > made_until_sort * count_) return Plan::record;
    const auto given = numbers_of(*job.domain);
    if (std::max(given.size(), given_.size()) > box_numbers && given != given_) return Plan::sample;
    set_frame(job);
    if (!(frame_.reach_squared > 0)) return Plan::none;
    const auto outside = static_cast<std::size_t>(std::ranges::count(job.outside, CellStatus::outside));
    const bool others = job.points.count() - outside != count_ || !std::ranges::all_of(order_, [&](std::int32_t row) {
                            return is_seed(job, static_cast<std::size_t>(row));
                        });
    if (complete_ && (others || rows_change(job))) {
        const bool cross = others && job.points.count() == points_;  // walls, where they are dropped
        if (cross && !sample_pays(job, share_of_matched)) return Plan::sample;
        if (!match(job, !others) && others) return Plan::sample;
    } else if (others) {
        return ++unmatched_ % unmatched_until_record == 0 ? Plan::record : Plan::sample;
    }
    if (skipped_ > 0 && sampled_) return --skipped_ == 0 ? Plan::sample : Plan::none;
    if (!sample_pays(job)) {
        skipped_ = refusals_ > 1 ? std::min(refusals_ - 1, max_skipped) : 0;
        return skipped_ > 0 ? Plan::none : Plan::sample;
    }
    return complete_ ? Plan::repair : Plan::record;
}

inline KeptCells::Powers KeptCells::powers_of(const SeedPlace& seed) const {
    constexpr auto infinity = std::numeric_limits<float>::infinity();
    double way[3], square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        way[k] = frame_.point[k] - seed.x[k];
        square += way[k] * way[k];
    }
    double tolerance = 0x1p-40 * (square + std::abs(seed.weight));
    if (frame_.slack > 0) {
        tolerance += 8 * frame_.slack * std::sqrt(square);
        for (const auto& d : frame_.dual)
            if (!(std::abs(way[0] * d[0] + way[1] * d[1] + way[2] * d[2]) < 0.49)) return {-infinity, infinity};
    }
    return {static_cast<float>(square - seed.weight - tolerance), static_cast<float>(square - seed.weight + tolerance)};
}

void KeptCells::begin(Plan plan, const Job& job, const SortedSeeds& seeds, ThreadPool& pool) {
    plan_ = plan;
    complete_ = sampled_ = false;  // until commit()
    bool settled = std::exchange(settled_, false);
    if (!settled) over_.clear();
    workers_.resize(std::max<std::size_t>(workers_.size(), pool.size()));
    for (Worker& worker : workers_) {
        worker.crossed.clear();
        worker.over_point.clear();
        worker.later.clear();
        worker.unmended.clear();
    }
    points_ = job.points.count();
    auto given = numbers_of(*job.domain);
    settled = settled && given == given_;
    given_ = std::move(given);
    facets_ = job.domain->facets;
    facet_seeds_.resize(facets_.size());
    std::atomic<bool> any_moves = false;
    const auto for_seeds = [&](const auto& visit) {
        pool.run(ceil_div(count_, task_seeds), [&](std::size_t task, unsigned index) {
            for (std::size_t s = task * task_seeds; s < std::min(count_, (task + 1) * task_seeds); ++s) {
                const SeedPlace now{{seeds.x[s], seeds.y[s], seeds.z[s]}, seeds.weights.empty() ? 0 : seeds.weights[s]};
                visit(s, std::exchange(places_[s], now), index);
            }
        });
    };
    if (plan == Plan::repair) {
        set_frame(job);
        settled = settled && frame_ == settled_frame_;
        still_.resize(count_);
        found_.assign(count_, 0);
        powers_.resize_uninitialized(count_);
        for_seeds([&](std::size_t s, const SeedPlace& before, unsigned index) {
            const bool stays = settled && std::memcmp(&before, &places_[s], sizeof before) == 0;
            double square = 0;
            for (std::size_t k = 0; k < 3; ++k)
                square += (places_[s].x[k] - before.x[k]) * (places_[s].x[k] - before.x[k]);
            if (square > frame_.reach_squared) workers_[index].crossed.emplace_back(s, before);
            const std::uint8_t state = state_[s].exchange(kept, std::memory_order_relaxed);
            still_[s] = static_cast<std::uint8_t>((state == kept ? was_kept : 0) | (stays ? has_stayed : 0));
            powers_[s] = powers_of(places_[s]);
            if (!stays) any_moves.store(true, std::memory_order_relaxed);
        });
        all_stay_ = !any_moves;
        for (Worker& worker : workers_)
            for (const auto& [s, before] : worker.crossed) cross(s, before, *job.domain, worker);
        return;
    }
    settled = false;
    rows_.clear();
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
    faces_.assign(count_, 0);
    hiding_.clear();
    for (Worker& worker : workers_) worker.chunk = worker.used = 0;
    for_seeds([&](std::size_t s, const SeedPlace&, unsigned) {
        order_[s] = seeds.input[s];
        state_[s].store(made, std::memory_order_relaxed);
        always_[s].store(0, std::memory_order_relaxed);
    });
}

void KeptCells::commit() {
    complete_ = plan_ != Plan::sample;
    sampled_ = !complete_;
    settled_ = plan_ == Plan::repair;
    settled_frame_ = frame_;
}

// All cells change alike, so they match as before, wherever the seed is.
void KeptCells::cross(std::size_t seed, const SeedPlace& before, const Domain& domain, Worker& worker) {
    if (!cell(seed).exists()) return;  // and those beside it are pending
    const SeedPlace& now = places_[seed];
    const auto turns = domain.edges.fraction({now.x[0] - before.x[0], now.x[1] - before.x[1], now.x[2] - before.x[2]});
    NearShift by{};
    for (std::size_t j = 0; j < 3; ++j) {
        if (!domain.periodic[j]) continue;
        if (!(std::abs(turns[j]) < 2 * KeptCell::max_shift)) return;  // it jumps, and its signs are wrong
        by[j] = static_cast<std::int8_t>(std::lrint(turns[j]));
    }
    const auto change = [&](std::size_t s, int sign, const auto& is_changed) {
        LooseCell& loose = worker.loose;
        loose.read(cell(s));
        for (std::size_t f = 0; f < loose.faces; ++f) {
            if (loose.id[f] < 0 || !is_changed(loose.id[f])) continue;
            for (std::size_t j = 0; j < 3; ++j) {
                std::int8_t& shift = loose.shift[f][j];
                shift = static_cast<std::int8_t>(shift + sign * by[j]);
                if (std::abs(shift) > KeptCell::max_shift) shift = 0, loose.tied = true;
            }
        }
        put(s, worker);
        found_[s] |= new_faces;
    };
    const auto own = static_cast<std::int32_t>(seed);
    const auto ids = cell(seed).ids();
    const std::vector<std::int32_t> around(ids.begin(), ids.end());
    change(seed, 1, [&](std::int32_t id) { return id != own; });
    for (auto next = around.begin(); next != around.end(); ++next) {
        const std::int32_t id = *next;
        if (id < 0 || id == own || std::find(around.begin(), next, id) != next) continue;
        if (const auto s = static_cast<std::size_t>(id); cell(s).exists())
            change(s, -1, [&](std::int32_t other) { return other == own; });
    }
}

std::size_t KeptCells::room_of(const std::byte* record) {
    return record == nullptr ? 0 : 8 * std::size_t{KeptCell(record).head().room};
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
    for (const exact::Shift& shift : shifts)
        for (const auto by : shift)
            if (std::abs(by) > KeptCell::max_shift) return store_large(seed, ids);
    LooseCell& loose = worker.loose;
    loose.faces = faces;
    loose.corners = corners;
    loose.tied = tied;
    for (std::size_t f = 0; f < faces; ++f) {
        loose.id[ranks[f]] = ids[f];
        NearShift& by = loose.shift[ranks[f]] = {};
        for (std::size_t j = 0; j < 3 && !shifts.empty(); ++j) by[j] = static_cast<std::int8_t>(shifts[f][j]);
    }
    bool turned = false;  // the corners of a clipped cell may be clockwise
    for (std::size_t v = 0; v < corners; ++v) {
        auto a = shape.rank[shape.a[v]], b = shape.rank[shape.b[v]], c = shape.rank[shape.c[v]];
        if (v == 0) turned = determinant(shape.plane[a].n, shape.plane[b].n, shape.plane[c].n) < 0;
        if (turned) std::swap(b, c);
        loose.corner[v] = {a, b, c};
    }
    alignas(8) std::byte scratch[LooseCell::max_bytes];
    std::byte*& at = cells_[seed];
    const std::size_t room = room_of(at), bytes = loose.pack(seed, worker.edges, room, scratch);
    const bool now_tied = KeptCell(scratch).head().tied;
    if (plan_ == Plan::repair) {
        const KeptCell now(scratch);
        mark_changes(KeptCell(at), now, worker);
        if (now_tied)
            for (const std::int32_t other : now.ids()) mark(other);
        // A kept cell may have corners that only this cell compares with half a period.
        if (!now_tied && frame_.reach_squared < std::numeric_limits<double>::infinity() &&
            !test_(frame_, seed, now, worker.signs))
            mark_wrong(now, seed, worker.signs);
    }
    if (room < bytes) at = allocate(bytes, worker);
    std::memcpy(at, scratch, bytes);
    faces_[seed] = KeptCell(at).head().faces;
}

void KeptCells::store_large(std::size_t seed, std::span<const std::int32_t> ids) {
    if (plan_ == Plan::repair && cells_[seed] != nullptr) {
        const KeptCell before(cells_[seed]);
        for (const std::int32_t id : before.ids()) mark(id);
    }
    cells_[seed] = nullptr;
    faces_[seed] = ids.empty() ? 0 : std::numeric_limits<std::uint8_t>::max();
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
    if (head.tied || !signs.tested) {
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
    CornerEdges& edges = worker.edges;
    edges.begin();
    const auto old = before.corners();
    for (std::size_t v = 0; v < old.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k) edges.add(old[v][k], old[v][(k + 1) % 3], v, old[v][(k + 2) % 3]);
    std::array<bool, CellShape::max_corners> found{};
    for (const KeptCell::Corner& corner : now.corners()) {
        const std::size_t a = old_face[corner[0]], b = old_face[corner[1]], c = old_face[corner[2]];
        bool same = false;
        if (a != none && b != none && c != none) {
            const auto [exists, v, third] = edges.find(a, b);
            same = exists && third == c;
            if (same) found[v] = true;
        }
        if (!same) mark_around(now, corner);
    }
    for (std::size_t v = 0; v < old.size(); ++v)
        if (!found[v]) mark_around(before, old[v]);
}

bool KeptCells::hides(std::size_t seed, Worker& worker) {
    std::byte*& four = hiding_[seed];
    if (four != nullptr && hide(frame_, test_, seed, KeptCell(four), worker.signs)) return true;
    alignas(8) std::array<std::byte, hiding_bytes> found;
    if (!find_hiding_seeds(frame_, cells_, seed, found) ||
        !hide(frame_, test_, seed, KeptCell(found.data()), worker.signs))
        return false;
    if (four == nullptr) four = allocate(hiding_bytes, worker);
    std::ranges::copy(found, four);
    return true;
}

// Tests the signs of a cell.
bool KeptCells::is_right(std::size_t seed, Worker& worker) {
    const KeptCell cell = this->cell(seed);
    if (cell.head().tied || !test_(frame_, seed, cell, worker.signs)) return false;
    if (may_hold(seed)) worker.over_point.push_back(seed);
    found_[seed] |= right;
    return true;
}

// Returns whether there is a flip that the worker may do now, for the cell that it has just tested. Notes the cell
// otherwise.
bool KeptCells::find_flip_of(std::size_t seed, Range range, Worker& worker) {
    const KeptCell cell = this->cell(seed);
    SignTest& signs = worker.signs;
    bool elsewhere = false;  // some flip changes cells of another worker
    const auto find = [&](const KeptCell::Corner& corner, std::size_t plane) {
        for (const std::size_t f : {std::size_t{corner[0]}, std::size_t{corner[1]}, std::size_t{corner[2]}, plane}) {
            const std::int32_t id = cell.ids()[f];
            if (id < 0) continue;
            const auto s = static_cast<std::size_t>(id);
            if (always_[s].load(std::memory_order_relaxed) != 0) return false;
            if (s < range.begin || s >= range.end) {
                elsewhere = true;
                return false;
            }
        }
        return find_flip(cells_, seed, signs, corner, plane, worker.flip);
    };
    if (!cell.head().tied && signs.tested) {
        const auto corners = cell.corners();
        const auto tests = cell.tests();
        for (std::size_t t = 0; t < tests.size(); ++t)
            if (!(signs.test_margin[t] > 0) && find(corners[tests[t].corner], tests[t].plane)) return true;
        for (std::size_t v = 0; v < cell.head().used; ++v) {
            if (signs.corner_margin[v] > 0) continue;
            for (const KeptCell::Corner& next : corners) {  // across an edge
                std::size_t common = 0, plane = 0;
                for (const std::uint8_t f : next)
                    if (std::ranges::find(corners[v], f) != corners[v].end())
                        ++common;
                    else
                        plane = f;
                if (common == 2 && std::ranges::binary_search(cell.planes(), plane) && find(corners[v], plane))
                    return true;
            }
        }
    }
    (elsewhere ? worker.later : worker.unmended).push_back(seed);
    return false;
}

void KeptCells::put(std::size_t seed, Worker& worker) {
    alignas(8) std::byte scratch[LooseCell::max_bytes];
    std::byte*& at = cells_[seed];
    const std::size_t room = room_of(at), bytes = worker.loose.pack(room, scratch);
    if (room < bytes) {
        at = allocate(bytes, worker);
        ++worker.grown;
    }
    std::memcpy(at, scratch, bytes);
    faces_[seed] = KeptCell(at).head().faces;
}

void KeptCells::flip(const Flip& flip, Worker& worker) {
    for (std::size_t k = 0; k < flip.id.size(); ++k) {
        if (flip.id[k] < 0) continue;
        const auto seed = static_cast<std::size_t>(flip.id[k]);
        worker.loose.read(cell(seed));
        found_[seed] = static_cast<std::uint8_t>((found_[seed] & new_faces) | (flip.is_end(k) ? new_faces : 0));
        const bool applied = flip.apply(k, order_, worker.loose);
        if (!applied) worker.loose.tied = true;
        // Some cell that has a sign sees whether the new edge is there already: it becomes tied, and its neighbors
        // pending.
        if (!applied || flip.has_sign(k)) worker.loose.find_tests(seed, worker.edges);
        put(seed, worker);
        if (flip.has_sign(k))
            worker.wrong.push_back(seed);
        else if (may_hold(seed))
            worker.over_point.push_back(seed);
    }
}

// Flips until the cell is right, and all that flips have changed.
void KeptCells::mend(std::size_t seed, Range range, Worker& worker) {
    if (is_right(seed, worker)) return;
    worker.wrong.assign(1, seed);
    bool is_tested = true;
    for (std::size_t flips = 0; !worker.wrong.empty();) {
        const std::size_t s = worker.wrong.back();
        worker.wrong.pop_back();
        const bool tested = std::exchange(is_tested, false);
        if ((found_[s] & right) != 0 || (!tested && is_right(s, worker)) || !find_flip_of(s, range, worker)) continue;
        if (++flips > max_flips) {
            worker.unmended.push_back(s);
            worker.unmended.insert(worker.unmended.end(), worker.wrong.begin(), worker.wrong.end());
            return;
        }
        flip(worker.flip, worker);
    }
}

// A neighbor that is nearer to the point settles it.
bool KeptCells::may_hold(std::size_t seed) const {
    const KeptCell cell = this->cell(seed);
    const float least = powers_[seed].least;
    const auto ids = cell.ids();
    for (std::size_t f = 0; f < ids.size(); ++f)
        if (ids[f] >= 0 && powers_[static_cast<std::size_t>(ids[f])].most < least && cell.near_shift(f) == NearShift{})
            return false;
    return is_no_farther(seed);
}

bool KeptCells::is_no_farther(std::size_t seed) const {
    const KeptCell cell = this->cell(seed);
    const auto [x, y, z] = way_to_point(places_[seed]);
    const double own = x * x + y * y + z * z, weight = places_[seed].weight;
    for (std::size_t f = 0; f < cell.faces(); ++f) {
        const std::int32_t id = cell.ids()[f];
        if (id < 0) continue;
        const SeedPlace& other = places_[static_cast<std::size_t>(id)];
        const NearShift shift = cell.near_shift(f);
        double way[3] = {x, y, z};
        for (std::size_t k = 0; k < 3; ++k) {
            way[k] -= other.x[k] - places_[seed].x[k];
            for (std::size_t j = 0; j < 3; ++j) way[k] -= shift[j] * frame_.vector[j][k];
        }
        const double square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
        const double tolerance = 0x1p-40 * (own + square + std::abs(weight) + std::abs(other.weight)) +
                                 8 * frame_.slack * (std::sqrt(own) + std::sqrt(square));
        if (square - other.weight + tolerance < own - weight) return false;
    }
    return true;
}

// Each task has a range of seeds and flips where all five are in it, so that threads need no locks. The second time
// ranges begin at the middles of the first ones. One thread does the rest.
void KeptCells::test(ThreadPool& pool) {
    hiding_.resize(count_);
    pool.run(ceil_div(count_, task_seeds), [&](std::size_t task, unsigned index) {
        for (std::size_t s = task * task_seeds; s < std::min(count_, (task + 1) * task_seeds); ++s)
            if (cells_[s] == nullptr && !(frame_.weighted && faces_[s] == 0 && hides(s, workers_[index])))
                mark(static_cast<std::int32_t>(s));
    });
    const std::size_t length = pool.size() == 1
                                   ? std::max<std::size_t>(count_, 1)  // all may be outside
                                   : std::max(task_seeds, ceil_div(count_, tasks_per_thread * pool.size()));
    pool.run(ceil_div(count_, length), [&](std::size_t task, unsigned index) {
        Worker& worker = workers_[index];
        const Range range{task * length, std::min(count_, (task + 1) * length)};
        for (std::size_t s = range.begin; s < range.end; ++s) {
            if (s % cells_per_check == 0) check_stop();
            if (s + 8 < range.end) prefetch(s + 8);
            if (!all_stay_ && s + 2 < range.end) prefetch_places(s + 2, false);
            const KeptCell cell = this->cell(s);
            if (!cell.exists()) continue;
            if (cell.head().tied || always_[s].load(std::memory_order_relaxed) != 0)
                mark(static_cast<std::int32_t>(s));
            else if ((found_[s] & right) == 0 && !is_still(s))
                mend(s, range, worker);
        }
    });
    std::vector<std::size_t> later;
    const auto gather = [&] {
        later.clear();
        for (Worker& worker : workers_) {
            later.insert(later.end(), worker.later.begin(), worker.later.end());
            worker.later.clear();
        }
        std::ranges::sort(later);
    };
    gather();
    pool.run(later.empty() ? 0 : ceil_div(count_, length) + 1, [&](std::size_t task, unsigned index) {
        const Range range{task == 0 ? 0 : task * length - length / 2, std::min(count_, task * length + length / 2)};
        for (auto s = std::ranges::lower_bound(later, range.begin); s != later.end() && *s < range.end; ++s)
            mend(*s, range, workers_[index]);
    });
    gather();
    for (const std::size_t s : later) mend(s, {0, count_}, workers_.front());
    for (Worker& worker : workers_) made_ += std::exchange(worker.grown, 0);
    for (Worker& worker : workers_)
        for (const std::size_t s : worker.unmended) {
            const KeptCell cell = this->cell(s);
            if (cell.head().tied || !test_(frame_, s, cell, worker.signs)) mark_wrong(cell, s, worker.signs);
        }
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
bool KeptCells::any_equal(Among among) const {
    const auto counts = [&](std::size_t s) { return among == Among::all_seeds || is_hidden(s); };
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
        if (!counts(s)) continue;
        const std::uint64_t b = bucket(places_[s]);
        shared[b / 64] |= met[b / 64] & bit(b);
        met[b / 64] |= bit(b);
    }
    std::vector<std::array<double, 3>> doubtful;
    for (std::size_t s = 0; s < count_; ++s)
        if (const std::uint64_t b = bucket(places_[s]); counts(s) && (shared[b / 64] & bit(b)) != 0)
            doubtful.push_back({places_[s].x[0], places_[s].x[1], places_[s].x[2]});
    std::ranges::sort(doubtful);
    return std::ranges::adjacent_find(doubtful) != doubtful.end();
}

bool KeptCells::meets_walls() {
    const auto has_face = [&](std::size_t f) {
        const std::size_t s = facet_seeds_[f];
        return s < count_ && cell(s).exists() && std::ranges::find(cell(s).ids(), facets_[f]) != cell(s).ids().end();
    };
    std::size_t met = 0;
    while (met < facets_.size() && has_face(met)) ++met;
    if (met == facets_.size()) return true;
    std::vector<std::size_t> with_face(walls_.size(), count_);  // some seed
    for (std::size_t s = 0; s < count_; ++s) {
        if (!cell(s).exists()) continue;
        for (const std::int32_t id : cell(s).ids()) {
            if (id >= 0) break;
            if (id != KeptCell::no_seed) with_face[static_cast<std::size_t>(-1 - id)] = s;
        }
    }
    std::ranges::transform(facets_, facet_seeds_.begin(),
                           [&](std::int32_t wall) { return with_face[static_cast<std::size_t>(-1 - wall)]; });
    return std::ranges::find(facet_seeds_, count_) == facet_seeds_.end();
}

// Made cells are right, so none of them is over the point if a kept one is and has less power there than all their
// seeds.
bool KeptCells::covers_once() {
    if (!meets_walls()) return false;
    std::vector<std::size_t>& over = over_;
    // No other still cell is over it.
    std::erase_if(over, [&](std::size_t s) { return !is_kept(s) || is_hidden(s) || !is_still(s); });
    for (const Worker& worker : workers_) over.insert(over.end(), worker.over_point.begin(), worker.over_point.end());
    std::ranges::sort(over);
    const auto repeated = std::ranges::unique(over);
    over.erase(repeated.begin(), repeated.end());
    SignTest& signs = workers_.front().signs;
    std::erase_if(over, [&](std::size_t s) {  // a flip may have changed it
        return !is_kept(s) || !test_(frame_, s, cell(s), signs) || !may_hold(s);
    });
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

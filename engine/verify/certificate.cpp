#include "verify/certificate.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "core/at.hpp"
#include "core/buffer.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "index/sort.hpp"
#include "result/arrays.hpp"

namespace votess {
namespace {

using Name = RowPolytope::Name;
using Shape = RowPolytope::Shape;

constexpr std::size_t cells_at_once = 256, cells_of_block = std::size_t{1} << 16;
constexpr std::size_t buckets = std::size_t{1} << 12;
constexpr int max_cuts = 200;  // of a seed without a cell
constexpr std::size_t max_near_walls = 12;
constexpr std::size_t max_tried_places = 64;
constexpr double max_doubt = 4;            // of numbers that are compared, in tolerances: nearly all have much less
constexpr double doubt_in_sum = 1.0 / 16;  // of a volume, where it only counts in a sum

// Linear in the shift.
std::uint64_t number_of(const exact::Shift& shift) {
    return static_cast<std::uint64_t>(shift[0]) * factor_a + static_cast<std::uint64_t>(shift[1]) * factor_b +
           static_cast<std::uint64_t>(shift[2]) * factor_c;
}

// Returns a number that names an edge of a polygon.
std::uint64_t number_of_edge(std::uint64_t face, std::uint64_t from, std::uint64_t to) {
    return scrambled(face + from * factor_a + to * factor_b);
}

}  // namespace

Certificate::Certificate(const CheckedRun& run, const Job& job, const detail::Result& result, const Endless& endless,
                         const Part& part)
    : run_(run),
      job_(job),
      result_(result),
      endless_(endless),
      part_(part),
      count_(part.ids.empty() ? result.status.size() : part.cells),
      numbers_(endless.numbers == nullptr ? result : *endless.numbers),
      tolerance_(double_tolerance.cell +
                 (numbers_.stats.precision == Precision::single ? single_tolerance : double_tolerance).cell),
      rows_{result.indptr, result.indices, result.shifts},
      planes_(job),
      unscale_(1 / job.scale),
      live_(result.status.size()),
      pool_(part.ids.empty() ? 0 : run.settled.threads) {
    for (std::size_t i = 0; i < live_.size(); ++i) live_[i] = result.status[i] == CellStatus::certified;
    detail::for_arrays([&](const auto& array) {
        using Value = std::remove_cvref_t<decltype(array.of(result)[0])>;
        has_places_ =
            has_places_ || (std::is_floating_point_v<Value> && array.name != "weights" && !array.of(numbers_).empty());
    });
    for (std::int32_t id = -1; - id <= planes_.walls(); --id) {
        if (!planes_.has_wall(id)) continue;
        using Kind = exact::Plane::Kind;
        const exact::Plane plane = planes_.plane(0, id, {});
        NearWall& wall = walls_.emplace_back(NearWall{id, {}, -infinity});
        if (plane.kind == Kind::wall) {
            const double length = length3(plane.seed);
            wall = {id, {plane.seed[0] / length, plane.seed[1] / length, plane.seed[2] / length}, plane.wall / length};
        } else if (plane.kind == Kind::lower_wall || plane.kind == Kind::upper_wall) {
            const double side = plane.kind == Kind::upper_wall ? 1 : -1;
            wall.normal[static_cast<std::size_t>(plane.axis)] = side;
            wall.offset = side * plane.wall;
        }
    }
    const Vector3 diagonal = minus(planes_.domain().box.upper, planes_.domain().box.lower);
    const auto& sides = planes_.domain().periodic;
    const bool partly = planes_.domain().is_periodic() && !(sides[0] && sides[1] && sides[2]);
    measures_ = partly || !result.stats.tiny_faces || !result.face_counts.empty() || !numbers_.volumes.empty() ||
                !numbers_.centroids.empty() || !numbers_.surface_areas.empty() || !numbers_.security_radii.empty() ||
                !numbers_.face_areas.empty() || !numbers_.face_normals.empty();
    for (unsigned k = 0; k < pool_.size(); ++k) {
        workers_.push_back(std::make_unique<Worker>(planes_, result.vertex_image_of));
        workers_.back()->areas.begin(std::min(4 * dot(diagonal, diagonal), std::numeric_limits<double>::max()));
    }
}

bool Certificate::is_live(std::int32_t id) const {
    const auto i = static_cast<std::size_t>(id);
    return id >= 0 && i < result_.status.size() && live_[i];
}

std::string Certificate::text_of(const Name& name) const {
    std::string text = name.id < 0 ? std::to_string(name.id) : text_of(at(name.id));
    if (!is_zero(name.shift))
        text += " (shift " + std::to_string(name.shift[0]) + " " + std::to_string(name.shift[1]) + " " +
                std::to_string(name.shift[2]) + ")";
    return text;
}

// Brings the seeds and vertices of a cell into the cache: in input order they lie anywhere. Inline, since compilers
// drop calls of functions without another effect.
void Certificate::prefetch(Prefetch what, std::size_t i) const {
    const std::span<const double> points = job_.points.f64;
    for (std::size_t e = rows_.begin(i); e < rows_.end(i) && !points.empty(); ++e)
        if (result_.indices[e] >= 0) {
            const double* const seed = points.data() + 3 * static_cast<std::size_t>(result_.indices[e]);
            __builtin_prefetch(seed);
            __builtin_prefetch(seed + 2);
        }
    if (what != Prefetch::all || result_.cell_vertex_indptr.empty() || result_.vertices.empty()) return;
    for (const std::int32_t v : vertices_of(i)) {
        __builtin_prefetch(&result_.vertices[3 * static_cast<std::size_t>(v)]);
        __builtin_prefetch(&result_.vertices[3 * static_cast<std::size_t>(v) + 2]);
    }
}

template <Certificate::Prefetch what, class Task>
void Certificate::for_cells(const Task& task) {
    pool_.run((count_ + cells_at_once - 1) / cells_at_once, [&](std::size_t piece, unsigned worker) {
        check_stop();
        const std::size_t begin = piece * cells_at_once, end = std::min(count_, begin + cells_at_once);
        for (std::size_t i = begin; i < end; ++i) {
            if (what != Prefetch::none && i + 1 < end) prefetch(what, i + 1);
            task(*workers_[worker], i);
        }
    });
}

Certificate::Verdict Certificate::prove() {
    for (auto& w : workers_) w->sums.assign(buckets, 0);
    for_cells<Prefetch::none>([&](Worker& w, std::size_t i) {
        if (has_right_side(w, i) && result_.status[i] != CellStatus::certified) check_other(w, i);
    });
    check_cells();
    Worker sum(planes_);
    sum.areas.begin(0);
    open_names_.assign(buckets, 0);
    const auto combine = [&] {
        for (auto& w : workers_) {
            sum.fault.merge(w->fault);
            sum.unsettled.merge(w->unsettled);
        }
        return sum.fault.text.empty() && sum.unsettled.text.empty();
    };
    for (auto& w : workers_) {
        for (std::size_t k = 0; k < buckets; ++k) open_names_[k] += w->sums[k];
        sum.polygons += w->polygons;
        sum.areas.add(w->areas);
        sum.volume += w->volume;
        sum.doubt += w->doubt;
    }
    if (combine() && part_.ids.empty()) check_volume(sum);
    if (combine() && std::ranges::any_of(open_names_, [](std::uint64_t s) { return s != 0; })) {
        const std::vector<bool> open = cells_of_open_names();
        for_cells<Prefetch::none>([&](Worker& w, std::size_t i) {
            if (open[i]) check_names(w, i);
        });
    }
    if (combine())
        for_cells<Prefetch::none>([&](Worker& w, std::size_t i) {
            if (result_.status[i] == CellStatus::empty) check_hidden(w, i);
        });
    if (combine() && sum.polygons == 0 && !result_.vertex_image_of.empty() && !result_.face_offsets.empty())
        check_images(sum);
    Verdict verdict;
    verdict.proven = combine();
    verdict.tiny_faces = sum.areas.count();
    if (verdict.proven && sum.polygons != 0) {
        verdict.proven = false;
        sum.fault.note(-1, [] { return std::string("two cells have different polygons between them"); });
    }
    verdict.fault = std::move(sum.fault);
    verdict.unsettled = std::move(sum.unsettled);
    for (Fault* fault : {&verdict.fault, &verdict.unsettled})
        if (!fault->text.empty() && fault->id >= 0) fault->id = id_of(static_cast<std::size_t>(fault->id));
    for (const auto& w : workers_) verdict.open.insert(verdict.open.end(), w->open.begin(), w->open.end());
    verdict.volume = sum.volume;
    verdict.doubt = sum.doubt;
    return verdict;
}

// Returns the live seeds, those that are near in space near each other.
std::vector<std::int32_t> Certificate::order_in_space() {
    cpu::SortedSeeds sorted;
    cpu::SeedSorter sorter;
    cpu::sort_inside(job_.points, job_.scale, 0, job_.outside, sorter, pool_, sorted);
    std::vector<std::int32_t> order;
    std::vector<bool> waits = live_;
    std::fill(waits.begin() + static_cast<std::ptrdiff_t>(count_), waits.end(), false);
    const auto live = static_cast<std::size_t>(std::ranges::count(waits, true));
    order.reserve(live);
    const auto add = [&](std::int32_t id) {
        if (waits[at(id)]) order.push_back(id);
        waits[at(id)] = false;
    };
    for (const std::int32_t id : sorted.input) add(id);
    for (std::size_t i = 0; order.size() < live; ++i) add(static_cast<std::int32_t>(i));
    return order;
}

void Certificate::check_cells() {
    const std::vector<std::int32_t> order = order_in_space();
    Buffer<std::int32_t> ranks{Buffer<std::int32_t>::Pages::huge};
    ranks.resize_uninitialized(result_.status.size());
    std::ranges::fill(ranks, -1);
    for (std::size_t k = 0; k < order.size(); ++k) ranks[at(order[k])] = static_cast<std::int32_t>(k);
    const std::size_t per_block =
        std::clamp(order.size() / (workers_.size() == 1 ? 1 : 4 * workers_.size()) + 1, cells_at_once, cells_of_block);
    pool_.run((order.size() + per_block - 1) / per_block, [&](std::size_t block, unsigned worker) {
        Worker& w = *workers_[worker];
        const std::size_t begin = block * per_block, end = std::min(order.size(), begin + per_block);
        w.handed.begin(order, ranks, begin, end);
        for (std::size_t k = begin; k < end; ++k) {
            if (k % cells_at_once == 0) check_stop();
            if (k + 8 < end) __builtin_prefetch(&rows_.indptr[at(order[k + 8])]);
            if (k + 4 < end) {
                const std::int32_t* const row = rows_.indices.data() + rows_.begin(at(order[k + 4]));
                __builtin_prefetch(row);
                __builtin_prefetch(row + 16);
            }
            if (k + 2 < end) {
                const std::size_t i = at(order[k + 2]);
                prefetch(Prefetch::seeds, i);
                for (std::size_t e = rows_.begin(i); e < rows_.end(i); ++e)
                    if (rows_.indices[e] >= 0) __builtin_prefetch(&ranks[at(rows_.indices[e])]);
                w.handed.prefetch(k + 2 - begin);
            }
            check_cell(w, at(order[k]));
        }
    });
}

// See shared_corners.hpp.
std::optional<Certificate::Verdict> Certificate::prove_shared() {
    if (result_.face_offsets.empty() || rows_.shifts.empty() != result_.vertex_image_of.empty()) return {};
    std::atomic<bool> failed = false;
    const auto is_good = [](const Worker& w) { return w.fault.text.empty() && w.unsettled.text.empty(); };
    const auto try_all = [&](const auto& task) {
        for_cells<Prefetch::seeds>([&](Worker& w, std::size_t i) {
            if (!failed.load(std::memory_order_relaxed) && (!task(w, i) || !is_good(w))) failed = true;
        });
        return !failed;
    };
    if (!endless_.covered_once) find_place();
    const bool shared = try_all([&](Worker& w, std::size_t i) {
        if (!has_right_side(w, i)) return false;
        if (result_.status[i] == CellStatus::certified) return check_shared(w, i);
        check_other(w, i);
        return true;
    });
    Worker sum(planes_);
    sum.areas.begin(0);
    std::uint64_t names = 0;
    for (auto& w : workers_) {
        names += w->shared.names();
        sum.areas.add(w->areas);
        sum.volume += w->volume;
        sum.doubt += w->doubt;
    }
    if (!shared || names != 0 || find_wrong_shift(false) || !shared_cover_once(sum) || !is_good(sum) ||
        !is_good(*workers_.front()))
        return {};
    if (std::ranges::find(result_.status, CellStatus::empty) != result_.status.end() &&
        !try_all([&](Worker& w, std::size_t i) {
            if (result_.status[i] == CellStatus::empty) check_hidden(w, i);
            return true;
        }))
        return {};
    Verdict verdict;
    verdict.proven = true;
    verdict.tiny_faces = result_.stats.tiny_faces.value_or(sum.areas.count());
    return verdict;
}

// Condition 3.
bool Certificate::shared_cover_once(Worker& sum) {
    if (std::ranges::find(result_.status, CellStatus::certified) == result_.status.end()) return false;
    const Domain& domain = planes_.domain();
    if (endless_.covered_once) return true;
    if (!domain.is_periodic()) return no_other_covers();
    if (!(domain.periodic[0] && domain.periodic[1] && domain.periodic[2])) return check_volume(sum), true;
    double volume = 0;
    for (const auto& w : workers_) volume += w->shared.volume();
    const double expected = job_.domain->volume;
    return std::isnormal(expected) && volume > 0.5 * expected && volume < 1.3 * expected;
}

// Whether a seed is reported to lie outside where it does.
bool Certificate::has_right_side(Worker& w, std::size_t i) const {
    const bool is_outside = !job_.outside.empty() && job_.outside[i] == CellStatus::outside;
    if (is_outside == (result_.status[i] == CellStatus::outside)) return true;
    w.fault.note(static_cast<std::int64_t>(i), [&] {
        return "seed " + text_of(i) +
               (is_outside ? " lies outside and is not reported so" : " is reported to lie outside, where it does not");
    });
    return false;
}

void Certificate::begin_cell(Worker& w, std::size_t i) const {
    w.owner = static_cast<std::int32_t>(i);
    if (!result_.duplicate_of.empty() && result_.duplicate_of[i] >= 0)
        w.fault.note(static_cast<std::int64_t>(i), [&] {
            return "seed " + text_of(i) + " has a cell and is reported to be a duplicate of " +
                   std::to_string(result_.duplicate_of[i]);
        });
}

bool Certificate::check_shared(Worker& w, std::size_t i) {
    RowPolytope& polytope = w.polytope;
    begin_cell(w, i);
    const std::size_t begin = rows_.begin(i), end = rows_.end(i);
    for (std::size_t entry = begin + 1; entry < end; ++entry)
        if (result_.indices[entry - 1] >= result_.indices[entry] && !(rows_.label(entry - 1) < rows_.label(entry)))
            return false;
    if (!add_row(w, i)) return false;
    tally_cover(w, i);
    const std::span<const std::int64_t> offsets(result_.face_offsets.data() + begin, end - begin + 1);
    const auto first = static_cast<std::size_t>(offsets.front()), last = static_cast<std::size_t>(offsets.back());
    const auto vertices = std::span<const std::int32_t>(result_.face_vertices).subspan(first, last - first);
    std::span<const std::int32_t> listed;
    if (!result_.cell_vertex_indptr.empty()) listed = vertices_of(i);
    if (!result_.cell_vertex_indptr.empty() && listed.empty()) return false;
    if (!polytope.close_polygons(offsets, vertices, listed)) return false;
    polytope.begin_corners();
    if ((!rows_.shifts.empty() && polytope.unit() != 1) || !w.shared.add(polytope, i)) return false;
    if (!result_.vertices.empty()) {
        const Vector3 place = planes_.place(i);
        for (const int v : w.shared.to_compare()) {
            const std::int32_t vertex = polytope.vertices()[static_cast<std::size_t>(v)];
            polytope.sharpen_corner(v, RowPolytope::sharp);
            if (!is_near(polytope, place, v, vertex)) check_vertex(w, i, v, vertex);
        }
    }
    if (!measures_) return true;
    for (int v = 0; v < static_cast<int>(polytope.fans().size()); ++v)
        if (!w.shared.has_place(v) && !polytope.place_corner(v)) return false;
    polytope.take_fans();
    check_numbers(w, i);
    return true;
}

void Certificate::unsettle(Worker& w, std::size_t i, const char* why) const {
    w.unsettled.note(static_cast<std::int64_t>(i), [&] { return "seed " + text_of(i) + ' ' + why; });
}

Name Certificate::name(std::size_t entry) const {
    if (rows_.shifts.empty()) return {rows_.indices[entry], {}};
    const FaceLabel label = rows_.label(entry);
    return {label.id, {label.shift[0], label.shift[1], label.shift[2]}};
}

// Visits the seeds that the row of an image lists, as images.
template <class Visit>
void Certificate::for_neighbors(const Name& of, const Visit& visit) const {
    const auto row = static_cast<std::size_t>(of.id);
    for (std::size_t entry = rows_.begin(row); entry < rows_.end(row); ++entry) {
        Name next = name(entry);
        if (!is_live(next.id)) continue;
        for (std::size_t k = 0; k < 3; ++k) next.shift[k] += of.shift[k];
        visit(next);
    }
}

void Certificate::check_cell(Worker& w, std::size_t i) {
    begin_cell(w, i);
    if (!add_row(w, i)) return;
    if (result_.face_offsets.empty()) {
        if (close_handed(w, i)) {
            measure_handed(w, i);
            if (!w.handed.to_name().empty()) name_planes(w, i);
            for (const int v : w.handed.to_name()) is_named(w.polytope, v) ? add_name(w, v) : check_corner(w, i, v);
            w.name_for(static_cast<std::int32_t>(i));
            return;
        }
        // Names the corners that were handed to it for the other three.
        const auto self = static_cast<std::int32_t>(i);
        w.handed.leave(i, [&](const std::array<std::int32_t, 3>& others) {
            std::uint64_t sum = random_of(self), is_last = 1;
            for (const std::int32_t id : others) {
                sum += random_of(id);
                is_last &= id < self ? 1 : 0;
            }
            const std::uint64_t h = scrambled(sum);
            for (const std::int32_t id : others) {
                w.named.push_back(static_cast<std::uint16_t>(h % buckets));
                w.name_for(id);
            }
            add_to_sum(w, h, 4 * is_last - 1);
            w.name_for(self);
        });
        if (!add_row(w, i)) return;
    }
    if (!wrap_row(w, i)) return;
    check_numbers(w, i);
    name_planes(w, i);
    if (!result_.face_offsets.empty()) check_polygons(w, i);
    add_names(w, i);
}

// Tries to make P_i with corners of other cells, see handed_corners.hpp. Walls that it may reach join it.
bool Certificate::close_handed(Worker& w, std::size_t i) {
    RowPolytope& polytope = w.polytope;
    const std::size_t listed = rows_.end(i) - rows_.begin(i);
    // Returns whether it found some, not too many.
    const auto add_walls = [&](double reach) {
        find_walls(w, i, reach);
        if (w.walls.size() > max_near_walls) return false;
        for (const Worker::UnlistedWall& wall : w.walls) polytope.add({wall.id, {}}, wall.plane);
        return !w.walls.empty();
    };
    double far = 0;  // most walls that it reaches are nearer than some bisector
    for (std::size_t f = 0; f < listed && !run_.settled.list_walls && !walls_.empty(); ++f)
        far = std::max(far, 0.5 * polytope.arrays().length[f]);
    if (far > 0) (void)add_walls(far);
    bool closed = w.handed.close(polytope, i, listed);
    if (!closed && !polytope.seems_open()) return false;
    w.extent = polytope.extent();
    if (add_walls(closed ? w.extent.reach() : infinity)) {
        closed = w.handed.close(polytope, i, listed);
        w.extent = polytope.extent();
    }
    if (!closed || w.walls.size() > max_near_walls) return false;
    return check_faces(w, i, Shape::solid) && w.handed.hand_on(polytope);
}

// Makes P_i, condition 1. Walls that the row does not list join it, the nearest ones first: all until they close it,
// then those that it may reach.
bool Certificate::wrap_row(Worker& w, std::size_t i) {
    RowPolytope& polytope = w.polytope;
    w.has_polygons = wrap_polygons(w, i);
    const bool sure = w.has_polygons || polytope.wrap_surely();
    find_walls(w, i, sure ? polytope.extent().reach() : infinity);
    const std::span<const Worker::UnlistedWall> walls = w.walls;
    std::size_t next = 0;
    const auto wrap = [&] {
        return polytope.seems_open() && next < walls.size() ? Shape::open : polytope.wrap_exactly();
    };
    Shape shape = sure ? Shape::solid : wrap();
    if (shape != Shape::solid) std::ranges::sort(w.walls, {}, &Worker::UnlistedWall::distance);
    for (std::size_t most = 12; next < walls.size() && shape != Shape::flat && shape != Shape::repeated; most *= 2) {
        const int before = polytope.planes();
        const double reach = shape == Shape::solid ? polytope.extent().reach() : infinity;
        for (std::size_t added = 0; next < walls.size() && added < most; ++next) {
            if (shape == Shape::solid && polytope.is_beyond(walls[next].plane, reach)) continue;
            polytope.add({walls[next].id, {}}, walls[next].plane);
            ++added;
        }
        if (polytope.planes() == before) continue;
        w.has_polygons = false;
        shape = polytope.wrap_surely() ? Shape::solid : wrap();
    }
    return check_faces(w, i, shape);
}

bool Certificate::add_row(Worker& w, std::size_t i) {
    const Name nearest = rows_.begin(i) == rows_.end(i) ? Name{-1, {}} : name(rows_.end(i) - 1);
    w.polytope.begin(i, is_live(nearest.id) ? planes_.rounded(i, nearest.id, nearest.shift).length : 1);
    for (std::size_t entry = rows_.begin(i); entry < rows_.end(i); ++entry) {
        if (add_seeds(w, i, entry)) break;
        const Name other = name(entry);
        const bool itself = other.id == static_cast<std::int32_t>(i) && is_zero(other.shift);
        bool exists = other.id < 0 ? planes_.has_wall(other.id) : is_live(other.id) && !itself;
        for (std::size_t k = 0; k < 3 && !is_zero(other.shift); ++k)
            exists &= other.shift[k] == 0 || (other.id >= 0 && planes_.domain().periodic[k]);
        if (!exists) {
            w.fault.note(static_cast<std::int64_t>(i), [&] {
                return "seed " + text_of(i) + " lists " + text_of(other) +
                       (other.id < 0 ? ", a wall that the domain lacks" : ", which has no cell");
            });
            return false;
        }
        const RoundedPlane plane = w.polytope.seen(other);
        if (plane.length == 0 && planes_.same_place(i, other.id, other.shift)) {
            w.fault.note(static_cast<std::int64_t>(i), [&] {
                return "seed " + text_of(i) + " lists " + text_of(other) + ", which lies at its place";
            });
            return false;
        }
        w.polytope.add(other, plane);
    }
    return true;
}

// Adds the rest of a row at once, if these are seeds without shifts.
bool Certificate::add_seeds(Worker& w, std::size_t i, std::size_t entry) const {
    const auto rest = rows_.indices.subspan(entry, rows_.end(i) - entry);
    const auto self = static_cast<std::int32_t>(i);
    if (rest.front() < 0) return false;
    for (std::size_t e = entry; e < rows_.end(i) && !rows_.shifts.empty(); ++e)
        if ((rows_.shifts[3 * e] | rows_.shifts[3 * e + 1] | rows_.shifts[3 * e + 2]) != 0) return false;
    return std::ranges::all_of(rest, [&](std::int32_t id) { return id != self && is_live(id); }) &&
           w.polytope.add_seeds(rest);
}

// Finds the walls that are not among the planes of the polytope, except those surely out of reach.
void Certificate::find_walls(Worker& w, std::size_t i, double reach) const {
    w.walls.clear();
    const exact::Point p = planes_.seed(i);
    const double far = reach / w.polytope.unit() * (1 + 0x1p-40),
                 rounding = 0x1p-40 * (std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]));
    for (const auto& [id, normal, offset] : walls_) {
        if (offset - dot(normal, p) > far + rounding + 0x1p-40 * std::abs(offset)) continue;
        const RoundedPlane plane = w.polytope.seen({id, {}});
        if (RowPolytope::is_out_of_reach(plane, reach)) continue;
        bool known = false;
        for (const Name& name : w.polytope.names()) known |= name.id == id;
        if (!known) w.walls.push_back({id, plane.d / plane.length, plane});
    }
}

bool Certificate::check_faces(Worker& w, std::size_t i, Shape shape) {
    const RowPolytope& polytope = w.polytope;
    if (shape == Shape::unsettled) return unsettle(w, i, "has a cell whose corners were not all found"), false;
    const int listed = static_cast<int>(rows_.end(i) - rows_.begin(i));
    const auto fault = [&](const char* what, const std::string& text) {
        w.fault.note(static_cast<std::int64_t>(i), [&] { return what + text_of(i) + text; });
        return false;
    };
    if (shape == Shape::open) return fault("cell ", " is not closed by the faces that it lists");
    if (shape == Shape::flat || shape == Shape::empty)
        return fault("cell ", " has no volume within the faces that it lists");
    if (shape == Shape::repeated) {
        const auto [f, g] = polytope.repeated();
        return fault("seed ",
                     " lists " + text_of(polytope.name(f)) + " and " + text_of(polytope.name(g)) + " for one face");
    }
    for (int f = 0; f < polytope.planes(); ++f) {
        if (f < listed && !polytope.has_face(f))
            return fault("seed ", " lists " + text_of(polytope.name(f)) + ", with which its cell shares no face");
        if (f >= listed && polytope.has_face(f) && run_.settled.list_walls)
            return fault("seed ", " does not list wall " + text_of(polytope.name(f)) + ", which bounds its cell");
    }
    return true;
}

// Compares volume, areas and counts. The bounds of rounding are those of the corners here and of the result.
void Certificate::check_numbers(Worker& w, std::size_t i) {
    RowPolytope& polytope = w.polytope;
    RowPolytope::Measures& m = w.measures;
    bool compares = true;
    for (std::size_t e = rows_.begin(i); e < rows_.end(i) && endless_.sides != nullptr; ++e)
        compares = compares && !endless_.sides->has(result_.indices[e]);
    const bool volumes = compares && (!numbers_.volumes.empty() || !numbers_.centroids.empty()),
               areas = compares && (!numbers_.face_areas.empty() || !numbers_.surface_areas.empty());
    polytope.measure_within(m, volumes ? max_doubt * tolerance_ : doubt_in_sum,
                            areas ? max_doubt * tolerance_ : infinity, !numbers_.centroids.empty());
    const MeasureUnit unit(unscale_ / polytope.unit(), run_.settled.region.thickness);
    if (!result_.stats.tiny_faces) add_areas(w);
    const double wide = m.diameter + 2 * m.error, doubt = m.doubt_of_volume();
    w.volume += unit.volume(m.volume);
    w.doubt += unit.volume(doubt);
    if (!compares) return;
    const auto compare = [&](const char* what, double given, double found, double allowed) {
        if (given == found || std::abs(given - found) <= allowed + 64 * smallest_double) return;
        w.fault.note(static_cast<std::int64_t>(i), [&] {
            return "cell " + text_of(i) + " has " + what + " " + number(given) + ", its faces give " + number(found);
        });
    };
    if (!numbers_.volumes.empty())
        compare("volume", numbers_.volumes[i], unit.volume(m.volume), unit.volume(tolerance_ * m.volume + doubt));
    std::size_t own = static_cast<std::size_t>(numbers_.indptr[i]);
    for (std::size_t f = 0; f < rows_.end(i) - rows_.begin(i); ++f) {
        if (polytope.name(static_cast<int>(f)).id < 0 && !numbers_.lists_walls) continue;
        if (!numbers_.face_areas.empty())
            compare("a face of area", numbers_.face_areas[own], unit.area(m.areas[f]),
                    unit.area(tolerance_ * m.surface + m.doubt_of_area()));
        const Vector3 normal = numbers_.face_normals.empty() ? Vector3{} : polytope.unit_normal(static_cast<int>(f));
        for (std::size_t k = 0; k < 3 && !numbers_.face_normals.empty(); ++k)
            compare("a normal with a component", numbers_.face_normals[3 * own + k], normal[k], tolerance_);
        ++own;
    }
    if (!numbers_.surface_areas.empty())
        compare("surface", numbers_.surface_areas[i], unit.area(m.surface),
                unit.area(tolerance_ * m.surface + m.doubt_of_area()));
    if (!numbers_.security_radii.empty())
        compare("a security radius of", numbers_.security_radii[i], unit.length(2 * m.reach),
                unit.length(tolerance_ * m.reach + 4 * m.error));
    const Vector3 place = planes_.place(i);
    for (std::size_t k = 0; k < 3 && !numbers_.centroids.empty() && m.volume > 2 * doubt; ++k) {
        const double x = (place[k] + m.centroid[k] / polytope.unit()) * unscale_;
        compare("a coordinate of the centroid,", numbers_.centroids[3 * i + k], x,
                unit.length((4 * doubt / m.volume + tolerance_) * (wide + m.reach)) + 0x1p-45 * std::abs(x));
    }
    if (result_.face_counts.empty()) return;
    std::size_t faces = 0;
    for (int f = 0; f < polytope.planes(); ++f) faces += polytope.has_face(f) ? 1 : 0;
    const auto count = [&](const char* what, std::uint32_t given, std::size_t found) {
        compare(what, given, static_cast<double>(found), 0);
    };
    count("a number of faces", result_.face_counts[i], faces);
    count("a number of edges", result_.edge_counts[i], polytope.edge_count());
    count("a number of vertices", result_.vertex_counts[i], polytope.corners().size());
}

// The same for a cell that is closed by handed corners, faster where there are no numbers to compare.
void Certificate::measure_handed(Worker& w, std::size_t i) {
    const RowPolytope& polytope = w.polytope;
    const PlaneArrays& p = polytope.arrays();
    const auto& [nearest, farthest, error] = w.extent;
    bool inside = true;
    for (std::size_t f = 0; f < p.count; ++f) inside = inside && p.d[f] > 0;
    if (has_places_ || result_.stats.tiny_faces || !inside ||
        !(error * error < RowPolytope::sharp * RowPolytope::sharp * nearest))
        return check_numbers(w, i);
    const std::span<const double> doubled = polytope.vector_areas(w.measures.vectors);
    w.measures.areas.resize(p.count);
    double volume = 0;
    for (std::size_t f = 0; f < p.count; ++f) {
        const double inverse = p.inverse[f],
                     area = 0.5 * inverse *
                            (doubled[4 * f] * p.nx[f] + doubled[4 * f + 1] * p.ny[f] + doubled[4 * f + 2] * p.nz[f]);
        w.measures.areas[f] = area;
        volume += area * p.d[f] * inverse / 3;
    }
    RowPolytope::Measures& m = w.measures;
    m.errors = 3 * error * static_cast<double>(polytope.corners().size());
    m.span = std::sqrt(farthest) + error;
    m.rounding = RowPolytope::rounding_of_sums * polytope.planes();
    if (!(m.doubt_of_volume() <= doubt_in_sum * volume)) return check_numbers(w, i);
    add_areas(w);
    const MeasureUnit unit(unscale_, run_.settled.region.thickness);
    w.volume += unit.volume(volume);
    w.doubt += unit.volume(m.doubt_of_volume());
}

// Counts the areas of faces with other cells.
void Certificate::add_areas(Worker& w) {
    std::vector<double>& areas = w.measures.areas;
    const double per_square = 1 / (w.polytope.unit() * w.polytope.unit());
    w.seed_areas.clear();
    for (int f = 0; f < w.polytope.planes(); ++f)
        if (w.polytope.name(f).id >= 0)
            w.seed_areas.push_back(std::max(areas[static_cast<std::size_t>(f)], 0.0) * per_square);
    w.areas.add(w.seed_areas);
}

// Tries to take the corners of P_i from the polygons of its row.
bool Certificate::wrap_polygons(Worker& w, std::size_t i) const {
    if (result_.face_offsets.empty()) return false;
    const std::span<const std::int64_t> offsets(result_.face_offsets.data() + rows_.begin(i),
                                                rows_.end(i) - rows_.begin(i) + 1);
    const std::span<const std::int32_t> all = result_.face_vertices;
    return w.polytope.wrap_polygons(offsets, all.subspan(static_cast<std::size_t>(offsets.front()),
                                                         static_cast<std::size_t>(offsets.back() - offsets.front())));
}

// Finds the vertices of all corners.
bool Certificate::take_vertices(Worker& w, std::size_t i) const {
    if (!w.has_polygons) return find_vertices(w, i);
    w.vertices.assign(w.polytope.vertices().begin(), w.polytope.vertices().end());
    return true;
}

void Certificate::check_polygons(Worker& w, std::size_t i) {
    if (!take_vertices(w, i)) {
        w.fault.note(static_cast<std::int64_t>(i),
                     [&] { return "cell " + std::to_string(i) + " has polygons that are not those of its faces"; });
        return;
    }
    add_polygons(w, i);
    if (!result_.cell_vertex_indptr.empty()) {
        std::uint64_t sum = 0;
        for (const std::int32_t v : w.vertices) sum += random_of(v);
        std::int32_t before = -1;
        bool ascend = true;
        for (const std::int32_t v : vertices_of(i)) {
            sum -= random_of(v);
            ascend = ascend && before < v;
            before = v;
        }
        if (sum != 0 || !ascend)
            w.fault.note(static_cast<std::int64_t>(i), [&] {
                return "cell " + std::to_string(i) + " lists " +
                       (sum != 0 ? "other vertices than those of its polygons" : "vertices that do not ascend");
            });
    }
    if (!result_.vertices.empty()) check_vertices(w, i);
}

// Finds the vertices of corners. A vertex of the result has the name of a corner if the same faces meet there. The
// directed edges of all polygons, as pairs of names, must be those of the faces; then each polygon runs once around its
// face. Sums of random numbers compare them.
bool Certificate::find_vertices(Worker& w, std::size_t i) const {
    const RowPolytope& polytope = w.polytope;
    w.keys.clear();
    for (int f = 0; f < polytope.planes(); ++f) w.keys.push_back(scrambled(static_cast<std::uint64_t>(f)));
    w.corner_keys.assign(polytope.corners().size(), 0);
    for (std::size_t v = 0; v < w.corner_keys.size(); ++v)
        for (const int f : polytope.through(static_cast<int>(v)))
            if (polytope.has_face(f)) w.corner_keys[v] += w.keys[static_cast<std::size_t>(f)];
    std::uint64_t sum = 0;
    for (const RowPolytope::Edge& e : polytope.edges()) {
        const std::uint64_t from = w.corner_keys[static_cast<std::size_t>(e.from)],
                            to = w.corner_keys[static_cast<std::size_t>(e.to)];
        sum += number_of_edge(w.keys[static_cast<std::size_t>(e.left)], from, to) +
               number_of_edge(w.keys[static_cast<std::size_t>(e.right)], to, from);
    }
    std::size_t size = 16;
    while (size < 2 * polytope.corners().size()) size *= 2;
    w.found.assign(size, {-1, 0});
    std::size_t used = 0;
    const auto find = [&](std::int32_t id) -> Worker::Vertex* {
        std::size_t k = (static_cast<std::uint32_t>(id) * 0x9e3779b1u >> 8) & (size - 1);
        while (w.found[k].id != id && w.found[k].id != -1) k = (k + 1) & (size - 1);
        if (w.found[k].id == -1) {
            if (id < 0 || ++used > polytope.corners().size()) return nullptr;
            w.found[k].id = id;
        }
        return &w.found[k];
    };
    if (polygons_of(i).size() != 2 * polytope.edges().size()) return false;
    for (std::size_t e = rows_.begin(i); e < rows_.end(i); ++e)
        for (auto c = result_.face_offsets[e]; c < result_.face_offsets[e + 1]; ++c) {
            Worker::Vertex* vertex = find(result_.face_vertices[static_cast<std::size_t>(c)]);
            if (vertex == nullptr) return false;
            vertex->key += w.keys[e - rows_.begin(i)];
        }
    for (std::size_t e = rows_.begin(i); e < rows_.end(i); ++e) {
        const auto begin = static_cast<std::size_t>(result_.face_offsets[e]),
                   end = static_cast<std::size_t>(result_.face_offsets[e + 1]);
        for (std::size_t c = begin; c < end; ++c)
            sum -= number_of_edge(w.keys[e - rows_.begin(i)], find(result_.face_vertices[c])->key,
                                  find(result_.face_vertices[c + 1 == end ? begin : c + 1])->key);
    }
    if (sum != 0) return false;
    std::ranges::sort(w.found, {}, &Worker::Vertex::key);
    w.vertices.clear();
    for (const std::uint64_t key : w.corner_keys)
        w.vertices.push_back(std::ranges::lower_bound(w.found, key, {}, &Worker::Vertex::key)->id);
    return true;
}

// Adds the polygons, as directed edges, to sums that are 0 if both cells of each face have the same.
void Certificate::add_polygons(Worker& w, std::size_t i) const {
    const auto self = static_cast<std::int32_t>(i);
    const Worker::PlaneName& own = w.names.back();
    const std::int32_t* const images = result_.vertex_image_of.empty() ? nullptr : result_.vertex_image_of.data();
    for (std::size_t e = rows_.begin(i); e < rows_.end(i); ++e) {
        const std::int32_t id = result_.indices[e];
        if (id < 0) continue;
        const Worker::PlaneName& other = w.names[e - rows_.begin(i)];
        const bool is_first = self != id ? self < id : other.before == 0;
        const std::uint64_t face = is_first ? own.random * factor_c + other.random * factor_d + other.shift
                                            : other.random * factor_c + own.random * factor_d - other.shift;
        const auto begin = static_cast<std::size_t>(result_.face_offsets[e]),
                   end = static_cast<std::size_t>(result_.face_offsets[e + 1]);
        const auto original = [&](std::size_t c) {
            const std::int32_t v = result_.face_vertices[c];
            return static_cast<std::uint64_t>(images == nullptr ? v : images[v]);
        };
        std::uint64_t sum = 0, before = original(end - 1);
        for (std::size_t c = begin; c < end; ++c) {
            const std::uint64_t next = original(c);
            sum += is_first ? number_of_edge(face, before, next) : -number_of_edge(face, next, before);
            before = next;
        }
        w.polygons += sum;
    }
}

std::span<const std::int32_t> Certificate::vertices_of(std::size_t i) const {
    const auto begin = static_cast<std::size_t>(result_.cell_vertex_indptr[i]),
               end = static_cast<std::size_t>(result_.cell_vertex_indptr[i + 1]);
    return std::span<const std::int32_t>(result_.cell_vertex_indices).subspan(begin, end - begin);
}

std::span<const std::int32_t> Certificate::polygons_of(std::size_t i) const {
    const auto first = static_cast<std::size_t>(result_.face_offsets[rows_.begin(i)]),
               last = static_cast<std::size_t>(result_.face_offsets[rows_.end(i)]);
    return std::span<const std::int32_t>(result_.face_vertices).subspan(first, last - first);
}

// Returns a vertex whose shift is not that from its original, by their places. certain: leaves out vertices so far away
// that rounding hides a period.
std::optional<std::size_t> Certificate::find_wrong_shift(bool certain) const {
    const std::span<const std::int32_t> images = result_.vertex_image_of;
    for (std::size_t v = 0; v < images.size(); ++v) {
        const std::size_t u = at(images[v]);
        const std::int8_t* const shift = &result_.vertex_shifts[3 * v];
        if (u == v && (shift[0] | shift[1] | shift[2]) == 0) continue;
        if (u == v || images[u] != images[v]) return v;
        if (result_.vertices.empty()) continue;
        constexpr double place_error = 0x1p12, near = 0.25;  // in errors of a rounded coordinate; of a whole number
        Vector3 way;
        double size = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = result_.vertices[3 * v + k] * job_.scale, y = result_.vertices[3 * u + k] * job_.scale;
            way[k] = x - y;
            size = std::max({size, std::abs(x), std::abs(y)});
        }
        const Basis& edges = planes_.domain().edges;
        const auto turns = edges.fraction(way);
        for (std::size_t k = 0; k < 3; ++k) {
            const double expected = planes_.domain().periodic[k] ? turns[k] : 0;
            if (certain && !(place_error * edges.fraction_error(static_cast<int>(k), size) < near)) continue;
            if (!(std::abs(expected - shift[k]) < near)) return v;
        }
    }
    return std::nullopt;
}

// Compares images of vertices with their originals. One of its cells says where a vertex is: all agree, as polygons do.
void Certificate::check_images(Worker& sum) {
    const std::span<const std::int32_t> images = result_.vertex_image_of;
    const auto fault = [&](std::size_t v) {
        sum.fault.note(-1, [&] {
            return "vertex " + std::to_string(v) + " is not the image of vertex " + std::to_string(images[v]) +
                   " that its shift says";
        });
    };
    if (const auto wrong = find_wrong_shift(true)) return fault(*wrong);
    std::vector<std::int32_t> number(images.size(), -1), cell(images.size(), -1);
    std::int32_t originals = 0;
    for (std::size_t v = 0; v < images.size(); ++v)
        if (std::int32_t& n = number[at(images[v])]; at(images[v]) != v && n < 0) n = originals++;
    for (std::size_t i = 0; i < result_.status.size(); ++i)
        for (const std::int32_t v : polygons_of(i))
            if (cell[at(v)] < 0) cell[at(v)] = static_cast<std::int32_t>(i);
    const auto for_corners = [&](const auto& visit) {
        for_cells<Prefetch::none>([&](Worker& w, std::size_t i) {
            const auto counts = [&](std::int32_t v) {
                return at(cell[at(v)]) == i && (images[at(v)] != v || number[at(v)] >= 0);
            };
            if (std::ranges::none_of(polygons_of(i), counts) || !build(w, i) || !take_vertices(w, i)) return;
            for (int corner = 0; corner < static_cast<int>(w.vertices.size()); ++corner)
                if (const std::int32_t v = w.vertices[at(corner)]; counts(v)) visit(w, i, corner, at(v));
        });
    };
    using Seeds = std::array<Name, 4>;
    std::vector<Seeds> seeds(at(originals));
    for_corners([&](Worker& w, std::size_t i, int corner, std::size_t v) {
        if (at(images[v]) != v) return;
        const auto& [a, b, c] = w.polytope.corners()[at(corner)].planes;
        seeds[at(number[v])] = {Name{static_cast<std::int32_t>(i), {}}, w.polytope.name(a), w.polytope.name(b),
                                w.polytope.name(c)};
    });
    for_corners([&](Worker& w, std::size_t i, int corner, std::size_t v) {
        const std::size_t u = at(images[v]);
        if (u == v) return;
        for (Name name : seeds[at(number[u])]) {
            for (std::size_t k = 0; k < 3 && name.id >= 0; ++k) name.shift[k] += result_.vertex_shifts[3 * v + k];
            const bool is_own = name.id == static_cast<std::int32_t>(i) && is_zero(name.shift);
            if (cell[u] >= 0 && (is_own || w.polytope.side(corner, name) == 0)) continue;
            w.fault.note(static_cast<std::int64_t>(i), [&] {
                return "vertex " + std::to_string(v) + " of cell " + std::to_string(i) +
                       " is not where an image of vertex " + std::to_string(u) + " is";
            });
            return;
        }
    });
}

// Compares the places of vertices with the corners.
void Certificate::check_vertices(Worker& w, std::size_t i) const {
    const Vector3 place = planes_.place(i);
    for (int v = 0; v < static_cast<int>(w.vertices.size()); ++v) {
        const std::int32_t vertex = w.vertices[static_cast<std::size_t>(v)];
        if (!is_near(w.polytope, place, v, vertex)) check_vertex(w, i, v, vertex);
    }
}

// Whether a vertex lies within half of the tolerance of a corner. place: of the seed.
bool Certificate::is_near(const RowPolytope& polytope, const Vector3& place, int corner, std::int32_t vertex) const {
    const Vector3& at = polytope.corners()[static_cast<std::size_t>(corner)].at;
    const double* const given = &result_.vertices[3 * static_cast<std::size_t>(vertex)];
    const double square = dot(at, at), per_unit = polytope.unit() == 1 ? 1 : 1 / polytope.unit();
    Vector3 off;
    for (std::size_t k = 0; k < 3; ++k) off[k] = given[k] * job_.scale - (place[k] + at[k] * per_unit);
    const double near = 0.5 * run_.tolerance.cell * per_unit;
    return square > 0x1p-900 && dot(off, off) <= near * near * square;
}

void Certificate::check_vertex(Worker& w, std::size_t i, int v, std::int32_t vertex) const {
    const Vector3 place = planes_.place(i);
    const RowPolytope::Corner& corner = w.polytope.corners()[static_cast<std::size_t>(v)];
    const double* const given = &result_.vertices[3 * static_cast<std::size_t>(vertex)];
    const double square = dot(corner.at, corner.at), per_unit = 1 / w.polytope.unit();
    const double length = (square > 0x1p-900 && square < 0x1p900 ? std::sqrt(square) : length3(corner.at)) * per_unit;
    for (std::size_t k = 0; k < 3; ++k) {
        const double x = place[k] + corner.at[k] * per_unit,
                     allowed =
                         2 * corner.error * per_unit + run_.tolerance.cell * length + 0x1p-48 * (std::abs(x) + length);
        if (std::abs(given[k] * job_.scale - x) <= allowed) continue;
        w.fault.note(static_cast<std::int64_t>(i), [&] {
            return "vertex " + std::to_string(vertex) + " of cell " + std::to_string(i) + " has " + "xyz"[k] + " = " +
                   number(given[k]) + ", its faces meet at " + number(x * unscale_);
        });
    }
}

void Certificate::name_planes(Worker& w, std::size_t i) const {
    const auto self = static_cast<std::int32_t>(i);
    w.names.resize(static_cast<std::size_t>(w.polytope.planes()) + 1);
    for (int f = 0; f < w.polytope.planes(); ++f) {
        const Name& other = w.polytope.name(f);
        const std::uint64_t random = random_of(other.id);
        Worker::PlaneName& name = w.names[static_cast<std::size_t>(f)] = {};
        name.sum = other.id < 0 ? random * factor_a : random;
        if (other.id < 0) continue;
        name.random = random, name.seeds = 1;
        name.before = (other.id != self ? other.id < self : other.shift < exact::Shift{}) ? 1 : 0;
        if (is_zero(other.shift)) continue;
        name.shift = number_of(other.shift);
        name.products = random * name.shift, name.squares = name.shift * name.shift;
    }
    w.names.back() = {.sum = random_of(self), .seeds = 1, .random = random_of(self)};
}

// Adds the names of corners in general position, condition 2.
void Certificate::add_names(Worker& w, std::size_t i) {
    const RowPolytope& polytope = w.polytope;
    for (int v = 0; v < static_cast<int>(polytope.corners().size()); ++v)
        is_named(polytope, v) ? add_name(w, v) : check_corner(w, i, v);
    w.name_for(static_cast<std::int32_t>(i));
}

// Returns whether the corner is in general position, between walls and cells to prove.
bool Certificate::is_named(const RowPolytope& polytope, int corner) const {
    const std::span<const int> through = polytope.through(corner);
    return through.size() == 3 && (part_.ids.empty() || std::ranges::all_of(through, [&](int f) {
                                       return polytope.name(f).id < 0 || at(polytope.name(f).id) < count_;
                                   }));
}

void Certificate::add_name(Worker& w, int corner) {
    std::uint64_t factor = 1;
    const std::uint64_t h = name_of(w, corner, factor);
    add_to_sum(w, h, factor);
}

void Certificate::add_to_sum(Worker& w, std::uint64_t name, std::uint64_t factor) {
    w.sums[name % buckets] += scrambled(name) * factor;
    w.named.push_back(static_cast<std::uint16_t>(name % buckets));
}

// Returns which cells have corners whose names are among sums that are not 0.
std::vector<bool> Certificate::cells_of_open_names() const {
    std::vector<bool> open(result_.status.size());
    for (const auto& w : workers_) {
        std::size_t k = 0;
        for (const auto& [cell, end] : w->named_cells)
            for (; k < end; ++k)
                if (open_names_[w->named[k]] != 0) open[at(cell)] = true;
    }
    return open;
}

// Returns a number that depends on the seeds and walls of a corner, neither on their order nor on a shift of all: with
// random numbers r of seeds and s of shifts, linear in these, from the sums of r, of (r - r')(s - s') and of
// (s - s')^2 over all pairs.
std::uint64_t Certificate::name_of(const Worker& w, int corner, std::uint64_t& factor) const {
    const Worker::PlaneName& own = w.names.back();
    const auto& [a, b, c] = w.polytope.corners()[static_cast<std::size_t>(corner)].planes;
    const Worker::PlaneName *const names = w.names.data(), &x = names[a], &y = names[b], &z = names[c];
    std::uint64_t sum = own.sum + x.sum + y.sum + z.sum;
    const std::uint64_t seeds = 1 + x.seeds + y.seeds + z.seeds, before = x.before + y.before + z.before;
    factor = before + 1 == seeds ? 1 - seeds : 1;
    if (!rows_.shifts.empty()) {
        const std::uint64_t random = own.random + x.random + y.random + z.random, shift = x.shift + y.shift + z.shift,
                            products = x.products + y.products + z.products,
                            squares = x.squares + y.squares + z.squares;
        sum += (seeds * products - random * shift) * factor_b + (seeds * squares - shift * shift) * factor_c;
    }
    return scrambled(sum);
}

void Certificate::check_names(Worker& w, std::size_t i) {
    if (result_.status[i] != CellStatus::certified || !build(w, i)) return;
    name_planes(w, i);
    const RowPolytope& polytope = w.polytope;
    for (int v = 0; v < static_cast<int>(polytope.corners().size()); ++v) {
        if (!is_named(polytope, v)) continue;
        std::uint64_t factor = 1;
        if (open_names_[name_of(w, v, factor) % buckets] != 0) check_corner(w, i, v);
    }
}

// Asks each neighbor at a corner whether its cell has it, condition 2: at the corner its power is that of seed i.
void Certificate::check_corner(Worker& w, std::size_t i, int corner) {
    RowPolytope& polytope = w.polytope;
    const std::span<const int> through = polytope.through(corner);
    w.asked.clear();
    for (const int f : through) {
        const Name& neighbor = polytope.name(f);
        if (neighbor.id < 0 || !polytope.has_face(f)) continue;
        if (!has_row(neighbor.id)) return unsettle(w, i, "has a neighbor without a row");
        for_neighbors(neighbor, [&](const Name& other) {
            if (other.id == static_cast<std::int32_t>(i) && other.shift == exact::Shift{}) return;
            if (std::ranges::any_of(through, [&](int g) { return polytope.name(g) == other; })) return;
            if (std::ranges::find(w.asked, other) != w.asked.end()) return;
            w.asked.push_back(other);
            if (polytope.side(corner, other) <= 0) return;
            w.fault.note(static_cast<std::int64_t>(i), [&] {
                return "seed " + text_of(i) + " lists " + text_of(neighbor) + ", but not its neighbor " +
                       text_of(other) + ", which is nearer to a corner of the cell";
            });
        });
    }
}

// Condition 4, for seeds other than hidden ones.
void Certificate::check_other(Worker& w, std::size_t i) {
    const auto fault = [&](const std::string& text) {
        w.fault.note(static_cast<std::int64_t>(i), [&] { return "seed " + text_of(i) + text; });
    };
    if (rows_.begin(i) != rows_.end(i)) return fault(" has no cell and a row");
    bool zero = true;
    detail::for_arrays([&](const auto& array) {
        const auto& values = array.of(result_);
        if (array.per != Per::cell || array.word == nullptr || values.empty()) return;
        for (std::size_t k = array.components * i; k < array.components * (i + 1); ++k)
            zero = zero && (array.components == 3 ? std::isnan(static_cast<double>(values[k]))
                                                  : values[k] == std::remove_cvref_t<decltype(values[k])>{});
    });
    if (!zero) return fault(" has no cell, and numbers of one");
    const bool listed = !result_.duplicate_of.empty() && result_.duplicate_of[i] >= 0;
    if (listed && result_.status[i] != CellStatus::duplicate) return fault(" is no duplicate, and named one");
    switch (result_.status[i]) {
        case CellStatus::outside:
        case CellStatus::empty:
            return;
        case CellStatus::duplicate:
            break;
        default:
            return fault(" has no verdict");
    }
    if (result_.duplicate_of.empty()) return unsettle(w, i, "is a duplicate, and the result does not say of which one");
    const std::int32_t k = result_.duplicate_of[i];
    const bool is_seed = k >= 0 && id_of(at(k)) < id_of(i) &&
                         result_.status[static_cast<std::size_t>(k)] != CellStatus::duplicate &&
                         result_.status[static_cast<std::size_t>(k)] != CellStatus::outside;
    if (!is_seed || planes_.weight(static_cast<std::size_t>(k)) != planes_.weight(i) || !planes_.same_place(i, k, {}))
        fault(" is reported to be a duplicate of " + std::to_string(k < 0 ? k : id_of(at(k))) + ", and is not");
}

// Returns the image of a live seed whose power is least at a place relative to seed i, by rounded numbers: goes from
// cell to cell, as far as these have rows. Powers count from that of seed i.
Name Certificate::owner_of(Worker& w, std::size_t i, const Vector3& place) const {
    const auto power = [&](const Name& name) {
        const RoundedPlane plane = planes_.rounded(i, name.id, name.shift);
        return plane.d - dot(plane.n, place);
    };
    Name best{w.owner, {}};
    double least = power(best);
    for (bool moved = true; moved;) {
        moved = false;
        for_neighbors(Name(best), [&](const Name& next) {
            const double value = power(next);
            if (value < least) least = value, best = next, moved = true;
        });
    }
    w.owner = best.id;
    return best;
}

// Finds the plane of a live seed that cuts off the most corners of the polytope of seed i, among the owner of a place
// and its neighbors. Returns how many corners it leaves inside, or nothing if it cuts off none. Without exact signs
// corners count only where rounded numbers settle it.
std::optional<std::size_t> Certificate::best_cut(Worker& w, std::size_t i, const Vector3& place, bool exactly,
                                                 Name& best) const {
    std::optional<std::size_t> fewest;
    const auto consider = [&](const Name& name) {
        const RoundedPlane plane = w.polytope.seen(name);
        if (plane.length == 0 && planes_.weight(static_cast<std::size_t>(name.id)) <= planes_.weight(i)) return;
        std::size_t inside = 0, outside = 0;
        for (int v = 0; v < static_cast<int>(w.polytope.corners().size()); ++v) {
            const RowPolytope::Corner& corner = w.polytope.corners()[at(v)];
            const double along = dot(plane.n, corner.at), slack = plane.d - along,
                         bound = corner.error * plane.length + 0x1p-48 * (std::abs(along) + plane.size);
            const int side = slack > bound ? -1 : slack < -bound ? 1 : exactly ? w.polytope.side(v, name) : 0;
            inside += side < 0 ? 1 : 0;
            outside += side > 0 ? 1 : 0;
        }
        if (outside > 0 && inside < fewest.value_or(inside + 1)) fewest = inside, best = name;
    };
    const double per_unit = 1 / w.polytope.unit();
    const Name owner = owner_of(w, i, {place[0] * per_unit, place[1] * per_unit, place[2] * per_unit});
    consider(owner);
    for_neighbors(owner, consider);
    return fewest;
}

// Condition 4 for a hidden seed. Its polytope within the walls, or within its own images, is cut by live seeds until a
// plane cuts off all corners. The seeds tried are those around the one that owns the middle of what is left, or else a
// corner.
bool Certificate::is_excluded(Worker& w, std::size_t i) {
    RowPolytope& polytope = w.polytope;
    const auto self = static_cast<std::int32_t>(i);
    if (!is_live(w.owner)) w.owner = first_live();
    if (!is_live(w.owner)) return false;
    const Name above = owner_of(w, i, {});
    polytope.begin(i, planes_.rounded(i, above.id, above.shift).length);
    for (const exact::Shift& shift : planes_.domain().reduced.shift) {
        if (shift == exact::Shift{}) continue;
        polytope.add({self, shift});
        polytope.add({self, {-shift[0], -shift[1], -shift[2]}});
    }
    find_walls(w, i, infinity);
    for (const Worker::UnlistedWall& wall : w.walls) polytope.add({wall.id, {}}, wall.plane);
    for (int cuts = 0; cuts < max_cuts; ++cuts) {
        const Shape shape = polytope.wrap();
        if (shape == Shape::flat || shape == Shape::empty) return true;
        if (shape != Shape::solid) break;
        const auto corners = polytope.corners();
        Vector3 middle{};
        for (const RowPolytope::Corner& corner : corners)
            for (std::size_t k = 0; k < 3 && cuts > 0; ++k)
                middle[k] += corner.at[k] / static_cast<double>(corners.size());
        Name best{};
        std::optional<std::size_t> inside;
        for (const bool exactly : {false, true}) {
            if (!inside) inside = best_cut(w, i, middle, exactly, best);
            for (std::size_t v = 0; v < corners.size() && !inside; ++v)
                inside = best_cut(w, i, corners[v].at, exactly, best);
        }
        if (!inside) break;
        bool excluded = *inside == 0;
        for (int v = 0; v < static_cast<int>(corners.size()) && excluded; ++v) excluded = polytope.side(v, best) >= 0;
        if (excluded) return true;
        polytope.add(best);
    }
    return false;
}

void Certificate::check_hidden(Worker& w, std::size_t i) {
    if (is_excluded(w, i)) return;
    if (part_.ids.empty()) return unsettle(w, i, "has no cell, and no few others were found that exclude it");
    w.open.push_back(static_cast<std::int32_t>(i));
}

std::vector<std::int32_t> Certificate::find_excluded(std::span<const std::int32_t> hidden) {
    pool_.run((hidden.size() + cells_at_once - 1) / cells_at_once, [&](std::size_t piece, unsigned worker) {
        check_stop();
        Worker& w = *workers_[worker];
        const std::size_t begin = piece * cells_at_once, end = std::min(hidden.size(), begin + cells_at_once);
        for (const std::int32_t i : hidden.subspan(begin, end - begin)) {
            if (!is_live(w.owner)) w.owner = first_live();
            const bool is_here = is_live(w.owner) && has_row(owner_of(w, at(i), {}).id);
            if (is_here && is_excluded(w, at(i))) w.excluded.push_back(i);
        }
    });
    std::vector<std::int32_t> excluded;
    for (const auto& w : workers_) excluded.insert(excluded.end(), w->excluded.begin(), w->excluded.end());
    return excluded;
}

// Condition 3.
void Certificate::check_volume(Worker& sum) {
    const double domain = job_.box_volume;
    if (endless_.covered_once) return;
    const auto has = [&](CellStatus status) {
        return std::ranges::find(result_.status, status) != result_.status.end();
    };
    if (!has(CellStatus::certified) && has(CellStatus::empty))
        return unsettle(sum, 0, "has no cell, nor has any other");
    if (!has(CellStatus::certified)) return;
    const Cover cover = cover_of(sum.volume, sum.doubt, domain);
    if (cover == Cover::unknown && !is_covered_once()) sum.unsettled.note(0, [] { return std::string(no_volume); });
    if (cover == Cover::more) sum.fault.note(-1, [&] { return text_of_cover(sum.volume, domain); });
}

Certificate::Cover Certificate::cover_of(double volume, double doubt, double domain) {
    if (!(doubt < 0.25 * domain) || std::isinf(volume)) return Cover::unknown;  // volumes may overflow
    return volume + doubt < 1.5 * domain ? Cover::once : Cover::more;
}

std::string Certificate::text_of_cover(double volume, double domain) {
    return "the cells that the rows describe have a volume of " + number(volume) + ", the domain holds " +
           number(domain);
}

// Condition 3 where sums of volumes have lost their digits, as in domains that end far away. In a periodic domain all
// images of all cells would have to be asked; see Endless::covered_once.
bool Certificate::is_covered_once() {
    find_place();
    for_cells<Prefetch::none>([&](Worker& w, std::size_t i) {
        if (covered_by_ && result_.status[i] == CellStatus::certified && add_row(w, i)) tally_cover(w, i);
    });
    return no_other_covers();
}

// Counts a cell that may hold the place found. Its polytope has its planes.
void Certificate::tally_cover(Worker& w, std::size_t i) const {
    if (!covered_by_ || i == *covered_by_) return;
    Vector3 from = minus(place_, planes_.place(i));
    for (double& x : from) x *= w.polytope.unit();
    const double length = std::abs(from[0]) + std::abs(from[1]) + std::abs(from[2]);  // at least
    for (int f = 0; f < w.polytope.planes(); ++f)
        if (w.polytope.is_surely_outside(from, length, f)) return;
    ++w.covering;
}

bool Certificate::no_other_covers() const {
    return covered_by_ && std::ranges::all_of(workers_, [](const auto& w) { return w->covering == 0; });
}

// Finds a place that lies certainly inside a cell: the smallest of the first few, as places far away have fewer digits.
void Certificate::find_place() {
    if (planes_.domain().is_periodic()) return;
    Worker& w = *workers_.front();
    double least = infinity;
    std::size_t tried = 0;
    for (std::size_t i = 0; i < result_.status.size() && tried < max_tried_places; ++i) {
        if (result_.status[i] != CellStatus::certified || !build(w, i)) continue;
        ++tried;
        w.polytope.sharpen(RowPolytope::sharp);
        w.polytope.measure(w.measures);
        const double per_unit = 1 / w.polytope.unit(), reach = w.measures.reach * per_unit;
        if (!(reach < least)) continue;
        const Vector3 seed = planes_.place(i);
        Vector3 middle;
        for (std::size_t k = 0; k < 3; ++k) middle[k] = seed[k] + w.measures.centroid[k] * per_unit;
        const Vector3 from = minus(middle, seed);
        const double length = length3(from[0], from[1], from[2]);
        bool inside = true;
        for (int f = 0; f < w.polytope.planes(); ++f) {
            const Name& other = w.polytope.name(f);
            const RoundedPlane plane = planes_.rounded(i, other.id, other.shift);
            inside = inside && plane.d - dot(plane.n, from) > RowPolytope::doubt_of(plane, length);
        }
        if (inside) covered_by_ = i, least = reach, place_ = middle;
    }
}

}  // namespace votess

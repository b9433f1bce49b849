#include "verify/verify_sample.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "core/text.hpp"
#include "cpu/clip/cell.hpp"
#include "input/domain_of_result.hpp"
#include "input/options.hpp"
#include "result/rows.hpp"

namespace votess {
namespace {

// Without a sample of the user's size, cells are tried until they took this much work, counted in distance tests: about
// a second. Being counted and not measured, it gives the same sample on every machine.
constexpr double budget = 5e8, work_of_cell = 1e4, work_of_range = 60, work_of_image = 150, work_of_plane = 100,
                 work_of_vertex = 1;
constexpr std::size_t least_sample = 64;

// splitmix64 (Steele, Lea, Flood 2014): portable, so that a sample is the same everywhere.
struct Random {
    std::uint64_t state;
    std::uint64_t next() {
        std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
};

exact::Point scaled_seed(const Job& job, std::size_t j) {
    return {job.points[3 * j] * job.scale, job.points[3 * j + 1] * job.scale, job.points[3 * j + 2] * job.scale};
}

bool takes_part(const Tessellation& t, std::size_t j) {
    return t.status()[j] != CellStatus::duplicate && t.status()[j] != CellStatus::outside;
}

// Seeds that take part, where they lie in the domain; by slot.
class BruteForce {
public:
    BruteForce(const Tessellation& t, const Job& job) : job_(job), domain_(*job.domain), slot_(t.size()) {
        exact::Point largest{};
        for (std::size_t j = 0; j < t.size(); ++j) {
            if (!takes_part(t, j)) continue;
            exact::Point at = scaled_seed(job, j);
            exact::Shift shift{};
            if (domain_.is_periodic()) {
                shift = wrap(domain_, at).value_or(shift);
                const auto exact = exact::differences({}, exact::Plane::bisector(at, shift, domain_.lattice)).x;
                at = {exact[0].high, exact[1].high, exact[2].high};
                for (std::size_t k = 0; k < 3; ++k) largest[k] = std::max(largest[k], std::abs(at[k]));
            }
            slot_[j] = id_.size();
            id_.push_back(static_cast<std::int32_t>(j));
            shift_.push_back(shift);
            at_.push_back(at);
        }
        // The places of two seeds are each rounded once, along axes that box vectors have a component of.
        for (std::size_t k = 0; k < 3; ++k) {
            if (std::ranges::none_of(domain_.lattice.vector, [&](const auto& v) { return v[k].high != 0; })) continue;
            place_rounding_[k] = 0x1p-52 * largest[k];
            rounding_ = std::max(rounding_, 2 * place_rounding_[k]);
        }
    }

    // Clips a cell by every seed, in a periodic domain by every image that can reach it: ranges of shifts are halved
    // until they hold one. Nearest first, for speed alone. Adds to work().
    void clip(std::size_t i, cpu::Cell& cell) {
        own_ = slot_[i];
        cell.start(scaled_seed(job_, i), domain_, static_cast<std::int32_t>(i));
        work_ += work_of_cell;
        cut_by_nearest(cell);
        images_.clear();
        const double reach = reach_of(cell);
        for (std::size_t s = 0; s < at_.size(); ++s) {
            const ShiftRange shifts =
                domain_.is_periodic() ? shifts_around(domain_, {at_[s], at_[s]}, at_[own_], reach) : ShiftRange{};
            add(s, shifts, reach * reach);
        }
        work_ += static_cast<double>(at_.size()) * (domain_.is_periodic() ? work_of_range : 1);
        while (!images_.empty() && !cell.empty()) {
            std::ranges::pop_heap(images_, farther);
            const Images next = images_.back();
            images_.pop_back();
            work_ += work_of_image;
            const Box bounds = bounds_of(next.slot, next.shifts);
            if (!cell.in_reach(bounds, more()) || !cell.may_cut(bounds, more())) continue;
            if (next.shifts.is_single())
                cut(next.slot, next.shifts, cell);
            else
                halve(next);
        }
    }

    [[nodiscard]] double work() const noexcept { return work_; }

private:
    struct Images {               // of one seed by a range of shifts
        double distance_squared;  // of the nearest, or less
        std::size_t slot;
        ShiftRange shifts;
    };
    static bool farther(const Images& a, const Images& b) { return a.distance_squared > b.distance_squared; }

    [[nodiscard]] double more() const {
        return domain_.has_weights() ? domain_.most_more(domain_.weights[static_cast<std::size_t>(id_[own_])]) : 0;
    }
    // No seed farther away cuts: R + sqrt(R^2 + w - w_i) for the largest weight w.
    [[nodiscard]] double reach_of(cpu::Cell& cell) const {
        constexpr double slack = 1 + 1e-9, least = 1e-150;  // squares below the least number are lost
        const double square = cell.radius_squared();
        return (std::sqrt(square) + std::sqrt(square + more())) * slack + rounding_ + least;
    }
    [[nodiscard]] Box bounds_of(std::size_t slot, const ShiftRange& shifts) const {
        const exact::Point& q = at_[slot];
        if (!domain_.is_periodic()) return cpu::seen_from(at_[own_], {q, q});
        return cpu::seen_from({}, images_of(domain_, {q, q}, shifts, at_[own_]), place_rounding_);
    }
    void add(std::size_t slot, const ShiftRange& shifts, double most) {
        const Box box = bounds_of(slot, shifts);
        double square = 0;
        for (int k = 0; k < 3; ++k) {
            const double gap = std::max({0.0, box.lower[k], -box.upper[k]});
            square += gap * gap;
        }
        if (square > most) return;
        images_.push_back({square, slot, shifts});
        std::ranges::push_heap(images_, farther);
    }
    void halve(const Images& images) {
        const int axis = longest_extent(domain_, images.shifts).axis;
        for (const ShiftRange& half : halves(images.shifts, axis)) add(images.slot, half, infinity);
    }

    // By a few seeds, so that others are soon out of reach.
    void cut_by_nearest(cpu::Cell& cell) {
        constexpr std::size_t most = 48;
        images_.clear();
        for (std::size_t s = 0; s < at_.size(); ++s) {
            const exact::Point &p = at_[own_], &q = at_[s];
            const double x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];
            double key = x * x + y * y + z * z;
            if (domain_.has_weights()) key -= domain_.weights[static_cast<std::size_t>(id_[s])];
            if (images_.size() == most && !(key < images_.front().distance_squared)) continue;
            if (images_.size() == most) {
                std::ranges::pop_heap(images_, {}, &Images::distance_squared);
                images_.pop_back();
            }
            images_.push_back({key, s, {}});
            std::ranges::push_heap(images_, {}, &Images::distance_squared);
        }
        work_ += static_cast<double>(at_.size());
        std::ranges::sort(images_, {}, &Images::distance_squared);
        for (const Images& image : images_) cut(image.slot, {}, cell);
    }

    void cut(std::size_t slot, const ShiftRange& range, cpu::Cell& cell) {
        const exact::Shift shift = domain_.is_periodic() ? only_shift(domain_, range) : exact::Shift{};
        const auto id = id_[slot];
        const auto i = static_cast<std::size_t>(id_[own_]), j = static_cast<std::size_t>(id);
        if ((slot == own_ && shift == exact::Shift{}) || cell.knows(id, shift)) return;
        exact::Shift total;
        for (std::size_t k = 0; k < 3; ++k) total[k] = shift[k] + shift_[slot][k] - shift_[own_][k];
        exact::Plane plane = exact::Plane::bisector(scaled_seed(job_, j), total, domain_.lattice);
        if (domain_.has_weights()) plane.power = exact::two_sum(domain_.weights[i], -domain_.weights[j]);
        work_ += work_of_plane + work_of_vertex * cell.slots();
        cell.clip(id, plane, shift);
    }

    static constexpr double infinity = std::numeric_limits<double>::infinity();

    const Job& job_;
    const Domain& domain_;
    std::vector<std::size_t> slot_;  // by index
    std::vector<std::int32_t> id_;
    std::vector<exact::Shift> shift_;  // that wrapped the seed
    std::vector<exact::Point> at_;     // where to, rounded
    exact::Point place_rounding_{};
    double rounding_ = 0;  // of distances
    std::size_t own_ = 0;
    std::vector<Images> images_;
    double work_ = 0;
};

struct RowFace {
    FaceLabel label;
    double area;
};

// Faces whose area is that of the threshold may have stayed or gone.
std::string check_row(const Tessellation& t, std::size_t i, std::vector<RowFace>& found, double allowed) {
    const Rows rows{t.indptr(), t.indices(), t.shifts()};
    const auto given = t.neighbors(i).size();
    std::ranges::sort(found, {}, &RowFace::label);
    std::size_t matched = 0;
    for (const RowFace& face : found) {
        const std::size_t entry = rows.find(i, face.label);
        const std::int32_t id = face.label.id;
        if (entry == rows.end(i)) {
            if (id >= 0 && t.least_face() > 0 && face.area < t.least_face() + allowed) continue;
            return "seed " + std::to_string(i) + " lists " + std::to_string(given) + " neighbors, without " +
                   std::to_string(id) + ", which is one of the " + std::to_string(found.size()) +
                   " found by trying every seed";
        }
        ++matched;
        if (t.face_areas().empty()) continue;
        const double area = t.face_areas()[entry];
        if (area != face.area && !(std::abs(area - face.area) <= allowed + std::numeric_limits<double>::denorm_min()))
            return "the face of cell " + std::to_string(i) + " with " + std::to_string(id) + " has area " +
                   number(area) + ", trying every seed gives " + number(face.area);
    }
    if (matched == given) return {};
    return "seed " + std::to_string(i) + " lists " + std::to_string(given) + " neighbors that differ from the " +
           std::to_string(found.size()) + " found by trying every seed";
}

std::string check_cell(const Tessellation& t, const Job& job, std::size_t i, cpu::Cell& cell, cpu::CellFaces& faces) {
    cell.canonical_faces(faces);
    constexpr std::size_t least_faces = 4;  // with fewer a cell has no interior
    const bool told_empty = t.status()[i] == CellStatus::empty;
    if ((cell.empty() || faces.size() < least_faces) != told_empty)
        return "seed " + std::to_string(i) + " is said to have " + (told_empty ? "no cell" : "a cell") +
               ", trying every seed leaves " + (told_empty ? "one" : "none");
    if (told_empty) return {};

    const double unscale = 1 / job.scale;
    std::vector<double> areas;
    const cpu::CellGeometry geometry = cell.measure(faces, &areas);
    if (!t.indptr().empty()) {
        std::vector<RowFace> row;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const cpu::CellPlane& plane = cell.planes()[faces.planes[f]];
            if (plane.id < 0 && !t.lists_walls()) continue;
            RowFace face{{plane.id, {}}, areas[f] * unscale * unscale};
            for (std::size_t k = 0; k < 3; ++k) face.label.shift[k] = static_cast<std::int8_t>(plane.shift[k]);
            row.push_back(face);
        }
        const double surface = std::accumulate(areas.begin(), areas.end(), 0.0) * unscale * unscale;
        const double allowed = (volume_tolerance(t).cell + double_tolerance.cell) * surface;
        if (auto failure = check_row(t, i, row, allowed); !failure.empty()) return failure;
    }
    if (!t.volumes().empty()) {
        const double volume = geometry.volume * unscale * unscale * unscale;
        const double allowed = (volume_tolerance(t).cell + double_tolerance.cell) * volume;  // both are rounded
        if (volume != t.volumes()[i] &&                                                      // both may be infinite
            !(std::abs(volume - t.volumes()[i]) <= allowed + std::numeric_limits<double>::denorm_min()))
            return "cell " + std::to_string(i) + " has volume " + number(t.volumes()[i]) +
                   ", trying every seed gives " + number(volume);
    }
    return {};
}

}  // namespace

std::string check_sample(const Tessellation& t, std::span<const double> points, const VerifyOptions& options,
                         std::size_t& sampled) {
    Options as_before = domain_options(t);
    as_before.weights = t.weights();
    const Job job = validate({points, {}}, as_before);
    std::vector<std::size_t> cells;
    for (std::size_t i = 0; i < t.size(); ++i)
        if (takes_part(t, i)) cells.push_back(i);
    Random random{options.rng_seed};
    BruteForce brute_force(t, job);
    cpu::Cell cell;
    cpu::CellFaces faces;
    const auto enough = [&] {
        return options.sample ? sampled >= *options.sample : sampled >= least_sample && brute_force.work() >= budget;
    };
    while (sampled < cells.size() && !enough()) {
        std::swap(cells[sampled], cells[sampled + random.next() % (cells.size() - sampled)]);
        const std::size_t i = cells[sampled++];
        brute_force.clip(i, cell);
        if (auto failure = check_cell(t, job, i, cell, faces); !failure.empty()) return failure;
    }
    return {};
}

}  // namespace votess

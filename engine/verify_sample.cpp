#include "verify_sample.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "cpu/cell.hpp"
#include "options.hpp"
#include "rows.hpp"

namespace votess {
namespace {

// Without a sample of the user's size, cells are tried until they took this much work, counted in distance tests: about
// a second. Being counted and not measured, it gives the same sample on every machine.
constexpr double budget = 5e8, work_of_cell = 1e4, work_of_image = 150, work_of_plane = 100, work_of_vertex = 1;
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

// Which seeds may cut a cell of radius R: a point of it is nearer to a seed at distance d, heavier by m, only if
// d < R + sqrt(R^2 + m).
class Reach {
public:
    // rounding: at most the error of a distance between two seeds, images or not.
    Reach(double radius_squared, double rounding) : square_(radius_squared * slack), rounding_(rounding) {
        plain_ = squared(distance(0));
    }

    [[nodiscard]] double distance(double more) const {
        const double beyond = square_ + more + (slack - 1) * std::abs(more);
        return beyond < 0 ? 0 : (std::sqrt(square_) + std::sqrt(beyond)) * slack + rounding_;
    }
    [[nodiscard]] bool holds(double distance_squared) const { return distance_squared <= plain_; }
    [[nodiscard]] bool holds(double distance_squared, double more) const {
        const double most = distance(more);
        return most > 0 && distance_squared <= squared(most);
    }

private:
    static constexpr double slack = 1 + 1e-9;
    static double squared(double x) { return x * x * slack; }

    double square_, rounding_, plain_;
};

// Seeds that take part, where they lie in the domain; by slot.
class BruteForce {
public:
    BruteForce(const Tessellation& t, const Job& job) : job_(job), domain_(*job.domain), slot_(t.size()) {
        for (std::size_t j = 0; j < t.size(); ++j) {
            if (!takes_part(t, j)) continue;
            exact::Point at = scaled_seed(job, j);
            exact::Shift shift{};
            if (domain_.is_periodic()) {
                shift = wrap(domain_, at).value_or(shift);
                const exact::Point step = domain_.translation(shift);
                for (std::size_t k = 0; k < 3; ++k) {
                    largest_ = std::max(largest_, std::abs(at[k]) + size_of(shift));
                    at[k] += step[k];
                }
            }
            slot_[j] = id_.size();
            id_.push_back(static_cast<std::int32_t>(j));
            shift_.push_back(shift);
            at_.push_back(at);
        }
    }

    // Clips a cell by every seed, in a periodic domain by every image that can reach it; the nearest come first, for
    // speed alone. Adds to work().
    void clip(std::size_t i, cpu::Cell& cell) {
        own_ = slot_[i];
        work_ += work_of_cell;
        done_.clear();
        cell.start(scaled_seed(job_, i), domain_, static_cast<std::int32_t>(i), at_[own_]);
        std::vector<exact::Shift> shifts(1);
        cut_by_nearest(shifts, cell);
        double size = 0;
        if (domain_.is_periodic()) {
            shifts = shifts_within_reach(cell, size);
            for (const exact::Shift& shift : shifts) size = std::max(size, size_of(shift));
            cut_by_nearest(shifts, cell);
            shifts = shifts_within_reach(cell, size);
        }
        Reach reach = reach_of(cell, size);
        images_.clear();
        for_each_image(shifts, [&](const Image& image) {
            if (may_cut(image, reach) && std::ranges::find(done_, image) == done_.end()) images_.push_back(image);
        });
        work_ += work_of_image * static_cast<double>(images_.size());
        std::ranges::sort(images_, {}, &Image::key);
        for (const Image& image : images_)
            if (may_cut(image, reach) && cut(image, cell)) reach = reach_of(cell, size);
    }

    [[nodiscard]] double work() const noexcept { return work_; }

private:
    struct Image {
        double key;  // the power distance
        double distance_squared;
        std::size_t slot;
        exact::Shift shift;
        friend bool operator==(const Image&, const Image&) = default;
    };

    // Bounds of the terms whose sum a translation is.
    [[nodiscard]] double size_of(const exact::Shift& shift) const {
        double size = 0;
        for (std::size_t j = 0; j < 3; ++j)
            for (const double x : domain_.vector[j]) size += std::abs(shift[j] * x);
        return size;
    }

    [[nodiscard]] double distance_squared(const exact::Point& other) const {
        const exact::Point& own = at_[own_];
        const double x = other[0] - own[0], y = other[1] - own[1], z = other[2] - own[2];
        return x * x + y * y + z * z;
    }
    [[nodiscard]] double weight(std::size_t slot) const {
        return domain_.has_weights() ? domain_.weights[static_cast<std::size_t>(id_[slot])] : 0;
    }

    // Two places and the translation between them are each off by a few ulps of the numbers they are sums of; squares
    // below the least number are lost.
    [[nodiscard]] Reach reach_of(cpu::Cell& cell, double size_of_shifts) const {
        constexpr double ulps = 16 * std::numeric_limits<double>::epsilon(), least = 1e-150;
        return {cell.radius_squared(), std::max(ulps * (largest_ + size_of_shifts), least)};
    }
    [[nodiscard]] bool may_cut(const Image& image, const Reach& reach) const {
        if (!domain_.has_weights()) return reach.holds(image.distance_squared);
        return reach.holds(image.distance_squared, weight(image.slot) - weight(own_));
    }

    [[nodiscard]] std::vector<exact::Shift> shifts_within_reach(cpu::Cell& cell, double size_of_shifts) const {
        const double more = domain_.has_weights() ? domain_.largest_weight - weight(own_) : 0;
        return domain_.shifts_within(at_[own_], reach_of(cell, size_of_shifts).distance(more));
    }

    // All seeds at these shifts, but for the cell's own itself.
    template <class Visit>
    void for_each_image(const std::vector<exact::Shift>& shifts, Visit visit) {
        for (const exact::Shift& shift : shifts) {
            const exact::Point step = domain_.translation(shift);
            const std::size_t skipped = shift == exact::Shift{} ? own_ : at_.size();
            for (std::size_t s = 0; s < at_.size(); ++s) {
                const exact::Point& at = at_[s];
                const double square = distance_squared({at[0] + step[0], at[1] + step[1], at[2] + step[2]});
                if (s != skipped) visit(Image{square - weight(s), square, s, shift});
            }
        }
        work_ += static_cast<double>(at_.size()) * static_cast<double>(shifts.size());
    }

    // By a few that were not yet done.
    void cut_by_nearest(const std::vector<exact::Shift>& shifts, cpu::Cell& cell) {
        constexpr std::size_t most = 48;
        images_.clear();
        for_each_image(shifts, [&](const Image& image) {
            if (images_.size() == most && !(image.key < images_.front().key)) return;
            if (std::ranges::find(done_, image) != done_.end()) return;
            if (images_.size() == most) {
                std::ranges::pop_heap(images_, {}, &Image::key);
                images_.pop_back();
            }
            images_.push_back(image);
            std::ranges::push_heap(images_, {}, &Image::key);
        });
        std::ranges::sort(images_, {}, &Image::key);
        for (const Image& image : images_) cut(image, cell);
        done_.insert(done_.end(), images_.begin(), images_.end());
    }

    bool cut(const Image& image, cpu::Cell& cell) {
        const auto id = id_[image.slot];
        const auto j = static_cast<std::size_t>(id);
        exact::Shift total;
        for (std::size_t k = 0; k < 3; ++k) total[k] = image.shift[k] + shift_[image.slot][k] - shift_[own_][k];
        exact::Plane plane = exact::Plane::bisector(scaled_seed(job_, j), total, domain_.lattice);
        if (domain_.has_weights())
            plane.power = exact::two_sum(domain_.weights[static_cast<std::size_t>(id_[own_])], -domain_.weights[j]);
        work_ += work_of_plane + work_of_vertex * cell.slots();
        return cell.clip(id, plane, image.shift);
    }

    const Job& job_;
    const Domain& domain_;
    std::vector<std::size_t> slot_;  // by index
    std::vector<std::int32_t> id_;
    std::vector<exact::Shift> shift_;  // that wrapped the seed
    std::vector<exact::Point> at_;     // where to, rounded
    double largest_ = 0;               // what places were summed from; 0 when they are exact
    std::size_t own_ = 0;
    std::vector<Image> done_, images_;
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
    Options as_before;
    if (t.cell())
        as_before.cell = t.cell();
    else
        as_before.box = t.box(), as_before.periodic = t.periodic();
    as_before.planes.assign(t.planes().begin(), t.planes().end());
    as_before.outside = Outside::drop;
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

// Integrals over a cell are integrals over its faces, by the divergence theorem: the antiderivative of the density
// along the first axis of the grid, times the component of the normal along it. So only faces are cut by the grid. The
// antiderivative begins again in each row of grid cells along that axis, at the first one that the cell meets there. So
// its terms are those of the cell, and black surroundings of a cell have no part in its sums.
#include "fields/masses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

#include "core/convex_polygon.hpp"
#include "core/text.hpp"
#include "fields/cell_polygons.hpp"
#include "fields/slicer.hpp"
#include "input/domain_of_result.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "input/supports.hpp"

namespace votess {
namespace fields {
namespace {

constexpr std::size_t cells_of_task = 256;
constexpr std::size_t max_along_axis = std::size_t{1} << 20;

// Exact for polynomials of degree 3 on a triangle: its center, and three nodes with these shares of one corner and of
// the two others.
constexpr double center_weight = -27.0 / 48, node_weight = 25.0 / 48, near_share = 0.6, far_share = 0.2;

Vector area_of(std::span<const Vector> corners) {
    Vector area{};
    for (std::size_t c = 1; c + 1 < corners.size(); ++c) {
        const Vector twice = cross(minus(corners[c], corners[0]), minus(corners[c + 1], corners[0]));
        for (std::size_t k = 0; k < 3; ++k) area[k] += twice[k] / 2;
    }
    return area;
}

// Products of two coordinates, in their order: xx, xy, xz, yy, yz, zz.
using Products = std::array<double, 6>;
constexpr std::array<std::array<std::size_t, 2>, 6> factors{{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

// Integrals of 1, x and products of coordinates over the part of a cell's density on one side of faces.
struct Moments {
    double mass = 0;
    Vector first{};
    Products second{};
    // Adds a node. t: the antiderivatives along x of the density times 1, x and x^2; y, z: its other coordinates.
    void add(double weight, const Vector& t, double y, double z) {
        mass += weight * t[0];
        first[0] += weight * t[1], first[1] += weight * t[0] * y, first[2] += weight * t[0] * z;
        second[0] += weight * t[2], second[1] += weight * t[1] * y, second[2] += weight * t[1] * z;
        second[3] += weight * t[0] * y * y, second[4] += weight * t[0] * y * z, second[5] += weight * t[0] * z * z;
    }
};

// Where a part of a face lies, and the integrals over it of the normal's first component times 1, y, z, yy, yz and zz.
struct Part {
    Cell cell{};
    Products across{};
};

class Integrator {
public:
    // flat: null, or the cells of a sheet.
    Integrator(const Tessellation& t, const Frame& frame, std::span<const double> values, const FlatCells* flat,
               bool walls, Masses& out)
        : t_(t),
          frame_(frame),
          values_(values),
          flat_(flat),
          walls_(walls),
          out_(out),
          polygons_(t, frame),
          slicer_(frame),
          size_(frame.cell_size()),
          dimensions_(t.planar() ? 2 : 3),
          volumes_(flat != nullptr ? flat->volumes() : t.volumes()),
          areas_(flat != nullptr ? flat->areas() : t.face_areas()) {
        for (std::size_t k = 0; k < 3; ++k) {
            Vector step{};
            step[k] = 1;
            edges_[k] = frame.in_space(step);
        }
        const auto along = [&](std::size_t k) { return static_cast<std::size_t>(frame.axis(k).count); };
        row_step_ = along(1) * along(2);
    }

    void add_cell(std::size_t seed) {
        for (std::size_t k = 0; k < dimensions_; ++k)
            out_.centroids[dimensions_ * seed + k] = std::numeric_limits<double>::quiet_NaN();
        if (flat_ != nullptr ? t_.status()[seed] != CellStatus::certified : !polygons_.load(seed)) return;
        moments_ = {};
        volume_ = 0;
        parts_.clear();
        place_.at = flat_ != nullptr ? flat_->at(seed) : polygons_.at();
        first_ = flat_ != nullptr ? flat_->first(seed) : polygons_.first();
        const auto end = static_cast<std::size_t>(t_.indptr()[seed + 1]);
        for (auto entry = static_cast<std::size_t>(t_.indptr()[seed]); entry < end; ++entry) {
            const bool has_mass = walls_ || t_.indices()[entry] >= 0;
            if (flat_ != nullptr) {
                const FlatCells::Edge& edge = flat_->edge(entry);
                add_edge(entry, {edge.from[0], edge.from[1], 0}, {edge.to[0], edge.to[1], 0}, has_mass);
            } else if (dimensions_ == 2) {
                const auto [from, to] = polygons_.edge(entry);
                add_edge(entry, from, to, has_mass);
            } else {
                add_face(entry, polygons_.polygon(entry), has_mass);
            }
        }
        add_rows();
        finish(seed);
    }

private:
    [[nodiscard]] double value(const Cell& cell) const { return values_[frame_.index(cell)]; }
    // The first corner of the cell says where it lies.
    [[nodiscard]] double value_at_corner() const {
        Cell cell{};
        for (std::size_t k = 0; k < 3; ++k) cell[k] = frame_.cover(k, place_.at[k], 0, 0).first;
        return value(cell);
    }

    // The grid cells that a face meets along an axis. between: whether it lies between two layers of them.
    [[nodiscard]] Range cover(std::size_t k, double least, double largest, bool& between) const {
        const Range range = frame_.cover(k, place_.at[k], least, largest);
        between = least == largest && least == static_cast<double>(range.first) - place_.at[k] &&
                  (frame_.axis(k).periodic || range.first > 0);
        return range;
    }

    // The mean density of a face, by parts.
    struct Mean {
        double sum = 0, all = 0;
        void add(double density, double share) { sum += share * density, all += share; }
    };
    void set_face_mass(std::size_t entry, const Mean& mean, double area_in_grid) {
        const double density = mean.all > 0 ? mean.sum / mean.all : value_at_corner();
        out_.face_masses[entry] = density * (areas_.empty() ? area_in_grid : areas_[entry]);
    }

    void add_face(std::size_t entry, std::span<const Vector> corners, bool has_mass) {
        const Vector area = area_of(corners);
        if (corners.size() < 3 || (!has_mass && area[0] == 0)) return;
        Window window;
        std::array<bool, 3> between{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [least, largest] = std::ranges::minmax(corners, {}, [k](const Vector& x) { return x[k]; });
            window[k] = cover(k, least[k], largest[k], between[k]);
        }
        Mean mean;
        face_.corners.assign(corners.begin(), corners.end());
        slicer_.slice(face_, place_, window, [&](const Cell& cell, const ConvexPolygon& part) {
            if (has_mass) mean.add(mean_of_sides(cell, between), dot(area_of(part.corners), area));
            if (area[0] != 0) add_polygon(cell, part.corners);
        });
        if (has_mass) set_face_mass(entry, mean, area_in_space(area));
    }

    // Returns the area in space of a face that has this one in the grid.
    [[nodiscard]] double area_in_space(const Vector& area) const {
        Vector in_space{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector normal = cross(edges_[(k + 1) % 3], edges_[(k + 2) % 3]);
            for (std::size_t i = 0; i < 3; ++i) in_space[i] += area[k] * normal[i];
        }
        return length3(in_space[0], in_space[1], in_space[2]);
    }

    [[nodiscard]] double mean_of_sides(const Cell& cell, const std::array<bool, 3>& between) const {
        double mean = value(cell);
        for (std::size_t k = 0; k < 3; ++k) {
            if (!between[k]) continue;
            Cell other = cell;
            --other[k];
            mean = (mean + value(other)) / 2;
        }
        return mean;
    }

    // The side of a prism over an edge. The lines of the grid cut the edge.
    void add_edge(std::size_t entry, const Vector& a, const Vector& b, bool has_mass) {
        if (!has_mass && a[1] == b[1]) return;
        std::array<Range, 2> window;
        std::array<bool, 3> between{};
        Cell cell{};
        std::array<std::int64_t, 2> step{}, end{};
        for (std::size_t k = 0; k < 2; ++k) {
            window[k] = cover(k, std::min(a[k], b[k]), std::max(a[k], b[k]), between[k]);
            step[k] = b[k] < a[k] ? -1 : 1;
            cell[k] = step[k] > 0 ? window[k].first : window[k].last;
            end[k] = step[k] > 0 ? window[k].last : window[k].first;
        }
        // The share of the edge at which it leaves a cell along an axis.
        const auto leaves = [&](std::size_t k) {
            if (cell[k] == end[k]) return 1.0;
            const double line = static_cast<double>(step[k] > 0 ? cell[k] + 1 : cell[k]) - place_.at[k];
            return std::clamp((line - a[k]) / (b[k] - a[k]), 0.0, 1.0);
        };
        std::array<double, 2> next{leaves(0), leaves(1)};
        Mean mean;
        double done = 0;
        Vector from = a;
        while (true) {
            const std::size_t k = next[1] < next[0] ? 1 : 0;
            const bool last = cell[0] == end[0] && cell[1] == end[1];
            const double share = last ? 1 : std::max(done, next[k]);
            Vector to = b;
            for (std::size_t i = 0; i < 2 && !last; ++i) to[i] = a[i] + share * (b[i] - a[i]);
            if (share > done || last) {
                if (has_mass) mean.add(mean_of_sides(cell, between), share - done);
                if (a[1] != b[1]) add_side(cell, from, to);
            }
            if (last) break;
            from = to;
            done = share;
            const std::size_t along = cell[k] == end[k] ? 1 - k : k;
            cell[along] += step[along];
            next[along] = leaves(along);
        }
        if (has_mass) set_face_mass(entry, mean, area_in_space({b[1] - a[1], a[0] - b[0], 0}));
    }

    // Adds nodes of a part of a face. weight: of the normal's first component.
    class Nodes {
    public:
        Nodes(Integrator& to, const Cell& cell)
            : to_(to),
              part_{cell, {}},
              density_(to.value(cell)),
              low_(static_cast<double>(cell[0]) - to.place_.at[0]) {}
        void add(double weight, const Vector& x) {
            const double y = x[1], z = x[2], inside = x[0] - low_;
            to_.volume_ += weight * x[0];
            const Products terms{1, y, z, y * y, y * z, z * z};
            for (std::size_t n = 0; n < 6; ++n) part_.across[n] += weight * terms[n];
            const double first = inside * (x[0] + low_) / 2;
            const double second = inside * (x[0] * x[0] + x[0] * low_ + low_ * low_) / 3;
            if (density_ > 0) to_.moments_.add(density_ * weight, {inside, first, second}, y, z);
        }
        void end() { to_.parts_.push_back(part_); }

    private:
        Integrator& to_;
        Part part_;
        double density_, low_;
    };

    // Two nodes of Gauss are exact for polynomials of degree 3.
    void add_side(const Cell& cell, const Vector& from, const Vector& to) {
        Nodes nodes(*this, cell);
        for (const double share : {0.5 - std::sqrt(1.0 / 12), 0.5 + std::sqrt(1.0 / 12)})
            nodes.add((to[1] - from[1]) / 2,
                      {from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1]), from[2]});
        nodes.end();
    }

    void add_polygon(const Cell& cell, std::span<const Vector> corners) {
        Nodes nodes(*this, cell);
        for (std::size_t c = 1; c + 1 < corners.size(); ++c) {
            const Vector &a = corners[0], &b = corners[c], &d = corners[c + 1];
            const double area = ((b[1] - a[1]) * (d[2] - a[2]) - (b[2] - a[2]) * (d[1] - a[1])) / 2;
            Vector sum, p, q, r;
            for (std::size_t k = 0; k < 3; ++k) {
                sum[k] = a[k] + b[k] + d[k];
                p[k] = far_share * sum[k] + (near_share - far_share) * a[k];
                q[k] = far_share * sum[k] + (near_share - far_share) * b[k];
                r[k] = far_share * sum[k] + (near_share - far_share) * d[k];
                sum[k] /= 3;
            }
            nodes.add(center_weight * area, sum);
            nodes.add(node_weight * area, p);
            nodes.add(node_weight * area, q);
            nodes.add(node_weight * area, r);
        }
        nodes.end();
    }

    // Adds the grid cells between the parts of faces and the beginning of each row.
    void add_rows() {
        const auto row_first = [](const Part& part) { return std::tuple(part.cell[1], part.cell[2], part.cell[0]); };
        std::ranges::sort(parts_, {}, row_first);
        Cell cell{};             // the next of the row
        Vector t{};              // the sums before it
        std::int64_t along = 0;  // its number in the domain
        const std::int64_t count = frame_.axis(0).count;
        std::size_t at = 0;  // of its value
        for (const Part& part : parts_) {
            if (&part == parts_.data() || part.cell[1] != cell[1] || part.cell[2] != cell[2]) {
                cell = part.cell;
                t = {};
                along = modulo(cell[0], count);
                at = frame_.index(cell);
            }
            for (; cell[0] < part.cell[0]; ++cell[0], ++along, at += row_step_) {
                if (along == count) along = 0, at -= static_cast<std::size_t>(count) * row_step_;
                const double density = values_[at], low = static_cast<double>(cell[0]) - place_.at[0];
                t[0] += density;
                t[1] += density * (low + 0.5);
                t[2] += density * (low * low + low + 1.0 / 3);
            }
            if (t[0] == 0) continue;
            const Products& by = part.across;
            moments_.mass += by[0] * t[0];
            moments_.first[0] += by[0] * t[1], moments_.first[1] += by[1] * t[0], moments_.first[2] += by[2] * t[0];
            moments_.second[0] += by[0] * t[2], moments_.second[1] += by[1] * t[1], moments_.second[2] += by[2] * t[1];
            for (std::size_t n = 3; n < 6; ++n) moments_.second[n] += by[n] * t[0];
        }
    }

    // The volume of a tiny cell has more digits than the polyhedron of its rounded vertices.
    void finish(std::size_t seed) {
        double volume = std::ldexp(volume_ * size_.mantissa, size_.exponent);
        if (!volumes_.empty()) {
            const double stated = volumes_[seed];
            if (!(volume > stated / 2 && volume < 2 * stated)) {
                moments_ = {value_at_corner(), {}, {}};
                volume_ = 1;
            }
            volume = stated;
        }
        const double mass = std::max(0.0, moments_.mass / volume_);
        out_.masses[seed] = mass * volume;
        if (!(out_.masses[seed] > 0)) return;
        Vector center{};
        for (std::size_t k = 0; k < 3; ++k) center[k] = moments_.first[k] / moments_.mass;
        const Vector place = frame_.in_space(center);
        for (std::size_t k = 0; k < dimensions_; ++k) out_.centroids[dimensions_ * seed + k] = first_[k] + place[k];
        double second = 0;
        for (std::size_t n = 0; n < 6; ++n) {
            const auto [i, j] = factors[n];
            if (j >= dimensions_) continue;
            const double central = moments_.second[n] / moments_.mass - center[i] * center[j];
            second += (i == j ? 1 : 2) * central * dot(edges_[i], edges_[j]);
        }
        out_.second_moments[seed] = std::max(0.0, second) * out_.masses[seed];
    }

    const Tessellation& t_;
    const Frame& frame_;
    std::span<const double> values_;
    const FlatCells* flat_;
    bool walls_;
    Masses& out_;
    CellPolygons polygons_;
    Slicer<ConvexPolygon> slicer_;
    Size size_;  // of a grid cell
    std::size_t dimensions_;
    std::span<const double> volumes_, areas_;  // as stated; may be empty
    std::array<Vector, 3> edges_{};            // of a grid cell, in space
    std::size_t row_step_ = 1;                 // in the array, from a grid cell to the next along the first axis
    Place place_;
    Vector first_{};  // corner of the cell, in space
    ConvexPolygon face_;
    // The cell in the grid, relative to its first corner.
    double volume_ = 0;
    Moments moments_;
    std::vector<Part> parts_;
};

}  // namespace

std::vector<double> checked_values(const Density& density, bool planar, const std::string& function, bool may_be_zero) {
    const auto refuse = [&](const std::string& message) {
        throw Error(ErrorCode::invalid_argument, function + "(): the density: " + message);
    };
    std::size_t cells = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t along = density.shape[k];
        if (along == 0 || along > max_along_axis)
            refuse("shape[" + std::to_string(k) + "] = " + std::to_string(along) + " is not from 1 to " +
                   std::to_string(max_along_axis));
        cells *= along;
    }
    if (planar && density.shape[2] != 1)
        refuse("shape[2] = " + std::to_string(density.shape[2]) + ": give 1 in two dimensions");
    if (density.values.size() != cells)
        refuse("there are " + std::to_string(density.values.size()) + " values, the shape needs " +
               std::to_string(cells));
    std::vector<double> values;
    values.reserve(cells);
    double sum = 0;
    in_pieces(cells, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            values.push_back(density.values[i]);
            sum += values[i];
            if (!(values[i] >= 0) || !std::isfinite(values[i]))
                refuse("value " + std::to_string(i) + " is " + number(values[i]) +
                       ": it must be finite and not negative");
        }
    });
    if (!std::isfinite(sum)) refuse("its values sum to " + number(sum) + ": give it in another unit");
    if (sum == 0 && !may_be_zero) refuse("all values are 0: there is no mass to divide");
    return values;
}

Masses masses_in(const Tessellation& t, const Frame& frame, std::span<const double> values, ThreadPool& pool,
                 bool walls, const FlatCells* flat) {
    Masses out;
    out.masses.resize(t.size());
    out.centroids.resize(t.size() * (t.planar() ? 2 : 3));
    out.second_moments.resize(t.size());
    out.face_masses.resize(t.indices().size());
    std::vector<std::unique_ptr<Integrator>> workers;
    for (unsigned w = 0; w < pool.size(); ++w)
        workers.push_back(std::make_unique<Integrator>(t, frame, values, flat, walls, out));
    pool.run(ceil_div(t.size(), cells_of_task), [&](std::size_t task, unsigned worker) {
        check_stop();
        for (std::size_t seed = task * cells_of_task; seed < std::min(t.size(), (task + 1) * cells_of_task); ++seed)
            workers[worker]->add_cell(seed);
    });
    return out;
}

}  // namespace fields

Masses masses(const Tessellation& t, const Density& density, unsigned threads) {
    require(t, "masses");
    const auto refuse = [](const std::string& message) {
        throw Error(ErrorCode::invalid_argument, "masses(): " + message);
    };
    check_member("threads", threads);
    const std::vector<double> values = fields::checked_values(density, t.planar(), "masses", true);
    if (t.size() == 0) return {};
    if (t.face_offsets().size() != t.indices().size() + 1)
        refuse("the tessellation has no polygons, set " + option("want.faces"));
    if (t.least_face() > 0)
        refuse("faces were dropped, and cells need them all: leave out " + option("min_face") + " and " +
               option("min_area"));
    if (EndlessSides(region_of(t)).any())
        refuse("cells that reach infinity have no mass, give a box with ends: set " + option("box"));
    ThreadPool pool(threads, "threads");
    return fields::masses_in(t, fields::Frame(t, density.shape), values, pool, true);
}

}  // namespace votess

#include "oracle/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "oracle/integer_polytope.hpp"
#include "support/text.hpp"

namespace test {
namespace {

constexpr std::size_t max_planes = 150;  // in one cell: the time grows with their cube
constexpr std::size_t max_seeds_remade = 60;

class Judge {
public:
    Judge(const votess::Tessellation& t, std::span<const double> points, const votess::Options& options)
        : t_(t), points_(points), options_(options), domain_(points, options) {
        mpf_set_default_prec(is_thin() ? many_digits : digits);
        find_duplicates();
    }

    std::string status(std::size_t i) const {
        using votess::CellStatus;
        const auto given = t_.status()[i];
        if ((given == CellStatus::outside) != domain_.is_outside(i))
            return domain_.is_outside(i) ? "lies outside and has a cell" : "is called outside";
        if (given == CellStatus::outside) return "";
        if (lighter_[i] != 0) return given == CellStatus::empty ? "" : "has a cell, and a heavier seed is at its place";
        if ((given == CellStatus::duplicate) != (duplicate_of_[i] >= 0))
            return duplicate_of_[i] >= 0 ? text("is a duplicate of ", duplicate_of_[i], " and has a cell")
                                         : "is called a duplicate";
        if (given == CellStatus::duplicate)
            return t_.duplicate_of()[i] == duplicate_of_[i] ? "" : text("is a duplicate of ", duplicate_of_[i]);
        if (given != CellStatus::certified && given != CellStatus::empty)
            return text("has status ", static_cast<int>(given));
        return "";
    }

    std::string cell(std::size_t i) {
        if (const std::string wrong = status(i); !wrong.empty()) return wrong;
        const auto row = t_.neighbors(i);
        if (t_.status()[i] != votess::CellStatus::certified) {
            if (!row.empty()) return "has no cell and a row";
            return takes_part(i) ? check_empty(i) : "";
        }
        std::vector<IntegerPlane> planes;
        std::vector<ExactFace> listed;
        for (std::size_t k = 0; k < row.size(); ++k) {
            const ExactFace face = face_of(t_, i, k);
            if (!listed.empty() && !(listed.back() < face)) return "has a row that does not ascend";
            listed.push_back(face);
            if (face.id < 0) continue;
            if (face.id >= static_cast<std::int32_t>(t_.size()) ||
                t_.status()[face.id] != votess::CellStatus::certified)
                return "lists " + name(face) + ", which has no cell";
            planes.push_back(domain_.bisector(i, static_cast<std::size_t>(face.id), face.shift));
        }
        for (IntegerPlane& wall : domain_.walls(i)) planes.push_back(std::move(wall));
        drop_hidden_walls(planes);
        if (planes.size() > max_planes) return "";
        const std::vector<Vertex> vertices = find_vertices(planes);
        std::string wrong;
        const std::vector<Face> faces = find_faces(planes, vertices, wrong);
        if (!wrong.empty()) return wrong;
        if (faces.size() < 4) return "is not closed by the faces that it lists";
        if (t_.lists_walls()) {
            std::vector<ExactFace> exact;
            for (const Face& face : faces) exact.push_back(planes[face.plane].face);
            std::ranges::sort(exact);
            if (exact != listed) return "lists walls that it has not, or lacks some";
        }
        if (wrong = check_others(i, planes, vertices, faces, listed); !wrong.empty()) return wrong;
        return check_numbers(i, planes, vertices, faces, listed);
    }

    // What is right, as far as that can be made in reasonable time.
    std::string exact_row(std::size_t i) const {
        if (t_.size() > max_seeds_remade || !takes_part(i)) return "";
        std::string line = "; exact are";
        for (const ExactFace& face : make(i).faces) line += ' ' + name(face);
        return line;
    }

private:
    // Whether cells may be as thin as the least double. Their volumes are differences of numbers of order one.
    bool is_thin() const {
        const auto is_tiny = [](double x) { return x != 0 && std::abs(x) < 0x1p-200; };
        bool thin = std::ranges::any_of(points_, is_tiny);
        if (options_.box)
            thin |=
                std::ranges::any_of(options_.box->lower, is_tiny) || std::ranges::any_of(options_.box->upper, is_tiny);
        return thin;
    }

    // The heaviest seed at a place has the cell, the first when there are several; those are its duplicates.
    void find_duplicates() {
        std::map<Integers, std::size_t, bool (*)(const Integers&, const Integers&)> best(
            [](const Integers& a, const Integers& b) {
                for (std::size_t k = 0; k < 3; ++k)
                    if (const int order = cmp(a[k], b[k]); order != 0) return order < 0;
                return false;
            });
        const auto weight = [&](std::size_t i) { return options_.weights.empty() ? 0 : options_.weights[i]; };
        for (std::size_t i = 0; i < domain_.size(); ++i) {
            if (domain_.is_outside(i)) continue;
            const auto [it, is_new] = best.emplace(domain_.place(i), i);
            if (!is_new && weight(i) > weight(it->second)) it->second = i;
        }
        duplicate_of_.assign(domain_.size(), -1);
        lighter_.assign(domain_.size(), 0);
        for (std::size_t i = 0; i < domain_.size(); ++i) {
            if (domain_.is_outside(i)) continue;
            const std::size_t other = best.at(domain_.place(i));
            if (weight(i) < weight(other)) {
                lighter_[i] = 1;
            } else if (i != other) {
                duplicate_of_[i] = static_cast<std::int32_t>(other);
            }
        }
    }
    // Whether the seed is one of those that share the space.
    [[nodiscard]] bool takes_part(std::size_t i) const {
        return !domain_.is_outside(i) && duplicate_of_[i] < 0 && lighter_[i] == 0;
    }

    // Two walls in one plane, or a listed face in a wall's: the first wall's is meant.
    static void drop_hidden_walls(std::vector<IntegerPlane>& planes) {
        std::erase_if(planes, [&](const IntegerPlane& wall) {
            return wall.face.id < 0 && std::ranges::any_of(planes, [&](const IntegerPlane& other) {
                       return other.face.id < 0 && other.face.id > wall.face.id && coincide(other, wall);
                   });
        });
    }

    ExactDomainCell make(std::size_t i) const {
        // Duplicates and seeds outside are left out, and ids stay those of the input.
        std::vector<double> points;
        std::vector<double> weights;
        std::vector<std::int32_t> id;
        std::size_t at = 0;
        for (std::size_t j = 0; j < t_.size(); ++j) {
            if (!takes_part(j)) continue;
            if (j == i) at = id.size();
            id.push_back(static_cast<std::int32_t>(j));
            points.insert(points.end(), points_.begin() + static_cast<std::ptrdiff_t>(3 * j),
                          points_.begin() + static_cast<std::ptrdiff_t>(3 * j + 3));
            if (!options_.weights.empty()) weights.push_back(options_.weights[j]);
        }
        votess::Options options = options_;
        options.weights = weights;
        ExactDomainCell cell = exact_cell(points, options, at, {});
        for (ExactFace& face : cell.faces)
            if (face.id >= 0) face.id = id[static_cast<std::size_t>(face.id)];
        return cell;
    }

    std::string check_empty(std::size_t i) const {
        if (t_.size() > max_seeds_remade) return "";
        return make(i).faces.empty() ? "" : "is called empty";
    }

    std::string check_others(std::size_t i, const std::vector<IntegerPlane>& planes,
                             const std::vector<Vertex>& vertices, const std::vector<Face>& faces,
                             const std::vector<ExactFace>& listed) const {
        int touching = 0;
        for (std::size_t j = 0; j < t_.size(); ++j) {
            if (!takes_part(j)) continue;
            for (const auto& shift : domain_.near_shifts(i, j)) {
                if (j == i && shift == std::array<int, 3>{}) continue;
                const IntegerPlane plane = domain_.bisector(i, j, shift);
                if (std::ranges::binary_search(listed, plane.face)) continue;
                if (cuts(plane, vertices, touching)) return "lacks " + name(plane.face);
                if (touching < 3) continue;
                for (const Face& face : faces)
                    if (coincide(plane, planes[face.plane]) && hides(plane, planes[face.plane]))
                        return "lists " + name(planes[face.plane].face) + " where in the same plane " +
                               name(plane.face) + " is the neighbor";
            }
        }
        return "";
    }

    std::string check_numbers(std::size_t i, const std::vector<IntegerPlane>& planes,
                              const std::vector<Vertex>& vertices, const std::vector<Face>& faces,
                              const std::vector<ExactFace>& listed) const {
        std::size_t corners = 0;
        for (const Face& face : faces) corners += face.corners.size();
        if (!t_.face_counts().empty() && (t_.face_counts()[i] != faces.size() || t_.edge_counts()[i] != corners / 2 ||
                                          t_.vertex_counts()[i] != vertices.size()))
            return text("counts ", t_.face_counts()[i], " faces, ", t_.edge_counts()[i], " edges, ",
                        t_.vertex_counts()[i], " vertices instead of ", faces.size(), ", ", corners / 2, ", ",
                        vertices.size());
        Real unit = 1;
        if (domain_.quantum() >= 0)
            unit <<= static_cast<mp_bitcnt_t>(domain_.quantum());
        else
            unit >>= static_cast<mp_bitcnt_t>(-domain_.quantum());
        const auto real = [&](const Integers& x, const Real& by) -> Reals {
            return {Real(Real(x[0]) * unit / by), Real(Real(x[1]) * unit / by), Real(Real(x[2]) * unit / by)};
        };
        std::vector<Reals> at;
        Real farthest = 0;
        Reals least, most;
        for (const Vertex& v : vertices) {
            at.push_back(real(v.x, Real(v.w)));
            const Real square = dot(at.back(), at.back());
            if (square > farthest) farthest = square;
            for (std::size_t k = 0; k < 3; ++k) {
                if (at.size() == 1 || at.back()[k] < least[k]) least[k] = at.back()[k];
                if (at.size() == 1 || at.back()[k] > most[k]) most[k] = at.back()[k];
            }
        }
        Real volume = 0, surface = 0;
        Reals moment{Real(0), Real(0), Real(0)};
        std::vector<Real> areas(planes.size());
        for (const Face& face : faces) {
            const IntegerPlane& plane = planes[face.plane];
            Reals turn{Real(0), Real(0), Real(0)};
            Real part = 0;
            Reals part_moment{Real(0), Real(0), Real(0)};
            const Reals& a = at[face.corners[0]];
            for (std::size_t k = 1; k + 1 < face.corners.size(); ++k) {
                const Reals &b = at[face.corners[k]], &c = at[face.corners[k + 1]];
                const Reals piece = cross(minus(b, a), minus(c, a));
                const Real six = dot(a, piece);
                part += six;
                for (std::size_t x = 0; x < 3; ++x) {
                    turn[x] += piece[x];
                    part_moment[x] += six * (a[x] + b[x] + c[x]) / 4;
                }
            }
            const Reals n{Real(plane.n[0]), Real(plane.n[1]), Real(plane.n[2])};
            const int outward = sgn(dot(turn, n));
            areas[face.plane] = sqrt(dot(turn, turn)) / 2;
            surface += areas[face.plane];
            volume += outward * part / 6;
            for (std::size_t x = 0; x < 3; ++x) moment[x] += outward * part_moment[x] / 6;
        }
        const bool single = t_.stats().precision == votess::Precision::single;
        const double relative = single ? 1e-5 : 1e-10;
        const auto differs = [](double given, const Real& exact, const Real& tolerance) {
            return !std::isfinite(given) || abs(Real(given) - exact) > tolerance + 64 * Real(0x1p-1074);
        };
        if (!t_.volumes().empty() && differs(t_.volumes()[i], volume, relative * volume))
            return text("has volume ", t_.volumes()[i], " instead of ", volume.get_d());
        if (!t_.surface_areas().empty() && differs(t_.surface_areas()[i], surface, relative * surface))
            return text("has surface ", t_.surface_areas()[i], " instead of ", surface.get_d());
        if (!t_.security_radii().empty()) {
            const Real radius = 2 * sqrt(farthest);
            if (differs(t_.security_radii()[i], radius, relative * radius))
                return text("has radius ", t_.security_radii()[i], " instead of ", radius.get_d());
        }
        const Reals seed = real(domain_.place(i), Real(1));
        Real extent = 0;
        for (std::size_t k = 0; k < 3; ++k)
            if (most[k] - least[k] > extent) extent = most[k] - least[k];
        const Real length = sqrt(farthest);
        for (std::size_t k = 0; k < 3 && !t_.centroids().empty(); ++k) {
            const Real c = seed[k] + moment[k] / volume;
            const double given = t_.centroids()[3 * i + k];
            // A seed with a weight, or beyond a wall, may lie far outside of its cell, whose vertices are rounded as
            // seen from it.
            const bool near =
                options_.weights.empty() && !domain_.is_periodic() && options_.outside != votess::Outside::keep;
            const Real rounding = near ? Real(4 * 0x1p-53 * abs(c)) : Real(1000 * 0x1p-53 * (abs(c) + length));
            if ((near || volume > 1e-280) && differs(given, c, relative * extent + rounding))
                return text("has the centroid's coordinate ", k, " at ", given, " instead of ", c.get_d());
        }
        for (const Face& face : faces) {
            const IntegerPlane& plane = planes[face.plane];
            const auto found = std::ranges::lower_bound(listed, plane.face);
            if (found == listed.end() || *found != plane.face) continue;
            const std::size_t e = static_cast<std::size_t>(t_.indptr()[i] + (found - listed.begin()));
            if (!t_.face_areas().empty() && differs(t_.face_areas()[e], areas[face.plane], relative * surface))
                return text("has with ", name(plane.face), " the area ", t_.face_areas()[e], " instead of ",
                            areas[face.plane].get_d());
            if (t_.face_normals().empty()) continue;
            const Real length = sqrt(Real(dot(plane.n, plane.n)));
            for (std::size_t k = 0; k < 3; ++k) {
                const Real n = Real(plane.n[k]) / length;
                if (differs(t_.face_normals()[3 * e + k], n, single ? 1e-5 : 1e-14))
                    return text("has with ", name(plane.face), " the normal's component ", k, " at ",
                                t_.face_normals()[3 * e + k], " instead of ", n.get_d());
            }
        }
        return "";
    }

    const votess::Tessellation& t_;
    std::span<const double> points_;
    const votess::Options& options_;
    IntegerDomain domain_;
    std::vector<std::int32_t> duplicate_of_;
    std::vector<char> lighter_;
};

}  // namespace

std::string check_certificate(const votess::Tessellation& t, std::span<const double> points, votess::Options options,
                              std::vector<std::size_t> cells) {
    if (t.size() == 0) return "";
    if (!options.cell) options.box = t.box();
    Judge judge(t, points, options);
    if (cells.empty()) {
        cells.resize(t.size());
        std::iota(cells.begin(), cells.end(), std::size_t{0});
    }
    for (const std::size_t i : cells)
        if (const std::string wrong = judge.cell(i); !wrong.empty()) {
            std::string row;
            for (std::size_t k = 0; k < t.neighbors(i).size(); ++k) row += ' ' + name(face_of(t, i, k));
            return text("cell ", i, ' ', wrong, "; listed are", row, judge.exact_row(i));
        }
    return "";
}

}  // namespace test

// Few seeds in small meshes against rational arithmetic. Each triangle and a fixed place make a tetrahedron. The part
// of a cell in the mesh is the sum of its parts in those, with their signs.
#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <string>

#include "oracle/exact_polygons.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/solids.hpp"
#include "support/text.hpp"

namespace {

using test::clip;
using test::cross;
using test::dot;
using test::doubled_area;
using test::exact_polygons;
using test::ExactPolygon;
using test::minus;
using test::opposite;
using test::RationalVector;
using test::Solid;
using votess::Options;
using Corners = std::vector<RationalVector>;

struct Part {
    mpq_class volume;
    RationalVector moment;  // relative to the seed
    double surface = 0;
    std::map<std::int32_t, double> areas;  // of faces, by neighbor
};

// A cone from `apex` over a polygon.
void add_cone(Part& part, const RationalVector& apex, const Corners& polygon, int sign) {
    for (std::size_t i = 2; i < polygon.size(); ++i) {
        const RationalVector a = minus(polygon[0], apex), b = minus(polygon[i - 1], apex), c = minus(polygon[i], apex);
        const mpq_class volume = sign * dot(a, cross(b, c)) / 6;
        part.volume += volume;
        for (std::size_t k = 0; k < 3; ++k)
            part.moment[k] += volume * (apex[k] + polygon[0][k] + polygon[i - 1][k] + polygon[i][k]) / 4;
    }
}

double length(const RationalVector& v) {
    return std::sqrt(mpq_class(dot(v, v)).get_d());
}

struct FacePart {
    Corners corners;
    mpq_class inner, outer;
};

// Cuts a face by the triangles that meet it, if the mesh bounds it from both sides. Else the whole face has the larger
// winding number on one side.
std::vector<FacePart> parts_of(const ExactPolygon& face, const std::vector<Corners>& triangles) {
    std::vector<FacePart> parts{{face.corners, 0, 0}};
    std::array<bool, 2> bounded{};
    std::vector<std::pair<RationalVector, mpq_class>> planes;
    for (const Corners& t : triangles) {
        const RationalVector normal = cross(minus(t[1], t[0]), minus(t[2], t[0]));
        const bool lies_on = std::ranges::all_of(t, [&](const auto& x) { return dot(face.n, x) == face.h; });
        if (lies_on) bounded[dot(face.n, normal) > 0 ? 1 : 0] = true;
        for (std::size_t k = 0; k < (lies_on ? 3 : 1); ++k) {
            const RationalVector n = lies_on ? cross(face.n, minus(t[(k + 1) % 3], t[k])) : normal;
            planes.emplace_back(n, dot(n, t[k]));
        }
    }
    if (!bounded[0] || !bounded[1]) return parts;
    for (const auto& [n, h] : planes) {
        std::vector<FacePart> halves;
        for (const FacePart& part : parts) {
            std::array<Corners, 2> half{part.corners, part.corners};
            clip(half[0], n, h);
            clip(half[1], opposite(n), -h);
            for (Corners& corners : half)
                if (dot(doubled_area(corners), face.n) > 0) halves.push_back({std::move(corners), 0, 0});
        }
        parts = std::move(halves);
    }
    return parts;
}

Part exact_part(const std::vector<ExactPolygon>& faces, const std::vector<Corners>& triangles) {
    Part part;
    if (faces.empty()) return part;
    // By face: parts with one winding number on each side, and their areas there in units of n.
    std::vector<std::vector<FacePart>> parts;
    for (const ExactPolygon& face : faces) parts.push_back(parts_of(face, triangles));
    const RationalVector& apex = triangles[0][0];
    for (const Corners& triangle : triangles) {
        const RationalVector normal = cross(minus(triangle[1], triangle[0]), minus(triangle[2], triangle[0]));
        Corners inside = triangle;
        bool bounds_other = false;  // the cell behind a face of this one
        for (const ExactPolygon& face : faces) {
            clip(inside, face.n, face.h);
            bool on_face = true;
            for (const RationalVector& x : triangle) on_face &= dot(face.n, x) == face.h;
            bounds_other |= on_face && dot(normal, face.n) < 0;
        }
        if (!bounds_other) part.surface += length(doubled_area(inside)) / 2;

        const int sign = sgn(dot(minus(triangle[0], apex), normal));
        if (sign == 0) continue;
        const std::array<RationalVector, 4> corners{triangle[0], triangle[1], triangle[2], apex};
        bool beyond_any = false;
        std::vector<std::array<int, 4>> sides;
        for (const ExactPolygon& face : faces) {
            std::array<int, 4> side;
            for (std::size_t i = 0; i < 4; ++i) side[i] = sgn(dot(face.n, corners[i]) - face.h);
            beyond_any |= std::ranges::none_of(side, [](int s) { return s < 0; });
            sides.push_back(side);
        }
        if (!beyond_any) add_cone(part, apex, inside, 1);
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const bool is_beyond = std::ranges::none_of(sides[f], [](int s) { return s < 0; });
            const bool is_before = std::ranges::none_of(sides[f], [](int s) { return s > 0; });
            if ((is_beyond || is_before) && std::ranges::count(sides[f], 0) < 3) continue;
            const bool holds_triangle = sides[f][0] == 0 && sides[f][1] == 0 && sides[f][2] == 0;  // which is counted
            for (FacePart& on_face : parts[f]) {
                Corners polygon = on_face.corners;
                for (std::size_t i = 0; i < 4; ++i) {  // the plane across from corner i
                    const RationalVector &a = corners[(i + 1) % 4], &b = corners[(i + 2) % 4],
                                         &c = corners[(i + 3) % 4];
                    RationalVector n = cross(minus(b, a), minus(c, a));
                    if (dot(n, minus(corners[i], a)) > 0) n = opposite(n);
                    clip(polygon, n, dot(n, a));
                }
                const mpq_class area = sign * dot(doubled_area(polygon), faces[f].n) / 2;
                if (!is_beyond) on_face.inner += area;
                if (!is_before) on_face.outer += area;
                if (!beyond_any && !holds_triangle) add_cone(part, apex, polygon, sign);
            }
        }
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
        mpq_class area;
        for (const FacePart& on_face : parts[f]) area += std::min(on_face.inner, on_face.outer);
        if (area != 0) part.areas[faces[f].face.id] = area.get_d() / length(faces[f].n);
    }
    return part;
}

// Compares all cells of a run with volumes, centroids, areas and surfaces; "" if they are equal.
std::string difference(const std::vector<double>& points, const Solid& solid, std::span<const double> weights = {},
                       double reach = 2) {
    Options options = test::all_options(test::cube(-reach, reach));
    options.device = "cpu";
    options.want.counts = false;
    options.want.surfaces = true;
    options.mesh = solid.mesh();
    options.weights = weights;
    const auto t = votess::tessellate(points, options);
    const double size = 10 * reach, square = 10 * reach * reach;
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto relative = [&](const double* x) {
            RationalVector r;
            for (std::size_t k = 0; k < 3; ++k) r[k] = mpq_class(x[k]) - mpq_class(points[3 * i + k]);
            return r;
        };
        std::vector<Corners> triangles;
        for (std::size_t v = 0; v < solid.triangles.size(); ++v) {
            if (v % 3 == 0) triangles.emplace_back();
            triangles.back().push_back(relative(&solid.vertices[3 * static_cast<std::size_t>(solid.triangles[v])]));
        }
        const Part part = exact_part(exact_polygons(points, options, i), triangles);
        const double volume = part.volume.get_d();
        const auto close = [](double x, double y, double size) { return std::abs(x - y) <= 1e-12 * size; };
        if (!(std::abs(t.volumes()[i] - volume) <= 1e-10 * std::abs(volume)))
            return test::text("cell ", i, " has the volume ", t.volumes()[i], ", exact is ", volume);
        if ((t.status()[i] == votess::CellStatus::certified) != (volume != 0))
            return test::text("cell ", i, " with the volume ", volume, " has the wrong status");
        for (std::size_t k = 0; k < 3 && volume != 0; ++k)
            if (!close(t.centroids()[3 * i + k] - points[3 * i + k], mpq_class(part.moment[k] / part.volume).get_d(),
                       size))
                return test::text("cell ", i, " has another centroid along axis ", k);
        const auto row = t.neighbors(i);
        double surface = volume == 0 ? 0 : part.surface;
        if (!close(t.mesh_areas()[i], surface, square))
            return test::text("cell ", i, " has the area ", t.mesh_areas()[i], " of the mesh, exact is ", surface);
        for (std::size_t k = 0; k < row.size(); ++k) {
            const auto found = part.areas.find(row[k]);
            const double area = t.face_areas()[static_cast<std::size_t>(t.indptr()[i]) + k];
            if (found == part.areas.end() || !close(area, found->second, square))
                return test::text("cells ", i, " and ", row[k], " share the area ", area, ", exact is ",
                                  found == part.areas.end() ? 0 : found->second);
            surface += area;
        }
        if (row.size() != part.areas.size())
            return test::text("cell ", i, " has ", row.size(), " neighbors, exact are ", part.areas.size());
        if (!close(t.surface_areas()[i], surface, square)) return test::text("cell ", i, " has another surface");
    }
    return "";
}

}  // namespace

TEST_SUITE("oracle") {
    // The face z = 0.5 lies in the surface. Below it the mesh is on the left, above it on the right.
    TEST_CASE("cells in meshes: a face that the mesh bounds from both sides") {
        for (const double middle : {0.25, 0.5, 0.625, 1.0}) {
            CAPTURE(middle);
            Solid solid = test::joined(test::cuboid({0, 0, 0}, {0.5, 1, 0.5}),
                                       test::cuboid({middle, 0, 0.5}, {middle + 0.5, 1, 1}));
            std::vector<double> points{0.5, 0.5, 0.25, 0.5, 0.5, 0.75};
            CHECK(difference(points, solid) == "");
            solid = solid.reversed();  // mirrored, ties put the triangles into the other cell
            for (auto* coordinates : {&points, &solid.vertices})
                for (std::size_t i = 2; i < coordinates->size(); i += 3) (*coordinates)[i] *= -1;
            CHECK(difference(points, solid) == "");
        }
    }

    // The mesh touches an edge of cell 1, at its end.
    TEST_CASE("cells in meshes: a mesh that touches an edge of a cell") {
        const std::vector<double> points{1.25, 0.875, -0.25, 0.5,   0.875, -0.25, 0.125, 1.25, 0.5,
                                         0.5,  0.875, 0.875, 0.125, -0.25, 0.125, -0.25, 1.25, -0.25};
        const Solid solid = test::joined(test::cuboid({0.5, 0.5, 0.375}, {1.125, 0.875, 0.625}),
                                         test::cuboid({0.375, 0, 0.125}, {0.875, 0.25, 0.375}));
        CHECK(difference(points, solid) == "");
    }

    // Corners are then quotients of numbers as small as their rounding errors.
    TEST_CASE("cells in meshes: sides within rounding of bisectors") {
        using test::NearBisector;
        test::Random random(60);
        for (std::size_t number = 0; number < test::by_size(16, 4); ++number) {
            CAPTURE(number);
            const auto kind = static_cast<NearBisector::Kind>(number % 4);
            NearBisector set;
            do set = test::near_bisector(kind, random);
            while (set.points.size() > 24);  // more seeds take seconds
            CHECK(difference(set.points, set.solid, {}, set.reach) == "");
        }
    }

    // The part of cell 0 is 1 x 1 x thickness.
    TEST_CASE("cells in meshes: slabs of a cell") {
        std::vector<double> points{0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
        for (const double size : {3.0, 1e3, 1e6, 1e9})
            for (const double thickness : {1e-2, 1e-5, 1e-8, 1e-11, 1e-14, 0x1p-53}) {
                CAPTURE(size);
                CAPTURE(thickness);
                const Solid solid = test::cuboid({-size, -size, 0.5 - thickness}, {size, size, size});
                CHECK(difference(points, solid, {}, 2 * size) == "");
            }
    }

    TEST_CASE("cells in meshes: rational tetrahedra") {
        test::Random random(43);
        const auto on_grid = [&](double from, double to) {  // ties abound
            return from + (to - from) * static_cast<double>(random.below(5)) / 4;
        };
        const auto place = [&](double from, double to) {
            return std::array{on_grid(from, to), on_grid(from, to), on_grid(from, to)};
        };
        const auto random_box = [&] {
            std::array<double, 3> lower = place(0, 0.5), upper;
            for (std::size_t k = 0; k < 3; ++k) upper[k] = lower[k] + on_grid(0.25, 0.75);
            return test::cuboid(lower, upper);
        };
        const auto random_tetrahedron = [&] {
            while (true) {
                const Solid s = test::tetrahedron({place(0, 1), place(0, 1), place(0, 1), place(0, 1)});
                if (s.volume() > 0) return s;
            }
        };
        const Solid unit = test::cuboid(0, 1);
        for (std::size_t number = 0; number < test::by_size(70, 7); ++number) {
            CAPTURE(number);
            Solid solid;
            switch (number % 7) {
                case 0:
                    solid = random_tetrahedron();
                    break;
                case 1:
                    solid = random_box();
                    break;
                case 2:
                    solid = test::joined(random_tetrahedron(), random_tetrahedron());
                    break;
                case 3:
                    solid = test::joined(random_box(), random_box());
                    break;
                case 4:
                    solid = test::joined(unit, test::cuboid(0.25, 0.75).reversed());
                    break;
                case 5:  // below and above z = 0.5, where faces of cells lie
                    for (std::size_t i = 0; i < 4; ++i) {
                        std::array<double, 3> lower = place(0, 0.5), upper;
                        for (std::size_t k = 0; k < 2; ++k) upper[k] = lower[k] + on_grid(0.25, 0.75);
                        lower[2] = i % 2 == 0 ? 0 : 0.5;
                        upper[2] = lower[2] + 0.5;
                        const Solid box = test::cuboid(lower, upper);
                        solid = i == 0 ? box : test::joined(solid, box);
                    }
                    break;
                default:
                    solid = test::joined(unit, random_tetrahedron());
                    break;
            }
            std::vector<double> points;
            std::vector<double> weights;
            for (std::size_t i = 1 + random.below(6); i > 0; --i)
                for (const double x : place(-0.25, 1.25)) points.push_back(x);
            if (number % 7 == 5) points.insert(points.end(), {0.375, 0.5, 0.25, 0.375, 0.5, 0.75});
            if (random.chance(0.3))  // no ties
                for (double& x : points) x += std::ldexp(static_cast<double>(random.below(1024)), -13);
            const std::size_t count = points.size() / 3;
            if (random.chance(0.4))
                for (std::size_t i = 0; i < count; ++i) weights.push_back(on_grid(0, 0.25));
            bool repeated = false;
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t j = 0; j < i; ++j)
                    repeated |= std::equal(&points[3 * i], &points[3 * i] + 3, &points[3 * j]);
            if (!repeated) CHECK(difference(points, solid, weights) == "");
        }
    }
}

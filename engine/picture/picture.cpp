// render(): chooses the cells to show, their colors, their triangles and the lines around them, and draws them.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "core/text.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "input/supports.hpp"
#include "picture/colors.hpp"
#include "picture/legend/layout.hpp"
#include "picture/piece_sections.hpp"
#include "picture/raster.hpp"
#include "picture/shown.hpp"
#include "picture/slice.hpp"
#include "picture/solid.hpp"
#include "plane/sheet.hpp"
#include "result/closed_rows.hpp"

namespace votess {
namespace picture {
namespace {

void check_size(const char* name, std::uint32_t pixels) {
    if (pixels < 64 || pixels > 16384) {
        refuse(std::string("picture: ") + name + " = " + std::to_string(pixels) + " pixels: give 64 to 16384");
    }
}

void check_slice(const Slice& slice, const Box& box) {
    if (slice.axis < 0 || slice.axis > 2)
        refuse("picture: slice axis " + std::to_string(slice.axis) + " is not 0, 1 or 2");
    const auto k = static_cast<std::size_t>(slice.axis);
    const double lower = box.lower[k], upper = box.upper[k];
    if (!(slice.value > lower && slice.value < upper)) {
        refuse(std::string("picture: slice at ") + "xyz"[k] + " = " + number(slice.value) +
               " is not inside the domain, which spans " + number(lower) + " to " + number(upper));
    }
}

void check_values(const PictureOptions& options, std::size_t count, const char* of) {
    if (!options.values.empty() && options.values.size() != count)
        refuse("picture: " + std::to_string(options.values.size()) + " values for " + std::to_string(count) + " " + of);
}

// Checks what does not depend on the cells.
void check_look(const PictureOptions& options) {
    check_size("width", options.width);
    check_size("height", options.height);
    check_colors(options);
    if (!std::isfinite(options.azimuth) || !(std::abs(options.elevation) <= 89)) {
        refuse("picture: view " + number(options.azimuth) + ", " + number(options.elevation) +
               ": the elevation is at most 89 degrees either way");
    }
    if (options.cut_at) {
        for (const double x : *options.cut_at)
            if (!std::isfinite(x)) refuse("picture: the cut is at " + number(x));
    }
    check_member("PictureOptions::threads", options.threads);
}

void check(const Tessellation& t, std::span<const double> points, const PictureOptions& options) {
    require(t, "picture");
    const std::size_t n = t.size();
    if (points.size() != (t.planar() ? 2 : 3) * n) {
        refuse("picture: " + std::to_string(points.size()) + " coordinates for " + std::to_string(n) + " cells");
    }
    if (n == 0) refuse("picture: no cell to draw");
    if (!t.in_mesh() && t.face_offsets().size() != t.indices().size() + 1) {
        refuse("picture: the tessellation has no faces: set " + option("want.faces"));
    }
    if (options.values.empty() && t.volumes().size() != n) {
        refuse("picture: no values to color by: give some, or ask the tessellation for volumes");
    }
    check_values(options, n, "cells");
    check_look(options);
    if (options.gap != 0 && !t.in_mesh()) refuse("picture: a gap is between pieces of cells in a mesh: leave it out");
    if (options.slice && t.planar()) refuse("picture: cells of the plane have no slice: leave it out");
}

// The domain's corners, bit k of the index telling the end along edge k; none for a polyhedron.
std::vector<Vec3> domain_corners(const Tessellation& t, const Box& box, bool endless) {
    if (!t.walls().empty() || (endless && t.cell())) return {};
    std::vector<Vec3> corners;
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3 p = t.cell() ? t.cell()->origin : box.lower;
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(corner >> k & 1)) continue;
            if (t.cell()) {
                p = p + (k == 0 ? t.cell()->a : k == 1 ? t.cell()->b : t.cell()->c);
            } else {
                p[k] = box.upper[k];
            }
        }
        corners.push_back(p);
    }
    return corners;
}

// Vectors by which the domain repeats.
std::vector<Vec3> domain_periods(const Tessellation& t) {
    std::vector<Vec3> periods;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!t.periodic()[k]) continue;
        Vec3 period{};
        if (t.cell())
            period = k == 0 ? t.cell()->a : k == 1 ? t.cell()->b : t.cell()->c;
        else
            period[k] = t.box().upper[k] - t.box().lower[k];
        periods.push_back(period);
    }
    return periods;
}

bool is_planar(const Pieces& pieces) {
    return pieces.centroids.size() == 2 * pieces.size();
}

// Pieces as the picture sees them. Their triangles are faces, in the plane their edges.
struct PieceMesh {
    explicit PieceMesh(const Pieces& pieces) : planar(is_planar(pieces)), corners(planar ? 2 : 3) {
        const std::size_t triangles = pieces.sources.size();
        ids.assign(triangles, -1);
        for (std::size_t t = 0; t <= triangles; ++t) offsets.push_back(static_cast<std::int64_t>(corners * t));
        vertices = pieces.triangles;
        for (std::size_t p = 0; p < pieces.size(); ++p) {
            const auto [begin, end] = entries(pieces, p);
            for (std::size_t at = begin; at < end; ++at)
                vertices[at] += static_cast<std::int32_t>(pieces.vertex_offsets[p]);
        }
        mesh = {pieces.triangle_offsets, ids, {}, offsets, vertices, pieces.vertices};
        if (planar) {
            mesh.vertices = places = in_sheet({pieces.vertices, {}});
            mesh.rings = true;
        } else {
            lines.assign(vertices.size(), 0);
            for (std::size_t p = 0; p < pieces.size(); ++p) find_lines(pieces, p);
            mesh.lines = lines;
        }
        domain.box = votess::bounds_of(mesh.vertices);
        domain.of_pieces = true;
    }
    PieceMesh(const PieceMesh&) = delete;
    PieceMesh& operator=(const PieceMesh&) = delete;

    bool planar;
    std::size_t corners;  // of a face
    std::vector<std::int32_t> ids, vertices;
    std::vector<std::int64_t> offsets;
    std::vector<char> lines;
    std::vector<double> places;
    Mesh mesh;
    DomainShape domain;

private:
    // Returns the range of a piece in `vertices`.
    [[nodiscard]] std::pair<std::size_t, std::size_t> entries(const Pieces& pieces, std::size_t p) const {
        return {corners * static_cast<std::size_t>(pieces.triangle_offsets[p]),
                corners * static_cast<std::size_t>(pieces.triangle_offsets[p + 1])};
    }

    // Draws a line where a plane meets another one or the surface.
    void find_lines(const Pieces& pieces, std::size_t p) {
        struct Side {
            std::pair<std::int32_t, std::int32_t> ends;
            std::int32_t plane;  // -1: the surface
            std::size_t at;
        };
        std::vector<Side> sides;
        const auto [begin, end] = entries(pieces, p);
        for (std::size_t at = begin; at < end; ++at) {
            const std::int32_t from = pieces.triangles[at], to = pieces.triangles[at % 3 == 2 ? at - 2 : at + 1];
            sides.push_back({std::minmax(from, to), pieces.on_surface[at / 3] != 0 ? -1 : pieces.sources[at / 3], at});
        }
        std::ranges::sort(sides, {}, &Side::ends);
        for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
            bool differ = false;
            for (j = i; j < sides.size() && sides[j].ends == sides[i].ends; ++j)
                differ |= sides[j].plane != sides[i].plane;
            for (std::size_t k = i; k < j && differ; ++k) lines[sides[k].at] = 1;
        }
    }
};

}  // namespace

Scene build_scene(const Mesh& mesh, const DomainShape& domain, std::span<const double> points,
                  std::span<const double> values, const PictureOptions& options, ThreadPool& pool) {
    // A section shows what it meets.
    const WallCells walls =
        options.slice && options.wall_cells == WallCells::automatic ? WallCells::show : options.wall_cells;
    const Shown shown = choose_cells(mesh, domain.box, walls, pool);
    const Scale scale = choose_scale(values, shown.cells, options);
    const std::vector<Color> colors = color_cells(values, scale, options.colormap);

    Scene scene;
    scene.width = options.width;
    scene.height = options.height;
    scene.background = options.background;
    const Sizes sizes(options.width, options.height);
    scene.edge_width = options.edges ? sizes.line : 0;
    const double margin = 46 * sizes.unit;
    const double right =
        options.color_bar ? scene.width - color_bar_width(scale, options, sizes) : scene.width - margin;
    Area area{margin, margin, right, scene.height - margin};
    if (options.slice) {
        if (options.frame) {
            area.left += 110 * sizes.unit;
            area.bottom -= 70 * sizes.unit;
        }
        area = build_slice({mesh, shown, points, colors, options, domain.periods, area}, sizes, pool, scene);
    } else {
        const auto corners = options.frame && !shown.walls_hidden ? std::span(domain.corners) : std::span<const Vec3>();
        build_solid({mesh, shown, points, colors, options, area, domain.corners.empty() || !domain.periods.empty(),
                     domain.of_pieces},
                    corners, pool, scene);
        area.top = 0.14 * scene.height;
        area.bottom = 0.86 * scene.height;
    }
    add_color_bar(scale, options, sizes, area, scene);
    return scene;
}

// Draws the sections of pieces in space. points: three coordinates for each piece. values: one each.
Picture render_sections(const Pieces& pieces, std::span<const double> points, std::span<const double> values,
                        const PictureOptions& options) {
    if (is_planar(pieces)) refuse("picture: pieces of the plane have no slice: leave it out");
    DomainShape domain{votess::bounds_of(pieces.vertices), {}, {}};
    check_slice(*options.slice, domain.box);
    const PieceSections sections(pieces, *options.slice);
    std::vector<double> of_sections, seeds;
    for (const std::size_t p : sections.piece) {
        of_sections.push_back(values[p]);
        seeds.insert(seeds.end(), &points[3 * p], &points[3 * p] + 3);
    }
    if (of_sections.empty()) refuse("picture: the slice meets no piece: move it");
    PictureOptions look = options;
    look.wall_cells = WallCells::show;
    ThreadPool pool(options.threads, "PictureOptions::threads");
    const Scene scene = build_scene(sections.mesh, domain, seeds, of_sections, look, pool);
    return {scene.width, scene.height, draw(scene, pool), 0};
}

// points: three coordinates for each piece. values: one each.
Picture render_pieces(const Pieces& pieces, std::span<const double> points, std::span<const double> values,
                      const PictureOptions& options) {
    if (pieces.size() == 0) refuse("picture: there are no pieces to draw");
    if (options.slice) return render_sections(pieces, points, values, options);
    const PieceMesh shape(pieces);
    PictureOptions look = options;
    look.wall_cells = WallCells::show;
    if (shape.planar)
        look.slice = Slice{};  // which meets all pieces
    else
        look.frame = false;
    ThreadPool pool(options.threads, "PictureOptions::threads");
    const Scene scene = build_scene(shape.mesh, shape.domain, points, values, look, pool);
    return {scene.width, scene.height, draw(scene, pool), 0};
}

// The pieces of a cell have its value, and in the plane and in a slice its seed.
Picture render_in_mesh(const Tessellation& t, std::span<const double> points, const PictureOptions& options) {
    const auto values = options.values.empty() ? t.volumes() : options.values;
    const Pieces of_cells = pieces(t, {.gap = options.gap, .threads = options.threads});
    std::vector<double> of_pieces, seeds;
    for (std::size_t i = 0; i < t.size(); ++i)
        for (std::int64_t p = of_cells.indptr[i]; p < of_cells.indptr[i + 1]; ++p) {
            of_pieces.push_back(values[i]);
            if (t.planar())
                seeds.insert(seeds.end(), {points[2 * i], points[2 * i + 1], 0});
            else
                seeds.insert(seeds.end(), &points[3 * i], &points[3 * i] + 3);
        }
    return render_pieces(of_cells, t.planar() || options.slice ? seeds : of_cells.centroids, of_pieces, options);
}

}  // namespace picture

Picture render(const Tessellation& tessellation, std::span<const double> given, const PictureOptions& options) {
    picture::check(tessellation, given, options);
    std::vector<double> points(given.begin(), given.end());  // another thread may write into them
    if (tessellation.in_mesh()) return picture::render_in_mesh(tessellation, points, options);
    picture::Mesh mesh{tessellation.indptr(),       tessellation.indices(),       tessellation.shifts(),
                       tessellation.face_offsets(), tessellation.face_vertices(), tessellation.vertices()};
    const bool planar = tessellation.planar();
    if (planar) {
        mesh.corner_begin = tessellation.cell_vertex_indptr();
        mesh.corners = tessellation.cell_vertex_indices();
    }
    Box box = tessellation.box();
    const auto infinite = [](double x) { return std::isinf(x); };
    const bool endless = std::ranges::any_of(box.lower, infinite) || std::ranges::any_of(box.upper, infinite);
    std::optional<detail::ClosedRows> closed;
    if (endless)
        closed = detail::closed_rows({mesh.indptr, mesh.face_offsets, tessellation.cell_vertex_indptr(), mesh.indices,
                                      mesh.face_vertices, tessellation.cell_vertex_indices(), mesh.shifts,
                                      tessellation.vertices(), box, planar ? std::size_t{2} : std::size_t{3}});
    if (closed) {
        if (!options.skip_open)
            refuse("picture: " + closed->open_cells() +
                   ": leave out such cells by PictureOptions::skip_open, or give a box");
        if (closed->indices.empty()) refuse("picture: all cells reach infinity: give a box");
        mesh = {closed->indptr,       closed->indices,       closed->shifts,
                closed->face_offsets, closed->face_vertices, tessellation.vertices()};
        if (planar) mesh.corner_begin = closed->cell_vertex_indptr, mesh.corners = closed->cell_vertex_indices;
        box = closed->bounds;
    }
    if (options.slice) picture::check_slice(*options.slice, box);
    std::vector<double> vertices;
    PictureOptions look = options;
    if (planar) {
        points = in_sheet({points, {}});
        mesh.vertices = vertices = in_sheet({mesh.vertices, {}});
        look.slice = Slice{};  // which meets all cells
        box.lower[2] = box.upper[2] = 0;
    }
    const picture::DomainShape domain{box, picture::domain_corners(tessellation, box, endless),
                                      picture::domain_periods(tessellation)};
    const auto values = options.values.empty() ? tessellation.volumes() : options.values;
    ThreadPool pool(options.threads, "PictureOptions::threads");
    const picture::Scene scene = picture::build_scene(mesh, domain, points, values, look, pool);
    return {scene.width, scene.height, picture::draw(scene, pool), closed ? closed->left_out : 0};
}

Picture render(const Pieces& pieces, const PictureOptions& options) {
    picture::check_look(options);
    picture::check_values(options, pieces.size(), "pieces");
    const auto values = options.values.empty() ? std::span(pieces.volumes) : options.values;
    if (options.seeds && options.slice)
        refuse("picture: pieces have no seeds: draw the tessellation, or leave them out");
    if (!picture::is_planar(pieces)) return picture::render_pieces(pieces, pieces.centroids, values, options);
    if (options.seeds) refuse("picture: pieces have no seeds: draw the tessellation, or leave them out");
    return picture::render_pieces(pieces, in_sheet({pieces.centroids, {}}), values, options);
}

}  // namespace votess

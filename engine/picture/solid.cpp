#include "picture/solid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/box.hpp"

namespace votess::picture {
namespace {

constexpr double focal_over_height = 2.4;  // a view of 24 degrees, little distortion

// Takes positions of the mesh to those of the scene, which are of order one around the origin.
struct Frame {
    Vec3 middle{};
    double scale = 1;

    explicit Frame(const Box& bounds) : middle(0.5 * (bounds.lower + bounds.upper)) {
        // Halves first: the difference itself may overflow.
        const Vec3 half = 0.5 * bounds.upper - 0.5 * bounds.lower;
        const double largest = std::max({half[0], half[1], half[2]});
        scale = 1 / largest;
    }
    [[nodiscard]] Vec3 operator()(const Vec3& p) const { return scale * (p - middle); }
};

// The space that is taken away: in front of all planes.
struct CutSpace {
    std::vector<CutPlane> planes;

    [[nodiscard]] bool holds(const Vec3& p) const {
        return !planes.empty() &&
               std::all_of(planes.begin(), planes.end(), [&](const CutPlane& plane) { return plane.height(p) > 0; });
    }
};

View look(const PictureOptions& options) {
    const double azimuth = options.azimuth * std::numbers::pi / 180;
    const double elevation = options.elevation * std::numbers::pi / 180;
    View view;
    view.back = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
    view.right = {-std::sin(azimuth), std::cos(azimuth), 0};
    view.up = cross(view.back, view.right);
    return view;
}

// Goes back until all points are inside the area, and centers them there.
void fit(View& view, std::span<const Vec3> points, const Area& area, double height) {
    view.focal = focal_over_height * height;
    const double width = area.right - area.left, tall = area.bottom - area.top;
    double lowest[2] = {}, highest[2] = {};
    view.distance = 0;
    // The projected middle moves with the distance: a few rounds settle it.
    double shift[2] = {0, 0};
    for (int round = 0; round < 8; ++round) {
        double distance = 0;
        for (const Vec3& p : points) {
            const double x = std::abs(dot(view.right, p) - shift[0]), y = std::abs(dot(view.up, p) - shift[1]);
            const double z = dot(view.back, p);
            distance = std::max({distance, z + view.focal * x / (0.5 * width), z + view.focal * y / (0.5 * tall)});
        }
        view.distance = distance;
        for (int k = 0; k < 2; ++k) {
            lowest[k] = 1e300;
            highest[k] = -1e300;
        }
        for (const Vec3& p : points) {
            const double w = distance - dot(view.back, p);
            const double at[2] = {dot(view.right, p) / w, dot(view.up, p) / w};
            for (int k = 0; k < 2; ++k) {
                lowest[k] = std::min(lowest[k], at[k]);
                highest[k] = std::max(highest[k], at[k]);
            }
        }
        for (int k = 0; k < 2; ++k) shift[k] = 0.5 * (lowest[k] + highest[k]) * distance;
    }
    view.middle = {0.5 * (area.left + area.right) - view.focal * 0.5 * (lowest[0] + highest[0]),
                   0.5 * (area.top + area.bottom) + view.focal * 0.5 * (lowest[1] + highest[1])};
    double radius = 0;
    for (const Vec3& p : points) radius = std::max(radius, std::sqrt(dot(p, p)));
    view.near = std::max(view.distance - 1.5 * radius, 0.05 * view.distance);
    view.far = view.distance + 1.5 * radius;
}

CutSpace cut_space(const PictureOptions& options, const View& view, const Box& bounds) {
    CutSpace space;
    if (options.cut == Cut::none) return space;
    const Vec3 at = options.cut_at ? *options.cut_at : 0.5 * (bounds.lower + bounds.upper);
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::abs(view.back[k]) > std::abs(view.back[nearest])) nearest = k;
    for (std::size_t k = 0; k < 3; ++k) {
        if (options.cut == Cut::half && k != nearest) continue;
        space.planes.push_back({static_cast<int>(k), at[k], view.back[k] < 0 ? -1.0 : 1.0});
    }
    return space;
}

// Makes the triangles of a block of cells.
class SolidBuilder {
public:
    SolidBuilder(const SolidJob& job, const Frame& frame, const CutSpace& space, const std::vector<char>& kept,
                 const View& view, double line)
        : job_(job),
          frame_(frame),
          space_(space),
          kept_(kept),
          view_(view),
          eye_(view.distance * view.back),
          line_(line) {}

    void add_cell(std::size_t cell, std::vector<FillVertex>& out, std::vector<Stroke>& lines) {
        const Mesh& mesh = job_.mesh;
        if (!mesh.lines.empty()) width_ = line_width_of(cell);
        for (std::size_t f = mesh.first_face(cell); f < mesh.end_face(cell); ++f) {
            // Behind a face between two cells there is nothing to see.
            if (mesh.joins(f) && kept_[static_cast<std::size_t>(mesh.indices[f])]) continue;
            add_face(f, job_.colors[cell], out, lines);
        }
        for (std::size_t k = 0; k < space_.planes.size(); ++k) add_cap(cell, k, out);
    }

private:
    // Returns 0 without lines.
    [[nodiscard]] double line_width_of(std::size_t cell) const {
        if (!(line_ > 0)) return 0;
        Box seen = empty_box;
        for (std::size_t f = job_.mesh.first_face(cell); f < job_.mesh.end_face(cell); ++f)
            for (const std::int32_t v : job_.mesh.polygon(f)) include(seen, view_.project(frame_(job_.mesh.vertex(v))));
        return line_width(0.25 * (seen.upper[0] - seen.lower[0] + seen.upper[1] - seen.lower[1]), line_);
    }

    void add_lines(std::size_t face, std::vector<Stroke>& lines) const {
        constexpr Vec3 towards{0, 0, 1e-3};  // in front of the surface beside it, which may come nearer there
        for (std::size_t i = 0; i < rest_.corners.size(); ++i) {
            if (!job_.mesh.is_line(face, i)) continue;
            const Vec3 a = view_.project(rest_.corners[i]);
            const Vec3 b = view_.project(rest_.corners[i + 1 == rest_.corners.size() ? 0 : i + 1]);
            lines.push_back(stroke(a - towards, b - towards, width_, line_color));
        }
    }

    void add_face(std::size_t face, Color color, std::vector<FillVertex>& out, std::vector<Stroke>& lines) {
        rest_.clear();
        const auto loop = job_.mesh.polygon(face);
        for (const std::int32_t v : loop) rest_.add(frame_(job_.mesh.vertex(v)), job_.mesh.lines.empty());
        Vec3 normal{};
        for (std::size_t i = 2; i < loop.size(); ++i) {
            normal = normal + cross(rest_.corners[i - 1] - rest_.corners[0], rest_.corners[i] - rest_.corners[0]);
        }
        const double length = std::sqrt(dot(normal, normal));
        if (!(length > 0)) return;
        normal = (1 / length) * normal;
        if (dot(normal, eye_ - rest_.corners[0]) <= 0) return;  // seen from inside only
        if (width_ > 0) add_lines(face, lines);
        if (space_.planes.empty()) return add_fan(rest_, normal, color, out);
        // What is behind the first plane, what is in front of it and behind the second, and so on.
        for (const CutPlane& plane : space_.planes) {
            const CutPlane here = scaled(plane);
            clip(rest_, here, true, false, piece_);
            add_fan(piece_, normal, color, out);
            clip(rest_, here, false, false, piece_);
            std::swap(rest_, piece_);
        }
    }

    // The section of the cell by a plane, as far as the space that is taken away reaches.
    void add_cap(std::size_t cell, std::size_t k, std::vector<FillVertex>& out) {
        section(job_.mesh, cell, space_.planes[k], rest_);
        if (rest_.corners.empty()) return;
        for (Vec3& corner : rest_.corners) corner = frame_(corner);
        for (std::size_t other = 0; other < space_.planes.size(); ++other) {
            if (other == k) continue;
            clip(rest_, scaled(space_.planes[other]), false, true, piece_);
            std::swap(rest_, piece_);
        }
        Vec3 normal{};
        normal[static_cast<std::size_t>(space_.planes[k].axis)] = space_.planes[k].side;
        add_fan(rest_, normal, job_.colors[cell], out);
    }

    [[nodiscard]] CutPlane scaled(CutPlane plane) const {
        plane.value = frame_.scale * (plane.value - frame_.middle[static_cast<std::size_t>(plane.axis)]);
        return plane;
    }

    const SolidJob& job_;
    const Frame& frame_;
    const CutSpace& space_;
    const std::vector<char>& kept_;
    const View& view_;
    Vec3 eye_;
    double line_;       // width in pixels
    double width_ = 0;  // of the lines of a piece
    Polygon rest_, piece_;
};

// The part of the line from a to b inside the space, as shares of it; empty when begin >= end.
struct Stretch {
    double begin = 0, end = 1;
};
Stretch inside(const CutSpace& space, const Vec3& a, const Vec3& b) {
    if (space.planes.empty()) return {0, 0};
    Stretch part;
    for (const CutPlane& plane : space.planes) {
        const double from = plane.height(a), to = plane.height(b);
        if (from <= 0 && to <= 0) return {0, 0};
        if (from < 0) part.begin = std::max(part.begin, from / (from - to));
        if (to < 0) part.end = std::min(part.end, from / (from - to));
    }
    return part;
}

// Draws the edges of the domain, except in front of the opening.
void add_frame(const View& view, const Frame& frame, std::span<const Vec3> corners, const CutSpace& opening,
               double width, std::vector<Stroke>& strokes) {
    constexpr Vec3 towards{0, 0, 2e-4};  // in front of the faces that it lies on
    for (std::size_t corner = 0; corner < corners.size(); ++corner) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (corner >> axis & 1) continue;
            const Vec3 from = corners[corner], to = corners[corner | 1u << axis];
            const Stretch removed = inside(opening, from, to);
            const bool whole = removed.begin >= removed.end;
            for (const Stretch part : {Stretch{0, whole ? 1 : removed.begin}, Stretch{whole ? 1 : removed.end, 1}}) {
                if (part.begin >= part.end) continue;
                const Vec3 a = view.project(frame(from + part.begin * (to - from)));
                const Vec3 b = view.project(frame(from + part.end * (to - from)));
                strokes.push_back(stroke(a - towards, b - towards, width, rgb(60, 60, 70, 140)));
            }
        }
    }
}

}  // namespace

Vec3 View::project(const Vec3& p) const {
    if (focal == 0) return p;
    const double w = distance - dot(back, p);
    const double depth = far / (far - near) * (1 - near / w);
    return {middle[0] + focal * dot(right, p) / w, middle[1] - focal * dot(up, p) / w, depth};
}

void add_fan(const Polygon& polygon, const Vec3& normal, Color color, std::vector<FillVertex>& out) {
    const std::size_t n = polygon.corners.size();
    if (n < 3) return;
    Vec3 middle{};
    for (const Vec3& p : polygon.corners) middle = middle + p;
    middle = (1.0 / static_cast<double>(n)) * middle;
    FillVertex vertex{};
    for (std::size_t k = 0; k < 3; ++k) vertex.normal[k] = static_cast<std::int8_t>(std::lround(127 * normal[k]));
    vertex.color = color;
    const auto add = [&](const Vec3& p, float edge) {
        vertex.position = floats(p);
        vertex.edge = edge;
        out.push_back(vertex);
    };
    for (std::size_t i = 0; i < n; ++i) {
        const float edge = polygon.line[i] ? 0.0f : 1.0f;
        add(middle, 1);
        add(polygon.corners[i], edge);
        add(polygon.corners[(i + 1) % n], edge);
    }
}

double line_width(double size, double line) {
    return line * std::clamp(0.1 * size / line - 0.1, 0.0, 1.0);
}

void remove_repeats(std::vector<Stroke>& lines) {
    const auto ends = [](const Stroke& s) {
        const auto near = [](const Floats& p) { return std::array{std::lround(16 * p[0]), std::lround(16 * p[1])}; };
        return std::minmax({near(s.from), near(s.to)});
    };
    std::ranges::stable_sort(lines, {}, ends);
    const auto repeats = std::ranges::unique(lines, {}, ends);
    lines.erase(repeats.begin(), repeats.end());
}

void build_solid(const SolidJob& job, std::span<const Vec3> corners, ThreadPool& pool, Scene& scene) {
    const Frame frame(job.shown.bounds);
    View& view = scene.view = look(job.options);
    std::vector<Vec3> outline;
    const Box& bounds = job.shown.bounds;
    if (job.shown.walls_hidden) {
        for (std::size_t i = 0; i < job.shown.cells.size(); ++i) {
            if (job.shown.cells[i]) outline.push_back(frame(point_of(job.points, i)));
        }
    } else if (job.own_outline) {
        for (std::size_t v = 0; v < job.mesh.vertices.size() / 3; ++v) {
            outline.push_back(frame(job.mesh.vertex(static_cast<std::int32_t>(v))));
        }
    } else {
        for (int corner = 0; corner < 8; ++corner) {
            Vec3 p;
            for (std::size_t k = 0; k < 3; ++k) p[k] = corner >> k & 1 ? bounds.upper[k] : bounds.lower[k];
            outline.push_back(frame(p));
        }
    }
    for (const Vec3& corner : corners) outline.push_back(frame(corner));
    Area area = job.area;
    if (job.shown.walls_hidden) {  // cells reach beyond their seeds
        const double margin = 0.03 * scene.height;
        area = {area.left + margin, area.top + margin, area.right - margin, area.bottom - margin};
    }
    fit(view, outline, area, scene.height);

    const CutSpace opening = cut_space(job.options, view, job.shown.bounds);
    CutSpace space = opening;
    std::vector<char> kept = job.shown.cells;
    if (job.options.cut == Cut::cells || job.whole_cells) {
        for (std::size_t i = 0; i < kept.size(); ++i) {
            if (space.holds(point_of(job.points, i))) kept[i] = 0;
        }
        space.planes.clear();
    }

    const std::size_t n = job.mesh.cells();
    std::vector<std::vector<FillVertex>> blocks(ceil_div(n, block_cells));
    std::vector<std::vector<Stroke>> lines(blocks.size());
    over_cells(n, pool, [&](std::size_t begin, std::size_t end, std::size_t block) {
        SolidBuilder builder(job, frame, space, kept, view, scene.edge_width);
        for (std::size_t i = begin; i < end; ++i)
            if (kept[i]) builder.add_cell(i, blocks[block], lines[block]);
    });
    append(blocks, scene.solid);
    append(lines, scene.strokes);
    remove_repeats(scene.strokes);
    scene.occlusion_radius = 0.16;
    if (!corners.empty()) add_frame(view, frame, corners, opening, 1.4 * scene.edge_width, scene.strokes);
}

}  // namespace votess::picture

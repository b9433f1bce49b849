#include "picture/slice.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/box.hpp"
#include "solid/ear_clipping.hpp"

namespace votess::picture {
namespace {

// Takes coordinates of the plane to pixels.
struct Plane {
    std::size_t axis, across, up;  // axes of space
    double low[2], pixels;         // pixels of a unit of length
    Area area;

    [[nodiscard]] Vec3 operator()(const Vec3& p) const {
        return {area.left + (p[across] - low[0]) * pixels, area.bottom - (p[up] - low[1]) * pixels, 0};
    }
};

Plane place(const SliceJob& job, const Slice& slice) {
    Plane plane{};
    plane.axis = static_cast<std::size_t>(slice.axis);
    plane.across = plane.axis == 0 ? 1 : 0;
    plane.up = plane.axis == 2 ? 1 : 2;
    const Box& bounds = job.shown.bounds;
    plane.low[0] = bounds.lower[plane.across];
    plane.low[1] = bounds.lower[plane.up];
    const double size[2] = {bounds.upper[plane.across] - plane.low[0], bounds.upper[plane.up] - plane.low[1]};
    const Area& most = job.area;
    plane.pixels = std::min((most.right - most.left) / size[0], (most.bottom - most.top) / size[1]);
    // Whole pixels, so that the frame is sharp.
    const double width = size[0] * plane.pixels, height = size[1] * plane.pixels;
    plane.area.left = std::round(0.5 * (most.left + most.right - width)) + 0.5;
    plane.area.top = std::round(0.5 * (most.top + most.bottom - height)) + 0.5;
    plane.area.right = plane.area.left + width;
    plane.area.bottom = plane.area.top + height;
    return plane;
}

// Draws pieces of the plane: polygons that need not be convex, with holes.
class RingBuilder {
public:
    RingBuilder(const SliceJob& job, const Plane& plane, double line) : job_(job), plane_(plane), line_(line) {}

    // Adds triangles, and if lines are drawn the edges.
    void add_piece(std::size_t piece, std::vector<FillVertex>& out, std::vector<Stroke>& edges) {
        find_rings(piece);
        if (rings_.empty()) return;
        FillVertex vertex{};
        vertex.color = job_.colors[piece];
        vertex.edge = 1;
        for (const auto& triangle : cutter_.cut(rings_)) {
            for (const std::int32_t v : triangle) {
                vertex.position = floats(plane_(job_.mesh.vertex(v)));
                out.push_back(vertex);
            }
        }
        if (line_ > 0) add_edges(edges);
    }

private:
    void find_rings(std::size_t piece) {
        rings_.clear();
        std::vector<solid::FlatCorner> ring;
        for (std::size_t f = job_.mesh.first_face(piece); f < job_.mesh.end_face(piece); ++f) {
            const auto edge = job_.mesh.polygon(f);
            const Vec3 at = plane_(job_.mesh.vertex(edge[0]));
            ring.push_back({at[0], at[1], edge[0]});
            if (edge[1] != ring.front().id) continue;
            if (ring.size() > 2) rings_.push_back(ring);
            ring.clear();
        }
    }

    void add_edges(std::vector<Stroke>& edges) const {
        double area = 0, around = 0;
        const auto over_edges = [&](const auto& task) {
            for (const auto& ring : rings_)
                for (std::size_t k = 0; k < ring.size(); ++k) task(ring[k], ring[k + 1 == ring.size() ? 0 : k + 1]);
        };
        for (const auto& ring : rings_) area += 0.5 * solid::doubled_area(ring);
        over_edges([&](const auto& a, const auto& b) { around += std::hypot(b.x - a.x, b.y - a.y); });
        if (!(around > 0)) return;
        // From the middle to an edge, if the piece is round.
        const double width = line_width(2 * std::abs(area) / around, line_);
        if (width == 0) return;
        over_edges([&](const auto& a, const auto& b) {
            edges.push_back(stroke({a.x, a.y, 0}, {b.x, b.y, 0}, width, line_color));
        });
    }

    const SliceJob& job_;
    const Plane& plane_;
    double line_;  // width in pixels
    std::vector<std::vector<solid::FlatCorner>> rings_;
    solid::EarClipping cutter_;
};

// The shifts of the images of a cell that may reach into the bounds of the domain, which are longer than its edges.
std::vector<Vec3> images(std::span<const Vec3> periods) {
    std::vector<Vec3> all{{0, 0, 0}};
    for (const Vec3& period : periods) {
        const bool oblique = std::count(period.begin(), period.end(), 0.0) < 2;
        const int most = oblique ? 2 : 1;
        std::vector<Vec3> more;
        for (const Vec3& image : all)
            for (int k = -most; k <= most; ++k) more.push_back(image + static_cast<double>(k) * period);
        all = std::move(more);
    }
    return all;
}

class SliceBuilder {
public:
    SliceBuilder(const SliceJob& job, const Plane& plane, const Slice& slice, std::span<const Vec3> images)
        : job_(job), plane_(plane), value_(slice.value), images_(images) {}

    void add_cell(std::size_t cell, std::vector<FillVertex>& out) {
        for (const Vec3& image : images_) {
            section(job_.mesh, cell, {static_cast<int>(plane_.axis), value_ - image[plane_.axis], 1}, polygon_);
            if (polygon_.corners.empty()) continue;
            for (Vec3& corner : polygon_.corners) corner = corner + image;
            if (images_.size() > 1) clip_to_box();
            for (Vec3& corner : polygon_.corners) corner = plane_(corner);
            add_fan(polygon_, {}, job_.colors[cell], out);
        }
    }

private:
    void clip_to_box() {
        for (const std::size_t axis : {plane_.across, plane_.up}) {
            for (const bool upper : {false, true}) {
                const double wall = upper ? job_.shown.bounds.upper[axis] : job_.shown.bounds.lower[axis];
                clip(polygon_, {static_cast<int>(axis), wall, 1}, upper, false, clipped_);
                std::swap(polygon_, clipped_);
            }
        }
    }

    const SliceJob& job_;
    const Plane& plane_;
    double value_;
    std::span<const Vec3> images_;
    Polygon polygon_, clipped_;
};

void add_seeds(const SliceJob& job, const Plane& plane, const Slice& slice, std::span<const char> met, double size,
               std::vector<Stroke>& out) {
    for (std::size_t i = 0; i < met.size(); ++i) {
        const Vec3 p = point_of(job.points, i);
        // Only those whose own cell the plane cuts, the nearer the clearer.
        if (!met[i]) continue;
        const double away = std::abs(p[plane.axis] - slice.value) * plane.pixels / (8 * size);
        const auto opacity = static_cast<unsigned>(std::lround(235 / (1 + away * away)));
        if (opacity < 40) continue;
        const Vec3 at = plane(p);
        // Seeds outside of polygons have parts of cells inside.
        const Area& area = plane.area;
        if (job.mesh.rings && (at[0] < area.left || at[0] > area.right || at[1] < area.top || at[1] > area.bottom))
            continue;
        const Vec3 on_top{at[0], at[1], 0};
        out.push_back(stroke(on_top, on_top, 2 * size, rgb(15, 15, 20, opacity)));
    }
}

}  // namespace

Area build_slice(const SliceJob& job, const Sizes& sizes, ThreadPool& pool, Scene& scene) {
    const Slice& slice = *job.options.slice;
    const Plane plane = place(job, slice);
    const std::vector<Vec3> all = images(job.periods);
    const std::size_t n = job.mesh.cells();
    std::vector<std::vector<FillVertex>> blocks(ceil_div(n, block_cells));
    std::vector<std::vector<Stroke>> edges(blocks.size());
    std::vector<char> met(n);
    over_cells(n, pool, [&](std::size_t begin, std::size_t end, std::size_t block) {
        SliceBuilder builder(job, plane, slice, all);
        RingBuilder pieces(job, plane, scene.edge_width);
        for (std::size_t i = begin; i < end; ++i) {
            if (!job.shown.cells[i]) continue;
            const std::size_t before = blocks[block].size();
            if (job.mesh.rings)
                pieces.add_piece(i, blocks[block], edges[block]);
            else
                builder.add_cell(i, blocks[block]);
            met[i] = blocks[block].size() > before;
        }
    });
    append(blocks, scene.flat);
    append(edges, scene.strokes);
    remove_repeats(scene.strokes);
    if (job.options.seeds) add_seeds(job, plane, slice, met, 4 * sizes.unit, scene.strokes);
    if (job.options.frame) {
        static constexpr const char* names[] = {"x", "y", "z"};
        const Box& b = job.shown.bounds;
        add_axes({{{{b.lower[plane.across], b.upper[plane.across]}, {b.lower[plane.up], b.upper[plane.up]}}},
                  {names[plane.across], names[plane.up]}},
                 sizes, plane.area, scene);
    }
    return plane.area;
}

}  // namespace votess::picture

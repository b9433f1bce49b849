#include "picture/piece_sections.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/at.hpp"

namespace votess::picture {
namespace {

using Ring = std::vector<Vec3>;
using Edge = std::pair<std::int32_t, std::int32_t>;  // the lower vertex first

// The axes of the section, so that outlines turn counterclockwise.
struct SectionAxes {
    explicit SectionAxes(int normal)
        : across(static_cast<std::size_t>(normal + 1) % 3), up(static_cast<std::size_t>(normal + 2) % 3) {}
    std::size_t across, up;
};

double signed_area(const Ring& ring, const SectionAxes& axes) {
    double sum = 0;
    for (std::size_t k = 1; k + 1 < ring.size(); ++k) {
        const Vec3 a = ring[k] - ring[0], b = ring[k + 1] - ring[0];
        sum += a[axes.across] * b[axes.up] - a[axes.up] * b[axes.across];
    }
    return 0.5 * sum;
}

bool contains(const Ring& ring, const Vec3& p, const SectionAxes& axes) {
    bool inside = false;
    for (std::size_t k = 0; k < ring.size(); ++k) {
        const Vec3 &a = ring[k], &b = ring[k + 1 == ring.size() ? 0 : k + 1];
        if ((a[axes.up] > p[axes.up]) == (b[axes.up] > p[axes.up])) continue;
        const double share = (p[axes.up] - a[axes.up]) / (b[axes.up] - a[axes.up]);
        inside ^= p[axes.across] < a[axes.across] + share * (b[axes.across] - a[axes.across]);
    }
    return inside;
}

// Returns the rings of a piece, which lies on their left. A vertex is above the plane or below it, never on it. So each
// triangle that meets the plane has one edge that leads down and one that leads up, and each edge has as many of both.
std::vector<Ring> rings_of(const Pieces& pieces, std::size_t p, const CutPlane& plane) {
    const auto vertex = [&](std::int32_t v) {
        const double* const x = &pieces.vertices[3 * at(pieces.vertex_offsets[p] + v)];
        return Vec3{x[0], x[1], x[2]};
    };
    struct Step {
        Edge from, to;
    };
    std::vector<Step> steps;
    for (auto t = at(pieces.triangle_offsets[p]); t < at(pieces.triangle_offsets[p + 1]); ++t) {
        Step step{};
        bool meets = false;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t a = pieces.triangles[3 * t + k], b = pieces.triangles[3 * t + (k + 1) % 3];
            const bool a_above = plane.height(vertex(a)) > 0, b_above = plane.height(vertex(b)) > 0;
            if (a_above == b_above) continue;
            (a_above ? step.from : step.to) = std::minmax(a, b);
            meets = true;
        }
        if (meets) steps.push_back(step);
    }
    std::ranges::sort(steps, {}, &Step::from);
    std::vector<char> used(steps.size());
    std::vector<Ring> rings;
    for (std::size_t first = 0; first < steps.size(); ++first) {
        Ring ring;
        for (std::size_t k = first; !used[k];) {
            used[k] = 1;
            ring.push_back(crossing(vertex(steps[k].from.first), vertex(steps[k].from.second), plane));
            auto next = std::ranges::lower_bound(steps, steps[k].to, {}, &Step::from);
            while (next != steps.end() && next->from == steps[k].to && used[at(next - steps.begin())]) ++next;
            if (next == steps.end() || next->from != steps[k].to) break;
            k = at(next - steps.begin());
        }
        if (ring.size() > 2) rings.push_back(std::move(ring));
    }
    return rings;
}

}  // namespace

PieceSections::PieceSections(const Pieces& pieces, const Slice& slice) {
    const CutPlane plane{slice.axis, slice.value, 1};
    const SectionAxes axes(slice.axis);
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        std::vector<std::pair<double, std::vector<Ring>>> outlines;  // area, then the outline and its holes
        std::vector<Ring> holes;
        for (Ring& ring : rings_of(pieces, p, plane)) {
            const double area = signed_area(ring, axes);
            if (area > 0)
                outlines.push_back({area, {std::move(ring)}});
            else if (area < 0)
                holes.push_back(std::move(ring));
        }
        std::ranges::sort(outlines, {}, [](const auto& one) { return one.first; });
        for (Ring& hole : holes) {
            const auto around = std::ranges::find_if(
                outlines, [&](const auto& one) { return contains(one.second.front(), hole.front(), axes); });
            if (around != outlines.end()) around->second.push_back(std::move(hole));
        }
        for (const auto& [_, rings] : outlines) add(p, rings);
    }
    mesh = {indptr_, ids_, {}, offsets_, ends_, vertices_};
    mesh.rings = true;
}

void PieceSections::add(std::size_t of, const std::vector<std::vector<Vec3>>& rings) {
    piece.push_back(of);
    for (const Ring& ring : rings) {
        const auto first = static_cast<std::int32_t>(vertices_.size() / 3);
        const auto count = static_cast<std::int32_t>(ring.size());
        for (std::int32_t k = 0; k < count; ++k) {
            vertices_.insert(vertices_.end(), ring[at(k)].begin(), ring[at(k)].end());
            ends_.insert(ends_.end(), {first + k, k + 1 == count ? first : first + k + 1});
            offsets_.push_back(static_cast<std::int64_t>(ends_.size()));
            ids_.push_back(-1);
        }
    }
    indptr_.push_back(static_cast<std::int64_t>(ids_.size()));
}

}  // namespace votess::picture

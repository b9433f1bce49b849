#include "fields/flat_cells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"

namespace votess::fields {
namespace {

constexpr std::size_t flat_cells_of_task = 1024;
constexpr std::int32_t last_side = -4, first_oblique = -7;  // walls; those between bound the sheet

using Flat = std::array<double, 2>;

double flat_cross(const Flat& a, const Flat& b) {
    return a[0] * b[1] - a[1] * b[0];
}

// Returns -2 to 2 for angles from -pi to pi.
double direction_of(const Flat& n) {
    const double share = n[1] / (std::abs(n[0]) + std::abs(n[1]));
    return n[0] >= 0 ? share : std::copysign(2 - std::abs(share), n[1]);
}

}  // namespace

// Lengths are times the scale of the frame. Places are relative to the seed.
class FlatCells::Maker {
public:
    Maker(const Tessellation& t, const Frame& frame, const FlatSeeds& seeds, FlatCells& out)
        : t_(t), frame_(frame), seeds_(seeds), out_(out) {}

    void make(std::size_t seed) {
        const auto begin = static_cast<std::size_t>(t_.indptr()[seed]);
        const auto end = static_cast<std::size_t>(t_.indptr()[seed + 1]);
        lines_.clear();
        for (std::size_t entry = begin; entry < end; ++entry)
            if (const std::int32_t id = t_.indices()[entry]; id >= last_side || id <= first_oblique)
                add_line(seed, entry, id);
        std::ranges::sort(lines_, {}, &Line::direction);
        if (!find_corners()) return;
        const double scale = frame_.scale();
        const Flat& first = corners_.front();
        const double* const place = &seeds_.places[3 * seed];
        out_.firsts_[seed] = {place[0] + first[0] / scale, place[1] + first[1] / scale, 0};
        const Vector at = frame_.position(place), more = frame_.in_grid({first[0], first[1], 0});
        out_.ats_[seed] = {at[0] + more[0], at[1] + more[1], 0};
        double twice = 0;
        Flat from{corners_.back()[0] - first[0], corners_.back()[1] - first[1]};
        Flat from_in_grid = in_grid(from);
        for (std::size_t k = 0; k < lines_.size(); ++k) {
            const Flat to{corners_[k][0] - first[0], corners_[k][1] - first[1]}, to_in_grid = in_grid(to);
            twice += flat_cross(from, to);
            out_.areas_[lines_[k].entry] = std::hypot(to[0] - from[0], to[1] - from[1]) / scale;
            Edge& edge = out_.edges_[lines_[k].entry] = {from_in_grid, to_in_grid};
            if (frame_.mirrored()) std::swap(edge.from, edge.to);
            from = to, from_in_grid = to_in_grid;
        }
        out_.volumes_[seed] = std::max(0.0, twice / 2 / scale / scale);
    }

private:
    // The cell lies where normal.x <= offset.
    struct Line {
        Flat normal{};
        double offset = 0;
        double direction = 0;  // of the normal, grows with its angle
        std::size_t entry = 0;
    };

    [[nodiscard]] Flat in_grid(const Flat& way) const {
        const Vector x = frame_.in_grid({way[0], way[1], 0});
        return {x[0], x[1]};
    }

    void add_line(std::size_t seed, std::size_t entry, std::int32_t id) {
        const double scale = frame_.scale();
        const double* const place = &seeds_.places[3 * seed];
        Line line;
        line.entry = entry;
        if (id >= 0) {
            const auto other = static_cast<std::size_t>(id);
            for (std::size_t k = 0; k < 2; ++k) {
                line.normal[k] = seeds_.places[3 * other + k] * scale - place[k] * scale;
                if (t_.shifts().empty()) continue;
                for (std::size_t e = 0; e < 2; ++e) line.normal[k] += t_.shifts()[3 * entry + e] * frame_.edge(e)[k];
            }
            const double heavier = (seeds_.weights[seed] - seeds_.weights[other]) * scale * scale;
            line.offset = (line.normal[0] * line.normal[0] + line.normal[1] * line.normal[1] + heavier) / 2;
        } else if (id <= first_oblique) {
            const Wall& wall = seeds_.walls[static_cast<std::size_t>(first_oblique - id)];
            line.normal = {wall.normal[0], wall.normal[1]};
            line.offset = (wall.offset - wall.normal[0] * place[0] - wall.normal[1] * place[1]) * scale;
        } else {  // -1, -2 lie across edge 0, the first where it begins; -3, -4 across edge 1
            const auto across = static_cast<std::size_t>((-1 - id) / 2);
            const Vector &edge = frame_.edge(across), &along = frame_.edge(1 - across);
            const bool at_end = id % 2 == 0;
            line.normal = {along[1], -along[0]};
            if ((line.normal[0] * edge[0] + line.normal[1] * edge[1] > 0) != at_end)
                line.normal = {-line.normal[0], -line.normal[1]};
            for (std::size_t k = 0; k < 2; ++k)
                line.offset += line.normal[k] * ((frame_.origin()[k] - place[k] * scale) + (at_end ? edge[k] : 0.0));
        }
        line.direction = direction_of(line.normal);
        lines_.push_back(line);
    }

    // Finds the corners after the lines. Where rounding hides the turn to the next line, the edge between both corners
    // is shorter than rounding, so both are the one before. Returns false without any turn.
    bool find_corners() {
        const std::size_t count = lines_.size();
        corners_.resize(count);
        std::size_t last = count;  // with a turn
        for (std::size_t k = 0; k < count; ++k) {
            const Line &a = lines_[k], &b = lines_[(k + 1) % count];
            const double turn = flat_cross(a.normal, b.normal);
            const Flat corner{(a.offset * b.normal[1] - b.offset * a.normal[1]) / turn,
                              (a.normal[0] * b.offset - b.normal[0] * a.offset) / turn};
            if (turn > 0 && std::isfinite(corner[0]) && std::isfinite(corner[1])) {
                if (last == count) std::fill_n(corners_.begin(), k, corner);
                corners_[last = k] = corner;
            } else if (last < count) {
                corners_[k] = corners_[last];
            }
        }
        return last < count;
    }

    const Tessellation& t_;
    const Frame& frame_;
    const FlatSeeds& seeds_;
    FlatCells& out_;
    std::vector<Line> lines_;
    std::vector<Flat> corners_;
};

FlatCells::FlatCells(const Tessellation& t, const Frame& frame, const FlatSeeds& seeds, ThreadPool& pool)
    : edges_(t.indices().size()), firsts_(t.size()), ats_(t.size()), volumes_(t.size()), areas_(t.indices().size()) {
    pool.run(ceil_div(t.size(), flat_cells_of_task), [&](std::size_t task, unsigned) {
        check_stop();
        Maker maker(t, frame, seeds, *this);
        const std::size_t end = std::min(t.size(), (task + 1) * flat_cells_of_task);
        for (std::size_t seed = task * flat_cells_of_task; seed < end; ++seed)
            if (t.status()[seed] == CellStatus::certified) maker.make(seed);
    });
}

}  // namespace votess::fields

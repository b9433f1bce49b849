// Voro++: cells clipped one by one with a search over a grid of blocks, one thread.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>
#include <voro++/voro++.hh>

#include "bench.hpp"

namespace bench {
namespace {

constexpr int room_of_block = 8;  // particles that a block holds before it grows

// Its documentation recommends 4 to 8 particles a block; its own tool uses optimal_particles (5.6).
std::array<int, 3> blocks_for(const Input& input) {
    const double side = std::cbrt(input.volume() * voro::optimal_particles / static_cast<double>(input.size()));
    std::array<int, 3> blocks{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        blocks[axis] = std::max(1, static_cast<int>(std::lround(input.lengths()[axis] / side)));
    }
    return blocks;
}

// Containers have no common base with put(), and those of radii ask for one more number.
template <class Container>
void fill(Container& container, const Input& input) {
    for (std::size_t i = 0; i < input.size(); ++i) {
        const double* p = &input.points[3 * i];
        if constexpr (std::is_same_v<Container, voro::container_poly>) {
            container.put(static_cast<int>(i), p[0], p[1], p[2], input.radii[i]);
        } else {
            container.put(static_cast<int>(i), p[0], p[1], p[2]);
        }
    }
}

// Rows in the order in which Voro++ visits; bringing them to input order would be extra work for it.
class Lists {
public:
    Lists(std::size_t n, Want want) : full_(want == Want::full) {
        ids_.reserve(n);
        indptr_.reserve(n + 1);
        indices_.reserve(16 * n);
        if (full_) {
            volumes_.reserve(n);
            centroids_.reserve(3 * n);
            areas_.reserve(16 * n);
        }
    }

    template <class Loop, class Container>
    void compute(Container& container) {
        voro::voronoicell_neighbor cell;
        std::vector<int> faces;
        std::vector<double> face_areas;
        Loop loop(container);
        if (!loop.start()) {
            return;
        }
        do {
            if (!container.compute_cell(cell, loop)) {
                continue;  // a duplicate, or a seed without a cell in a power diagram
            }
            ids_.push_back(loop.pid());
            cell.neighbors(faces);
            if (full_) {
                cell.face_areas(face_areas);
            }
            for (std::size_t face = 0; face < faces.size(); ++face) {
                if (faces[face] >= 0) {  // no wall
                    indices_.push_back(faces[face]);
                    if (full_) {
                        areas_.push_back(face_areas[face]);
                    }
                }
            }
            indptr_.push_back(static_cast<std::int64_t>(indices_.size()));
            if (full_) {
                double x, y, z, cx, cy, cz;
                loop.pos(x, y, z);
                volumes_.push_back(cell.volume());
                cell.centroid(cx, cy, cz);
                centroids_.insert(centroids_.end(), {x + cx, y + cy, z + cz});
            }
        } while (loop.inc());
    }

    [[nodiscard]] Answer answer(double seconds) const {
        Answer answer{.seconds = seconds, .links = indices_.size()};
        answer.volume = std::accumulate(volumes_.begin(), volumes_.end(), 0.0);
        answer.area = std::accumulate(areas_.begin(), areas_.end(), 0.0);
        return answer;
    }

private:
    bool full_;
    std::vector<std::int32_t> ids_, indices_;
    std::vector<std::int64_t> indptr_{0};
    std::vector<double> volumes_, centroids_, areas_;
};

// arguments: of the container.
template <class Container, class Loop, class... Arguments>
Answer measure(const Input& input, Want want, const Arguments&... arguments) {
    const Stopwatch stopwatch;
    Container container(arguments..., room_of_block);
    fill(container, input);
    Lists lists(input.size(), want);
    lists.compute<Loop>(container);
    return lists.answer(stopwatch.seconds());
}

template <class Container>
Answer measure_in_box(const Input& input, Want want) {
    const auto& [lower, upper] = input.box;
    const auto [nx, ny, nz] = blocks_for(input);
    const auto [x, y, z] = input.periodic;
    return measure<Container, voro::c_loop_all>(input, want, lower[0], upper[0], lower[1], upper[1], lower[2], upper[2],
                                                nx, ny, nz, x, y, z);
}

Answer measure_in_cell(const Input& input, Want want) {
    const auto& [origin, a, b, c, periodic] = *input.cell;
    const auto [nx, ny, nz] = blocks_for(input);
    return measure<voro::container_periodic, voro::c_loop_all_periodic>(input, want, a[0], b[0], b[1], c[0], c[1], c[2],
                                                                        nx, ny, nz);
}

class Voropp final : public Peer {
public:
    [[nodiscard]] std::string name() const override { return "voro++"; }
    [[nodiscard]] std::string version() const override { return "0.4"; }  // its headers have no more digits
    // It takes radii, whose squares are the weights, and no weights.
    [[nodiscard]] bool can(const Input& input, Want want) const override {
        return want != Want::proof && input.weights.empty() && input.walls.empty();
    }

    [[nodiscard]] Answer run(const Input& input, Want want, unsigned) const override {
        if (input.cell) {
            return measure_in_cell(input, want);
        }
        return input.radii.empty() ? measure_in_box<voro::container>(input, want)
                                   : measure_in_box<voro::container_poly>(input, want);
    }
};

}  // namespace

std::unique_ptr<Peer> make_voropp() {
    return std::make_unique<Voropp>();
}

}  // namespace bench

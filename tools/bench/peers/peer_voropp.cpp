// Voro++: cells clipped one by one with a search over a grid of blocks, one thread.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <voro++/voro++.hh>

#include "bench.hpp"

namespace bench {
namespace {

class Voropp final : public Peer {
public:
    [[nodiscard]] std::string name() const override { return "voro++"; }
    [[nodiscard]] std::string version() const override { return "0.4"; }  // its headers do not tell more
    [[nodiscard]] bool can(Want) const override { return true; }

    [[nodiscard]] Answer run(const Input& input, Want want, unsigned) const override {
        // Its documentation asks for 4 to 8 particles a block; optimal_particles (5.6) is what its own tool aims for.
        const auto& [lower, upper] = input.box;
        double volume = 1;
        for (int axis = 0; axis < 3; ++axis) {
            volume *= upper[axis] - lower[axis];
        }
        const double side = std::cbrt(volume * voro::optimal_particles / static_cast<double>(input.size()));
        int blocks[3];
        for (int axis = 0; axis < 3; ++axis) {
            blocks[axis] = std::max(1, static_cast<int>(std::lround((upper[axis] - lower[axis]) / side)));
        }

        const Stopwatch stopwatch;
        voro::container container(lower[0], upper[0], lower[1], upper[1], lower[2], upper[2], blocks[0], blocks[1],
                                  blocks[2], false, false, false, 8);
        for (std::size_t i = 0; i < input.size(); ++i) {
            const double* p = &input.points[3 * i];
            container.put(static_cast<int>(i), p[0], p[1], p[2]);
        }

        // Rows in the order in which Voro++ visits; bringing them to input order would be extra work for it.
        std::vector<std::int32_t> ids;
        std::vector<std::int64_t> indptr{0};
        std::vector<std::int32_t> indices;
        std::vector<double> volumes, centroids, areas;
        ids.reserve(input.size());
        indptr.reserve(input.size() + 1);
        indices.reserve(16 * input.size());
        if (want == Want::full) {
            volumes.reserve(input.size());
            centroids.reserve(3 * input.size());
            areas.reserve(16 * input.size());
        }

        voro::voronoicell_neighbor cell;
        std::vector<int> faces;
        std::vector<double> face_areas;
        voro::c_loop_all loop(container);
        if (loop.start()) {
            do {
                if (!container.compute_cell(cell, loop)) {
                    continue;  // a duplicate
                }
                ids.push_back(loop.pid());
                cell.neighbors(faces);
                if (want == Want::full) {
                    cell.face_areas(face_areas);
                }
                for (std::size_t face = 0; face < faces.size(); ++face) {
                    if (faces[face] >= 0) {  // no wall
                        indices.push_back(faces[face]);
                        if (want == Want::full) {
                            areas.push_back(face_areas[face]);
                        }
                    }
                }
                indptr.push_back(static_cast<std::int64_t>(indices.size()));
                if (want == Want::full) {
                    double x, y, z, cx, cy, cz;
                    loop.pos(x, y, z);
                    volumes.push_back(cell.volume());
                    cell.centroid(cx, cy, cz);
                    centroids.insert(centroids.end(), {x + cx, y + cy, z + cz});
                }
            } while (loop.inc());
        }
        Answer answer{stopwatch.seconds(), indices.size(), 0};
        answer.volume = std::accumulate(volumes.begin(), volumes.end(), 0.0);
        answer.area = std::accumulate(areas.begin(), areas.end(), 0.0);
        return answer;
    }
};

}  // namespace

std::unique_ptr<Peer> make_voropp() {
    return std::make_unique<Voropp>();
}

}  // namespace bench

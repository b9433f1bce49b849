// Prints volumes and neighbors of cells. The points come from a file with lines `x y z`; without a file they are 1,000
// random ones in the unit box.
//
//     c++ -std=c++20 cells.cpp $(pkg-config --cflags --libs votess) -o cells
//     ./cells [POINTS.txt]
//
// ../cmake builds it with CMake.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>
#include <votess/votess.hpp>

namespace {

// Returns x0 y0 z0 x1 ...: votess takes all coordinates in one array.
std::vector<double> read_points(const std::string& path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error("cannot read " + path);
    std::vector<double> points;
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream row(line);
        double x = 0, y = 0, z = 0;
        if (!(row >> x >> y >> z)) {
            throw std::runtime_error(path + ", line " + std::to_string(number) + ": 3 numbers expected, got: " + line);
        }
        points.insert(points.end(), {x, y, z});
    }
    return points;
}

std::vector<double> random_points(std::size_t count) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::vector<double> points(3 * count);
    for (double& x : points) x = uniform(random);
    return points;
}

void print(const votess::Tessellation& t) {
    const votess::Box& box = t.box();
    std::printf("%zu cells in %g %g %g to %g %g %g, on %s\n", t.size(), box.lower[0], box.lower[1], box.lower[2],
                box.upper[0], box.upper[1], box.upper[2], t.stats().device.c_str());
    for (std::size_t i = 0; i < t.size() && i < 5; ++i) {
        std::printf("cell %zu: volume %g, neighbors", i, t.volumes()[i]);
        for (const auto j : t.neighbors(i)) std::printf(" %d", j);
        std::printf("\n");
    }
    std::printf("mean number of neighbors: %g\n",
                t.size() == 0 ? 0 : static_cast<double>(t.indices().size()) / static_cast<double>(t.size()));
    std::printf("sum of the volumes: %.12g\n", t.stats().volume_sum);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        votess::Options options;  // neighbors and volumes; options.want requests more
        std::vector<double> points;
        if (argc > 1) {
            points = read_points(argv[1]);  // votess makes a box around them
        } else {
            points = random_points(1000);
            options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        }
        const votess::Tessellation t = votess::tessellate(points, options);
        print(t);
    } catch (const std::exception& error) {  // such as votess::Error
        std::fprintf(stderr, "cells: %s\n", error.what());
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}

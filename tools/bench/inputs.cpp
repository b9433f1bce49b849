#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "bench.hpp"

namespace bench {
namespace {

// std::uniform_real_distribution differs between standard libraries; the engine behind it does not.
class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    double gaussian() {
        const double radius = std::sqrt(-2 * std::log1p(-uniform()));
        return radius * std::cos(2 * std::numbers::pi * uniform());
    }

private:
    std::mt19937_64 engine_;
};

const votess::Box unit_box{{0, 0, 0}, {1, 1, 1}};

Input uniform(std::size_t n, Random& random) {
    Input input{"uniform", std::vector<double>(3 * n), unit_box};
    for (double& x : input.points) {
        x = random.uniform();
    }
    return input;
}

// 50 normal clusters in the unit box, sigma from 0.01 to 0.05; what falls outside comes back in on the other side.
Input clustered(std::size_t n, Random& random) {
    struct Cluster {
        double center[3], sigma;
    };
    std::vector<Cluster> clusters(50);
    for (Cluster& c : clusters) {
        for (double& x : c.center) {
            x = random.uniform();
        }
        c.sigma = 0.01 + 0.04 * random.uniform();
    }
    Input input{"clustered", {}, unit_box};
    input.points.reserve(3 * n);
    for (std::size_t i = 0; i < n; ++i) {
        const Cluster& c = clusters[static_cast<std::size_t>(random.uniform() * static_cast<double>(clusters.size()))];
        for (const double center : c.center) {
            const double x = center + c.sigma * random.gaussian();
            input.points.push_back(x - std::floor(x));
        }
    }
    return input;
}

// Half-integers in an integer box, so that eight seeds lie on one sphere exactly around every inner cell vertex.
Input lattice(std::size_t n, Random&) {
    const auto side = static_cast<std::size_t>(std::max(1.0, std::round(std::cbrt(static_cast<double>(n)))));
    const double length = static_cast<double>(side);
    Input input{"lattice", {}, {{0, 0, 0}, {length, length, length}}};
    input.points.reserve(3 * side * side * side);
    for (std::size_t z = 0; z < side; ++z) {
        for (std::size_t y = 0; y < side; ++y) {
            for (std::size_t x = 0; x < side; ++x) {
                for (const std::size_t coordinate : {x, y, z}) {
                    input.points.push_back(static_cast<double>(coordinate) + 0.5);
                }
            }
        }
    }
    return input;
}

// The hardest case for a search by distance: every cell reaches the center, so every seed is near every other.
Input sphere(std::size_t n, Random& random) {
    Input input{"sphere", {}, unit_box};
    input.points.reserve(3 * n);
    for (std::size_t i = 0; i < n; ++i) {
        const double v[3] = {random.gaussian(), random.gaussian(), random.gaussian()};
        const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        for (const double x : v) {
            input.points.push_back(0.5 + (length > 0 ? 0.4 * x / length : 0.0));
        }
    }
    return input;
}

}  // namespace

const std::vector<std::string>& input_names() {
    static const std::vector<std::string> names{"uniform", "clustered", "lattice", "sphere"};
    return names;
}

Input make_input(std::string_view name, std::size_t n, std::uint64_t rng_seed) {
    Random random(rng_seed);
    if (name == "uniform") {
        return uniform(n, random);
    }
    if (name == "clustered") {
        return clustered(n, random);
    }
    if (name == "lattice") {
        return lattice(n, random);
    }
    if (name == "sphere") {
        return sphere(n, random);
    }
    throw std::invalid_argument("unknown input '" + std::string(name) + "'");
}

}  // namespace bench

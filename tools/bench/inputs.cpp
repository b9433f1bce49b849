#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
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

Input periodic(std::size_t n, Random& random) {
    Input input = uniform(n, random);
    input.name = "periodic";
    input.periodic = {true, true, true};
    return input;
}

Input triclinic(std::size_t n, Random& random) {
    Input input = uniform(n, random);
    input.name = "triclinic";
    const double tilt_xy = 0.4, tilt_xz = -0.3, tilt_yz = 0.2;
    input.cell = {.a = {1, 0, 0}, .b = {tilt_xy, 1, 0}, .c = {tilt_xz, tilt_yz, 1}};
    input.box = {{tilt_xz, 0, 0}, {1 + tilt_xy, 1 + tilt_yz, 1}};
    for (std::size_t i = 0; i < n; ++i) {
        double* p = &input.points[3 * i];
        p[0] += tilt_xy * p[1] + tilt_xz * p[2];
        p[1] += tilt_yz * p[2];
    }
    return input;
}

// A power diagram of spheres that overlap some of their neighbors: the largest radius is 0.74 of the mean spacing.
Input radii(std::size_t n, Random& random) {
    Input input = uniform(n, random);
    input.name = "radii";
    const double largest = 0.02 * std::cbrt(5e4 / static_cast<double>(n));
    input.radii.resize(n);
    for (double& radius : input.radii) {
        radius = largest * random.uniform();
    }
    return input;
}

// A power diagram whose weights exceed the square of the spacing by far. Most seeds have no cell, and others may lie
// outside their cells.
Input heavy(std::size_t n, Random& random) {
    Input input = uniform(n, random);
    input.name = "heavy";
    input.weights.resize(n);
    for (double& weight : input.weights) {
        weight = random.uniform();
    }
    return input;
}

// 50 normal clusters in the unit box, sigma from 0.01 to 0.05; seeds outside come back in on the other side.
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

// Seeds of a unit cell, repeated. Their coordinates are multiples of a quarter, so ties are exact: many cells meet in a
// vertex, and some touch only in a point or an edge.
Input lattice(std::string name, std::size_t n, const std::vector<std::array<double, 3>>& basis) {
    const double cells = static_cast<double>(n) / static_cast<double>(basis.size());
    const auto side = static_cast<std::uint64_t>(std::max(1.0, std::round(std::cbrt(cells))));
    const double length = static_cast<double>(side);
    Input input{std::move(name), {}, {{0, 0, 0}, {length, length, length}}};
    input.points.reserve(3 * basis.size() * side * side * side);
    for (std::uint64_t z = 0; z < side; ++z) {
        for (std::uint64_t y = 0; y < side; ++y) {
            for (std::uint64_t x = 0; x < side; ++x) {
                for (const auto& seed : basis) {
                    input.points.insert(input.points.end(),
                                        {static_cast<double>(x) + seed[0], static_cast<double>(y) + seed[1],
                                         static_cast<double>(z) + seed[2]});
                }
            }
        }
    }
    // Twice the pairs of seeds at the distances of the lattice's faces; in fcc, where walls meet, the next ones too.
    const std::uint64_t s = side, odd = 2 * side - 1;
    if (basis.size() == 1) {
        input.links = 6 * s * s * (s - 1);
    } else if (basis.size() == 2) {
        input.links = 2 * odd * odd * odd + 12 * s * s * (s - 1);
    } else {
        input.links = 12 * s * odd * odd + 24 * (s - 1);
    }
    return input;
}

Input cubic(std::size_t n, Random&) {
    return lattice("lattice", n, {{0.5, 0.5, 0.5}});
}

Input bcc(std::size_t n, Random&) {
    return lattice("bcc", n, {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}});
}

Input fcc(std::size_t n, Random&) {
    return lattice("fcc", n, {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.25}, {0.75, 0.25, 0.75}, {0.25, 0.75, 0.75}});
}

// A cubic lattice whose seeds moved by up to a quarter of the spacing along each axis.
Input jittered(std::size_t n, Random& random) {
    Input input = lattice("jittered", n, {{0.5, 0.5, 0.5}});
    for (double& x : input.points) {
        x += 0.25 * (2 * random.uniform() - 1);
    }
    input.links.reset();
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

// Uniform and periodic, with a sum of waves as weights. Its diagram is about that of seeds displaced by half of the
// gradient, here by at most `spacings` mean spacings: hardly a cell is empty. A solver of transport has such weights.
Input waves(std::string name, std::size_t count, double spacings, std::size_t n, Random& random) {
    constexpr double most_periods = 3;
    Input input = periodic(n, random);
    input.name = std::move(name);
    input.weights.assign(n, 0);
    std::vector<std::array<double, 3>> gradients(n, {0, 0, 0});
    for (std::size_t wave = 0; wave < count; ++wave) {
        double k[3] = {2 * std::numbers::pi, 0, 0}, square = 1;
        for (std::size_t axis = 0; axis < 3 && count > 1; ++axis) {
            const double periods = std::floor((2 * most_periods + 1) * random.uniform()) - most_periods;
            square += periods * periods - (axis == 0 ? 1 : 0);
            k[axis] = 2 * std::numbers::pi * periods;
        }
        const double phase = 2 * std::numbers::pi * random.uniform();
        for (std::size_t i = 0; i < n; ++i) {
            const double* p = &input.points[3 * i];
            const double angle = k[0] * p[0] + k[1] * p[1] + k[2] * p[2] + phase;
            input.weights[i] += std::sin(angle) / (1 + square);
            for (std::size_t axis = 0; axis < 3; ++axis) gradients[i][axis] += k[axis] * std::cos(angle) / (1 + square);
        }
    }
    double steepest = 0;
    for (const auto& g : gradients) steepest = std::max(steepest, std::hypot(g[0], g[1], g[2]));
    const double spacing = 1 / std::cbrt(static_cast<double>(n));
    for (double& weight : input.weights) weight *= 2 * spacings * spacing / steepest;
    return input;
}

Input smooth(std::size_t n, Random& random) {
    return waves("smooth", 20, 1, n, random);
}

Input transport(std::size_t n, Random& random) {
    return waves("transport", 20, 4, n, random);
}

template <int halves>
Input wave(std::size_t n, Random& random) {
    char name[16];
    std::snprintf(name, sizeof name, "wave-%g", halves / 2.0);
    return waves(name, 1, halves / 2.0, n, random);
}

// As heavy, but periodic.
Input hidden(std::size_t n, Random& random) {
    Input input = heavy(n, random);
    input.name = "hidden";
    input.periodic = {true, true, true};
    return input;
}

// The weights |x|^2 about the center: all cells with a vertex inside meet near it.
Input paraboloid(std::size_t n, Random& random) {
    Input input = uniform(n, random);
    input.name = "paraboloid";
    for (std::size_t i = 0; i < n; ++i) {
        double square = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double x = input.points[3 * i + axis] - 0.5;
            square += x * x;
        }
        input.weights.push_back(square);
    }
    return input;
}

// Seeds of a thin layer in the middle of the box.
Input sheet(std::size_t n, Random& random) {
    Input input = uniform(n, random);
    input.name = "sheet";
    constexpr double height = 0.006;
    for (std::size_t i = 0; i < n; ++i) input.points[3 * i + 2] = 0.5 + height * (input.points[3 * i + 2] - 0.5);
    return input;
}

// Uniform in an octahedron of walls.
Input octahedron(std::size_t n, Random& random) {
    Input input{"octahedron", {}, unit_box};
    constexpr double reach = 0.5;
    for (unsigned corner = 0; corner < 8; ++corner) {
        votess::Wall wall{{}, reach};
        for (std::size_t k = 0; k < 3; ++k) {
            wall.normal[k] = (corner >> k & 1) != 0 ? 1 : -1;
            wall.offset += 0.5 * wall.normal[k];
        }
        input.walls.push_back(wall);
    }
    while (input.points.size() < 3 * n) {
        const double p[3] = {random.uniform(), random.uniform(), random.uniform()};
        if (std::abs(p[0] - 0.5) + std::abs(p[1] - 0.5) + std::abs(p[2] - 0.5) < reach)
            input.points.insert(input.points.end(), p, p + 3);
    }
    return input;
}

struct Maker {
    const char* name;
    Input (*make)(std::size_t n, Random& random);
};
constexpr Maker makers[] = {{"uniform", uniform},
                            {"clustered", clustered},
                            {"lattice", cubic},
                            {"bcc", bcc},
                            {"fcc", fcc},
                            {"jittered", jittered},
                            {"sphere", sphere},
                            {"periodic", periodic},
                            {"triclinic", triclinic},
                            {"octahedron", octahedron},
                            {"radii", radii},
                            {"heavy", heavy},
                            {"smooth", smooth},
                            {"transport", transport},
                            {"wave-0.5", wave<1>},
                            {"wave-1", wave<2>},
                            {"wave-2", wave<4>},
                            {"wave-5", wave<10>},
                            {"hidden", hidden},
                            {"paraboloid", paraboloid},
                            {"sheet", sheet}};
constexpr std::string_view file_prefix = "file:";

// Returns the numbers of a line, without its comment. Throws for any other text.
std::vector<double> numbers_of(std::string line, const std::string& where) {
    line.resize(std::min(line.find('#'), line.size()));
    std::vector<double> numbers;
    for (const char* at = line.c_str();;) {
        at += std::strspn(at, " \t\r,");
        if (*at == '\0') {
            return numbers;
        }
        char* end = nullptr;
        const double number = std::strtod(at, &end);
        if (end == at || !std::isfinite(number)) {
            throw std::runtime_error(where + ": no number: " + at);
        }
        numbers.push_back(number);
        at = end;
    }
}

// The bounds, each side moved out by half of the mean spacing, as in votess::Options::box.
votess::Box box_around(const std::vector<double>& points) {
    votess::Box box;
    std::copy_n(points.begin(), 3, box.lower.begin());
    box.upper = box.lower;
    for (std::size_t i = 0; i < points.size(); ++i) {
        box.lower[i % 3] = std::min(box.lower[i % 3], points[i]);
        box.upper[i % 3] = std::max(box.upper[i % 3], points[i]);
    }
    double longest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        longest = std::max(longest, box.upper[axis] - box.lower[axis]);
    }
    const double margin = longest / std::cbrt(static_cast<double>(points.size() / 3)) / 2;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] -= margin;
        box.upper[axis] += margin;
    }
    return box;
}

}  // namespace

bool Input::plain() const {
    return periodic == std::array{false, false, false} && !cell && weights.empty() && radii.empty() && walls.empty();
}

std::array<double, 3> Input::lengths() const {
    if (cell) {
        return {cell->a[0], cell->b[1], cell->c[2]};
    }
    return {box.upper[0] - box.lower[0], box.upper[1] - box.lower[1], box.upper[2] - box.lower[2]};
}

double Input::volume() const {
    const auto [x, y, z] = lengths();
    return x * y * z;
}

votess::Options Input::options() const {
    votess::Options options;
    if (cell) {
        options.cell = cell;
    } else {
        options.box = box;
        options.periodic = periodic;
    }
    options.weights = weights;
    options.radii = radii;
    options.walls = walls;
    return options;
}

const std::vector<std::string>& input_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Maker& maker : makers) {
            all.emplace_back(maker.name);
        }
        return all;
    }();
    return names;
}

bool is_file(std::string_view name) {
    return name.starts_with(file_prefix);
}

std::string label_of(std::string_view name) {
    if (!is_file(name)) {
        return std::string(name);
    }
    return std::string(file_prefix) + std::filesystem::path(name.substr(file_prefix.size())).stem().string();
}

Input make_input(std::string_view name, std::size_t n, std::uint64_t rng_seed) {
    if (is_file(name)) {
        return read_points(std::string(name.substr(file_prefix.size())));
    }
    for (const Maker& maker : makers) {
        if (name == maker.name) {
            Random random(rng_seed);
            return maker.make(n, random);
        }
    }
    throw std::invalid_argument("unknown input '" + std::string(name) + "'");
}

Input read_points(const std::string& path) {
    std::ifstream in(path);
    if (!in) {
        throw std::runtime_error("cannot read " + path);
    }
    Input input{label_of(std::string(file_prefix) + path), {}, {}};
    std::size_t columns = 0, number = 0;
    for (std::string line; std::getline(in, line);) {
        const std::string where = path + ':' + std::to_string(++number);
        const std::vector<double> numbers = numbers_of(std::move(line), where);
        if (numbers.empty()) {
            continue;
        }
        columns = columns == 0 ? numbers.size() : columns;
        if (numbers.size() != columns || columns < 3 || columns > 4) {
            throw std::runtime_error(where + ": expected x y z or id x y z on every line");
        }
        input.points.insert(input.points.end(), numbers.end() - 3, numbers.end());
    }
    if (input.size() < 2) {
        throw std::runtime_error(path + ": fewer than two points");
    }
    input.points.shrink_to_fit();
    input.box = box_around(input.points);
    return input;
}

}  // namespace bench

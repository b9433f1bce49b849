// Benchmark of votess against its peers: inputs and peers.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <votess/votess.hpp>

namespace bench {

struct Input {
    std::string name;
    std::vector<double> points;  // x0 y0 z0 x1 ...
    votess::Box box;             // the bounds of a triclinic domain
    // As in votess::Options. A triclinic cell is periodic and begins at the origin, with a along x and b in the xy
    // plane: Voro++ takes no other.
    std::array<bool, 3> periodic{};
    std::optional<votess::TriclinicBox> cell = std::nullopt;
    std::vector<double> weights{}, radii{};
    std::vector<votess::Wall> walls{};
    // Sum of the lengths of the neighbor lists, where it is known; ties must not change it.
    std::optional<std::uint64_t> links = std::nullopt;
    [[nodiscard]] std::size_t size() const { return points.size() / 3; }
    // Whether the input is a Voronoi diagram in a box with walls, which every peer can do.
    [[nodiscard]] bool plain() const;
    [[nodiscard]] std::array<double, 3> lengths() const;  // of the box along the axes, without tilts
    [[nodiscard]] double volume() const;                  // of the box
    // Returns the domain and the weights, as views of the input.
    [[nodiscard]] votess::Options options() const;
};

// Returns the inputs that make_input generates.
const std::vector<std::string>& input_names();
bool is_file(std::string_view name);  // whether the name is file:PATH
// Returns the name of an input in reports: that of a file is without folders.
std::string label_of(std::string_view name);
// Returns about n points (a lattice has the nearest number possible), the same for the same arguments on every machine.
// Throws std::invalid_argument for an unknown name, std::runtime_error for a file that cannot be used.
Input make_input(std::string_view name, std::size_t n, std::uint64_t rng_seed);
// Reads text, a point a line: x y z or id x y z, '#' begins a comment. The box is the default of votess.
Input read_points(const std::string& path);

enum class Want {
    neighbors,
    full,   // volumes, centroids and face areas too
    proof,  // neighbors, of which only the time of the program's own check counts
};
std::string_view name_of(Want want);
// Returns the want with that name, one of the three.
Want want_of(std::string_view name);

// Sums of a peer's result, so that it cannot win by computing less.
struct Answer {
    double seconds = 0;
    std::uint64_t links = 0;                            // sum of the lengths of the neighbor lists, without walls
    double volume = 0;                                  // sum of the volumes; 0 when not computed
    double area = 0;                                    // sum of the face areas of all lists; 0 when not computed
    std::optional<votess::Stats> stats = std::nullopt;  // of votess
};

// One program to compare. run() measures the time from an array of points to neighbor lists in memory, without the
// setup that a user would reuse and without freeing. It throws std::exception when the peer fails on the input.
class Peer {
public:
    virtual ~Peer() = default;
    [[nodiscard]] virtual std::string name() const = 0;
    [[nodiscard]] virtual std::string version() const = 0;
    [[nodiscard]] virtual bool can(const Input& input, Want want) const = 0;
    // Returns the numbers of threads to measure with, out of those requested.
    [[nodiscard]] virtual std::vector<unsigned> threads(const std::vector<unsigned>&) const { return {1}; }
    // Whether the diagram ends at the box. Others report the unbounded diagram, which has more neighbors at the rim.
    [[nodiscard]] virtual bool bounded(const Input&) const { return true; }
    // Relative error of the sum of the volumes.
    [[nodiscard]] virtual double volume_error() const { return 1e-9; }
    // Makes the setup that a user would reuse, before the first run on an input. Not timed.
    virtual void prepare(const Input&, Want, unsigned) const {}
    [[nodiscard]] virtual Answer run(const Input& input, Want want, unsigned threads) const = 0;
};

// Makes votess on the CPU. instructions: as in votess::Options; they make a peer of their own, such as votess/avx2.
std::unique_ptr<Peer> make_votess(const std::string& instructions = "");
// Makes votess on a Vulkan device, named as in votess::Options. Throws votess::Error when the device is missing.
std::unique_ptr<Peer> make_votess_on(const std::string& device);
std::unique_ptr<Peer> make_voropp();
std::unique_ptr<Peer> make_qhull();
std::unique_ptr<Peer> make_cgal();
std::unique_ptr<Peer> make_geogram();

using Peers = std::vector<std::unique_ptr<Peer>>;

// Returns both directions of each pair as compressed rows, for peers that deliver pairs. A user who wants neighbor
// lists needs this step, so it is timed.
struct Rows {
    std::vector<std::int64_t> indptr;
    std::vector<std::int32_t> indices;
};
Rows rows_from_pairs(std::size_t n, const std::vector<std::pair<std::int32_t, std::int32_t>>& pairs);

class Stopwatch {
public:
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Returns the device among votess::devices() with this id (as for Options::device) or this name (as in Stats::device).
votess::DeviceInfo describe(const std::string& device, const std::string& name);

}  // namespace bench

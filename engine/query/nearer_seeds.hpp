// Seeds that a probe may bury: inside of its cell they are nearer than all seeds known so far. They belong to a power
// diagram or lie outside of the domain, in which they have a part all the same. The
// parts of the known seeds are convex, and on each of them the difference of two powers is linear. So a seed that is
// nearer anywhere is nearer at a vertex of some part.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "domain/probe.hpp"
#include "index/hierarchy.hpp"
#include "index/seed_images.hpp"

namespace votess::cpu {

// A sorted seed, and by which shift of it an image is meant, as seen from the place of a probe.
struct Member {
    std::int32_t home;
    exact::Shift shift{};
    friend auto operator<=>(const Member&, const Member&) = default;
};

// One per thread.
class NearerSeeds {
public:
    NearerSeeds(const SortedSeeds& seeds, const Hierarchy& hierarchy) : seeds_(seeds), hierarchy_(hierarchy) {}

    // Whether a probe may bury seeds. Otherwise each seed lies in its own part, which no probe takes whole.
    [[nodiscard]] bool may_bury() const { return !seeds_.weights.empty() || !seeds_.beyond.empty(); }
    void begin(const Probe& probe);
    // Adds a vertex of a part, relative to the probe. power: the squared distance of its seed, less the weight; error:
    // a bound on that of the place.
    void add_vertex(const std::array<double, 3>& x, double power, double error);
    // Appends the seeds that may be nearer at some vertex, unless `members` has them. Returns false when images outside
    // the sorted seeds may be nearer.
    [[nodiscard]] bool find(std::vector<Member>& members);

private:
    struct Vertex {
        std::array<double, 3> x;
        double power, error;
    };
    struct Node {
        int level;
        std::size_t index;
    };
    // No seed of a weight up to this is nearer at a vertex unless it is nearer to the probe than that.
    [[nodiscard]] double reach(double weight) const;
    // Whether a seed may be nearer at a vertex. square: a lower bound of their squared distance.
    [[nodiscard]] bool may_be_nearer(const Vertex& vertex, double square, double weight) const;
    [[nodiscard]] bool may_be_nearer(std::size_t place, double weight);
    // Returns the numbers of the vertices at which some seed of a node may be nearer.
    [[nodiscard]] const std::vector<std::uint32_t>& vertices_near(int level, std::size_t index);

    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    exact::Point at_{};
    double rounding_ = 0;  // of places
    double farthest_ = 0, highest_ = 0;
    std::vector<Vertex> vertices_;
    std::vector<Node> nodes_;
    // By level, the top last: those of the node whose seeds were tried last.
    struct NearVertices {
        std::size_t index;
        std::vector<std::uint32_t> numbers;
    };
    std::vector<NearVertices> near_;
    std::vector<Member> known_;  // sorted
};

}  // namespace votess::cpu

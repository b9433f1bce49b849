// The division of a probe's cell by the exact clipper. Part a is the set of points nearer to the probe than to seed a,
// and nearer to a than to any other seed. It is clipped as the cell of a, with the bisector of the probe reversed.
//
// The neighbors of the probe are all seeds that have a part, unless the probe may bury seeds: their whole cell was
// inside its cell. That happens in a power diagram, and to seeds outside of the domain. NearerSeeds finds them. Where
// it cannot, a search goes from part to part: the parts fill the cell, so each has a face in common with another.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "cpu/cell_builder.hpp"
#include "polytope/piece.hpp"
#include "query/nearer_seeds.hpp"
#include "triangulate/delaunay.hpp"
#include "triangulate/power_sites.hpp"

namespace votess::cpu {

struct Part {
    std::int32_t home;
    double volume;
    std::array<double, 3> moment{};  // the integral of x over the face with the seed, relative to the probe
    double distance = 1;             // of the seed
};

// One per thread.
class Parts {
public:
    Parts(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels)
        : seeds_(seeds), builder_(seeds, hierarchy, kernels), nearer_(seeds, hierarchy) {}

    void begin_job(const Domain& domain) { builder_.begin_job(domain); }
    // neighbors: of the probe, without its images; others may be among them. Returns the parts that have a volume.
    [[nodiscard]] std::span<const Part> divide(const Probe& probe, std::span<const Member> neighbors, bool moments);
    // Returns by how many members parts have been clipped, all together.
    [[nodiscard]] std::size_t clips() const { return clips_; }

private:
    [[nodiscard]] PowerSites sites_of_members() const;
    [[nodiscard]] SeedImages::Base base_of(std::int32_t home) const;
    [[nodiscard]] exact::Plane guard_of(const Member& member) const;
    [[nodiscard]] Cell& build(std::size_t k, std::span<const exact::Plane> guards);
    // Returns whether the part of members_[k] has a volume. Its cell is then in cell_, faces_.
    [[nodiscard]] bool clip(std::size_t k);
    void triangulate();
    void clip_all();
    void clip_by_search();
    void add_vertices_of(std::size_t k);
    void add_neighbors_of(std::size_t k);
    void add(const Member& member);
    // Measures the part of members_[k], which is the cell at hand.
    struct Known {
        std::size_t member;
        Part part;
        double error;   // a bound, of the volume
        Measured area;  // of the face with the seed, where moments are wanted
    };
    [[nodiscard]] Known measure(std::size_t k, Precision precision) const;

    const SortedSeeds& seeds_;
    CellBuilder builder_;
    NearerSeeds nearer_;
    const Probe* probe_ = nullptr;
    bool moments_ = false;
    std::size_t clips_ = 0;
    bool search_ = false;  // builds each part among all seeds, not among the members
    // The triangulation of many members, in their order: few of them cut each part, and none is cut out of a hidden
    // one.
    std::optional<Delaunay> triangulation_;
    std::vector<std::int32_t> around_;
    std::vector<std::uint8_t> marks_;
    std::vector<Member> members_;
    std::set<Member> found_;  // the same, while it searches
    std::vector<std::int32_t> homes_;
    std::vector<exact::Shift> shifts_;
    std::vector<Known> known_;
    std::vector<Part> parts_;
    const Cell* cell_ = nullptr;
    std::array<double, 3> to_probe_{};  // from its seed
    CellFaces faces_;
};

}  // namespace votess::cpu

// Regions of a surface, and the triangles that join those that meet.
//
// The polygons of all cells are faces of a complex without gaps. Each is in a region: at first, in a connected part of
// a cell. Triangles join the regions that meet at a place. They form a mesh like the surface if regions are disks, two
// of them share one curve at most, and three one place (Edelsbrunner, Shah: Triangulating topological spaces, 1997).
// Otherwise regions are split along sides of faces, which are first cut into triangles from their middle. That ends: no
// two of these triangles share more than a side, so that each could be a region of its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <utility>
#include <vector>

#include "core/at.hpp"
#include "votess/surface.hpp"

namespace votess::surface {

// As surface_cells() with SurfaceWant::polygons. Parts without area and sides without length are kept.
[[nodiscard]] SurfaceCells whole_cells(std::span<const double> points, const TriangleMesh& mesh, unsigned threads);

class Regions {
public:
    explicit Regions(SurfaceCells whole);

    // Splits faulty regions until there are none, or `max` regions. Each new one follows all before.
    void split(std::size_t max);
    [[nodiscard]] std::size_t size() const { return areas_.size(); }
    // By region: not 0 if triangles would not fit together there as the surface does. Regions at edges of more than two
    // triangles of the surface do not count.
    [[nodiscard]] const std::vector<std::uint8_t>& faults() const { return faults_; }
    // Returns whether a region was split, or cut to be.
    [[nodiscard]] bool is_cut(std::size_t region) const { return is_cut_[region] != 0; }
    // Turned as the surface, the lowest region first, ascending.
    [[nodiscard]] const std::vector<std::int32_t>& triangles() const { return triangles_; }
    // The faces as polygons, their regions as pieces.
    [[nodiscard]] const SurfaceCells& faces() const { return faces_; }

private:
    static constexpr std::uint8_t faulty = 1, beside_crowd = 2;  // by region: splitting it may not help the latter
    static constexpr std::int64_t border = -1, crowded = -2;     // of one triangle, of more than two
    using Pair = std::pair<std::int32_t, std::int32_t>;

    void connect();
    void judge();
    void walk_around(std::size_t first, std::vector<std::uint8_t>& is_seen);
    void meet();
    void count_sides();
    void mark(std::initializer_list<std::int32_t> regions);
    void mark_pairs();
    [[nodiscard]] bool is_split(std::size_t region) const { return (faults_[region] & faulty) != 0; }  // or will be
    void cut_faces();
    [[nodiscard]] bool bisect(std::int32_t region, const std::vector<std::size_t>& own);
    [[nodiscard]] std::size_t next(std::size_t side) const {
        return side + 1 == at(faces_.polygon_offsets[face_[side] + 1]) ? at(faces_.polygon_offsets[face_[side]])
                                                                       : side + 1;
    }
    [[nodiscard]] std::size_t before(std::size_t side) const {
        return side == at(faces_.polygon_offsets[face_[side]]) ? at(faces_.polygon_offsets[face_[side] + 1]) - 1
                                                               : side - 1;
    }
    [[nodiscard]] std::int32_t region_of(std::size_t side) const { return faces_.polygon_pieces[face_[side]]; }

    SurfaceCells faces_;
    std::vector<std::size_t> face_;    // by side
    std::vector<std::int64_t> other_;  // by side: the one on the other face; border or crowded
    // By region.
    std::vector<double> areas_;
    std::vector<std::size_t> counts_;   // faces
    std::vector<std::uint8_t> is_cut_;  // its faces are triangles from a middle
    std::vector<std::uint8_t> is_exempt_;
    std::vector<std::int64_t> euler_;
    std::vector<std::uint32_t> border_ends_;  // of its stretches of the border
    std::vector<std::uint8_t> faults_;
    std::vector<std::int32_t> triangles_;
    std::vector<std::array<std::int32_t, 3>> meetings_;  // triangles as found
    std::vector<Pair> ends_;                             // of curves that two regions share
    std::vector<Pair> closing_;                          // edges of triangles on the border
    std::vector<std::int32_t> around_;                   // regions around a vertex, each run once
    bool is_open_ = false;                               // they begin and end at a border
};

}  // namespace votess::surface

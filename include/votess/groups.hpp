// Sums of the cells by group: molecules, residues, grains, clusters.
//
//     const votess::Groups groups = votess::groups(t, labels);
//     for (k = groups.indptr[g]; k < groups.indptr[g + 1]; ++k)
//         groups.indices[k], groups.areas[k]         // group g touches this group, with this area
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
#include <votess/votess.hpp>

namespace votess {

// G groups of N seeds. Each array of sums is empty if the tessellation lacks the numbers.
struct Groups {
    std::vector<std::int64_t> labels;         // G, ascending: the different labels
    std::vector<std::int64_t> member_indptr;  // G+1 offsets into members
    std::vector<std::int32_t> members;        // N seeds: those of each group, ascending
    std::vector<std::int64_t> indptr;         // G+1 offsets into indices, counts and areas
    // The neighbors of each group, ascending: walls if the rows list them, then numbers of groups. A group is not its
    // own neighbor, not even across a periodic boundary.
    std::vector<std::int32_t> indices;
    std::vector<std::int64_t> counts;   // the faces between both; of a wall
    std::vector<double> areas;          // their area; equal for both groups
    std::vector<double> volumes;        // G
    std::vector<double> surface_areas;  // G: faces to other groups, to walls, and in a mesh to its surface
    std::vector<double> mesh_areas;     // G: the part on the surface of the mesh, with Want::surfaces

    [[nodiscard]] std::size_t size() const noexcept { return labels.size(); }  // G
};

// Returns the sums by group of N labels, one for each cell. areas need Want::areas, surface_areas also Want::surfaces.
// Throws invalid_argument for another
// number of labels, and for cells without neighbors in Want, of a subset, of probes.
[[nodiscard]] VOTESS_API Groups groups(const Tessellation& tessellation, std::span<const std::int64_t> labels);

}  // namespace votess

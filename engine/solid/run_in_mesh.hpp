// A run in a closed triangle mesh.
#pragma once

#include <memory>
#include <span>

#include "input/job.hpp"
#include "input/run_in_box.hpp"
#include "result/result.hpp"
#include "solid/closed_mesh.hpp"

namespace votess::solid {

// Returns the parts of the cells of a run in the mesh of its region. Makes the cells in a box around the mesh, on any
// device. Then the CPU cuts those that triangles come near. The others are inside or outside as a whole: one ray
// decides for all of them that are connected.
[[nodiscard]] detail::Result run_in_mesh(const Settled& whole, const RunInBox& run);

// Returns the region around the mesh and the points in which the cells are made: with a box, without the mesh. Throws
// for points that have no box, and for a mesh that is not inside.
[[nodiscard]] Region region_around(const ClosedMesh& mesh, const Settled& run);

// Returns the volume of a mesh, in a sheet the area that its prism stands on.
[[nodiscard]] double volume_in(const ClosedMesh& mesh, const Region& region);
// Throws invalid_argument unless the mesh lies in the box of the region, if that has one. A sheet has no ends above and
// below.
void check_inside(const ClosedMesh& mesh, const Region& region);
// Brings a mesh into the units of a job. Throws invalid_argument if it lies outside of a triclinic box.
void place_mesh(ClosedMesh& mesh, const Job& job);
// Returns the default box of a mesh and points. Throws for points that are not finite.
[[nodiscard]] Box default_box_around(const ClosedMesh& mesh, const Points& points);

// Returns the arrays of whole cells of probes that cut_probes() needs. Throws as check_want().
[[nodiscard]] Want want_of_probes(const Want& wanted);
// Cuts cells of probes at these places, 3Q as given. weights: scaled, or none. job: of the seeds, in units of the mesh.
[[nodiscard]] detail::Result cut_probes(detail::Result whole, std::span<const double> places,
                                        std::span<const double> weights, std::shared_ptr<const ClosedMesh> mesh,
                                        const Job& job, const Want& wanted);

// Throws `unsupported` for arrays that parts lack.
void check_want(const Want& want);

}  // namespace votess::solid

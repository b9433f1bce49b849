// Domains that HDF5 files state: those of clvotess, H5MD, MDTraj and cosmological snapshots.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "read/hdf5/hdf5_file.hpp"
#include "read/input.hpp"

namespace clvotess {

struct FrameOfFile {
    std::uint64_t number = 0, frames = 1;
};

// Returns the group of the particles in H5MD, of a dataset position or position/value; empty for other files.
[[nodiscard]] std::string particles_of(const std::string& points);

// Returns the domain of a file. note: receives what is not read. points: the dataset. dimensions: of the points. frame:
// of them, if there are frames.
[[nodiscard]] FileDomain domain_of_hdf5(const Hdf5File& file, const std::string& points, std::size_t dimensions,
                                        const std::optional<FrameOfFile>& frame, std::string& note);

// Returns the step of a frame in H5MD; empty without it.
[[nodiscard]] std::string timestep_of_hdf5(const Hdf5File& file, const std::string& points, std::uint64_t frame);

}  // namespace clvotess

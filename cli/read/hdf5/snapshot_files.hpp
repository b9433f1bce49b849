// Snapshots of Gadget, AREPO and SWIFT: NAME.hdf5, or the files NAME.0.hdf5, NAME.1.hdf5, ... of one snapshot.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace clvotess {

// The parts of a name such as snap_010.3.hdf5.
struct SnapshotName {
    std::string base;        // snap_010
    std::uint64_t part = 0;  // 3
    std::string extension;   // .hdf5

    [[nodiscard]] std::string file(std::uint64_t number) const {
        return base + "." + std::to_string(number) + extension;
    }
};

// Returns the parts of a name; nothing without a number before the extension.
[[nodiscard]] std::optional<SnapshotName> split_snapshot_name(const std::string& path);

// Returns the file to open for a path: the file itself, or the first file of the snapshot with that base.
[[nodiscard]] std::string first_snapshot_file(const std::string& path);

}  // namespace clvotess

// Snapshots of Gadget, AREPO and SWIFT: NAME.hdf5, or the files NAME.0.hdf5, NAME.1.hdf5, ... of one snapshot.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace clvotess {

// A name such as snap_010.3.hdf5, taken apart.
struct SnapshotName {
    std::string base;        // snap_010
    std::uint64_t part = 0;  // 3
    std::string extension;   // .hdf5

    [[nodiscard]] std::string file(std::uint64_t number) const {
        return base + "." + std::to_string(number) + extension;
    }
};

// Returns nothing when the name has no number before its extension.
[[nodiscard]] std::optional<SnapshotName> split_snapshot_name(const std::string& path);

// The file to open for what the user gave: the file itself, or the first of the snapshot whose base it is.
[[nodiscard]] std::string first_snapshot_file(const std::string& path);

}  // namespace clvotess

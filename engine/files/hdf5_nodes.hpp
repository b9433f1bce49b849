// Files of CGNS in HDF5's format, written without its library: a tree of nodes, each a group with one array.
// Formats: "HDF5 File Format Specification", version 1.8; "CGNS/HDF5" of the CGNS documentation.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "files/byte_sink.hpp"

namespace votess::files {

enum class NodeType : std::uint8_t { none, text, int32, int64, float32, float64 };

struct Hdf5Node {
    std::string name, label;  // at most 32 bytes each
    NodeType type = NodeType::none;
    std::vector<std::uint64_t> extent;    // of the array; the last index varies fastest
    std::function<void(ByteSink&)> put;   // writes the array
    std::vector<Hdf5Node> children = {};  // at most 65,000
};

// Writes a file whose root has these nodes. Throws invalid_argument for more children than a group may have.
void write_nodes(std::vector<Hdf5Node> nodes, ByteSink& out);

}  // namespace votess::files

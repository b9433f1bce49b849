// One HDF5 file that several processes write together. Each holds a share of the rows of each array.
#pragma once

#include <hdf5.h>

#include <functional>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "failure.hpp"
#include "read/input.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {

struct SharedArray {
    ResultArray own;          // the share of this process
    std::uint64_t first = 0;  // its first row in the whole
    std::uint64_t rows = 0;   // in the whole
};

struct Hdf5Share {
    std::string path;
    hid_t access = H5P_DEFAULT;  // how the library opens the file
    std::vector<SharedArray> arrays;
    const votess::Tessellation& domain;
    const std::vector<Attribute>& attributes;
    // Calls the work of this process, and throws if it fails in any process.
    std::function<void(const std::function<void()>&)> together;
    std::function<Failure(int)> failure;  // returns the exception for an errno
};

// Collective. Names, types, total rows, domains and attributes must be equal in all processes.
void write_hdf5_share(const Hdf5Share& share);

}  // namespace clvotess

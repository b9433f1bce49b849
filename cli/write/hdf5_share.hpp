// One HDF5 file that several processes write together, each a share of the rows of each array.
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
    ResultArray own;          // this share
    std::uint64_t first = 0;  // row of the whole that it begins with
    std::uint64_t rows = 0;   // of the whole
};

struct Hdf5Share {
    std::string path;
    hid_t access = H5P_DEFAULT;  // how the library opens the file
    std::vector<SharedArray> arrays;
    const votess::Tessellation& domain;
    const std::vector<Attribute>& attributes;
    // Does the work of this process and throws where that of any failed.
    std::function<void(const std::function<void()>&)> together;
    std::function<Failure(int)> failure;  // what to throw, of errno
};

// All processes call it, with equal names, types, numbers of rows, domains and attributes.
void write_hdf5_share(const Hdf5Share& share);

}  // namespace clvotess

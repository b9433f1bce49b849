// An output whose arrays come some rows at a time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "write/result_arrays.hpp"

namespace clvotess {

class StreamedFile {
public:
    virtual ~StreamedFile() = default;
    // The next array, with so many rows in all; those of `first` are its first ones. Arrays in the order of
    // result_arrays().
    virtual void add(const ResultArray& first, std::uint64_t rows) = 0;
    // Rows of array `number` from `row` on.
    virtual void write(std::size_t number, std::uint64_t row, const ResultArray& rows) = 0;
    // What a file holds once.
    virtual void finish(const votess::Tessellation& domain, const std::vector<Attribute>& attributes) = 0;
};

}  // namespace clvotess

// Bodies laid over a grid, on all threads.
#pragma once

#include <functional>
#include <memory>

#include "core/thread_pool.hpp"
#include "fields/slicer.hpp"

namespace votess::fields {

// Makes bodies and adds their values to the grid. Each thread has its own.
class Carrier {
public:
    virtual ~Carrier() = default;
    // Makes the body of this number. False when there is none.
    virtual bool load(std::size_t number, Body& body) = 0;
    // Adds the part of the last body that lies in a grid cell, an index. part: divided by the volume of the body, so
    // that the volumes of all parts sum to 1.
    virtual void add(std::size_t cell, const ConvexPiece::Measure& part) = 0;
};
using MakeCarrier = std::function<std::unique_ptr<Carrier>()>;

// Lays bodies 0 .. count-1 over the grid. Each tile of the grid belongs to one task, which adds bodies in their order.
// So sums do not depend on the number of threads, and parts take no memory.
void overlay(const Frame& frame, ThreadPool& pool, std::size_t count, const MakeCarrier& make_carrier);

}  // namespace votess::fields

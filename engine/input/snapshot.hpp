// A copy of the points of a call.
//
// Another thread may write into the caller's arrays during a call, and a mapped file may change. Two reads may then
// differ: a count of seeds, the bounds of a grid or a test for NaN would no longer fit the coordinates. So each call
// copies the points first, and reads only the copy. settle() copies weights and subsets, check_queries() queries.
#pragma once

#include "core/buffer.hpp"
#include "core/thread_pool.hpp"
#include "input/job.hpp"

namespace votess {

class Snapshot {
public:
    // Copies the points. The copy is valid until the next call of take().
    Points take(const Points& points, ThreadPool& pool);
    // Returns the memory of the copy, for other use when nobody reads it any more.
    [[nodiscard]] std::span<std::byte> memory() { return f64_.empty() ? f32_.memory() : f64_.memory(); }

private:
    Buffer<double> f64_{Buffer<double>::Pages::huge};
    Buffer<float> f32_{Buffer<float>::Pages::huge};
};

}  // namespace votess

// The points of a call, copied once.
//
// Another thread may write into the caller's arrays during a call, and a mapped file may change. What is read twice
// may then differ: a count of seeds, the bounds of a grid or a test for NaN no longer fits the coordinates. So each
// call copies the caller's points before it looks at them, and reads nothing but the copy. Weights are copied by
// scaled_weights(), queries by check_queries().
#pragma once

#include "core/buffer.hpp"
#include "core/thread_pool.hpp"
#include "input/job.hpp"

namespace votess {

class Snapshot {
public:
    // Copies the points. The copy is valid until the next call of take() or release_pages().
    Points take(const Points& points, ThreadPool& pool);
    // Gives the pages of a large copy back to the system. Its content is lost.
    void release_pages();

private:
    Buffer<double> f64_{Buffer<double>::Pages::huge};
    Buffer<float> f32_{Buffer<float>::Pages::huge};
};

}  // namespace votess

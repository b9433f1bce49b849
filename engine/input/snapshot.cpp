#include "input/snapshot.hpp"

#include <algorithm>
#include <cstring>
#include <functional>

#include "core/arithmetic.hpp"

namespace votess {
namespace {

constexpr std::size_t task_numbers = std::size_t{1} << 16;

template <class Real>
std::span<const Real> copy(std::span<const Real> from, Buffer<Real>& to, ThreadPool& pool) {
    to.resize_uninitialized(from.size());
    const auto task = [&](std::size_t index, unsigned) {
        const std::size_t begin = index * task_numbers, count = std::min(task_numbers, from.size() - begin);
        std::memcpy(to.data() + begin, from.data() + begin, count * sizeof(Real));
    };
    const std::size_t tasks = ceil_div(from.size(), task_numbers);
    if (tasks == 1)
        task(0, 0);
    else
        pool.run(tasks, std::cref(task));  // by reference: no allocation
    return to;
}

}  // namespace

Points Snapshot::take(const Points& points, ThreadPool& pool) {
    return {copy(points.f64, f64_, pool), copy(points.f32, f32_, pool), points.first};
}

}  // namespace votess

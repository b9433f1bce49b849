// A Tessellator used again takes no new memory for the same number of seeds. A program of its own, because it counts
// what operator new hands out.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <optional>
#include <random>
#include <thread>
#include <utility>
#include <vector>
#include <votess/votess.hpp>

#include "cpu/cell_builder.hpp"
#include "index/sort.hpp"

namespace {

std::atomic<std::size_t> taken{0};  // bytes since the program began
int failures = 0;

#define CHECK(condition)                                                                \
    do {                                                                                \
        if (!(condition)) {                                                             \
            std::fprintf(stderr, "reuse.cpp:%d: not true: %s\n", __LINE__, #condition); \
            ++failures;                                                                 \
        }                                                                               \
    } while (0)

void* take(std::size_t bytes, std::size_t alignment) {
    taken += bytes;
    void* memory =
        std::aligned_alloc(alignment, (std::max<std::size_t>(bytes, 1) + alignment - 1) / alignment * alignment);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

template <class Work>
std::size_t bytes_of(Work work) {
    const std::size_t before = taken;
    work();
    return taken - before;
}

std::vector<double> uniform(std::size_t count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::vector<double> points(3 * count);
    for (double& x : points) x = static_cast<double>(random() >> 11) * 0x1p-53;
    return points;
}

votess::Options options_for(votess::Want want, unsigned threads) {
    votess::Options options;
    options.device = "cpu";
    options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
    options.want = want;
    options.threads = threads;
    return options;
}

void check_later_calls(votess::Want want, std::size_t count, unsigned threads) {
    const votess::Options options = options_for(want, threads);
    votess::Tessellator tessellator;
    // The few cells measured in higher precision take some for a moment.
    const std::size_t little = (std::size_t{64} << 10) + (want.volumes ? 4 * count : 0);
    std::size_t least = SIZE_MAX;
    // A thread takes memory in a later call too where it gets more of the cells than ever before. That ends: none
    // gets more than all of them.
    const unsigned calls = threads == 1 ? 3 : 40;
    for (unsigned call = 1; call <= calls && least > little; ++call) {
        const auto points = uniform(count, call);  // other seeds have a few faces more or less
        const std::size_t bytes = bytes_of([&] { (void)tessellator.tessellate(points, options); });
        if (call >= 3) least = std::min(least, bytes);
    }
    std::printf("%zu seeds, %u threads: a later call took %zu bytes\n", count, threads, least);
    CHECK(least <= little);
}

void check_handles() {
    const votess::Options options = options_for({.areas = true}, 2);
    const auto a = uniform(5000, 1), b = uniform(5000, 2);
    const auto fresh_a = votess::tessellate(a, options), fresh_b = votess::tessellate(b, options);
    const auto same = [](const votess::Tessellation& x, const votess::Tessellation& y) {
        return std::ranges::equal(x.indices(), y.indices()) && std::ranges::equal(x.indptr(), y.indptr()) &&
               std::ranges::equal(x.volumes(), y.volumes()) && std::ranges::equal(x.face_areas(), y.face_areas());
    };
    std::optional<votess::Tessellator> tessellator(std::in_place);
    votess::Tessellation kept = tessellator->tessellate(a, options);
    const votess::Tessellation copy = kept;
    votess::Tessellation other = tessellator->tessellate(b, options);
    CHECK(same(kept, fresh_a) && same(copy, fresh_a) && same(other, fresh_b));
    const void* memory = other.indices().data();
    other = {};
    other = tessellator->tessellate(a, options);
    CHECK(other.indices().data() == memory);
    CHECK(same(kept, fresh_a) && same(other, fresh_a));
    // Dropped by other threads while the next one is made.
    for (int round = 0; round < 5; ++round) {
        std::thread dropper([dropped = std::exchange(other, {})]() mutable { dropped = {}; });
        other = tessellator->tessellate(round % 2 == 0 ? b : a, options);
        dropper.join();
        CHECK(same(other, round % 2 == 0 ? fresh_b : fresh_a));
    }
    // What is wanted and how much may change: nothing of an earlier run shows.
    other = {};
    other = tessellator->tessellate(uniform(100, 3), options_for({.neighbors = false, .counts = true}, 1));
    CHECK(other.indices().empty() && other.indptr().empty() && other.face_areas().empty() && other.size() == 100);
    std::thread dropper([dropped = std::exchange(other, {})]() mutable { dropped = {}; });
    tessellator.reset();
    dropper.join();
    CHECK(same(kept, fresh_a));
}

}  // namespace

void* operator new(std::size_t bytes) {
    return take(bytes, alignof(std::max_align_t));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {  // std::stable_sort
    try {
        return take(bytes, alignof(std::max_align_t));
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    return take(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    std::free(memory);
}

int main() {
    // Sanitizers have their own memory, and see the handles.
    if (std::getenv("VOTESS_TEST_REDUCED") == nullptr)
        for (const std::size_t count : {8000, 24000})
            for (const unsigned threads : {1u, 2u}) {
                check_later_calls({.volumes = false}, count, threads);
                check_later_calls({true, true, true, true, true}, count, threads);
            }
    check_handles();
    return failures == 0 ? 0 : 1;
}

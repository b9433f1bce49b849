#include "support/allocations.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define VOTESS_COUNT_ALLOCATIONS 0
#elif defined(__has_feature)
#define VOTESS_COUNT_ALLOCATIONS !(__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define VOTESS_COUNT_ALLOCATIONS 1
#endif

#if VOTESS_COUNT_ALLOCATIONS

namespace {

std::atomic<std::size_t> count{0};

void* counted(void* memory) {
    if (memory == nullptr) throw std::bad_alloc();
    ++count;
    return memory;
}

}  // namespace

// The other forms of new and delete call these.
void* operator new(std::size_t bytes) {
    return counted(std::malloc(bytes == 0 ? 1 : bytes));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    // Not every system has aligned_alloc(). The word before the memory is where malloc() began: both are multiples
    // of 16, also where a caller such as LLVM 22 requests less.
    const std::size_t step = std::max(static_cast<std::size_t>(alignment), std::size_t{16});
    auto* const begin = static_cast<std::byte*>(counted(std::malloc(bytes + step)));
    auto* const memory = begin + (step - reinterpret_cast<std::uintptr_t>(begin) % step);
    reinterpret_cast<void**>(memory)[-1] = begin;
    return memory;
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    if (memory != nullptr) std::free(static_cast<void**>(memory)[-1]);
}
void operator delete(void* memory, std::size_t, std::align_val_t alignment) noexcept {
    operator delete(memory, alignment);
}

std::optional<std::size_t> test::allocations() {
    return count.load();
}

#else

std::optional<std::size_t> test::allocations() {
    return std::nullopt;
}

#endif

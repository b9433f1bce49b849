// Memory that is reused and never filled. Whoever writes a part first also touches its pages first: threads share the
// cost of new pages, and each page lies near its thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/system.hpp"
#include "core/thread_pool.hpp"

namespace votess {

template <class T>
class Buffer {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    Buffer() = default;
    // Huge pages are slow to get, but scattered writes to small pages are slow too: their addresses do not fit the
    // processor's tables.
    enum class Pages : std::uint8_t { normal, huge };
    explicit Buffer(Pages pages) : pages_(pages) {}
    Buffer(Buffer&& other) noexcept { *this = std::move(other); }
    Buffer& operator=(Buffer&& other) noexcept {
        memory_ = std::move(other.memory_);
        size_ = std::exchange(other.size_, 0);
        capacity_ = std::exchange(other.capacity_, 0);
        pages_ = other.pages_;
        return *this;
    }

    // Keeps the elements unless the memory has to grow; then all are lost.
    void resize_uninitialized(std::size_t count) {
        if (count > capacity_) {
            memory_.reset();
            size_ = capacity_ = 0;
            const std::size_t room = count + count / 8;  // untouched memory costs nothing
            if (room > std::size_t{PTRDIFF_MAX} / sizeof(T)) throw std::bad_array_new_length();
            memory_ = allocate(room * sizeof(T), pages_);
            capacity_ = room;
        }
        size_ = count;
    }

    // Makes the pages of elements first .. end - 1 present, on all threads: cheaper than a fault for each page. No two
    // threads share a huge page, which both would clear.
    void touch(std::size_t first, std::size_t end, ThreadPool& pool) {
        constexpr std::uintptr_t page = 4096;
        const auto from = reinterpret_cast<std::uintptr_t>(data() + first) / page * page;
        const auto to = reinterpret_cast<std::uintptr_t>(data() + end), base = from / huge_page * huge_page;
        if (to < from + 4 * page) return;
        const auto touch_piece = [&](std::size_t piece, unsigned) {
            const std::uintptr_t begin = std::max(from, base + piece * huge_page);
            system::touch_pages(reinterpret_cast<void*>(begin), std::min(to, base + (piece + 1) * huge_page) - begin);
        };
        const std::size_t pieces = ceil_div(to - base, huge_page);
        pieces == 1 ? touch_piece(0, 0) : pool.run(pieces, std::cref(touch_piece));  // by reference: no allocation
    }

    // Returns the memory of a large buffer to the system but keeps its addresses. The contents are lost.
    void release_pages(std::size_t least = system::min_released) {
        auto* memory = reinterpret_cast<std::byte*>(memory_.get());
        const std::size_t bytes = capacity_ * sizeof(T), before = -reinterpret_cast<std::uintptr_t>(memory) % huge_page;
        if (bytes >= least && bytes >= before + huge_page)
            system::release_pages(memory + before, (bytes - before) / huge_page * huge_page);
    }

    // Returns the memory of the elements, and the rest of their last huge page.
    [[nodiscard]] std::span<std::byte> memory() {
        return {reinterpret_cast<std::byte*>(data()),
                std::min(capacity_ * sizeof(T), round_up(size_ * sizeof(T), huge_page))};
    }

    operator std::span<T>() { return {data(), size_}; }
    operator std::span<const T>() const { return {data(), size_}; }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] std::size_t capacity() const { return capacity_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }
    [[nodiscard]] T* data() { return memory_.get(); }
    [[nodiscard]] const T* data() const { return memory_.get(); }
    [[nodiscard]] T* begin() { return data(); }
    [[nodiscard]] T* end() { return data() + size_; }
    [[nodiscard]] const T* begin() const { return data(); }
    [[nodiscard]] const T* end() const { return data() + size_; }
    [[nodiscard]] T& operator[](std::size_t i) { return memory_[i]; }
    [[nodiscard]] const T& operator[](std::size_t i) const { return memory_.get()[i]; }

private:
    static constexpr std::size_t huge_page = system::huge_page;

    struct Free {
        std::align_val_t alignment{64};
        void operator()(T* memory) const { ::operator delete(memory, alignment); }
    };
    using Memory = std::unique_ptr<T[], Free>;

    static Memory allocate(std::size_t bytes, Pages pages) {
        Free free;
        const bool huge = pages == Pages::huge && bytes >= huge_page;
        if (huge) free.alignment = std::align_val_t{huge_page};
        void* const memory = ::operator new(bytes, free.alignment);
        if (huge) system::prefer_huge_pages(memory, bytes / huge_page * huge_page);
        return Memory(static_cast<T*>(memory), free);
    }

    Memory memory_;
    std::size_t size_ = 0, capacity_ = 0;
    Pages pages_ = Pages::normal;
};

}  // namespace votess

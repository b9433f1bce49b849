// Memory that a job needs no more. Its later arrays get it, so that the system clears no other pages for them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/system.hpp"

namespace votess {

class PageStock {
public:
    void clear() { memories_.clear(); }
    // Until clear() the owner neither uses nor frees this memory. Its contents are lost.
    void put(std::span<std::byte> memory) {
        if (!memory.empty()) memories_.push_back(memory);
    }
    // Returns `bytes` of memory, or fewer where no memory has so many, but not fewer than `least`, or none.
    [[nodiscard]] std::span<std::byte> take(std::size_t bytes, std::size_t least) {
        constexpr std::size_t alignment = 64;  // of what follows
        for (const std::size_t enough : {bytes, least})
            for (auto& memory : memories_) {
                if (memory.size() < enough) continue;
                const auto taken = memory.first(std::min(round_up(bytes, alignment), memory.size()));
                memory = memory.subspan(taken.size());
                return taken;
            }
        return {};
    }
    // Moves whole huge pages to new memory, as far as they go. allocated: bytes of the allocation that it is a part of.
    // Does nothing in a small one: the program's heap may have pages there already.
    void move_to(std::span<std::byte> fresh, std::size_t allocated) {
        constexpr std::size_t surely_new = std::size_t{32} << 20;
        if (allocated < surely_new) return;
        fresh = whole_pages(fresh);
        for (auto& memory : memories_) {
            const auto pages = whole_pages(memory);
            const std::size_t bytes = std::min(pages.size(), fresh.size());
            if (bytes == 0) continue;
            if (!system::move_pages(pages.data(), fresh.data(), bytes)) return;
            fresh = fresh.subspan(bytes);
            memory = pages.subspan(bytes);
        }
    }
    // Returns large memory to the system, except the first `kept` bytes.
    void shrink(std::size_t kept) {
        for (auto& memory : memories_) {
            const auto pages = whole_pages(memory.subspan(std::min(kept, memory.size())));
            kept -= std::min(kept, memory.size());
            if (pages.size() < system::min_released) continue;
            system::release_pages(pages.data(), pages.size());
            memory = memory.first(static_cast<std::size_t>(pages.data() - memory.data()));
        }
    }
    // Returns large memory to the system.
    void release() {
        for (const auto& memory : memories_)
            if (const auto pages = whole_pages(memory); pages.size() >= system::min_released)
                system::release_pages(pages.data(), pages.size());
        clear();
    }

private:
    static std::span<std::byte> whole_pages(std::span<std::byte> memory) {
        const std::size_t before = -reinterpret_cast<std::uintptr_t>(memory.data()) % system::huge_page;
        if (memory.size() < before) return {};
        return memory.subspan(before, (memory.size() - before) / system::huge_page * system::huge_page);
    }

    std::vector<std::span<std::byte>> memories_;
};

}  // namespace votess

// The operators new and delete of the tests, which libraries such as LLVM use too.
#include "support/allocations.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>

TEST_SUITE("stages") {
    TEST_CASE("allocations: memory of any alignment leaves its neighbors alone") {
        constexpr std::size_t count = 8;
        for (std::size_t alignment = 1; alignment <= 256; alignment *= 2)
            for (const std::size_t bytes : {1, 24, 4096}) {
                CAPTURE(alignment);
                CAPTURE(bytes);
                void* blocks[count];
                for (void*& block : blocks) {
                    block = ::operator new (bytes, std::align_val_t{alignment});
                    CHECK(reinterpret_cast<std::uintptr_t>(block) % alignment == 0);
                    std::memset(block, 0xff, bytes);
                }
                // A damaged block ends the process here.
                for (void* block : blocks) ::operator delete (block, bytes, std::align_val_t{alignment});
            }
    }
}

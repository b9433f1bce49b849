// Ids in three bytes each, for rows that wait: enough for 2^24 seeds, and a quarter less memory.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#if defined(__x86_64__)
#include <tmmintrin.h>
#endif

namespace votess::packed {

inline constexpr std::size_t bytes_per_id = 3;
inline constexpr std::size_t spare_bytes = 4;  // beyond the last id, which reading and writing may touch
inline constexpr std::int32_t walls = 256;     // ids from -walls on; stored as numbers from 0
inline constexpr std::size_t most_seeds = (std::size_t{1} << 24) - walls;

inline bool possible(std::size_t seeds, std::size_t wall_count) {
    return seeds <= most_seeds && wall_count <= static_cast<std::size_t>(walls) &&
           std::endian::native == std::endian::little;
}

inline void write(const std::int32_t* ids, std::size_t count, std::byte* to) {
    for (std::size_t i = 0; i < count; ++i) {  // the fourth byte is the next one's
        const std::int32_t number = ids[i] + walls;
        std::memcpy(to + bytes_per_id * i, &number, sizeof number);
    }
}

inline void read(const std::byte* from, std::size_t count, std::int32_t* ids) {
    for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t number;
        std::memcpy(&number, from + bytes_per_id * i, sizeof number);
        ids[i] = static_cast<std::int32_t>(number & 0xffffff) - walls;
    }
}

#if defined(__x86_64__)

inline bool fast_possible() {
    return __builtin_cpu_supports("ssse3") != 0;
}

// The same, four at a time.
[[gnu::target("ssse3")]] inline void fast_write(const std::int32_t* ids, std::size_t count, std::byte* to) {
    constexpr std::size_t together = 4;
    const __m128i gather = _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1);
    const __m128i offset = _mm_set1_epi32(walls);
    std::size_t i = 0;
    for (; i + together <= count; i += together) {
        const __m128i four = _mm_loadu_si128(reinterpret_cast<const __m128i*>(ids + i));
        const __m128i bytes = _mm_shuffle_epi8(_mm_add_epi32(four, offset), gather);
        _mm_storeu_si128(reinterpret_cast<__m128i*>(to + bytes_per_id * i), bytes);
    }
    write(ids + i, count - i, to + bytes_per_id * i);
}
[[gnu::target("ssse3")]] inline void fast_read(const std::byte* from, std::size_t count, std::int32_t* ids) {
    constexpr std::size_t together = 4;
    const __m128i spread = _mm_setr_epi8(0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1);
    const __m128i offset = _mm_set1_epi32(walls);
    std::size_t i = 0;
    for (; i + together <= count; i += together) {
        const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + bytes_per_id * i));
        const __m128i numbers = _mm_sub_epi32(_mm_shuffle_epi8(bytes, spread), offset);
        _mm_storeu_si128(reinterpret_cast<__m128i*>(ids + i), numbers);
    }
    read(from + bytes_per_id * i, count - i, ids + i);
}

#else

inline bool fast_possible() {
    return false;
}
inline void fast_write(const std::int32_t* ids, std::size_t count, std::byte* to) {
    write(ids, count, to);
}
inline void fast_read(const std::byte* from, std::size_t count, std::int32_t* ids) {
    read(from, count, ids);
}

#endif

}  // namespace votess::packed

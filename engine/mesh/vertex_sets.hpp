// Sets of vertices that are equal except for a translation by whole box vectors: union-find (Galler and Fischer 1964)
// with translations on the links. Many threads join sets at once.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "core/buffer.hpp"
#include "exact/predicate.hpp"

namespace votess {

struct ShiftedVertex {
    std::uint32_t vertex;
    exact::Shift shift;  // from it
};

class VertexSets {
public:
    // Every vertex is alone. init() for the vertices of a range, from any thread.
    explicit VertexSets(std::size_t count) { words_.resize_uninitialized(count); }
    void init(std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) words_[v] = pack({static_cast<std::uint32_t>(v), {}});
    }

    // From any thread. The root of the set, and how far the vertex is from it.
    [[nodiscard]] ShiftedVertex find(std::uint32_t vertex) {
        exact::Shift shift{};
        for (;;) {
            const std::uint64_t word = load(vertex);
            if (static_cast<std::uint32_t>(word) == vertex) return {vertex, shift};
            const ShiftedVertex up = unpack(word);
            if (word >> vertex_bits == no_shift) {  // as nearly all are
                const std::uint64_t next = load(up.vertex);
                if (static_cast<std::uint32_t>(next) == up.vertex) return {up.vertex, shift};
                if (next >> vertex_bits == no_shift) {
                    replace(vertex, word, next);
                    vertex = static_cast<std::uint32_t>(next);
                    continue;
                }
            }
            const ShiftedVertex upper = unpack(load(up.vertex));
            const ShiftedVertex both{upper.vertex, sum(up.shift, upper.shift)};
            if (upper.vertex != up.vertex) replace(vertex, word, pack(both));  // a shorter way for the next
            shift = sum(shift, both.shift);
            vertex = both.vertex;
        }
    }
    // When all are united, from any thread: the vertices of a range point to their roots.
    void flatten(std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const auto vertex = static_cast<std::uint32_t>(v);
            if (root(vertex) != vertex) std::atomic_ref(words_[v]).store(pack(find(vertex)), std::memory_order_relaxed);
        }
    }
    // After flatten(): the root of a vertex, and whether it is moved from the root.
    [[nodiscard]] std::uint32_t root(std::uint32_t vertex) { return static_cast<std::uint32_t>(load(vertex)); }
    [[nodiscard]] bool is_moved(std::uint32_t vertex) { return load(vertex) >> vertex_bits != no_shift; }
    // From any thread. Vertex a is vertex b moved by the shift.
    void unite(std::uint32_t a, std::uint32_t b, const exact::Shift& shift) {
        if (shift == exact::Shift{} && load(a) == load(b)) return;  // they have been united by another face
        for (;;) {
            const ShiftedVertex ra = find(a), rb = find(b);
            if (ra.vertex == rb.vertex) return;
            // ra + ra.shift = rb + rb.shift + shift
            const exact::Shift between = sum(sum(rb.shift, shift), negative(ra.shift));
            const bool up = ra.vertex > rb.vertex;
            const ShiftedVertex link{up ? rb.vertex : ra.vertex, up ? between : negative(between)};
            const std::uint32_t linked = up ? ra.vertex : rb.vertex;
            if (replace(linked, pack({linked, {}}), pack(link))) return;
        }
    }

    static exact::Shift sum(const exact::Shift& a, const exact::Shift& b) {
        return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
    }
    static exact::Shift negative(const exact::Shift& a) { return {-a[0], -a[1], -a[2]}; }

private:
    static constexpr int shift_bits = 10, vertex_bits = 32;
    static constexpr int shift_zero = 1 << (shift_bits - 1);
    static constexpr std::uint64_t no_shift =
        shift_zero * (1ull | 1ull << shift_bits | 1ull << 2 * shift_bits);  // of a word, packed

    static std::uint64_t pack(const ShiftedVertex& v) {
        std::uint64_t word = v.vertex;
        for (int k = 0; k < 3; ++k)
            word |= static_cast<std::uint64_t>(v.shift[k] + shift_zero) << (vertex_bits + k * shift_bits);
        return word;
    }
    static ShiftedVertex unpack(std::uint64_t word) {
        ShiftedVertex v{static_cast<std::uint32_t>(word), {}};
        for (int k = 0; k < 3; ++k)
            v.shift[k] =
                static_cast<int>(word >> (vertex_bits + k * shift_bits) & ((1u << shift_bits) - 1)) - shift_zero;
        return v;
    }
    [[nodiscard]] std::uint64_t load(std::uint32_t vertex) {
        return std::atomic_ref(words_[vertex]).load(std::memory_order_relaxed);
    }
    bool replace(std::uint32_t vertex, std::uint64_t old, std::uint64_t word) {
        return std::atomic_ref(words_[vertex]).compare_exchange_strong(old, word, std::memory_order_relaxed);
    }

    Buffer<std::uint64_t> words_;
};

}  // namespace votess

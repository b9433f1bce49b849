#include "exact/corner.hpp"

#include "exact/integer/normals.hpp"

namespace votess::exact {
namespace {

// The hull under construction: a ring of planes, each with the side of the hull that leads to the next.
template <class N>
struct Link {
    decltype(cross_of(N{}, N{})) side;  // N x next N: positive towards the inside
    int next, previous;
};

// Incremental hull of rays in an open half space. A new ray sees one run of sides. It lies strictly outside some. At
// either end it may lie in line with a side, whose near corner then falls between the two.
template <class N>
std::span<int> hull(std::span<const N> n, std::span<int> out) {
    const int count = static_cast<int>(n.size());
    int second = 1;
    while (second < count && cross_of(n[0], n[second]).is_zero()) ++second;
    if (second >= count) return {};
    const auto side = cross_of(n[0], n[second]);
    int third = second + 1, turn = 0;
    while (third < count && (turn = side.turn(n[third])) == 0) ++third;
    if (third >= count) return {};

    Scratch<Link<N>> ring(n.size());
    auto connect = [&](int i, int j) {
        ring[i].side = cross_of(n[i], n[j]);
        ring[i].next = j;
        ring[j].previous = i;
    };
    const int left = turn > 0 ? second : third, right = turn > 0 ? third : second;
    connect(0, left);
    connect(left, right);
    connect(right, 0);
    int head = 0;
    for (int k = 1; k < count; ++k) {
        if (k == second || k == third) continue;
        auto turn_at = [&](int i) { return ring[i].side.turn(n[k]); };
        int i = head;
        while (turn_at(i) >= 0 && ring[i].next != head) i = ring[i].next;
        if (turn_at(i) >= 0) continue;
        int begin = i, end = ring[i].next;
        while (begin != end && turn_at(ring[begin].previous) <= 0) begin = ring[begin].previous;
        while (begin != end && turn_at(end) <= 0) end = ring[end].next;
        if (begin == end) return {};  // no half space holds these normals
        connect(begin, k);
        connect(k, end);
        head = k;
    }
    std::size_t size = 0;
    int i = head;
    do {
        out[size++] = i;
        i = ring[i].next;
    } while (i != head);
    return out.first(size);
}

}  // namespace

std::span<int> corner_polygon(const Point& p, std::span<const Plane* const> planes, std::span<int> out) {
    if (planes.size() < 3) return {};
    return decide_on_normals(p, planes, [out](auto normals) { return hull(normals, out); });
}

}  // namespace votess::exact

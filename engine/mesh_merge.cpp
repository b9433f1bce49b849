// Matching the polygons of a face as its two cells have them.
#include <algorithm>
#include <limits>
#include <string>

#include "mesh_builder.hpp"

namespace votess {
namespace {

// The best turn is that of equal polygons when every other one is so much farther off, in squares.
constexpr double clearly_worse = 100;

[[noreturn]] void bug(std::size_t cell, std::int32_t other) {
    throw Error(ErrorCode::internal, "a bug in votess: cells " + std::to_string(cell) + " and " +
                                         std::to_string(other) + " differ in the face that they share");
}

Shift wide(const std::array<std::int8_t, 3>& s) {
    return {s[0], s[1], s[2]};
}

// As seen from a cell that lies `shift` away from where the label counts from.
bool same(const FaceLabel& a, const FaceLabel& b, const Shift& b_shift) {
    if (a.id != b.id) return false;
    return a.id < 0 || wide(a.shift) == VertexSets::sum(wide(b.shift), b_shift);
}

std::array<double, 3> middle(const MeshCellView& cell, std::size_t row) {
    std::array<double, 3> sum{};
    for (std::uint32_t k = cell.begin(row); k < cell.end(row); ++k)
        for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += cell.position(cell.corner(k))[axis];
    for (double& x : sum) x /= cell.end(row) - cell.begin(row);
    return sum;
}

}  // namespace

FaceLabel FaceMatcher::label(std::size_t entry) const {
    FaceLabel label{result_.indices[entry], {}};
    if (!result_.shifts.empty()) std::copy_n(result_.shifts.data() + 3 * entry, 3, label.shift.begin());
    return label;
}

// The row's size if it has none.
std::size_t FaceMatcher::find_entry(std::size_t cell, const FaceLabel& wanted) const {
    const auto begin = static_cast<std::size_t>(result_.indptr[cell]);
    std::size_t low = 0, high = static_cast<std::size_t>(result_.indptr[cell + 1]) - begin;
    const std::size_t size = high;
    while (low < high) {
        const std::size_t half = (low + high) / 2;
        if (label(begin + half) < wanted)
            low = half + 1;
        else
            high = half;
    }
    return low < size && label(begin + low) == wanted ? low : size;
}

void FaceMatcher::unite_faces(std::size_t i) {
    const auto begin = static_cast<std::size_t>(result_.indptr[i]),
               end = static_cast<std::size_t>(result_.indptr[i + 1]);
    if (MeshCellView(records_[i]).faces() != end - begin) bug(i, static_cast<std::int32_t>(i));
    const FaceLabel own{static_cast<std::int32_t>(i), {}};
    for (std::size_t entry = begin; entry < end; ++entry) {
        const FaceLabel there = label(entry);
        if (there < own) continue;
        FaceLabel back = own;
        for (std::size_t k = 0; k < 3; ++k) back.shift[k] = static_cast<std::int8_t>(-there.shift[k]);
        const auto j = static_cast<std::size_t>(there.id);
        const std::size_t row = find_entry(j, back);
        if (row == static_cast<std::size_t>(result_.indptr[j + 1] - result_.indptr[j])) bug(i, there.id);
        unite_face({i, entry - begin}, {j, row}, wide(there.shift));
    }
}

// The other cell's polygon runs the other way round: its corner t is this one's corner (turn - t).
void FaceMatcher::unite_face(const Face& face, const Face& other, const Shift& shift) {
    const MeshCellView a(records_[face.cell]), b(records_[other.cell]);
    const std::uint32_t a_begin = a.begin(face.row), b_begin = b.begin(other.row);
    const std::uint32_t count = a.end(face.row) - a_begin;
    if (b.faces() <= other.row || b.end(other.row) - b_begin != count)
        bug(face.cell, static_cast<std::int32_t>(other.cell));
    std::uint32_t turn = 1;  // both begin with the same edge
    if (!same(a.beginning(face.row), b.beginning(other.row), shift)) {
        bool clear = false;
        turn = turn_by_distance(a, face.row, b, other.row, clear);
        if (!clear) turn = turn_by_labels(face, other, shift).value_or(turn);
    }
    const auto a_first = static_cast<std::uint32_t>(result_.cell_vertex_indptr[face.cell]);
    const auto b_first = static_cast<std::uint32_t>(result_.cell_vertex_indptr[other.cell]);
    for (std::uint32_t t = 0; t < count; ++t)
        sets_.unite(a_first + a.corner(a_begin + (turn + count - t) % count), b_first + b.corner(b_begin + t), shift);
}

// Of edges where more than three cells meet, the cells of a face name different ones.
std::uint32_t FaceMatcher::turn_by_distance(const MeshCellView& a, std::size_t row_a, const MeshCellView& b,
                                            std::size_t row_b, bool& clear) const {
    const auto middle_a = middle(a, row_a), middle_b = middle(b, row_b);
    const std::uint32_t a_begin = a.begin(row_a), b_begin = b.begin(row_b), count = a.end(row_a) - a_begin;
    double best = std::numeric_limits<double>::infinity(), second = best;
    std::uint32_t best_turn = 0;
    for (std::uint32_t turn = 0; turn < count; ++turn) {
        double sum = 0;
        for (std::uint32_t t = 0; t < count && sum < second; ++t) {
            const double* x = a.position(a.corner(a_begin + (turn + count - t) % count));
            const double* y = b.position(b.corner(b_begin + t));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double d = (x[axis] - middle_a[axis]) - (y[axis] - middle_b[axis]);
                sum += d * d;
            }
        }
        if (sum < best) {
            second = best;
            best = sum;
            best_turn = turn;
        } else {
            second = std::min(second, sum);
        }
    }
    clear = best * clearly_worse < second;
    return best_turn;
}

// For a polygon so small that rounding spoils it: an edge that both name alike is the same edge.
std::optional<std::uint32_t> FaceMatcher::turn_by_labels(const Face& face, const Face& other,
                                                         const Shift& shift) const {
    const MeshCellView a(records_[face.cell]), b(records_[other.cell]);
    const std::uint32_t count = a.end(face.row) - a.begin(face.row);
    for (std::uint32_t p = 0; p < count; ++p) {
        FaceLabel ours, theirs;
        if (!label_across(face, p, ours)) continue;
        for (std::uint32_t q = 0; q < count; ++q)
            if (label_across(other, q, theirs) && same(ours, theirs, shift)) return (p + 1 + q) % count;
    }
    return std::nullopt;
}

// Of the face across the edge that begins at a corner; false for a wall that rows do not list.
bool FaceMatcher::label_across(const Face& face, std::uint32_t place, FaceLabel& out) const {
    const MeshCellView cell(records_[face.cell]);
    const auto next = [&](std::size_t row, std::uint32_t k) {
        return cell.corner(k + 1 == cell.end(row) ? cell.begin(row) : k + 1);
    };
    const std::uint32_t k = cell.begin(face.row) + place, from = cell.corner(k), to = next(face.row, k);
    for (std::size_t row = 0; row < cell.faces(); ++row)
        for (std::uint32_t c = cell.begin(row); c < cell.end(row); ++c)
            if (cell.corner(c) == to && next(row, c) == from) {
                out = label(static_cast<std::size_t>(result_.indptr[face.cell]) + row);
                return true;
            }
    return false;
}

}  // namespace votess

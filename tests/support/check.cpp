#include "support/check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <set>
#include <sstream>
#include <votess/pieces.hpp>

#include "oracle/certificate.hpp"
#include "oracle/half_spaces.hpp"
#include "polytope/cell_kernels.hpp"
#include "support/arrays.hpp"
#include "support/text.hpp"

namespace test {

namespace {

std::string text_row(std::span<const std::int32_t> row) {
    std::ostringstream out;
    out << '[';
    for (std::size_t k = 0; k < row.size(); ++k) out << (k ? " " : "") << row[k];
    out << ']';
    return out.str();
}

bool is_duplicate(const votess::Tessellation& t, std::size_t i) {
    return t.status()[i] == votess::CellStatus::duplicate;
}

std::string check_duplicate_cell(const votess::Tessellation& t, std::span<const double> points, std::size_t i) {
    if (!t.neighbors(i).empty()) return text("duplicate ", i, " has neighbors");
    if (!t.volumes().empty() && t.volumes()[i] != 0) return text("duplicate ", i, " has a volume");
    if (!t.centroids().empty() && !std::isnan(t.centroids()[3 * i])) return text("duplicate ", i, " has a centroid");
    if (!t.face_counts().empty() && t.face_counts()[i] + t.edge_counts()[i] + t.vertex_counts()[i] != 0)
        return text("duplicate ", i, " has faces, edges or vertices");
    const auto of = t.duplicate_of()[i];
    if (of < 0 || static_cast<std::size_t>(of) >= i) return text("duplicate ", i, " of ", of);
    for (std::size_t a = 0; a < 3; ++a)
        if (points[3 * i + a] != points[3 * static_cast<std::size_t>(of) + a])
            return text(i, " is no duplicate of ", of);
    return "";
}

std::string check_row(const votess::Tessellation& t, std::size_t i) {
    const auto row = t.neighbors(i);
    for (std::size_t k = 0; k < row.size(); ++k) {
        const std::int32_t j = row[k];
        if (k > 0 && row[k - 1] >= j) return text("row ", i, " does not ascend: ", text_row(row));
        if (j < (t.lists_walls() ? -6 : 0)) return text("row ", i, " holds ", j);
        if (j < 0) continue;
        if (static_cast<std::size_t>(j) >= t.size() || static_cast<std::size_t>(j) == i || is_duplicate(t, j))
            return text("row ", i, " holds ", j);
        const auto back = t.neighbors(static_cast<std::size_t>(j));
        if (!std::binary_search(back.begin(), back.end(), static_cast<std::int32_t>(i)))
            return text(i, " lists ", j, " but ", j, " does not list ", i);
    }
    return "";
}

std::string check_cell(const votess::Tessellation& t, std::size_t i, bool may_underflow) {
    if (!t.volumes().empty() && !(t.volumes()[i] > 0 || (may_underflow && t.volumes()[i] == 0)))
        return text("cell ", i, " has volume ", t.volumes()[i]);
    if (!t.centroids().empty())
        for (std::size_t a = 0; a < 3; ++a) {
            const double c = t.centroids()[3 * i + a];
            if (!(c >= t.box().lower[a] && c <= t.box().upper[a])) return text("centroid ", i, " is outside: ", c);
        }
    if (!t.face_counts().empty()) {
        const std::int64_t f = t.face_counts()[i], e = t.edge_counts()[i], v = t.vertex_counts()[i];
        if (v - e + f != 2 || f < 4 || 2 * e < 3 * v)
            return text("cell ", i, " has ", v, " vertices, ", e, " edges, ", f, " faces");
        if (t.lists_walls() && t.indptr().size() > 1 && static_cast<std::size_t>(f) != t.neighbors(i).size())
            return text("cell ", i, " counts ", f, " faces and lists ", t.neighbors(i).size());
    }
    return "";
}

std::string check_volume_sum(const votess::Tessellation& t) {
    if (t.volumes().empty()) return "";
    double box = 1, sum = 0;
    for (std::size_t a = 0; a < 3; ++a) box *= t.box().upper[a] - t.box().lower[a];
    for (const double v : t.volumes()) sum += v;
    // Subnormal volumes are rounded to a multiple of the least double.
    const double rounding = static_cast<double>(t.size() + 1) * std::numeric_limits<double>::denorm_min();
    if (!(std::abs(sum - box) <= 1e-9 * box + rounding)) return text("volumes sum to ", sum, " in a box of ", box);
    if (!(std::abs(t.stats().volume_sum - box) <= 1e-9 * box + rounding))
        return text("stats.volume_sum ", t.stats().volume_sum);
    if (!(std::abs(t.stats().box_volume - box) <= 1e-14 * box)) return text("stats.box_volume ", t.stats().box_volume);
    return "";
}

}  // namespace

bool reduced() {
    const char* value = std::getenv("VOTESS_TEST_REDUCED");
    return value != nullptr && *value != '\0' && std::string_view(value) != "0";
}

std::size_t by_size(std::size_t full, std::size_t when_reduced) {
    return reduced() ? when_reduced : full;
}

votess::Options all_options(const std::optional<votess::Box>& box) {
    votess::Options options;
    options.device = "cpu";
    options.box = box;
    options.list_walls = true;
    options.want = {true, true, true, true, true};
    options.threads = 1;
    return options;
}

votess::Tessellation run(const PointSet& set) {
    return votess::tessellate(set.points, all_options(set.box));
}

votess::Tessellation run(const PointSet& set, votess::Options options) {
    options.box = set.box;
    return votess::tessellate(set.points, options);
}

std::vector<std::int32_t> row_of(const votess::Tessellation& t, std::size_t i) {
    const auto row = t.neighbors(i);
    return {row.begin(), row.end()};
}

Rows rows_of(const votess::Tessellation& t) {
    Rows rows;
    for (std::size_t i = 0; i < t.size(); ++i) rows.push_back(row_of(t, i));
    return rows;
}

std::string check_invariants(const votess::Tessellation& t, std::span<const double> points, bool may_underflow) {
    const std::size_t n = points.size() / 3;
    if (t.size() != n || t.status().size() != n) return text("size ", t.size(), " instead of ", n);
    const bool rows = !t.indptr().empty();
    if (rows) {
        if (t.indptr().size() != n + 1 || t.indptr()[0] != 0) return "indptr has a wrong size or start";
        if (!std::is_sorted(t.indptr().begin(), t.indptr().end())) return "indptr does not ascend";
        if (static_cast<std::size_t>(t.indptr()[n]) != t.indices().size())
            return "indptr does not end at indices.size()";
        if (!t.face_areas().empty() && t.face_areas().size() != t.indices().size())
            return "face_areas has a wrong size";
        for (const double area : t.face_areas())
            if (!(area >= 0)) return text("a face has area ", area);
    }
    std::uint64_t faces = 0, duplicates = 0;
    for (std::size_t i = 0; i < n; ++i) {
        std::string wrong;
        if (is_duplicate(t, i)) {
            ++duplicates;
            wrong = check_duplicate_cell(t, points, i);
        } else if (t.status()[i] != votess::CellStatus::certified) {
            wrong = text("cell ", i, " has status ", static_cast<int>(t.status()[i]));
        } else {
            if (!t.duplicate_of().empty() && t.duplicate_of()[i] != -1) wrong = text("duplicate_of[", i, "] is not -1");
            if (wrong.empty() && rows) wrong = check_row(t, i);
            if (wrong.empty()) wrong = check_cell(t, i, may_underflow);
            if (!t.face_counts().empty()) faces += t.face_counts()[i];
        }
        if (!wrong.empty()) return wrong;
    }
    if (duplicates == 0 ? !t.duplicate_of().empty() : t.duplicate_of().size() != n)
        return "duplicate_of has a wrong size";
    if (t.stats().points != n) return text("stats.points ", t.stats().points);
    if (t.stats().duplicates != duplicates) return text("stats.duplicates ", t.stats().duplicates);
    if (t.stats().empty_cells != duplicates) return text("stats.empty_cells ", t.stats().empty_cells);
    if (!t.face_counts().empty() && t.stats().faces != faces) return text("stats.faces ", t.stats().faces);
    return n > 0 ? check_volume_sum(t) : "";
}

namespace {

// Returns the first row that differs, or a number that is not less than those of both.
std::size_t first_other_row(const votess::Tessellation& a, const votess::Tessellation& b) {
    std::size_t i = 0;
    while (i < std::min(a.size(), b.size()) && std::ranges::equal(a.neighbors(i), b.neighbors(i))) ++i;
    return i;
}

// Arrays of whole numbers, and normals.
std::string check_lists(const votess::Tessellation& a, const votess::Tessellation& b) {
    if (const auto row = first_other_row(a, b); row < std::min(a.size(), b.size()))
        return text("row ", row, ": ", text_row(a.neighbors(row)), " and ", text_row(b.neighbors(row)));
    std::string differs;
    for_common_arrays(a, b, [&](const auto& array) {
        using Element = std::remove_cvref_t<decltype(array.of(a)[0])>;
        if (std::is_floating_point_v<Element> && array.name != "face_normals") return;
        if (differs.empty() && !std::ranges::equal(array.of(a), array.of(b), same_number))
            differs = text(array.name, " differs");
    });
    return differs;
}

}  // namespace

std::string check_identical(const votess::Tessellation& a, const votess::Tessellation& b) {
    if (const std::string lists = check_lists(a, b); !lists.empty()) return lists;
    const std::string differs = different_array(a, b);
    return differs.empty() ? "" : text(differs, " differs");
}

namespace {

// Returns what follows from a result, as text: equal results give equal text.
std::string derived(const votess::Tessellation& t) {
    std::ostringstream out;
    out.precision(17);
    const auto put = [&](const auto&... lists) {
        (std::ranges::for_each(lists, [&](auto x) { out << +x << ' '; }), ...);
        out << '\n';
    };
    const auto attempt = [&](auto&& make) {
        try {
            make();
        } catch (const votess::Error& error) {
            out << error.what() << '\n';
        }
    };
    attempt([&] {
        const votess::Delaunay dual = votess::delaunay(t);
        put(dual.tetrahedra, dual.tetrahedra_shifts, dual.tetrahedra_centers, dual.polytope_indptr,
            dual.polytope_indices, dual.polytope_shifts, dual.polytope_centers);
    });
    attempt([&] {
        const votess::Pieces pieces = votess::pieces(t);
        put(pieces.volumes, pieces.vertices);
    });
    return out.str();
}

}  // namespace

std::string check_same_result(const votess::Tessellation& a, const votess::Tessellation& b) {
    if (const std::string arrays = check_identical(a, b); !arrays.empty()) return arrays;
    if (a.box().lower != b.box().lower || a.box().upper != b.box().upper) return "boxes differ";
    if (a.periodic() != b.periodic()) return "periodic axes differ";
    if (a.cell().has_value() != b.cell().has_value()) return "one has a cell";
    if (a.cell() && (a.cell()->origin != b.cell()->origin || a.cell()->a != b.cell()->a || a.cell()->b != b.cell()->b ||
                     a.cell()->c != b.cell()->c || a.cell()->periodic != b.cell()->periodic))
        return "cells differ";
    if (!std::ranges::equal(a.walls(), b.walls(), [](const votess::Wall& v, const votess::Wall& w) {
            return v.normal == w.normal && v.offset == w.offset;
        }))
        return "walls differ";
    if (a.planar() != b.planar() || a.lists_walls() != b.lists_walls() || a.probed() != b.probed() ||
        a.in_mesh() != b.in_mesh() || a.is_subset() != b.is_subset() || a.least_face() != b.least_face())
        return "attributes differ";
    const votess::Stats &s = a.stats(), &t = b.stats();
    if (s.device != t.device || s.points != t.points || s.faces != t.faces || s.mean_faces != t.mean_faces ||
        s.volume_sum != t.volume_sum || s.box_volume != t.box_volume || s.duplicates != t.duplicates ||
        s.empty_cells != t.empty_cells || s.exact_cells != t.exact_cells || s.tiny_faces != t.tiny_faces ||
        s.threads != t.threads || s.precision != t.precision)
        return "stats differ";
    const std::string of_a = derived(a), of_b = derived(b);
    return of_a == of_b ? "" : text("the dual or the pieces differ: ", of_a, "and ", of_b);
}

std::string check_same_cells(const votess::Tessellation& a, const votess::Tessellation& b) {
    if (const std::string lists = check_lists(a, b); !lists.empty()) return lists;
    if (a.volumes().size() != b.volumes().size() || a.face_areas().size() != b.face_areas().size() ||
        a.centroids().size() != b.centroids().size())
        return "arrays differ in size";
    const auto differ = [](double x, double y, double tolerance) {
        return x != y && !(std::isnan(x) && std::isnan(y)) && !(std::abs(x - y) <= tolerance);
    };
    for (std::size_t i = 0; i < a.volumes().size(); ++i)
        if (differ(a.volumes()[i], b.volumes()[i], 2e-10 * a.volumes()[i] + 64 * 0x1p-1074))
            return text("volume ", i, ": ", a.volumes()[i], " and ", b.volumes()[i]);
    double longest = 0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, a.box().upper[k] - a.box().lower[k]);
    for (std::size_t i = 0; i < a.centroids().size(); ++i)
        if (differ(a.centroids()[i], b.centroids()[i], 1e-9 * longest + 1e-15 * std::abs(a.centroids()[i])))
            return text("centroid ", i / 3, ": ", a.centroids()[i], " and ", b.centroids()[i]);
    for (std::size_t i = 0; i < a.size() && !a.face_areas().empty(); ++i) {
        const auto begin = static_cast<std::size_t>(a.indptr()[i]), end = static_cast<std::size_t>(a.indptr()[i + 1]);
        double surface = 0;
        for (std::size_t f = begin; f < end; ++f) surface += a.face_areas()[f];
        for (std::size_t f = begin; f < end; ++f)
            if (differ(a.face_areas()[f], b.face_areas()[f], 2e-10 * surface))
                return text("face area ", f, " of cell ", i, ": ", a.face_areas()[f], " and ", b.face_areas()[f]);
    }
    return "";
}

std::string check_exact(const votess::Tessellation& t, std::span<const double> points) {
    const std::string wrong = check_certificate(t, points, all_options(t.box()));
    return wrong.empty() ? check_invariants(t, points, true) : wrong;
}

std::string check_right(const Coordinates& points, const votess::Options& options) {
    const auto t = votess::tessellate(points, options);
    if (const std::string wrong = check_domain(t); !wrong.empty()) return wrong;
    if (const std::string wrong = votess::verify(t, points).failure; !wrong.empty()) return wrong;
    return check_certificate(t, points, options);
}

std::string refusal(const Coordinates& points, const votess::Options& options, votess::ErrorCode code) {
    std::string message;
    const auto found = error_of([&] { (void)votess::tessellate(points, options); }, &message);
    if (found && found != code) return "another code than the test expects";
    return has(message, "\n") ? "several lines" : message;
}

}  // namespace test

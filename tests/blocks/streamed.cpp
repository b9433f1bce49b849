#include "blocks/streamed.hpp"

#include <algorithm>
#include <cstring>

namespace test {
namespace {

using namespace votess;

template <class To, class From>
void add(std::vector<To>& to, From from) {
    to.insert(to.end(), from.begin(), from.end());
}

template <class Found, class Wanted>
bool same(const std::vector<Found>& found, Wanted wanted) {
    return std::equal(found.begin(), found.end(), wanted.begin(), wanted.end());
}

bool same_bits(const std::vector<double>& found, std::span<const double> wanted) {
    return found.size() == wanted.size() &&
           (wanted.empty() || std::memcmp(found.data(), wanted.data(), wanted.size_bytes()) == 0);
}

}  // namespace

bool Pieces::restart() {
    at_ = 0;
    return !once_;
}

bool Pieces::next(StreamSeeds& seeds) {
    const std::size_t count = std::min(piece_, points_.size() / dimensions_ - at_);
    if (count == 0) return false;
    seeds.points = points_.subspan(dimensions_ * at_, dimensions_ * count);
    if (!weights_.empty()) seeds.weights = weights_.subspan(at_, count);
    if (!radii_.empty()) seeds.radii = radii_.subspan(at_, count);
    at_ += count;
    return true;
}

void StreamedRows::rows(const StreamRows& some) {
    if (some.first != cells.status.size()) wrong = "a piece begins with seed " + std::to_string(some.first);
    ++pieces;
    if (!some.indptr.empty()) {
        if (some.indptr.size() != some.status.size() + 1) wrong = "an indptr has another length";
        if (some.indptr[0] != static_cast<std::int64_t>(cells.indices.size())) wrong = "an indptr does not go on";
        add(cells.indptr, some.indptr.subspan(cells.indptr.empty() ? 0 : 1));
    }
    add(cells.status, some.status);
    add(cells.duplicate_of, some.duplicate_of);
    add(cells.indices, some.indices);
    add(cells.shifts, some.shifts);
    add(cells.face_areas, some.face_areas);
    add(cells.face_normals, some.face_normals);
    add(cells.volumes, some.volumes);
    add(cells.centroids, some.centroids);
    add(cells.surface_areas, some.surface_areas);
    add(cells.security_radii, some.security_radii);
    add(cells.face_counts, some.face_counts);
    add(cells.edge_counts, some.edge_counts);
    add(cells.vertex_counts, some.vertex_counts);
}

Streamed streamed(std::span<const double> points, const Options& options, std::uint64_t memory, std::size_t piece,
                  bool once, bool verify, bool hull) {
    Pieces pieces(points, options, piece, once);
    Options plain = options;
    plain.weights = plain.radii = {};
    Streamed found;
    found.result = tessellate_stream(pieces, found.rows, plain,
                                     {.memory = memory, .temporary = "", .verify = verify, .hull = hull});
    return found;
}

std::string difference(const Streamed& found, const Tessellation& t) {
    const BlockCells& cells = found.rows.cells;
    if (found.result.verified && !found.result.verified->passed) return found.result.verified->failure;
    if (!found.rows.wrong.empty()) return found.rows.wrong;
    if (!same(cells.status, t.status())) return "statuses differ";
    if (!same(cells.indptr, t.indptr())) return "lengths of rows differ";
    if (!same(cells.indices, t.indices())) return "neighbors differ";
    if (!same(cells.shifts, t.shifts())) return "shifts differ";
    if (!same(cells.duplicate_of, t.duplicate_of())) return "duplicates differ";
    if (!same(cells.face_counts, t.face_counts())) return "counts of faces differ";
    if (!same(cells.edge_counts, t.edge_counts())) return "counts of edges differ";
    if (!same(cells.vertex_counts, t.vertex_counts())) return "counts of vertices differ";
    if (found.rows.head.seeds != t.size() || found.rows.head.entries != t.indices().size() ||
        found.rows.head.duplicates == t.duplicate_of().empty())
        return "the head differs";
    const Stats &stats = found.result.stats, &whole = t.stats();
    if (stats.points != whole.points || stats.faces != whole.faces || stats.duplicates != whole.duplicates ||
        stats.empty_cells != whole.empty_cells || stats.mean_faces != whole.mean_faces)
        return "the statistics differ";
    if (stats.box_volume != whole.box_volume) return "the volume of the domain differs";
    if (!same_bits(cells.volumes, t.volumes())) return "volumes differ";
    if (!same_bits(cells.centroids, t.centroids())) return "centroids differ";
    if (!same_bits(cells.face_areas, t.face_areas())) return "areas differ";
    if (!same_bits(cells.face_normals, t.face_normals())) return "normals differ";
    if (!same_bits(cells.surface_areas, t.surface_areas())) return "surfaces differ";
    if (!same_bits(cells.security_radii, t.security_radii())) return "security radii differ";
    return "";
}

}  // namespace test

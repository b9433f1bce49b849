#include "blocks/streamed.hpp"

#include <algorithm>

#include "support/arrays.hpp"

namespace test {
namespace {

using namespace votess;

template <class To, class From>
void add(std::vector<To>& to, From from) {
    to.insert(to.end(), from.begin(), from.end());
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
    votess::for_row_arrays([&](const auto& array, std::size_t) { add(array.of(cells), array.of(some)); });
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
    if (const std::string array = different_array(cells, t, same_bits); !array.empty()) return array + " differs";
    if (found.rows.head.seeds != t.size() || found.rows.head.entries != t.indices().size() ||
        found.rows.head.duplicates == t.duplicate_of().empty())
        return "the head differs";
    const Stats &stats = found.result.stats, &whole = t.stats();
    if (stats.points != whole.points || stats.faces != whole.faces || stats.duplicates != whole.duplicates ||
        stats.empty_cells != whole.empty_cells || stats.mean_faces != whole.mean_faces)
        return "the statistics differ";
    if (stats.box_volume != whole.box_volume) return "the volume of the domain differs";
    return "";
}

}  // namespace test

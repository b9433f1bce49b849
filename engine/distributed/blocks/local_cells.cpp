// The cells of a block: those that were complete at once, and those that had to ask.
#include <algorithm>

#include "distributed/blocks/local_block.hpp"

namespace votess::blocks {
namespace {

// Puts the arrays of cells one after the other.
class Merger {
public:
    Merger(BlockCells& out, std::size_t cells, std::size_t entries) : out_(out), cells_(cells), entries_(entries) {
        out_.indptr.reserve(cells + 1);
        out_.indptr.push_back(0);
    }

    // Cell i of a run with these seeds.
    void add(const detail::Result& from, std::size_t i, const Seeds& seeds) {
        append(out_.status, from.status, i, 1, cells_);
        append(out_.volumes, from.volumes, i, 1, cells_);
        append(out_.centroids, from.centroids, i, 3, cells_);
        append(out_.surface_areas, from.surface_areas, i, 1, cells_);
        append(out_.security_radii, from.security_radii, i, 1, cells_);
        append(out_.face_counts, from.face_counts, i, 1, cells_);
        append(out_.edge_counts, from.edge_counts, i, 1, cells_);
        append(out_.vertex_counts, from.vertex_counts, i, 1, cells_);
        for (auto e = static_cast<std::size_t>(from.indptr[i]); e < static_cast<std::size_t>(from.indptr[i + 1]); ++e) {
            const std::int32_t index = from.indices[e];
            const auto seed = static_cast<std::size_t>(index);
            out_.neighbors.push_back(index < 0 ? index : seeds.ids[seed]);
            out_.tags.push_back(index < 0 ? -1 : seeds.tags[seed]);
            append(out_.shifts, from.shifts, e, 3, entries_);
            append(out_.areas, from.face_areas, e, 1, entries_);
            append(out_.normals, from.face_normals, e, 3, entries_);
        }
        out_.indptr.push_back(static_cast<std::int64_t>(out_.neighbors.size()));
    }

private:
    template <class T>
    static void append(std::vector<T>& to, const Buffer<T>& from, std::size_t i, std::size_t each, std::size_t count) {
        if (from.size() == 0) return;
        if (to.empty()) to.reserve(each * count);
        for (std::size_t k = each * i; k < each * (i + 1); ++k) to.push_back(from[k]);
    }

    BlockCells& out_;
    std::size_t cells_, entries_;
};

}  // namespace

Asked LocalBlock::asked() const {
    Asked asked;
    for (const std::uint32_t cell : asked_) asked.cells.add(all_.seeds, cell);
    for (const std::int32_t i : friends_) asked.friends.add(all_.seeds, static_cast<std::size_t>(i));
    asked.friends = asked.friends.sorted();
    asked.faces = asked_faces_;
    return asked;
}

// The neighbors of the cells that had to ask are among those that they had and those that they got.
void finish_asked(const Options& options, const Asked& asked, const Seeds& answers, Run& run) {
    if (asked.cells.size() == 0) return;
    run.seeds = asked.cells;
    Seeds others = asked.friends;
    others.add(answers);
    others = others.sorted();
    for (std::size_t i = 0; i < others.size(); ++i)
        if (!std::ranges::binary_search(asked.cells.ids, others.ids[i])) run.seeds.add(others, i);
    run.clip(options, asked.cells.size());
}

BlockCells LocalBlock::finish(const Seeds& answers) {
    counts_.given += answers.size();
    Run asked_run;
    finish_asked(options_, asked(), answers, asked_run);
    counts_.exact_cells = all_.result.stats.exact_cells + asked_run.result.stats.exact_cells;

    BlockCells cells;
    const std::size_t entries = all_.result.indices.size() + asked_run.result.indices.size();
    cells.neighbors.reserve(entries);
    cells.tags.reserve(entries);
    Merger merger(cells, count_, entries);
    const std::span own_ids = std::span(all_.seeds.ids).first(count_);
    std::vector<std::int64_t> others_met;
    const auto add = [&](const Run& from, std::size_t i, std::size_t first_other) {
        merger.add(from.result, i, from.seeds);
        for (auto e = from.result.indptr[i]; e < from.result.indptr[i + 1]; ++e) {
            const std::int32_t index = from.result.indices[static_cast<std::size_t>(e)];
            if (index < 0 || static_cast<std::size_t>(index) < first_other) continue;
            const std::int64_t id = from.seeds.ids[static_cast<std::size_t>(index)];
            if (!std::ranges::binary_search(own_ids, id)) others_met.push_back(id);
        }
    };
    for (std::size_t i = 0, asked = 0; i < count_; ++i) {
        if (asked < asked_.size() && asked_[asked] == i)
            add(asked_run, asked++, asked_.size());
        else
            add(all_, i, count_);
    }
    std::ranges::sort(others_met);
    const auto [end, last] = std::ranges::unique(others_met);
    counts_.needed = static_cast<std::uint64_t>(end - others_met.begin());
    for (const std::int32_t of : all_.result.duplicate_of)
        cells.duplicate_of.push_back(of < 0 ? -1 : all_.seeds.ids[static_cast<std::size_t>(of)]);
    return cells;
}

}  // namespace votess::blocks

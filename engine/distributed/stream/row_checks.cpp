#include "distributed/stream/row_checks.hpp"

#include <algorithm>

#include "core/process.hpp"
#include "verify/brute_force.hpp"
#include "verify/invariants.hpp"
#include "verify/verify_sample.hpp"

namespace votess::stream {
namespace {

std::uint64_t mixed(std::uint64_t x) {
    return SampleRandom{x}.next();
}

// The entry (i, j, shift) adds a random number H(i, j, shift), and the one that answers it, (j, i, -shift), subtracts
// the same, whichever comes first. So the sum is 0 in the end, and with a fault it is so by chance only: for two
// sums of 64 bits with a probability of about 2^-128.
void add_pair(std::array<std::uint64_t, 2>& sums, std::int64_t i, const ToldFace& face) {
    std::int64_t j = face.id;
    std::array<std::int8_t, 3> shift = face.shift, back{};
    for (std::size_t k = 0; k < 3; ++k) back[k] = static_cast<std::int8_t>(-shift[k]);
    const bool adds = i != j ? i < j : back < shift;
    if (!adds) {
        std::swap(i, j);
        shift = back;
    }
    std::uint64_t packed = 0;
    for (const std::int8_t s : shift) packed = packed << 8 | static_cast<std::uint8_t>(s);
    constexpr std::array<std::uint64_t, 2> starts{0x243f6a8885a308d3, 0x13198a2e03707344};  // digits of pi
    for (std::size_t s = 0; s < sums.size(); ++s) {
        std::uint64_t h = mixed(starts[s] + static_cast<std::uint64_t>(i));
        h = mixed(h + static_cast<std::uint64_t>(j));
        h = mixed(h + packed);
        sums[s] += adds ? h : -h;
    }
}

std::size_t begin_of(const StreamRows& rows, std::size_t k) {
    return static_cast<std::size_t>(rows.indptr[k] - rows.indptr[0]);
}

ToldFace face_at(const StreamRows& rows, std::size_t entry) {
    ToldFace face{rows.neighbors[entry], {}, rows.areas.empty() ? 0 : rows.areas[entry]};
    if (!rows.shifts.empty()) std::copy_n(&rows.shifts[3 * entry], 3, face.shift.begin());
    return face;
}

}  // namespace

std::size_t sample_size(std::uint64_t seeds, std::size_t blocks, bool periodic, std::uint64_t memory) {
    // Distance tests of a cell: of the seeds of all blocks, and what each block does besides.
    const double work = static_cast<double>(seeds) * (periodic ? 62 : 2) + 2e4 * static_cast<double>(blocks);
    constexpr double bytes_of_answer = 2000;
    const double room = 0.1 * static_cast<double>(memory) / (bytes_of_answer * static_cast<double>(blocks + 1));
    return std::max(min_sample, static_cast<std::size_t>(std::min(sample_budget / work, room)));
}

void RowChecks::take(const StreamRows& rows) {
    for (std::size_t k = 0; k < rows.status.size(); ++k) {
        certified_ |= rows.status[k] == CellStatus::certified;
        if (layout_.rows()) take_row(rows, k);
        if (!rows.face_counts.empty() && rows.status[k] == CellStatus::certified && wrong_count_.empty())
            wrong_count_ = check_euler_formula(static_cast<std::int64_t>(rows.first + k), rows.vertex_counts[k],
                                               rows.edge_counts[k], rows.face_counts[k]);
    }
}

void RowChecks::take_row(const StreamRows& rows, std::size_t k) {
    const auto id = static_cast<std::int64_t>(rows.first + k);
    ToldFace last;
    for (std::size_t entry = begin_of(rows, k); entry < begin_of(rows, k + 1); ++entry) {
        const ToldFace face = face_at(rows, entry);
        if (entry > begin_of(rows, k) && !(last < face) && wrong_row_.empty()) wrong_row_ = not_ascending(id, face.id);
        if (face.id >= 0) add_pair(pairs_, id, face);
        last = face;
    }
    if (takes_part(rows.status[k])) keep(rows, k);
}

// The cells with the least random keys are a sample that does not depend on how rows come.
void RowChecks::keep(const StreamRows& rows, std::size_t k) {
    const std::uint64_t key = mixed(rows.first + k);
    if (kept_.size() == sample_) {
        if (sample_ == 0 || key >= kept_.front().key) return;
        std::ranges::pop_heap(kept_, before);
        kept_.pop_back();
    }
    Kept cell{key, static_cast<std::int64_t>(rows.first + k), rows.status[k], 0, {}};
    if (!rows.volumes.empty()) cell.volume = rows.volumes[k];
    for (std::size_t entry = begin_of(rows, k); entry < begin_of(rows, k + 1); ++entry)
        cell.row.push_back(face_at(rows, entry));
    kept_.push_back(std::move(cell));
    std::ranges::push_heap(kept_, before);
}

VerifyReport RowChecks::report(const Stats& stats, const BlockDomain& domain, std::size_t blocks,
                               const std::function<BlockSeeds(std::size_t)>& block) {
    VerifyReport report;
    const auto check = [&](const char* name, bool possible, const auto& run) {
        if (!possible && stats.points > 0)
            report.skipped.emplace_back(name);
        else if (report.failure.empty())
            report.failure = run();
    };
    check("volumes", layout_.bytes(Array::volumes) > 0,
          [&] { return check_volume_sum(stats, certified_, double_tolerance.sum); });
    check("symmetry", layout_.rows(), [&] { return check_symmetry(); });
    check("euler", layout_.bytes(Array::face_counts) > 0, [&] { return wrong_count_; });
    check("sample", layout_.rows(), [&] {
        report.sampled = kept_.size();
        return kept_.empty() ? std::string() : check_sample(domain, blocks, block);
    });
    report.passed = report.failure.empty();
    return report;
}

std::string RowChecks::check_symmetry() const {
    if (!wrong_row_.empty()) return wrong_row_;
    if (pairs_ == decltype(pairs_){}) return {};
    return "the lists of neighbors are not symmetric: some seed lists another which does not list it";
}

BlockCells RowChecks::cells_of_sample() const {
    BlockCells cells;
    cells.indptr.push_back(0);
    for (const Kept& kept : kept_) {
        cells.status.push_back(kept.status);
        if (layout_.bytes(Array::volumes) > 0) cells.volumes.push_back(kept.volume);
        for (const ToldFace& face : kept.row) {
            cells.neighbors.push_back(face.id);
            if (layout_.bytes(Array::shifts) > 0)
                cells.shifts.insert(cells.shifts.end(), face.shift.begin(), face.shift.end());
            if (layout_.bytes(Array::areas) > 0) cells.areas.push_back(face.area);
        }
        cells.indptr.push_back(static_cast<std::int64_t>(cells.neighbors.size()));
    }
    return cells;
}

// The sample is one more block for the verifier of blocks: the others say what their seeds leave of its cells. Each is
// given the seeds that its rows name as well: more seeds take no neighbor away, and cells of a block far away would be
// large without them.
std::string RowChecks::check_sample(const BlockDomain& domain, std::size_t blocks,
                                    const std::function<BlockSeeds(std::size_t)>& block) {
    std::ranges::sort(kept_, {}, &Kept::id);
    const BlockCells cells = cells_of_sample();
    std::vector<std::int64_t> named;
    for (const Kept& kept : kept_) {
        named.push_back(kept.id);
        for (const ToldFace& face : kept.row) named.push_back(face.id);
    }
    std::ranges::sort(named);
    named.erase(std::ranges::unique(named).begin(), named.end());
    blocks::Seeds around;
    for (std::size_t b = 0; b < blocks; ++b) {
        give_back_memory();
        const BlockSeeds own = block(b);
        for (std::size_t i = 0; i < own.seeds.size(); ++i)
            if (takes_part(own.status[i]) && std::ranges::binary_search(named, own.seeds.ids[i]))
                around.add(own.seeds, i);
    }
    around = around.sorted();
    blocks::Seeds seeds;
    for (const Kept& kept : kept_)
        seeds.add(around, static_cast<std::size_t>(std::ranges::lower_bound(around.ids, kept.id) - around.ids.begin()));

    const std::vector<std::int32_t> holders(cells.neighbors.size());
    BlockVerifier verifier(domain, seeds.ids, seeds.points, seeds.weights, cells, holders);
    std::vector<std::size_t> all(verifier.candidates());
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
    const Message asked = verifier.seeds(all);
    std::vector<Message> faces;
    for (std::size_t b = 0; b < blocks; ++b) {
        give_back_memory();
        BlockSeeds own = block(b);
        const std::size_t count = own.seeds.size();
        for (std::size_t i = 0; i < around.size(); ++i)
            if (!std::ranges::binary_search(own.seeds.ids.begin(),
                                            own.seeds.ids.begin() + static_cast<std::ptrdiff_t>(count), around.ids[i]))
                own.seeds.add(around, i);
        BlockCells none;
        none.status = std::move(own.status);
        none.status.resize(own.seeds.size(), CellStatus::certified);
        none.indptr.assign(own.seeds.size() + 1, 0);
        faces.push_back(
            BlockVerifier(domain, own.seeds.ids, own.seeds.points, own.seeds.weights, none, {}).faces_of(asked));
    }
    return verifier.check_cells(all, faces);
}

}  // namespace votess::stream

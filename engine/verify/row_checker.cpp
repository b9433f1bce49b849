#include "verify/row_checker.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/scrambled.hpp"
#include "core/text.hpp"
#include "core/thread_pool.hpp"
#include "core/vector3.hpp"

namespace votess {
namespace {

constexpr std::size_t rows_of_piece = 1024;             // that one thread takes at once
constexpr std::size_t max_open = std::size_t{1} << 17;  // seeds without a cell that all blocks try to exclude

// An entry of a row: seed i lists j.
struct Entry {
    std::int64_t i = 0, j = 0;
    std::array<std::int8_t, 4> shift{};  // of j, in the first three
    std::int32_t tag_i = 0, tag_j = 0;

    // The entry of row j for the same face.
    [[nodiscard]] Entry counterpart() const {
        Entry other{j, i, {}, tag_j, tag_i};
        for (std::size_t k = 0; k < 3; ++k) other.shift[k] = static_cast<std::int8_t>(-shift[k]);
        return other;
    }
    [[nodiscard]] bool operator<(const Entry& other) const {
        return std::tie(i, j, shift) < std::tie(other.i, other.j, other.shift);
    }
};

using PairSums = std::array<std::uint64_t, 2>;

// Returns the first random numbers of pairs whose lower seed this is.
PairSums random_of_row(std::int64_t id) {
    constexpr PairSums starts{0x243f6a8885a308d3, 0x13198a2e03707344};  // digits of pi
    return {scrambled(starts[0] + static_cast<std::uint64_t>(id)),
            scrambled(starts[1] + static_cast<std::uint64_t>(id))};
}

// An entry adds a random number that depends on the pair, the shift and the tags. Its counterpart subtracts the same.
// So the sums are 0, and with a fault they are 0 with a probability of about 2^-128. of_row: of seed i.
void add(PairSums& sums, const Entry& entry, const PairSums& of_row) {
    const Entry other = entry.counterpart();
    const bool adds = entry.i != entry.j ? entry.i < entry.j : entry.shift < other.shift;
    const Entry& first = adds ? entry : other;
    std::uint64_t shift = 0;
    for (const std::int8_t s : first.shift) shift = shift << 8 | static_cast<std::uint8_t>(s);
    const std::uint64_t tags = static_cast<std::uint64_t>(first.tag_i) << 32 | static_cast<std::uint32_t>(first.tag_j);
    const PairSums of_first = first.i == entry.i ? of_row : random_of_row(first.i);
    for (std::size_t s = 0; s < sums.size(); ++s) {
        std::uint64_t h = scrambled(of_first[s] + static_cast<std::uint64_t>(first.j));
        if ((shift | tags) != 0) h = scrambled(scrambled(h + shift) + tags);
        sums[s] += adds ? h : -h;
    }
}

// Adds a row of ascending seeds, without shifts and tags, to the same sums.
void add_plain_row(PairSums& sums, std::int64_t id, std::span<const std::int64_t> seeds, const PairSums& of_row) {
    PairSums total{};
    std::size_t k = 0;
    for (; k < seeds.size() && seeds[k] < id; ++k) {
        const PairSums of_first = random_of_row(seeds[k]);
        for (std::size_t s = 0; s < total.size(); ++s)
            total[s] -= scrambled(of_first[s] + static_cast<std::uint64_t>(id));
    }
    for (; k < seeds.size(); ++k)
        for (std::size_t s = 0; s < total.size(); ++s)
            total[s] += scrambled(of_row[s] + static_cast<std::uint64_t>(seeds[k]));
    for (std::size_t s = 0; s < sums.size(); ++s) sums[s] += total[s];
}

std::size_t dimensions_of(const CheckedRun& run) {
    return run.planar ? 2 : 3;
}

std::size_t begin_of(const StreamRows& rows, std::size_t k) {
    return static_cast<std::size_t>(rows.indptr[k] - rows.indptr[0]);
}

std::int64_t id_of(const StreamRows& rows, std::size_t k, const RowNames& names) {
    return names.ids.empty() ? static_cast<std::int64_t>(rows.first + k) : names.ids[k];
}

ReportedFace face_at(const StreamRows& rows, std::size_t entry, const CheckedRun& run) {
    ReportedFace face{rows.indices[entry], {}, rows.face_areas.empty() ? 0 : rows.face_areas[entry]};
    const std::size_t each = dimensions_of(run);
    if (!rows.shifts.empty()) std::copy_n(&rows.shifts[each * entry], each, face.shift.begin());
    return face;
}

Entry entry_of(std::int64_t id, const ReportedFace& face, std::size_t entry, const RowNames& names) {
    Entry result{id, face.id, {face.shift[0], face.shift[1], face.shift[2]}, 0, 0};
    if (!names.owners.empty()) result.tag_i = names.own_rank, result.tag_j = names.owners[entry];
    return result;
}

// Area times normal sums to 0 over a closed surface.
void check_surface(const StreamRows& rows, std::size_t k, std::int64_t id, const CheckedRun& run, Fault& fault) {
    const double tolerance = run.tolerance.sum;
    const std::size_t each = dimensions_of(run);
    std::array<double, 3> sum{};
    double surface = 0;
    for (std::size_t entry = begin_of(rows, k); entry < begin_of(rows, k + 1); ++entry) {
        surface += rows.face_areas[entry];
        for (std::size_t d = 0; d < each; ++d) sum[d] += rows.face_areas[entry] * rows.face_normals[each * entry + d];
    }
    const double open = length3(sum[0], sum[1], sum[2]);
    if (std::isfinite(surface) && !(open <= tolerance * surface + 64 * smallest_double))
        fault.note(id, [&] {
            return "cell " + std::to_string(id) + " is not closed: area times normal sums to " + number(open) +
                   ", its surface is " + number(surface);
        });
}

void check_euler(const StreamRows& rows, std::size_t k, std::int64_t id, bool planar, Fault& fault) {
    const std::int64_t vertices = rows.vertex_counts[k], edges = rows.edge_counts[k], faces = rows.face_counts[k];
    const bool holds = planar ? vertices == edges && edges == faces : vertices - edges + faces == 2;
    if (rows.status[k] == CellStatus::certified && !holds)
        fault.note(id, [&] {
            return "cell " + std::to_string(id) + " has " + std::to_string(vertices) + " vertices, " +
                   std::to_string(edges) + " edges and " + std::to_string(faces) + " faces, against Euler's formula";
        });
}

// Names the first entry that has no counterpart, or one with other tags.
Fault without_counterpart(std::vector<Entry> entries) {
    std::ranges::sort(entries, std::less<>());
    Fault fault;
    for (const Entry& entry : entries) {
        const Entry wanted = entry.counterpart();
        const auto found = std::ranges::lower_bound(entries, wanted, std::less<>());
        const bool listed = found != entries.end() && !(wanted < *found);
        if (listed && found->tag_i == wanted.tag_i) continue;
        fault.note(entry.i, [&] {
            const std::string lists = "seed " + std::to_string(entry.i) + " lists " + std::to_string(entry.j);
            return listed ? lists + ", which is not among the seeds of rank " + std::to_string(entry.tag_j)
                          : lists + ", which does not list it";
        });
    }
    return fault;
}

// Returns the values of all ranks, one rank's after the other's.
template <class T>
std::vector<T> gathered(RunBlocks& blocks, const std::vector<T>& own) {
    std::vector<T> all;
    for (const Message& message : blocks.gather_all(to_bytes(own))) append_bytes(message, all);
    return all;
}

}  // namespace

std::size_t sample_size(std::uint64_t seeds, std::size_t blocks, bool periodic) {
    const double work =
        static_cast<double>(seeds) * static_cast<double>(tests_of_seed(periodic)) + 2e4 * static_cast<double>(blocks);
    return std::max(min_sample, static_cast<std::size_t>(sample_budget / work));
}

RowChecker::RowChecker(CheckedRun run, const Sample& sample, RunBlocks& blocks)
    : run_(std::move(run)), sample_(sample), blocks_(blocks) {}

RowChecker::~RowChecker() = default;

void RowChecker::take(const StreamRows& rows, const RowNames& names) {
    const bool faces = !rows.indptr.empty(), counts = !rows.face_counts.empty();
    const bool surfaces = !rows.face_areas.empty() && !rows.face_normals.empty() && run_.settled.list_walls;
    sums_.rows |= faces;
    sums_.volumes |= !rows.volumes.empty();
    sums_.counts |= counts;
    const auto check = [&](Checks& checks, std::size_t k) {
        const std::int64_t id = id_of(rows, k, names);
        if (faces && !sample_.rows_are_proven) take_row(checks, rows, k, id, names);
        if (surfaces) check_surface(rows, k, id, run_, checks.surface);
        const bool open = run_.ends.any() && (rows.volumes.empty() || std::isinf(rows.volumes[k]));
        if (counts && !open) check_euler(rows, k, id, run_.planar, checks.euler);
    };
    const std::size_t count = rows.status.size(), pieces = (count + rows_of_piece - 1) / rows_of_piece;
    if (pieces > 1 && !pool_) pool_ = std::make_unique<ThreadPool>(run_.settled.threads);
    checks_.resize(pool_ ? pool_->size() : 1);
    const auto check_piece = [&](std::size_t piece, unsigned worker) {
        for (std::size_t k = piece * rows_of_piece; k < std::min(count, (piece + 1) * rows_of_piece); ++k)
            check(checks_[worker], k);
    };
    if (pieces > 1)
        pool_->run(pieces, check_piece);
    else if (count > 0)
        check_piece(0, 0);
    for (std::size_t k = 0; k < count; ++k) {
        sums_.certified |= rows.status[k] == CellStatus::certified;
        if (!rows.volumes.empty()) sums_.volume += rows.volumes[k];
        if (takes_part(rows.status[k])) keep(rows, k, id_of(rows, k, names));
    }
    if (faces) sums_.entries += begin_of(rows, count);
}

void RowChecker::take_row(Checks& checks, const StreamRows& rows, std::size_t k, std::int64_t id,
                          const RowNames& names) const {
    const PairSums of_row = random_of_row(id);
    if (rows.shifts.empty() && names.owners.empty() && run_.only.empty()) {
        const std::span<const std::int64_t> row =
            rows.indices.subspan(begin_of(rows, k), begin_of(rows, k + 1) - begin_of(rows, k));
        std::size_t first = 0;
        bool ascends = true;
        for (std::size_t entry = 0; entry < row.size(); ++entry) {
            first += row[entry] < 0 ? 1 : 0;
            ascends = ascends && (entry == 0 || row[entry - 1] < row[entry]);
        }
        if (ascends && std::ranges::find(row, id) == row.end())
            return add_plain_row(checks.pairs, id, row.subspan(first), of_row);
    }
    ReportedFace last;
    for (std::size_t entry = begin_of(rows, k); entry < begin_of(rows, k + 1); ++entry) {
        const ReportedFace face = face_at(rows, entry, run_);
        if (entry > begin_of(rows, k) && !(last < face))
            checks.order.note(id, [&] {
                return "the row of seed " + std::to_string(id) + " does not ascend at " + std::to_string(face.id);
            });
        last = face;
        if (run_.has_row(face.id)) add(checks.pairs, entry_of(id, face, entry, names), of_row);
    }
}

void RowChecker::keep(const StreamRows& rows, std::size_t k, std::int64_t id) {
    if (sample_.max_cells == 0 || id != sample_.cell.value_or(id)) return;
    const std::uint64_t key = scrambled(scrambled(sample_.rng_seed) + static_cast<std::uint64_t>(id));
    if (kept_.size() == sample_.max_cells) {
        if (key >= kept_.front().key) return;
        std::ranges::pop_heap(kept_, before);
        kept_.pop_back();
    }
    ReportedCell cell{id, rows.status[k] == CellStatus::empty, !rows.face_areas.empty(), {}, {}};
    if (!rows.volumes.empty()) cell.volume = rows.volumes[k];
    if (!rows.indptr.empty()) {
        cell.row.emplace();
        for (std::size_t entry = begin_of(rows, k); entry < begin_of(rows, k + 1); ++entry)
            cell.row->push_back(face_at(rows, entry, run_));
    }
    kept_.push_back({key, std::move(cell)});
    std::ranges::push_heap(kept_, before);
}

VerifyReport RowChecker::report() {
    const std::size_t ranks = combine();
    VerifyReport report;
    const auto check = [&](const char* name, bool possible, const auto& find) {
        if (run_.seeds > 0 && !possible)
            report.skipped.emplace_back(name);
        else if (report.failure.empty())
            report.failure = find();
    };
    check("volumes", sums_.volumes && run_.only.empty(), [&] { return check_volumes(); });
    check("symmetry", sums_.rows, [&] { return check_symmetry(ranks); });
    check("euler", sums_.counts, [&] { return euler_.text; });
    if (report.failure.empty()) report.failure = surface_.text;
    if (report.failure.empty()) prove(report);
    // The proof compares no numbers of the plane.
    if (!report.proven || run_.planar)
        check("sample", sums_.rows || sums_.volumes, [&] { return check_sample(report.sampled); });
    report.passed = report.failure.empty();
    report.proven &= report.passed;
    if (!report.passed) report.unproven.clear();
    return report;
}

void RowChecker::prove(VerifyReport& report) {
    report.unproven = sample_.unproven;
    if (run_.seeds > 0 && report.unproven.empty() && !sums_.rows) report.unproven = "the result has no neighbors";
    if (run_.ends.any() && report.unproven.empty()) report.unproven = "cells of a domain without end are sampled";
    if (!report.unproven.empty()) return;
    BlockProof own, all;
    blocks_.for_proofs([&](Seeds seeds, const BorderRows& border, const RunBlocks::RowsOf& rows) {
        BlockCertificate certificate(run_, std::move(seeds), border);
        rows([&](const StreamRows& some, const RowNames&) { certificate.add(some); });
        own.merge(certificate.prove());
    });
    for (const Message& message : blocks_.gather_all(message_of(own))) {
        BlockProof some;
        read_message(message, some);
        all.merge(std::move(some));
    }
    exclude_open(own.open, all);
    all.check_volume(run_.domain_volume);
    report.failure = all.fault.text;
    report.unproven = all.unsettled.text;
    report.proven = report.failure.empty() && report.unproven.empty();
}

// Seeds without a cell may be far away from the cells of their block. So cells of other blocks exclude them, or at last
// all seeds. own: the open ones of this rank.
void RowChecker::exclude_open(const Seeds& own, BlockProof& proof) {
    if (proof.open.size() == 0 || !proof.fault.text.empty() || !proof.unsettled.text.empty()) return;
    std::vector<std::int64_t> excluded;
    if (proof.open.size() <= max_open)
        blocks_.for_proofs([&](Seeds seeds, const BorderRows& border, const RunBlocks::RowsOf& rows) {
            BlockCertificate certificate(run_, std::move(seeds), border);
            rows([&](const StreamRows& some, const RowNames&) { certificate.add(some); });
            const std::vector<std::int64_t> some = certificate.find_excluded(proof.open);
            excluded.insert(excluded.end(), some.begin(), some.end());
        });
    excluded = gathered(blocks_, excluded);
    std::ranges::sort(excluded);
    std::vector<std::int64_t> left;
    for (const std::int64_t id : proof.open.ids)
        if (!std::ranges::binary_search(excluded, id)) left.push_back(id);
    if (left.empty()) return;
    if (left.size() > sample_size(run_.seeds, 1, run_.settled.region.is_periodic()))
        return proof.unsettled.note(left.front(), [&] {
            return std::to_string(left.size()) +
                   " seeds have no cell, and for so many no cells of one block were found that exclude them";
        });
    std::vector<ReportedCell> cells;
    for (const std::int64_t id : own.ids)
        if (!std::ranges::binary_search(excluded, id)) cells.push_back({id, true, false, {}, {}});
    double work = 0;
    proof.fault = try_cells(cells, own.sorted(), work);
}

std::size_t RowChecker::combine() {
    for (Checks& checks : checks_) {
        for (std::size_t s = 0; s < sums_.pairs.size(); ++s) sums_.pairs[s] += checks.pairs[s];
        order_.merge(std::move(checks.order));
        euler_.merge(std::move(checks.euler));
        surface_.merge(std::move(checks.surface));
    }
    Writer writer;
    writer.put(sums_);
    for (const Fault* fault : {&order_, &euler_, &surface_}) writer.put(*fault);
    const std::vector<Message> states = blocks_.gather_all(writer.take());
    sums_ = {};
    for (const Message& state : states) {
        Reader reader(state);
        Sums some;
        reader.get(some);
        sums_.volume += some.volume;
        sums_.entries += some.entries;
        for (std::size_t s = 0; s < sums_.pairs.size(); ++s) sums_.pairs[s] += some.pairs[s];
        sums_.certified |= some.certified;
        sums_.rows |= some.rows;
        sums_.volumes |= some.volumes;
        sums_.counts |= some.counts;
        for (Fault* fault : {&order_, &euler_, &surface_}) {
            Fault other;
            reader.get(other);
            fault->merge(std::move(other));
        }
    }
    return states.size();
}

Fault RowChecker::first_of_ranks(const Fault& own) {
    Fault first;
    for (const Message& message : blocks_.gather_all(message_of(own))) {
        Fault some;
        read_message(message, some);
        first.merge(std::move(some));
    }
    return first;
}

// Without a seed inside no cell fills the domain. Subnormal volumes are rounded to a multiple of the least double.
std::string RowChecker::check_volumes() const {
    const double expected = sums_.certified ? run_.domain_volume : 0;
    const double allowed =
        run_.tolerance.sum * run_.domain_volume + static_cast<double>(run_.seeds + 1) * smallest_double;
    if (sums_.volume == expected || std::abs(sums_.volume - expected) <= allowed) return {};
    return "volumes sum to " + number(sums_.volume) + ", the domain holds " + number(run_.domain_volume);
}

// Where sums differ, entries are read again, part by part, to name one: both sides of a pair meet on one rank.
std::string RowChecker::check_symmetry(std::size_t ranks) {
    constexpr std::uint64_t entries_at_once = std::uint64_t{1} << 22;
    if (!order_.text.empty()) return order_.text;
    if (sums_.pairs == decltype(sums_.pairs){}) return {};
    const std::uint64_t parts = 1 + sums_.entries / (entries_at_once * ranks);
    bool again = true;
    for (std::uint64_t part = 0; part < parts && again; ++part) {
        std::vector<std::vector<Entry>> to(ranks);
        std::vector<Message> messages;
        blocks_.together([&] {
            again = blocks_.for_rows([&](const StreamRows& rows, const RowNames& names) {
                for (std::size_t k = 0; k < rows.status.size(); ++k)
                    for (std::size_t entry = begin_of(rows, k); entry < begin_of(rows, k + 1); ++entry) {
                        const Entry one = entry_of(id_of(rows, k, names), face_at(rows, entry, run_), entry, names);
                        const auto [low, high] = std::minmax(one.i, one.j);
                        const std::uint64_t h =
                            scrambled(scrambled(static_cast<std::uint64_t>(low)) + static_cast<std::uint64_t>(high));
                        if (run_.has_row(one.j) && h % parts == part) to[h / parts % ranks].push_back(one);
                    }
            });
            for (const auto& entries : to) messages.push_back(to_bytes(entries));
        });
        messages = blocks_.exchange(messages);
        Fault fault;
        blocks_.together([&] {
            std::vector<Entry> entries;
            for (const Message& message : messages) append_bytes(message, entries);
            fault = without_counterpart(std::move(entries));
        });
        fault = first_of_ranks(fault);
        if (!fault.text.empty()) return fault.text;
    }
    return "the lists of neighbors are not symmetric: some seed lists another which does not list it";
}

// Returns the seeds that the sample's rows name, as far as this rank has them.
Seeds RowChecker::seeds_of_sample() {
    std::vector<std::int64_t> names;
    blocks_.together([&] {
        for (const Kept& kept : kept_) {
            names.push_back(kept.cell.id);
            if (kept.cell.row)
                for (const ReportedFace& face : *kept.cell.row) names.push_back(face.id);
        }
        std::ranges::sort(names);
        names.erase(std::ranges::unique(names).begin(), names.end());
    });
    Seeds seeds;
    blocks_.for_blocks([&](const Seeds& block) {
        blocks_.together([&] {
            for (const std::int64_t id : names)
                if (const std::size_t i = place_of(id, block.ids); i < block.size()) seeds.add(block, i);
        });
    });
    return seeds.sorted();
}

// Cells are tried in rounds, by ascending key over all ranks.
std::string RowChecker::check_sample(std::size_t& sampled) {
    std::ranges::sort(kept_, before);
    const Seeds named = seeds_of_sample();
    double work = 0;
    std::size_t next = 0, round = sample_.first_round;
    while (true) {
        const double max_work = std::ranges::max(gathered(blocks_, std::vector{work}));
        if (max_work >= sample_.budget) return {};
        if (sampled > 0) {  // as many as the rest of the budget pays for
            const double done = static_cast<double>(sampled), rest = done * (sample_.budget / max_work - 1);
            round = static_cast<std::size_t>(std::max(static_cast<double>(min_sample), std::min(rest, 8 * done)));
        }
        std::vector<std::uint64_t> keys;
        for (std::size_t k = next; k < std::min(kept_.size(), next + round); ++k) keys.push_back(kept_[k].key);
        keys = gathered(blocks_, keys);
        std::ranges::sort(keys);
        keys.resize(std::min({keys.size(), round, sample_.max_cells - sampled}));
        if (keys.empty()) return {};
        std::vector<ReportedCell> cells;
        for (; next < kept_.size() && kept_[next].key <= keys.back(); ++next)
            cells.push_back(std::move(kept_[next].cell));
        const Fault fault = try_cells(cells, named, work);
        sampled += keys.size();
        if (!fault.text.empty()) return fault.text;
    }
}

// A block gets the seeds that rows name as well: they take no neighbor away, and without them cells of distant blocks
// would be large.
Fault RowChecker::try_cells(std::span<const ReportedCell> cells, const Seeds& named, double& work) {
    Seeds seeds;
    std::vector<ReportedCell> known;
    Fault fault;
    for (const ReportedCell& cell : cells) {
        if (const std::size_t place = place_of(cell.id, named.ids); place < named.size()) {
            seeds.add(named, place);
            known.push_back(cell);
        } else {
            fault.note(cell.id, [&] {
                return "seed " + std::to_string(cell.id) + " lies outside or is a duplicate, and is not reported so";
            });
        }
    }
    const std::vector<Message> requests = blocks_.gather_all(to_message(seeds));
    std::vector<Message> replies;
    blocks_.for_blocks([&](Seeds block) {
        std::vector<Message> own;
        blocks_.together([&] {
            Seeds others;
            for (std::size_t i = 0; i < named.size(); ++i)
                if (place_of(named.ids[i], block.ids) == block.size()) others.add(named, i);
            if (others.size() > 0) {
                block.add(others);
                block = block.sorted();
            }
            own = clip_by_block(run_, block, requests, work);
        });
        for (Message& reply : blocks_.exchange(own)) replies.push_back(std::move(reply));
    });
    blocks_.together([&] { fault.merge(first_difference(run_, known, seeds, replies)); });
    return first_of_ranks(fault);
}

}  // namespace votess

// Block by block what verify() checks; see votess/blocks.hpp.
#include <algorithm>
#include <numeric>
#include <optional>
#include <string>

#include "core/bytes.hpp"
#include "input/options.hpp"
#include "verify/brute_force.hpp"
#include "verify/invariants.hpp"
#include "verify/told_cell.hpp"
#include "verify/verify_sample.hpp"
#include "votess/blocks.hpp"

namespace votess {

namespace detail {

struct BlockVerifierState {
    Options options;
    std::span<const std::int64_t> ids;
    std::vector<double> points, weights;  // copied, see input/snapshot.hpp
    const BlockCells& cells;
    std::span<const std::int32_t> holders;
    std::vector<std::size_t> order;       // rows by id, where ids do not ascend
    std::vector<std::size_t> candidates;  // rows
    std::optional<Job> job;               // the seeds, once a sample is tried
    std::optional<BruteForce> brute_force;
    cpu::Cell cell;
    cpu::CellFaces faces;

    [[nodiscard]] std::size_t begin(std::size_t row) const { return static_cast<std::size_t>(cells.indptr[row]); }
    [[nodiscard]] std::size_t end(std::size_t row) const { return static_cast<std::size_t>(cells.indptr[row + 1]); }
    [[nodiscard]] ToldFace face(std::size_t entry) const {
        ToldFace face{cells.neighbors[entry], {}, cells.areas.empty() ? 0 : cells.areas[entry]};
        if (!cells.shifts.empty()) std::copy_n(&cells.shifts[3 * entry], 3, face.shift.begin());
        return face;
    }
    [[nodiscard]] std::optional<std::size_t> row_of(std::int64_t id) const {
        std::size_t low = 0, high = ids.size();
        const auto row_at = [this](std::size_t k) { return order.empty() ? k : order[k]; };
        while (low < high) {
            const std::size_t half = (low + high) / 2;
            if (ids[row_at(half)] < id)
                low = half + 1;
            else
                high = half;
        }
        if (low == ids.size() || ids[row_at(low)] != id) return std::nullopt;
        return row_at(low);
    }
    [[nodiscard]] bool lists(std::size_t row, const ToldFace& wanted) const {
        std::size_t low = begin(row), high = end(row);
        while (low < high) {
            const std::size_t half = (low + high) / 2;
            if (face(half) < wanted)
                low = half + 1;
            else
                high = half;
        }
        return low < end(row) && !(wanted < face(low));
    }
    [[nodiscard]] ToldCell told(std::size_t row) const {
        ToldCell told{ids[row],
                      cells.status[row] == CellStatus::empty,
                      {},
                      options.list_walls,
                      !cells.areas.empty(),
                      {},
                      0,
                      double_tolerance.cell};
        if (!cells.volumes.empty()) told.volume = cells.volumes[row];
        told.row.emplace();
        for (std::size_t entry = begin(row); entry < end(row); ++entry) told.row->push_back(face(entry));
        return told;
    }
};

}  // namespace detail

namespace {

// The cell of seed `id` has a face with seed `to`: the row of `to` must say so.
struct Pair {
    std::int64_t to = 0, id = 0;
    std::array<std::int8_t, 8> shift{};  // as `to` sees it, in the first three
};

struct SomeSeeds {
    std::vector<std::int64_t> ids;
    std::vector<double> points, weights;

    void add(std::int64_t id, std::span<const double> all_points, std::span<const double> all_weights, std::size_t i) {
        ids.push_back(id);
        points.insert(points.end(), &all_points[3 * i], &all_points[3 * i] + 3);
        if (!all_weights.empty()) weights.push_back(all_weights[i]);
    }
    void put_to(blocks::Writer& writer) const {
        writer.put(ids);
        writer.put(points);
        writer.put(weights);
    }
    void get_from(blocks::Reader& reader) {
        reader.get(ids);
        reader.get(points);
        reader.get(weights);
        if (points.size() != 3 * ids.size() || (!weights.empty() && weights.size() != ids.size()))
            throw Error(ErrorCode::invalid_argument, "a message between blocks does not hold whole seeds");
    }
};

// Says of each seed that was asked about whether the seeds of the block leave it nothing, else how many have faces.
struct Answer {
    std::vector<std::uint8_t> empty;
    std::vector<std::uint64_t> counts;
    SomeSeeds seeds;
};

std::string name_of(std::int64_t id) {
    return std::to_string(id);
}

}  // namespace

BlockVerifier::BlockVerifier(const BlockDomain& domain, std::span<const std::int64_t> ids,
                             std::span<const double> points, std::span<const double> weights, const BlockCells& cells,
                             std::span<const std::int32_t> holders) {
    const std::size_t count = ids.size();
    if (points.size() != 3 * count || (!weights.empty() && weights.size() != count) || cells.status.size() != count ||
        cells.indptr.size() != count + 1 || cells.neighbors.size() != static_cast<std::size_t>(cells.indptr.back()) ||
        holders.size() != cells.neighbors.size())
        throw Error(ErrorCode::invalid_argument,
                    "ids, points, weights, cells and holders do not fit: give those of the " + std::to_string(count) +
                        " seeds, and a holder for each entry of their rows");
    state_ = std::make_unique<detail::BlockVerifierState>(detail::BlockVerifierState{domain.options(),
                                                                                     ids,
                                                                                     {points.begin(), points.end()},
                                                                                     {weights.begin(), weights.end()},
                                                                                     cells,
                                                                                     holders,
                                                                                     {},
                                                                                     {},
                                                                                     {},
                                                                                     {},
                                                                                     cpu::Cell(),
                                                                                     {}});
    if (!std::ranges::is_sorted(ids)) {
        state_->order.resize(count);
        std::iota(state_->order.begin(), state_->order.end(), std::size_t{0});
        std::ranges::sort(state_->order, {}, [&](std::size_t row) { return ids[row]; });
    }
    for (std::size_t row = 0; row < count; ++row)
        if (takes_part(cells.status[row])) state_->candidates.push_back(row);
}

BlockVerifier::BlockVerifier(BlockVerifier&&) noexcept = default;
BlockVerifier& BlockVerifier::operator=(BlockVerifier&&) noexcept = default;
BlockVerifier::~BlockVerifier() = default;

std::string BlockVerifier::check_rows() const {
    const auto& s = *state_;
    for (std::size_t row = 0; row < s.ids.size(); ++row)
        for (std::size_t entry = s.begin(row) + 1; entry < s.end(row); ++entry)
            if (!(s.face(entry - 1) < s.face(entry))) return not_ascending(s.ids[row], s.cells.neighbors[entry]);
    return {};
}

std::string BlockVerifier::check_euler() const {
    const auto& s = *state_;
    if (s.cells.face_counts.empty()) return {};
    for (std::size_t row = 0; row < s.ids.size(); ++row) {
        if (s.cells.status[row] != CellStatus::certified) continue;
        auto wrong = check_euler_formula(s.ids[row], s.cells.vertex_counts[row], s.cells.edge_counts[row],
                                         s.cells.face_counts[row]);
        if (!wrong.empty()) return wrong;
    }
    return {};
}

std::vector<Message> BlockVerifier::pairs(std::size_t blocks, std::size_t first, std::size_t last) const {
    const auto& s = *state_;
    std::vector<std::vector<Pair>> pairs(blocks);
    for (std::size_t row = first; row < last; ++row)
        for (std::size_t entry = s.begin(row); entry < s.end(row); ++entry) {
            const ToldFace face = s.face(entry);
            if (face.id < 0) continue;
            Pair pair{face.id, s.ids[row], {}};
            for (std::size_t k = 0; k < 3; ++k) pair.shift[k] = static_cast<std::int8_t>(-face.shift[k]);
            const std::int32_t holder = s.holders[entry];
            if (holder < 0 || static_cast<std::size_t>(holder) >= blocks)
                throw Error(ErrorCode::invalid_argument, "the row of seed " + name_of(pair.id) + " says that block " +
                                                             std::to_string(holder) + " has seed " + name_of(pair.to));
            pairs[static_cast<std::size_t>(holder)].push_back(pair);
        }
    std::vector<Message> messages;
    for (const auto& some : pairs) {
        blocks::Writer writer;
        if (!some.empty()) writer.put(some);
        messages.push_back(writer.take());
    }
    return messages;
}

std::string BlockVerifier::check_pairs(const Message& message) const {
    if (message.empty()) return {};
    const auto& s = *state_;
    std::vector<Pair> pairs;
    blocks::Reader reader(message);
    reader.get(pairs);
    reader.end();
    for (const Pair& pair : pairs) {
        const std::string lists = "seed " + name_of(pair.id) + " lists " + name_of(pair.to);
        const auto row = s.row_of(pair.to);
        if (!row) return lists + ", which is not among the seeds of the block that is said to have it";
        if (!s.lists(*row, {pair.id, {pair.shift[0], pair.shift[1], pair.shift[2]}, 0}))
            return lists + ", which does not list it";
    }
    return {};
}

std::size_t BlockVerifier::candidates() const noexcept {
    return state_->candidates.size();
}

Message BlockVerifier::seeds(std::span<const std::size_t> candidates) const {
    if (candidates.empty()) return {};
    const auto& s = *state_;
    SomeSeeds seeds;
    for (const std::size_t c : candidates) {
        const std::size_t row = s.candidates.at(c);
        seeds.add(s.ids[row], s.points, s.weights, row);
    }
    blocks::Writer writer;
    seeds.put_to(writer);
    return writer.take();
}

Message BlockVerifier::faces_of(const Message& message) {
    if (message.empty()) return {};
    auto& s = *state_;
    if (!s.job) {
        Options options = s.options;
        options.weights = s.weights;
        s.job = validate({s.points, {}}, options);
        s.brute_force.emplace(*s.job, s.cells.status);
    }
    SomeSeeds asked;
    blocks::Reader reader(message);
    asked.get_from(reader);
    reader.end();
    Answer answer;
    const double scale = s.job->scale;
    std::vector<std::int32_t> own;
    for (std::size_t k = 0; k < asked.ids.size(); ++k) {
        if (const auto row = s.row_of(asked.ids[k]))
            s.brute_force->clip(*row, s.cell);
        else
            s.brute_force->clip(
                {asked.points[3 * k] * scale, asked.points[3 * k + 1] * scale, asked.points[3 * k + 2] * scale},
                asked.weights.empty() ? 0 : asked.weights[k] * scale * scale, s.cell);
        own.clear();
        constexpr std::size_t min_faces = 4;  // with fewer a cell has no interior
        s.cell.canonical_faces(s.faces);
        const bool empty = s.cell.empty() || s.faces.size() < min_faces;
        if (!empty)
            for (const std::int32_t plane : s.faces.planes) {
                const std::int32_t id = s.cell.planes()[static_cast<std::size_t>(plane)].id;
                if (id >= 0 && static_cast<std::size_t>(id) < s.ids.size()) own.push_back(id);
            }
        std::ranges::sort(own);
        own.erase(std::ranges::unique(own).begin(), own.end());
        for (const std::int32_t i : own)
            answer.seeds.add(s.ids[static_cast<std::size_t>(i)], s.points, s.weights, static_cast<std::size_t>(i));
        answer.empty.push_back(empty ? 1 : 0);
        answer.counts.push_back(own.size());
    }
    blocks::Writer writer;
    writer.put(answer.empty);
    writer.put(answer.counts);
    answer.seeds.put_to(writer);
    return writer.take();
}

// Each block keeps of a cell what its seeds leave, and the faces of that are all that need be known of them.
std::string BlockVerifier::check_cells(std::span<const std::size_t> candidates, std::span<const Message> faces) {
    auto& s = *state_;
    std::vector<SomeSeeds> around(candidates.size());
    std::vector<bool> buried(candidates.size());
    for (const Message& message : faces) {
        if (message.empty()) continue;
        Answer answer;
        blocks::Reader reader(message);
        reader.get(answer.empty);
        reader.get(answer.counts);
        answer.seeds.get_from(reader);
        reader.end();
        std::size_t at = 0;
        if (answer.counts.size() != candidates.size() || answer.empty.size() != candidates.size())
            throw Error(ErrorCode::invalid_argument, "an answer is about other cells than were asked about");
        for (std::size_t k = 0; k < candidates.size(); ++k) {
            if (answer.empty[k] != 0) buried[k] = true;
            for (std::uint64_t left = answer.counts[k]; left > 0; --left, ++at)
                around[k].add(answer.seeds.ids.at(at), answer.seeds.points, answer.seeds.weights, at);
        }
    }
    for (std::size_t k = 0; k < candidates.size(); ++k) {
        const std::size_t row = s.candidates.at(candidates[k]);
        const ToldCell told = s.told(row);
        if (buried[k]) {
            if (told.empty) continue;
            return "seed " + name_of(told.id) + " is said to have a cell, trying every seed leaves none";
        }
        SomeSeeds all = around[k], sorted;
        all.add(told.id, s.points, s.weights, row);
        std::vector<std::size_t> order(all.ids.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::ranges::sort(order, {}, [&](std::size_t i) { return all.ids[i]; });
        for (const std::size_t i : order)
            if (sorted.ids.empty() || sorted.ids.back() != all.ids[i])
                sorted.add(all.ids[i], all.points, all.weights, i);
        Options options = s.options;
        options.weights = sorted.weights;
        const Job job = validate({sorted.points, {}}, options);
        const std::vector<CellStatus> status(sorted.ids.size(), CellStatus::certified);
        BruteForce brute_force(job, status);
        brute_force.clip(static_cast<std::size_t>(std::ranges::find(sorted.ids, told.id) - sorted.ids.begin()), s.cell);
        if (auto failure = difference(told, job.scale, sorted.ids, s.cell, s.faces); !failure.empty()) return failure;
    }
    return {};
}

bool BlockVerifier::has_worked_enough() const noexcept {
    return state_->brute_force && state_->brute_force->work() >= sample_budget;
}

}  // namespace votess

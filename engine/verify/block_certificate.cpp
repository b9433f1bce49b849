#include "verify/block_certificate.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "core/at.hpp"
#include "input/settle.hpp"
#include "result/arrays.hpp"
#include "result/result.hpp"
#include "verify/certificate.hpp"

namespace votess {
namespace {

using Shift8 = std::array<std::int8_t, 3>;

// Moves values to a buffer.
template <class T>
void move_to(Buffer<T>& to, std::vector<T>& from) {
    to.resize_uninitialized(from.size());
    std::ranges::copy(from, to.begin());
    from = {};
}

}  // namespace

void BorderRows::add(const BorderRows& others) {
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    seeds.add(others.seeds);
    append(cells, others.cells);
    append(sizes, others.sizes);
    append(indices, others.indices);
    append(shifts, others.shifts);
}

void BorderRows::put_to(Writer& writer) const {
    seeds.put_to(writer);
    writer.pack(cells);
    writer.pack(sizes);
    writer.pack(indices);
    writer.pack(shifts);
}

void BorderRows::get_from(Reader& reader) {
    constexpr std::uint64_t any = std::numeric_limits<std::uint64_t>::max() / 16;
    seeds.get_from(reader);
    reader.unpack(cells, seeds.size());
    reader.unpack(sizes, cells.size());
    reader.unpack(indices, any);
    reader.unpack(shifts, 3 * indices.size());
}

std::vector<BorderRows> border_rows(const Seeds& seeds, const Rows& rows, std::size_t count,
                                    std::span<const std::uint32_t> skipped, std::size_t blocks) {
    std::vector<BorderRows> to(blocks);
    std::vector<std::vector<std::uint32_t>> named(blocks);
    std::vector<std::int32_t> others;
    for (std::size_t i = 0; i < count; ++i) {
        if (std::ranges::binary_search(skipped, static_cast<std::uint32_t>(i))) continue;
        others.clear();
        for (std::size_t e = rows.begin(i); e < rows.end(i); ++e)
            if (const std::int32_t j = rows.indices[e]; j >= 0 && seeds.tags[at(j)] != seeds.tags[i])
                others.push_back(seeds.tags[at(j)]);
        std::ranges::sort(others);
        others.erase(std::ranges::unique(others).begin(), others.end());
        for (const std::int32_t block : others) {
            BorderRows& some = to[at(block)];
            some.cells.push_back(seeds.ids[i]);
            named[at(block)].push_back(static_cast<std::uint32_t>(i));
            const std::size_t before = some.indices.size();
            for (std::size_t e = rows.begin(i); e < rows.end(i); ++e) {
                const FaceLabel label = rows.label(e);
                if (label.id < 0) continue;
                some.indices.push_back(seeds.ids[at(label.id)]);
                named[at(block)].push_back(static_cast<std::uint32_t>(label.id));
                if (!rows.shifts.empty()) some.shifts.insert(some.shifts.end(), label.shift.begin(), label.shift.end());
            }
            some.sizes.push_back(static_cast<std::uint32_t>(some.indices.size() - before));
        }
    }
    for (std::size_t b = 0; b < blocks; ++b) {
        std::ranges::sort(named[b]);
        named[b].erase(std::ranges::unique(named[b]).begin(), named[b].end());
        for (const std::uint32_t i : named[b]) to[b].seeds.add(seeds, i);
        to[b].seeds.tags = {};
    }
    return to;
}

void BlockProof::merge(BlockProof other) {
    fault.merge(std::move(other.fault));
    unsettled.merge(std::move(other.unsettled));
    volume += other.volume;
    doubt += other.doubt;
    open.add(other.open);
    certified |= other.certified;
}

void BlockProof::check_volume(double domain) {
    if (!fault.text.empty() || !unsettled.text.empty()) return;
    if (!certified) return;
    switch (Certificate::cover_of(volume, doubt, domain)) {
        case Certificate::Cover::once:
            return;
        case Certificate::Cover::unknown:
            return unsettled.note(-1, [] { return std::string(Certificate::no_volume); });
        case Certificate::Cover::more:
            return fault.note(-1, [&] { return Certificate::text_of_cover(volume, domain); });
    }
}

BlockCertificate::BlockCertificate(const CheckedRun& run, Seeds own, const BorderRows& border)
    : run_(run),
      seeds_(std::move(own)),
      count_(seeds_.size()),
      index_(seeds_.ids, border.seeds.size()),
      border_(border) {
    seeds_.tags = {};
    const SeedIndex given(border.seeds.ids);
    const auto add_seed = [&](std::size_t k) {
        seeds_.add(border.seeds, k);
        if (index_.add(seeds_.size() - 1)) return true;
        seeds_.drop_last();
        return false;
    };
    for (std::size_t c = 0; c < border.cells.size(); ++c) {
        const std::int64_t id = border.cells[c];
        const std::int32_t k = given.find(id);
        if (k >= 0 && add_seed(at(k)))
            border_cells_.push_back(static_cast<std::uint32_t>(c));
        else
            proof_.unsettled.note(id, [&] { return "seed " + std::to_string(id) + " has rows in two blocks"; });
    }
    for (std::size_t k = 0; k < border.seeds.size(); ++k) add_seed(k);
    rows_.status.reserve(seeds_.size());
    rows_.indptr.reserve(seeds_.size() + 1);
    rows_.indptr.push_back(0);
}

void BlockCertificate::add_entry(std::size_t cell, std::int64_t id, std::span<const std::int8_t> shift) {
    const std::int32_t j = id < 0 ? static_cast<std::int32_t>(id) : index_.find(id);
    if (id >= 0 && j < 0)
        return proof_.unsettled.note(seeds_.ids[cell], [&] {
            return "seed " + std::to_string(seeds_.ids[cell]) + " lists " + std::to_string(id) +
                   ", whose place no block gave";
        });
    rows_.indices.push_back(j);
    if (!run_.settled.region.is_periodic()) return;
    Shift8 whole{};
    std::ranges::copy(shift, whole.begin());
    rows_.shifts.insert(rows_.shifts.end(), whole.begin(), whole.end());
}

void BlockCertificate::add(const StreamRows& rows) {
    const std::size_t each = run_.planar ? 2 : 3, first = rows_.status.size(), added = rows.status.size();
    const auto begin = rows.indptr.front();
    for (std::size_t k = 0; k < added; ++k) {
        if (run_.planar && run_.settled.list_walls && rows.status[k] == CellStatus::certified)
            for (const std::int32_t wall : {Sheet::above, Sheet::below}) add_entry(first + k, wall, {});
        for (auto e = at(rows.indptr[k] - begin); e < at(rows.indptr[k + 1] - begin); ++e)
            add_entry(first + k, rows.indices[e],
                      rows.shifts.empty() ? rows.shifts : rows.shifts.subspan(each * e, each));
        end_row();
        const std::int64_t of = rows.duplicate_of.empty() ? -1 : rows.duplicate_of[k];
        rows_.duplicate_of.push_back(of < 0 ? -1 : index_.find(of));
        if (of >= 0 && rows_.duplicate_of.back() < 0)
            proof_.fault.note(seeds_.ids[first + k], [&] {
                return "seed " + std::to_string(seeds_.ids[first + k]) + " is reported to be a duplicate of " +
                       std::to_string(of) + ", which lies elsewhere";
            });
    }
    for_row_arrays([&](const auto& array, std::size_t number) {
        constexpr std::size_t ids[] = {detail::number_of("indices"), detail::number_of("duplicate_of"),
                                       detail::number_of("shifts")};
        const bool is_status = number == detail::number_of("status");
        if (std::ranges::find(ids, number) != std::end(ids) || (run_.planar && !is_status)) return;
        auto& to = array.of(rows_);
        const auto& from = array.of(rows);
        to.insert(to.end(), from.begin(), from.end());
    });
}

// Adds the rows of the border, and empty ones of all others.
void BlockCertificate::complete() {
    const std::span<const std::int8_t> shifts = border_.shifts;
    std::vector<std::size_t> begin(border_.cells.size() + 1);
    for (std::size_t c = 0; c < border_.cells.size(); ++c) begin[c + 1] = begin[c] + border_.sizes[c];
    for (std::size_t k = 0; k < border_cells_.size(); ++k) {
        const std::size_t c = border_cells_[k];
        for (std::size_t e = begin[c]; e < begin[c + 1]; ++e)
            add_entry(count_ + k, border_.indices[e], shifts.empty() ? shifts : shifts.subspan(3 * e, 3));
        end_row();
    }
    rows_.status.resize(seeds_.size(), CellStatus::certified);
}

template <class Task>
auto BlockCertificate::with_certificate(const Task& task) {
    while (rows_.indptr.size() <= seeds_.size()) end_row();
    rows_.duplicate_of.resize(seeds_.size(), -1);
    detail::Result result;
    result.lists_walls = run_.settled.list_walls;
    result.stats.precision = Precision::double_;
    move_to(result.indptr, rows_.indptr);
    for_row_arrays([&](const auto& array, std::size_t) { move_to(array.of(result), array.of(rows_)); });
    Settled part = run_.settled;
    part.points = {seeds_.points, {}};
    part.weights = {seeds_.weights};
    const Job job = make_job(std::move(part));
    Certificate certificate(run_, job, result, {}, {count_, seeds_.ids});
    return task(certificate);
}

BlockProof BlockCertificate::prove() {
    proof_.certified = std::ranges::find(rows_.status, CellStatus::certified) != rows_.status.end();
    complete();
    if (!proof_.fault.text.empty() || !proof_.unsettled.text.empty()) return std::move(proof_);
    Certificate::Verdict verdict = with_certificate([](Certificate& certificate) { return certificate.prove(); });
    proof_.fault = std::move(verdict.fault);
    proof_.unsettled = std::move(verdict.unsettled);
    proof_.volume = verdict.volume;
    proof_.doubt = verdict.doubt;
    for (const std::int32_t i : verdict.open) proof_.open.add(seeds_, at(i));
    return std::move(proof_);
}

std::vector<std::int64_t> BlockCertificate::find_excluded(const Seeds& hidden) {
    complete();
    std::vector<std::int32_t> numbers;
    for (std::size_t k = 0; k < hidden.size(); ++k) {
        numbers.push_back(index_.find(hidden.ids[k]));
        if (numbers.back() >= 0) continue;
        numbers.back() = static_cast<std::int32_t>(seeds_.size());
        seeds_.add(hidden, k);
        rows_.status.push_back(CellStatus::empty);
    }
    std::vector<std::int64_t> excluded;
    for (const std::int32_t i :
         with_certificate([&](Certificate& certificate) { return certificate.find_excluded(numbers); }))
        excluded.push_back(seeds_.ids[at(i)]);
    return excluded;
}

}  // namespace votess

// Rows of blocks, whole and damaged, against the proof of RowChecker. The damaged rows of a run in memory go through
// it in several blocks.
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "input/settle.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "verify/row_checker.hpp"

namespace {

using test::PointSet;
using votess::CellStatus;

// The rows and seeds of a run, and the block of each seed.
struct InBlocks : votess::RunBlocks {
    votess::BlockCells cells;
    std::vector<double> points, weights;
    std::vector<std::size_t> block_of;
    std::size_t blocks = 0;

    void for_blocks(const std::function<void(votess::Seeds)>& task) override {
        for (std::size_t b = 0; b < blocks; ++b) {
            votess::Seeds seeds;
            for (const std::size_t i : members(b))
                if (votess::takes_part(cells.status[i])) add(i, seeds);
            task(seeds);
        }
    }
    void for_proofs(const Prove& prove) override {
        std::vector<votess::BorderRows> border(blocks);
        for (std::size_t b = 0; b < blocks; ++b) {
            const auto to = border_of(b);
            for (std::size_t k = 0; k < blocks; ++k) {
                votess::BorderRows some;
                votess::read_message(votess::to_message(to[k]), some);
                border[k].add(some);
            }
        }
        for (std::size_t b = 0; b < blocks; ++b) {
            votess::Seeds own;
            for (const std::size_t i : members(b)) add(i, own);
            if (own.size() == 0) continue;
            prove(own, border[b], [&](const Visit& visit) {
                for (const std::size_t i : members(b)) visit(row_of(i), {});
            });
        }
    }

private:
    std::vector<std::size_t> members(std::size_t b) const {
        std::vector<std::size_t> members;
        for (std::size_t i = 0; i < block_of.size(); ++i)
            if (block_of[i] == b) members.push_back(i);
        return members;
    }
    void add(std::size_t i, votess::Seeds& to) const { to.add(static_cast<std::int64_t>(i), points, weights, i); }
    votess::StreamRows row_of(std::size_t i) const {
        const votess::StreamRows all = votess::rows_of(cells);
        votess::StreamRows one;
        one.first = i;
        one.indptr = all.indptr.subspan(i, 2);
        const auto begin = static_cast<std::size_t>(one.indptr[0]), end = static_cast<std::size_t>(one.indptr[1]);
        votess::for_row_arrays([&](const auto& array, std::size_t) {
            const auto& from = array.of(all);
            const bool of_cell = array.per == votess::Per::cell;
            if (!from.empty())
                array.of(one) = from.subspan(array.components * (of_cell ? i : begin),
                                             array.components * (of_cell ? 1 : end - begin));
        });
        return one;
    }
    // The rows of a block for the others. Its seeds come first.
    std::vector<votess::BorderRows> border_of(std::size_t b) const {
        std::vector<std::size_t> order = members(b);
        const std::size_t count = order.size();
        for (std::size_t i = 0; i < block_of.size(); ++i)
            if (block_of[i] != b) order.push_back(i);
        votess::Seeds seeds;
        std::vector<std::int32_t> place(order.size());
        for (std::size_t k = 0; k < order.size(); ++k) {
            add(order[k], seeds);
            seeds.tags.push_back(static_cast<std::int32_t>(block_of[order[k]]));
            place[order[k]] = static_cast<std::int32_t>(k);
        }
        std::vector<std::int64_t> indptr{0};
        std::vector<std::int32_t> indices;
        std::vector<std::int8_t> shifts;
        for (std::size_t k = 0; k < count; ++k) {
            const votess::StreamRows row = row_of(order[k]);
            for (const std::int64_t id : row.indices)
                indices.push_back(id < 0 ? -1 : place[static_cast<std::size_t>(id)]);
            shifts.insert(shifts.end(), row.shifts.begin(), row.shifts.end());
            indptr.push_back(static_cast<std::int64_t>(indices.size()));
        }
        return votess::border_rows(seeds, {indptr, indices, shifts}, count, {}, blocks);
    }
};

struct Case {
    std::string name;
    PointSet set;
    votess::Options options;
    std::vector<double> weights{};
};

InBlocks in_blocks(const Case& c, const votess::Tessellation& t, std::size_t blocks, bool scattered) {
    InBlocks run;
    const auto copy = [](auto from, auto& to) { to.assign(from.begin(), from.end()); };
    copy(t.indptr(), run.cells.indptr);
    votess::for_row_arrays([&](const auto& array, std::size_t) { copy(array.of(t), array.of(run.cells)); });
    run.points = c.set.points;
    run.weights = c.weights;
    run.blocks = blocks;
    double lower = run.points[0], upper = lower;
    for (std::size_t i = 0; i < c.set.size(); ++i) {
        lower = std::min(lower, run.points[3 * i]);
        upper = std::max(upper, run.points[3 * i]);
    }
    for (std::size_t i = 0; i < c.set.size(); ++i) {
        const double along = (run.points[3 * i] - lower) / (upper - lower);
        run.block_of.push_back(
            scattered ? i % blocks
                      : std::min(blocks - 1, static_cast<std::size_t>(along * static_cast<double>(blocks))));
    }
    return run;
}

votess::VerifyReport verified(const Case& c, const votess::Tessellation& t, InBlocks& run) {
    votess::Settled settled = votess::settle(c.options);
    settled.region.box = t.cell() ? std::nullopt : std::optional(t.box());
    settled.weights = {};
    votess::RowChecker checker({settled, c.set.size(), t.stats().box_volume}, {.unproven = ""}, run);
    checker.take(votess::rows_of(run.cells));
    return checker.report();
}

std::vector<Case> cases() {
    std::vector<Case> cases;
    const auto options_for = [](const PointSet& set) {
        votess::Options options = test::all_options(set.box);
        options.threads = 2;
        return options;
    };
    const auto add = [&](const std::string& name, const PointSet& set, const auto& change) {
        Case& c = cases.emplace_back(Case{name, set, options_for(set)});
        change(c);
    };
    const std::size_t n = test::by_size(240, 120);
    add("box", test::uniform(n, 1), [](Case&) {});
    add("without walls", test::uniform(n, 2), [](Case& c) { c.options.list_walls = false; });
    add("periodic", test::uniform(n, 3), [](Case& c) { c.options.periodic = {true, true, true}; });
    add("slab", test::uniform(n, 4), [](Case& c) { c.options.periodic = {true, false, true}; });
    add("triclinic", test::uniform(n, 5), [](Case& c) {
        c.options.box.reset();
        c.options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.2, 1}, {true, true, true}};
    });
    add("walls", test::uniform(n, 6), [](Case& c) {
        c.options.walls = test::octahedron(0.6);
        c.options.outside = votess::Outside::drop;
    });
    for (const bool periodic : {false, true})
        add("weights", test::uniform(n, 7), [&](Case& c) {
            test::Random random(8);
            for (std::size_t i = 0; i < c.set.size(); ++i) c.weights.push_back(random.uniform(0, 0.03));
            c.options.periodic = {periodic, periodic, periodic};
        });
    add("cubic", test::cubic(6), [](Case&) {});
    add("cubic, periodic", test::cubic(6), [](Case& c) { c.options.periodic = {true, true, true}; });
    add("face-centered", test::fcc(3), [](Case& c) { c.options.periodic = {true, true, true}; });
    add("duplicates", test::with_duplicates(n, 40, 9), [](Case&) {});
    add("clusters", test::clustered(n, 10), [](Case&) {});
    return cases;
}

votess::Tessellation made(const Case& c) {
    votess::Options options = c.options;
    options.weights = c.weights;
    return votess::tessellate(c.set.points, options);
}

std::size_t row_end(const votess::BlockCells& cells, std::size_t i) {
    return static_cast<std::size_t>(cells.indptr[i + 1]);
}

// Removes the entry of row i that lists j with the shift.
void erase(votess::BlockCells& cells, std::size_t i, std::int64_t j, const std::array<std::int8_t, 3>& shift) {
    for (auto e = static_cast<std::size_t>(cells.indptr[i]); e < row_end(cells, i); ++e) {
        if (cells.indices[e] != j ||
            (!cells.shifts.empty() && !std::equal(shift.begin(), shift.end(), &cells.shifts[3 * e])))
            continue;
        cells.indices.erase(cells.indices.begin() + static_cast<std::ptrdiff_t>(e));
        if (!cells.shifts.empty()) {
            const auto at = cells.shifts.begin() + static_cast<std::ptrdiff_t>(3 * e);
            cells.shifts.erase(at, at + 3);
        }
        for (std::size_t k = i + 1; k < cells.indptr.size(); ++k) --cells.indptr[k];
        return;
    }
}

// Adds one, where it belongs.
void insert(votess::BlockCells& cells, std::size_t i, std::int64_t j) {
    auto e = static_cast<std::size_t>(cells.indptr[i]);
    while (e < row_end(cells, i) && cells.indices[e] < j) ++e;
    if (e < row_end(cells, i) && cells.indices[e] == j) return;
    cells.indices.insert(cells.indices.begin() + static_cast<std::ptrdiff_t>(e), j);
    if (!cells.shifts.empty())
        cells.shifts.insert(cells.shifts.begin() + static_cast<std::ptrdiff_t>(3 * e), 3, std::int8_t{0});
    for (std::size_t k = i + 1; k < cells.indptr.size(); ++k) ++cells.indptr[k];
}

}  // namespace

TEST_CASE("blocks: all cells are proven, however the blocks are") {
    for (const Case& c : cases()) {
        const votess::Tessellation t = made(c);
        for (const std::size_t blocks : {1, 2, 5})
            for (const bool scattered : {false, true}) {
                CAPTURE(c.name);
                CAPTURE(blocks);
                CAPTURE(scattered);
                InBlocks run = in_blocks(c, t, blocks, scattered);
                const votess::VerifyReport report = verified(c, t, run);
                CHECK(report.failure == "");
                CHECK(report.unproven == "");
                CHECK(report.proven);
                CHECK(report.sampled == 0);
            }
    }
}

// Symmetry, volumes and Euler's formula hold after each damage: only the proof can notice it.
TEST_CASE("blocks: damage that is symmetric is noticed, and no harmless change is") {
    test::Random random(11);
    std::size_t noticed = 0, harmless = 0;
    for (const Case& c : cases()) {
        const votess::Tessellation t = made(c);
        CAPTURE(c.name);
        for (std::size_t trial = 0; trial < test::by_size(60, 12); ++trial) {
            InBlocks run = in_blocks(c, t, 1 + trial % 4, trial % 2 == 1);
            votess::BlockCells& cells = run.cells;
            const std::vector<std::int64_t> indptr = cells.indptr;
            const std::vector<CellStatus> status = cells.status;
            votess::BlockCells plain;
            plain.indptr = indptr;
            plain.indices = cells.indices;
            plain.shifts = cells.shifts;
            plain.status = status;
            plain.duplicate_of = cells.duplicate_of;
            cells = plain;  // no numbers, which other checks compare
            Case changed = c;
            const auto i = static_cast<std::size_t>(random.below(c.set.size()));
            const std::size_t kind = trial % 5;
            CAPTURE(kind);
            CAPTURE(i);
            std::vector<std::size_t> seeds;  // entries that list others
            for (auto e = static_cast<std::size_t>(indptr[i]); e < row_end(cells, i); ++e)
                if (cells.indices[e] >= 0 && cells.indices[e] != static_cast<std::int64_t>(i)) seeds.push_back(e);
            if (seeds.empty()) continue;
            const std::size_t entry = seeds[static_cast<std::size_t>(random.below(seeds.size()))];
            const auto j = static_cast<std::size_t>(cells.indices[entry]);
            std::array<std::int8_t, 3> shift{}, back{};
            for (std::size_t k = 0; k < 3 && !cells.shifts.empty(); ++k) {
                shift[k] = cells.shifts[3 * entry + k];
                back[k] = static_cast<std::int8_t>(-shift[k]);
            }
            const auto erase_pair = [&] {
                erase(cells, i, static_cast<std::int64_t>(j), shift);
                erase(cells, j, static_cast<std::int64_t>(i), back);
            };
            const auto insert_pair = [&] {
                std::size_t other = i;
                while (other == i || cells.status[other] != CellStatus::certified)
                    other = static_cast<std::size_t>(random.below(c.set.size()));
                insert(cells, i, static_cast<std::int64_t>(other));
                insert(cells, other, static_cast<std::int64_t>(i));
            };
            if (kind == 0) erase_pair();
            if (kind == 1) insert_pair();
            if (kind == 2) erase_pair(), insert_pair();
            if (kind == 3)
                for (std::size_t k = 0; k < 3; ++k)
                    changed.set.points[3 * i + k] +=
                        random.uniform(-1, 1) * 0.02 * (t.box().upper[0] - t.box().lower[0]);
            if (kind == 4) {
                if (changed.weights.empty()) changed.weights.assign(c.set.size(), 0);
                changed.weights[i] += 0.01 * (t.box().upper[0] - t.box().lower[0]) * random.uniform(-1, 1);
            }
            run.points = changed.set.points;
            run.weights = changed.weights;
            bool same = false;
            try {
                const votess::Tessellation right = made(changed);
                same = std::ranges::equal(right.indptr(), cells.indptr) &&
                       std::ranges::equal(right.indices(), cells.indices) &&
                       std::ranges::equal(right.shifts(), cells.shifts) &&
                       std::ranges::equal(right.status(), cells.status);
            } catch (const votess::Error&) {
                continue;  // the seed left the domain
            }
            const votess::VerifyReport report = verified(changed, t, run);
            CAPTURE(report.failure);
            CAPTURE(report.unproven);
            CHECK(report.proven == same);
            if (same) CHECK(report.passed);
            ++(same ? harmless : noticed);
        }
    }
    CHECK(noticed > test::by_size(400, 60));
    CHECK(harmless > 0);
}

TEST_CASE("blocks: a seed that names another as its duplicate, in any block, is noticed") {
    test::Random random(12);
    const Case c = cases().front();
    const votess::Tessellation t = made(c);
    for (std::size_t trial = 0; trial < test::by_size(40, 10); ++trial) {
        InBlocks run = in_blocks(c, t, 5, trial % 2 == 1);
        run.cells.duplicate_of.assign(c.set.size(), -1);
        run.cells.duplicate_of[random.below(c.set.size())] = static_cast<std::int64_t>(random.below(c.set.size()));
        CHECK_FALSE(verified(c, t, run).passed);
    }
}

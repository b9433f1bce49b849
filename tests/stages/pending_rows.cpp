// Rows between the engine and the result: as steps of 16 bits, in memory that the job has left.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/page_stock.hpp"
#include "input/settle.hpp"
#include "output/near_rows.hpp"
#include "output/result_builder.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

using votess::Buffer;
using votess::NearReader;
using votess::NearRows;
using votess::NearWriter;
using votess::PageStock;

namespace {

using Huge = Buffer<std::byte>;

// Adds a row of neighbors given by places, or by names below 0.
void add(NearWriter& writer, std::int32_t place, const std::vector<std::int32_t>& neighbors) {
    std::int16_t* const row = writer.add_row(place, neighbors.size());
    for (std::size_t j = 0; j < neighbors.size(); ++j) {
        row[j] = neighbors[j] < 0 ? NearRows::far : NearWriter::step(neighbors[j] - place);
        if (row[j] == NearRows::far) writer.add_other(neighbors[j]);
    }
}

}  // namespace

TEST_CASE("pending rows: steps near and far return the names") {
    constexpr std::int32_t places = 300000;
    std::vector<std::int32_t> input(places);
    for (std::int32_t i = 0; i < places; ++i) input[static_cast<std::size_t>(i)] = i;  // names are places
    test::Random random(7);
    const auto place = [&] { return static_cast<std::int32_t>(random.below(places)); };
    constexpr std::int32_t edge = 32767;
    NearWriter writer;
    for (int round = 0; round < 3; ++round) {
        std::vector<std::vector<std::int32_t>> rows;
        writer.clear();
        for (int k = 0; k < 2000; ++k) {
            const std::int32_t own = k % 3 == 0 ? place() : 40000 + k;
            std::vector<std::int32_t> row;
            for (std::size_t j = 0; j < 1 + random.below(40); ++j) row.push_back(place());
            for (const std::int32_t by : {-edge - 2, -edge - 1, -edge, 0, edge, edge + 1})
                if (own + by >= 0 && own + by < places) row.push_back(own + by);
            row.push_back(-1 - static_cast<std::int32_t>(random.below(9)));
            add(writer, own, row);
            rows.push_back(row);
        }
        NearReader reader(writer.rows(input.data()));
        for (const auto& row : rows) {
            std::vector<std::int32_t> names(row.size());
            reader.read(names.data(), names.size());
            REQUIRE(names == row);
        }
    }
}

TEST_CASE("pending rows: pieces and moved pages of a stock overlap nothing") {
    constexpr std::size_t size = std::size_t{41} << 20, piece = 300008;
    Huge lent(Huge::Pages::huge), fresh(Huge::Pages::huge);
    lent.resize_uninitialized(size);
    std::memset(lent.data(), 1, size);
    PageStock stock;
    stock.put(lent.memory());
    votess::Arena arena;
    arena.reset(piece, &stock);
    std::vector<std::byte*> pieces;
    for (int k = 0; k < 12; ++k) {
        pieces.push_back(arena.allocate(piece));
        CHECK(pieces.back() >= lent.data());
        CHECK(pieces.back() + piece <= lent.data() + size);
        std::memset(pieces.back(), 10 + k, piece);
    }
    arena.give_rest();
    fresh.resize_uninitialized(size);
    stock.move_to(fresh.memory(), size);
    stock.release();
    std::memset(fresh.data(), 2, size);
    const auto holds = [](const std::byte* memory, std::size_t bytes, int value) {
        return std::all_of(memory, memory + bytes, [&](std::byte b) { return b == std::byte(value); });
    };
    for (int k = 0; k < 12; ++k) CHECK(holds(pieces[static_cast<std::size_t>(k)], piece, 10 + k));
    arena.reset(piece);
    std::memset(lent.data(), 3, size);  // the owner has it again
    CHECK(holds(lent.data(), size, 3));
    CHECK(holds(fresh.data(), size, 2));
}

TEST_CASE("pending rows: arrays of rows get lent pages and hold every entry") {
    constexpr std::size_t cells = 600000, length = 15;  // indices of 34 MiB
    const auto set = test::uniform(4, 20);
    votess::Job job = votess::make_job(votess::settle({set.points, {}}, test::all_options(set.box)));
    const std::vector<double> points(3 * cells);
    job.points = {points, {}};
    job.want = {.volumes = false, .areas = true};
    job.want.neighbors = true;
    std::vector<std::int32_t> input(cells);
    for (std::size_t i = 0; i < cells; ++i)
        input[i] = static_cast<std::int32_t>(i * 7 % cells);  // 7 and cells: coprime
    const auto name = [](std::size_t cell, std::size_t j) {
        return static_cast<std::int32_t>((cell + j * j * j * 97) % cells);
    };
    const auto area = [](std::size_t cell, std::size_t j) { return static_cast<double>(cell * length + j); };
    Buffer<double> lent(Buffer<double>::Pages::huge);
    votess::ThreadPool pool(2);
    votess::ResultBuilder builder;
    for (int call = 0; call < 4; ++call) {
        const bool in_parts = call >= 2;
        job.want.areas = !in_parts;
        builder.begin(job, pool);
        CHECK(builder.has_parts() == in_parts);
        lent.resize_uninitialized(cells * 7);
        std::fill(lent.begin(), lent.end(), -1.0);
        builder.lend(lent.memory());
        constexpr std::size_t block = 5000;
        pool.run(cells / block, [&](std::size_t b, unsigned) {
            struct Part {
                NearWriter writer;
                std::vector<std::uint32_t> lengths;
                std::vector<std::int32_t> cells;
            };
            std::array<Part, votess::ResultBuilder::max_parts> parts;
            std::vector<double> areas;
            for (std::size_t place = b * block; place < (b + 1) * block; ++place) {
                const auto cell = static_cast<std::size_t>(input[place]);
                const std::size_t own = cell % 11 == 0 ? 0 : length;  // some have no row
                Part& part = parts[in_parts ? builder.part_of(cell) : 0];
                if (own > 0 || !in_parts) part.lengths.push_back(static_cast<std::uint32_t>(own));
                if (own == 0) continue;
                part.cells.push_back(input[place]);
                std::int16_t* const row = part.writer.add_row(static_cast<std::int32_t>(place), length);
                for (std::size_t j = 0; j < length; ++j) {
                    // Near along the curve: the place of j, which has another name.
                    const bool near = (cell + j) % 3 != 0;
                    const auto step = static_cast<std::int16_t>(static_cast<int>(j) - 7);
                    const auto at = static_cast<std::int64_t>(place) + step;
                    const bool exists = at >= 0 && at < static_cast<std::int64_t>(cells);
                    row[j] = near && exists ? step : NearRows::far;
                    if (row[j] == NearRows::far) part.writer.add_other(name(cell, j));
                    areas.push_back(area(cell, j));
                }
            }
            if (!in_parts)
                builder.add_rows(std::span(input).subspan(b * block, block), parts[0].lengths,
                                 parts[0].writer.rows(input.data()), {areas, {}, {}});
            for (std::size_t p = 0; p < parts.size() && in_parts; ++p)
                builder.add_rows_of_part(p, parts[p].cells, parts[p].lengths, parts[p].writer.rows(input.data()), {});
        });
        votess::detail::Result result;
        builder.finish(result, pool);
        REQUIRE(result.indptr.size() == cells + 1);
        std::size_t wrong = 0;
        for (std::size_t place = 0; place < cells; ++place) {
            const auto cell = static_cast<std::size_t>(input[place]);
            const auto begin = static_cast<std::size_t>(result.indptr[cell]);
            const std::size_t own = cell % 11 == 0 ? 0 : length;
            wrong += static_cast<std::size_t>(result.indptr[cell + 1]) - begin == own ? 0 : 1;
            for (std::size_t j = 0; j < own; ++j) {
                const auto at = static_cast<std::int64_t>(place) + static_cast<std::int64_t>(j) - 7;
                const bool near = (cell + j) % 3 != 0 && at >= 0 && at < static_cast<std::int64_t>(cells);
                const std::int32_t expected = near ? input[static_cast<std::size_t>(at)] : name(cell, j);
                wrong += result.indices[begin + j] == expected ? 0 : 1;
                wrong += in_parts || result.face_areas[begin + j] == area(cell, j) ? 0 : 1;
            }
        }
        CHECK(wrong == 0);
    }
}

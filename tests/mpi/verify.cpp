#include "mpi/verify.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <optional>
#include <votess/mpi.hpp>

#include "mpi/inputs.hpp"

namespace test {
namespace {

using votess::mpi::Cells;
using votess::mpi::Result;

// The seeds that a rank hands in, and its result.
struct Part {
    std::vector<double> points;
    std::vector<double> radii;
    Result result;
};

struct World {
    MPI_Comm comm;
    int rank = 0, size = 1;
    std::vector<std::string> wrong;
};

Part part_of(const World& world, const Input& input, Cells cells) {
    Part part;
    std::vector<std::int64_t> ids;
    for (std::size_t i = 0; i < input.size(); ++i) {
        if (static_cast<int>(i % static_cast<std::size_t>(world.size)) != world.rank) continue;
        ids.push_back(static_cast<std::int64_t>(i));
        const std::size_t each = input.dimensions();
        part.points.insert(part.points.end(), &input.points[each * i], &input.points[each * i] + each);
        if (!input.radii.empty()) part.radii.push_back(input.radii[i]);
    }
    votess::Options options = input.options;
    options.radii = part.radii;
    part.result = votess::mpi::tessellate(world.comm, part.points, ids, options, cells);
    return part;
}

votess::VerifyReport verified(const World& world, const Part& part, std::optional<std::size_t> sample) {
    votess::VerifyOptions options;
    options.sample = sample;
    const bool made = part.result.send_indptr.empty();
    return votess::mpi::verify(world.comm, part.result, made ? std::vector<double>() : part.points, options);
}

void passes(World& world, const Input& input, Cells cells) {
    const Part part = part_of(world, input, cells);
    const votess::VerifyReport report = verified(world, part, 100), proof = verified(world, part, std::nullopt);
    if (!report.passed || !report.skipped.empty() || report.sampled == 0 || report.proven)
        world.wrong.push_back("verify, " + input.name + ": '" + report.failure + "'");
    const bool endless = proof.unproven == "cells of a domain without end are sampled";
    if (!proof.passed || !proof.skipped.empty() || proof.proven == endless)
        world.wrong.push_back("verify, " + input.name + ": '" + proof.failure + "', '" + proof.unproven + "'");
}

void fails(World& world, const std::string& name, const Part& part, const std::string& words) {
    const votess::VerifyReport report = verified(world, part, part.result.counts.seeds);
    if (report.passed || report.failure.find(words) == std::string::npos)
        world.wrong.push_back("verify, " + name + ": '" + report.failure + "' instead of '" + words + "'");
    if (verified(world, part, std::nullopt).passed) world.wrong.push_back("verify, " + name + ": there is a proof");
}

void erase_entry(votess::BlockCells& cells, std::size_t row, std::size_t entry) {
    const auto erase = [&](auto& values, std::size_t each) {
        if (values.empty()) return;
        const auto at = values.begin() + static_cast<std::ptrdiff_t>(each * entry);
        values.erase(at, at + static_cast<std::ptrdiff_t>(each));
    };
    erase(cells.indices, 1);
    erase(cells.owners, 1);
    erase(cells.shifts, 3);
    erase(cells.face_areas, 1);
    erase(cells.face_normals, 3);
    for (std::size_t i = row + 1; i < cells.indptr.size(); ++i) --cells.indptr[i];
}

// The entry of this rank's first row that leads to a seed of the last rank, but not to its own seed.
std::size_t entry_to_last(const World& world, const Result& result) {
    for (auto e = static_cast<std::size_t>(result.cells.indptr[0]); e < result.cells.indices.size(); ++e)
        if (result.cells.owners[e] == world.size - 1 && result.cells.indices[e] != result.ids[0]) return e;
    return 0;
}

void erase_pair(const World& world, Result& result) {
    std::array<std::int64_t, 5> pair{};  // seed, neighbor, shift
    votess::BlockCells& cells = result.cells;
    if (world.rank == 0) {
        const std::size_t entry = entry_to_last(world, result);
        const auto row = static_cast<std::size_t>(
            std::ranges::upper_bound(cells.indptr, static_cast<std::int64_t>(entry)) - cells.indptr.begin() - 1);
        pair = {result.ids[row], cells.indices[entry], cells.shifts[3 * entry], cells.shifts[3 * entry + 1],
                cells.shifts[3 * entry + 2]};
        erase_entry(cells, row, entry);
    }
    MPI_Bcast(pair.data(), 5, MPI_INT64_T, 0, world.comm);
    if (world.rank != world.size - 1) return;
    const auto row = static_cast<std::size_t>(std::ranges::find(result.ids, pair[1]) - result.ids.begin());
    for (auto e = static_cast<std::size_t>(cells.indptr[row]); e < static_cast<std::size_t>(cells.indptr[row + 1]); ++e)
        if (cells.indices[e] == pair[0] && cells.shifts[3 * e] == -pair[2] && cells.shifts[3 * e + 1] == -pair[3] &&
            cells.shifts[3 * e + 2] == -pair[4])
            return erase_entry(cells, row, e);
}

void finds_damage(World& world) {
    Input input = input_of(uniform(300, 3), ", periodic");
    input.options.periodic = {true, true, true};
    const Part good = part_of(world, input, Cells::handed_in);
    const bool last = world.rank == world.size - 1;
    const auto damaged = [&](const std::function<void(Result&)>& damage, const std::string& name,
                             const std::string& words) {
        Part part = good;
        damage(part.result);
        fails(world, name, part, words);
    };
    damaged(
        [&](Result& r) {
            if (last) r.cells.volumes[5] *= 1.01;
        },
        "a volume", "volumes sum to ");
    damaged(
        [&](Result& r) {
            // The sum does not change.
            if (world.rank == 0) r.cells.volumes[2] += 1e-6;
            if (last) r.cells.volumes[3] -= 1e-6;
        },
        "two volumes", " has volume ");
    damaged(
        [&](Result& r) {
            if (last) std::swap(r.cells.indices[0], r.cells.indices[1]);
        },
        "the order", "does not ascend");
    damaged(
        [&](Result& r) {
            if (last) erase_entry(r.cells, 1, static_cast<std::size_t>(r.cells.indptr[1]));
        },
        "an entry", "which does not list it");
    damaged([&](Result& r) { erase_pair(world, r); }, "a pair", ", which is one of the ");
    damaged(
        [&](Result& r) {
            if (last) r.cells.shifts[2] ^= 1;
        },
        "a shift", "list");
    damaged(
        [&](Result& r) {
            if (last) ++r.cells.edge_counts[7];
        },
        "a number of edges", "against Euler's formula");
    damaged(
        [&](Result& r) {
            if (world.rank == 0) r.cells.face_areas[entry_to_last(world, r)] *= 1.001;
        },
        "an area", " has area ");
    if (world.size > 1)
        damaged(
            [&](Result& r) {
                if (last) r.cells.owners[3] = (r.cells.owners[3] + 1) % world.size;
            },
            "an owner", "which is not among the seeds");
    // A seed that another one buries has no cell, whichever rank has which.
    Input buried = input_of({"buried", {0.5, 0.5, 0.5, 0.51, 0.5, 0.5, 0.1, 0.1, 0.1, 0.9, 0.9, 0.8}, unit_box()});
    buried.radii = {0.01, 0.3, 0.05, 0.05};
    for (const Cells cells : {Cells::handed_in, Cells::made}) passes(world, buried, cells);
    Part part = part_of(world, buried, Cells::handed_in);
    for (auto& status : part.result.cells.status)
        if (status == votess::CellStatus::empty) status = votess::CellStatus::certified;
    std::ranges::fill(part.result.cells.face_counts, 2u);  // so that Euler's formula holds
    std::ranges::fill(part.result.cells.edge_counts, 0u);
    std::ranges::fill(part.result.cells.vertex_counts, 0u);
    fails(world, "a buried seed", part, "seed 0 is reported to have a cell, trying every seed leaves none");
}

}  // namespace

std::vector<std::string> check_verify(MPI_Comm comm) {
    World world{comm, 0, 1, {}};
    MPI_Comm_rank(comm, &world.rank);
    MPI_Comm_size(comm, &world.size);
    // Under sanitizers one input in four.
    const std::size_t step = std::getenv("VOTESS_TEST_REDUCED") != nullptr ? 4 : 1;
    const std::vector<Input> inputs = all_inputs();
    std::size_t number = 0;
    for (std::size_t k = 0; k < inputs.size(); k += step)
        if (inputs[k].size() > 0) passes(world, inputs[k], number++ % 3 == 0 ? Cells::made : Cells::handed_in);
    finds_damage(world);
    return world.wrong;
}

}  // namespace test

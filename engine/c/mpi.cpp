// votess/mpi.h. Options and the last error are those of libvotess.
#include <votess/mpi.h>

#include <algorithm>
#include <utility>
#include <votess/mpi.hpp>

#include "c/handles.hpp"
#include "distributed/mpi/exchange.hpp"
#include "result/arrays.hpp"

using namespace votess::c;
using votess::mpi::Result;

struct votess_mpi_result {
    Result result;
};

namespace {

static_assert(same(VOTESS_MPI_HANDED_IN, votess::mpi::Cells::handed_in));
static_assert(same(VOTESS_MPI_MADE, votess::mpi::Cells::made));

// The input of a rank. An argument that is wrong on one rank is an error on all. check(): of further arguments.
struct Input {
    template <typename Check>
    Input(MPI_Comm comm, const double* given, size_t count, const votess_options* given_options, const void* out,
          const Check& check) {
        votess::mpi::Ranks(comm).together([&] {
            require(out, "out");
            options = convert_options(given_options, count);
            points = coordinates(given, count, "points", "count", dimensions_of(options));
            check();
        });
    }
    votess::Options options;
    std::span<const double> points;
};

constexpr std::size_t first_size = offsetof(votess_mpi_counts, volume_sum) + sizeof(votess_mpi_counts::volume_sum);

}  // namespace

size_t votess_mpi_sizeof_comm(void) {
    return sizeof(MPI_Comm);
}

votess_status votess_mpi_hull_new(MPI_Comm comm, const double* points, size_t count, const votess_options* options,
                                  votess_hull** out) {
    return guarded([&] {
        if (out != nullptr) *out = nullptr;
        const Input input(comm, points, count, options, out, [] {});
        *out = new votess_hull{rows_of(votess::mpi::hull_walls(comm, input.points, input.options))};
    });
}

votess_status votess_mpi_tessellate(MPI_Comm comm, const double* points, size_t count, const int64_t* ids,
                                    const votess_options* options, int32_t cells, votess_mpi_result** out) {
    return guarded([&] {
        if (out != nullptr) *out = nullptr;
        const Input input(comm, points, count, options, out, [&] {
            if (cells != VOTESS_MPI_HANDED_IN && cells != VOTESS_MPI_MADE)
                refuse("cells is " + std::to_string(cells) + ": use one of VOTESS_MPI_*");
        });
        const std::span<const std::int64_t> numbers(ids, ids == nullptr ? 0 : count);
        *out = new votess_mpi_result{votess::mpi::tessellate(comm, input.points, numbers, input.options,
                                                             static_cast<votess::mpi::Cells>(cells))};
    });
}

void votess_mpi_free(votess_mpi_result* result) {
    delete result;
}

votess_status votess_mpi_array(const votess_mpi_result* result, const char* name, votess_array* array) {
    return expose(result, "result", name, array, [](const votess_mpi_result& of) {
        const Result& r = of.result;
        const auto& box = r.options.box;
        std::vector<NamedArray> arrays{
            named("ids", r.ids),
            named("points", r.points, dimensions_of(r.options)),
            named("indptr", r.cells.indptr),
            named("owners", r.cells.owners),
            named("send_indptr", r.send_indptr),
            named("send", r.send),
            named("receive_indptr", r.receive_indptr),
            named("receive", r.receive),
            named("box", std::span<const double>(box ? box->lower.data() : nullptr, box ? 6 : 0), 3)};
        votess::for_row_arrays([&](const auto& row, std::size_t) {
            arrays.push_back(named(row.name.data(), row.of(r.cells), components_of(row, r.options.planar)));
        });
        return arrays;
    });
}

votess_status votess_mpi_read_counts(const votess_mpi_result* result, votess_mpi_counts* out) {
    return guarded(result, "result", [&](auto& of) {
        require(out, "counts");
        const std::uint32_t size = out->struct_size;
        require_struct_size(size, first_size, "counts.struct_size", "set it to sizeof(votess_mpi_counts)");
        const votess::mpi::Counts& counts = of.result.counts;
        const votess_mpi_counts c_counts{size,         counts.rounds,     counts.seeds,      counts.largest_block,
                                         counts.given, counts.needed,     counts.tested,     counts.questions,
                                         counts.bytes, counts.box_volume, counts.volume_sum, counts.exact_cells};
        write_struct(c_counts, *out);
    });
}

votess_status votess_mpi_verify(MPI_Comm comm, const votess_mpi_result* result, const double* points, size_t count,
                                size_t sample, uint64_t rng_seed, int* passed, uint32_t* skipped, size_t* sampled,
                                char* failure, size_t failure_size, char* unproven, size_t unproven_size) {
    return guarded([&] {
        const ReportOut out{passed, nullptr, skipped, sampled, nullptr, failure, failure_size, unproven, unproven_size};
        std::span<const double> input;
        votess::mpi::Ranks(comm).together([&] {
            begin_report(out);
            require(result, "result");
            input = coordinates(points, count, "points", "count", dimensions_of(result->result.options));
        });
        write_report(votess::mpi::verify(comm, result->result, input, verify_options(sample, rng_seed)), out);
    });
}

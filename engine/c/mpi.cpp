// votess/mpi.h. Options and the last error are those of libvotess.
#include <votess/mpi.h>

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>
#include <votess/mpi.hpp>

#include "c/handles.hpp"
#include "distributed/mpi/exchange.hpp"

using namespace votess::c;
using votess::BlockCells;
using votess::mpi::Result;

struct votess_mpi_result {
    Result result;
};

namespace {

static_assert(same(VOTESS_MPI_HANDED_IN, votess::mpi::Cells::handed_in));
static_assert(same(VOTESS_MPI_MADE, votess::mpi::Cells::made));
static_assert(sizeof(votess::CellStatus) == sizeof(std::uint8_t));  // exposed as it lies in memory

constexpr std::size_t first_size = offsetof(votess_mpi_counts, volume_sum) + sizeof(votess_mpi_counts::volume_sum);

template <typename Element>
const Element* expose(const votess_mpi_result* result, std::size_t* length,
                      std::vector<Element> Result::*array) noexcept {
    if (result == nullptr) set_last_error("result is NULL");
    return expose_span<Element>(
        result == nullptr ? std::span<const Element>() : std::span<const Element>(result->result.*array), length);
}

template <typename Element, typename Holder>
requires std::is_base_of_v<Holder, BlockCells>
const Element* expose(const votess_mpi_result* result, std::size_t* length,
                      std::vector<Element> Holder::*array) noexcept {
    if (result == nullptr) set_last_error("result is NULL");
    return expose_span<Element>(
        result == nullptr ? std::span<const Element>() : std::span<const Element>(result->result.cells.*array), length);
}

}  // namespace

size_t votess_mpi_sizeof_comm(void) {
    return sizeof(MPI_Comm);
}

votess_status votess_mpi_hull_new(MPI_Comm comm, const double* points, size_t count, const votess_options* options,
                                  votess_hull** out) {
    return guarded([&] {
        if (out != nullptr) *out = nullptr;
        std::span<const double> input;
        votess::Options converted;
        votess::mpi::Ranks(comm).together([&] {
            require(out, "out");
            converted = convert_options(options, count);
            input = coordinates(points, count, "points", "count", converted.planar ? 2 : 3);
        });
        std::vector<double> rows;
        for (const votess::Wall& wall : votess::mpi::hull_walls(comm, input, converted)) {
            rows.insert(rows.end(), wall.normal.begin(), wall.normal.end());
            rows.push_back(wall.offset);
        }
        *out = new votess_hull{std::move(rows)};
    });
}

votess_status votess_mpi_tessellate(MPI_Comm comm, const double* points, size_t count, const int64_t* ids,
                                    const votess_options* options, int32_t cells, votess_mpi_result** out) {
    return guarded([&] {
        if (out != nullptr) *out = nullptr;
        // An argument that is wrong on one rank is an error on all.
        std::span<const double> input;
        votess::Options converted;
        votess::mpi::Ranks(comm).together([&] {
            require(out, "out");
            converted = convert_options(options, count);
            input = coordinates(points, count, "points", "count", converted.planar ? 2 : 3);
            if (cells != VOTESS_MPI_HANDED_IN && cells != VOTESS_MPI_MADE)
                refuse("cells is " + std::to_string(cells) + ": use one of VOTESS_MPI_*");
        });
        const std::span<const std::int64_t> numbers(ids, ids == nullptr ? 0 : count);
        *out = new votess_mpi_result{
            votess::mpi::tessellate(comm, input, numbers, converted, static_cast<votess::mpi::Cells>(cells))};
    });
}

void votess_mpi_free(votess_mpi_result* result) {
    delete result;
}

const int64_t* votess_mpi_ids(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &Result::ids);
}

const double* votess_mpi_points(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &Result::points);
}

const uint8_t* votess_mpi_status(const votess_mpi_result* result, size_t* length) {
    return reinterpret_cast<const std::uint8_t*>(expose(result, length, &BlockCells::status));
}

const int64_t* votess_mpi_duplicate_of(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::duplicate_of);
}

const int64_t* votess_mpi_indptr(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::indptr);
}

const int64_t* votess_mpi_indices(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::indices);
}

const int32_t* votess_mpi_owners(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::owners);
}

const int8_t* votess_mpi_shifts(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::shifts);
}

const double* votess_mpi_face_areas(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::face_areas);
}

const double* votess_mpi_face_normals(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::face_normals);
}

const double* votess_mpi_volumes(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::volumes);
}

const double* votess_mpi_centroids(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::centroids);
}

const double* votess_mpi_surface_areas(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::surface_areas);
}

const double* votess_mpi_security_radii(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::security_radii);
}

const uint32_t* votess_mpi_face_counts(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::face_counts);
}

const uint32_t* votess_mpi_edge_counts(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::edge_counts);
}

const uint32_t* votess_mpi_vertex_counts(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &BlockCells::vertex_counts);
}

const int64_t* votess_mpi_send_indptr(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &Result::send_indptr);
}

const int64_t* votess_mpi_send(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &Result::send);
}

const int64_t* votess_mpi_receive_indptr(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &Result::receive_indptr);
}

const int64_t* votess_mpi_receive(const votess_mpi_result* result, size_t* length) {
    return expose(result, length, &Result::receive);
}

votess_status votess_mpi_box(const votess_mpi_result* result, double lower[3], double upper[3]) {
    return guarded([&] {
        require(result, "result");
        require(lower, "lower");
        require(upper, "upper");
        const auto& box = result->result.options.box;
        if (!box) refuse("the domain is a triclinic box, which has no lower and upper corner: read the options");
        std::ranges::copy(box->lower, lower);
        std::ranges::copy(box->upper, upper);
    });
}

votess_status votess_mpi_read_counts(const votess_mpi_result* result, votess_mpi_counts* out) {
    return guarded([&] {
        require(result, "result");
        require(out, "counts");
        const std::uint32_t size = out->struct_size;
        require_struct_size(size, first_size, "counts.struct_size", "set it to sizeof(votess_mpi_counts)");
        const votess::mpi::Counts& counts = result->result.counts;
        const votess_mpi_counts c_counts{size,         counts.rounds,     counts.seeds,      counts.largest_block,
                                         counts.given, counts.needed,     counts.tested,     counts.questions,
                                         counts.bytes, counts.box_volume, counts.volume_sum, counts.exact_cells};
        std::memcpy(out, &c_counts, std::min<std::size_t>(size, sizeof c_counts));
    });
}

votess_status votess_mpi_verify(MPI_Comm comm, const votess_mpi_result* result, const double* points, size_t count,
                                size_t sample, uint64_t rng_seed, int* passed, uint32_t* skipped, size_t* sampled,
                                char* failure, size_t failure_size) {
    return guarded([&] {
        const ReportOut out{passed, skipped, sampled, failure, failure_size};
        std::span<const double> input;
        votess::mpi::Ranks(comm).together([&] {
            begin_report(out);
            require(result, "result");
            input = coordinates(points, count, "points", "count", result->result.options.planar ? 2 : 3);
        });
        write_report(votess::mpi::verify(comm, result->result, input, verify_options(sample, rng_seed)), out);
    });
}

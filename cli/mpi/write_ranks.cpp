#include "mpi/write_ranks.hpp"

#include <algorithm>
#include <cerrno>
#include <limits>

#include "mpi/shared_file.hpp"
#include "write/hdf5_share.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

// The rows of one rank as arrays of the file, in the order of result_arrays().
class RankArrays {
public:
    RankArrays(const Ranks& ranks, const InputShare& share, const votess::BlockCells& cells, const OutputData& data) {
        const std::uint64_t entries = cells.indices.size(), first_entry = ranks.sum_before(entries);
        const std::uint64_t all_entries = ranks.sum(entries);
        // The last rank also holds the end of the rows.
        const bool last = ranks.rank() + 1 == ranks.size();
        indptr_.assign(cells.indptr.begin(), cells.indptr.end() - (last ? 0 : 1));
        for (std::int64_t& at : indptr_) at += static_cast<std::int64_t>(first_entry);
        duplicate_of_ = cells.duplicate_of;
        duplicate_of_.resize(cells.status.size(), -1);

        ResultPiece piece;
        piece.size = size_of_vectors(data.tessellation);
        piece.ids = share.input.ids;
        piece.has_ids = share.has_ids;
        piece.wide = share.rows > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max());
        piece.indptr = indptr_;
        piece.wide_indices = cells.indices;
        piece.wide_duplicate_of = duplicate_of_;
        if (!piece.wide) {
            narrow_indices_.assign(cells.indices.begin(), cells.indices.end());
            narrow_duplicate_of_.assign(duplicate_of_.begin(), duplicate_of_.end());
        }
        piece.indices = narrow_indices_;
        piece.duplicate_of = narrow_duplicate_of_;
        piece.has_duplicates = ranks.any(std::ranges::any_of(duplicate_of_, [](auto of) { return of >= 0; }));
        piece.shifts = cells.shifts;
        piece.has_shifts = ranks.any(!cells.shifts.empty());
        piece.face_areas = cells.face_areas;
        piece.face_normals = cells.face_normals;
        piece.volumes = cells.volumes;
        piece.centroids = cells.centroids;
        piece.surface_areas = cells.surface_areas;
        piece.security_radii = cells.security_radii;
        piece.face_counts = cells.face_counts;
        piece.edge_counts = cells.edge_counts;
        piece.vertex_counts = cells.vertex_counts;
        piece.status = cells.status;
        for (const ResultArray& array : result_arrays(piece, data.wanted, data.carried)) {
            if (array.of_entries)
                arrays_.push_back({array, first_entry, all_entries});
            else
                arrays_.push_back({array, share.first, share.rows + (array.name == "indptr" ? 1 : 0)});
        }
    }
    RankArrays(const RankArrays&) = delete;
    RankArrays& operator=(const RankArrays&) = delete;

    [[nodiscard]] const std::vector<SharedArray>& all() const noexcept { return arrays_; }

private:
    std::vector<std::int64_t> indptr_, duplicate_of_;
    std::vector<std::int32_t> narrow_indices_, narrow_duplicate_of_;
    std::vector<SharedArray> arrays_;
};

hid_t access_by_ranks() {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    if (access < 0 || H5Pset_fapl_mpio(access, MPI_COMM_WORLD, MPI_INFO_NULL) < 0)
        throw runtime_failure("HDF5 cannot write from several ranks");
    return access;
}

}  // namespace

void write_ranks(const Ranks& ranks, const std::vector<std::string>& paths, const InputShare& share,
                 const votess::BlockCells& cells, const OutputData& data) {
    if (paths.empty()) return;
    const std::vector<Attribute> attributes = attributes_of(data.input.units, data.domain_from);
    const RankArrays arrays(ranks, share, cells, data);
    for (const std::string& path : paths) {
        SharedFile file(ranks, path);
        Hdf5Share output{file.temporary(),
                         access_by_ranks(),
                         arrays.all(),
                         data.tessellation,
                         attributes,
                         [&](const std::function<void()>& work) {
                             ranks.together([&] {
                                 errno = 0;  // HDF5 does not reset it
                                 work();
                             });
                         },
                         [&](int error) { return file.write_failure(error); }};
        write_hdf5_share(output);
        H5Pclose(output.access);
        file.publish();
    }
}

}  // namespace clvotess

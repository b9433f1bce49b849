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
        const auto is_seed = [](std::int64_t of) { return of >= 0; };
        const WholeRows whole{
            .size = size_of_vectors(data.tessellation),
            .has_ids = share.has_ids,
            .has_shifts = data.tessellation.periodic() != std::array<bool, 3>{},
            .has_duplicates = ranks.any(std::ranges::any_of(duplicate_of_, is_seed)),
            .wide = share.rows > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())};
        rows_ = votess::rows_of(cells);
        rows_.duplicate_of = duplicate_of_;
        rows_.indptr = indptr_;
        for (const ResultArray& array :
             result_arrays(rows_, std::nullopt, whole, share.input.ids, data.wanted, data.carried)) {
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
    votess::StreamRows rows_;
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

#include "mpi/write_ranks.hpp"

#include <algorithm>
#include <cerrno>
#include <limits>
#include <list>

#include "mpi/shared_file.hpp"
#include "write/hdf5_share.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

// The rows of one rank as arrays of the file: names, types and shapes are those of result_arrays().
class RankArrays {
public:
    RankArrays(const Ranks& ranks, const InputShare& share, const votess::BlockCells& cells, const OutputData& data)
        : ranks_(ranks), share_(share), cells_(cells) {
        const votess::Want& wanted = data.wanted;
        entries_ = cells.neighbors.size();
        first_entry_ = ranks.sum_before(entries_);
        all_entries_ = ranks.sum(entries_);
        if (share.has_ids) add_cells("ids", share.input.ids);
        if (wanted.neighbors) add_rows();
        if (wanted.areas) add_entries("face_areas", cells.areas);
        if (wanted.normals) add_entries("face_normals", cells.normals, 3);
        if (wanted.volumes) add_cells("volumes", cells.volumes);
        if (wanted.centroids) add_cells("centroids", cells.centroids, 3);
        if (wanted.surfaces) add_cells("surface_areas", cells.surface_areas);
        if (wanted.radii) add_cells("security_radii", cells.security_radii);
        if (wanted.counts) {
            add_cells("face_counts", cells.face_counts);
            add_cells("edge_counts", cells.edge_counts);
            add_cells("vertex_counts", cells.vertex_counts);
        }
        add_cells("status", cells.status);
        add_duplicates();
        for (const InputColumn& column : data.carried) add_cells(column.name, column.values, column.width);
    }
    RankArrays(const RankArrays&) = delete;
    RankArrays& operator=(const RankArrays&) = delete;

    [[nodiscard]] const std::vector<SharedArray>& all() const noexcept { return arrays_; }

private:
    template <class T>
    void add(std::string_view name, const std::vector<T>& values, std::size_t columns, std::uint64_t first,
             std::uint64_t rows) {
        arrays_.push_back({as_array(name, std::span<const T>(values), columns), first, rows});
    }
    template <class T>
    void add_cells(std::string_view name, const std::vector<T>& values, std::size_t columns = 1) {
        add(name, values, columns, share_.first, share_.rows);
    }
    template <class T>
    void add_entries(std::string_view name, const std::vector<T>& values, std::size_t columns = 1) {
        add(name, values, columns, first_entry_, all_entries_);
    }

    // int32 where all seeds have such numbers, as in memory.
    template <class Add>
    void add_numbers(const std::vector<std::int64_t>& numbers, const Add& add) {
        if (share_.rows > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())) return add(numbers);
        add(narrow_.emplace_back(numbers.begin(), numbers.end()));
    }

    void add_rows() {
        // The rank that has the last rows also says where they end.
        const bool last = ranks_.rank() + 1 == ranks_.size();
        indptr_.assign(cells_.indptr.begin(), cells_.indptr.end() - (last ? 0 : 1));
        for (std::int64_t& at : indptr_) at += static_cast<std::int64_t>(first_entry_);
        add("indptr", indptr_, 1, share_.first, share_.rows + 1);
        add_numbers(cells_.neighbors, [&](const auto& numbers) { add_entries("indices", numbers); });
        if (ranks_.any(!cells_.shifts.empty())) add_entries("shifts", cells_.shifts, 3);
    }

    void add_duplicates() {
        if (!ranks_.any(std::ranges::any_of(cells_.duplicate_of, [](auto of) { return of >= 0; }))) return;
        duplicate_of_ = cells_.duplicate_of;
        duplicate_of_.resize(cells_.status.size(), -1);
        add_numbers(duplicate_of_, [&](const auto& numbers) { add_cells("duplicate_of", numbers); });
    }

    const Ranks& ranks_;
    const InputShare& share_;
    const votess::BlockCells& cells_;
    std::uint64_t entries_ = 0, first_entry_ = 0, all_entries_ = 0;
    std::vector<std::int64_t> indptr_, duplicate_of_;
    std::list<std::vector<std::int32_t>> narrow_;  // where arrays stay in place
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
                                 errno = 0;  // HDF5 leaves what others left
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

// Reads an HDF5 file: datasets of numbers, and attributes of the groups of a snapshot.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <new>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "failure.hpp"
#include "files/formats/hdf5_handles.hpp"
#include "files/inflate.hpp"
#include "files/input_file.hpp"
#include "files/limits.hpp"
#include "interrupt.hpp"
#include "read/input.hpp"

namespace clvotess {

class Hdf5Dataset {
public:
    Hdf5Dataset(hid_t file, const std::string& path, std::string where)
        : where_(std::move(where)), set_(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose) {
        if (!set_.valid()) throw error("cannot be opened as a dataset" + newer_version());
        const Hdf5Handle space(H5Dget_space(set_.id()), H5Sclose);
        const int rank = space.valid() ? H5Sget_simple_extent_ndims(space.id()) : -1;
        if (rank < 0) throw error("has no readable shape");
        extent_.resize(static_cast<std::size_t>(rank));
        if (rank > 0 && H5Sget_simple_extent_dims(space.id(), extent_.data(), nullptr) != rank) {
            throw error("has no readable shape");
        }
        const Hdf5Handle type(H5Dget_type(set_.id()), H5Tclose);
        if (!type.valid()) throw error("has no readable type");
        type_class_ = H5Tget_class(type.id());
        type_size_ = H5Tget_size(type.id());
        is_unsigned_ = is_whole() && H5Tget_sign(type.id()) == H5T_SGN_NONE;
    }

    // Returns whether the shape is (frames, N, count), of floats.
    [[nodiscard]] bool has_frames(hsize_t count) const {
        return extent_.size() == 3 && extent_[2] == count && is_float();
    }
    // Reads one frame from now on: the first dimension counts frames.
    void choose_frame(std::uint64_t frame) {
        frame_ = frame;
        frames_ = extent_.front();
        extent_.erase(extent_.begin());
    }
    // Returns whether the dataset has a row of numbers for each of `rows` points in each of `frames` frames.
    [[nodiscard]] bool is_column_of(std::uint64_t frames, std::uint64_t rows) const {
        return extent_.size() >= 2 && extent_[0] == frames && extent_[1] == rows;
    }
    [[nodiscard]] bool has_columns(hsize_t count) const {
        return extent_.size() == 2 && extent_[1] == count && is_float();
    }
    // Returns whether there is a number, or a row of numbers, for each point.
    [[nodiscard]] bool is_numbers() const {
        const bool rows = extent_.size() == 2 && extent_[1] > 0 && extent_[1] <= max_columns;
        return (extent_.size() == 1 || rows) && (is_float() || is_whole());
    }
    [[nodiscard]] std::uint64_t width() const { return extent_.size() == 2 ? extent_[1] : 1; }
    [[nodiscard]] bool is_column() const { return extent_.size() == 1 && (is_float() || is_whole()); }
    [[nodiscard]] bool is_float() const { return type_class_ == H5T_FLOAT && type_size_ <= sizeof(double); }
    [[nodiscard]] bool is_flags() const { return type_class_ == H5T_ENUM; }
    [[nodiscard]] bool is_whole() const { return type_class_ == H5T_INTEGER && type_size_ <= sizeof(std::int64_t); }
    [[nodiscard]] std::uint64_t rows() const { return extent_.empty() ? 0 : extent_[0]; }
    [[nodiscard]] std::size_t rank() const { return extent_.size(); }

    template <typename Number>
    void append_to(std::vector<Number>& to) const {
        append_to(to, 0, rows());
    }
    // Appends rows from `first` on. It reads in pieces, so that Ctrl-C works and HDF5 converts through a small buffer.
    template <typename Number>
    void append_to(std::vector<Number>& to, std::uint64_t first, std::uint64_t rows) const {
        check_storage();
        constexpr bool whole = std::is_same_v<Number, std::int64_t>;
        const hid_t memory_type = whole ? whole_type() : H5T_NATIVE_DOUBLE;
        const std::uint64_t columns = extent_.size() == 2 ? extent_[1] : 1;
        const std::size_t begin = to.size();
        to.resize(begin + rows * columns);
        const Hdf5Handle file_space(H5Dget_space(set_.id()), H5Sclose);
        const hsize_t piece = std::max<hsize_t>(1, (hsize_t{1} << 22) / std::max<std::uint64_t>(columns, 1));
        for (hsize_t row = 0; row < rows; row += piece) {
            throw_if_interrupted();
            std::vector<hsize_t> start{first + row, 0};
            std::vector<hsize_t> count{std::min(piece, rows - row), columns};
            start.resize(extent_.size());
            count.resize(extent_.size());
            if (frame_) {
                start.insert(start.begin(), *frame_);
                count.insert(count.begin(), 1);
            }
            const auto rank = static_cast<int>(count.size());
            const Hdf5Handle memory_space(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
            const bool selected = rank == 0 || H5Sselect_hyperslab(file_space.id(), H5S_SELECT_SET, start.data(),
                                                                   nullptr, count.data(), nullptr) >= 0;
            if (!selected || H5Dread(set_.id(), memory_type, memory_space.id(), file_space.id(), H5P_DEFAULT,
                                     to.data() + begin + row * columns) < 0) {
                throw error("cannot be read: the file is damaged, or packed by a filter that is not there");
            }
        }
        if constexpr (whole) check_size(std::span(to).subspan(begin), first);
    }

    // Returns the value of entries that were never written, if the file sets one.
    [[nodiscard]] std::optional<std::int64_t> fill_value() const {
        const Hdf5Handle plist(H5Dget_create_plist(set_.id()), H5Pclose);
        H5D_fill_value_t state{};
        std::int64_t value = 0;
        if (H5Pfill_value_defined(plist.id(), &state) < 0 || state != H5D_FILL_VALUE_USER_DEFINED ||
            H5Pget_fill_value(plist.id(), whole_type(), &value) < 0)
            return std::nullopt;
        return value;
    }

    [[nodiscard]] std::string description() const {
        std::string text = "shape (";
        for (std::size_t k = 0; k < extent_.size(); ++k) text += (k > 0 ? ", " : "") + std::to_string(extent_[k]);
        text += extent_.size() == 1 ? ",)" : ")";
        const std::string bits = std::to_string(8 * type_size_);
        return text + (type_class_ == H5T_FLOAT     ? " of float" + bits
                       : type_class_ == H5T_INTEGER ? " of int" + bits
                                                    : " of no numbers");
    }
    [[nodiscard]] Failure error(const std::string& message) const { return bad_input(where_ + " " + message); }

    // Returns the bytes in memory after reading.
    [[nodiscard]] double bytes() const {
        double bytes = sizeof(double);
        for (const hsize_t extent : extent_) bytes *= static_cast<double>(extent);
        return bytes;
    }

private:
    // Unsigned numbers keep their bits: HDF5 would turn those that an int64 cannot hold into its largest value.
    [[nodiscard]] hid_t whole_type() const { return is_unsigned_ ? H5T_NATIVE_UINT64 : H5T_NATIVE_INT64; }
    void check_size(std::span<const std::int64_t> numbers, std::uint64_t first) const {
        if (!is_unsigned_ || std::ranges::all_of(numbers, [](std::int64_t n) { return n >= 0; })) return;
        const auto absent = fill_value();
        for (std::size_t k = 0; k < numbers.size(); ++k)
            if (numbers[k] < 0 && numbers[k] != absent)
                throw error("row " + std::to_string(first + k) + " = " +
                            std::to_string(static_cast<std::uint64_t>(numbers[k])) + " is too large for int64");
    }
    // Throws Failure for an extent that the file cannot hold, or for parts that were never written.
    void check_storage() const {
        const Hdf5Handle plist(H5Dget_create_plist(set_.id()), H5Pclose);
        if (!plist.valid()) throw error("has no readable layout");
        if (H5Pget_layout(plist.id()) == H5D_VIRTUAL) {
            throw error("is virtual and refers to other files: give the first of these");
        }
        if (H5Pget_external_count(plist.id()) > 0) throw error("is in external files, which is not supported");
        constexpr std::uint64_t best_ratio = 1032;  // of deflate, the usual filter
        const bool packed = H5Pget_nfilters(plist.id()) > 0;
        const std::uint64_t stored = H5Dget_storage_size(set_.id());
        double bytes = static_cast<double>(type_size_) * static_cast<double>(frames_);
        for (const hsize_t extent : extent_) bytes *= static_cast<double>(extent);
        if (bytes > static_cast<double>(stored) * (packed ? best_ratio : 1)) {
            throw error("announces more numbers (" + description() + ") than the file holds");
        }
        if (H5Pget_layout(plist.id()) == H5D_CHUNKED) check_chunk(plist.id());
    }

    // Throws Failure for a large chunk. HDF5 unpacks whole chunks, even if they are larger than the dataset.
    void check_chunk(hid_t plist) const {
        std::array<hsize_t, H5S_MAX_RANK> sides{};
        const int rank = H5Pget_chunk(plist, H5S_MAX_RANK, sides.data());
        double chunk = static_cast<double>(type_size_);
        for (int k = 0; k < rank; ++k) chunk *= static_cast<double>(sides[static_cast<std::size_t>(k)]);
        constexpr double largest = 0x1p28;
        if (chunk > largest) throw error("has chunks of more than 256 MiB: store it in smaller ones, with h5repack");
    }

    std::string where_;
    Hdf5Handle set_;
    std::vector<hsize_t> extent_;  // of a frame
    std::optional<hsize_t> frame_;
    hsize_t frames_ = 1;
    H5T_class_t type_class_ = H5T_NO_CLASS;
    std::size_t type_size_ = 0;
    bool is_unsigned_ = false;
};

class Hdf5File {
public:
    // Refuses a FIFO before opening it, which would wait for a writer.
    explicit Hdf5File(const std::string& path) : path_(path) {
        std::error_code problem;
        if (std::filesystem::exists(path, problem) && !std::filesystem::is_regular_file(path, problem))
            throw bad_input(path + ": not a regular file");
        size_ = InputFile(path).size();
        file_ = {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
        if (!file_.valid()) {
            const std::string newer = newer_version();  // of the last call
            if (newer.empty() && H5Fis_hdf5(path.c_str()) > 0)
                throw bad_input(path +
                                ": HDF5 cannot open the file: another program has it open for writing and must "
                                "close it first, or the file is damaged");
            throw bad_input(path + ": not an HDF5 file, or a damaged one" + newer);
        }
        hsize_t size = 0;
        if (H5Fget_filesize(file_.id(), &size) < 0 || size > size_) throw bad_input(path + ": the file ends too early");
    }

    // Throws Failure when the datasets together are too large for the file.
    void check_unpacked(double bytes) const {
        constexpr double max = 0x1p63;
        clvotess::check_unpacked(size_, static_cast<std::uint64_t>(std::min(bytes, max)), path_);
    }

    [[nodiscard]] bool has(const std::string& dataset) const {
        std::string part;  // HDF5 reports an error unless each link on the way exists
        for (std::size_t at = 0; at <= dataset.size(); ++at) {
            if (at < dataset.size() && dataset[at] != '/') continue;
            part = dataset.substr(0, at);
            if (part.empty()) continue;
            if (H5Lexists(file_.id(), part.c_str(), H5P_DEFAULT) <= 0) return false;
        }
        return !part.empty() && H5Oexists_by_name(file_.id(), dataset.c_str(), H5P_DEFAULT) > 0;
    }

    [[nodiscard]] bool is_group(const std::string& path) const {
        if (!has(path)) return false;
        H5O_info_t object{};
        return H5Oget_info_by_name2(file_.id(), path.c_str(), &object, H5O_INFO_BASIC, H5P_DEFAULT) >= 0 &&
               object.type == H5O_TYPE_GROUP;
    }

    [[nodiscard]] Hdf5Dataset open(const std::string& dataset) const {
        return {file_.id(), dataset, path_ + ": dataset " + in_quotes(dataset)};
    }

    // Returns the paths of all datasets. Throws Failure for deeply nested groups, where HDF5 takes quadratic time.
    [[nodiscard]] std::vector<std::string> datasets() const {
        Walk walk{.failed = {}, .names = {}, .seen = {}, .path = {}, .depth = 0};
        H5O_info_t root{};
        if (H5Oget_info2(file_.id(), &root, H5O_INFO_BASIC) >= 0) walk.seen.insert(root.addr);
        if (list(file_.id(), walk) < 0 && walk.failed.empty())
            walk.failed = "the file is damaged: its datasets cannot be listed";
        throw_if_interrupted();
        if (!walk.failed.empty()) throw bad_input(path_ + ": " + walk.failed);
        return walk.names;
    }

    // Returns the numbers of an attribute of the group Header; empty without it.
    [[nodiscard]] std::vector<double> header(const char* name) const {
        return has("Header") ? attribute("Header", name) : std::vector<double>();
    }

    [[nodiscard]] bool has_attribute(const std::string& object, const char* name) const {
        return H5Aexists_by_name(file_.id(), object.c_str(), name, H5P_DEFAULT) > 0;
    }
    // Returns the numbers or flags of an attribute; empty without it.
    [[nodiscard]] std::vector<double> attribute(const std::string& object, const char* name) const {
        if (!has_attribute(object, name)) return {};
        const Hdf5Handle attribute(H5Aopen_by_name(file_.id(), object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT),
                                   H5Aclose);
        const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose);
        const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
        const hssize_t count = space.valid() ? H5Sget_simple_extent_npoints(space.id()) : -1;
        const H5T_class_t kind = type.valid() ? H5Tget_class(type.id()) : H5T_NO_CLASS;
        constexpr hssize_t max_count = 64;
        if (count < 1 || count > max_count || (kind != H5T_FLOAT && kind != H5T_INTEGER && kind != H5T_ENUM)) return {};
        std::vector<double> values(static_cast<std::size_t>(count));
        if (H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, values.data()) < 0) return {};
        return values;
    }

    // Returns the number of rows of an attribute; 0 for one without dimensions.
    [[nodiscard]] hsize_t rows_of_attribute(const std::string& object, const char* name) const {
        const Hdf5Handle attribute(H5Aopen_by_name(file_.id(), object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT),
                                   H5Aclose);
        const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose);
        std::array<hsize_t, H5S_MAX_RANK> sides{};
        return space.valid() && H5Sget_simple_extent_dims(space.id(), sides.data(), nullptr) > 0 ? sides[0] : 0;
    }

    // Returns the texts of an attribute; empty without it.
    [[nodiscard]] std::vector<std::string> texts(const std::string& object, const char* name) const {
        if (!has_attribute(object, name)) return {};
        const Hdf5Handle attribute(H5Aopen_by_name(file_.id(), object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT),
                                   H5Aclose);
        const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose), type(H5Aget_type(attribute.id()), H5Tclose);
        const hssize_t count = space.valid() ? H5Sget_simple_extent_npoints(space.id()) : -1;
        constexpr hssize_t max_count = 64;
        if (count < 1 || count > max_count || !type.valid() || H5Tget_class(type.id()) != H5T_STRING) return {};
        std::vector<std::string> result;
        if (H5Tis_variable_str(type.id()) > 0) {
            std::vector<char*> pointers(static_cast<std::size_t>(count), nullptr);
            if (H5Aread(attribute.id(), type.id(), pointers.data()) < 0) return {};
            for (const char* text : pointers) result.emplace_back(text ? text : "");
            H5Dvlen_reclaim(type.id(), space.id(), H5P_DEFAULT, pointers.data());
            return result;
        }
        const std::size_t size = H5Tget_size(type.id());
        if (size == 0 || size > max_line) return {};
        std::string bytes(size * static_cast<std::size_t>(count), '\0');
        if (H5Aread(attribute.id(), type.id(), bytes.data()) < 0) return {};
        for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
            result.emplace_back(bytes.substr(k * size, size).c_str());
        return result;
    }

    // Returns the attributes of Header and Units that scale the numbers of a snapshot.
    [[nodiscard]] std::vector<Attribute> units() const {
        std::vector<Attribute> all;
        for (const char* const group : {"Header", "Units"}) {
            if (!has(group)) continue;
            std::vector<std::string> names;
            const auto visit = [](hid_t, const char* name, const H5A_info_t*, void* to) -> herr_t {
                static_cast<std::vector<std::string>*>(to)->emplace_back(name);
                return 0;
            };
            const Hdf5Handle object(H5Oopen(file_.id(), group, H5P_DEFAULT), H5Oclose);
            if (H5Aiterate2(object.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &names) < 0) continue;
            for (const std::string& name : names) {
                const bool scales =
                    name.starts_with("Unit") || name == "HubbleParam" || name == "Time" || name == "Redshift";
                const std::vector<double> values = attribute(group, name.c_str());
                if (scales && values.size() == 1 && name.find('/') == std::string::npos)
                    all.push_back({name, values[0]});
            }
        }
        return all;
    }

    [[nodiscard]] const std::string& path() const noexcept { return path_; }

private:
    struct Walk {
        std::string failed;
        std::vector<std::string> names;
        std::set<haddr_t> seen;  // objects; hard links may form a circle
        std::string path;        // of the current group, with a slash at its end
        int depth = 0;
    };

    // Called by HDF5, so it must not throw.
    static herr_t visit(hid_t group, const char* name, const H5L_info_t* link, void* to) noexcept {
        Walk& walk = *static_cast<Walk*>(to);
        try {
            if (interrupting_signal() != 0) return -1;
            H5O_info_t object{};
            if (link->type != H5L_TYPE_HARD) return 0;
            if (H5Oget_info_by_name2(group, name, &object, H5O_INFO_BASIC, H5P_DEFAULT) < 0) return -1;
            if (!walk.seen.insert(object.addr).second) return 0;
            if (object.type == H5O_TYPE_DATASET) walk.names.push_back(walk.path + name);
            if (object.type != H5O_TYPE_GROUP) return 0;
            if (walk.depth == max_depth) {
                walk.failed = "groups are nested more than " + std::to_string(max_depth) + " deep";
                return -1;
            }
            const Hdf5Handle inner(H5Gopen2(group, name, H5P_DEFAULT), H5Gclose);
            if (!inner.valid()) return -1;
            const std::size_t length = walk.path.size();
            walk.path += std::string(name) + "/";
            ++walk.depth;
            const herr_t result = list(inner.id(), walk);
            --walk.depth;
            walk.path.resize(length);
            return result;
        } catch (const std::bad_alloc&) {
            walk.failed = "out of memory";
            return -1;
        }
    }

    static herr_t list(hid_t group, Walk& walk) {
        return H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &walk);
    }

    std::string path_;
    std::uint64_t size_ = 0;
    Hdf5Handle file_;
};

}  // namespace clvotess

// HDF5: a dataset (N, 3) of floats, and the snapshots of cosmological codes, whose datasets are spread over files.
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "failure.hpp"
#include "files/formats/hdf5_handles.hpp"
#include "files/formats/hdf5_module.hpp"
#include "files/numbers.hpp"
#include "interrupt.hpp"
#include "read/input.hpp"
#include "read/snapshot_files.hpp"
#include "stream/pieces.hpp"
#include "stream/streamed_file.hpp"

namespace clvotess {
namespace {

// Group of a dataset, with the slash at its end; "" for the root.
std::string group_of(const std::string& path) {
    const auto slash = path.rfind('/');
    return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

class Hdf5Dataset {
public:
    Hdf5Dataset(hid_t file, const std::string& path, std::string where)
        : where_(std::move(where)), set_(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose) {
        if (!set_.valid()) throw error("cannot be opened as a dataset");
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
    }

    [[nodiscard]] bool is_points() const { return has_columns(3); }
    [[nodiscard]] bool has_columns(hsize_t count) const {
        return extent_.size() == 2 && extent_[1] == count && is_float();
    }
    // One or a row of them for each point.
    [[nodiscard]] bool is_numbers() const {
        return (extent_.size() == 1 || (extent_.size() == 2 && extent_[1] > 0)) && (is_float() || is_whole());
    }
    [[nodiscard]] std::uint64_t width() const { return extent_.size() == 2 ? extent_[1] : 1; }
    [[nodiscard]] bool is_column() const { return extent_.size() == 1 && (is_float() || is_whole()); }
    [[nodiscard]] bool is_float() const { return type_class_ == H5T_FLOAT && type_size_ <= sizeof(double); }
    [[nodiscard]] bool is_whole() const { return type_class_ == H5T_INTEGER && type_size_ <= sizeof(std::int64_t); }
    [[nodiscard]] std::uint64_t rows() const { return extent_.empty() ? 0 : extent_[0]; }

    template <typename Number>
    void append_to(std::vector<Number>& to) const {
        append_to(to, 0, rows());
    }
    // Rows from `first` on, behind what `to` holds. In pieces, so that Ctrl-C is heard and HDF5 converts through a
    // small buffer.
    template <typename Number>
    void append_to(std::vector<Number>& to, std::uint64_t first, std::uint64_t rows) const {
        check_storage();
        const hid_t memory_type = std::is_same_v<Number, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
        const std::uint64_t columns = extent_.size() == 2 ? extent_[1] : 1;
        const std::size_t begin = to.size();
        to.resize(begin + rows * columns);
        const Hdf5Handle file_space(H5Dget_space(set_.id()), H5Sclose);
        constexpr hsize_t piece = hsize_t{1} << 20;
        for (hsize_t row = 0; row < rows; row += piece) {
            throw_if_interrupted();
            const std::array<hsize_t, 2> start{first + row, 0};
            const std::array<hsize_t, 2> count{std::min(piece, rows - row), columns};
            const auto rank = static_cast<int>(extent_.size());
            const Hdf5Handle memory_space(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
            if (H5Sselect_hyperslab(file_space.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) <
                    0 ||
                H5Dread(set_.id(), memory_type, memory_space.id(), file_space.id(), H5P_DEFAULT,
                        to.data() + begin + row * columns) < 0) {
                throw error("cannot be read: the file is damaged, or packed by a filter that is not there");
            }
        }
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

private:
    // A broken extent must not take memory, nor may parts that were never written read as zeros.
    void check_storage() const {
        const Hdf5Handle plist(H5Dget_create_plist(set_.id()), H5Pclose);
        if (!plist.valid()) throw error("has no readable layout");
        if (H5Pget_layout(plist.id()) == H5D_VIRTUAL) {
            throw error("is virtual, only names what other files hold: give the first of those files");
        }
        if (H5Pget_external_count(plist.id()) > 0) throw error("lies in external files, which is not supported");
        constexpr std::uint64_t best_ratio = 1032;  // of deflate, the packer in use
        const bool packed = H5Pget_nfilters(plist.id()) > 0;
        const std::uint64_t stored = H5Dget_storage_size(set_.id());
        double bytes = static_cast<double>(type_size_);
        for (const hsize_t extent : extent_) bytes *= static_cast<double>(extent);
        if (bytes > static_cast<double>(stored) * (packed ? best_ratio : 1)) {
            throw error("announces more numbers (" + description() + ") than the file holds");
        }
    }

    std::string where_;
    Hdf5Handle set_;
    std::vector<hsize_t> extent_;
    H5T_class_t type_class_ = H5T_NO_CLASS;
    std::size_t type_size_ = 0;
};

class Hdf5File {
public:
    explicit Hdf5File(const std::string& path) : path_(path) {
        if (!std::ifstream(path)) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
        file_ = {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
        if (!file_.valid()) throw bad_input(path + ": not an HDF5 file, or a damaged one");
        std::ifstream stream(path, std::ios::ate | std::ios::binary);
        hsize_t size = 0;
        if (H5Fget_filesize(file_.id(), &size) < 0 || size > static_cast<std::uint64_t>(stream.tellg())) {
            throw bad_input(path + ": the file ends too early");
        }
    }

    [[nodiscard]] bool has(const std::string& dataset) const {
        std::string part;  // each link on the way must exist, or HDF5 calls it an error
        for (std::size_t at = 0; at <= dataset.size(); ++at) {
            if (at < dataset.size() && dataset[at] != '/') continue;
            part = dataset.substr(0, at);
            if (part.empty()) continue;
            if (H5Lexists(file_.id(), part.c_str(), H5P_DEFAULT) <= 0) return false;
        }
        return !part.empty() && H5Oexists_by_name(file_.id(), dataset.c_str(), H5P_DEFAULT) > 0;
    }

    [[nodiscard]] Hdf5Dataset open(const std::string& dataset) const {
        return {file_.id(), dataset, path_ + ": dataset " + in_quotes(dataset)};
    }

    [[nodiscard]] std::vector<std::string> datasets() const {
        std::vector<std::string> names;
        const auto visit = [](hid_t, const char* name, const H5O_info_t* info, void* to) -> herr_t {
            if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(to)->emplace_back(name);
            return 0;
        };
        if (H5Ovisit2(file_.id(), H5_INDEX_NAME, H5_ITER_INC, visit, &names, H5O_INFO_BASIC) < 0) {
            throw bad_input(path_ + ": the file is damaged: its datasets cannot be listed");
        }
        return names;
    }

    // Numbers of an attribute of the group Header; empty when it is not there.
    [[nodiscard]] std::vector<double> header(const char* name) const {
        return has("Header") ? attribute("Header", name) : std::vector<double>();
    }

    [[nodiscard]] std::vector<double> attribute(const char* group, const char* name) const {
        if (H5Aexists_by_name(file_.id(), group, name, H5P_DEFAULT) <= 0) return {};
        const Hdf5Handle attribute(H5Aopen_by_name(file_.id(), group, name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
        const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose);
        const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
        const hssize_t count = space.valid() ? H5Sget_simple_extent_npoints(space.id()) : -1;
        const H5T_class_t kind = type.valid() ? H5Tget_class(type.id()) : H5T_NO_CLASS;
        constexpr hssize_t most = 64;
        if (count < 1 || count > most || (kind != H5T_FLOAT && kind != H5T_INTEGER)) return {};
        std::vector<double> values(static_cast<std::size_t>(count));
        if (H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, values.data()) < 0) return {};
        return values;
    }

    // Returns Unit... and what else scales the numbers of a snapshot, out of the groups Header and Units.
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
    std::string path_;
    Hdf5Handle file_;
};

class Hdf5Pieces : public InputPieces {
public:
    // rows: so many in a piece.
    Hdf5Pieces(const std::string& path, const ReadRequest& request, std::uint64_t rows)
        : request_(request), rows_(rows), first_(first_snapshot_file(path)) {
        name_ = request_.dataset.empty() ? find_points(first_) : without_slash(request_.dataset);
        domain = domain_of(first_);
        units = first_.units();
        const std::vector<double> announced = first_.header("NumFilesPerSnapshot");
        if (announced.empty() || !(announced[0] > 1)) return;
        const auto name = split_snapshot_name(first_.path());
        constexpr double most = 1e6;
        if (!name || !(announced[0] <= most)) {
            throw bad_input(first_.path() + ": one of " + to_text(announced[0]) +
                            " files of a snapshot, but it is not named like NAME.0.hdf5");
        }
        if (name->part != 0) {
            throw bad_input(first_.path() + ": one of " + to_text(announced[0]) +
                            " files of a snapshot: give the first, " + in_quotes(name->file(0)) + ", and all are read");
        }
        snapshot_ = name;
        files_ = static_cast<std::uint64_t>(announced[0]);
        note = to_text(announced[0]) + " files of a snapshot";
    }

    bool restart() override {
        part_.reset();
        opened_ = read_ = 0;
        found_ = false;
        return true;
    }

    bool next(Input& piece) override {
        piece = {};
        return append(piece, rows_);
    }

    // All of the share that is asked for, at once.
    Input all() {
        const Share& share = request_.share;
        if (share.parts > 1) {
            std::uint64_t rows = rows_of(first_);
            for (std::uint64_t number = 1; number < files_; ++number)
                rows += rows_of(Hdf5File(snapshot_->file(number)));
            begin_ = share.begin(rows);
            end_ = share.end(rows);
        }
        Input input;
        while (append(input, std::numeric_limits<std::uint64_t>::max())) {
        }
        if (input.columns.empty()) input.columns = columns_;
        return input;
    }

private:
    // A file, and how far it has been read.
    struct Part {
        std::optional<Hdf5File> file;  // none for the first, which stays open
        std::optional<Hdf5Dataset> points, ids;
        std::vector<Hdf5Dataset> columns;
        std::uint64_t next = 0;
    };

    static std::string without_slash(const std::string& path) {
        return path.substr(std::min(path.find_first_not_of('/'), path.size()));
    }

    // Files of clvotess itself state all of their domain.
    static FileDomain domain_of(const Hdf5File& file) {
        const std::vector<double> axes = file.attribute("/", "periodic");
        if (axes.size() == 3) {
            std::vector<double> walls;
            if (file.has("walls") && file.open("walls").has_columns(4)) file.open("walls").append_to(walls);
            return stated_domain(file.attribute("/", "box"), {axes[0] != 0, axes[1] != 0, axes[2] != 0},
                                 file.attribute("/", "cell"), file.attribute("/", "origin"), walls);
        }
        FileDomain domain;
        domain.box = box_of(file);
        return domain;
    }

    // A snapshot states the sides of its box, which begins at 0; whether it is periodic it does not say.
    static std::optional<votess::Box> box_of(const Hdf5File& file) {
        const std::vector<double> size = file.header("BoxSize");
        if (size.size() != 1 && size.size() != 3) return std::nullopt;
        votess::Box box{};
        for (std::size_t k = 0; k < 3; ++k) {
            box.upper[k] = size[size.size() == 3 ? k : 0];
            if (!(box.upper[k] > 0 && std::isfinite(box.upper[k]))) return std::nullopt;
        }
        return box;
    }

    [[nodiscard]] static std::string find_points(const Hdf5File& file) {
        std::vector<std::string> candidates;
        for (const std::string& name : file.datasets()) {
            if (file.open(name).is_points()) candidates.push_back(name);
        }
        if (candidates.size() == 1) return candidates[0];
        if (candidates.empty()) {
            throw bad_input(file.path() + ": no dataset of floats with shape (N, 3)");
        }
        constexpr std::size_t shown = 8;
        std::string list;
        for (std::size_t i = 0; i < candidates.size() && i < shown; ++i) list += " " + candidates[i];
        if (candidates.size() > shown) list += " ...";
        throw bad_input(file.path() + ": several datasets could be the points, name one with --dataset:" + list);
    }

    [[nodiscard]] Failure no_dataset(const Hdf5File& file) const {
        std::string list;
        for (const std::string& other : file.datasets()) {
            if (file.open(other).is_points()) list += " " + other;
        }
        return bad_input(file.path() + ": no dataset " + in_quotes(name_) +
                         (list.empty() ? ", nor any of floats with shape (N, 3)" : "; of shape (N, 3) are" + list));
    }

    // What is wrong with the points append() will say.
    [[nodiscard]] std::uint64_t rows_of(const Hdf5File& file) const {
        return file.has(name_) ? file.open(name_).rows() : 0;
    }

    // The next points of the file that is being read, or of the next one, as far as they are in the share.
    bool append(Input& to, std::uint64_t most) {
        while (!part_ || part_->next == part_->points->rows()) {
            if (opened_ == files_) {
                finish();
                return false;
            }
            open(opened_++);
        }
        const std::uint64_t here = part_->next, passed = std::min(most, part_->points->rows() - here);
        const std::uint64_t skipped = std::clamp(begin_, read_, read_ + passed) - read_,
                            rows = std::clamp(end_, read_, read_ + passed) - read_ - skipped;
        const std::uint64_t first = here + skipped;
        part_->points->append_to(to.points, first, rows);
        if (part_->ids) part_->ids->append_to(to.ids, first, rows);
        if (to.columns.empty()) to.columns = columns_;
        for (std::size_t c = 0; c < to.columns.size(); ++c)
            part_->columns[c].append_to(to.columns[c].values, first, rows);
        part_->next += passed;
        read_ += passed;
        return true;
    }

    // A file of a snapshot may lack particles of the type that is asked for.
    void open(std::uint64_t number) {
        part_.reset();
        std::optional<Hdf5File> later;
        if (number > 0) later.emplace(snapshot_->file(number));
        const Hdf5File& file = later ? *later : first_;
        if (!file.has(name_)) {
            if (snapshot_ && !has_particles(file)) return;
            throw no_dataset(file);
        }
        const bool first = !found_;
        found_ = true;
        part_.emplace();
        part_->points.emplace(file.open(name_));
        const Hdf5Dataset& points = *part_->points;
        if (!points.is_points()) throw points.error("has " + points.description() + ", expected (N, 3) of floats");
        find_ids(file, points.rows());
        if (points.rows() > 0) {
            if (with_ids_ && *with_ids_ != part_->ids.has_value())
                throw bad_input(file.path() + ": some files of the snapshot have ids, others have not");
            with_ids_ = part_->ids.has_value();
        }
        if (first) columns_ = wanted(file, points.rows());
        for (const InputColumn& column : columns_) {
            const Hdf5Dataset& values = part_->columns.emplace_back(file.open(path_of(column.name, file)));
            if (!values.is_numbers() || values.width() != column.width || values.rows() != points.rows()) {
                throw values.error("has " + values.description() + ", expected numbers for each of the " +
                                   std::to_string(points.rows()) + " points");
            }
        }
        part_->file = std::move(later);
    }

    void finish() {
        if (!found_) throw no_dataset(first_);
        if (snapshot_) check_total(first_);
    }

    // Beside the points, or at the root; empty when it is at neither place.
    [[nodiscard]] std::string find_column(const std::string& column, const Hdf5File& file) const {
        const std::string beside = group_of(name_) + column;
        const std::string path = file.has(beside) ? beside : without_slash(column);
        return file.has(path) ? path : "";
    }

    [[nodiscard]] std::string path_of(const std::string& column, const Hdf5File& file) const {
        const std::string path = find_column(column, file);
        if (!path.empty()) return path;
        throw bad_input(file.path() + ": no dataset " + in_quotes(column) +
                        ", neither beside the points nor at the root");
    }

    // The columns that the run names, and all others beside the points if it says so.
    [[nodiscard]] std::vector<InputColumn> wanted(const Hdf5File& file, std::uint64_t rows) const {
        std::vector<InputColumn> columns;
        for (const std::string& name : request_.columns) {
            if (request_.columns_may_lack && find_column(name, file).empty()) continue;
            columns.push_back({name, static_cast<std::size_t>(file.open(path_of(name, file)).width()), {}});
        }
        const std::string group = group_of(name_);
        for (const std::string& path : request_.all_columns ? file.datasets() : std::vector<std::string>()) {
            const std::string name = path.substr(std::min(group.size(), path.size()));
            const bool beside = path.starts_with(group) && name.find('/') == std::string::npos;
            const bool named = std::ranges::find(columns, name, &InputColumn::name) != columns.end();
            if (!beside || named || path == name_ || name == "ParticleIDs" || name == "ids") continue;
            const Hdf5Dataset values = file.open(path);
            if (values.is_numbers() && values.rows() == rows)
                columns.push_back({name, static_cast<std::size_t>(values.width()), {}});
        }
        return columns;
    }

    // ParticleIDs beside the points of a snapshot, ids beside those of others.
    void find_ids(const Hdf5File& file, std::uint64_t rows) {
        for (const char* const name : {"ParticleIDs", "ids"}) {
            const std::string path = group_of(name_) + name;
            if (path == name_ || !file.has(path)) continue;
            Hdf5Dataset ids = file.open(path);
            if (!ids.is_column() || !ids.is_whole() || ids.rows() != rows) continue;
            part_->ids.emplace(std::move(ids));
            break;
        }
    }

    // Index of the type in PartType<index>/...; nothing for other names.
    [[nodiscard]] std::optional<std::size_t> particle_type() const {
        constexpr std::string_view start = "PartType";
        if (!name_.starts_with(start) || name_.size() <= start.size() + 1 || name_[start.size() + 1] != '/') return {};
        const char digit = name_[start.size()];
        if (digit < '0' || digit > '9') return std::nullopt;
        return static_cast<std::size_t>(digit - '0');
    }

    [[nodiscard]] bool has_particles(const Hdf5File& file) const {
        const auto type = particle_type();
        const std::vector<double> counts = file.header("NumPart_ThisFile");
        return !type || *type >= counts.size() || counts[*type] != 0;
    }

    void check_total(const Hdf5File& first) const {
        const auto type = particle_type();
        const std::vector<double> low = first.header("NumPart_Total"), high = first.header("NumPart_Total_HighWord");
        if (!type || *type >= low.size()) return;
        const double total = low[*type] + (*type < high.size() ? std::ldexp(high[*type], 32) : 0);
        if (total == static_cast<double>(read_)) return;
        throw bad_input(first.path() + ": the files of the snapshot hold " + std::to_string(read_) +
                        " points, but its header announces " + to_text(total));
    }

    ReadRequest request_;
    std::uint64_t rows_;
    Hdf5File first_;
    std::optional<SnapshotName> snapshot_;  // where there are several files
    std::uint64_t files_ = 1;
    std::string name_;                                                           // of the points
    std::vector<InputColumn> columns_;                                           // empty ones
    std::uint64_t opened_ = 0, read_ = 0;                                        // files and points
    std::uint64_t begin_ = 0, end_ = std::numeric_limits<std::uint64_t>::max();  // of the share
    bool found_ = false;                                                         // in any file
    std::optional<bool> with_ids_;
    std::optional<Part> part_;
};

Input read(const std::string& path, const ReadRequest& request) {
    begin_hdf5();
    Hdf5Pieces pieces(path, request, 0);
    Input input = pieces.all();
    input.domain = std::move(pieces.domain);
    input.units = std::move(pieces.units);
    input.note = std::move(pieces.note);
    return input;
}

std::unique_ptr<InputPieces> open(const std::string& path, const ReadRequest& request, std::size_t rows) {
    begin_hdf5();
    return std::make_unique<Hdf5Pieces>(path, request, rows);
}

}  // namespace

void write_hdf5(OutputFile& file, const OutputData& data);
std::unique_ptr<StreamedFile> create_hdf5(OutputFile& file);
void write_grid_hdf5(OutputFile& file, const GridOutput& grid);

}  // namespace clvotess

extern "C" const clvotess::Hdf5Module clvotess_hdf5;
const clvotess::Hdf5Module clvotess_hdf5{clvotess::read, clvotess::open, clvotess::write_hdf5, clvotess::create_hdf5,
                                         clvotess::write_grid_hdf5};

// HDF5: a dataset (N, 3) of floats, in the plane (N, 2); frames (T, N, 3) as in H5MD and MDTraj; snapshots of
// cosmological codes, in one file or several.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "failure.hpp"
#include "files/formats/hdf5_module.hpp"
#include "files/line_reader.hpp"
#include "files/numbers.hpp"
#include "read/frames.hpp"
#include "read/hdf5/hdf5_domain.hpp"
#include "read/hdf5/hdf5_file.hpp"
#include "read/hdf5/snapshot_files.hpp"
#include "read/input.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

// Returns the group of a dataset, with a slash at its end; "" for the root. An element NAME/value of H5MD is one
// dataset.
std::string group_of(std::string path) {
    if (path.ends_with("/value")) path.resize(path.size() - std::string_view("/value").size());
    const auto slash = path.rfind('/');
    return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

// Returns whether a dataset of that name holds vectors at the points, not places.
bool is_no_place(std::string path) {
    if (path.ends_with("/value")) path.resize(path.size() - std::string_view("/value").size());
    const std::string name = lower_case(path.substr(path.rfind('/') + 1));
    constexpr std::array<std::string_view, 11> vectors{"velocities",   "velocity",      "vel",    "v",
                                                       "forces",       "force",         "f",      "accelerations",
                                                       "acceleration", "magneticfield", "momenta"};
    return std::ranges::find(vectors, std::string_view(name)) != vectors.end();
}

// A file and its read position.
struct Part {
    std::optional<Hdf5File> file;  // null for the first, which stays open
    std::optional<Hdf5Dataset> points, ids;
    std::vector<std::optional<Hdf5Dataset>> columns;  // null for masses in the header
    std::uint64_t next = 0;
};

class Hdf5Pieces : public InputPieces {
public:
    // rows: of a piece.
    Hdf5Pieces(const std::string& path, const ReadRequest& request, std::uint64_t rows)
        : request_(request), rows_(rows), first_(first_snapshot_file(path)) {
        name_ = request_.dataset.empty() ? find_points("") : without_slash(request_.dataset);
        if (first_.is_group(name_)) name_ = find_points(name_ + "/");
        if (first_.has(name_)) {
            const Hdf5Dataset points = first_.open(name_);
            for (const std::size_t columns : columns_of(request_.dimensions)) {
                if (points.has_frames(columns)) frames_ = points.rows();
                if (points.has_frames(columns) || points.has_columns(columns)) dimensions = columns;
            }
        }
        units = first_.units();
        if (frames_) {
            choose_frame(request_.frame.value_or(0));
            return;
        }
        if (request_.frame) throw without_frames(first_.path());
        domain = domain_of_hdf5(first_, name_, dimensions, std::nullopt, note);
        const std::vector<double> announced = first_.header("NumFilesPerSnapshot");
        if (announced.empty() || !(announced[0] > 1)) return;
        const auto name = split_snapshot_name(first_.path());
        constexpr double max_files = 1e6;
        if (!name || !(announced[0] <= max_files)) {
            throw bad_input(first_.path() + ": one of " + to_text(announced[0]) +
                            " files of a snapshot, but it is not named like NAME.0.hdf5");
        }
        if (name->part != 0) {
            throw bad_input(first_.path() + ": one of " + to_text(announced[0]) +
                            " files of a snapshot: give the first, " + in_quotes(name->file(0)) + ", and all are read");
        }
        snapshot_ = name;
        files_ = static_cast<std::uint64_t>(announced[0]);
        note = to_text(announced[0]) + " files of a snapshot" + (note.empty() ? "" : "; " + note);
    }

    [[nodiscard]] std::optional<std::uint64_t> frames() const noexcept { return frames_; }
    [[nodiscard]] const std::string& path() const noexcept { return first_.path(); }

    // Goes to a frame. Throws Failure if it is missing.
    void choose_frame(std::uint64_t frame) {
        if (frame >= *frames_) {
            throw bad_input(path() + ": frame " + std::to_string(frame) + " is missing, the file has " +
                            std::to_string(*frames_) + ", counted from 0");
        }
        (void)restart();
        columns_.clear();
        frame_ = frame;
        std::string unread;
        domain = domain_of_hdf5(first_, name_, dimensions, FrameOfFile{frame, *frames_}, unread);
        timestep = timestep_of_hdf5(first_, name_, frame);
        note = note_of_frame(frame, frames_, timestep) + (unread.empty() ? "" : "; " + unread);
    }

    bool restart() override {
        begin_hdf5();
        part_.reset();
        opened_ = read_ = 0;
        found_ = false;
        return true;
    }

    bool next(Input& piece) override {
        begin_hdf5();
        piece = {};
        return append(piece, rows_);
    }

    // Reads the whole requested share.
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
        input.domain = domain;
        input.units = units;
        input.note = note;
        input.timestep = timestep;
        return input;
    }

private:
    static std::string without_slash(std::string path) {
        while (path.ends_with('/')) path.pop_back();
        return path.substr(std::min(path.find_first_not_of('/'), path.size()));
    }

    // Returns the only dataset of a group that can be the points.
    [[nodiscard]] std::string find_points(const std::string& group) const {
        const Hdf5File& file = first_;
        const std::vector<std::string> candidates = candidates_of(file, group);
        const auto is_usual = [](const std::string& path) {
            const std::string name = lower_case(path.substr(path.rfind('/') + 1));
            return name == "coordinates" || name == "positions" || path.ends_with("position/value");
        };
        if (std::ranges::count_if(candidates, is_usual) == 1) return *std::ranges::find_if(candidates, is_usual);
        if (candidates.size() == 1) return candidates[0];
        if (candidates.empty()) {
            throw bad_input(file.path() + ": no dataset of floats with shape " + shapes_of(request_.dimensions) +
                            ": store the coordinates as one, or as the arrays x, y, z of an .npz");
        }
        constexpr std::size_t shown = 8;
        std::string list;
        for (std::size_t i = 0; i < candidates.size() && i < shown; ++i) list += " " + candidates[i];
        if (candidates.size() > shown) list += " ...";
        throw bad_input(file.path() + ": several datasets could be the points, name one with --dataset:" + list);
    }

    // Returns the datasets of a group, or of the root for "", that can be the points.
    [[nodiscard]] std::vector<std::string> candidates_of(const Hdf5File& file, const std::string& group) const {
        std::vector<std::string> candidates;
        for (const std::size_t columns : columns_of(request_.dimensions)) {
            for (const std::string& name : file.datasets()) {
                if (!name.starts_with(group) || is_no_place(name) || name == "walls") continue;
                const Hdf5Dataset set = file.open(name);
                const bool box = name.ends_with("/box/edges") || name.ends_with("/box/edges/value");
                if (!box && (set.has_columns(columns) || set.has_frames(columns))) candidates.push_back(name);
            }
            if (!candidates.empty()) break;
        }
        return candidates;
    }

    [[nodiscard]] Failure no_dataset(const Hdf5File& file) const {
        std::string list;
        for (const std::string& other : candidates_of(file, "")) list += " " + other;
        return bad_input(file.path() + ": no dataset " + in_quotes(name_) +
                         (list.empty() ? ", nor any of floats with shape " + shapes_of(request_.dimensions)
                                       : "; of the shape of points are" + list));
    }

    // append() reports errors of the points.
    [[nodiscard]] std::uint64_t rows_of(const Hdf5File& file) const {
        if (!file.has(name_)) return 0;
        Hdf5Dataset points = file.open(name_);
        if (frames_) points.choose_frame(frame_);
        return points.rows();
    }

    // Reads the next points of the share, from the current file or the next one.
    bool append(Input& to, std::uint64_t max_rows) {
        while (!part_ || part_->next == part_->points->rows()) {
            if (opened_ == files_) {
                finish();
                return false;
            }
            open(opened_++);
        }
        const std::uint64_t here = part_->next, passed = std::min(max_rows, part_->points->rows() - here);
        const std::uint64_t skipped = std::clamp(begin_, read_, read_ + passed) - read_,
                            rows = std::clamp(end_, read_, read_ + passed) - read_ - skipped;
        const std::uint64_t first = here + skipped;
        to.dimensions = part_->points->width();
        const std::size_t before = to.size();
        part_->points->append_to(to.points, first, rows);
        if (part_->ids) part_->ids->append_to(to.ids, first, rows);
        if (to.columns.empty()) to.columns = columns_;
        for (std::size_t c = 0; c < to.columns.size(); ++c) {
            if (part_->columns[c])
                append_column(*part_->columns[c], first, rows, to.columns[c]);
            else
                to.columns[c].values.insert(to.columns[c].values.end(), rows, *mass_of_all());
        }
        if (!particles_of(name_).empty()) remove_absent(to, before);
        part_->next += passed;
        read_ += passed;
        return true;
    }

    static void append_column(const Hdf5Dataset& from, std::uint64_t first, std::uint64_t rows, InputColumn& to) {
        InputColumn part{.name = to.name, .width = to.width, .keeps_integers = to.keeps_integers};
        from.append_to(part.values, first, rows);
        if (from.is_whole() && std::ranges::any_of(part.values, [&](double x) { return part.may_round(x); })) {
            std::vector<std::int64_t> integers;
            from.append_to(integers, first, rows);
            part.values.clear();
            for (const std::int64_t integer : integers) part.append_integer(integer);
        }
        to.append_all(part);
    }

    // Removes particles that a file of H5MD lists without a place, from row `begin` on: those whose id is the fill
    // value of the ids, and rows of NaN at the end of a frame with others (ZnH5MD).
    void remove_absent(Input& to, std::size_t begin) const {
        const std::size_t size = to.dimensions;
        std::size_t end = to.size();
        const auto is_empty = [&](std::size_t row) {
            return std::all_of(&to.points[size * row], &to.points[size * row] + size,
                               [](double x) { return std::isnan(x); });
        };
        while (end > begin && is_empty(end - 1)) --end;
        if (end == begin) end = to.size();
        const auto fill = part_->ids ? part_->ids->fill_value() : std::nullopt;
        std::size_t kept = begin;
        const auto move_row = [](auto& values, std::size_t width, std::size_t from, std::size_t row) {
            if (!values.empty()) std::copy_n(&values[width * from], width, &values[width * row]);
        };
        for (std::size_t row = begin; row < end; ++row) {
            if (fill && to.ids[row] == *fill) continue;
            if (row != kept) {
                move_row(to.points, size, row, kept);
                move_row(to.ids, 1, row, kept);
                for (InputColumn& column : to.columns) move_row(column.values, column.width, row, kept);
            }
            ++kept;
        }
        to.points.resize(size * kept);
        if (part_->ids) to.ids.resize(kept);
        for (InputColumn& column : to.columns) column.values.resize(column.width * kept);
    }

    // A file of a snapshot may lack particles of the requested type.
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
        if (frames_) part_->points->choose_frame(frame_);
        const Hdf5Dataset& points = *part_->points;
        const auto columns = columns_of(request_.dimensions);
        if (std::ranges::none_of(columns, [&](std::size_t count) { return points.has_columns(count); }))
            throw points.error("has " + points.description() + ", expected " + shapes_of(request_.dimensions) +
                               " of floats");
        find_ids(file, points.rows());
        if (points.rows() > 0) {
            if (with_ids_ && *with_ids_ != part_->ids.has_value())
                throw bad_input(file.path() + ": some files of the snapshot have ids, others have not");
            with_ids_ = part_->ids.has_value();
        }
        if (first) columns_ = wanted(file, points.rows());
        for (const InputColumn& column : columns_) {
            if (is_mass_of_all(column.name, file)) {
                part_->columns.emplace_back();
                continue;
            }
            const Hdf5Dataset& values =
                *part_->columns.emplace_back(open_column(file, path_of(column.name, file), points.rows()));
            if (!values.is_numbers() || values.width() != column.width || values.rows() != points.rows()) {
                throw values.error("has " + values.description() + ", expected numbers for each of the " +
                                   std::to_string(points.rows()) + " points");
            }
        }
        double bytes = points.bytes() + (part_->ids ? part_->ids->bytes() : 0);
        for (const auto& column : part_->columns) bytes += column ? column->bytes() : 0;
        file.check_unpacked(bytes);
        part_->file = std::move(later);
    }

    // Opens a column, at the current frame if it has frames.
    [[nodiscard]] Hdf5Dataset open_column(const Hdf5File& file, const std::string& path, std::uint64_t rows) const {
        Hdf5Dataset set = file.open(path);
        if (frames_ && set.is_column_of(*frames_, rows)) set.choose_frame(frame_);
        return set;
    }

    void finish() {
        if (!found_) throw no_dataset(first_);
        if (snapshot_) check_total(first_);
    }

    // Returns the path of a dataset in the group of the points or at the root; empty if it is in neither.
    [[nodiscard]] std::string find_column(const std::string& column, const Hdf5File& file) const {
        for (const std::string& path : {group_of(name_) + column, without_slash(column)}) {
            if (file.has(path + "/value")) return path + "/value";
            if (file.has(path)) return path;
        }
        return "";
    }

    // Returns the mass that the header states for all particles of the type; nothing if they differ.
    [[nodiscard]] std::optional<double> mass_of_all() const {
        const auto type = particle_type();
        const std::vector<double> masses = first_.header("MassTable");
        if (!type || *type >= masses.size() || !(masses[*type] > 0)) return std::nullopt;
        return masses[*type];
    }
    // Returns whether the column holds masses that the header states.
    [[nodiscard]] bool is_mass_of_all(const std::string& column, const Hdf5File& file) const {
        const std::string name = column.substr(column.rfind('/') + 1);
        return (name == "Masses" || name == "Mass") && find_column(column, file).empty() && mass_of_all();
    }

    [[nodiscard]] std::string path_of(const std::string& column, const Hdf5File& file) const {
        const std::string path = find_column(column, file);
        if (!path.empty()) return path;
        const std::string group = group_of(name_);
        std::string list;
        for (const std::string& other : file.datasets())
            if (other.starts_with(group) && other.find('/', group.size()) == std::string::npos)
                add_name(list, other.substr(group.size()));
        throw bad_input(file.path() + ": no dataset " + in_quotes(column) +
                        ", neither in the group of the points nor at the root; the group has " + list);
    }

    // Finds the requested columns; with all_columns also the others in the group of the points.
    [[nodiscard]] std::vector<InputColumn> wanted(const Hdf5File& file, std::uint64_t rows) const {
        std::vector<InputColumn> columns;
        for (std::size_t c = 0; c < request_.columns.size(); ++c) {
            const std::string& name = request_.columns[c];
            const bool carried = c >= request_.first_carried;
            if (is_mass_of_all(name, file)) {
                columns.push_back({.name = name});
                continue;
            }
            if (request_.columns_may_lack && find_column(name, file).empty()) continue;
            const Hdf5Dataset values = open_column(file, path_of(name, file), rows);
            columns.push_back(
                {.name = name, .width = static_cast<std::size_t>(values.width()), .keeps_integers = carried});
        }
        const std::string group = group_of(name_);
        for (const std::string& path : request_.all_columns ? file.datasets() : std::vector<std::string>()) {
            std::string name = path.substr(std::min(group.size(), path.size()));
            if (name.ends_with("/value")) name.resize(name.size() - std::string_view("/value").size());
            const bool beside = path.starts_with(group) && name.find('/') == std::string::npos;
            const bool named = std::ranges::find(columns, name, &InputColumn::name) != columns.end();
            if (!beside || named || path == name_ || name == "ParticleIDs" || name == "ids") continue;
            const Hdf5Dataset values = open_column(file, path, rows);
            if (columns.size() == max_columns) throw bad_input(file.path() + ": too many columns for --copy all");
            if (values.is_numbers() && values.rows() == rows)
                columns.push_back(
                    {.name = name, .width = static_cast<std::size_t>(values.width()), .keeps_integers = true});
        }
        const bool named = std::ranges::find(columns, "Masses", &InputColumn::name) != columns.end();
        if (request_.all_columns && !named && is_mass_of_all("Masses", file)) columns.push_back({.name = "Masses"});
        return columns;
    }

    // Finds ParticleIDs in a snapshot, ids in other files.
    void find_ids(const Hdf5File& file, std::uint64_t rows) {
        for (const char* const name : {"ParticleIDs", "ids", "id/value", "id"}) {
            const std::string path = group_of(name_) + name;
            if (path == name_ || !file.has(path) || file.is_group(path)) continue;
            Hdf5Dataset ids = open_column(file, path, rows);
            if (!ids.is_column() || !ids.is_whole()) continue;
            if (ids.rows() != rows)
                throw ids.error("has " + ids.description() + ", expected a number for each of the " +
                                std::to_string(rows) + " points");
            part_->ids.emplace(std::move(ids));
            break;
        }
    }

    // Returns the index in PartType<index>/...; nothing for other names.
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
    std::optional<SnapshotName> snapshot_;  // for several files
    std::uint64_t files_ = 1;
    std::string name_;                     // of the points
    std::optional<std::uint64_t> frames_;  // of datasets (frames, N, 3)
    std::uint64_t frame_ = 0;              // the current one
    std::string timestep;
    std::vector<InputColumn> columns_;                                           // without values
    std::uint64_t opened_ = 0, read_ = 0;                                        // numbers of files and points
    std::uint64_t begin_ = 0, end_ = std::numeric_limits<std::uint64_t>::max();  // of the share
    bool found_ = false;                                                         // whether any file has points
    std::optional<bool> with_ids_;
    std::optional<Part> part_;
};

Input read(const std::string& path, const ReadRequest& request) {
    begin_hdf5();
    return Hdf5Pieces(path, request, 0).all();
}

class Hdf5Frames : public InputFrames {
public:
    Hdf5Frames(const std::string& path, const ReadRequest& request)
        : pieces_(path, request, 0), frames_(pieces_.frames().value_or(1)) {}

    bool next(Input& frame) override {
        if (passed_ >= frames_) return false;
        begin_hdf5();  // on the thread that reads
        if (pieces_.frames()) pieces_.choose_frame(passed_);
        frame = pieces_.all();
        frame.frame = passed_++;
        return true;
    }
    bool skip() override { return passed_ < frames_ && ++passed_ > 0; }
    bool last(Input& frame) override {
        passed_ = frames_ - std::min<std::uint64_t>(frames_, 1);
        return next(frame);
    }
    std::optional<std::uint64_t> count_rest() override { return frames_ - passed_; }
    [[nodiscard]] double fraction() const override {
        return static_cast<double>(passed_) / static_cast<double>(std::max<std::uint64_t>(frames_, 1));
    }
    [[nodiscard]] const std::string& name() const override { return pieces_.path(); }

private:
    Hdf5Pieces pieces_;
    std::uint64_t frames_;
};

std::unique_ptr<InputFrames> open_frames_of_hdf5(const std::string& path, const ReadRequest& request) {
    begin_hdf5();
    return std::make_unique<Hdf5Frames>(path, request);
}

std::unique_ptr<InputPieces> open(const std::string& path, const ReadRequest& request, std::size_t rows) {
    begin_hdf5();
    return std::make_unique<Hdf5Pieces>(path, request, rows);
}

}  // namespace

void write_hdf5(OutputFile& file, const OutputData& data);
std::unique_ptr<FramesFile> create_hdf5_frames(OutputFile& file);
std::unique_ptr<StreamedFile> create_hdf5(OutputFile& file);
void write_grid_hdf5(OutputFile& file, const GridOutput& grid);
void write_arrays_hdf5(OutputFile& file, std::span<const ResultArray> arrays);

}  // namespace clvotess

extern "C" const clvotess::Hdf5Module CLVOTESS_HDF5_SYMBOL;
const clvotess::Hdf5Module CLVOTESS_HDF5_SYMBOL{clvotess::read,
                                                clvotess::open,
                                                clvotess::open_frames_of_hdf5,
                                                clvotess::write_hdf5,
                                                clvotess::create_hdf5,
                                                clvotess::create_hdf5_frames,
                                                clvotess::write_grid_hdf5,
                                                clvotess::write_arrays_hdf5};

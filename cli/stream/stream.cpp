#include "stream/stream.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <votess/stream.hpp>

#include "arguments/carried.hpp"
#include "domain.hpp"
#include "failure.hpp"
#include "files/formats/hdf5_module.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "interrupt.hpp"
#include "read/input.hpp"
#include "stream/scratch_file.hpp"
#include "write/output.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

constexpr std::size_t piece_rows = 100000;
constexpr std::uint64_t beside_library = 32'000'000;  // bytes: pieces of input and output, buffers of HDF5

// A number, also with a power of 1000 behind it, or of 1024 as in 4Gi.
std::uint64_t bytes_of(std::string text) {
    const std::string given = text;
    double unit = 1;
    const double step = text.ends_with('i') ? 1024 : 1000;
    if (text.ends_with('i')) text.pop_back();
    constexpr std::string_view letters = "KMGT";
    const auto power = text.empty() ? std::string_view::npos : letters.find(text.back());
    if (power != std::string_view::npos) {
        text.pop_back();
        unit = std::pow(step, static_cast<double>(power + 1));
    }
    const auto number = read_double(text);
    constexpr double most = 1e18;
    if (!number || !(*number * unit >= 1 && *number * unit <= most) || (step > 1000 && unit == 1))
        throw bad_input("--memory must be a number of bytes such as 500M, 4G or 4Gi, not " + in_quotes(given));
    return static_cast<std::uint64_t>(*number * unit);
}

// Bytes in memory now, 0 where the system does not tell.
std::uint64_t resident_bytes() {
    std::ifstream statm("/proc/self/statm");
    std::uint64_t size = 0, resident = 0;
    statm >> size >> resident;
    return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

// Beside the first output, which takes about as much room, or where the system has its own.
std::string scratch_folder(const Arguments& arguments) {
    if (!arguments.temporary.empty()) return arguments.temporary;
    if (arguments.outputs.empty()) return std::filesystem::temp_directory_path().string();
    return std::filesystem::path(identity_of(arguments.outputs[0])).parent_path().string();
}

// Ids and columns wait in files of their own for the rows beside which they go.
class Beside {
public:
    Beside(const Arguments& arguments, std::string folder) : arguments_(arguments), folder_(std::move(folder)) {}

    void keep(const Input& piece) {
        if (!begun_) {
            begun_ = true;
            names_ = piece;
            names_.points.clear();
            for (InputColumn& column : names_.columns) column.values.clear();
            const std::size_t arrays = names_.columns.size() + (piece.ids.empty() ? 0 : 1);
            for (std::size_t a = 0; a < arrays; ++a) files_.emplace_back(folder_);
            Input copy = names_;
            (void)take_carried(arguments_, copy);  // refuses names that the output cannot have, before any work
        }
        auto file = files_.begin();
        if (!piece.ids.empty()) (file++)->write(bytes_of(piece.ids));
        for (const InputColumn& column : piece.columns) (file++)->write(bytes_of(column.values));
    }
    [[nodiscard]] bool has_ids() const { return !names_.ids.empty(); }
    void rewind() {
        for (ScratchFile& file : files_) file.rewind();
    }
    [[nodiscard]] std::uint64_t bytes() const {
        std::uint64_t sum = 0;
        for (const ScratchFile& file : files_) sum += file.size();
        return sum;
    }

    // What belongs to the next rows, without points.
    [[nodiscard]] Input read(std::size_t rows) {
        Input input = names_;
        auto file = files_.begin();
        const auto fill = [&](auto& numbers, std::size_t count) {
            numbers.resize(count);
            (file++)->read(numbers.data(), count * sizeof(numbers[0]));
        };
        if (!names_.ids.empty()) fill(input.ids, rows);
        for (InputColumn& column : input.columns) fill(column.values, rows * column.width);
        complete_columns(arguments_, input);
        return input;
    }

private:
    template <class Number>
    static std::string_view bytes_of(const std::vector<Number>& numbers) {
        return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
    }

    const Arguments& arguments_;
    std::string folder_;
    bool begun_ = false;
    Input names_;  // of columns; and some ids, if there are any
    std::deque<ScratchFile> files_;
};

// Masses and volumes of all seeds until the last duplicate is known: its mass goes to a seed whose row came earlier.
class WaitingMasses {
public:
    explicit WaitingMasses(const std::string& folder) : masses_(folder), volumes_(folder) {}

    // The next rows; duplicate_of counts from the first row of all.
    void add(std::span<const double> masses, std::span<const double> volumes,
             std::span<const std::int64_t> duplicate_of) {
        masses_.write(bytes_of(masses));
        volumes_.write(bytes_of(volumes));
        for (std::size_t i = 0; i < duplicate_of.size(); ++i)
            if (duplicate_of[i] >= 0)
                masses_.add_to(sizeof(double) * static_cast<std::uint64_t>(duplicate_of[i]), masses[i]);
    }
    // Calls use(first row, densities) for all rows.
    template <class Use>
    void each_density(const Use& use) {
        masses_.rewind();
        volumes_.rewind();
        const std::uint64_t rows = masses_.size() / sizeof(double);
        std::vector<double> masses, volumes;
        for (std::uint64_t row = 0; row < rows; row += piece_rows) {
            masses.resize(std::min<std::uint64_t>(piece_rows, rows - row));
            volumes.resize(masses.size());
            masses_.read(masses.data(), sizeof(double) * masses.size());
            volumes_.read(volumes.data(), sizeof(double) * volumes.size());
            use(row, densities(masses, volumes));
        }
    }
    [[nodiscard]] std::uint64_t bytes() const { return masses_.size() + volumes_.size(); }

private:
    static std::string_view bytes_of(std::span<const double> numbers) {
        return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
    }

    ScratchFile masses_, volumes_;
};

class Source : public votess::StreamSource {
public:
    Source(const Arguments& arguments, InputPieces& pieces, Beside& beside)
        : arguments_(arguments), pieces_(pieces), beside_(beside) {}

    bool restart() override {
        first_reading_ = readings_++ == 0;
        return pieces_.restart();
    }
    bool next(votess::StreamSeeds& seeds) override {
        throw_if_interrupted();
        if (!pieces_.next(piece_)) return false;
        if (first_reading_) beside_.keep(piece_);
        seeds.points = piece_.points;
        if (arguments_.has_weights)
            (arguments_.has_radii ? seeds.radii : seeds.weights) = one_each(piece_.columns.at(0));
        return true;
    }

private:
    const Arguments& arguments_;
    InputPieces& pieces_;
    Beside& beside_;
    Input piece_;
    int readings_ = 0;
    bool first_reading_ = true;
};

class Sink : public votess::StreamSink {
public:
    Sink(const Arguments& arguments, InputPieces& pieces, Beside& beside, std::string folder,
         const DomainFrom& domain_from)
        : arguments_(arguments),
          pieces_(pieces),
          beside_(beside),
          folder_(std::move(folder)),
          domain_from_(domain_from) {}

    void begin(const votess::StreamHead& head) override {
        const auto began = Progress::Clock::now();
        head_ = head;
        head_.options.log = {};
        // An empty result has the domain of the run.
        domain_ = votess::tessellate(std::span<const double>(), head_.options);
        beside_.rewind();
        if (arguments_.has_density && head.duplicates) waiting_.emplace(folder_);
        for (const std::string& path : arguments_.outputs)
            writers_.push_back(load_hdf5("cannot write HDF5").create(files_.emplace_back(path)));
        add_seconds(began);
    }

    void rows(const votess::StreamRows& rows) override {
        const auto began = Progress::Clock::now();
        for (std::size_t begin = 0; begin == 0 || begin < rows.status.size(); begin += piece_rows)
            write(rows, begin, std::min(piece_rows, rows.status.size() - begin));
        add_seconds(began);
    }

    void finish() {
        const auto began = Progress::Clock::now();
        if (waiting_) {
            waiting_->each_density([&](std::uint64_t row, const std::vector<double>& density) {
                for (auto& writer : writers_)
                    writer->write(density_number_, row, as_array("density", std::span(density)));
            });
        }
        for (auto& writer : writers_) writer->finish(domain_, attributes_of(pieces_.units, domain_from_));
        writers_.clear();
        for (OutputFile& file : files_) file.finish();
        throw_if_interrupted();
        for (OutputFile& file : files_) file.publish();
        add_seconds(began);
    }

    [[nodiscard]] const votess::Tessellation& domain() const { return domain_; }
    [[nodiscard]] double seconds() const { return seconds_; }
    [[nodiscard]] std::uint64_t temporary_bytes() const { return waiting_ ? waiting_->bytes() : 0; }

private:
    void add_seconds(Progress::Clock::time_point began) {
        seconds_ += std::chrono::duration<double>(Progress::Clock::now() - began).count();
    }

    // Numbers of `count` rows, as many as there are for each; ids as narrow as those of a result in memory.
    ResultPiece piece_of(const votess::StreamRows& rows, std::size_t begin, std::size_t count) {
        ResultPiece piece;
        const auto cells = [&](const auto& all, std::size_t each = 1) {
            return all.empty() ? all : all.subspan(each * begin, each * count);
        };
        piece.wide = head_.seeds > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max());
        piece.has_shifts = head_.periodic && head_.entries > 0;
        piece.has_duplicates = head_.duplicates;
        piece.status = cells(rows.status);
        piece.volumes = cells(rows.volumes);
        piece.centroids = cells(rows.centroids, 3);
        piece.surface_areas = cells(rows.surface_areas);
        piece.security_radii = cells(rows.security_radii);
        piece.face_counts = cells(rows.face_counts);
        piece.edge_counts = cells(rows.edge_counts);
        piece.vertex_counts = cells(rows.vertex_counts);
        piece.wide_duplicate_of = cells(rows.duplicate_of);
        narrow_duplicate_of_.assign(piece.wide_duplicate_of.begin(), piece.wide_duplicate_of.end());
        piece.duplicate_of = narrow_duplicate_of_;
        if (rows.indptr.empty()) return piece;
        piece.indptr = rows.indptr.subspan(begin, count + 1);
        const auto first = static_cast<std::size_t>(piece.indptr.front() - rows.indptr.front());
        const auto size = static_cast<std::size_t>(piece.indptr.back() - piece.indptr.front());
        const auto entries = [&](const auto& all, std::size_t each = 1) {
            return all.empty() ? all : all.subspan(each * first, each * size);
        };
        piece.wide_indices = entries(rows.neighbors);
        if (!piece.wide) narrow_indices_.assign(piece.wide_indices.begin(), piece.wide_indices.end());
        piece.indices = narrow_indices_;
        piece.shifts = entries(rows.shifts, 3);
        piece.face_areas = entries(rows.areas);
        piece.face_normals = entries(rows.normals, 3);
        return piece;
    }

    void write(const votess::StreamRows& rows, std::size_t begin, std::size_t count) {
        Input input = beside_.read(count);
        ResultPiece piece = piece_of(rows, begin, count);
        piece.ids = input.ids;
        piece.has_ids = beside_.has_ids();
        std::vector<InputColumn> carried = take_carried(arguments_, input);
        const std::vector<double> masses = masses_of(arguments_, input);
        const auto volumes = masses.empty() ? std::span<const double>() : rows.volumes.subspan(begin, masses.size());
        fill_density(arguments_, masses, volumes, carried);
        if (waiting_) waiting_->add(masses, volumes, piece.wide_duplicate_of);
        const auto arrays = result_arrays(piece, arguments_.wanted, carried);
        density_number_ = arrays.size() - 1;  // the last one, where there is a density
        for (std::size_t a = 0; a < arrays.size(); ++a) {
            const ResultArray& array = arrays[a];
            const std::uint64_t all = array.of_entries ? head_.entries : head_.seeds + (array.name == "indptr" ? 1 : 0);
            const std::uint64_t row =
                array.of_entries ? static_cast<std::uint64_t>(piece.indptr[0]) : rows.first + begin;
            for (auto& writer : writers_) {
                if (begun_)
                    writer->write(a, row, array);
                else
                    writer->add(array, all);
            }
        }
        begun_ = true;
    }

    const Arguments& arguments_;
    InputPieces& pieces_;
    Beside& beside_;
    std::string folder_;
    const DomainFrom& domain_from_;
    std::optional<WaitingMasses> waiting_;
    std::size_t density_number_ = 0;
    votess::StreamHead head_;
    votess::Tessellation domain_;
    std::deque<OutputFile> files_;
    std::vector<std::unique_ptr<StreamedFile>> writers_;
    std::vector<std::int32_t> narrow_indices_, narrow_duplicate_of_;
    bool begun_ = false;
    double seconds_ = 0;
};

std::uint64_t memory_for_library(std::uint64_t memory) {
    const std::uint64_t taken = resident_bytes() + beside_library, least = taken + votess::StreamOptions::least_memory;
    if (memory >= least) return memory - taken;
    throw bad_input("--memory " + std::to_string(memory) + " is too little: clvotess itself takes about " +
                    std::to_string(taken / 1'000'000) + "M, give at least " + std::to_string(least / 1'000'000 + 1) +
                    "M");
}

}  // namespace

void read_memory(const std::optional<std::string>& memory, const std::optional<std::string>& temporary,
                 Arguments& arguments) {
    if (temporary && !memory) throw bad_input("--temporary goes with --memory SIZE only");
    if (temporary && temporary->empty()) throw bad_input("--temporary is empty: give a folder");
    if (memory) arguments.memory = bytes_of(*memory);
    if (temporary) arguments.temporary = *temporary;
}

void check_streamed(const Arguments& arguments) {
    const auto refuse = [](const std::string& what, const std::string& why) {
        throw bad_input("--memory and " + what + " do not go together: " + why);
    };
    const votess::Options& options = arguments.options;
    const bool cpu = options.device == "auto" || options.device == "cpu";
    if (!cpu) refuse("--device " + options.device, "blocks are clipped by the CPU, leave the device out");
    for (const std::string& path : arguments.outputs)
        if (!path.ends_with(".h5") && !path.ends_with(".hdf5"))
            refuse("-o " + path, "rows are written in pieces into .h5 only, name it .h5");
    if (arguments.wanted.vertices || arguments.wanted.faces)
        refuse("vertices or faces", "cells of several blocks share vertices, leave them out");
    if (options.min_face > 0 || options.min_area > 0)
        refuse("--min-face or --min-area", "that needs the faces of all cells at once, leave it out");
    if (options.duplicates == votess::Duplicates::error)
        refuse("--duplicates error",
               "duplicates are known at the end only, leave it out and look at duplicate_of in the output");
    if (arguments.picture) refuse("--image", "a picture needs all cells at once, leave it out");
}

Summary run_streamed(const Arguments& arguments, Progress::Clock::time_point run_began) {
    const InterruptGuard guard;
    Progress progress(!arguments.quiet, run_began);
    const auto pieces = arguments.random_count ? open_random(*arguments.random_count, arguments.rng_seed, piece_rows)
                                               : open_pieces(arguments.input, arguments.read, piece_rows);
    votess::Options options = arguments.options;
    const DomainFrom domain_from = choose_domain(pieces->domain, arguments.periodic, options);
    options.progress = [&progress](double fraction) {
        progress.show(fraction);
        return interrupting_signal() == 0;
    };
    options.log = [&](std::string_view text) {
        if (text.starts_with("about "))
            progress.say(std::string(text));
        else
            progress.name(std::string(text));
    };
    const std::string folder = scratch_folder(arguments);
    Beside beside(arguments, folder);
    Source source(arguments, *pieces, beside);
    Sink sink(arguments, *pieces, beside, folder, domain_from);
    Summary summary;
    try {
        const votess::StreamResult result = votess::tessellate_stream(
            source, sink, options,
            {.memory = memory_for_library(arguments.memory), .temporary = folder, .verify = arguments.verify});
        summary.verified = result.verified;
        if (summary.failure().empty()) sink.finish();
        summary.stats = result.stats;
        summary.streamed = {result.blocks, result.largest_block, result.asked_cells,
                            result.temporary_bytes + beside.bytes() + sink.temporary_bytes()};
    } catch (const votess::Error& error) {
        if (error.code() == votess::ErrorCode::cancelled) throw_if_interrupted();
        throw;
    }
    votess::StageSeconds& seconds = summary.stats.seconds;
    summary.seconds_read = std::exchange(seconds.upload, 0);
    summary.seconds_write = sink.seconds();
    seconds.download = std::max(0.0, seconds.download - sink.seconds());
    summary.input_note = pieces->note;
    summary.domain = domain_text(sink.domain(), domain_from);
    summary.domain_json = domain_json(sink.domain(), domain_from);
    summary.has_volumes = arguments.wanted.volumes;
    return summary;
}

}  // namespace clvotess

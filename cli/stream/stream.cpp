#include "stream/stream.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
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
#include "run/frames.hpp"
#include "run/settle.hpp"
#include "stream/scratch_file.hpp"
#include "write/output.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

constexpr std::size_t piece_rows = 100000;
constexpr std::uint64_t bytes_for_pieces = 32'000'000;  // bytes for pieces of input and output, and buffers of HDF5

// Reads a number of bytes with an optional unit: powers of 1000, such as 4G, or of 1024, such as 4Gi.
std::uint64_t read_bytes(std::string text) {
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
    constexpr double max = 1e18;
    if (!number || !(*number * unit >= 1 && *number * unit <= max) || (step > 1000 && unit == 1))
        throw bad_input("--memory must be a number of bytes such as 500M, 4G or 4Gi, not " + in_quotes(given));
    return static_cast<std::uint64_t>(*number * unit);
}

// Returns the folder of temporary files: by default that of the first output, else the system's.
std::string scratch_folder(const Arguments& arguments) {
    if (!arguments.temporary.empty()) return arguments.temporary;
    using votess::system::text_of;
    if (arguments.outputs.empty()) return text_of(std::filesystem::temp_directory_path());
    return text_of(votess::system::path_of(identity_of(arguments.outputs[0])).parent_path());
}

// Stores ids and columns in temporary files until their rows are written.
class RowExtras {
public:
    RowExtras(const Arguments& arguments, std::string folder) : arguments_(arguments), folder_(std::move(folder)) {}

    void keep(const Input& piece) {
        refuse_large_integers(piece.columns, "--memory");
        if (!begun_) {
            begun_ = true;
            names_ = piece;
            names_.points.clear();
            for (InputColumn& column : names_.columns) column.values.clear();
            const std::size_t arrays = names_.columns.size() + (piece.ids.empty() ? 0 : 1);
            for (std::size_t a = 0; a < arrays; ++a) files_.emplace_back(folder_);
            Input copy = names_;
            (void)take_carried(arguments_, copy);  // throws for names that the output cannot hold, before any work
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

    // Returns ids and columns of the next rows, without points.
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
    const Arguments& arguments_;
    std::string folder_;
    bool begun_ = false;
    Input names_;  // names of the columns; ids are not empty if there are any
    std::deque<ScratchFile> files_;
};

// Stores masses and volumes of all seeds until the last duplicate is known, whose mass goes to an earlier row.
class PendingMasses {
public:
    explicit PendingMasses(const std::string& folder) : masses_(folder), volumes_(folder) {}

    // Adds the next rows. duplicate_of: rows of the whole run.
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
    ScratchFile masses_, volumes_;
};

class Source : public votess::StreamSource {
public:
    Source(const Arguments& arguments, InputPieces& pieces, RowExtras& extras)
        : arguments_(arguments), pieces_(pieces), extras_(extras) {}

    bool restart() override {
        first_reading_ = readings_++ == 0;
        return pieces_.restart();
    }
    bool next(votess::StreamSeeds& seeds) override {
        throw_if_interrupted();
        if (!pieces_.next(piece_)) return false;
        if (first_reading_) extras_.keep(piece_);
        seeds.points = piece_.points;
        if (arguments_.has_weights)
            (arguments_.has_radii ? seeds.radii : seeds.weights) = one_each(piece_.columns.at(0));
        return true;
    }

private:
    const Arguments& arguments_;
    InputPieces& pieces_;
    RowExtras& extras_;
    Input piece_;
    int readings_ = 0;
    bool first_reading_ = true;
};

class Sink : public votess::StreamSink {
public:
    Sink(const Arguments& arguments, InputPieces& pieces, RowExtras& extras, std::string folder,
         const DomainFrom& domain_from)
        : arguments_(arguments),
          pieces_(pieces),
          extras_(extras),
          folder_(std::move(folder)),
          domain_from_(domain_from) {}

    void begin(const votess::StreamHead& head) override {
        const auto began = Clock::now();
        head_ = head;
        head_.options.log = {};
        // An empty result, which holds the domain of the run.
        domain_ = votess::tessellate(std::span<const double>(), head_.options);
        extras_.rewind();
        if (arguments_.has_density && head.duplicates) pending_.emplace(folder_);
        for (const std::string& path : arguments_.outputs)
            writers_.push_back(load_hdf5("cannot write HDF5").create(files_.emplace_back(path)));
        seconds_ += seconds_since(began);
    }

    void rows(const votess::StreamRows& rows) override {
        const auto began = Clock::now();
        for (std::size_t begin = 0; begin == 0 || begin < rows.status.size(); begin += piece_rows)
            write(rows, begin, std::min(piece_rows, rows.status.size() - begin));
        seconds_ += seconds_since(began);
    }

    void finish() {
        const auto began = Clock::now();
        if (pending_) {
            pending_->each_density([&](std::uint64_t row, const std::vector<double>& density) {
                for (auto& writer : writers_)
                    writer->write(density_number_, row, as_array("density", std::span(density)));
            });
        }
        for (auto& writer : writers_) writer->finish(domain_, attributes_of(pieces_.units, domain_from_));
        writers_.clear();
        for (OutputFile& file : files_) file.finish();
        throw_if_interrupted();
        for (OutputFile& file : files_) file.publish();
        seconds_ += seconds_since(began);
    }

    [[nodiscard]] const votess::Tessellation& domain() const { return domain_; }
    [[nodiscard]] double seconds() const { return seconds_; }
    [[nodiscard]] std::uint64_t temporary_bytes() const { return pending_ ? pending_->bytes() : 0; }

private:
    void write(const votess::StreamRows& rows, std::size_t begin, std::size_t count) {
        Input input = extras_.read(count);
        std::vector<InputColumn> carried = take_carried(arguments_, input);
        const std::vector<double> masses = masses_of(arguments_, input);
        const auto volumes = masses.empty() ? std::span<const double>() : rows.volumes.subspan(begin, masses.size());
        fill_density(arguments_, masses, volumes, carried);
        if (pending_)
            pending_->add(masses, volumes,
                          rows.duplicate_of.empty() ? rows.duplicate_of : rows.duplicate_of.subspan(begin, count));
        const WholeRows whole{
            .size = size_of_vectors(domain_),
            .has_ids = extras_.has_ids(),
            .has_shifts = head_.periodic,
            .has_duplicates = head_.duplicates,
            .wide = head_.seeds > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())};
        const auto arrays = result_arrays(rows, RowRange{begin, count}, whole, input.ids, arguments_.wanted, carried);
        density_number_ = arrays.size() - 1;  // with --density the last array
        for (std::size_t a = 0; a < arrays.size(); ++a) {
            const ResultArray& array = arrays[a];
            const std::uint64_t all = array.of_entries ? head_.entries : head_.seeds + (array.name == "indptr" ? 1 : 0);
            const std::uint64_t row =
                array.of_entries ? static_cast<std::uint64_t>(rows.indptr[begin]) : rows.first + begin;
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
    RowExtras& extras_;
    std::string folder_;
    const DomainFrom& domain_from_;
    std::optional<PendingMasses> pending_;
    std::size_t density_number_ = 0;
    votess::StreamHead head_;
    votess::Tessellation domain_;
    std::deque<OutputFile> files_;
    std::vector<std::unique_ptr<StreamedFile>> writers_;
    bool begun_ = false;
    double seconds_ = 0;
};

std::uint64_t memory_for_library(std::uint64_t memory) {
    const std::uint64_t taken = votess::system::resident_memory() + bytes_for_pieces,
                        least = taken + votess::StreamOptions::least_memory;
    if (memory >= least) return memory - taken;
    throw bad_input("--memory " + std::to_string(memory) + " is too little: clvotess needs about " +
                    std::to_string(taken / 1'000'000) + "M, give at least " + std::to_string(least / 1'000'000 + 1) +
                    "M");
}

}  // namespace

void read_memory(const Typed& typed, Arguments& arguments) {
    if (const std::string* size = typed.value("--memory")) arguments.memory = read_bytes(*size);
    if (const std::string* folder = typed.value("--temporary")) {
        if (folder->empty()) throw bad_input("--temporary is empty: give a folder");
        arguments.temporary = *folder;
    }
    if (arguments.memory == 0) return;
    if (arguments.covalent)
        throw bad_input("--memory needs a column of radii: --radii covalent holds all points in memory");
    if (const Option* option = arguments.find_needing({Needs::all_cells, Needs::all_points}, {"--frames"}))
        throw bad_input("--memory does not work with " + long_name(*option) +
                        ": it needs all points or cells at once; leave one out");
}

void check_streamed(const Arguments& arguments) {
    const auto refuse = [](const std::string& what, const std::string& why) {
        throw bad_input("--memory does not work with " + what + ": " + why);
    };
    const votess::Options& options = arguments.options;
    const bool cpu = options.device == "auto" || options.device == "cpu";
    if (!cpu) refuse("--device " + options.device, "it runs on the CPU; leave the device out");
    for (const std::string& path : arguments.outputs)
        if (!names_hdf5(path))
            refuse("-o " + path, "pieces can only be written to .h5; name the file .h5");
        else if (arguments.frames && !names_frame(path))
            refuse("-o " + path, "each frame has a file; let {frame} stand for its number, as in out-{frame}.h5");
    if (arguments.wanted.vertices || arguments.wanted.faces)
        refuse("vertices or faces", "cells of several blocks share vertices; leave them out");
    if (options.duplicates == votess::Duplicates::error)
        refuse("--duplicates error",
               "duplicates are known only at the end; leave it out and read duplicate_of in the output");
}

namespace {

Summary stream_one(const Arguments& arguments, Clock::time_point run_began) {
    const InterruptGuard guard;
    Progress progress(!arguments.quiet, run_began);
    const auto pieces = arguments.random_count
                            ? open_random(*arguments.random_count, arguments.rng_seed, arguments.read, piece_rows)
                            : open_pieces(arguments.input, arguments.read, piece_rows);
    votess::Options options = arguments.options;
    const DomainFrom domain_from = settle_domain(arguments, pieces->dimensions, pieces->domain, options);
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
    RowExtras extras(arguments, folder);
    Source source(arguments, *pieces, extras);
    Sink sink(arguments, *pieces, extras, folder, domain_from);
    Summary summary;
    summary.set_dimensions(options.planar, arguments.read.dimensions);
    try {
        const votess::StreamResult result = votess::tessellate_stream(source, sink, options,
                                                                      {.memory = memory_for_library(arguments.memory),
                                                                       .temporary = folder,
                                                                       .verify = arguments.verify,
                                                                       .hull = arguments.hull});
        summary.verified = result.verified;
        if (summary.failure().empty()) sink.finish();
        summary.stats = result.stats;
        summary.streamed = {result.blocks, result.largest_block, result.asked_cells,
                            result.temporary_bytes + extras.bytes() + sink.temporary_bytes()};
    } catch (const votess::Error& error) {
        if (error.code() == votess::ErrorCode::cancelled) throw_if_interrupted();
        throw;
    }
    votess::StageSeconds& seconds = summary.stats.seconds;
    summary.seconds_read = std::exchange(seconds.upload, 0);
    summary.seconds_write = sink.seconds();
    seconds.download = std::max(0.0, seconds.download - sink.seconds());
    summary.input_note = pieces->note;
    summary.set_domain(sink.domain(), domain_from);
    summary.has_volumes = arguments.wanted.volumes;
    return summary;
}

}  // namespace

Summary run_streamed(const Arguments& arguments, Clock::time_point run_began) {
    if (!arguments.frames) return stream_one(arguments, run_began);
    const FrameRange& range = *arguments.frames;
    const std::uint64_t count = open_frames(arguments.input, arguments.read)->count_rest().value_or(1);
    Summary sum;
    sum.frames.emplace();
    sum.has_volumes = arguments.wanted.volumes;
    for (std::uint64_t number = range.last ? count - 1 : range.begin; number < count; ++number) {
        if (!range.last && !range.holds(number)) continue;
        Arguments one = arguments;
        one.frames.reset();
        if (count > 1) one.read.frame = number;
        for (std::string& path : one.outputs) path = with_frame(path, number);
        const Summary frame = in_frame(arguments, number, [&] { return stream_one(one, run_began); });
        if (const std::string failure = frame.failure(); !failure.empty())
            throw Failure(exit_code::verification_failed, "frame " + std::to_string(number) + ": " + failure);
        sum.add(frame, number, frame.stats.points);
        sum.seconds_read += frame.seconds_read;
        sum.seconds_write += frame.seconds_write;
    }
    if (sum.frames->count == 0)
        throw bad_input(arguments.input + ": frame " + range.text + " is missing, the file has " +
                        std::to_string(count) + ", counted from 0");
    return sum;
}

}  // namespace clvotess

#include "frames/frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>
#include <votess/votess.hpp>

#include "arguments/carried.hpp"
#include "domain.hpp"
#include "failure.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "frames/relay.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

using FrameClock = std::chrono::steady_clock;

double seconds_from(FrameClock::time_point begin) {
    return std::chrono::duration<double>(FrameClock::now() - begin).count();
}

// A frame and its cells.
struct FrameCells {
    Input input;
    std::span<const double> radii;  // a view into the input
    votess::Tessellation cells;
    std::vector<InputColumn> carried;
    DomainFrom domain_from;
};

// Reads the frames of a range, one after the other.
class RangeReader {
public:
    RangeReader(const Arguments& arguments)
        : range_(*arguments.frames), read_(arguments.read), frames_(open_frames(arguments.input, arguments.read)) {}

    // Returns the next frame of the range; nothing after the last. Throws Failure if the range has no frame.
    std::optional<Input> next() {
        const auto begun = FrameClock::now();
        std::optional<Input> frame(std::in_place);
        if (!read(*frame)) frame.reset();
        any_ |= frame.has_value();
        if (!any_) throw no_frame(*frames_, range_.text);
        seconds += seconds_from(begun);
        return frame;
    }
    // Returns the share of the range that was read; 0 where that is unknown.
    [[nodiscard]] double fraction() const {
        return range_.end ? static_cast<double>(frames_->passed()) / static_cast<double>(*range_.end)
                          : frames_->fraction();
    }

    double seconds = 0;

private:
    bool read(Input& frame) {
        if (range_.last) return !any_ && fitted(frames_->last(frame), frame);
        while (range_.ends_after(frames_->passed())) {
            if (range_.holds(frames_->passed())) return fitted(frames_->next(frame), frame);
            if (!frames_->skip()) break;
        }
        return false;
    }

    bool fitted(bool found, Input& frame) const {
        if (found) fit_dimensions(frames_->name(), read_, frame);
        return found;
    }

    const FrameRange& range_;
    const ReadRequest& read_;
    std::unique_ptr<InputFrames> frames_;
    bool any_ = false;
};

void add_stats(const votess::Stats& one, votess::Stats& sum) {
    sum.device = one.device;
    sum.threads = one.threads;
    sum.points += one.points;
    sum.faces += one.faces;
    sum.volume_sum += one.volume_sum;
    sum.box_volume += one.box_volume;
    sum.duplicates += one.duplicates;
    sum.empty_cells += one.empty_cells;
    sum.fallback_cells += one.fallback_cells;
    sum.fallback_reasons.uncertain += one.fallback_reasons.uncertain;
    sum.fallback_reasons.overflow += one.fallback_reasons.overflow;
    sum.fallback_reasons.exhausted += one.fallback_reasons.exhausted;
    sum.fallback_reasons.skipped += one.fallback_reasons.skipped;
    sum.fallback_reasons.domain += one.fallback_reasons.domain;
    sum.exact_cells += one.exact_cells;
    if (one.tiny_faces) sum.tiny_faces = sum.tiny_faces.value_or(0) + *one.tiny_faces;
    for (double votess::StageSeconds::*stage :
         {&votess::StageSeconds::open, &votess::StageSeconds::upload, &votess::StageSeconds::sort,
          &votess::StageSeconds::knn, &votess::StageSeconds::clip, &votess::StageSeconds::fallback,
          &votess::StageSeconds::download, &votess::StageSeconds::total})
        sum.seconds.*stage += one.seconds.*stage;
    sum.peak_memory_bytes = std::max(sum.peak_memory_bytes, one.peak_memory_bytes);
    sum.precision = one.precision;
    const std::uint64_t cells = sum.points - sum.empty_cells;
    sum.mean_faces = cells > 0 ? static_cast<double>(sum.faces) / static_cast<double>(cells) : 0;
}

// Infinity and NaN have the words that Python reads.
std::string json_array(std::span<const double> numbers) {
    std::string text;
    for (const double x : numbers) {
        text.append(text.empty() ? "[" : ", ");
        text += std::isfinite(x) ? to_text(x) : std::isnan(x) ? "NaN" : x > 0 ? "Infinity" : "-Infinity";
    }
    return text + "]";
}

// Returns words, each with a line end.
std::string lines_of(const std::vector<std::string>& words) {
    std::string lines;
    for (const std::string& word : words) lines.append(word).append("\n");
    return lines;
}

// Returns the line of JSON before the numbers of a frame. words: bytes of each column of words, whose width is 0 there.
std::string description_of(const Input& frame, const std::vector<std::size_t>& words, std::size_t species) {
    std::string columns, units;
    for (std::size_t c = 0; c < frame.columns.size(); ++c) {
        const InputColumn& column = frame.columns[c];
        check_name(column);
        columns.append(columns.empty() ? "[" : ", [").append(json_string(column.name));
        columns.append(", ").append(std::to_string(column.of_words ? 0 : column.width));
        columns.append(", ").append(std::to_string(words[c])).append("]");
    }
    for (const auto& [name, value] : frame.units) {
        const double* const number = std::get_if<double>(&value);
        units.append(units.empty() ? "" : ", ").append(json_string(name)).append(": ");
        units += number ? to_text(*number) : json_string(std::get<std::string>(value));
    }
    const FileDomain& domain = frame.domain;
    const std::size_t size = frame.dimensions;
    const auto list = [size](const std::array<double, 3>& vector) {
        return json_array(std::span<const double>(vector).first(size));
    };
    std::string shape;
    if (domain.cell) {
        const votess::TriclinicBox& cell = *domain.cell;
        shape = R"("cell": [)" + list(cell.a) + ", " + list(cell.b) + (size == 3 ? ", " + list(cell.c) : "") +
                R"(], "origin": )" + list(cell.origin) + ", ";
    } else if (domain.box) {
        shape = R"("box": [)" + list(domain.box->lower) + ", " + list(domain.box->upper) + "], ";
    }
    std::string axes, walls;
    const std::array<bool, 3>& periodic = domain.cell ? domain.cell->periodic : domain.periodic;
    for (std::size_t k = 0; k < size; ++k) axes.append(axes.empty() ? "" : ", ").append(periodic[k] ? "true" : "false");
    for (const votess::Wall& wall : domain.walls) {
        std::vector<double> row(wall.normal.begin(), wall.normal.begin() + static_cast<std::ptrdiff_t>(size));
        row.push_back(wall.offset);
        walls.append(walls.empty() ? "" : ", ").append(json_array(row));
    }
    return R"({"frame": )" + std::to_string(frame.frame.value_or(0)) + R"(, "timestep": )" +
           json_string(frame.timestep) + R"(, "points": )" + std::to_string(frame.size()) + R"(, "dimensions": )" +
           std::to_string(size) + R"(, "ids": )" + (frame.ids.empty() ? "false" : "true") + R"(, "species": )" +
           std::to_string(species) + R"(, "columns": [)" + columns + R"(], "units": {)" + units + "}, " + shape +
           R"("walls": [)" + walls + R"(], "periodic": [)" + axes + R"(], "periodic_from": ")" +
           word_of(domain.periodic_from) + "\"}";
}

class FrameRun {
public:
    FrameRun(const Arguments& arguments, Progress& progress, Summary& summary)
        : arguments_(arguments),
          progress_(progress),
          summary_(summary),
          reader_(arguments),
          outputs_(arguments.outputs) {
        summary.has_volumes = arguments.wanted.volumes;
        summary.frames.emplace();
    }

    // Reads ahead on a thread and writes behind on another. Where reading may wait, as for a pipe, or with --threads 1
    // one step follows the other.
    void run() {
        const bool may_wait = arguments_.input == "-" || is_special_file(arguments_.input);
        const bool alone = arguments_.options.threads == 1 || may_wait;
        alone ? run_in_turn() : run_with_threads();
        outputs_.publish();
        summary_.seconds_read = reader_.seconds;
    }

private:
    void run_in_turn() {
        while (auto input = reader_.next()) {
            auto cells = compute(std::move(*input), reader_.fraction());
            write(cells);
        }
    }

    void run_with_threads() {
        struct Read {
            Input input;
            double fraction = 0;
        };
        Relay<Read> frames;
        Relay<FrameCells> done;
        std::exception_ptr write_failure;
        const auto read_all = [&] {
            try {
                while (auto input = reader_.next())
                    if (!frames.push({std::move(*input), reader_.fraction()})) return;
                frames.end();
            } catch (...) {
                frames.end(std::current_exception());
            }
        };
        const auto write_all = [&] {
            try {
                while (auto cells = done.pop()) write(*cells);
            } catch (...) {
                write_failure = std::current_exception();
                done.stop();
            }
        };
        {
            // Joins the threads, whatever happens.
            struct Threads {
                Relay<Read>& frames;
                Relay<FrameCells>& done;
                std::thread reader = {}, writer = {};
                ~Threads() {
                    frames.stop();
                    done.end();
                    if (reader.joinable()) reader.join();
                    if (writer.joinable()) writer.join();
                }
            } threads{frames, done};
            threads.reader = std::thread(read_all);
            threads.writer = std::thread(write_all);
            while (auto frame = frames.pop())
                if (!done.push(compute(std::move(frame->input), frame->fraction))) break;
        }
        if (write_failure) std::rethrow_exception(write_failure);
    }

    FrameCells compute(Input&& input, double fraction) {
        const std::uint64_t number = input.frame.value_or(0);
        show(number, fraction);
        FrameCells frame;
        frame.input = std::move(input);
        votess::Options options = arguments_.options;
        options.progress = [](double) { return interrupting_signal() == 0; };
        try {
            complete_columns(arguments_, frame.input);
            take_weights(arguments_, frame.input, options);
            frame.radii = options.radii;
            frame.carried = take_carried(arguments_, frame.input);
            check_columns(frame.carried);
            choose_dimensions(frame.input, options);
            summary_.set_dimensions(options.planar, arguments_.read.dimensions);
            frame.domain_from = choose_domain(frame.input.domain, arguments_.periodic, options, arguments_.hull);
            check_corner(frame.input, options, frame.domain_from);
            if (arguments_.hull) set_hull(frame.input.points, options);
            frame.cells = tessellator_.tessellate(std::span<const double>(frame.input.points), options);
            std::vector<double> masses = masses_of(arguments_, frame.input);
            merge_masses(frame.cells.duplicate_of(), masses);
            fill_density(arguments_, masses, frame.cells.volumes(), frame.carried);
            fill_zones(arguments_, frame.input, frame.cells, frame.carried);
        } catch (const Failure& failure) {
            throw Failure(failure.code(), "frame " + std::to_string(number) + ": " + failure.what());
        } catch (const votess::Error& error) {
            if (error.code() == votess::ErrorCode::cancelled) throw;
            throw votess::Error(error.code(), "frame " + std::to_string(number) + ": " + error.what());
        }
        add_to_summary(frame, number);
        return frame;
    }

    // Throws Failure if a .csv would have rows of different lengths.
    void check_columns(const std::vector<InputColumn>& carried) {
        std::vector<std::pair<std::string, std::size_t>> columns;
        for (const InputColumn& column : carried) columns.emplace_back(column.name, column.width);
        if (!columns_) columns_ = columns;
        const auto is_csv = [](const std::string& path) { return extension_of(path) == ".csv"; };
        if (columns != *columns_ && std::ranges::any_of(arguments_.outputs, is_csv))
            throw bad_input(
                "other columns than in the first frame, and .csv has one line of names: name them by --copy");
    }

    void add_to_summary(const FrameCells& frame, std::uint64_t number) {
        const std::string domain = domain_text(frame.cells, frame.domain_from);
        FramesSummary& frames = *summary_.frames;
        const std::uint64_t points = frame.cells.size();
        if (frames.count == 0) {
            frames = {0, number, number, points, points, false};
            summary_.domain = domain;
            summary_.domain_json = domain_json(frame.cells, frame.domain_from);
        }
        frames.moving_domain |= domain != summary_.domain;
        ++frames.count;
        frames.last = number;
        frames.min_points = std::min(frames.min_points, points);
        frames.max_points = std::max(frames.max_points, points);
        add_stats(frame.cells.stats(), summary_.stats);
        if (arguments_.verify) verify_frame(frame, number);
    }

    void verify_frame(const FrameCells& frame, std::uint64_t number) {
        const votess::VerifyReport report = votess::verify(frame.cells, frame.input.points);
        if (!report.passed)
            throw Failure(
                exit_code::verification_failed,
                "frame " + std::to_string(number) + ": verification failed, no file was written: " + report.failure);
        if (!summary_.verified) {
            summary_.verified = report;
            return;
        }
        summary_.verified->sampled += report.sampled;
        if (report.tiny_faces)
            summary_.verified->tiny_faces = summary_.verified->tiny_faces.value_or(0) + *report.tiny_faces;
    }

    void write(const FrameCells& frame) {
        const auto begun = FrameClock::now();
        outputs_.add({.input = frame.input,
                      .tessellation = frame.cells,
                      .wanted = arguments_.wanted,
                      .format = arguments_.format,
                      .radii = frame.radii,
                      .domain_from = frame.domain_from,
                      .carried = frame.carried,
                      .coloring = arguments_.coloring,
                      .place = first_ ? FramePlace::first : FramePlace::later,
                      .has_radii = arguments_.has_radii});
        first_ = false;
        summary_.seconds_write += seconds_from(begun);
    }

    void show(std::uint64_t number, double fraction) {
        constexpr std::chrono::milliseconds pause(100);
        const auto now = FrameClock::now();
        if (now - shown_ < pause) return;
        shown_ = now;
        progress_.name("frame " + std::to_string(number));
        progress_.show(fraction);
    }

    const Arguments& arguments_;
    Progress& progress_;
    Summary& summary_;
    RangeReader reader_;
    FrameOutputs outputs_;
    votess::Tessellator tessellator_;
    FrameClock::time_point shown_;
    std::optional<std::vector<std::pair<std::string, std::size_t>>> columns_;  // of the first frame: names and widths
    bool first_ = true;  // whether the next frame to write is the first
};

}  // namespace

void check_frames(const Arguments& arguments) {
    if (arguments.read.frame) throw bad_input("give either --frame or --frames, not both");
    if (arguments.points_alone && !arguments.outputs.empty())
        throw bad_input("--points writes to stdout: leave -o out");
    if (arguments.picture) throw bad_input("--image draws one frame: give --frame N instead of --frames");
    if (!arguments.only.empty())
        throw bad_input("--only chooses points of one frame: give --frame N instead of --frames");
    if (arguments.has_volumes) throw bad_input("--volumes fits one frame: give --frame N instead of --frames");
    check_frame_outputs(arguments.outputs);
}

void write_points(const Arguments& arguments) {
    const InterruptGuard guard;
    RangeReader reader(arguments);
    OutputFile out("-");
    const auto write = [&out](const auto& values) {
        out.write({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])});
    };
    while (const auto frame = reader.next()) {
        const std::string species = lines_of(frame->species);
        std::vector<std::string> words;
        std::vector<std::size_t> sizes;
        for (const InputColumn& column : frame->columns)
            sizes.push_back(words.emplace_back(lines_of(column.words)).size());
        out.write(description_of(*frame, sizes, species.size()) + "\n");
        write(frame->points);
        write(frame->ids);
        for (std::size_t c = 0; c < words.size(); ++c) {
            write(frame->columns[c].values);
            out.write(words[c]);
        }
        out.write(species);
    }
    out.finish();
}

Summary run_frames(const Arguments& arguments, FrameClock::time_point run_began) {
    Summary summary;
    Progress progress(!arguments.quiet, run_began);
    run_stoppable(progress, [&](const votess::ProgressCallback&) {
        const votess::ProgressScope scope([](double) { return interrupting_signal() == 0; });  // for verify()
        FrameRun(arguments, progress, summary).run();
        return true;
    });
    return summary;
}

}  // namespace clvotess

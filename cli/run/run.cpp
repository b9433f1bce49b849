#include "run/run.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "failure.hpp"
#include "files/output_file.hpp"
#include "interrupt.hpp"
#include "run/cells.hpp"
#include "run/frames.hpp"
#include "run/relay.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

class CellsRun {
public:
    CellsRun(const Arguments& arguments, Clock::time_point run_began)
        : arguments_(arguments), frames_(arguments), run_began_(run_began), outputs_(arguments.frames.has_value()) {
        summary_.has_volumes = arguments.wanted.volumes;
    }

    Summary run_one() {
        Input input = *frames_.next();
        summary_.input_note = input.note;
        const Cells cells = make_cells(arguments_, std::move(input), nullptr, Watch(arguments_.quiet, run_began_));
        add_to_summary(cells);
        if (!cells.failed()) {
            const InterruptGuard guard;
            write(cells);
        }
        return finished();
    }

    // Reads ahead on a thread and writes behind on another. Where reading may wait, as for a pipe, or with --threads 1
    // one step follows the other.
    Summary run_several() {
        Progress progress(!arguments_.quiet, run_began_);
        bar_ = &progress;
        summary_.frames.emplace();
        return run_stoppable(progress, [&](const votess::ProgressCallback&) {
            const bool may_wait = arguments_.input == "-" || is_special_file(arguments_.input);
            const bool alone = arguments_.options.threads == 1 || may_wait;
            alone ? run_in_turn() : run_with_threads();
            return finished();
        });
    }

private:
    Summary finished() {
        outputs_.publish();
        summary_.seconds_read = frames_.seconds();
        return std::move(summary_);
    }

    void run_in_turn() {
        while (auto input = frames_.next()) write(compute(std::move(*input), frames_.fraction()));
    }

    void run_with_threads() {
        struct Read {
            Input input;
            double fraction = 0;
        };
        Relay<Read> inputs;
        Relay<Cells> done;
        std::exception_ptr write_failure;
        const auto read_all = [&] {
            try {
                while (auto input = frames_.next())
                    if (!inputs.push({std::move(*input), frames_.fraction()})) return;
                inputs.end();
            } catch (...) {
                inputs.end(std::current_exception());
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
                Relay<Read>& inputs;
                Relay<Cells>& done;
                std::thread reader = {}, writer = {};
                ~Threads() {
                    inputs.stop();
                    done.end();
                    if (reader.joinable()) reader.join();
                    if (writer.joinable()) writer.join();
                }
            } threads{inputs, done};
            threads.reader = std::thread(read_all);
            threads.writer = std::thread(write_all);
            while (auto frame = inputs.pop())
                if (!done.push(compute(std::move(frame->input), frame->fraction))) break;
        }
        if (write_failure) std::rethrow_exception(write_failure);
    }

    Cells compute(Input input, double fraction) {
        show(input.frame.value_or(0), fraction);
        return in_frame(arguments_, input.frame, [&] {
            Cells cells = make_cells(arguments_, std::move(input), &tessellator_, Watch());
            check_columns(cells.carried);
            add_to_summary(cells);
            if (cells.failed())
                throw Failure(exit_code::verification_failed,
                              "verification failed, no file was written: " + cells.verified->failure);
            return cells;
        });
    }

    // Throws Failure if a .csv would have rows of different lengths.
    void check_columns(const std::vector<InputColumn>& carried) {
        std::vector<std::pair<std::string, std::size_t>> columns;
        for (const InputColumn& column : carried) columns.emplace_back(column.name, column.width);
        if (!columns_) columns_ = columns;
        const auto one_head = [](const std::string& path) {
            return extension_of(path) == ".csv" && !names_frame(path);
        };
        if (columns != *columns_ && std::ranges::any_of(arguments_.outputs, one_head))
            throw bad_input(
                "other columns than in the first frame, and .csv has one line of names: name them by --copy");
    }

    void add_to_summary(const Cells& cells) {
        const votess::Tessellation& tessellation = cells.tessellation;
        Summary one;
        one.set_domain(tessellation, cells.domain_from);
        one.stats = tessellation.stats();
        one.fit = cells.fit;
        one.verified = cells.verified;
        one.set_dimensions(tessellation.planar(), arguments_.read.dimensions);
        summary_.add(one, cells.input.frame.value_or(0), tessellation.size());
    }

    void write(const Cells& cells) {
        const auto begun = Clock::now();
        const std::uint64_t number = cells.input.frame.value_or(0);
        outputs_.begin_frame(number);
        if (arguments_.picture)
            outputs_.add(arguments_.picture->file, [&](OutputFile& file) { file.write(cells.image); });
        for (const std::string& path : arguments_.outputs)
            outputs_.add(path, cells.output(arguments_, outputs_.place(path)));
        outputs_.end_frame();
        summary_.seconds_write += seconds_since(begun) + cells.image_seconds;
    }

    void show(std::uint64_t number, double fraction) {
        constexpr std::chrono::milliseconds pause(100);
        const auto now = Clock::now();
        if (now - shown_ < pause) return;
        shown_ = now;
        bar_->name("frame " + std::to_string(number));
        bar_->show(fraction);
    }

    const Arguments& arguments_;
    Frames frames_;
    Clock::time_point run_began_;
    Progress* bar_ = nullptr;  // of all frames
    Summary summary_;
    Outputs outputs_;
    votess::Tessellator tessellator_;
    Clock::time_point shown_;
    std::optional<std::vector<std::pair<std::string, std::size_t>>> columns_;  // of the first frame: names and widths
};

}  // namespace

void check_frames(const Arguments& arguments) {
    if (arguments.read.frame) throw bad_input("give either --frame or --frames, not both");
    if (arguments.points_alone && !arguments.outputs.empty())
        throw bad_input("--points writes to stdout: leave -o out");
}

Summary run_cells(const Arguments& arguments, Clock::time_point run_began) {
    CellsRun run(arguments, run_began);
    return arguments.frames ? run.run_several() : run.run_one();
}

}  // namespace clvotess

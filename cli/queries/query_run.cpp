#include "queries/query_run.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

#include "arguments/elements.hpp"
#include "failure.hpp"
#include "files/numbers.hpp"
#include "interrupt.hpp"
#include "queries/point_queries.hpp"
#include "queries/to_grid.hpp"
#include "run/frames.hpp"

namespace clvotess {
namespace {

// Wall-clock seconds of the stages of a run, in order. Those of later frames are added.
class StageTimes {
public:
    // Ends a stage, which began when the previous one ended.
    void end(const std::string& stage) {
        const auto now = Clock::now();
        const double seconds = std::chrono::duration<double>(now - last_).count();
        const auto known = std::ranges::find(stages_, stage, &Stage::first);
        if (known == stages_.end())
            stages_.emplace_back(stage, seconds);
        else
            known->second += seconds;
        last_ = now;
    }
    // Returns an object: the total, then each stage.
    [[nodiscard]] std::string json() const {
        std::string text = "{\"total\": " + to_text(std::chrono::duration<double>(last_ - began_).count());
        for (const auto& [stage, seconds] : stages_) text += ", \"" + stage + "\": " + to_text(seconds);
        return text + "}";
    }
    [[nodiscard]] Clock::time_point began() const { return began_; }

private:
    using Stage = std::pair<std::string, double>;
    Clock::time_point began_ = Clock::now(), last_ = began_;
    std::vector<Stage> stages_;
};

Input read_queries(const Arguments& arguments, ReadRequest request, std::size_t dimensions) {
    // Points of the plane may be known by their two coordinates, and queries too.
    if (dimensions == 2) request.dimensions = arguments.read.dimensions;
    return read_input(arguments.queries, request);
}

std::unique_ptr<Query> query_of(const Arguments& arguments) {
    return arguments.to_grid ? make_grid_query(arguments) : make_point_query(arguments);
}

class QueryRun {
public:
    explicit QueryRun(const Arguments& arguments)
        : arguments_(arguments),
          query_(query_of(arguments)),
          frames_(arguments),
          outputs_(arguments.frames.has_value()) {}

    std::string run() {
        if (arguments_.frames) {
            Progress progress(!arguments_.quiet, times_.began());
            run_stoppable(progress, [&](const votess::ProgressCallback&) {
                answer_all(Watch(), &progress);
                return 0;
            });
        } else {
            answer_all(Watch(arguments_.quiet, times_.began()), nullptr);
        }
        return summary();
    }

private:
    void answer_all(const Watch& watch, Progress* bar) {
        while (std::optional<Input> seeds = frames_.next()) {
            if (bar) bar->show(frames_.fraction());
            in_frame(arguments_, seeds->frame, [&] {
                answer(std::move(*seeds), watch);
                return 0;
            });
        }
        const InterruptGuard guard;
        outputs_.publish();
        times_.end("write");
    }

    void answer(Input seeds, const Watch& watch) {
        const std::size_t dimensions = seeds.dimensions;
        if (!arguments_.queries.empty() && frame_count_ == 0)
            queries_ = read_queries(arguments_, query_->request(dimensions), dimensions);
        if (queries_.size() == 0) queries_.dimensions = dimensions;
        if (queries_.dimensions != dimensions)
            throw bad_input(arguments_.queries + ": these have three coordinates, but the points of " +
                            arguments_.input + " two: add --2d if their z does not matter");
        queries_.frame = seeds.frame;
        queries_.timestep = seeds.timestep;
        queries_.units = seeds.units;
        Settled settled = settle(arguments_, std::move(seeds));
        times_.end("read");
        votess::Diagram diagram = watch([&](const votess::ProgressCallback& callback) {
            votess::Options options = settled.options;
            options.progress = callback;
            if (arguments_.hull) set_hull(settled.input.points, options);
            return votess::Diagram(settled.input.points, options);
        });
        times_.end("sort");
        const QueryInput input{std::move(settled), queries_, std::move(diagram)};
        watch([&](const votess::ProgressCallback& callback) {
            query_->ask(input, callback);
            return 0;
        });
        times_.end(query_->stage);
        ++frame_count_;
        points_ += input.diagram.size();
        asked_ += queries_.size();
        std::optional<InterruptGuard> guard;
        if (!arguments_.frames) guard.emplace();
        outputs_.begin_frame(queries_.frame.value_or(0));
        query_->write(input, outputs_);
        outputs_.end_frame();
        times_.end("write");
    }

    std::string summary() const {
        const std::string points = std::to_string(points_), queries = std::to_string(asked_);
        const std::string frames = std::to_string(frame_count_);
        if (arguments_.json) {
            std::string text = "{\"version\": \"" VOTESS_VERSION_STRING "\", \"points\": " + points;
            if (!arguments_.queries.empty()) text += ", \"queries\": " + queries;
            text += query_->note(true);
            for (const auto& [name, _, number] : query_->counts())
                text += std::string(", \"") + name + "\": " + std::to_string(number);
            if (arguments_.frames) text += ", \"frames\": " + frames;
            return text + ", \"seconds\": " + times_.json() + "}\n";
        }
        if (arguments_.quiet || std::ranges::count(arguments_.outputs, "-") > 0) return "";
        std::string text = query_->done;
        text += arguments_.queries.empty() ? query_->note(false) + " from " : " " + queries + " queries among ";
        text += points + " seeds";
        if (arguments_.frames) text += " of " + frames + (frame_count_ == 1 ? " frame" : " frames");
        for (const auto& [_, words, number] : query_->counts())
            if (number > 0) text += ", " + std::to_string(number) + " " + words;
        return text + '\n';
    }

    const Arguments& arguments_;
    StageTimes times_;
    std::unique_ptr<Query> query_;
    Frames frames_;
    Outputs outputs_;
    Input queries_;
    std::uint64_t frame_count_ = 0, points_ = 0, asked_ = 0;
};

}  // namespace

std::string run_query(const Arguments& arguments) {
    return QueryRun(arguments).run();
}

Values values_of(const Input& seeds, std::size_t first_column) {
    Values values;
    const auto columns = std::span(seeds.columns).subspan(std::min(first_column, seeds.columns.size()));
    for (const InputColumn& column : columns) values.components += column.width;
    for (std::size_t i = 0; i < seeds.size(); ++i)
        for (const InputColumn& column : columns)
            for (std::size_t k = 0; k < column.width; ++k) values.rows.push_back(column.values[column.width * i + k]);
    values.components = std::max<std::size_t>(values.components, 1);  // for a file of no points
    return values;
}

ReadRequest request_of_queries(const Arguments& arguments) {
    ReadRequest request;
    request.threads = arguments.read.threads;
    request.species = arguments.covalent;
    if (!arguments.has_weights || arguments.covalent) return request;
    request.columns = {arguments.read.columns.at(0)};
    request.columns_may_lack = true;
    return request;
}

std::vector<double> sizes_of_queries(const Arguments& arguments, const QueryInput& input) {
    const Input& queries = input.queries;
    if (!arguments.has_weights || input.diagram.size() == 0) return {};
    if (arguments.covalent && queries.species.size() == queries.size()) return covalent_radii(queries.species);
    if (queries.columns.empty()) return std::vector<double>(queries.size());
    const auto column = one_each(queries.columns.front());
    return {column.begin(), column.end()};
}

bool is_npy_output(const std::string& path) {
    return path != "-" && extension_of(path) == ".npy";
}

void check_number_outputs(const Arguments& arguments, const std::string& does) {
    const std::vector<std::string>& outputs = arguments.outputs;
    if (outputs.empty()) throw bad_input(arguments.query + " " + does + ": add -o FILE.npy, FILE.txt or - for stdout");
    for (const std::string& path : outputs) {
        const bool text = path == "-" || extension_of(path) == ".txt" || is_special_file(path);
        if (!text && !is_npy_output(path))
            throw bad_input(arguments.query + " writes .npy and .txt, not " + in_quotes(path));
    }
    check_paths(outputs, {arguments.input, arguments.queries});
}

}  // namespace clvotess

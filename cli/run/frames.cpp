#include "run/frames.hpp"

#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "domain.hpp"
#include "failure.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "summary.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

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
// The last word of a column says whether its numbers are 64-bit integers.
std::string description_of(const Input& frame, const std::vector<std::size_t>& words, std::size_t species) {
    std::string columns, units;
    for (std::size_t c = 0; c < frame.columns.size(); ++c) {
        const InputColumn& column = frame.columns[c];
        check_name(column);
        columns.append(columns.empty() ? "[" : ", [").append(json_string(column.name));
        columns.append(", ").append(std::to_string(column.of_words ? 0 : column.width));
        columns.append(", ").append(std::to_string(words[c])).append(column.of_integers ? ", true]" : ", false]");
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

}  // namespace

FrameRange read_frame_range(const std::string& text) {
    FrameRange range;
    range.text = text;
    if (text == "all") return range;
    if (text == "last") {
        range.last = true;
        return range;
    }
    const auto refuse = [&] {
        return bad_input("--frames must be all, last or a:b:c, frames a to b - 1 in steps of c, counted from 0, not " +
                         in_quotes(text));
    };
    const auto parts = split(text, ':');
    if (parts.size() < 2 || parts.size() > 3) throw refuse();
    std::array<std::optional<std::uint64_t>, 3> numbers;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        numbers[k] = read_uint64(parts[k]);
        if (!numbers[k] && !parts[k].empty()) throw refuse();
    }
    range.begin = numbers[0].value_or(0);
    range.end = numbers[1];
    range.step = numbers[2].value_or(1);
    if (range.step == 0 || (range.end && *range.end <= range.begin)) throw refuse();
    return range;
}

Frames::Frames(const Arguments& arguments) : arguments_(arguments) {
    if (arguments.frames) file_ = open_frames(arguments.input, arguments.read);
}

std::optional<Input> Frames::next() {
    const auto begun = Clock::now();
    std::optional<Input> frame = read();
    any_ |= frame.has_value();
    if (!any_) throw no_frame(*file_, arguments_.frames->text);
    seconds_ += seconds_since(begun);
    return frame;
}

double Frames::fraction() const {
    if (!file_) return 0;
    const FrameRange& range = *arguments_.frames;
    return range.end ? static_cast<double>(file_->passed()) / static_cast<double>(*range.end) : file_->fraction();
}

std::optional<Input> Frames::read() {
    const ReadRequest& request = arguments_.read;
    if (!file_) {
        if (any_) return std::nullopt;
        if (arguments_.random_count && arguments_.options.mesh)
            return random_points_in(*arguments_.options.mesh, arguments_.options.planar ? 2 : 3,
                                    *arguments_.random_count, arguments_.rng_seed, request.threads);
        return arguments_.random_count ? random_points(*arguments_.random_count, arguments_.rng_seed, request)
                                       : read_input(arguments_.input, request);
    }
    const FrameRange& range = *arguments_.frames;
    const auto fitted = [&](bool (InputFrames::*take)(Input&)) {
        std::optional<Input> frame(std::in_place);
        if (!(*file_.*take)(*frame)) return std::optional<Input>();
        fit_dimensions(file_->name(), request, *frame);
        return frame;
    };
    if (range.last) return any_ ? std::nullopt : fitted(&InputFrames::last);
    while (range.ends_after(file_->passed())) {
        if (range.holds(file_->passed())) return fitted(&InputFrames::next);
        if (!file_->skip()) break;
    }
    return std::nullopt;
}

void write_points(const Arguments& arguments) {
    const InterruptGuard guard;
    Frames reader(arguments);
    OutputFile out("-");
    while (const auto frame = reader.next()) {
        const std::string species = lines_of(frame->species);
        std::vector<std::string> words;
        std::vector<std::size_t> sizes;
        for (const InputColumn& column : frame->columns)
            sizes.push_back(words.emplace_back(lines_of(column.words)).size());
        out.write(description_of(*frame, sizes, species.size()) + "\n");
        out.write(bytes_of(frame->points));
        out.write(bytes_of(frame->ids));
        for (std::size_t c = 0; c < words.size(); ++c) {
            out.write(bytes_of(frame->columns[c].values));
            out.write(words[c]);
        }
        out.write(species);
    }
    out.finish();
}

}  // namespace clvotess

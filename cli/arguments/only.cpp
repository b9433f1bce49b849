#include "arguments/only.hpp"

#include <algorithm>

#include "arguments/typed.hpp"
#include "failure.hpp"
#include "files/line_reader.hpp"
#include "files/text_source.hpp"
#include "options.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

bool is_range(const std::string& text) {
    return !text.empty() && text.find_first_not_of("0123456789:") == std::string::npos;
}

// As slices of Python, from 0 up.
std::vector<std::int64_t> read_range(const std::string& text, std::size_t count) {
    const auto parts = split(text, ':');
    if (parts.size() > 3) throw bad_input("--only " + text + " has more than three parts: give START:STOP:STEP");
    const auto part = [&](std::size_t k, std::uint64_t otherwise) {
        if (k >= parts.size() || parts[k].empty()) return otherwise;
        return whole_number("--only", std::string(parts[k]), std::uint64_t{1} << 40);
    };
    const std::uint64_t start = part(0, 0), step = part(2, 1);
    const std::uint64_t stop = parts.size() == 1 ? start + 1 : std::min<std::uint64_t>(part(1, count), count);
    if (step == 0) throw bad_input("--only " + text + " has the step 0: give 1 or more");
    std::vector<std::int64_t> only;
    for (std::uint64_t i = start; i < stop; i += step) only.push_back(static_cast<std::int64_t>(i));
    return only;
}

}  // namespace

void check_only(const Arguments& arguments) {
    if (arguments.only.empty()) throw bad_input("--only is empty: give a range such as 0:100, or a file of indices");
    if (arguments.only == "-" && arguments.input == "-")
        throw bad_input("INPUT and --only are both stdin: give one as a file");
    if (arguments.only == "-" && arguments.frames)
        throw bad_input("--only - is read for each frame: give it as a file");
    if (arguments.has_volumes || arguments.has_density || arguments.has_zones)
        throw bad_input(
            "--only makes some of the cells, but --volumes, --density and --watershed need all: leave it out");
    for (const std::string& path : arguments.outputs)
        if (!output_has(path, input_columns) || path.ends_with(".vtu"))
            throw bad_input("--only writes text, .csv, .xyz, .dump, .npz and .h5, not " + in_quotes(path));
}

std::vector<std::int64_t> read_only(const std::string& only, std::size_t count) {
    if (is_range(only)) return read_range(only, count);
    if (extension_of(only) == ".npy") return read_npy_indices(only, count);
    TextSource source(only, false);
    const std::string text = rest_of(source);
    LineReader lines(text, source.name());
    std::vector<std::int64_t> indices;
    Words words;
    for (std::string_view line; lines.next_filled(line);) {
        split_words(line, words);
        for (const std::string_view word : words) indices.push_back(lines.whole(word, "an index of --only"));
    }
    return indices;
}

InputColumn rows_of(const InputColumn& column, const std::vector<std::int64_t>& only) {
    InputColumn some{
        .name = column.name, .width = column.width, .of_words = column.of_words, .of_integers = column.of_integers};
    for (const std::int64_t i : only) {
        if (column.of_words) {
            some.words.push_back(column.words[static_cast<std::size_t>(i)]);
            continue;
        }
        const auto begin =
            column.values.begin() + static_cast<std::ptrdiff_t>(i * static_cast<std::int64_t>(column.width));
        some.values.insert(some.values.end(), begin, begin + static_cast<std::ptrdiff_t>(column.width));
    }
    return some;
}

Input points_of(const Input& input, const std::vector<std::int64_t>& only) {
    Input some;
    some.domain = input.domain;
    some.units = input.units;
    some.note = input.note;
    some.frame = input.frame;
    some.timestep = input.timestep;
    some.dimensions = input.dimensions;
    some.points = rows_of({"points", input.dimensions, input.points}, only).values;
    for (const std::int64_t i : only) {
        some.ids.push_back(input.ids.empty() ? i : input.ids[static_cast<std::size_t>(i)]);
        if (!input.species.empty()) some.species.push_back(input.species[static_cast<std::size_t>(i)]);
    }
    return some;
}

}  // namespace clvotess

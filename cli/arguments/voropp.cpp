// clvotess --voro++: the command line of voro++ 0.4.6, so that scripts change only the name of the program.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "arguments/arguments.hpp"
#include "failure.hpp"
#include "files/numbers.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

constexpr std::string_view expected =
    "give -c -l -m -n -o -p -px -py -pz -r -v as needed, then x_min x_max y_min y_max z_min z_max FILE";

class Words {
public:
    Words(int count, const char* const* values) : words_(values + std::min(count, 1), values + count) {}

    [[nodiscard]] bool at_end() const { return next_ == words_.size(); }
    [[nodiscard]] std::size_t left() const { return words_.size() - next_; }

    std::string take(const std::string& of) {
        if (at_end()) throw bad_input("--voro++: " + of + " needs a value: " + std::string(expected));
        return words_[next_++];
    }

    template <std::size_t count>
    std::array<double, count> take_numbers(const std::string& of) {
        std::array<double, count> numbers{};
        for (double& number : numbers) {
            const std::string word = take(of);
            const auto read = read_double(word);
            if (!read) throw bad_input("--voro++: " + of + ": " + in_quotes(word) + " is not a number");
            number = *read;
        }
        return numbers;
    }

private:
    std::vector<std::string> words_;
    std::size_t next_ = 0;
};

// Returns true when the word is a known option, whose values it takes.
bool take_option(const std::string& word, Words& words, Arguments& arguments, std::string& format) {
    std::array<bool, 3>& periodic = *arguments.periodic;
    if (word == "-c") {
        format = words.take(word);
    } else if (word == "-l" || word == "-m") {
        (void)words.take_numbers<1>(word);  // grid of voro++, not used
    } else if (word == "-n") {
        (void)words.take_numbers<3>(word);
    } else if (word == "-o") {
        // Rows always follow the input order.
    } else if (word == "-p") {
        periodic = {true, true, true};
    } else if (word == "-px" || word == "-py" || word == "-pz") {
        periodic[static_cast<std::size_t>(word[2] - 'x')] = true;
    } else if (word == "-r") {
        arguments.has_weights = arguments.has_radii = true;
    } else if (word == "-v") {
        arguments.quiet = false;
    } else if (word.size() == 3 && word.starts_with("-w")) {
        throw bad_input(
            "--voro++: " + word +
            " also cuts the cells of points beyond the wall, so the result is not a diagram: run clvotess with --wall, "
            "--wall-sphere, --wall-cylinder or --wall-cone");
    } else if (word == "-g" || word == "-y" || word == "-yp" || word == "-yv") {
        throw bad_input("--voro++: " + word +
                        " writes for gnuplot or POV-Ray: run clvotess with --image, or -o FILE in .vtu, .ply or .glb");
    } else {
        return false;
    }
    return true;
}

}  // namespace

void drop_upper_walls(const Arguments& arguments, Input& input) {
    if (!arguments.format.like_voropp()) return;
    const std::array<double, 3>& upper = arguments.options.box->upper;
    for (std::size_t k = 0; k < input.points.size(); ++k) {
        const std::size_t axis = k % 3;
        if (!(*arguments.periodic)[axis] && input.points[k] == upper[axis])
            input.points[k] = std::nextafter(upper[axis], std::numeric_limits<double>::infinity());
    }
}

Arguments read_voropp_arguments(int count, const char* const* values) {
    Words words(count, values);
    Arguments arguments;
    arguments.quiet = true;
    arguments.periodic.emplace();
    std::string format;
    std::string word = words.take("--voro++");
    while (take_option(word, words, arguments, format)) word = words.take("--voro++");

    // The box and the file follow the options.
    if (words.left() != 6) {
        throw bad_input("--voro++: from " + in_quotes(word) + " on there are " + std::to_string(words.left() + 1) +
                        " words, 7 expected, the numbers of the box and the file: " + std::string(expected));
    }
    const auto first = read_double(word);
    if (!first)
        throw bad_input("--voro++: " + in_quotes(word) +
                        " is neither a known option nor a number: " + std::string(expected));
    const auto rest = words.take_numbers<5>("the box");
    votess::Options& options = arguments.options;
    options.box = votess::Box{.lower = {*first, rest[1], rest[3]}, .upper = {rest[0], rest[2], rest[4]}};
    options.outside = votess::Outside::drop;
    arguments.input = words.take("the box");
    arguments.outputs = {arguments.input + ".vol"};
    arguments.read.text = true;
    arguments.read.threads = options.threads;
    if (arguments.has_radii) arguments.read.columns = {"5"};
    check_outputs(arguments.outputs, {arguments.input});

    if (format.empty()) format = arguments.has_radii ? "%i %q %v %r" : "%i %q %v";
    arguments.format = TextFormat(format, true);
    options.list_walls = true;  // as voro++ does in %n
    options.want.neighbors = options.want.volumes = false;
    arguments.format.add_needs(options.want);
    arguments.wanted = options.want = votess::implied_want(options);
    return arguments;
}

}  // namespace clvotess

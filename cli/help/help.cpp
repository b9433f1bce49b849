#include "help/help.hpp"

#include <algorithm>
#include <cmath>
#include <vector>
#include <votess/version.hpp>

#include "failure.hpp"
#include "files/numbers.hpp"
#include "options.hpp"

namespace clvotess {
namespace {

constexpr std::string_view title = "clvotess: exact Voronoi tessellation in three dimensions, or two (--2d)\n\n";
constexpr std::string_view usage =
    "usage: clvotess INPUT [options]                      tessellate the points of INPUT\n"
    "       clvotess --random N [--rng-seed S] [options]  N uniform points in the unit box instead\n"
    "       clvotess --surface FILE --remesh N -o OUT.obj a mesh of even triangles for a surface\n\n"
    "Prints a short summary and writes the files that -o names.\n";
constexpr std::string_view ending =
    R"(units: lengths are those of the input, areas their square, volumes their cube; times in the
       summary are seconds.

exit codes: 0 done, 1 run-time failure (device lost, disk full, out of memory,
            fewer threads than -t requests),
            2 bad usage or input, or a missing device,
            3 verification failed, 130 stopped by Ctrl-C

example: the volume and the neighbors of each of a million random points
  clvotess --random 1e6 -o cells.txt --format "%i %q %v %n"
)";

constexpr std::size_t text_column = 25, text_width = 75;

// Adds a text, indented from its second line on.
void add_lines(std::string& page, std::string_view text) {
    for (;;) {
        const auto end = text.find('\n');
        page.append(text.substr(0, end)) += '\n';
        if (end == std::string_view::npos) return;
        text.remove_prefix(end + 1);
        page.append(text_column, ' ');
    }
}

void add_row(std::string& page, std::string_view names, std::string_view text) {
    page.append("  ").append(names);
    const std::size_t length = names.size() + 2;
    if (text.empty()) {
        page += '\n';
        return;
    }
    if (length < text_column) {
        page.append(text_column - length, ' ');
    } else {
        page.append("\n").append(text_column, ' ');
    }
    add_lines(page, text);
}

// Returns the text with default, range and unit: "... (length unit squared, default 0)".
std::string text_of(const Option& option) {
    std::string notes(option.traits.unit);
    const auto note = [&](const std::string& text) { notes += (notes.empty() ? "" : ", ") + text; };
    if (!option.traits.start.empty()) note("default " + std::string(option.traits.start));
    if (std::isfinite(option.traits.max)) note("at most " + to_text(option.traits.max));
    std::string text(option.text);
    if (notes.empty()) return text;
    const bool fits = text.size() - (text.rfind('\n') + 1) + notes.size() + 3 <= text_width;
    return text + (fits ? " (" : "\n(") + notes + ")";
}

// Adds text to a manual page: backslashes and minus signs get a backslash, and no line begins with a command.
void add_roff(std::string& page, std::string_view text) {
    bool line_begins = true;
    for (const char c : text) {
        if (line_begins && (c == '.' || c == '\'')) page += "\\&";
        if (c == '\\' || c == '-') page += '\\';
        page += c == '\\' ? 'e' : c;
        line_begins = c == '\n';
    }
}

// Returns the words that an option takes, with blanks between; "" if its value is not a word.
std::string joined_words(const Option& option) {
    std::string joined;
    for (const std::string_view word : words_of(option)) add_name(joined, word);
    return joined;
}

std::string bash_completion() {
    std::string all, cases;
    each_option([&](const Option& option) {
        std::string pattern;
        for (const std::string_view name : names_of(option)) {
            all.append(" ").append(name);
            pattern.append(pattern.empty() ? "" : "|").append(name);
        }
        const std::string words = joined_words(option);
        if (!words.empty()) {
            cases += "        " + pattern + ") COMPREPLY=($(compgen -W \"" + words + "\" -- \"$word\")); return ;;\n";
        }
    });
    return "_clvotess() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
           "    case $before in\n" +
           cases +
           "    esac\n"
           "    case $word in\n"
           "        -*) COMPREPLY=($(compgen -W \"" +
           all.substr(1) +
           "\" -- \"$word\")) ;;\n"
           "        *) COMPREPLY=($(compgen -f -- \"$word\")) ;;\n"
           "    esac\n"
           "}\n"
           "complete -o filenames -F _clvotess clvotess\n";
}

std::string zsh_completion() {
    return "autoload -U +X bashcompinit && bashcompinit\n" + bash_completion();
}

std::string fish_completion() {
    std::string lines;
    each_option([&](const Option& option) {
        const auto names = names_of(option);
        if (names.empty()) return;
        lines += "complete -c clvotess";
        for (const std::string_view name : names) {
            lines.append(name.starts_with("--") ? " -l " : " -s ").append(name.substr(name.find_first_not_of('-')));
        }
        const std::string words = joined_words(option);
        if (!words.empty()) lines += " -x -a \"" + words + "\"";
        lines += '\n';
    });
    return lines;
}

}  // namespace

std::string usual_help() {
    std::string page;
    page.append(title).append(usage).append("\n");
    each_option([&](const Option& option) {
        if (!option.traits.brief.empty()) add_row(page, option.names, option.traits.brief);
    });
    return page + "\nclvotess --help-all lists every option in detail.\n";
}

std::string whole_help() {
    std::string page;
    page.append(title).append(usage);
    for (const Option& option : option_table()) {
        if (option.names.empty())
            page.append("\n").append(option.text).append("\n");
        else
            add_row(page, option.names, text_of(option));
    }
    return page.append("\n").append(ending);
}

std::string manual_page() {
    std::string page =
        ".TH CLVOTESS 1 \"\" \"votess " VOTESS_VERSION_STRING
        "\"\n.SH NAME\nclvotess \\- exact Voronoi tessellation in three dimensions or two\n.SH SYNOPSIS\n.nf\n";
    add_roff(page, usage);
    for (const Option& option : option_table()) {
        page += option.names.empty() ? ".fi\n.SH \"" : ".B \"";
        add_roff(page, option.names.empty() ? option.text : option.names);
        page += option.names.empty() ? "\"\n.nf\n" : "\"\n.RS\n";
        if (option.names.empty()) continue;
        add_roff(page, text_of(option));
        page += "\n.RE\n";
    }
    page += ".fi\n.SH NOTES\n.nf\n";
    add_roff(page, ending);
    return page + ".fi\n";
}

std::string completion(const std::string& shell) {
    if (shell == "bash") return bash_completion();
    if (shell == "zsh") return zsh_completion();
    if (shell == "fish") return fish_completion();
    throw bad_input("--completion must be bash, zsh or fish, not " + in_quotes(shell));
}

}  // namespace clvotess

#include "help/help.hpp"

#include <algorithm>
#include <vector>
#include <votess/version.hpp>

#include "failure.hpp"
#include "help/options_table.hpp"

namespace clvotess {
namespace {

constexpr std::string_view title = "clvotess: exact 3D Voronoi tessellation\n\n";
constexpr std::string_view usage =
    "usage: clvotess INPUT [options]                      tessellate the points of INPUT\n"
    "       clvotess --random N [--rng-seed S] [options]  N uniform points in the unit box instead\n\n"
    "Prints a short summary and writes the files that -o names.\n";
constexpr std::string_view ending =
    R"(units: lengths are those of the input, areas their square, volumes their cube; times in the
       summary are seconds.

exit codes: 0 done, 1 run-time failure (device lost, disk full, out of memory,
            fewer threads than -t requests),
            2 bad usage or input, or a device that is not there,
            3 verification failed, 130 stopped by Ctrl-C

example: the volume and the neighbors of each of a million random points
  clvotess --random 1e6 -o cells.txt --format "%i %q %v %n"
)";

constexpr std::size_t text_column = 25;

// Returns the text with every line except the first indented.
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

// Returns the names of an option without its value: "-o" and "--output".
std::vector<std::string_view> names_of(const HelpRow& row) {
    std::vector<std::string_view> names;
    std::string_view rest = row.names;
    while (rest.starts_with('-')) {
        const auto end = rest.find_first_of(", ");
        names.push_back(rest.substr(0, end));
        rest.remove_prefix(end == std::string_view::npos ? rest.size() : rest.find_first_not_of(", ", end));
    }
    return names;
}

// Returns the words that an option accepts, with blanks between them; "" for other values.
std::string words_of(const HelpRow& row) {
    const auto blank = row.names.rfind(' ');
    std::string words(blank == std::string_view::npos ? "" : row.names.substr(blank + 1));
    if (words.starts_with('[')) words = words.substr(1, words.size() - 2);
    if (words.find('|') == std::string::npos) return "";
    for (char& c : words) {
        if (c == '|') c = ' ';
    }
    return words;
}

// Returns text for roff: backslashes and minus signs are escaped, and no line begins with a command.
void add_roff(std::string& page, std::string_view text) {
    bool line_begins = true;
    for (const char c : text) {
        if (line_begins && (c == '.' || c == '\'')) page += "\\&";
        if (c == '\\' || c == '-') page += '\\';
        page += c == '\\' ? 'e' : c;
        line_begins = c == '\n';
    }
}

template <typename Use>
void each_row(Use use) {
    for (const HelpSection& section : help_sections()) {
        for (const HelpRow& row : section.rows) use(row);
    }
}

std::string bash_completion() {
    std::string all, cases;
    each_row([&](const HelpRow& row) {
        std::string pattern;
        for (const std::string_view name : names_of(row)) {
            all.append(" ").append(name);
            pattern.append(pattern.empty() ? "" : "|").append(name);
        }
        const std::string words = words_of(row);
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
    each_row([&](const HelpRow& row) {
        const auto names = names_of(row);
        if (names.empty()) return;
        lines += "complete -c clvotess";
        for (const std::string_view name : names) {
            lines.append(name.starts_with("--") ? " -l " : " -s ").append(name.substr(name.find_first_not_of('-')));
        }
        const std::string words = words_of(row);
        if (!words.empty()) lines += " -x -a \"" + words + "\"";
        lines += '\n';
    });
    return lines;
}

}  // namespace

std::string usual_help() {
    std::string page;
    page.append(title).append(usage).append("\n");
    each_row([&](const HelpRow& row) {
        if (!row.brief.empty()) add_row(page, row.names, row.brief);
    });
    return page + "\nclvotess --help-all lists every option in detail.\n";
}

std::string whole_help() {
    std::string page;
    page.append(title).append(usage).append("\n");
    for (const HelpSection& section : help_sections()) {
        page.append(section.heading).append("\n");
        for (const HelpRow& row : section.rows) add_row(page, row.names, row.text);
        page += '\n';
    }
    return page.append(ending);
}

std::string manual_page() {
    std::string page = ".TH CLVOTESS 1 \"\" \"votess " VOTESS_VERSION_STRING
                       "\"\n.SH NAME\nclvotess \\- exact 3D Voronoi tessellation\n.SH SYNOPSIS\n.nf\n";
    add_roff(page, usage);
    page += ".fi\n";
    for (const HelpSection& section : help_sections()) {
        page += ".SH \"";
        add_roff(page, section.heading);
        page += "\"\n.nf\n";
        for (const HelpRow& row : section.rows) {
            page += ".B \"";
            add_roff(page, row.names);
            page += "\"\n.RS\n";
            add_roff(page, row.text);
            page += "\n.RE\n";
        }
        page += ".fi\n";
    }
    page += ".SH NOTES\n.nf\n";
    add_roff(page, ending);
    return page + ".fi\n";
}

std::string_view usage_of(std::string_view option) {
    std::string_view usage;
    each_row([&](const HelpRow& row) {
        if (std::ranges::count(names_of(row), option) > 0) usage = row.names;
    });
    return usage;
}

std::string completion(const std::string& shell) {
    if (shell == "bash") return bash_completion();
    if (shell == "zsh") return zsh_completion();
    if (shell == "fish") return fish_completion();
    throw bad_input("--completion must be bash, zsh or fish, not " + in_quotes(shell));
}

}  // namespace clvotess

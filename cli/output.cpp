#include "output.hpp"

#include <set>

#include "atomic_file.hpp"
#include "failure.hpp"

namespace clvotess {

bool is_text_output(const std::string& path) {
    return path == "-" || extension_of(path) == ".txt" || (extension_of(path) != ".npz" && is_special_file(path));
}

void check_outputs(const std::vector<std::string>& paths, const std::string& input) {
    std::set<std::string> seen;
    for (const std::string& path : paths) {
        if (!is_text_output(path) && extension_of(path) != ".npz") {
            throw bad_input("cannot write " + in_quotes(path) +
                            ": this version writes .txt and .npz, and text on stdout as -");
        }
        if (path != "-") check_writable(path);
        if (!seen.insert(identity_of(path)).second) throw bad_input("output " + in_quotes(path) + " is named twice");
        if (path != "-" && input != "-" && !input.empty() && !is_special_file(path) &&
            identity_of(path) == identity_of(input)) {
            throw bad_input("output " + in_quotes(path) + " is the input: give it another name");
        }
    }
}

void write_outputs(const std::vector<std::string>& paths, const OutputData& data) {
    std::vector<OutputFile> files;
    files.reserve(paths.size());
    for (const std::string& path : paths) {
        OutputFile& file = files.emplace_back(path);
        if (is_text_output(path)) {
            write_text(file, data);
        } else {
            write_npz(file, data);
        }
        file.finish();
    }
    for (OutputFile& file : files) file.publish();
}

}  // namespace clvotess

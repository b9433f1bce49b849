// Drives the readers without libFuzzer: every file of the corpus, then damaged copies, which depend on the seed alone.
//   votess_reader_fuzz CORPUS RUNS [--seed N] [READER...]    CORPUS has a folder for each reader; default: all readers
//   votess_reader_fuzz --replay READER FILE
// An input that ends the program is stored as crash-READER in the current folder.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/readers/reader_target.hpp"

extern "C" void __sanitizer_set_death_callback(void (*callback)()) __attribute__((weak));

namespace {

std::string reader, input;

void keep_input() {
    const std::string path = "crash-" + reader;
    if (std::FILE* const file = std::fopen(path.c_str(), "wb")) {
        std::fwrite(input.data(), 1, input.size(), file);
        std::fclose(file);
        std::fprintf(stderr, "the input is kept as %s\n", path.c_str());
    }
}

void keep_and_end(int signal) {
    std::signal(signal, SIG_DFL);
    keep_input();
    std::raise(signal);
}

std::string read_file(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw std::invalid_argument("cannot read " + path.string());
    return {std::istreambuf_iterator<char>(stream), {}};
}

// A copy of the exact size, so that a sanitizer detects reads beyond its end.
void feed(std::string bytes) {
    input = std::move(bytes);
    const std::vector<std::uint8_t> exact(input.begin(), input.end());
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

// Cuts the file, flips bits, replaces letters or numbers, or removes, repeats or inserts pieces.
std::string damaged(std::string bytes, const std::string& other, std::mt19937_64& random) {
    const auto below = [&random](std::size_t limit) { return limit > 0 ? std::size_t{random() % limit} : 0; };
    const std::size_t how = below(8);
    if (how == 0) return bytes.substr(0, below(bytes.size() + 1));
    constexpr std::string_view letters = "0123456789-.e\n <>\"/=,;:#";
    constexpr std::string_view numbers[] = {
        "-1", "0", "1e999", "0,5", "nan", "4294967296", "18446744073709551615", "9223372036854775808"};
    constexpr std::size_t longest_header = 1500, longest_piece = 40;
    for (std::size_t left = 1 + below(4); left > 0 && !bytes.empty(); --left) {
        const std::size_t at = below(below(2) == 0 ? bytes.size() : std::min(bytes.size(), longest_header));
        const auto is_number = [](char c) { return (c >= '0' && c <= '9') || c == '.'; };
        switch (how) {
            case 1:
            case 2:
                bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
                break;
            case 3:
                bytes[at] = letters[below(letters.size())];
                break;
            case 4:
                bytes.erase(at, below(longest_piece));
                break;
            case 5: {
                std::size_t end = at;
                while (end < bytes.size() && is_number(bytes[end])) ++end;
                bytes.replace(at, end - at, numbers[below(std::size(numbers))]);
                break;
            }
            case 6:
                bytes.insert(at, other.substr(below(other.size() + 1), below(longest_piece)));
                break;
            default:
                bytes.insert(at, bytes.substr(below(bytes.size()), below(longest_piece)));
                break;
        }
    }
    return bytes;
}

void run(const std::filesystem::path& corpus, std::uint64_t runs, std::uint64_t seed) {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(corpus / reader)) paths.push_back(entry.path());
    std::ranges::sort(paths);
    std::vector<std::string> files;
    for (const auto& path : paths) feed(files.emplace_back(read_file(path)));
    if (files.empty()) throw std::invalid_argument("no files in " + (corpus / reader).string());
    std::mt19937_64 random(seed);
    for (std::uint64_t k = 0; k < runs; ++k) {
        const std::string& other = files[random() % files.size()];
        feed(damaged(files[random() % files.size()], other, random));
    }
    std::printf("%s: %zu files, %llu damaged copies\n", reader.c_str(), files.size(),
                static_cast<unsigned long long>(runs));
    std::fflush(stdout);
}

int main_inside(std::vector<std::string> words) {
    if (words.size() == 3 && words[0] == "--replay") {
        reader = words[1];
        if (!choose_reader(reader)) throw std::invalid_argument("the readers are " + reader_names());
        feed(read_file(words[2]));
        return 0;
    }
    if (words.size() < 2) throw std::invalid_argument("usage: votess_reader_fuzz CORPUS RUNS [--seed N] [READER...]");
    std::uint64_t seed = 1;
    if (const auto at = std::ranges::find(words, "--seed"); at != words.end() && at + 1 != words.end()) {
        seed = std::stoull(at[1]);
        words.erase(at, at + 2);
    }
    std::vector<std::string> names(words.begin() + 2, words.end());
    if (names.empty()) {
        std::istringstream all(reader_names());
        names.assign(std::istream_iterator<std::string>(all), {});
    }
    for (const std::string& name : names) {
        reader = name;
        if (!choose_reader(reader)) throw std::invalid_argument("the readers are " + reader_names());
        run(words[0], std::stoull(words[1]), seed);
    }
    return 0;
}

}  // namespace

int main(int count, char** values) {
    if (__sanitizer_set_death_callback) __sanitizer_set_death_callback(keep_input);
    for (const int signal : {SIGABRT, SIGSEGV, SIGFPE}) {
        if (!__sanitizer_set_death_callback || signal == SIGABRT) std::signal(signal, keep_and_end);
    }
    try {
        return main_inside({values + 1, values + count});
    } catch (const std::exception& error) {
        // Also catches exceptions that are not refusals.
        std::fprintf(stderr, "votess_reader_fuzz: %s\n", error.what());
        keep_input();
        return 1;
    }
}

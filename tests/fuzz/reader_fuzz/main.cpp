// Feeds a reader of clvotess with damaged copies of a good file: cut, with bits flipped, letters replaced, pieces taken
// out or repeated. A reader gives whole points or one line of complaint; anything else ends this program.
//   votess_reader_fuzz FILE ROUNDS [COLUMN]      prints how many copies were read and how many refused
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "failure.hpp"
#include "read/input.hpp"

namespace {

using namespace clvotess;
using Parser = Input (*)(std::string_view, const std::string&, const ReadRequest&);

template <TextKind kind>
Input text(std::string_view bytes, const std::string& name, const ReadRequest& request) {
    return parse_text(bytes, kind, name, request);
}

const std::map<std::string, Parser> parsers{{".txt", text<TextKind::plain>},
                                            {".xyz", parse_xyz},
                                            {".vasp", parse_poscar},
                                            {".csv", text<TextKind::csv>},
                                            {".npz", parse_npz},
                                            {".dump", parse_lammps_dump},
                                            {".data", parse_lammps_data},
                                            {".ply", parse_ply},
                                            {".vtp", parse_vtk},
                                            {".vtu", parse_vtk}};

std::string damaged(std::string bytes, std::mt19937_64& random) {
    const auto below = [&random](std::size_t limit) {
        return limit > 0 ? static_cast<std::size_t>(random() % limit) : 0;
    };
    if (bytes.empty()) return bytes;
    const std::size_t how = below(6);
    if (how == 0) return bytes.substr(0, below(bytes.size()));
    constexpr std::string_view letters = "0123456789-.e\n <>\"/=,;";
    constexpr std::size_t longest_header = 1500, longest_piece = 20;
    for (std::size_t left = 1 + below(3); left > 0 && !bytes.empty(); --left) {
        const std::size_t at = below(below(2) == 0 ? bytes.size() : std::min(bytes.size(), longest_header));
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
            default:
                bytes.insert(at, bytes.substr(below(bytes.size()), below(longest_piece)));
                break;
        }
    }
    return bytes;
}

[[noreturn]] void complain(const std::string& what, const std::string& bytes) {
    std::ofstream("damaged", std::ios::binary) << bytes;
    std::fprintf(stderr, "%s; the file is kept as \"damaged\"\n", what.c_str());
    std::exit(1);
}

void check(const Input& input, const ReadRequest& request, const std::string& bytes) {
    const std::size_t count = input.size();
    if (input.points.size() != 3 * count) complain("no whole number of points", bytes);
    if (!input.ids.empty() && input.ids.size() != count) complain("ids of another number than points", bytes);
    if (count > 0 && input.columns.size() < request.columns.size()) complain("fewer columns than wanted", bytes);
    for (const InputColumn& column : input.columns) {
        if (column.values.size() != column.width * count) complain("values of another number", bytes);
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) return std::fprintf(stderr, "usage: votess_reader_fuzz FILE ROUNDS [COLUMN]\n"), 2;
    const std::string path = argv[1];
    const long rounds = std::atol(argv[2]);
    ReadRequest request;
    if (argc > 3) request.columns = {argv[3]};
    std::ifstream stream(path, std::ios::binary);
    const std::string good{std::istreambuf_iterator<char>(stream), {}};
    const Parser parse = parsers.at(extension_of(path));
    std::mt19937_64 random(good.size());
    long read = 0, refused = 0;
    for (long round = 0; round <= rounds; ++round) {
        const std::string bytes = round == 0 ? good : damaged(good, random);
        const std::vector<char> exact(bytes.begin(), bytes.end());  // no byte behind the last
        request.all_columns = round % 3 == 2;
        try {
            check(parse({exact.data(), exact.size()}, "file", request), request, bytes);
            ++read;
        } catch (const Failure& failure) {
            if (failure.code() != exit_code::bad_input) complain(failure.what(), bytes);
            if (round == 0) complain("the good file is refused: " + std::string(failure.what()), bytes);
            ++refused;
        } catch (const std::exception& error) {
            complain(error.what(), bytes);
        }
    }
    std::printf("%ld %ld\n", read, refused);
}

// The fuzz target of each reader of clvotess: LLVMFuzzerTestOneInput() passes one file to the reader. It must return
// whole points or fail with one line; anything else ends this program. libFuzzer drives it, or standalone.cpp.
#include "fuzz/readers/reader_target.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "failure.hpp"
#include "files/numbers.hpp"
#include "files/text_source.hpp"
#include "read/frames.hpp"
#include "read/input.hpp"
#include "read/surface.hpp"

#if VOTESS_FUZZ_HDF5
#include "files/formats/hdf5_module.hpp"
extern "C" const clvotess::Hdf5Module clvotess_hdf5;
namespace clvotess {
// The module also writes files, which is not tested here.
void write_hdf5(OutputFile&, const OutputData&) {
    std::abort();
}
std::unique_ptr<StreamedFile> create_hdf5(OutputFile&) {
    std::abort();
}
std::unique_ptr<FramesFile> create_hdf5_frames(OutputFile&) {
    std::abort();
}
void write_grid_hdf5(OutputFile&, const GridOutput&) {
    std::abort();
}
void write_arrays_hdf5(OutputFile&, std::span<const ResultArray>) {
    std::abort();
}
}  // namespace clvotess
#endif

namespace {

using namespace clvotess;

[[noreturn]] void complain(const std::string& what) {
    std::fprintf(stderr, "reader: %s\n", what.c_str());
    std::abort();
}

void check(const Input& input) {
    const std::size_t count = input.size();
    if (input.points.size() != input.dimensions * count) complain("no whole number of points");
    if (!input.ids.empty() && input.ids.size() != count) complain("ids of another number than points");
    for (const InputColumn& column : input.columns)
        if (column.values.size() + column.words.size() != column.width * count)
            complain("values of another number than points");
    if (!input.species.empty() && input.species.size() != count) complain("species of another number than points");
    if (one_line(input.note) != input.note) complain("a note of several lines");
}

// Returns the message of a refusal; empty on success.
template <typename Read>
std::string refusal(Read read) {
    try {
        read();
        return {};
    } catch (const Failure& failure) {
        if (failure.code() != exit_code::bad_input) complain(std::string("failed: ") + failure.what());
        if (*failure.what() == 0) complain("an empty message");
        return failure.what();
    }
}

// Reads in both other ways, as clvotess does.
template <typename Read>
void read_planes(Read read, ReadRequest request) {
    for (const Dimensions dimensions : {Dimensions::either, Dimensions::two}) {
        request.dimensions = dimensions;
        (void)refusal([&] {
            Input input = read(request);
            fit_dimensions("file", request, input);
            if (dimensions == Dimensions::two && !input.planar()) complain("two dimensions are requested");
            check(input);
        });
    }
}

// Requests without columns, with optional columns, with all columns, and for another frame.
template <typename Read>
void read_all_ways(Read read, bool frames = false) {
    const auto with = [&](const ReadRequest& request) { (void)refusal([&] { check(read(request)); }); };
    with({});
    read_planes(read, {});
    ReadRequest wishes;
    wishes.columns = {"r", "radius", "4"};
    with(wishes);
    wishes.columns_may_lack = true;
    with(wishes);
    wishes.columns.clear();
    wishes.all_columns = wishes.species = true;
    with(wishes);
    wishes.all_columns = false;
    wishes.columns = {"species", "2"};
    wishes.first_carried = 0;
    with(wishes);
    if (!frames) return;
    wishes.frame = 1;
    with(wishes);
}

// A file for readers that open a path, in memory if /dev/shm exists.
class MemoryFile {
public:
    explicit MemoryFile(std::string_view bytes) {
        const std::filesystem::path shared = "/dev/shm";
        path_ = (exists(shared) ? shared : std::filesystem::temp_directory_path()) / "votess_fuzz_XXXXXX";
        const int descriptor = mkstemp(path_.data());
        if (descriptor < 0 || write(descriptor, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
            std::abort();
        close(descriptor);
    }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    ~MemoryFile() { unlink(path_.c_str()); }
    [[nodiscard]] const std::string& path() const { return path_; }

private:
    std::string path_;
};

using Parser = Input (*)(std::string_view, const std::string&, const ReadRequest&);

template <Parser parser>
void parse(std::string_view bytes) {
    read_all_ways([&](const ReadRequest& request) { return parser(bytes, "file", request); });
}

// Frames in one pass must equal single ones.
using Opener = std::unique_ptr<InputFrames> (*)(std::string_view, const ReadRequest&);
template <Opener opener>
void parse_frames(std::string_view bytes) {
    std::vector<Input> all;
    (void)refusal([&] {
        const auto frames = opener(bytes, {});
        Input frame;
        while (frames && frames->next(frame)) {
            check(frame);
            all.push_back(frame);
        }
    });
    constexpr std::size_t max_tried = 4;
    for (std::size_t k = 0; k < std::min(all.size(), max_tried); ++k) {
        Input one;
        const std::string refused = refusal([&] { one = read_frame(*opener(bytes, {}), k); });
        // What follows the frame may be refused.
        if (refused.empty() && (one.frame != all[k].frame || one.ids != all[k].ids ||
                                one.points.size() != all[k].points.size() || one.timestep != all[k].timestep))
            complain("frame " + std::to_string(k) + " differs from that of a pass");
    }
    (void)refusal([&] {
        Input last;
        const auto frames = opener(bytes, {});
        if (frames && frames->last(last)) check(last);
    });
}

std::unique_ptr<InputFrames> open_xyz_bytes(std::string_view bytes, const ReadRequest& request) {
    auto source = std::make_unique<TextSource>(bytes, "file");
    std::string head;
    return open_xyz_frames(source, request, head);
}
std::unique_ptr<InputFrames> open_dump_bytes(std::string_view bytes, const ReadRequest& request) {
    return open_dump_frames(std::make_unique<TextSource>(bytes, "file"), request);
}
void parse_xyz(std::string_view bytes) {
    const auto read = [&](const ReadRequest& request) {
        return read_xyz(std::make_unique<TextSource>(bytes, "file"), request);
    };
    read_all_ways(read, true);
    parse_frames<open_xyz_bytes>(bytes);
}
void parse_dump(std::string_view bytes) {
    read_all_ways(
        [&](const ReadRequest& request) {
            return read_frame(*open_dump_bytes(bytes, request), request.frame.value_or(0));
        },
        true);
    parse_frames<open_dump_bytes>(bytes);
}

// Rows in pieces must equal those of the whole text, and so must refusals, which may come earlier.
template <TextKind kind>
void parse_rows(std::string_view bytes) {
    read_all_ways([&](const ReadRequest& request) { return parse_text(bytes, kind, "file", request); });
    const MemoryFile file(bytes);
    Input whole, joined;
    const std::string refused = refusal([&] { whole = parse_text(bytes, kind, file.path()); });
    const std::string in_pieces = refusal([&] {
        const auto pieces = open_text(file.path(), kind, {}, 1);
        for (Input piece; pieces->next(piece);) {
            check(piece);
            joined.points.insert(joined.points.end(), piece.points.begin(), piece.points.end());
            joined.ids.insert(joined.ids.end(), piece.ids.begin(), piece.ids.end());
        }
    });
    if (refused != in_pieces) complain("whole: '" + refused + "', in pieces: '" + in_pieces + "'");
    const bool equal = whole.points.size() == joined.points.size() && whole.ids == joined.ids &&
                       (whole.points.empty() || std::memcmp(whole.points.data(), joined.points.data(),
                                                            whole.points.size() * sizeof(double)) == 0);
    if (refused.empty() && !equal) complain("rows in pieces differ from those of the whole");
}

void parse_gz(std::string_view bytes) {
    const MemoryFile file(bytes);
    (void)refusal([&] {
        TextSource source(file.path(), true);
        check(parse_text(rest_of(source), TextKind::plain, "file"));
    });
}

void parse_npy(std::string_view bytes) {
    const MemoryFile file(bytes);
    (void)refusal([&] { check(read_npy(file.path())); });
    ReadRequest part;
    part.share = {1, 3};
    (void)refusal([&] { check(read_npy(file.path(), part)); });
    read_planes([&](const ReadRequest& request) { return read_npy(file.path(), request); }, part);
    (void)refusal([&] {
        const auto pieces = open_npy(file.path(), {}, 2);
        for (Input piece; pieces->next(piece);) check(piece);
    });
}

using SurfaceParser = Surface (*)(std::string_view, const std::string&);
template <SurfaceParser parser>
void parse_surface(std::string_view bytes) {
    (void)refusal([&] {
        const Surface surface = parser(bytes, "file");
        if (surface.vertices.size() % 3 != 0 || surface.triangles.size() % 3 != 0) complain("no whole triangles");
        for (const std::int32_t v : surface.triangles)
            if (v < 0 || static_cast<std::size_t>(v) >= surface.vertices.size() / 3) complain("no such vertex");
    });
}

// The C library also rounds correctly, and accepts more texts.
void read_number(std::string_view bytes) {
    const auto value = read_double(bytes);
    if (!value) return;
    const std::string text(bytes);
    const double expected = std::strtod(text.c_str(), nullptr);
    if (*value != expected && !(std::isnan(*value) && std::isnan(expected)))
        complain("'" + text + "' is read as " + to_text(*value) + ", not " + to_text(expected));
}

#if VOTESS_FUZZ_HDF5
void parse_hdf5(std::string_view bytes) {
    const MemoryFile file(bytes);
    ReadRequest all;
    all.all_columns = true;
    (void)refusal([&] { check(clvotess_hdf5.read(file.path(), all)); });
    read_planes([&](const ReadRequest& request) { return clvotess_hdf5.read(file.path(), request); }, all);
    (void)refusal([&] {
        const auto frames = clvotess_hdf5.open_frames(file.path(), {});
        for (Input frame; frames->passed() < 4 && frames->next(frame);) check(frame);
    });
    (void)refusal([&] {
        const auto pieces = clvotess_hdf5.open(file.path(), {}, 2);
        for (Input piece; pieces->next(piece);) check(piece);
    });
}
#endif

using Target = void (*)(std::string_view bytes);

const std::map<std::string, Target>& targets() {
    static const std::map<std::string, Target> all {
        {"number", read_number}, {"text", parse_rows<TextKind::plain>}, {"csv", parse_rows<TextKind::csv>},
            {"gz", parse_gz}, {"xyz", parse_xyz}, {"poscar", parse<parse_poscar>}, {"tess", parse<parse_tess>},
            {"lammps_dump", parse_dump}, {"lammps_data", parse<parse_lammps_data>}, {"ply", parse<parse_ply>},
            {"npy", parse_npy}, {"npz", parse<parse_npz>}, {"off", parse_surface<parse_off>},
            {"obj", parse_surface<parse_obj>}, {"stl", parse_surface<parse_stl>},
            {"ply_mesh", parse_surface<parse_ply_surface>}, {"glb", parse_surface<parse_glb>},
#if VOTESS_FUZZ_HDF5
            {"hdf5", parse_hdf5},
#endif
    };
    return all;
}

Target chosen = nullptr;

}  // namespace

bool choose_reader(const std::string& name) {
    const auto found = targets().find(name);
    if (found != targets().end()) chosen = found->second;
    return found != targets().end();
}

std::string reader_names() {
    std::string names;
    for (const auto& [name, target] : targets()) add_name(names, name);
    return names;
}

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    const char* const name = std::getenv("VOTESS_FUZZ_READER");
    if (name && choose_reader(name)) return 0;
    std::fprintf(stderr, "VOTESS_FUZZ_READER must be one of: %s\n", reader_names().c_str());
    std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    chosen({reinterpret_cast<const char*>(data), size});
    return 0;
}

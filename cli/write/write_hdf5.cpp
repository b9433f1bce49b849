// HDF5: the arrays of .npz as datasets at the root. HDF5 opens the temporary file by its path.
#include <algorithm>
#include <array>
#include <cerrno>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "failure.hpp"
#include "files/formats/hdf5_handles.hpp"
#include "files/output_file.hpp"
#include "interrupt.hpp"
#include "queries/grid_files.hpp"
#include "write/hdf5_share.hpp"
#include "write/output.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

hid_t hdf5_type(NumberType type) {
    const std::array<hid_t, 10> types{H5T_STD_I8LE,  H5T_STD_U8LE,  H5T_STD_I16LE, H5T_STD_U16LE,  H5T_STD_I32LE,
                                      H5T_STD_U32LE, H5T_STD_I64LE, H5T_STD_U64LE, H5T_IEEE_F32LE, H5T_IEEE_F64LE};
    return types[static_cast<std::size_t>(type)];
}

// Returns the type of an array: of numbers, or of texts of equal length.
Hdf5Handle hdf5_type(const ResultArray& array) {
    if (array.text == 0) return {H5Tcopy(hdf5_type(array.type)), H5Tclose};
    Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type.id(), array.text);
    H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
    return type;
}

// Returns access by the driver stdio. The default driver resolves the name of a file, and an unnamed file has none.
Hdf5Handle access_by_stdio() {
    Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (!access.valid() || H5Pset_fapl_stdio(access.id()) < 0)
        throw runtime_failure("HDF5 lacks its driver stdio: use another build of HDF5");
    return access;
}

class Hdf5Writer {
public:
    explicit Hdf5Writer(OutputFile& output)
        : Hdf5Writer(output.path_for_library(), access_by_stdio().id(),
                     [&output](int error) { return output.write_failure(error); }) {}

    // access: how HDF5 opens the file. failure: returns the exception for an errno.
    Hdf5Writer(const std::string& path, hid_t access, std::function<Failure(int)> failure)
        : failure_(std::move(failure)) {
        const Hdf5Handle creation = without_times(H5P_FILE_CREATE);
        file_ = {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.id(), access), H5Fclose};
        require(file_.valid());
        place_ = file_.id();
    }

    // Places all following arrays and attributes into a new group, until it is closed.
    [[nodiscard]] Hdf5Handle open_group(const std::string& name) {
        const Hdf5Handle creation = without_times(H5P_GROUP_CREATE);
        Hdf5Handle group(H5Gcreate2(file_.id(), name.c_str(), H5P_DEFAULT, creation.id(), H5P_DEFAULT), H5Gclose);
        require(group.valid());
        place_ = group.id();
        return group;
    }
    void close_group(Hdf5Handle& group) {
        place_ = file_.id();
        close(group);
    }

    void add(const ResultArray& array) {
        Hdf5Handle set = create(array, array.rows());
        write(set, array, 0);
        close(set);
    }

    void close(Hdf5Handle& set) { require(set.close()); }

    [[nodiscard]] Hdf5Handle create(const ResultArray& array, hsize_t rows) {
        const std::array<hsize_t, 2> extent{rows, array.columns};
        return create(std::string(array.name), hdf5_type(array).id(),
                      std::span(extent).first(array.columns == 1 ? 1 : 2));
    }

    // Writes the rows of the array into the dataset, from row `first` on.
    void write(const Hdf5Handle& set, const ResultArray& array, hsize_t first) {
        const Hdf5Handle space(H5Dget_space(set.id()), H5Sclose);
        const int rank = array.columns == 1 ? 1 : 2;
        constexpr std::size_t piece_bytes = std::size_t{64} << 20;  // Ctrl-C works between pieces
        const std::size_t row_bytes = array.item() * array.columns;
        const Hdf5Handle type = hdf5_type(array);
        const hsize_t piece = piece_bytes / row_bytes;
        for (hsize_t row = 0; row < array.rows(); row += piece) {
            throw_if_interrupted();
            const std::array<hsize_t, 2> start{first + row, 0};
            const std::array<hsize_t, 2> count{std::min(piece, array.rows() - row), array.columns};
            const Hdf5Handle memory(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
            require(H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >= 0);
            require(H5Dwrite(set.id(), type.id(), memory.id(), space.id(), H5P_DEFAULT,
                             array.bytes.data() + row * row_bytes) >= 0);
        }
    }

    void add_grid(const GridOutput& grid) {
        const std::vector<std::uint64_t> shape = grid.shape();
        const std::vector<hsize_t> extent(shape.begin(), shape.end());
        Hdf5Handle set = create("grid", H5T_IEEE_F64LE, extent);
        require(H5Dwrite(set.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, grid.numbers.data()) >= 0);
        require(set.close());
    }

    void add_domain(const votess::Tessellation& tessellation) {
        const DomainArrays domain(tessellation);
        for (const ResultArray& array : domain.all()) {
            if (array.name == "walls") {  // an attribute holds at most 64 kB
                add(array);
            } else {
                add_attribute(array);
            }
        }
    }

    void add_attribute(const ResultArray& array) {
        const std::array<hsize_t, 2> extent{array.rows(), array.columns};
        const Hdf5Handle space(H5Screate_simple(array.columns == 1 ? 1 : 2, extent.data(), nullptr), H5Sclose);
        write_attribute(std::string(array.name), hdf5_type(array.type), space, array.bytes.data());
    }

    void add_attribute(const std::string& name, double value) {
        write_attribute(name, H5T_IEEE_F64LE, {H5Screate(H5S_SCALAR), H5Sclose}, &value);
    }

    void add_attribute(const std::string& name, const std::string& text) {
        const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
        require(H5Tset_size(type.id(), text.size() + 1) >= 0);
        write_attribute(name, type.id(), space, text.c_str());
    }

    void finish() {
        errno = 0;
        require(file_.close());
    }

private:
    // No times of creation, so that equal results give equal files.
    Hdf5Handle without_times(hid_t of) {
        Hdf5Handle creation(H5Pcreate(of), H5Pclose);
        require(H5Pset_obj_track_times(creation.id(), false) >= 0);
        return creation;
    }
    // extent: of its axes.
    Hdf5Handle create(const std::string& name, hid_t type, std::span<const hsize_t> extent) {
        const Hdf5Handle space(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
        const Hdf5Handle creation = without_times(H5P_DATASET_CREATE);
        Hdf5Handle set(H5Dcreate2(place_, name.c_str(), type, space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT),
                       H5Dclose);
        require(set.valid());
        return set;
    }
    void write_attribute(const std::string& name, hid_t type, const Hdf5Handle& space, const void* values) {
        Hdf5Handle attribute(H5Acreate2(place_, name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
        require(attribute.valid() && H5Awrite(attribute.id(), type, values) >= 0 && attribute.close());
    }

    void require(bool done) {
        if (!done) throw failure_(errno);
    }

    std::function<Failure(int)> failure_;
    Hdf5Handle file_;
    hid_t place_ = H5I_INVALID_HID;  // the file or a group
};

void add_attributes(Hdf5Writer& writer, const votess::Tessellation& domain, const std::vector<Attribute>& attributes) {
    writer.add_domain(domain);
    for (const Attribute& attribute : attributes)
        std::visit([&](const auto& value) { writer.add_attribute(attribute.name, value); }, attribute.value);
}

void finish_file(Hdf5Writer& writer, const votess::Tessellation& domain, const std::vector<Attribute>& attributes) {
    add_attributes(writer, domain, attributes);
    writer.finish();
}

// Writes a group for each frame, with the arrays and attributes of a file of that frame alone, and its number.
class Hdf5FramesFile : public FramesFile {
public:
    explicit Hdf5FramesFile(OutputFile& file) : writer_(file) {}

    void add(const OutputData& data) override {
        begin_hdf5();  // on the thread that writes
        const std::uint64_t number = data.input.frame.value_or(0);
        std::string digits = std::to_string(number);
        constexpr std::size_t width = 6;
        digits.insert(0, width - std::min(width, digits.size()), '0');
        Hdf5Handle group = writer_.open_group("frame_" + digits);
        for (const ResultArray& array : result_arrays(data)) writer_.add(array);
        std::vector<Attribute> attributes = attributes_of(data.input.units, data.domain_from);
        attributes.push_back({"frame", static_cast<double>(number)});
        if (!data.input.timestep.empty()) attributes.push_back({"timestep", data.input.timestep});
        add_attributes(writer_, data.tessellation, attributes);
        writer_.close_group(group);
    }
    void finish() override {
        writer_.add_attribute("version", std::string(VOTESS_VERSION_STRING));
        writer_.finish();
    }

private:
    Hdf5Writer writer_;
};

// Creates all datasets before it writes more rows than the first ones. So the file equals one that is written at once.
class StreamedHdf5 : public StreamedFile {
public:
    explicit StreamedHdf5(OutputFile& file) : writer_(file) {}

    void add(const ResultArray& first, std::uint64_t rows) override {
        sets_.push_back(writer_.create(first, rows));
        writer_.write(sets_.back(), first, 0);
    }
    void write(std::size_t number, std::uint64_t row, const ResultArray& rows) override {
        writer_.write(sets_[number], rows, row);
    }
    void finish(const votess::Tessellation& domain, const std::vector<Attribute>& attributes) override {
        for (Hdf5Handle& set : sets_) writer_.close(set);
        finish_file(writer_, domain, attributes);
    }

private:
    Hdf5Writer writer_;
    std::vector<Hdf5Handle> sets_;
};

}  // namespace

void write_hdf5(OutputFile& file, const OutputData& data) {
    begin_hdf5();
    Hdf5Writer writer(file);
    for (const ResultArray& array : result_arrays(data)) writer.add(array);
    finish_file(writer, data.tessellation, attributes_of(data.input.units, data.domain_from));
}

std::unique_ptr<FramesFile> create_hdf5_frames(OutputFile& file) {
    begin_hdf5();
    return std::make_unique<Hdf5FramesFile>(file);
}

std::unique_ptr<StreamedFile> create_hdf5(OutputFile& file) {
    begin_hdf5();
    return std::make_unique<StreamedHdf5>(file);
}

void write_hdf5_share(const Hdf5Share& share) {
    begin_hdf5();
    std::optional<Hdf5Writer> writer;
    share.together([&] { writer.emplace(share.path, share.access, share.failure); });
    for (const SharedArray& array : share.arrays) {
        Hdf5Handle set;
        share.together([&] { set = writer->create(array.own, array.rows); });
        share.together([&] { writer->write(set, array.own, array.first); });
        share.together([&] { writer->close(set); });
    }
    share.together([&] { finish_file(*writer, share.domain, share.attributes); });
}

// Writes a dataset `grid`. The domain, the method and the names of the columns are attributes of the root.
void write_grid_hdf5(OutputFile& file, const GridOutput& grid) {
    begin_hdf5();
    Hdf5Writer writer(file);
    writer.add_grid(grid);
    writer.add_domain(grid.domain);
    std::string columns;
    for (const std::string& name : grid.names) columns += (columns.empty() ? "" : ",") + name;
    const std::string axis = grid.options.project ? std::string(1, "xyz"[*grid.options.project]) : "";
    for (const auto& [name, text] : {std::pair<std::string, std::string>{"columns", columns},
                                     {"method", grid.method},
                                     {"project", axis},
                                     {"domain_from", word_of(grid.domain_from.box)},
                                     {"periodic_from", word_of(grid.domain_from.periodic)},
                                     {"version", VOTESS_VERSION_STRING}})
        writer.add_attribute(name, text);
    writer.finish();
}

void write_arrays_hdf5(OutputFile& file, std::span<const ResultArray> arrays) {
    begin_hdf5();
    Hdf5Writer writer(file);
    for (const ResultArray& array : arrays) writer.add(array);
    writer.add_attribute("version", std::string(VOTESS_VERSION_STRING));
    writer.finish();
}

}  // namespace clvotess

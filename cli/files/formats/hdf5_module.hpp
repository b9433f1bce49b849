// HDF5 lies in a module, clvotess_hdf5, which is loaded when a file needs it: its library brings thirty others, whose
// loading would take most of the time of a short run.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace clvotess {

struct GridOutput;
struct Input;
struct OutputData;
class InputPieces;
class OutputFile;
class StreamedFile;
struct ReadRequest;

// What the module offers, under its own name. It calls functions of the program, which exports them.
struct Hdf5Module {
    Input (*read)(const std::string& path, const ReadRequest& request);
    std::unique_ptr<InputPieces> (*open)(const std::string& path, const ReadRequest& request, std::size_t rows);
    void (*write)(OutputFile& file, const OutputData& data);
    std::unique_ptr<StreamedFile> (*create)(OutputFile& file);
    void (*write_grid)(OutputFile& file, const GridOutput& grid);
};

// Throws Failure when the module cannot be loaded; `task`, such as "cannot read 'a.h5'", begins the message.
const Hdf5Module& load_hdf5(const std::string& task);

}  // namespace clvotess

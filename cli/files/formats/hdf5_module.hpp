// The module clvotess_hdf5, which holds all calls of HDF5. It is loaded when a file needs it: HDF5 brings thirty other
// libraries, and loading them would dominate a short run.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

// The symbol of the module's functions. In the module its name ends with a digest of all headers, so that a program
// does not call a module of another build, whose types may differ.
#ifndef CLVOTESS_HDF5_SYMBOL
#define CLVOTESS_HDF5_SYMBOL clvotess_hdf5
#endif

namespace clvotess {

struct GridOutput;
struct Input;
struct OutputData;
class FramesFile;
class InputFrames;
class InputPieces;
class OutputFile;
class StreamedFile;
struct ReadRequest;
struct ResultArray;

// The functions of the module. They call functions that the program exports.
struct Hdf5Module {
    Input (*read)(const std::string& path, const ReadRequest& request);
    std::unique_ptr<InputPieces> (*open)(const std::string& path, const ReadRequest& request, std::size_t rows);
    std::unique_ptr<InputFrames> (*open_frames)(const std::string& path, const ReadRequest& request);
    void (*write)(OutputFile& file, const OutputData& data);
    std::unique_ptr<StreamedFile> (*create)(OutputFile& file);
    std::unique_ptr<FramesFile> (*create_frames)(OutputFile& file);
    void (*write_grid)(OutputFile& file, const GridOutput& grid);
    void (*write_arrays)(OutputFile& file, std::span<const ResultArray> arrays);
};

// Throws Failure when the module cannot be loaded; `task`, such as "cannot read 'a.h5'", begins the message.
const Hdf5Module& load_hdf5(const std::string& task);

}  // namespace clvotess

// The numbers of a <DataArray> in VTK's XML files: as text, in base64 beside the tag, or appended behind the XML, raw
// or in base64; plain or in blocks packed by zlib.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "files/binary_numbers.hpp"

namespace clvotess {

// How the file writes binary numbers: attributes of <VTKFile>, and what follows <AppendedData>.
struct VtkLayout {
    bool swapped = false;       // big-endian
    bool wide_headers = false;  // of 64 bits
    bool packed = false;        // in blocks, by zlib
    bool appended_raw = false;
    std::string_view appended;  // behind the mark _
};

struct VtkArray {
    std::string name;
    NumberType type = NumberType::float64;
    enum class Place { text, inline_binary, appended } place = Place::text;
    std::uint64_t components = 1;
    std::uint64_t offset = 0;  // of appended data
    std::string_view content;  // between the tags
};

// `count` numbers, each as float64 or as a whole number. `where` is for messages. Throws Failure.
[[nodiscard]] std::vector<double> load_floats(const VtkArray& array, const VtkLayout& layout, std::uint64_t count,
                                              const std::string& where);
[[nodiscard]] std::vector<std::int64_t> load_wholes(const VtkArray& array, const VtkLayout& layout, std::uint64_t count,
                                                    const std::string& where);

}  // namespace clvotess

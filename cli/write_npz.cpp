// NumPy's .npz: a zip archive of .npy members, uncompressed, so that it can be read and written at the speed of memory.
#include <array>
#include <bit>
#include <string>

#include "atomic_file.hpp"
#include "output.hpp"
#include "zip_writer.hpp"

namespace clvotess {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they lie in memory");

std::string npy_header(std::string_view type, const std::string& shape) {
    std::string dict = "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': " + shape + ", }";
    constexpr std::size_t start_size = 10, alignment = 64;
    const std::size_t unpadded = start_size + dict.size() + 1;
    dict.append((alignment - unpadded % alignment) % alignment, ' ');
    dict += '\n';
    std::string header("\x93NUMPY\x01\x00", 8);
    header += static_cast<char>(dict.size() & 0xff);
    header += static_cast<char>(dict.size() >> 8);
    return header + dict;
}

template <typename Number>
void add_array(ZipWriter& zip, const std::string& name, std::string_view type, std::span<const Number> values,
               std::size_t columns = 1) {
    const std::string rows = std::to_string(values.size() / columns);
    const std::string shape = columns == 1 ? "(" + rows + ",)" : "(" + rows + ", " + std::to_string(columns) + ")";
    const std::string header = npy_header(type, shape);
    const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    zip.add(name + ".npy", std::array{std::string_view(header), bytes});
}

}  // namespace

void write_npz(OutputFile& file, const OutputData& data) {
    const votess::Tessellation& cells = data.tessellation;
    ZipWriter zip(file);
    if (data.wanted.neighbors) {
        add_array(zip, "indptr", "<i8", cells.indptr());
        add_array(zip, "indices", "<i4", cells.indices());
    }
    if (data.wanted.areas) add_array(zip, "face_areas", "<f8", cells.face_areas());
    if (data.wanted.volumes) add_array(zip, "volumes", "<f8", cells.volumes());
    if (data.wanted.centroids) add_array(zip, "centroids", "<f8", cells.centroids(), 3);
    add_array(zip, "status", "|u1", cells.status());
    if (!cells.duplicate_of().empty()) add_array(zip, "duplicate_of", "<i4", cells.duplicate_of());
    zip.finish();
}

}  // namespace clvotess

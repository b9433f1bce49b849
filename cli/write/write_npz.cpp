// NumPy's .npz: a zip archive of .npy members, uncompressed for speed.
#include <array>
#include <string>

#include "files/formats/npy_array.hpp"
#include "files/formats/zip_writer.hpp"
#include "files/output_file.hpp"
#include "write/output.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

std::string_view numpy_type(NumberType type) {
    constexpr std::array<std::string_view, 10> names{"|i1", "|u1", "<i2", "<u2", "<i4",
                                                     "<u4", "<i8", "<u8", "<f4", "<f8"};
    return names[static_cast<std::size_t>(type)];
}

class NpzWriter {
public:
    explicit NpzWriter(OutputFile& file) : zip_(file) {}

    void add(std::string_view name, std::string_view type, std::span<const std::uint64_t> shape,
             std::string_view bytes) {
        const std::string header = npy_header(type, shape);
        zip_.add(std::string(name) + ".npy", std::array{std::string_view(header), bytes});
    }
    void add(std::span<const ResultArray> arrays) {
        for (const ResultArray& array : arrays) {
            const std::array<std::uint64_t, 2> shape{array.rows(), array.columns};
            const std::string text = "|S" + std::to_string(array.text);
            add(array.name, array.text > 0 ? std::string_view(text) : numpy_type(array.type),
                std::span(shape).first(array.columns == 1 ? 1 : 2), array.bytes);
        }
    }
    void finish() { zip_.finish(); }

private:
    ZipWriter zip_;
};

}  // namespace

void write_npz_arrays(OutputFile& file, std::span<const ResultArray> arrays) {
    NpzWriter npz(file);
    npz.add(arrays);
    npz.finish();
}

void write_npz(OutputFile& file, const OutputData& data) {
    NpzWriter npz(file);
    npz.add(result_arrays(data));
    npz.add(DomainArrays(data.tessellation).all());
    for (const auto& [name, value] : attributes_of(data.input.units, data.domain_from)) {
        if (const double* const number = std::get_if<double>(&value)) {
            npz.add(name, "<f8", {}, {reinterpret_cast<const char*>(number), sizeof *number});
            continue;
        }
        std::string letters;  // NumPy's text has four bytes a letter
        for (const char c : std::get<std::string>(value)) letters += {c, '\0', '\0', '\0'};
        npz.add(name, "<U" + std::to_string(letters.size() / 4), {}, letters);
    }
    npz.finish();
}

}  // namespace clvotess

#include "queries/grid_files.hpp"

#include <algorithm>

#include "failure.hpp"
#include "files/formats/hdf5_module.hpp"
#include "files/formats/npy_array.hpp"
#include "files/formats/png.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

void write_npy(OutputFile& file, const GridOutput& grid) {
    file.write(npy_header("<f8", grid.shape()));
    file.write(bytes_of(grid.numbers));
}

std::string xml_escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
    }
    return result;
}

// Writes VTK's image data: numbers of grid cells, x fastest. A projected axis has one cell, as long as the box.
void write_vti(OutputFile& file, const GridOutput& grid) {
    std::array<std::size_t, 3> cells = grid.options.shape;
    if (grid.options.project) cells[static_cast<std::size_t>(*grid.options.project)] = 1;
    const votess::Box& box = grid.domain.box();
    std::string extent, origin, spacing;
    for (std::size_t k = 0; k < 3; ++k) {
        const bool flat = k == 2 && grid.domain.planar();
        if (k > 0) extent += ' ', origin += ' ', spacing += ' ';
        extent += "0 ";
        extent += flat ? "0" : std::to_string(cells[k]);
        origin += to_text(box.lower[k]);
        spacing += flat ? "1" : to_text((box.upper[k] - box.lower[k]) / static_cast<double>(cells[k]));
    }
    const std::uint64_t bytes = cells[0] * cells[1] * cells[2] * sizeof(double);
    std::string head =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<ImageData WholeExtent=\"" +
        extent + "\" Origin=\"" + origin + "\" Spacing=\"" + spacing + "\">\n<Piece Extent=\"" + extent +
        "\">\n<CellData>\n";
    for (std::size_t c = 0; c < grid.names.size(); ++c)
        head += "<DataArray type=\"Float64\" Name=\"" + xml_escaped(grid.names[c]) +
                "\" format=\"appended\" offset=\"" + std::to_string(c * (sizeof bytes + bytes)) + "\"/>\n";
    OutputBuffer out;
    const auto flush = [&] {
        file.write(out.bytes());
        out.clear();
    };
    out.put(head + "</CellData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_");
    for (std::size_t c = 0; c < grid.names.size(); ++c) {
        out.put_binary(bytes);
        for (std::size_t z = 0; z < cells[2]; ++z) {
            for (std::size_t y = 0; y < cells[1]; ++y)
                for (std::size_t x = 0; x < cells[0]; ++x)
                    out.put_binary(grid.numbers[((x * cells[1] + y) * cells[2] + z) * grid.names.size() + c]);
            flush();
        }
    }
    out.put("\n</AppendedData>\n</VTKFile>\n");
    flush();
}

// Whether the edges of a cell lie along the axes.
bool is_upright(const votess::TriclinicBox& cell) {
    const auto& [origin, a, b, c, periodic] = cell;
    return a == std::array{a[0], 0.0, 0.0} && b == std::array{0.0, b[1], 0.0} && c == std::array{0.0, 0.0, c[2]} &&
           a[0] > 0 && b[1] > 0 && c[2] > 0;
}

}  // namespace

std::vector<std::uint64_t> GridOutput::shape() const {
    std::vector<std::uint64_t> shape;
    for (int k = 0; k < static_cast<int>(size_of_vectors(domain)); ++k)
        if (k != options.project) shape.push_back(options.shape[static_cast<std::size_t>(k)]);
    if (options.columns > 1) shape.push_back(options.columns);
    return shape;
}

void check_grid_outputs(const std::vector<std::string>& outputs, bool has_image, const std::string& input) {
    if (outputs.empty() && !has_image)
        throw bad_input("--to-grid needs an output: add -o FILE.npy, FILE.h5 or FILE.vti, or --image FILE.png");
    for (const std::string& path : outputs) {
        if (path == "-" || !(names_hdf5(path) || extension_of(path) == ".npy" || extension_of(path) == ".vti"))
            throw bad_input("--to-grid writes .npy, .h5 and .vti, not " + in_quotes(path));
        if (names_hdf5(path)) check_hdf5(path);
    }
    check_paths(outputs, {input});
}

void check_grid_domain(const std::vector<std::string>& outputs, const votess::Tessellation& domain) {
    for (const std::string& path : outputs)
        if (domain.cell() && !is_upright(*domain.cell()) && extension_of(path) == ".vti")
            throw bad_input(in_quotes(path) + ": .vti cannot hold the grid of a skewed cell: write .npy or .h5");
}

void write_grid(OutputFile& file, const std::string& path, const GridOutput& grid) {
    if (names_hdf5(path)) return load_hdf5("cannot write HDF5").write_grid(file, grid);
    if (extension_of(path) == ".vti") return write_vti(file, grid);
    write_npy(file, grid);
}

std::string draw_grid(const GridOutput& grid, votess::Colormap colormap) {
    const std::vector<std::uint64_t> shape = grid.shape();
    votess::PictureOptions options;
    options.values = grid.numbers;
    options.colormap = colormap;
    const std::vector<std::uint8_t> colors = votess::value_colors(options);
    votess::Picture picture;
    picture.width = static_cast<std::uint32_t>(shape[0]);
    picture.height = static_cast<std::uint32_t>(shape[1]);
    for (std::size_t y = shape[1]; y-- > 0;)
        for (std::size_t x = 0; x < shape[0]; ++x) {
            const std::uint8_t* const rgb = &colors[3 * (x * shape[1] + y)];
            picture.pixels.insert(picture.pixels.end(), {rgb[0], rgb[1], rgb[2], 255});
        }
    return to_png(picture);
}

}  // namespace clvotess

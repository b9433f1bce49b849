// VTK's XML files of points: .vtp (PolyData) and .vtu (UnstructuredGrid). Points and, by name, columns of PointData.
#include <algorithm>
#include <optional>

#include "failure.hpp"
#include "files/formats/vtk_data.hpp"
#include "files/formats/xml_scanner.hpp"
#include "files/inflate.hpp"
#include "files/limits.hpp"
#include "files/numbers.hpp"
#include "interrupt.hpp"
#include "read/input.hpp"

namespace clvotess {
namespace {

struct Piece {
    std::uint64_t count = 0;
    std::optional<VtkArray> points;
    std::vector<VtkArray> columns;
};

class VtkReader {
public:
    VtkReader(std::string_view bytes, const std::string& name, const ReadRequest& request)
        : bytes_(bytes), name_(name), request_(request), scanner_(bytes, name) {}

    Input read() {
        read_tags();
        Input input;
        for (const Piece& piece : pieces_) append(piece, input);
        if (!input.ids.empty() && input.ids.size() != input.size()) input.ids.clear();  // only in some of the pieces
        return input;
    }

private:
    [[nodiscard]] Failure error(const std::string& message) const { return bad_input(name_ + ": " + message); }

    void read_tags() {
        XmlTag tag;
        bool is_vtk = false, closed = false;
        std::string_view section;  // Points or PointData, inside a piece
        while (!closed && scanner_.next(tag)) {
            throw_if_interrupted();
            if (!is_vtk) {
                if (tag.name != "VTKFile" || !tag.opens) throw error("not a VTK file in XML");
                is_vtk = true;
                read_layout(tag);
            } else if (tag.name == "AppendedData" && tag.opens) {
                read_appended(tag);
                closed = true;
            } else if (tag.name == "VTKFile" && tag.closes) {
                closed = true;
            } else if (tag.name == "Piece" && tag.opens) {
                const auto count = read_uint64(tag["NumberOfPoints"]);
                if (!count) throw error("a <Piece> has no valid NumberOfPoints");
                pieces_.push_back({*count, {}, {}});
                count_array();
            } else if (tag.name == "Points" || tag.name == "PointData") {
                section = tag.closes ? std::string_view{} : tag.name;
            } else if (tag.name == "DataArray" && tag.opens && !section.empty() && !pieces_.empty()) {
                read_array(tag, section == "Points");
            }
        }
        if (!is_vtk) throw error("not a VTK file in XML");
        if (!closed) throw error("the file ends too early");
    }

    void read_layout(const XmlTag& tag) {
        if (tag["type"] != "PolyData" && tag["type"] != "UnstructuredGrid") {
            throw error("a VTK file of type " + in_quotes(tag["type"]) + ", expected PolyData or UnstructuredGrid");
        }
        layout_.swapped = tag["byte_order"] == "BigEndian";
        layout_.wide_headers = tag["header_type"] == "UInt64";
        const std::string_view packer = tag["compressor"];
        if (!packer.empty() && packer != "vtkZLibDataCompressor") {
            throw error("packed by " + in_quotes(packer) + ", only vtkZLibDataCompressor is supported");
        }
        layout_.packed = !packer.empty();
    }

    void read_appended(const XmlTag& tag) {
        const std::string_view encoding = tag["encoding"];
        if (encoding != "raw" && encoding != "base64") {
            throw error("appended data in the encoding " + in_quotes(encoding) + ", expected raw or base64");
        }
        layout_.appended_raw = encoding == "raw";
        const auto mark = bytes_.find('_', tag.end);
        if (mark == std::string_view::npos) throw error("the file ends too early");
        layout_.appended = bytes_.substr(mark + 1);
    }

    void read_array(const XmlTag& tag, bool is_points) {
        using enum NumberType;
        constexpr std::pair<std::string_view, NumberType> types[] = {
            {"Int8", int8},     {"UInt8", uint8}, {"Int16", int16},   {"UInt16", uint16},   {"Int32", int32},
            {"UInt32", uint32}, {"Int64", int64}, {"UInt64", uint64}, {"Float32", float32}, {"Float64", float64}};
        const auto* const type =
            std::find_if(std::begin(types), std::end(types), [&](const auto& t) { return t.first == tag["type"]; });
        if (type == std::end(types)) {
            if (!is_points) return;  // strings and the like
            throw error("points of type " + in_quotes(tag["type"]));
        }
        count_array();
        VtkArray array;
        array.name = tag["Name"];
        array.type = type->second;
        const std::string_view components = tag["NumberOfComponents"];
        const auto number = components.empty() ? std::optional<std::uint64_t>(1) : read_uint64(components);
        if (!number) throw error("a <DataArray> has no valid NumberOfComponents");
        array.components = *number;
        const std::string_view format = tag["format"];
        if (format == "appended") {
            array.place = VtkArray::Place::appended;
            const auto offset = read_uint64(tag["offset"]);
            if (!offset) throw error("a <DataArray> has no valid offset");
            array.offset = *offset;
        } else if (format == "binary" || format == "ascii" || format.empty()) {
            if (format == "binary") array.place = VtkArray::Place::inline_binary;
            if (!tag.closes) array.content = scanner_.content(tag.end);
        } else {
            throw error("a <DataArray> in the format " + in_quotes(format));
        }
        if (is_points) {
            pieces_.back().points = array;
        } else {
            pieces_.back().columns.push_back(array);
        }
    }

    void count_array() {
        if (++arrays_ > max_arrays)
            throw error("more than the " + std::to_string(max_arrays) + " pieces and arrays that are read");
    }

    // Several arrays may lie at one place of the file, packed or not.
    void take_budget(std::uint64_t numbers) {
        numbers_ += numbers;
        check_unpacked(bytes_.size(), numbers_ * sizeof(double), name_);
    }

    void append(const Piece& piece, Input& input) {
        if (piece.count == 0) return;
        if (!piece.points || piece.points->components != 3) {
            throw error("a <Piece> of " + std::to_string(piece.count) + " points without <Points> of 3 components");
        }
        constexpr std::uint64_t most = std::uint64_t{1} << 44;
        if (piece.count > most) throw error(std::to_string(piece.count) + " points are announced, far more than fit");
        const auto add = [](auto& to, auto&& values) {
            if (to.empty()) {
                to = std::move(values);
            } else {
                const std::size_t before = to.size();
                to.resize(before + values.size());
                std::copy(values.begin(), values.end(), to.begin() + static_cast<std::ptrdiff_t>(before));
            }
        };
        take_budget(3 * piece.count);
        add(input.points, load_floats(*piece.points, layout_, 3 * piece.count, name_ + ": points"));
        const VtkArray* const ids = find(piece, "id") ? find(piece, "id") : find(piece, "ids");
        if (ids && ids->components == 1 && !is_float(ids->type)) {
            take_budget(piece.count);
            add(input.ids, load_wholes(*ids, layout_, piece.count, name_ + ": " + ids->name));
        }
        if (input.columns.empty()) input.columns = wanted(piece);
        for (InputColumn& column : input.columns) {
            const VtkArray* const array = find(piece, column.name);
            if (!array || array->components != column.width) {
                std::string names;
                for (const VtkArray& other : piece.columns) add_name(names, other.name);
                throw error("no column " + in_quotes(column.name) +
                            " in PointData, or one of another width than before; "
                            "there are " +
                            (names.empty() ? "none" : names));
            }
            if (column.width == 0 || column.width > max_columns) throw error(column.name + " has no valid width");
            take_budget(column.width * piece.count);
            add(column.values, load_floats(*array, layout_, column.width * piece.count, name_ + ": " + array->name));
        }
    }

    // The columns that the run names, as wide as those of this piece, and all others if it says so.
    [[nodiscard]] std::vector<InputColumn> wanted(const Piece& piece) const {
        std::vector<InputColumn> columns;
        for (const std::string& name : request_.columns) {
            const VtkArray* const array = find(piece, name);
            if (!array && request_.columns_may_lack) continue;
            columns.push_back({name, array ? static_cast<std::size_t>(array->components) : 1, {}});
        }
        for (const VtkArray& array : piece.columns) {
            const bool named = std::ranges::find(columns, array.name, &InputColumn::name) != columns.end();
            if (!request_.all_columns || named || array.name == "id" || array.name == "ids") continue;
            columns.push_back({array.name, static_cast<std::size_t>(array.components), {}});
        }
        return columns;
    }

    [[nodiscard]] static const VtkArray* find(const Piece& piece, std::string_view name) {
        for (const VtkArray& array : piece.columns) {
            if (array.name == name) return &array;
        }
        return nullptr;
    }

    std::string_view bytes_;
    std::string name_;
    const ReadRequest& request_;
    XmlScanner scanner_;
    VtkLayout layout_;
    std::vector<Piece> pieces_;
    std::size_t arrays_ = 0;     // and pieces
    std::uint64_t numbers_ = 0;  // that were read
};

}  // namespace

Input parse_vtk(std::string_view bytes, const std::string& name, const ReadRequest& request) {
    return VtkReader(bytes, name, request).read();
}

}  // namespace clvotess

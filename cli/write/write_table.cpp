// Tables with a row for each seed: .csv, extended .xyz and LAMMPS .dump, in blocks of rows that threads make.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "failure.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "in_order.hpp"
#include "write/columns.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

// One or several columns of numbers or words.
struct TableColumn {
    std::string name;
    char type;  // as in extended XYZ: I, R or S
    std::size_t width;
    std::function<void(OutputBuffer& row, std::size_t i, char between)> put;
    std::shared_ptr<const void> owner = {};  // of the numbers, if they are not those of the result
};
using Table = std::vector<TableColumn>;

// Faces of 3, 4, 5, 6, and of 7 or more edges.
constexpr std::size_t index_parts = 5;

// value: returns a number by its place in the column.
template <class Value>
TableColumn of_numbers(std::string name, std::size_t width, Value value) {
    constexpr char type = std::is_floating_point_v<decltype(value(std::size_t{}))> ? 'R' : 'I';
    return {std::move(name), type, width, [=](OutputBuffer& row, std::size_t i, char between) {
                for (std::size_t k = 0; k < width; ++k) {
                    if (k > 0) row.put(between);
                    row.put_number(value(width * i + k));
                }
            }};
}
template <class Number>
TableColumn of_numbers(std::string name, std::span<const Number> values, std::size_t width = 1) {
    return of_numbers(std::move(name), width, [=](std::size_t k) { return values[k]; });
}

// Returns the centroids beside the listed points, which may lie outside of a periodic domain: the result has those of
// the seeds inside.
std::vector<double> centroids_of(const OutputData& data) {
    const std::span<const double> all = data.tessellation.centroids();
    std::vector<double> centroids(all.begin(), all.end());
    if (data.tessellation.periodic() == std::array<bool, 3>{}) return centroids;
    const std::vector<double> wrapped = votess::wrapped_points(data.tessellation, data.input.points);
    for (std::size_t k = 0; k < centroids.size(); ++k) centroids[k] += data.input.points[k] - wrapped[k];
    return centroids;
}

std::size_t neighbors_of(const votess::Tessellation& cells, std::size_t i) {
    return static_cast<std::size_t>(std::ranges::count_if(cells.neighbors(i), [](auto j) { return j >= 0; }));
}

// Writes how many faces between cells have 3, 4, 5, 6, and 7 or more edges.
TableColumn voronoi_index_of(const votess::Tessellation& cells) {
    return {"voronoi_index", 'I', index_parts,
            [indptr = cells.indptr(), indices = cells.indices(), offsets = cells.face_offsets()](
                OutputBuffer& row, std::size_t i, char between) {
                std::array<std::size_t, index_parts> counts{};
                for (auto at = static_cast<std::size_t>(indptr[i]); at < static_cast<std::size_t>(indptr[i + 1]);
                     ++at) {
                    const auto edges = static_cast<std::size_t>(offsets[at + 1] - offsets[at]);
                    if (indices[at] >= 0) ++counts[std::clamp<std::size_t>(edges, 3, 2 + index_parts) - 3];
                }
                for (std::size_t part = 0; part < index_parts; ++part) {
                    if (part > 0) row.put(between);
                    row.put_number(counts[part]);
                }
            }};
}

// Returns 0 for z in the plane.
double coordinate(const OutputData& data, std::size_t i, std::size_t axis) {
    const std::size_t size = data.input.dimensions;
    return axis < size ? data.input.points[size * i + axis] : 0;
}

// Adds the columns x, y and z, or fewer.
void add_coordinates(const OutputData& data, std::size_t count, Table& table) {
    for (std::size_t k = 0; k < count; ++k)
        table.push_back(
            of_numbers(std::string(1, "xyz"[k]), 1, [&data, k](std::size_t i) { return coordinate(data, i, k); }));
}

TableColumn ids_of(const OutputData& data, std::int64_t first) {
    return of_numbers("id", 1, [&ids = data.input.ids, first](std::size_t i) {
        return ids.empty() ? static_cast<std::int64_t>(i) + first : ids[i];
    });
}

// Returns a text as a field of .csv: in quotes if it holds a mark, a quote, a blank or a line end (RFC 4180).
std::string field_of(const std::string& text) {
    if (text.find_first_of(",;\"# \t\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
    return quoted + "\"";
}

TableColumn words(std::string name, const std::vector<std::string>& values) {
    return {std::move(name), 'S', 1, [&values](OutputBuffer& row, std::size_t i, char between) {
                row.put(between == ',' ? field_of(values[i]) : values[i]);
            }};
}

// Returns the columns of the cells, then those of the input.
Table results_of(const OutputData& data) {
    const votess::Tessellation& cells = data.tessellation;
    const votess::Want& wanted = data.wanted;
    Table table;
    const bool planar = cells.planar();
    for_columns(cells, wanted, [&](const auto& array, const auto& values) {
        const std::string name(planar && array.column == "volume"         ? "area"
                               : planar && array.column == "surface_area" ? "perimeter"
                                                                          : array.column);
        if (array.name != "centroids") return table.push_back(of_numbers(name, values, components_of(array, planar)));
        const auto centroids = std::make_shared<const std::vector<double>>(centroids_of(data));
        table.push_back(of_numbers(name, std::span(*centroids), size_of_vectors(cells)));
        table.back().owner = centroids;
    });
    Table of_rows;
    if (wanted.neighbors)
        of_rows.push_back(of_numbers("neighbors", 1, [&cells](std::size_t i) { return neighbors_of(cells, i); }));
    // Faces that reach infinity have no number of edges, so no cell of such a domain has an index.
    const auto reaches_infinity = [](double bound) { return std::isinf(bound); };
    const bool endless = std::ranges::any_of(cells.box().lower, reaches_infinity) ||
                         std::ranges::any_of(cells.box().upper, reaches_infinity);
    if (wanted.faces && !planar && !endless) of_rows.push_back(voronoi_index_of(cells));
    const auto after_volumes = table.begin() + (wanted.volumes ? 1 : 0);
    table.insert(after_volumes, std::make_move_iterator(of_rows.begin()), std::make_move_iterator(of_rows.end()));
    if (data.has_radii) table.push_back(of_numbers("radius", data.radii));
    return table;
}

// Returns whether two columns have the same numbers or words.
bool are_equal(const TableColumn& a, const TableColumn& b, std::size_t rows) {
    for (std::size_t i = 0; i < rows; ++i) {
        OutputBuffer of_a, of_b;
        a.put(of_a, i, ' ');
        b.put(of_b, i, ' ');
        if (of_a.bytes() != of_b.bytes()) return false;
    }
    return true;
}

// Adds the columns of --copy, except those that the table has: the radius, and the species of the seeds by any name.
// Throws Failure for one of a name that the table has for another.
void add_carried(const OutputData& data, Table& table) {
    for (const InputColumn& column : data.carried) {
        const auto integer = [&column](std::size_t k) { return column.integer(k); };
        TableColumn own = column.of_integers     ? of_numbers(column.name, column.width, integer)
                          : column.words.empty() ? of_numbers(column.name, std::span(column.values), column.width)
                                                 : words(column.name, column.words);
        bool is_there = false, is_taken = false;
        for (const TableColumn& other : table) {
            const bool named = other.name == own.name, of_species = other.name == "element" || other.name == "type";
            if (!named && !(own.name == "species" && of_species)) continue;
            const bool equal = are_equal(own, other, data.tessellation.size());
            is_there = is_there || equal;
            is_taken = is_taken || (named && !equal);
        }
        if (is_there) continue;
        if (is_taken)
            throw bad_input("cannot carry the column " + in_quotes(own.name) +
                            ", for the file has another one of that name: rename the column");
        table.push_back(std::move(own));
    }
}

// Names that parts of a column have in a header: NAME_x, NAME_y, NAME_z, or NAME_3, NAME_4, ... of a Voronoi index.
std::string part_name(const TableColumn& column, std::size_t part) {
    if (column.width == 1) return column.name;
    if (column.name == "voronoi_index") return std::string("n") + std::to_string(part + 3);
    if (column.width == 3 || column.name.ends_with("centroid")) return column.name + "_" + "xyz"[part];
    return column.name + "_" + std::to_string(part + 1);
}

void write_rows(OutputFile& file, const OutputData& data, const Table& table, std::string_view before, char between) {
    constexpr std::size_t block = 4096;
    const std::size_t count = data.tessellation.size();
    in_order((count + block - 1) / block, data.threads,
             [&](std::size_t k) {
                 OutputBuffer rows;
                 for (std::size_t i = k * block; i < std::min(count, (k + 1) * block); ++i) {
                     rows.put(before);
                     bool first = true;
                     for (const TableColumn& column : table) {
                         if (!first) rows.put(between);
                         column.put(rows, i, between);
                         first = false;
                     }
                     rows.put('\n');
                 }
                 return rows;
             },
             [&](const OutputBuffer& rows) {
                 file.write(rows.bytes());
                 return true;
             });
}

bool is_whole(const std::string& word) {
    return read_int64(word).has_value();
}

// Returns the edges of the domain, a box or a cell, with its corner. A domain of the plane gets the height 1 around
// z = 0, as in LAMMPS: other programs read three edges.
votess::TriclinicBox edges_of(const votess::Tessellation& cells) {
    const votess::Box& box = cells.box();
    // Rounded up where points at the upper bound would be outside. The error of a difference: Knuth, TAOCP 2, 4.2.2.
    const auto length = [&](std::size_t k) {
        const double lower = box.lower[k], upper = box.upper[k], rounded = upper - lower, part = rounded - upper;
        const double error = (upper - (rounded - part)) - (lower + part);
        const bool up = error > 0 && !cells.periodic()[k];
        return up ? std::nextafter(rounded, std::numeric_limits<double>::infinity()) : rounded;
    };
    votess::TriclinicBox edges{.origin = box.lower,
                               .a = {length(0), 0, 0},
                               .b = {0, length(1), 0},
                               .c = {0, 0, length(2)},
                               .periodic = cells.periodic()};
    if (cells.cell()) edges = *cells.cell();
    if (cells.planar()) edges.origin[2] = -0.5, edges.c = {0, 0, 1};
    return edges;
}

// Writes a box whose edges are those of LAMMPS by their bounds and tilts, others by the edges.
void put_dump_box(OutputBuffer& text, const votess::Tessellation& cells) {
    const votess::TriclinicBox box = edges_of(cells);
    const auto& [a, b, c] = std::tie(box.a, box.b, box.c);
    const bool restricted =
        a[1] == 0 && a[2] == 0 && b[2] == 0 && a[0] > 0 && b[1] > 0 && c[2] > 0 && cells.cell().has_value();
    std::string flags;
    for (const bool axis : cells.periodic()) flags += axis ? " pp" : " ff";
    text.put("ITEM: BOX BOUNDS");
    if (!cells.cell()) {
        text.put(flags + "\n");
        for (std::size_t k = 0; k < 3; ++k) {
            const bool height = k == 2 && cells.planar();
            text.put_vector(std::array{height ? box.origin[k] : cells.box().lower[k],
                                       height ? box.origin[k] + c[k] : cells.box().upper[k]});
            text.put('\n');
        }
        return;
    }
    text.put((restricted ? " xy xz yz" : " abc origin") + flags + "\n");
    const double xy = b[0], xz = c[0], yz = c[1];
    const std::array<double, 3> below{std::min({0.0, xy, xz, xy + xz}), std::min(0.0, yz), 0},
        above{std::max({0.0, xy, xz, xy + xz}), std::max(0.0, yz), 0}, side{a[0], b[1], c[2]}, tilt{xy, xz, yz};
    for (std::size_t k = 0; k < 3; ++k) {
        if (restricted) {
            const std::array<double, 3> row{box.origin[k] + below[k], box.origin[k] + side[k] + above[k], tilt[k]};
            text.put_vector(row);
        } else {
            text.put_vector(k == 0 ? a : k == 1 ? b : c);
            text.put(' ');
            text.put_number(box.origin[k]);
        }
        text.put('\n');
    }
}

}  // namespace

// The columns have the prefix c_, by which LAMMPS, OVITO and ASE know computed numbers.
void write_dump(OutputFile& file, const OutputData& data) {
    OutputBuffer head;
    head.put("ITEM: TIMESTEP\n");
    if (read_int64(data.input.timestep)) {
        head.put(data.input.timestep);
    } else {
        head.put_number(data.input.frame.value_or(0));
    }
    head.put("\nITEM: NUMBER OF ATOMS\n");
    head.put_number(data.tessellation.size());
    head.put('\n');
    put_dump_box(head, data.tessellation);

    const std::vector<std::string>& species = data.input.species;
    Table table{ids_of(data, 1)};
    if (std::ranges::all_of(species, is_whole)) {
        table.push_back({"type", 'I', 1, [&species](OutputBuffer& row, std::size_t i, char) {
                             row.put(species.empty() ? std::string_view("1") : species[i]);
                         }});
    } else {
        table.push_back(words("element", species));
    }
    add_coordinates(data, 3, table);
    for (TableColumn& column : results_of(data)) {
        if (column.name != "radius") column.name.insert(0, "c_");
        table.push_back(std::move(column));
    }
    add_carried(data, table);
    head.put("ITEM: ATOMS");
    for (const TableColumn& column : table) {
        for (std::size_t part = 0; part < column.width; ++part) {
            head.put(' ');
            const bool index = column.name == "c_voronoi_index";
            head.put(index ? "c_n" + std::to_string(part + 3) : part_name(column, part));
        }
    }
    head.put('\n');
    file.write(head.bytes());
    write_rows(file, data, table, "", ' ');
}

void write_xyz(OutputFile& file, const OutputData& data) {
    const votess::TriclinicBox box = edges_of(data.tessellation);
    OutputBuffer head;
    head.put_number(data.tessellation.size());
    head.put("\nLattice=\"");
    head.put_vector(box.a);
    head.put(' ');
    head.put_vector(box.b);
    head.put(' ');
    head.put_vector(box.c);
    head.put("\" Origin=\"");
    head.put_vector(box.origin);
    head.put("\" pbc=\"");
    for (std::size_t k = 0; k < 3; ++k) {
        if (k > 0) head.put(' ');
        head.put(data.tessellation.periodic()[k] ? 'T' : 'F');
    }
    head.put('"');
    if (data.input.frame) {
        head.put(" frame=");
        head.put_number(*data.input.frame);
    }
    if (!data.input.timestep.empty()) head.put(" Timestep=" + data.input.timestep);

    const std::vector<std::string>& species = data.input.species;
    Table table;
    if (!species.empty() && std::ranges::all_of(species, is_whole)) {
        table.push_back(words("type", species));
        table.back().type = 'I';
    } else {
        table.push_back({"species", 'S', 1, [&species](OutputBuffer& row, std::size_t i, char) {
                             row.put(species.empty() ? std::string_view("X") : species[i]);
                         }});
    }
    table.push_back({"pos", 'R', 3, [&data](OutputBuffer& row, std::size_t i, char between) {
                         row.put_vector(
                             std::array{coordinate(data, i, 0), coordinate(data, i, 1), coordinate(data, i, 2)},
                             between);
                     }});
    if (!data.input.ids.empty()) table.push_back(ids_of(data, 0));
    for (TableColumn& column : results_of(data)) table.push_back(std::move(column));
    add_carried(data, table);
    head.put(" Properties=");
    for (std::size_t c = 0; c < table.size(); ++c) {
        const TableColumn& column = table[c];
        head.put((c > 0 ? ":" : "") + column.name + ":" + column.type + ":" + std::to_string(column.width));
    }
    head.put('\n');
    file.write(head.bytes());
    write_rows(file, data, table, "", ' ');
}

void write_csv(OutputFile& file, const OutputData& data) {
    Table table{ids_of(data, 0)};
    add_coordinates(data, data.input.dimensions, table);
    for (TableColumn& column : results_of(data)) table.push_back(std::move(column));
    add_carried(data, table);
    if (data.place != FramePlace::later) {
        std::string head = data.place == FramePlace::first ? "frame" : "";
        for (const TableColumn& column : table)
            for (std::size_t part = 0; part < column.width; ++part)
                head.append(head.empty() ? "" : ",").append(field_of(part_name(column, part)));
        file.write(head.append("\n"));
    }
    const bool framed = data.place != FramePlace::alone;
    write_rows(file, data, table, framed ? std::to_string(data.input.frame.value_or(0)) + "," : "", ',');
}

bool is_table_column(std::string_view name, bool planar) {
    constexpr std::array<std::string_view, 13> names{"id",    "x",  "y",  "z",  "pos", "neighbors", "voronoi_index",
                                                     "frame", "n3", "n4", "n5", "n6",  "n7"};
    if (name.starts_with("c_")) name.remove_prefix(2);  // in a dump
    if (planar && (name == "area" || name == "perimeter")) return true;
    return is_column(name) || std::ranges::find(names, name) != names.end();
}

}  // namespace clvotess

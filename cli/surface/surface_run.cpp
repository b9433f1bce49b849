#include "surface/surface_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
#include <votess/surface.hpp>

#include "arguments/carried.hpp"
#include "failure.hpp"
#include "files/formats/hdf5_module.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "read/input.hpp"
#include "write/output.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

constexpr std::array mesh_formats{".obj", ".ply", ".off", ".stl"};

bool is_mesh_format(const std::string& path) {
    return std::ranges::find(mesh_formats, extension_of(path)) != mesh_formats.end();
}

// A mesh to write.
struct Triangles {
    std::span<const double> vertices;
    std::span<const std::int32_t> corners;

    [[nodiscard]] std::span<const double, 3> vertex(std::int32_t v) const {
        return vertices.subspan(3 * static_cast<std::size_t>(v)).first<3>();
    }
    [[nodiscard]] std::size_t size() const { return corners.size() / 3; }
    [[nodiscard]] std::size_t vertex_count() const { return vertices.size() / 3; }
};

// Writes rows in pieces.
void write_rows(OutputFile& file, OutputBuffer& out, std::size_t rows, const std::function<void(std::size_t)>& put) {
    constexpr std::size_t piece = 4096;
    for (std::size_t i = 0; i < rows; ++i) {
        put(i);
        if ((i + 1) % piece != 0) continue;
        file.write(out.bytes());
        out.clear();
    }
    file.write(out.bytes());
    out.clear();
}

void put_triangle(OutputBuffer& out, std::string_view head, const Triangles& mesh, std::size_t t, int first) {
    out.put(head);
    for (std::size_t k = 0; k < 3; ++k) {
        out.put(' ');
        out.put_number(mesh.corners[3 * t + k] + first);
    }
    out.put('\n');
}

void write_obj_or_off(OutputFile& file, const Triangles& mesh, bool is_obj) {
    OutputBuffer out;
    if (!is_obj) out.put("OFF\n" + std::to_string(mesh.vertex_count()) + " " + std::to_string(mesh.size()) + " 0\n");
    write_rows(file, out, mesh.vertex_count(), [&](std::size_t v) {
        if (is_obj) out.put("v ");
        out.put_vector(mesh.vertices.subspan(3 * v, 3));
        out.put('\n');
    });
    write_rows(file, out, mesh.size(),
               [&](std::size_t t) { put_triangle(out, is_obj ? "f" : "3", mesh, t, is_obj ? 1 : 0); });
}

void write_binary_ply(OutputFile& file, const Triangles& mesh) {
    OutputBuffer out;
    out.put("ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.vertex_count()) +
            "\nproperty double x\nproperty double y\nproperty double z\nelement face " + std::to_string(mesh.size()) +
            "\nproperty list uchar int vertex_indices\nend_header\n");
    write_rows(file, out, mesh.vertices.size(), [&](std::size_t k) { out.put_binary(mesh.vertices[k]); });
    write_rows(file, out, mesh.size(), [&](std::size_t t) {
        out.put_binary(std::uint8_t{3});
        for (std::size_t k = 0; k < 3; ++k) out.put_binary(mesh.corners[3 * t + k]);
    });
}

void write_text_stl(OutputFile& file, const Triangles& mesh) {
    OutputBuffer out;
    out.put("solid surface\n");
    write_rows(file, out, mesh.size(), [&](std::size_t t) {
        const auto a = mesh.vertex(mesh.corners[3 * t]), b = mesh.vertex(mesh.corners[3 * t + 1]),
                   c = mesh.vertex(mesh.corners[3 * t + 2]);
        std::array<double, 3> n{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t y = (k + 1) % 3, z = (k + 2) % 3;
            n[k] = (b[y] - a[y]) * (c[z] - a[z]) - (b[z] - a[z]) * (c[y] - a[y]);
        }
        const double length = std::hypot(n[0], n[1], n[2]);
        for (double& x : n) x = length > 0 ? x / length : 0;
        out.put("facet normal ");
        out.put_vector(n);
        out.put("\nouter loop\n");
        for (const auto& x : {a, b, c}) {
            out.put("vertex ");
            out.put_vector(x);
            out.put('\n');
        }
        out.put("endloop\nendfacet\n");
    });
    file.write("endsolid surface\n");
}

void write_mesh_file(OutputFile& file, const std::string& path, const Triangles& mesh) {
    if (extension_of(path) == ".ply") return write_binary_ply(file, mesh);
    if (extension_of(path) == ".stl") return write_text_stl(file, mesh);
    write_obj_or_off(file, mesh, extension_of(path) == ".obj");
}

void write_arrays(OutputFile& file, const std::string& path, std::span<const ResultArray> arrays) {
    if (names_hdf5(path)) return load_hdf5("cannot write HDF5").write_arrays(file, arrays);
    write_npz_arrays(file, arrays);
}

// Returns the length of the boundary of each part.
std::vector<double> perimeters_of(const votess::SurfaceCells& cells) {
    std::vector<double> perimeters = cells.borders;
    for (std::size_t i = 0; i < cells.size(); ++i)
        for (std::int64_t k = cells.indptr[i]; k < cells.indptr[i + 1]; ++k)
            perimeters[i] += cells.lengths[static_cast<std::size_t>(k)];
    return perimeters;
}

void write_cell_rows(OutputFile& file, const Input& seeds, const votess::SurfaceCells& cells) {
    const std::vector<double> perimeters = perimeters_of(cells);
    OutputBuffer out;
    out.put("id,x,y,z,area,perimeter,border,neighbors,pieces,euler,cx,cy,cz\n");
    write_rows(file, out, cells.size(), [&](std::size_t i) {
        out.put_number(seeds.ids.empty() ? static_cast<std::int64_t>(i) : seeds.ids[i]);
        out.put(',');
        out.put_vector(std::span(seeds.points).subspan(3 * i, 3), ',');
        for (const double x : {cells.areas[i], perimeters[i], cells.borders[i]}) {
            out.put(',');
            out.put_number(x);
        }
        for (const std::int64_t n :
             {cells.indptr[i + 1] - cells.indptr[i], std::int64_t{cells.pieces[i]}, std::int64_t{cells.euler[i]}}) {
            out.put(',');
            out.put_number(n);
        }
        out.put(',');
        out.put_vector(std::span(cells.centroids).subspan(3 * i, 3), ',');
        out.put('\n');
    });
}

// Views into the cells and the other arguments.
std::vector<ResultArray> arrays_of(const votess::SurfaceCells& cells, std::span<const double> points,
                                   std::span<const std::int32_t> faults) {
    std::vector<ResultArray> arrays{as_array("points", points, 3)};
    votess::for_surface_arrays(cells, [&](std::string_view name, const auto& values, std::size_t components) {
        arrays.push_back(as_array(name, std::span(values), components));
    });
    arrays.push_back(as_array("faults", faults));
    return arrays;
}

// Members of a JSON object, or words for people.
class Report {
public:
    // words: behind the number; a plural s is cut for one. Empty: in JSON only.
    template <class Number>
    void add(const char* name, Number value, const std::string& words = "") {
        std::string text;
        if constexpr (std::is_floating_point_v<Number>)
            text = std::isfinite(value) ? to_text(value) : "null";
        else
            text = std::to_string(value);
        json_ += std::string(", \"") + name + "\": " + text;
        if (words.empty()) return;
        const bool single = text == "1" && words.ends_with('s');
        words_ += (words_.empty() ? "" : ", ") + text + " " + (single ? words.substr(0, words.size() - 1) : words);
    }
    [[nodiscard]] std::string json(const std::string& rest) const {
        return "{\"version\": \"" VOTESS_VERSION_STRING "\"" + json_ + rest + "}\n";
    }
    [[nodiscard]] std::string words() const { return words_ + '\n'; }

private:
    std::string json_, words_;
};

class SurfaceRun {
public:
    explicit SurfaceRun(const Arguments& arguments) : arguments_(arguments) {}

    std::string run() {
        surface_ = read_surface("--surface", arguments_.surface_file);
        surface_.merge |= arguments_.mesh.merge;
        surface_.tolerance = arguments_.mesh.tolerance;
        if (surface_.tolerance > 0 && !surface_.merge)
            throw bad_input("--mesh-tolerance needs --mesh-repair merge: give both");
        report_.add("surface_triangles", surface_.triangles.size() / 3);
        arguments_.remesh ? remesh() : find_cells();
        const InterruptGuard guard;
        Outputs outputs(false);
        for (const std::string& path : arguments_.outputs)
            outputs.add(path, [&](OutputFile& file) { write(file, path); });
        outputs.publish();
        const double all = seconds_since(began_);
        if (arguments_.json)
            return report_.json(", \"seconds\": {\"total\": " + to_text(all) + ", \"read\": " + to_text(read_seconds_) +
                                ", \"surface\": " + to_text(surface_seconds_) +
                                ", \"write\": " + to_text(all - read_seconds_ - surface_seconds_) + "}");
        return arguments_.quiet ? "" : report_.words();
    }

private:
    void find_cells() {
        if (arguments_.random_count) {
            seeds_.dimensions = 3;
            seeds_.points = votess::sample_surface(surface_.view(), *arguments_.random_count, arguments_.rng_seed);
        } else {
            seeds_ = read_input(arguments_.input, arguments_.read);
        }
        complete_columns(arguments_, seeds_);
        std::vector<double> weights;
        if (arguments_.has_weights) {
            const std::span<const double> column = one_each(seeds_.columns.at(0));
            weights.assign(column.begin(), column.end());
            for (double& weight : weights) weight *= arguments_.has_radii ? weight : 1;
        }
        read_seconds_ = seconds_since(began_);
        cells_ = watch_([&](const votess::ProgressCallback& progress) {
            votess::SurfaceOptions options;
            options.weights = weights;
            options.threads = arguments_.options.threads;
            options.progress = progress;
            return votess::surface_cells(seeds_.points, surface_.view(), options);
        });
        surface_seconds_ = seconds_since(began_) - read_seconds_;
        faults_ = cells_.faults();
        const auto without = std::ranges::count(cells_.pieces, 0);
        report_.add("points", cells_.size(), "cells");
        report_.add("area", std::accumulate(cells_.areas.begin(), cells_.areas.end(), 0.0), "in area");
        report_.add("border", std::accumulate(cells_.borders.begin(), cells_.borders.end(), 0.0));
        report_.add("polygons", cells_.polygon_seeds.size(), "polygons");
        report_.add("dual_triangles", cells_.dual.size() / 3, "triangles in the dual");
        report_.add("without_part", without, "seeds without a part");
        report_.add("in_pieces", std::ranges::count_if(cells_.pieces, [](std::int32_t n) { return n > 1; }),
                    "cells in several pieces");
        report_.add("faults", faults_.size(), "faults");
    }

    void remesh() {
        read_seconds_ = seconds_since(began_);
        mesh_ = watch_([&](const votess::ProgressCallback& progress) {
            votess::RemeshOptions options;
            options.rng_seed = arguments_.rng_seed;
            options.sharp = arguments_.sharp;
            options.threads = arguments_.options.threads;
            options.progress = progress;
            return votess::remesh(surface_.view(), *arguments_.remesh, options);
        });
        if (mesh_.triangles.empty())
            throw bad_input("--remesh " + std::to_string(*arguments_.remesh) + " makes no triangle: give more points");
        surface_seconds_ = seconds_since(began_) - read_seconds_;
        report_.add("vertices", mesh_.vertices.size() / 3, "vertices");
        report_.add("triangles", mesh_.triangles.size() / 3, "triangles");
        report_.add("min_angle", mesh_.min_angle, "degrees at the sharpest corner");
        report_.add("mean_min_angle", mesh_.mean_min_angle, "in the mean of triangles");
        report_.add("distance", mesh_.distance, "from the surface");
        report_.add("seeds", mesh_.points.size() / 3);
        report_.add("border_edges", mesh_.border_edges, "edges of one triangle");
        report_.add("crowded_edges", mesh_.crowded_edges, "edges of more than two");
        report_.add("faults", mesh_.faults.size(), "faults");
    }

    void write(OutputFile& file, const std::string& path) {
        if (arguments_.remesh) {
            if (is_mesh_format(path)) return write_mesh_file(file, path, {mesh_.vertices, mesh_.triangles});
            const std::array arrays{as_array("vertices", std::span<const double>(mesh_.vertices), 3),
                                    as_array("triangles", std::span<const std::int32_t>(mesh_.triangles), 3),
                                    as_array("points", std::span<const double>(mesh_.points), 3),
                                    as_array("faults", std::span<const std::int32_t>(mesh_.faults))};
            return write_arrays(file, path, arrays);
        }
        if (is_mesh_format(path)) return write_mesh_file(file, path, {seeds_.points, cells_.dual});
        if (extension_of(path) == ".csv") return write_cell_rows(file, seeds_, cells_);
        std::vector<ResultArray> arrays = arrays_of(cells_, seeds_.points, faults_);
        const std::vector<double> perimeters = perimeters_of(cells_);
        arrays.push_back(as_array("perimeters", std::span(perimeters)));
        if (!seeds_.ids.empty()) arrays.push_back(as_array("ids", std::span<const std::int64_t>(seeds_.ids)));
        write_arrays(file, path, arrays);
    }

    const Arguments& arguments_;
    Clock::time_point began_ = Clock::now();
    Watch watch_{arguments_.quiet, began_};
    double read_seconds_ = 0, surface_seconds_ = 0;
    Surface surface_;
    Input seeds_;
    votess::SurfaceCells cells_;
    std::vector<std::int32_t> faults_;
    votess::Remesh mesh_;
    Report report_;
};

}  // namespace

void refuse_beside_surface(const Arguments& arguments) {
    for (const Option* option : arguments.given)
        if (!option->traits.on_surface)
            throw bad_input(long_name(*option) +
                            " does not go with --surface, whose cells are parts of a surface: "
                            "leave it out");
}

void read_surface_options(const Typed& typed, Arguments& arguments) {
    arguments.surface_file = *typed.value("--surface");
    if (arguments.surface_file.empty() || holds_polygons("--surface", arguments.surface_file))
        throw bad_input("--surface is " + in_quotes(arguments.surface_file) +
                        ": give a triangle mesh in .off, .obj, .ply, .stl or .glb");
    if (const std::string* count = typed.value("--remesh")) {
        if (typed.has("INPUT") || typed.has("--random"))
            throw bad_input("--remesh chooses its own points: leave out INPUT and --random");
        for (const char* option : {"--dataset", "--frame", "--columns", "--weights", "--radii"})
            if (typed.has(option))
                throw bad_input(std::string(option) + " goes with INPUT, not with --remesh: leave it out");
        arguments.remesh = read_count("--remesh", *count, std::uint64_t{1} << 28);
        if (arguments.outputs.empty())
            throw bad_input("--remesh makes a mesh: add -o FILE in .obj, .ply, .off, .stl, .npz or .h5");
    }
    for (const std::string& path : arguments.outputs) {
        const std::string extension = path == "-" ? "" : extension_of(path);
        const bool is_table = extension == ".csv" && !arguments.remesh;
        if (!is_table && extension != ".npz" && !names_hdf5(path) && !is_mesh_format(path))
            throw bad_input(std::string(arguments.remesh ? "--remesh writes" : "--surface writes .csv,") +
                            " .npz, .h5, .obj, .ply, .off and .stl, not " + in_quotes(path));
        if (names_hdf5(path)) check_hdf5(path);
    }
    check_paths(arguments.outputs, {arguments.input, arguments.surface_file});
}

std::string run_on_surface(const Arguments& arguments) {
    return SurfaceRun(arguments).run();
}

}  // namespace clvotess

// Neper's .tess: the seeds with their weights, which count squared, and the domain. Its polyhedra are made again; a
// note reports those that regularization changed.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "failure.hpp"
#include "files/line_reader.hpp"
#include "read/input.hpp"

namespace clvotess {
namespace {

// The words of a file. A list may have line ends anywhere.
class WordReader {
public:
    WordReader(std::string_view text, const std::string& name) : lines_(text, name) {}

    // Returns the next word, or nothing at the end.
    [[nodiscard]] std::string_view next() {
        while (at_ == words_.size()) {
            std::string_view line;
            if (!lines_.next_filled(line)) return {};
            split_words(line, words_);
            at_ = 0;
        }
        return words_[at_++];
    }
    [[nodiscard]] std::string_view need(const char* what) {
        const std::string_view word = next();
        if (word.empty()) throw lines_.error(std::string("the file ends where ") + what + " is expected");
        return word;
    }
    [[nodiscard]] double number(const char* what) {
        const double value = lines_.number(need(what));
        if (!std::isfinite(value)) throw lines_.error(std::string(what) + " is not finite");
        return value;
    }
    [[nodiscard]] std::int64_t whole(const char* what) { return lines_.whole(need(what), what); }
    [[nodiscard]] std::size_t count(const char* what) {
        const std::int64_t value = whole(what);
        if (value < 0 || !can_hold(lines_.rest().size() + words_.size(), static_cast<std::uint64_t>(value), 1))
            throw lines_.error(std::to_string(value) + " is not a number of " + what + " that this file has room for");
        return static_cast<std::size_t>(value);
    }
    void skip(std::size_t count, const char* what) {
        for (std::size_t k = 0; k < count; ++k) (void)need(what);
    }
    [[nodiscard]] Failure error(const std::string& message) const { return lines_.error(message); }

private:
    LineReader lines_;
    Words words_;
    std::size_t at_ = 0;
};

class TessReader {
public:
    TessReader(std::string_view text, const std::string& name) : words_(text, name), name_(name) {}

    Input read() {
        if (words_.next() != "***tess") throw words_.error("a .tess file begins with ***tess");
        for (std::string_view word = words_.next(); !word.empty() && word != "***end"; word = words_.next()) {
            if (word.starts_with("**")) {
                section_ = word;
                if (section_ == "**general") read_general();
                if (section_ == "**cell") cells_ = words_.count("cells");
                if (section_ == "**format") format_ = words_.number("the version of the format");
                if (section_ == "**vertex") read_vertices();
                if (section_ == "**face" && has_planes()) read_faces();
                if (section_ == "**polyhedron" && has_planes()) read_polyhedra();
            } else if (word.starts_with("*")) {
                read_part(word);
            }
        }
        if (input_.points.size() != 3 * cells_)
            throw bad_input(name_ + ": a .tess file without seeds (*seed): its cells may be no power diagram");
        if (input_.note.empty() && !are_power_cells())
            throw bad_input(
                name_ +
                ": its polyhedra are not the power cells of its seeds, as after -transform or with aspratio: "
                "to make the cells of the seeds, write these as rows of text");
        set_domain();
        return std::move(input_);
    }
    [[nodiscard]] const std::vector<double>& radii() const { return radii_; }

private:
    void read_general() {
        const std::int64_t dimension = words_.whole("the dimension");
        if (dimension != 3)
            throw words_.error("a tessellation in " + std::to_string(dimension) +
                               " dimensions: those in three are read; write its seeds as rows of text");
    }

    // A row: number, x, y, z, and a state: not 0 where regularization made one vertex of several.
    void read_vertices() {
        const std::size_t count = words_.count("vertices");
        for (std::size_t i = 0; i < count; ++i) {
            words_.skip(4, "a vertex");
            if (words_.whole("the state of a vertex") != 0) input_.note = "regularized polyhedra, made again without";
        }
    }

    // Whether the rows of faces are those that read_faces() knows.
    [[nodiscard]] bool has_planes() const { return format_ >= 3.4 && format_ < 4; }

    // Returns the number of a face without the sign that says how it is oriented.
    static std::uint64_t face_of(std::int64_t number) {
        const auto face = static_cast<std::uint64_t>(number);
        return number < 0 ? 0 - face : face;
    }

    // A row: number; lists of vertices and edges; the plane as d, a, b, c; a state; a point and its coordinates.
    void read_faces() {
        const std::size_t count = words_.count("faces");
        for (std::size_t i = 0; i < count; ++i) {
            std::array<double, 4>& plane = planes_[face_of(words_.whole("a face"))];
            words_.skip(words_.count("vertices"), "a vertex");
            words_.skip(words_.count("edges"), "an edge");
            for (double& x : plane) x = words_.number("a parameter of a plane");
            words_.skip(5, "a point of a face");
        }
    }

    // A row: number, the number of faces, and these, negative where they face inward.
    void read_polyhedra() {
        const std::size_t count = words_.count("polyhedra");
        for (std::size_t i = 0; i < count; ++i) {
            const std::int64_t cell = words_.whole("a polyhedron");
            if (cell < 1 || static_cast<std::uint64_t>(cell) > cells_)
                throw words_.error("polyhedron " + std::to_string(cell) + " is none of the cells");
            const std::size_t faces = words_.count("faces");
            for (std::size_t k = 0; k < faces; ++k)
                sides_[face_of(words_.whole("a face"))].push_back(static_cast<std::size_t>(cell) - 1);
        }
    }

    // Returns whether most faces between two cells lie on the bisector of their seeds. Numbers have 12 decimals, and
    // small faces far from the origin have rounded planes.
    [[nodiscard]] bool are_power_cells() const {
        constexpr double tolerance = 1e-6;
        std::size_t wrong = 0, seen = 0;
        for (const auto& [face, cells] : sides_) {
            const auto plane = planes_.find(face);
            if (cells.size() != 2 || plane == planes_.end()) continue;
            std::array<double, 3> normal{};
            double length = 0, along = 0, offset = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double a = input_.points[3 * cells[0] + k], b = input_.points[3 * cells[1] + k];
                normal[k] = b - a;
                length += normal[k] * normal[k];
                along += normal[k] * plane->second[k + 1];
                offset += (b - a) * (b + a) / 2;
            }
            const double a = radii_[cells[0]], b = radii_[cells[1]];
            offset += (a - b) * (a + b) / 2;
            length = std::sqrt(length);
            const double sign = along < 0 ? -1 : 1, near = std::max(tolerance, 1e-10 / length);
            offset /= length;
            bool same = std::abs(sign * plane->second[0] - offset) < near * std::max(1.0, std::abs(offset));
            for (std::size_t k = 0; k < 3; ++k)
                same &= std::abs(sign * plane->second[k + 1] - normal[k] / length) < near;
            wrong += same ? 0 : 1;
            ++seen;
        }
        return 2 * wrong <= seen;
    }

    void read_part(std::string_view part) {
        if (section_ == "**cell" && part == "*id") {
            for (std::size_t i = 0; i < cells_; ++i) input_.ids.push_back(words_.whole("an id"));
        } else if (section_ == "**cell" && part == "*seed") {
            for (std::size_t i = 0; i < cells_; ++i) {
                (void)words_.whole("a seed's number");
                for (std::size_t k = 0; k < 3; ++k) input_.points.push_back(words_.number("a coordinate"));
                radii_.push_back(words_.number("a weight"));
            }
        } else if ((section_ == "**cell" && part == "*lam") ||
                   (section_ == "**scale" && part == "*general" && words_.whole("the number of scales") > 1)) {
            throw words_.error(
                "grains are cut into others, which the seeds do not describe: read the file of one scale");
        } else if (section_ == "**domain" && part == "*general") {
            domain_ = words_.need("the type of the domain");
        } else if (section_ == "**domain" && part == "*vertex") {
            read_domain_vertices();
        } else if (section_ == "**domain" && part == "*face") {
            read_domain_faces();
        } else if (section_.starts_with("**periodic") && part == "*general") {
            for (bool& periodic : input_.domain.periodic) periodic = words_.whole("a flag of periodicity") != 0;
            words_.skip(3, "a period");
        }
    }

    // A row: number, x, y, z, label, the number of vertices of cells, and these.
    void read_domain_vertices() {
        const std::size_t count = words_.count("vertices of the domain");
        for (std::size_t i = 0; i < count; ++i) {
            words_.skip(1, "a vertex");
            for (std::size_t k = 0; k < 3; ++k) {
                const double x = words_.number("a coordinate");
                box_.lower[k] = i == 0 ? x : std::min(box_.lower[k], x);
                box_.upper[k] = i == 0 ? x : std::max(box_.upper[k], x);
                middle_[k] += x / static_cast<double>(count);
            }
            words_.skip(1, "a label");
            words_.skip(words_.count("vertices"), "a vertex");
        }
    }

    // A row: number; lists of vertices and edges; type, the number of parameters, and these; label; a list of faces.
    void read_domain_faces() {
        const std::size_t count = words_.count("faces of the domain");
        for (std::size_t i = 0; i < count; ++i) {
            words_.skip(1, "a face");
            words_.skip(words_.count("vertices"), "a vertex");
            words_.skip(words_.count("edges"), "an edge");
            const std::string type(words_.need("the type of a face"));
            if (type != "plane")
                throw words_.error(
                    "the domain has a face that is a " + type +
                    ": planes are read; give the domain by --box or --wall-cylinder and the seeds as text");
            if (words_.count("parameters") != 4) throw words_.error("expected 4 parameters of a plane");
            const double d = words_.number("a parameter");
            votess::Wall wall;  // normals lead inward or outward
            wall.offset = d;
            for (double& n : wall.normal) n = words_.number("a parameter");
            walls_.push_back(wall);
            words_.skip(1, "a label");
            words_.skip(words_.count("faces"), "a face");
        }
    }

    // Whether the domain is a box along the axes. A cube may be turned.
    [[nodiscard]] bool is_box() const {
        return domain_ == "cube" && std::ranges::all_of(walls_, [](const votess::Wall& wall) {
                   return std::ranges::count(wall.normal, 0.0) == 2;
               });
    }

    // Walls lie inside a larger box, which cuts nothing.
    void set_domain() {
        if (domain_.empty()) return;
        for (std::size_t k = 0; k < 3; ++k)
            if (!(box_.lower[k] < box_.upper[k])) throw bad_input(name_ + ": the domain has no volume");
        if (!is_box()) {
            for (votess::Wall& wall : walls_) {
                double height = -wall.offset;
                for (std::size_t k = 0; k < 3; ++k) height += wall.normal[k] * middle_[k];
                if (height <= 0) continue;
                wall.offset = -wall.offset;
                for (double& n : wall.normal) n = -n;
            }
            for (std::size_t k = 0; k < 3; ++k) {
                const double room = (box_.upper[k] - box_.lower[k]) / 4;
                box_.lower[k] -= room, box_.upper[k] += room;
            }
            input_.domain.walls = walls_;
        }
        input_.domain.box = box_;
        input_.domain.periodic_from = DomainSource::stated;
    }

    WordReader words_;
    const std::string& name_;
    std::string section_, domain_;
    std::size_t cells_ = 0;
    double format_ = 0;
    std::map<std::uint64_t, std::array<double, 4>> planes_;    // of faces
    std::map<std::uint64_t, std::vector<std::size_t>> sides_;  // the cells of faces
    std::vector<double> radii_;
    votess::Box box_;
    std::array<double, 3> middle_{};  // of the domain's vertices
    std::vector<votess::Wall> walls_;
    Input input_;
};

}  // namespace

Input parse_tess(std::string_view text, const std::string& name, const ReadRequest& request) {
    TessReader reader(text, name);
    Input input = reader.read();
    bool added = false;
    for (const std::string& column : request.columns) {
        if (column != "radius") {
            if (request.columns_may_lack) continue;
            throw bad_input(name + ": a .tess file has the column 'radius', not " + in_quotes(column));
        }
        input.columns.push_back({.name = column, .values = reader.radii()});
        added = true;
    }
    if (request.all_columns && !added) input.columns.push_back({.name = "radius", .values = reader.radii()});
    return input;
}

}  // namespace clvotess

// NumPy's .npz: a zip archive of .npy members.
#include <algorithm>
#include <array>

#include "failure.hpp"
#include "files/formats/npy_array.hpp"
#include "files/formats/zip_reader.hpp"
#include "files/line_reader.hpp"
#include "read/input.hpp"

namespace clvotess {
namespace {

class NpzReader {
public:
    NpzReader(std::string_view bytes, const std::string& name, const ReadRequest& request)
        : name_(name), request_(request), members_(list_members(bytes, name)) {}

    Input read() {
        Input input;
        const ZipMember* points = find_points();
        if (points) {
            NpyArray array = open(*points);
            array.check_points(columns_of(request_.dimensions));
            array.read_numbers(input.points);
            input.dimensions = array.shape()[1];
            const std::string name = plain_name(*points);
            if (request_.dataset.empty() && name != "points") note("the points are its array " + name, input);
        } else {
            read_axes(input);
        }
        for (const char* const name : {"ids", "id"}) {
            const ZipMember* const member = find(name);
            if (!member || !input.ids.empty()) continue;
            NpyArray array = open(*member);
            if (!array.is_column() || !array.is_whole())
                throw bad_input(name_ + ": " + name +
                                " are not whole numbers in a list: save them as integers, or leave them out");
            check_length(name, array, input.size(), "the array of points");
            input.ids = array.read_whole();
        }
        for (std::size_t c = 0; c < request_.columns.size(); ++c)
            read_column(request_.columns[c], c >= request_.first_carried, input);
        if (request_.all_columns) read_others(points, input);
        read_domain(input);
        return input;
    }

private:
    [[nodiscard]] const ZipMember* find(const std::string& name) const {
        for (const ZipMember& member : members_) {
            if (member.name == name + ".npy" || member.name == name) return &member;
        }
        return nullptr;
    }

    [[nodiscard]] NpyArray open(const ZipMember& member) const {
        return {open_member(member, name_ + ": " + member.name), name_ + ": " + member.name};
    }

    [[nodiscard]] static std::string plain_name(const ZipMember& member) {
        return member.name.ends_with(".npy") ? member.name.substr(0, member.name.size() - 4) : member.name;
    }

    [[nodiscard]] static bool is_of_domain(const std::string& name) {
        return name == "box" || name == "cell" || name == "walls";
    }

    [[nodiscard]] std::string list(const std::vector<const ZipMember*>& members) const {
        std::string text;
        for (const ZipMember* member : members) add_name(text, plain_name(*member));
        return text;
    }

    [[nodiscard]] Failure no_array(const std::string& name) const {
        std::vector<const ZipMember*> all;
        for (const ZipMember& member : members_) all.push_back(&member);
        return bad_input(name_ + ": no array " + in_quotes(name) + "; there are " + list(all));
    }

    // Returns the member named by --dataset, or `points`, or the only array that fits and is not of the domain; null
    // when there are x, y and perhaps z instead.
    [[nodiscard]] const ZipMember* find_points() const {
        if (!request_.dataset.empty()) {
            if (const ZipMember* const member = find(request_.dataset)) return member;
            throw no_array(request_.dataset);
        }
        if (!request_.coordinates.empty()) {
            for (const std::string& axis : request_.coordinates)
                if (!find(axis)) throw no_array(axis);
            return nullptr;
        }
        if (const ZipMember* const member = find("points")) return member;
        const bool flat = request_.dimensions != Dimensions::three;
        if (find("x") && find("y") && (find("z") || flat)) return nullptr;
        std::vector<const ZipMember*> candidates;
        for (const std::size_t columns : columns_of(request_.dimensions)) {
            for (const ZipMember& member : members_) {
                const std::string name = plain_name(member);
                if (!member.name.ends_with(".npy") || is_of_domain(name)) continue;
                const NpyArray array = open(member);
                if (array.has_columns(columns) && array.is_float()) candidates.push_back(&member);
            }
            if (!candidates.empty()) break;
        }
        if (candidates.size() == 1) return candidates[0];
        if (candidates.empty()) {
            // Whoever reads an array of another type says which type it expects.
            for (const ZipMember& member : members_)
                if (const std::string name = plain_name(member);
                    member.name.ends_with(".npy") && !is_of_domain(name) && open(member).has_columns(flat ? 2 : 3))
                    return &member;
            throw bad_input(name_ + ": no array of floats with shape " + shapes_of(request_.dimensions) +
                            (flat ? ", nor arrays x and y" : ", nor arrays x, y and z"));
        }
        throw bad_input(name_ + ": several arrays could be the points, name one with --dataset: " + list(candidates));
    }

    // Returns whether an array has that shape, with any number of rows for 0.
    [[nodiscard]] static bool fits(const NpyArray& array, std::size_t rows, std::size_t columns) {
        const auto& shape = array.shape();
        return shape.size() == (columns == 1 ? 1 : 2) && (rows == 0 || shape[0] == rows) &&
               (columns == 1 || shape[1] == columns) && array.is_number();
    }

    // Returns the numbers of an array of that shape; empty without such an array.
    [[nodiscard]] std::vector<double> numbers(const char* name, std::size_t rows, std::size_t columns) const {
        std::vector<double> values;
        const ZipMember* const member = find(name);
        if (!member) return values;
        NpyArray array = open(*member);
        if (!fits(array, rows, columns))
            throw bad_input(
                name_ + ": " + name + " does not hold numbers with shape (" +
                (rows == 0 ? std::string("W") : std::to_string(rows)) + ", " +
                (columns == 1 ? std::string() : std::to_string(columns)) + ")" +
                (name == std::string_view("box") ? "" : ", which state a domain beside box: leave one out"));
        return array.read_numbers(values), values;
    }

    // Reads the domain in the arrays that clvotess writes.
    void read_domain(Input& input) const {
        const std::size_t size = input.dimensions;
        const ZipMember* const box = find("box");
        if (!box || (!find("periodic") && !fits(open(*box), 2, size))) return note_unread(input);
        const std::vector<double> corners = numbers("box", 2, size), flags = numbers("periodic", size, 1),
                                  cell = numbers("cell", size, size), origin = numbers("origin", size, 1);
        input.domain = stated_domain(name_, corners, flags, cell, origin, numbers("walls", 0, size + 1));
    }

    // Notes the arrays that would state a domain beside a box, except those of another shape with a row for each point.
    void note_unread(Input& input) const {
        struct Of {
            const char* name;
            std::size_t rows, columns;
        };
        const std::size_t size = input.dimensions;
        std::string names;
        for (const auto& [name, rows, columns] : {Of{"box", 2, size}, Of{"periodic", size, 1}, Of{"cell", size, size},
                                                  Of{"origin", size, 1}, Of{"walls", 0, size + 1}}) {
            const ZipMember* const member = find(name);
            if (!member) continue;
            const NpyArray array = open(*member);
            const bool of_points = may_be_column(array) && array.shape()[0] == input.size();
            if (!of_points || fits(array, rows, columns)) add_name(names, name);
        }
        note(note_of_unread(names, size), input);
    }

    static void note(const std::string& text, Input& input) {
        input.note += (input.note.empty() || text.empty() ? "" : "; ") + text;
    }

    // Returns the names of the arrays of x, y and perhaps z.
    [[nodiscard]] std::vector<std::string> axis_names() const {
        if (!request_.coordinates.empty()) return request_.coordinates;
        return find("z") ? std::vector<std::string>{"x", "y", "z"} : std::vector<std::string>{"x", "y"};
    }

    void read_axes(Input& input) const {
        const std::vector<std::string> axes = axis_names();
        std::size_t count = 0;
        input.dimensions = axes.size();
        for (std::size_t k = 0; k < axes.size(); ++k) {
            NpyArray array = open(*find(axes[k]));
            if (!array.is_column() || !array.is_float()) {
                throw bad_input(name_ + ": " + axes[k] + " is not an array of floats with shape (N,)");
            }
            if (k == 0) count = array.shape()[0];
            check_length(axes[k], array, count, axes[0]);
            array.read_numbers(input.points, k, axes.size());
        }
    }

    void check_length(const std::string& what, const NpyArray& array, std::size_t count,
                      const std::string& other) const {
        if (array.shape()[0] == count) return;
        throw bad_input(name_ + ": " + what + " has " + std::to_string(array.shape()[0]) + " numbers, " + other +
                        " has " + std::to_string(count));
    }

    // Returns whether the array holds a number, or a row of numbers, for each point.
    [[nodiscard]] static bool may_be_column(const NpyArray& array) {
        const auto& shape = array.shape();
        return (shape.size() == 1 || (shape.size() == 2 && shape[1] > 0)) && array.is_number();
    }

    void read_column(const std::string& name, bool carried, Input& input) const {
        const ZipMember* const member = find(name);
        if (!member && request_.columns_may_lack) return;
        if (!member) throw no_array(name);
        NpyArray array = open(*member);
        if (!may_be_column(array))
            throw bad_input(name_ + ": " + name + " is not an array with numbers for each point");
        check_length(name, array, input.size(), "the array of points");
        const auto width = static_cast<std::size_t>(array.is_column() ? 1 : array.shape()[1]);
        if (width > max_columns) throw bad_input(name_ + ": " + name + " has rows of " + columns_text(width));
        InputColumn& column =
            input.columns.emplace_back(InputColumn{.name = name, .width = width, .keeps_integers = carried});
        if (array.is_float()) return array.read_numbers(column.values);
        for (const std::int64_t whole : array.read_whole()) column.append_integer(whole);
    }

    // Adds all other arrays with a row for each point.
    void read_others(const ZipMember* points, Input& input) const {
        for (const ZipMember& member : members_) {
            const std::string name = plain_name(member);
            const bool axis = !points && std::ranges::count(axis_names(), name) > 0;
            const bool named = std::ranges::find(input.columns, name, &InputColumn::name) != input.columns.end();
            if (&member == points || axis || named || name == "ids" || name == "id" || !member.name.ends_with(".npy"))
                continue;
            const NpyArray array = open(member);
            const bool fits = may_be_column(array) && array.shape()[0] == input.size();
            if (fits && (array.is_column() || array.shape()[1] <= max_columns)) read_column(name, true, input);
        }
    }

    const std::string& name_;
    const ReadRequest& request_;
    std::vector<ZipMember> members_;
};

}  // namespace

Input parse_npz(std::string_view bytes, const std::string& name, const ReadRequest& request) {
    return NpzReader(bytes, name, request).read();
}

}  // namespace clvotess

// Text rows, in blocks that threads make.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "files/output_file.hpp"
#include "in_order.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

constexpr double radius_of_voropp = 0.5;  // what Voro++ prints for %r when there are no radii

using Point = std::array<double, 3>;
using Polygon = std::span<const std::int32_t>;

class TextWriter {
public:
    // wrapped: the points inside of a periodic domain, around which cells lie; may be empty without %c and %p.
    TextWriter(const OutputData& data, std::span<const double> wrapped, bool ids_ascend)
        : data_(data),
          wrapped_(wrapped),
          places_(data.format.like_voropp() ? wrapped : data.input.points),
          cells_(data.tessellation),
          size_(size_of_vectors(cells_)),
          indices_(cells_.indices()),
          areas_(cells_.face_areas()),
          probed_(cells_.probed()),
          subset_(cells_.is_subset()),
          ids_ascend_(ids_ascend) {
        if (data_.format.like_voropp()) buffer_.set_digits(6);
    }

    // Returns the rows of cells begin .. end - 1.
    OutputBuffer rows(std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            ordered_ = false;
            if (data_.format.like_voropp() && cells_.status()[i] != votess::CellStatus::certified) continue;
            for (const FormatPiece& piece : data_.format.pieces()) {
                if (piece.code == 0) {
                    buffer_.put(piece.literal);
                } else {
                    put(piece.code, i);
                }
            }
            for (const InputColumn& column : data_.carried) {
                if (column.of_words) {
                    buffer_.put(' ');
                    buffer_.put(column.words[i]);
                    continue;
                }
                for (std::size_t k = 0; k < column.width; ++k) {
                    buffer_.put(' ');
                    if (column.of_integers) {
                        buffer_.put_number(column.integer(column.width * i + k));
                    } else {
                        buffer_.put_number(column.values[column.width * i + k]);
                    }
                }
            }
            buffer_.put('\n');
        }
        return std::move(buffer_);
    }

private:
    void put(char code, std::size_t i) {
        const double* const seed = places_.data() + size_ * i;
        switch (code) {
            case 'i':
                return buffer_.put_number(id_of(i));
            case 'x':
                return buffer_.put_number(seed[0]);
            case 'y':
                return buffer_.put_number(seed[1]);
            case 'z':
                return buffer_.put_number(seed[2]);
            case 'q':
                return buffer_.put_vector({seed, size_});
            case 'r':
                return buffer_.put_number(data_.radii.empty() ? radius_of_voropp : data_.radii[i]);
            case 'w':
                return buffer_.put_number(cells_.vertex_counts()[i]);
            case 'g':
                return buffer_.put_number(cells_.edge_counts()[i]);
            case 's':
                return buffer_.put_number(cells_.face_counts()[i]);
            case 'm': {
                const double radius = cells_.security_radii()[i] / 2;
                return buffer_.put_number(radius * radius);
            }
            case 'F':
                return buffer_.put_number(cells_.surface_areas()[i]);
            case 'v':
                return buffer_.put_number(cells_.volumes()[i]);
            case 'c': {
                Point centroid = point_of(cells_.centroids(), i);
                const Point origin = point_of(wrapped_, i);
                for (std::size_t k = 0; k < size_; ++k) centroid[k] -= origin[k];
                return buffer_.put_vector(std::span(centroid).first(size_));
            }
            case 'C': {
                return buffer_.put_vector(cells_.centroids().subspan(size_ * i, size_));
            }
            case 'p':
                return put_vertices(i, point_of(wrapped_, i));
            case 'P':
                return put_vertices(i, {});
            default:
                return put_of_faces(code, i);
        }
    }

    // Lists with an entry for each face follow the order of %n.
    void put_of_faces(char code, std::size_t i) {
        order_row(i);
        switch (code) {
            case 'n':
                return put_list(order_, [&](std::size_t entry) { buffer_.put_number(name_of(entry)); });
            case 'f':
                return put_list(order_, [&](std::size_t entry) { buffer_.put_number(areas_[entry]); });
            case 'l':
                return put_list(order_, [&](std::size_t entry) {
                    put_bracketed(cells_.face_normals().subspan(size_ * entry, size_));
                });
            case 'a':
                return put_list(order_, [&](std::size_t entry) { buffer_.put_number(polygon(entry).size()); });
            case 'e':
                return put_list(order_, [&](std::size_t entry) { buffer_.put_number(perimeter(polygon(entry))); });
            case 't':
                return put_list(order_, [&](std::size_t entry) { put_polygon(i, polygon(entry)); });
            case 'E': {
                double twice = 0;  // each edge belongs to two faces
                for (const std::size_t entry : order_) twice += perimeter(polygon(entry));
                return buffer_.put_number(twice / 2);
            }
            case 'o':
                return put_vertex_orders(i);
            default:
                return put_size_table();
        }
    }

    template <typename List, typename Put>
    void put_list(const List& list, Put put_one) {
        bool first = true;
        for (const auto& item : list) {
            if (!first) buffer_.put(' ');
            put_one(item);
            first = false;
        }
    }

    void put_bracketed(std::span<const double> vector) {
        buffer_.put('(');
        buffer_.put_vector(vector, ',');
        buffer_.put(')');
    }

    // Returns row i of vectors; z is 0 in the plane.
    [[nodiscard]] Point point_of(std::span<const double> vectors, std::size_t i) const {
        Point point{};
        for (std::size_t k = 0; k < size_; ++k) point[k] = vectors[size_ * i + k];
        return point;
    }

    [[nodiscard]] std::int64_t id_of(std::size_t i) const {
        return data_.input.ids.empty() ? static_cast<std::int64_t>(i) : data_.input.ids[i];
    }

    // Returns the id of a neighbor, or the number of a wall, for an entry of indices. Probes list seeds by index. A
    // subset has neighbors among all points.
    [[nodiscard]] std::int64_t name_of(std::size_t entry) const {
        const std::int32_t j = indices_[entry];
        if (j < 0 || probed_) return j;
        if (subset_) return data_.all_ids.empty() ? j : data_.all_ids[static_cast<std::size_t>(j)];
        return id_of(static_cast<std::size_t>(j));
    }

    // Fills order_ with the entries of row i: walls first, then by id. Where ids ascend, indices are already in that
    // order.
    void order_row(std::size_t i) {
        if (ordered_) return;
        ordered_ = true;
        order_.resize(cells_.neighbors(i).size());
        std::iota(order_.begin(), order_.end(), static_cast<std::size_t>(cells_.indptr()[i]));
        if (ids_ascend_) return;
        keys_.clear();
        for (const std::size_t entry : order_) keys_.emplace_back(indices_[entry] >= 0, name_of(entry), entry);
        std::ranges::sort(keys_);
        for (std::size_t k = 0; k < order_.size(); ++k) order_[k] = std::get<2>(keys_[k]);
    }

    [[nodiscard]] Polygon polygon(std::size_t entry) const {
        const auto begin = static_cast<std::size_t>(cells_.face_offsets()[entry]);
        const auto end = static_cast<std::size_t>(cells_.face_offsets()[entry + 1]);
        return cells_.face_vertices().subspan(begin, end - begin);
    }

    [[nodiscard]] Polygon vertices_of(std::size_t i) const {
        const auto begin = static_cast<std::size_t>(cells_.cell_vertex_indptr()[i]);
        const auto end = static_cast<std::size_t>(cells_.cell_vertex_indptr()[i + 1]);
        return cells_.cell_vertex_indices().subspan(begin, end - begin);
    }

    [[nodiscard]] const double* vertex(std::int32_t index) const {
        return cells_.vertices().data() + size_ * static_cast<std::size_t>(index);
    }

    // Returns the number of a mesh vertex among those of the cell, which ascend; -1 for infinity.
    [[nodiscard]] std::int64_t local_number(Polygon vertices, std::int32_t index) const {
        return index < 0 ? index : std::ranges::lower_bound(vertices, index) - vertices.begin();
    }

    // Only infinity, as a neighbor, has no corners.
    [[nodiscard]] double perimeter(Polygon corners) const {
        if (corners.empty() || std::ranges::count(corners, -1) > 0) return std::numeric_limits<double>::infinity();
        double length = 0;
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const double* const a = vertex(corners[k]);
            const double* const b = vertex(corners[k + 1 < corners.size() ? k + 1 : 0]);
            length += std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
        }
        return length;
    }

    void put_vertices(std::size_t i, const Point& origin) {
        put_list(vertices_of(i), [&](std::int32_t index) {
            Point at = point_of(cells_.vertices(), static_cast<std::size_t>(index));
            for (std::size_t k = 0; k < size_; ++k) at[k] -= origin[k];
            put_bracketed(std::span(at).first(size_));
        });
    }

    // Numbers count the cell's vertices in %p and %P, and -1 is infinity. The order is clockwise seen from outside, as
    // in Voro++.
    void put_polygon(std::size_t i, Polygon corners) {
        const Polygon vertices = vertices_of(i);
        buffer_.put('(');
        for (std::size_t k = 0; k < corners.size(); ++k) {
            if (k > 0) buffer_.put(',');
            buffer_.put_number(local_number(vertices, corners[corners.size() - 1 - k]));
        }
        buffer_.put(')');
    }

    // Counts faces, because equally many edges and faces meet at a vertex of a polyhedron.
    void put_vertex_orders(std::size_t i) {
        const Polygon vertices = vertices_of(i);
        counts_.assign(vertices.size(), 0);
        for (const std::size_t entry : order_) {
            for (const std::int32_t index : polygon(entry))
                if (index >= 0) ++counts_[static_cast<std::size_t>(local_number(vertices, index))];
        }
        put_list(counts_, [&](std::size_t count) { buffer_.put_number(count); });
    }

    // Writes how many faces have 0, 1, 2, ... edges.
    void put_size_table() {
        counts_.clear();
        for (const std::size_t entry : order_) {
            const std::size_t size = polygon(entry).size();
            if (size >= counts_.size()) counts_.resize(size + 1);
            ++counts_[size];
        }
        put_list(counts_, [&](std::size_t count) { buffer_.put_number(count); });
    }

    const OutputData& data_;
    std::span<const double> wrapped_, places_;  // places_: for %q, as voro++ prints them
    const votess::Tessellation& cells_;
    std::size_t size_;  // of vectors
    OutputBuffer buffer_;
    std::span<const std::int32_t> indices_;
    std::span<const double> areas_;
    bool probed_, subset_, ids_ascend_;
    std::vector<std::size_t> order_, counts_;
    std::vector<std::tuple<bool, std::int64_t, std::size_t>> keys_;  // scratch of order_row(): is a seed, name, entry
    bool ordered_ = false;                                           // whether order_ belongs to the current row
};

}  // namespace

void write_text(OutputFile& file, const OutputData& data) {
    constexpr std::size_t block = 4096;
    std::vector<double> wrapped;
    if (data.format.like_voropp() || data.format.has_any("cp"))
        wrapped = votess::wrapped_points(data.tessellation, data.input.points);
    const bool subset = data.tessellation.is_subset();
    const bool ids_ascend = std::ranges::is_sorted(subset ? data.all_ids : std::span(data.input.ids));
    const std::size_t count = data.tessellation.size();
    if (data.place != FramePlace::alone) file.write(frame_line(data.input, count, "points"));
    in_order((count + block - 1) / block, data.threads,
             [&](std::size_t k) {
                 return TextWriter(data, wrapped, ids_ascend).rows(k * block, std::min(count, (k + 1) * block));
             },
             [&](const OutputBuffer& rows) {
                 file.write(rows.bytes());
                 return true;
             });
}

}  // namespace clvotess

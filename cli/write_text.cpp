// Text rows, streamed through a buffer of fixed size.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <numeric>

#include "atomic_file.hpp"
#include "output.hpp"

namespace clvotess {
namespace {

class RowBuffer {
public:
    explicit RowBuffer(OutputFile& file) : file_(file), bytes_(capacity, '\0') {}

    void put(std::string_view text) {
        if (text.size() > capacity - used_) flush();
        if (text.size() > capacity) return file_.write(text);
        std::memcpy(bytes_.data() + used_, text.data(), text.size());
        used_ += text.size();
    }

    void put(char c) {
        make_room();
        bytes_[used_++] = c;
    }

    template <typename Number>
    void put_number(Number value) {
        make_room();
        if constexpr (std::is_floating_point_v<Number>) {
            if (std::isnan(value)) return put(std::string_view("nan"));  // never -nan
        }
        char* const begin = bytes_.data() + used_;
        used_ += static_cast<std::size_t>(std::to_chars(begin, begin + longest_number, value).ptr - begin);
    }

    void put_three(double x, double y, double z) {
        put_number(x);
        put(' ');
        put_number(y);
        put(' ');
        put_number(z);
    }

    void flush() {
        file_.write(std::string_view(bytes_.data(), used_));
        used_ = 0;
    }

private:
    static constexpr std::size_t capacity = std::size_t{1} << 20;
    static constexpr std::size_t longest_number = 32;

    void make_room() {
        if (capacity - used_ < longest_number) flush();
    }

    OutputFile& file_;
    std::string bytes_;
    std::size_t used_ = 0;
};

class TextWriter {
public:
    TextWriter(OutputFile& file, const OutputData& data) : data_(data), buffer_(file) {}

    void write() {
        const std::size_t count = data_.tessellation.size();
        for (std::size_t i = 0; i < count; ++i) {
            for (const FormatPiece& piece : data_.format.pieces()) put(piece, i);
            buffer_.put('\n');
        }
        buffer_.flush();
    }

private:
    void put(const FormatPiece& piece, std::size_t i) {
        const votess::Tessellation& cells = data_.tessellation;
        const double* const seed = data_.input.points.data() + 3 * i;
        switch (piece.code) {
            case 'i':
                buffer_.put_number(id_of(i));
                break;
            case 'x':
                buffer_.put_number(seed[0]);
                break;
            case 'y':
                buffer_.put_number(seed[1]);
                break;
            case 'z':
                buffer_.put_number(seed[2]);
                break;
            case 'q':
                buffer_.put_three(seed[0], seed[1], seed[2]);
                break;
            case 'w':
                buffer_.put_number(cells.vertex_counts()[i]);
                break;
            case 's':
                buffer_.put_number(cells.face_counts()[i]);
                break;
            case 'n':
                put_neighbors(i);
                break;
            case 'f':
                put_areas(i);
                break;
            case 'F': {
                const auto areas = areas_of(i);
                buffer_.put_number(std::accumulate(areas.begin(), areas.end(), 0.0));
                break;
            }
            case 'v':
                buffer_.put_number(cells.volumes()[i]);
                break;
            case 'c': {
                const double* const centroid = cells.centroids().data() + 3 * i;
                buffer_.put_three(centroid[0] - seed[0], centroid[1] - seed[1], centroid[2] - seed[2]);
                break;
            }
            default:
                buffer_.put(piece.literal);
                break;
        }
    }

    [[nodiscard]] std::int64_t id_of(std::size_t i) const {
        return data_.input.ids.empty() ? static_cast<std::int64_t>(i) : data_.input.ids[i];
    }

    [[nodiscard]] std::span<const double> areas_of(std::size_t i) const {
        const votess::Tessellation& cells = data_.tessellation;
        return cells.face_areas().subspan(static_cast<std::size_t>(cells.indptr()[i]), cells.neighbors(i).size());
    }

    // In the order of put_neighbors().
    void put_areas(std::size_t i) {
        const auto areas = areas_of(i);
        const auto indices = data_.tessellation.neighbors(i);
        order_.resize(areas.size());
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        if (!data_.input.ids.empty()) {
            std::ranges::stable_sort(order_, {}, [&](std::size_t k) {
                const std::int32_t j = indices[k];
                return std::pair(j >= 0, j < 0 ? j : id_of(static_cast<std::size_t>(j)));
            });
        }
        for (std::size_t k = 0; k < order_.size(); ++k) {
            if (k > 0) buffer_.put(' ');
            buffer_.put_number(areas[order_[k]]);
        }
    }

    // Walls first, then ids in ascending order, as the library orders indices.
    void put_neighbors(std::size_t i) {
        row_.clear();
        for (const std::int32_t j : data_.tessellation.neighbors(i)) {
            row_.push_back(j < 0 ? j : id_of(static_cast<std::size_t>(j)));
        }
        if (!data_.input.ids.empty()) {
            const auto indices = data_.tessellation.neighbors(i);
            const auto walls = std::count_if(indices.begin(), indices.end(), [](std::int32_t j) { return j < 0; });
            std::sort(row_.begin() + walls, row_.end());
        }
        bool first = true;
        for (const std::int64_t id : row_) {
            if (!first) buffer_.put(' ');
            buffer_.put_number(id);
            first = false;
        }
    }

    const OutputData& data_;
    RowBuffer buffer_;
    std::vector<std::int64_t> row_;
    std::vector<std::size_t> order_;
};

}  // namespace

void write_text(OutputFile& file, const OutputData& data) {
    TextWriter(file, data).write();
}

}  // namespace clvotess

#include "cpu/cell_writer.hpp"

#include <algorithm>
#include <numeric>

#include "cpu/seed_images.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t usual_rows = std::size_t{1} << 16;  // ids of a block; memory that is not needed is not touched

}  // namespace

void CellWriter::begin_job(const Job& job, const StarKernels& kernels, ResultBuilder& out) {
    kernels_ = &kernels;
    out_ = &out;
    want_ = job.options.want;
    want_.neighbors = want_.neighbors || want_.areas;
    walls_ = job.options.walls;
    unscale_ = 1 / job.scale;
    counters_ = {};
    rows_size_ = 0;
    lengths_.clear();
}

void CellWriter::prefetch(std::size_t seed) const {
    const auto input = static_cast<std::size_t>(seeds_.input[seed]);
    if (want_.volumes) __builtin_prefetch(&out_->volumes()[input], 1);
    if (want_.centroids) __builtin_prefetch(&out_->centroids()[3 * input], 1);
}

bool CellWriter::write(std::size_t seed, Star& star) {
    if (need_geometry() && !star.measure(geometry_)) return false;
    const auto faces = star.faces();
    counters_.faces += faces.size();
    counters_.exact_cells += star.used_exact() ? 1 : 0;
    if (want_.neighbors) write_row(faces, want_.areas ? geometry_.areas.data() : nullptr);
    write_geometry(seed, geometry_.volume, geometry_.centroid.data());
    write_counts(seed, faces.size(), static_cast<std::uint32_t>(star.edge_count()),
                 static_cast<std::uint32_t>(star.vertex_count()));
    return true;
}

void CellWriter::write(std::size_t seed, Cell& cell) {
    counters_.exact_cells += cell.used_exact() ? 1 : 0;
    if (cell.empty()) return write_empty(seed);
    std::span<const std::int32_t> planes;
    if (need_geometry() || want_.counts || cell.met_tie()) {
        cell.canonical_faces(faces_);
        planes = faces_.planes;
    } else {
        cell.face_planes(planes_);
        planes = planes_;
    }
    constexpr std::size_t least_faces = 4;
    if (planes.size() < least_faces) return write_empty(seed);  // flat
    counters_.faces += planes.size();
    if (need_geometry()) {
        const CellGeometry geometry = cell.measure(faces_, want_.areas ? &face_areas_ : nullptr);
        write_geometry(seed, geometry.volume, geometry.centroid.data());
    }
    if (want_.neighbors) {
        ids_.clear();
        for (const std::int32_t p : planes) ids_.push_back(cell.planes()[p].id);
        write_row(ids_, want_.areas ? face_areas_.data() : nullptr);
    }
    write_counts(seed, planes.size(), faces_.edge_count, faces_.vertex_count);
}

void CellWriter::write_empty(std::size_t seed) {
    out_->set_empty(static_cast<std::size_t>(seeds_.input[seed]), CellStatus::empty);
    ++counters_.empty_cells;
    leave_out();
}

void CellWriter::write_geometry(std::size_t seed, double volume, const double* centroid) {
    const auto input = static_cast<std::size_t>(seeds_.input[seed]);
    if (want_.volumes) out_->volumes()[input] = volume * unscale_ * unscale_ * unscale_;
    if (!want_.centroids) return;
    const double p[3] = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    for (int k = 0; k < 3; ++k) out_->centroids()[3 * input + k] = (centroid[k] + p[k]) * unscale_;
}

void CellWriter::write_counts(std::size_t seed, std::size_t faces, std::uint32_t edges, std::uint32_t vertices) {
    if (!want_.counts) return;
    const auto input = static_cast<std::size_t>(seeds_.input[seed]);
    out_->face_counts()[input] = static_cast<std::uint32_t>(faces);
    out_->edge_counts()[input] = edges;
    out_->vertex_counts()[input] = vertices;
}

std::int32_t CellWriter::input_of(std::int32_t id) const {
    const std::int32_t home = seeds_.images == nullptr ? id : seeds_.images->home(id);
    return seeds_.input[static_cast<std::size_t>(home)];
}

// The same id may stand there several times.
void CellWriter::rank_images(std::span<const std::int32_t> ids) {
    order_.resize(ids.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::ranges::stable_sort(order_, {}, [&](std::uint16_t k) { return ids[k]; });
    for (std::size_t place = 0; place < order_.size(); ++place) places_[order_[place]] = static_cast<std::uint16_t>(place);
}

void CellWriter::write_row(std::span<const std::int32_t> ids, const double* areas) {
    if (rows_.size() < rows_size_ + 2 * ids.size()) {
        rows_.resize(std::max(usual_rows, 2 * rows_.size()) + 2 * ids.size());
    }
    if (areas != nullptr && areas_.size() < rows_.size()) areas_.resize(rows_.size());
    // First behind its place, in the order of the faces, then sorted into it.
    std::int32_t* row = rows_.data() + rows_size_;
    std::int32_t* unsorted = row + ids.size();
    int count = 0;
    if (areas != nullptr && kept_areas_.size() < ids.size()) kept_areas_.resize(2 * ids.size());
    for (std::size_t k = 0; k < ids.size(); ++k) {
        const std::int32_t id = ids[k];
        unsorted[count] = id < 0 ? id : input_of(id);
        if (areas != nullptr) kept_areas_[static_cast<std::size_t>(count)] = areas[k];
        count += (id >= 0 || walls_) ? 1 : 0;
    }
    if (places_.size() < ids.size()) places_.resize(2 * ids.size());
    if (seeds_.images == nullptr)
        kernels_->rank(unsorted, count, places_.data());
    else
        rank_images({unsorted, static_cast<std::size_t>(count)});
    for (int k = 0; k < count; ++k) row[places_[static_cast<std::size_t>(k)]] = unsorted[k];
    if (areas != nullptr)
        for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
            areas_[rows_size_ + places_[k]] = kept_areas_[k] * unscale_ * unscale_;
    rows_size_ += static_cast<std::size_t>(count);
    lengths_.push_back(static_cast<std::uint32_t>(count));
}

void CellWriter::end_block(std::span<const std::int32_t> cells) {
    out_->add_rows(cells, lengths_, std::span(rows_).first(rows_size_),
                   want_.areas ? std::span<const double>(areas_).first(rows_size_) : std::span<const double>{});
    rows_size_ = 0;
    lengths_.clear();
}

}  // namespace votess::cpu

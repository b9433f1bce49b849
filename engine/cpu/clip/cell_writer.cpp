#include "cpu/clip/cell_writer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "cpu/sort/seed_images.hpp"
#include "input/implied_wants.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t usual_rows = std::size_t{1} << 16;  // ids of a block; memory that is not needed is not touched

std::array<std::int8_t, 3> narrow(const exact::Shift& shift) {
    std::array<std::int8_t, 3> result{};
    for (std::size_t j = 0; j < 3; ++j) {
        result[j] = static_cast<std::int8_t>(shift[j]);
        if (result[j] != shift[j])
            throw Error(ErrorCode::unsupported,
                        "the cell is so skewed that neighbors lie more than 127 box vectors away: give shorter vectors "
                        "that span the same lattice");
    }
    return result;
}

}  // namespace

void CellWriter::begin_job(const Job& job, const StarKernels& kernels, ResultBuilder& out) {
    kernels_ = &kernels;
    out_ = &out;
    want_ = job.options.want;
    walls_ = job.options.list_walls;
    domain_ = job.domain.get();
    probe_number_ = job.probes_of.value_or(0);
    probe_id_ = std::numeric_limits<std::int32_t>::min();
    moved_ = seeds_.images != nullptr && seeds_.images->has_moves();
    periodic_ = job.domain->is_periodic();
    placed_ = needs_geometry(want_);
    measured_ = want_.volumes || want_.centroids || want_.areas || want_.surfaces || want_.radii;
    ranked_ = measured_ || want_.neighbors;
    row_order_ = job.row_order;
    unscale_ = 1 / job.scale;
    counters_ = {};
    rows_size_ = 0;
    resize_beside_rows();  // an earlier job may have wanted none of them
    lengths_.clear();
    polygon_writer_.clear();
}

void CellWriter::prefetch(std::size_t seed) const {
    const auto input = static_cast<std::size_t>(seeds_.input[seed]);
    if (want_.volumes) __builtin_prefetch(&out_->volumes()[input], 1);
    if (want_.centroids) __builtin_prefetch(&out_->centroids()[3 * input], 1);
}

void CellWriter::leave_out() {
    lengths_.push_back(0);
    if (want_.vertices) polygon_writer_.append_none();
}

bool CellWriter::write(Star& star) {
    if (star.faces().empty()) {
        counters_.exact_cells += star.used_exact() ? 1 : 0;
        write_empty();
        return true;
    }
    const auto faces = star.faces();
    face_shifts_.clear();
    if (periodic_) find_shifts(faces);
    if (ranked_) rank_faces(faces);
    if (measured_) {
        CellShape* shape = star.shape(std::span(ranks_).first(faces.size()));
        if (shape == nullptr || !kernels_->measure(*shape, measures_)) return false;
        face_areas_ = std::span(measures_.areas).first(faces.size());
        write_measures();
    } else if (want_.vertices && !star.knows_vertices()) {
        return false;
    }
    counters_.faces += faces.size();
    counters_.exact_cells += star.used_exact() ? 1 : 0;
    if (want_.normals) star.normals(face_normals_);
    if (want_.neighbors) write_row();
    if (want_.vertices) {
        star.polygons(std::span(ranks_).first(faces.size()), polygons_);
        // Their cells lie elsewhere in the domain, each by a shift of its own.
        if (moved_) polygons_.shared.clear();
        write_polygons();
    }
    write_counts(faces.size(), static_cast<std::uint32_t>(star.edge_count()),
                 static_cast<std::uint32_t>(star.vertex_count()));
    return true;
}

void CellWriter::write(Cell& cell) {
    counters_.exact_cells += cell.used_exact() ? 1 : 0;
    if (cell.empty()) return write_empty();
    std::span<const std::int32_t> planes;
    if (placed_ || want_.counts || cell.met_tie()) {
        cell.canonical_faces(faces_);
        planes = faces_.planes;
    } else {
        cell.face_planes(planes_);
        planes = planes_;
    }
    constexpr std::size_t least_faces = 4;
    if (planes.size() < least_faces) return write_empty();  // flat
    counters_.faces += planes.size();
    ids_.clear();
    face_normals_.clear();
    face_shifts_.clear();
    for (const std::int32_t p : planes) {
        const CellPlane& plane = cell.planes()[static_cast<std::size_t>(p)];
        ids_.push_back(plane.id);
        if (periodic_) face_shifts_.push_back(plane.shift);
        if (want_.normals) face_normals_.push_back(unit_vector(plane.n));
    }
    if (moved_) count_from_domain(ids_);
    if (ranked_) rank_faces(ids_);
    if (measured_) measure(cell);
    if (want_.neighbors) write_row();
    if (want_.vertices) {
        read_polygons(cell, faces_, std::span(ranks_).first(faces_ranked_), polygons_);
        write_polygons();
    }
    write_counts(planes.size(), faces_.edge_count, faces_.vertex_count);
}

// As the walk's cells are measured, so that it does not matter how a cell was found; else from exact corners.
void CellWriter::measure(const Cell& cell) {
    const std::span ranks = std::span(ranks_).first(faces_ranked_);
    shape_.weighted = domain_->has_weights();
    if (shape_reader_.read(cell, faces_, ranks, shape_) && kernels_->measure(shape_, measures_)) {
        face_areas_ = std::span(measures_.areas).first(faces_.size());
    } else {
        measure_exactly(cell, faces_, ranks, measures_, many_areas_);
        face_areas_ = many_areas_;
    }
    write_measures();
}

void CellWriter::write_none(std::size_t output, CellStatus status) {
    out_->set_empty(output, status);
    ++counters_.empty_cells;
    leave_out();
}

void CellWriter::write_measures() {
    const CellMeasures& m = measures_;
    if (want_.volumes) out_->volumes()[output_] = m.volume * unscale_ * unscale_ * unscale_;
    if (want_.centroids) {
        const exact::Point p = place();
        for (std::size_t k = 0; k < 3; ++k) out_->centroids()[3 * output_ + k] = (m.centroid[k] + p[k]) * unscale_;
    }
    if (want_.surfaces)
        out_->surface_areas()[output_] =
            std::accumulate(face_areas_.begin(), face_areas_.end(), 0.0) * unscale_ * unscale_;
    if (want_.radii) out_->security_radii()[output_] = 2 * std::sqrt(m.farthest_squared) * unscale_;
}

void CellWriter::write_counts(std::size_t faces, std::uint32_t edges, std::uint32_t vertices) {
    if (!want_.counts) return;
    out_->face_counts()[output_] = static_cast<std::uint32_t>(faces);
    out_->edge_counts()[output_] = edges;
    out_->vertex_counts()[output_] = vertices;
}

std::int32_t CellWriter::input_of(std::int32_t id) const {
    if (id == probe_id_) return probe_number_;
    const std::int32_t home = seeds_.images == nullptr ? id : seeds_.images->home(id);
    return seeds_.input[static_cast<std::size_t>(home)];
}

// Nothing is found where all are seeds themselves by no shift, as they are away from the faces of the domain.
// An image may have no shift either: one that was moved into the reduced cell, and lies beside it.
void CellWriter::find_shifts(std::span<const std::int32_t> ids) {
    const SeedImages& images = *seeds_.images;
    const bool any_image = std::ranges::any_of(ids, [&](auto id) { return id >= 0 && images.is_image(id); });
    if (!moved_ && !any_image) return;
    for (const std::int32_t id : ids) face_shifts_.push_back(id < 0 ? exact::Shift{} : images.shift(id));
    if (moved_) count_from_domain(ids);
    if (!any_image && std::ranges::all_of(face_shifts_, [](const auto& shift) { return shift == exact::Shift{}; }))
        face_shifts_.clear();
}

void CellWriter::count_from_domain(std::span<const std::int32_t> ids) {
    for (std::size_t f = 0; f < ids.size(); ++f) {
        if (ids[f] < 0) continue;
        const exact::Shift more = shift_in_domain(ids[f]);
        for (std::size_t j = 0; j < 3; ++j) face_shifts_[f][j] += more[j];
    }
}

void CellWriter::aim(std::size_t output, const Probe& probe) {
    output_ = output;
    probe_ = &probe;
    probe_id_ = static_cast<std::int32_t>(seeds_.places());
    moved_ = seeds_.images != nullptr && (seeds_.images->has_moves() || probe.place.move != exact::Shift{});
}

exact::Shift CellWriter::shift_in_domain(std::int32_t id) const {
    const SeedImages& images = *seeds_.images;
    if (probe_ == nullptr) return images.shift_in_domain(images.home(id), seed_);
    if (id == probe_id_) return {};
    return images.shift_in_domain(images.home(id), probe_->place.move);
}

exact::Point CellWriter::place() const {
    if (probe_ != nullptr) {
        const auto& [at, low, by, move] = probe_->place;
        if (move == exact::Shift{}) return at;
        const exact::Shift shift{by[0] - move[0], by[1] - move[1], by[2] - move[2]};
        const auto moved = exact::differences({}, exact::Plane::bisector(probe_->x, shift, domain_->lattice));
        return {moved.x[0].high, moved.x[1].high, moved.x[2].high};
    }
    if (seeds_.images != nullptr) return seeds_.images->place_in_domain(seed_);
    return {seeds_.x[seed_], seeds_.y[seed_], seeds_.z[seed_]};
}

void CellWriter::resize_beside_rows() {
    if (want_.areas) areas_.resize(rows_.size());
    if (want_.normals) normals_.resize(3 * rows_.size());
    if (periodic_) shifts_.resize(3 * rows_.size());
}

void CellWriter::make_room(std::size_t faces) {
    rows_.resize(std::max({usual_rows, 2 * rows_.size(), rows_size_ + faces}));
    resize_beside_rows();
}

void CellWriter::rank_faces(std::span<const std::int32_t> ids) {
    const std::size_t count = ids.size();
    if (names_.size() < std::max(count, most_ranked)) {
        names_.resize(std::max(count, most_ranked));
        ranks_.resize(names_.size());
    }
    faces_ranked_ = count;
    std::size_t walls = 0;
    const bool images = !face_shifts_.empty();
    const std::int32_t* input = seeds_.input.begin();
    std::int32_t* names = names_.data();
    for (std::size_t f = 0; f < count; ++f) {
        const std::int32_t id = ids[f];
        walls += id < 0 ? 1 : 0;
        names[f] = id < 0 ? id : images ? input_of(id) : input[id];
    }
    hidden_ = walls_ ? 0 : walls;
    const std::int32_t* keys = names_.data();
    if (!row_order_.empty()) {
        keys_.resize(count);
        for (std::size_t f = 0; f < count; ++f)
            keys_[f] = names_[f] < 0 ? names_[f] : row_order_[static_cast<std::size_t>(names_[f])];
        keys = keys_.data();
    }
    if (count > most_ranked) return rank_labels();
    kernels_->rank(keys, static_cast<int>(count), ranks_.data());
    if (face_shifts_.empty()) return;
    // In a small periodic box a seed is a neighbor more than once.
    std::array<bool, most_ranked> taken{};
    for (std::size_t f = 0; f < count; ++f) {
        if (std::exchange(taken[ranks_[f]], true)) return rank_labels();
    }
}

void CellWriter::rank_labels() {
    const std::vector<std::int32_t>& keys = row_order_.empty() ? names_ : keys_;
    const auto label = [&](std::uint32_t f) {
        return std::pair(keys[f], face_shifts_.empty() ? exact::Shift{} : face_shifts_[f]);
    };
    order_.resize(faces_ranked_);
    std::iota(order_.begin(), order_.end(), 0u);
    std::ranges::sort(order_, {}, label);
    for (std::size_t r = 0; r < order_.size(); ++r) ranks_[order_[r]] = static_cast<std::uint32_t>(r);
}

void CellWriter::write_row() {
    const std::size_t faces = faces_ranked_, count = faces - hidden_;
    if (rows_size_ + faces > rows_.size()) make_room(faces);
    const std::size_t begin = rows_size_;
    const auto for_listed = [&](auto visit) {  // a face and its entry
        for (std::size_t f = 0; f < faces; ++f)
            if (ranks_[f] >= hidden_) visit(f, begin + ranks_[f] - hidden_);
    };
    std::int32_t* row = rows_.data() + begin;
    const std::uint32_t* rank = ranks_.data();
    if (hidden_ == 0)
        for (const std::int32_t name : std::span(names_).first(faces)) row[*rank++] = name;
    else
        for_listed([&](std::size_t f, std::size_t entry) { rows_[entry] = names_[f]; });
    if (want_.areas) {
        const double square = unscale_ * unscale_;
        for (std::size_t k = 0; k < count; ++k) areas_[begin + k] = face_areas_[hidden_ + k] * square;
    }
    if (want_.normals)
        for_listed(
            [&](std::size_t f, std::size_t entry) { std::ranges::copy(face_normals_[f], &normals_[3 * entry]); });
    if (periodic_ && face_shifts_.empty()) std::memset(&shifts_[3 * begin], 0, 3 * count);
    if (!face_shifts_.empty())
        for_listed(
            [&](std::size_t f, std::size_t entry) { std::ranges::copy(narrow(face_shifts_[f]), &shifts_[3 * entry]); });
    rows_size_ += count;
    lengths_.push_back(static_cast<std::uint32_t>(count));
}

void CellWriter::write_polygons() {
    labels_.resize(faces_ranked_);
    order_.resize(faces_ranked_);
    for (std::size_t f = 0; f < faces_ranked_; ++f) {
        labels_[f] = {names_[f], face_shifts_.empty() ? std::array<std::int8_t, 3>{} : narrow(face_shifts_[f])};
        order_[ranks_[f]] = static_cast<std::uint32_t>(f);
    }
    polygon_writer_.append(polygons_, labels_, order_, hidden_, place());
}

void CellWriter::end_block(std::span<const std::int32_t> cells) {
    const auto of = [this](const auto& values, bool wanted, std::size_t each) {
        return std::span(values).first(wanted ? each * rows_size_ : 0);
    };
    out_->add_rows(cells, lengths_, std::span(rows_).first(rows_size_),
                   {of(areas_, want_.areas, 1), of(normals_, want_.normals, 3), of(shifts_, periodic_, 3)});
    if (want_.vertices) out_->mesh().add(cells, polygon_writer_.block());
    rows_size_ = 0;
    lengths_.clear();
    polygon_writer_.clear();
}

}  // namespace votess::cpu

#include "cpu/clip/cell_writer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "cpu/sort/seed_images.hpp"
#include "input/implied_wants.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t usual_rows = std::size_t{1} << 20;  // ids of a block; memory that is not needed is not touched

// Keeps the first `kept` values.
template <class T>
void grow_to(Buffer<T>& values, std::size_t kept, std::size_t size) {
    Buffer<T> larger;
    larger.resize_uninitialized(size);
    std::copy_n(values.data(), kept, larger.data());
    values = std::move(larger);
}

[[noreturn]] void too_skewed() {
    throw Error(
        ErrorCode::unsupported,
        "the cell is so skewed that neighbors lie more than 127 box vectors away: give shorter vectors that span "
        "the same lattice");
}

inline void narrow(const exact::Shift& shift, std::int8_t* out) {
    for (std::size_t j = 0; j < 3; ++j) {
        out[j] = static_cast<std::int8_t>(shift[j]);
        if (out[j] != shift[j]) too_skewed();
    }
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
    plain_rows_ = !want_.normals && !want_.vertices;
    unscale_ = 1 / job.scale;
    counters_ = {};
    rows_size_ = 0;
    // As long as the rows of an earlier job.
    if (want_.areas) areas_.resize_uninitialized(rows_.size());
    if (want_.normals) normals_.resize_uninitialized(3 * rows_.size());
    if (periodic_) shifts_.resize_uninitialized(3 * rows_.size());
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
    if (measured_ ? !star.measure(geometry_) : placed_ && !star.knows_vertices()) return false;
    const auto faces = star.faces();
    counters_.faces += faces.size();
    counters_.exact_cells += star.used_exact() ? 1 : 0;
    if (want_.normals) star.normals(face_normals_);
    if (want_.neighbors) {
        face_shifts_.clear();
        if (moved_) find_shifts(faces);
        write_row({faces, face_shifts_, geometry_.areas.data(), face_normals_.data()});
    }
    if (want_.vertices) {
        rank_faces();
        star.polygons(ranks_, polygons_);
        // Their cells lie elsewhere in the domain, each by a shift of its own.
        if (moved_) polygons_.shared.clear();
        write_polygons();
    }
    write_geometry(geometry_.volume, geometry_.centroid.data());
    if (want_.surfaces || want_.radii)
        write_sizes(std::span(geometry_.areas).first(faces.size()), star.farthest_squared());
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
    if (measured_) {
        const CellGeometry geometry = cell.measure(faces_, want_.areas || want_.surfaces ? &face_areas_ : nullptr);
        write_geometry(geometry.volume, geometry.centroid.data());
    }
    if (want_.neighbors) {
        ids_.clear();
        face_normals_.clear();
        face_shifts_.clear();
        for (const std::int32_t p : planes) {
            ids_.push_back(cell.planes()[p].id);
            if (periodic_) face_shifts_.push_back(cell.planes()[p].shift);
            if (want_.normals) face_normals_.push_back(unit_vector(cell.planes()[p].n));
        }
        if (moved_) count_from_domain(ids_);
        write_row({ids_, face_shifts_, face_areas_.data(), face_normals_.data()});
    }
    if (want_.vertices) {
        rank_faces();
        read_polygons(cell, faces_, ranks_, polygons_);
        write_polygons();
    }
    if (want_.surfaces || want_.radii) write_sizes(face_areas_, cell.farthest_squared(faces_));
    write_counts(planes.size(), faces_.edge_count, faces_.vertex_count);
}

void CellWriter::write_none(std::size_t output, CellStatus status) {
    out_->set_empty(output, status);
    ++counters_.empty_cells;
    leave_out();
}

void CellWriter::write_geometry(double volume, const double* centroid) {
    if (want_.volumes) out_->volumes()[output_] = volume * unscale_ * unscale_ * unscale_;
    if (!want_.centroids) return;
    const exact::Point p = place();
    for (int k = 0; k < 3; ++k) out_->centroids()[3 * output_ + k] = (centroid[k] + p[k]) * unscale_;
}

void CellWriter::write_sizes(std::span<const double> areas, double farthest_squared) {
    if (want_.surfaces)
        out_->surface_areas()[output_] = std::accumulate(areas.begin(), areas.end(), 0.0) * unscale_ * unscale_;
    if (want_.radii) out_->security_radii()[output_] = 2 * std::sqrt(farthest_squared) * unscale_;
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

// Leaves face_shifts_ empty where all are seeds themselves by no shift, as they are away from the faces of the domain.
// An image may have no shift either: one that was moved into the reduced cell, and lies beside it.
void CellWriter::find_shifts(std::span<const std::int32_t> ids) {
    const SeedImages& images = *seeds_.images;
    const bool any_image = std::ranges::any_of(ids, [&](auto id) { return id >= 0 && images.is_image(id); });
    if (!moved_ && !any_image) return;
    face_shifts_.resize(ids.size());
    for (std::size_t f = 0; f < ids.size(); ++f) face_shifts_[f] = ids[f] < 0 ? exact::Shift{} : images.shift(ids[f]);
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

void CellWriter::grow(std::size_t ids) {
    const std::size_t size = std::max(usual_rows, 2 * ids);
    grow_to(rows_, rows_size_, size);
    if (want_.areas) grow_to(areas_, rows_size_, size);
    if (want_.normals) grow_to(normals_, 3 * rows_size_, 3 * size);
    if (periodic_) grow_to(shifts_, 3 * rows_size_, 3 * size);
}

void CellWriter::write_row(Faces faces) {
    make_room(faces.ids.size());
    std::optional<std::size_t> count;
    if (plain_rows_ && faces.ids.size() <= (periodic_ ? most_marked : most_ranked)) count = write_plain_row(faces);
    if (!count) {
        count = 0;
        if (periodic_ && faces.shifts.empty()) {
            find_shifts(faces.ids);
            faces.shifts = face_shifts_;
        }
        find_order(faces);
        for (const std::uint32_t face : order_) {
            if (labels_[face].id < 0 && !walls_) continue;
            const std::size_t entry = rows_size_ + (*count)++;
            rows_[entry] = labels_[face].id;
            if (want_.areas) areas_[entry] = faces.areas[face] * unscale_ * unscale_;
            for (std::size_t k = 0; k < 3 && want_.normals; ++k) normals_[3 * entry + k] = faces.normals[face][k];
            for (std::size_t k = 0; k < 3 && periodic_; ++k) shifts_[3 * entry + k] = labels_[face].shift[k];
        }
    }
    rows_size_ += *count;
    lengths_.push_back(static_cast<std::uint32_t>(*count));
}

// Ids, and areas if wanted. Nothing where two ids may be the same: in a small periodic box a seed is a neighbor more
// than once.
std::optional<std::size_t> CellWriter::write_plain_row(const Faces& faces) {
    // First behind its place, in the order of the faces, then sorted into it.
    std::int32_t* row = rows_.data() + rows_size_;
    std::int32_t* unsorted = row + faces.ids.size();
    const SeedImages* images = seeds_.images;
    bool shifted = !faces.shifts.empty();
    int count = 0;
    const auto gather = [&, areas = want_.areas, walls = walls_](const auto& input) {
        for (std::size_t k = 0; k < faces.ids.size(); ++k) {
            const std::int32_t id = faces.ids[k];
            unsorted[count] = id < 0 ? id : input(id);
            if (areas) kept_areas_[static_cast<std::size_t>(count)] = faces.areas[k];
            count += (id >= 0 || walls) ? 1 : 0;
        }
    };
    const std::int32_t* input = seeds_.input.data();
    if (shifted)
        gather([this](std::int32_t id) { return input_of(id); });
    else if (images == nullptr)
        gather([=](std::int32_t id) { return input[id]; });
    else
        gather([&, input](std::int32_t id) {
            if (!images->is_image(id)) return input[id];
            shifted = true;
            return input[images->home(id)];
        });
    kernels_->rank(unsorted, count, places_.data());
    if (shifted && !places_differ(count)) return {};
    for (int k = 0; k < count; ++k) row[places_[static_cast<std::size_t>(k)]] = unsorted[k];
    if (want_.areas) {
        const double square = unscale_ * unscale_;
        double* areas = areas_.data() + rows_size_;
        for (int k = 0; k < count; ++k)
            areas[places_[static_cast<std::size_t>(k)]] = kept_areas_[static_cast<std::size_t>(k)] * square;
    }
    if (periodic_) {
        std::int8_t* shifts = shifts_.data() + 3 * rows_size_;
        if (!shifted) std::memset(shifts, 0, 3 * static_cast<std::size_t>(count));
        const std::uint16_t* place = places_.data();
        for (std::size_t k = 0; shifted && k < faces.ids.size(); ++k) {
            const std::int32_t id = faces.ids[k];
            if (id < 0 && !walls_) continue;
            const auto shift = !faces.shifts.empty() ? faces.shifts[k] : id < 0 ? exact::Shift{} : images->shift(id);
            narrow(shift, shifts + 3 * std::size_t{*place++});
        }
    }
    return static_cast<std::size_t>(count);
}

bool CellWriter::places_differ(int count) const {
    std::uint64_t marked = 0;
    for (int k = 0; k < count; ++k) marked |= 1ull << places_[static_cast<std::size_t>(k)];
    return std::popcount(marked) == count;
}

// Fills labels_ and order_.
void CellWriter::find_order(const Faces& faces) {
    const std::size_t count = faces.ids.size();
    labels_.resize(count);
    order_.resize(count);
    make_room(count);
    std::int32_t* ids = rows_.data() + rows_size_;  // for a moment
    for (std::size_t f = 0; f < count; ++f) {
        const std::int32_t id = faces.ids[f];
        ids[f] = id < 0 ? id : input_of(id);
        labels_[f] = {ids[f], {}};
        if (!faces.shifts.empty()) narrow(faces.shifts[f], labels_[f].shift.data());
    }
    if (count <= most_marked) {
        kernels_->rank(ids, static_cast<int>(count), places_.data());
        for (std::size_t f = 0; f < count; ++f) order_[places_[f]] = static_cast<std::uint32_t>(f);
        if (places_differ(static_cast<int>(count))) return;
    }
    std::iota(order_.begin(), order_.end(), 0u);
    std::ranges::sort(order_, {}, [this](std::uint32_t f) { return labels_[f]; });
}

// After write_row() of the same cell.
void CellWriter::rank_faces() {
    ranks_.resize(order_.size());
    for (std::size_t r = 0; r < order_.size(); ++r) ranks_[order_[r]] = static_cast<std::uint32_t>(r);
}

void CellWriter::write_polygons() {
    const std::size_t hidden = order_.size() - lengths_.back();
    polygon_writer_.append(polygons_, labels_, order_, hidden, place());
}

void CellWriter::end_block(std::span<const std::int32_t> cells) {
    const auto of = [this](const auto& values, bool wanted, std::size_t each) {
        return std::span(values.data(), wanted ? each * rows_size_ : 0);
    };
    out_->add_rows(cells, lengths_, std::span(rows_.data(), rows_size_),
                   {of(areas_, want_.areas, 1), of(normals_, want_.normals, 3), of(shifts_, periodic_, 3)});
    if (want_.vertices) out_->mesh().add(cells, polygon_writer_.block());
    rows_size_ = 0;
    lengths_.clear();
    polygon_writer_.clear();
}

}  // namespace votess::cpu

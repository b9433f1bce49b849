#include "output/cell_writer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "core/vector3.hpp"
#include "index/seed_images.hpp"
#include "input/settled.hpp"
#include "polytope/vast_cell.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t initial_room = std::size_t{1} << 17;  // entries; memory costs nothing until it is touched

template <class T>
void grow_to(Buffer<T>& values, std::size_t kept, std::size_t size) {
    Buffer<T> larger;
    larger.resize_uninitialized(size);
    std::copy_n(values.data(), kept, larger.data());
    values = std::move(larger);
}

[[noreturn]] void too_skewed() {
    throw Error(ErrorCode::unsupported,
                "the cell is so skewed that neighbors lie more than 127 box vectors away: give shorter vectors that "
                "span the same lattice");
}

inline void narrow(const exact::Shift& shift, std::int8_t* out) {
    for (std::size_t j = 0; j < 3; ++j) {
        out[j] = static_cast<std::int8_t>(shift[j]);
        if (out[j] != shift[j]) too_skewed();
    }
}

}  // namespace

void CellWriter::begin_job(const Job& job, const StarKernels& kernels, std::span<const std::int32_t> row_places,
                           ResultBuilder& out) {
    kernels_ = &kernels;
    out_ = &out;
    want_ = job.want;
    walls_ = job.list_walls;
    domain_ = job.domain.get();
    kept_ = nullptr;
    only_ = job.only.get();
    probe_number_ = job.probes_of.value_or(0);
    probe_id_ = std::numeric_limits<std::int32_t>::min();
    moved_ = seeds_.images != nullptr && seeds_.images->any_moved();
    periodic_ = job.domain->is_periodic();
    placed_ = needs_geometry(want_);
    measured_ = want_.volumes || want_.centroids || want_.areas || want_.surfaces || want_.radii;
    ranked_ = measured_ || want_.neighbors;
    row_places_ = row_places;
    thickness_ = job.region.thickness;
    unit_ = job.unit();
    counters_ = {};
    const Box& box = domain_->box;
    const Vector3 diagonal = minus(box.upper, box.lower);
    tally_.begin(4 * dot(diagonal, diagonal));
    in_parts_ = out.has_parts();
    placing_ = false;
    new_rows_.clear();
    new_values_.clear();
    clear_rows();
    // As long as in an earlier job.
    if (want_.areas) areas_.resize_uninitialized(room_);
    if (want_.normals) normals_.resize_uninitialized(3 * room_);
    polygon_writer_.clear();
}

void CellWriter::prefetch(std::size_t seed) const {
    if (only_ != nullptr) return;
    const auto input = static_cast<std::size_t>(seeds_.input[seed]);
    for_row_arrays([&](const auto& array, std::size_t) {
        if (array.per == Per::cell && array.word != nullptr && want_.*array.word)
            __builtin_prefetch(&array.of(out_->arrays())[array.components * input], 1);
    });
}

void CellWriter::skip_row() {
    ++written_;
    if (!in_parts_) rows_[0].lengths.push_back(0);
    if (want_.vertices) polygon_writer_.append_none();
}

bool CellWriter::write(Star& star) {
    if (star.faces().empty()) {
        counters_.exact_cells += star.used_exact() ? 1 : 0;
        write_empty();
        return true;
    }
    if (want_.vertices && !star.knows_vertices()) return false;
    const auto faces = star.faces();
    face_shifts_.clear();
    if (moved_) find_shifts(faces);
    if (ranked_) rank_faces(faces);
    CellShape* shape = nullptr;
    if (measured_ || kept_ != nullptr) shape = star.shape(std::span(ranks_).first(faces.size()));
    if (kept_ != nullptr) store(shape, star.met_tie());
    if (measured_) {
        if (shape == nullptr || !measure_by_kernel(*shape)) return false;
        face_areas_ = std::span(measures_.areas).first(faces.size());
        write_measures();
    }
    counters_.faces += faces.size();
    counters_.exact_cells += star.used_exact() ? 1 : 0;
    if (want_.normals) star.normals(face_normals_);
    if (want_.neighbors) write_row();
    if (want_.vertices) {
        star.polygons(std::span(ranks_).first(faces.size()), polygons_);
        // Each of their cells has its own shift in the domain.
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
    if (placed_ || want_.counts || kept_ != nullptr || cell.met_tie()) {
        cell.canonical_faces(faces_);
        planes = faces_.planes;
    } else {
        cell.face_planes(planes_);
        planes = planes_;
    }
    constexpr std::size_t min_faces = 4;
    if (planes.size() < min_faces) return write_empty();  // flat
    counters_.faces += planes.size();
    ids_.clear();
    face_normals_.clear();
    face_shifts_.clear();
    for (const std::int32_t p : planes) {
        const CellPlane& plane = cell.planes()[static_cast<std::size_t>(p)];
        ids_.push_back(plane.id);
        if (periodic_) face_shifts_.push_back(plane.shift);
        if (want_.normals) face_normals_.push_back(unit_normal(cell.seed(), plane.source));
    }
    if (moved_) count_from_domain(ids_);
    if (ranked_) rank_faces(ids_);
    if (kept_ != nullptr) {
        const bool fits = shape_reader_.read(cell, faces_, std::span(ranks_).first(ids_.size()), false, shape_);
        store(fits ? &shape_ : nullptr, cell.met_tie());
    }
    if (measured_) measure(cell);
    if (want_.neighbors) write_row();
    if (want_.vertices) {
        read_polygons(cell, faces_, std::span(ranks_).first(ranked_ids_.size()), polygons_);
        write_polygons();
    }
    write_counts(planes.size(), faces_.edge_count, faces_.vertex_count);
}

void CellWriter::store(const CellShape* shape, bool tied) {
    homes_.clear();
    shifts_of_homes_.clear();
    for (std::size_t f = 0; f < ranked_ids_.size(); ++f) {
        const std::int32_t id = ranked_ids_[f];
        homes_.push_back(id < 0 || seeds_.images == nullptr ? id : seeds_.images->home(id));
        if (shifted_) shifts_of_homes_.push_back(shift_of(f));
    }
    if (shape == nullptr) return kept_->store_large(seed_, homes_);
    kept_->store(worker_, seed_, homes_, shifts_of_homes_, ranks_, *shape, tied);
}

void CellWriter::store(std::size_t seed, Star& star) {
    set_output(seed);
    face_shifts_.clear();
    rank_faces(star.faces());
    if (!star.faces().empty()) store(star.shape(std::span(ranks_).first(ranked_ids_.size())), star.met_tie());
}

bool CellWriter::write(std::size_t seed, const KeptCell& cell, bool with_row) {
    set_output(seed);
    const auto ids = cell.ids();
    const std::size_t count = ids.size(), corners = cell.corners().size();
    kept_planes_.begin(seed, cell);
    wall_faces_ = 0;
    while (wall_faces_ < count && ids[wall_faces_] < 0) ++wall_faces_;  // they come first
    if (measured_) {
        kept_planes_.shape(shape_);
        if (!measure_by_kernel(shape_)) return false;
        face_areas_ = std::span(measures_.areas).first(count);
    }
    face_shifts_.clear();
    face_normals_.clear();
    if (cell.head().shifted)
        for (std::size_t f = 0; f < count; ++f) face_shifts_.push_back(cell.shift(f));
    if (names_.size() < max_ranked) {
        names_.resize(max_ranked);
        ranks_.resize(max_ranked);
    }
    std::iota(ranks_.begin(), ranks_.begin() + static_cast<std::ptrdiff_t>(count), 0u);
    for (std::size_t f = 0; f < count && with_row; ++f)
        names_[f] = ids[f] < 0 ? ids[f] : seeds_.input[static_cast<std::size_t>(ids[f])];
    for (std::size_t f = 0; f < count && want_.normals; ++f)
        face_normals_.push_back(unit_normal(kept_planes_.seed(), kept_planes_.plane(f)));
    ranked_ids_ = ids;
    shifted_ = cell.head().shifted;
    hidden_ = walls_ ? 0 : wall_faces_;
    if (measured_) write_measures();
    counters_.faces += count;
    if (want_.neighbors) place_row(with_row);
    write_counts(count, static_cast<std::uint32_t>(3 * corners / 2), static_cast<std::uint32_t>(corners));
    return true;
}

// Measures as the walk does, so that results do not depend on how a cell was found; else from exact corners.
void CellWriter::measure(const Cell& cell) {
    const std::span ranks = std::span(ranks_).first(ranked_ids_.size());
    const bool beyond = probe_ == nullptr && seeds_.is_beyond(seed_);
    shape_.weighted = domain_->has_weights() || beyond;
    if (shape_reader_.read(cell, faces_, ranks, beyond, shape_) && measure_by_kernel(shape_)) {
        face_areas_ = std::span(measures_.areas).first(faces_.size());
    } else {
        measure_exactly(cell, faces_, ranks, measures_, many_areas_);
        face_areas_ = many_areas_;
    }
    write_measures();
}

bool CellWriter::measure_by_kernel(CellShape& shape) {
    measures_.exponent = 0;
    if (!kernels_->measure(shape, measures_)) return false;
    const auto is_wall = [&](std::size_t f) { return f < wall_faces_; };
    const auto distance2 = [&](std::size_t f) {
        const auto& [x, y, z] = shape.plane[f].n;  // half of the way
        return 4 * (x * x + y * y + z * z);
    };
    const auto planes = static_cast<std::size_t>(shape.planes);
    if (wall_faces_ < planes && is_surely_compact(measures_.farthest_squared, distance2(planes - 1))) return true;
    return !vast_beyond(std::span(measures_.areas).first(planes), is_wall, distance2);
}

void CellWriter::write_none(std::size_t output, CellStatus status) {
    out_->set_empty(output, status);
    ++counters_.empty_cells;
    skip_row();
}

void CellWriter::write_measures() {
    const CellMeasures& m = measures_;
    const MeasureUnit unit = unit_of_cell();
    if (m.exponent == 0) {
        tally_.add(face_areas_.subspan(wall_faces_));
    } else {
        std::vector<double> areas(face_areas_.begin() + wall_faces_, face_areas_.end());
        for (double& area : areas) area = std::ldexp(area, 2 * m.exponent);
        tally_.add(areas);
    }
    if (want_.volumes) out_->arrays().volumes[output_] = unit.volume(m.volume);
    if (want_.centroids) {
        const exact::Point p = place();
        for (std::size_t k = 0; k < 3; ++k)
            out_->arrays().centroids[3 * output_ + k] = unit_.length(m.centroid[k] + p[k]);
    }
    if (want_.surfaces)
        out_->arrays().surface_areas[output_] = unit.area(std::accumulate(face_areas_.begin(), face_areas_.end(), 0.0));
    if (want_.radii) out_->arrays().security_radii[output_] = unit.length(2 * std::sqrt(m.farthest_squared));
}

MeasureUnit CellWriter::unit_of_cell() const {
    if (measures_.exponent == 0) return unit_;
    return {std::ldexp(unit_.length(1), measures_.exponent), thickness_};
}

void CellWriter::write_counts(std::size_t faces, std::uint32_t edges, std::uint32_t vertices) {
    if (!want_.counts) return;
    out_->arrays().face_counts[output_] = static_cast<std::uint32_t>(faces);
    out_->arrays().edge_counts[output_] = edges;
    out_->arrays().vertex_counts[output_] = vertices;
}

std::int32_t CellWriter::input_of(std::int32_t id) const {
    if (id == probe_id_) return probe_number_;
    const std::int32_t home = seeds_.images == nullptr ? id : seeds_.images->home(id);
    return seeds_.input[static_cast<std::size_t>(home)];
}

// Clears face_shifts_ if all ids are seeds without a shift, as they are away from the faces of the domain. An image may
// have shift 0 too, if it was moved into the reduced cell and lies beside it.
void CellWriter::find_shifts(std::span<const std::int32_t> ids) {
    const SeedImages& images = *seeds_.images;
    const bool any_image = std::ranges::any_of(ids, [&](auto id) { return id >= 0 && images.is_image(id); });
    face_shifts_.resize(ids.size());
    for (std::size_t f = 0; f < ids.size(); ++f) face_shifts_[f] = ids[f] < 0 ? exact::Shift{} : images.shift(ids[f]);
    count_from_domain(ids);
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

void CellWriter::set_output(std::size_t output, const Probe& probe) {
    output_ = output;
    probe_ = &probe;
    probe_id_ = static_cast<std::int32_t>(seeds_.places());
    moved_ = seeds_.images != nullptr && (seeds_.images->any_moved() || probe.place.move != exact::Shift{});
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

void CellWriter::grow(std::size_t entries) {
    room_ = std::max(initial_room, 2 * entries);
    if (want_.areas) grow_to(areas_, entries_, room_);
    if (want_.normals) grow_to(normals_, 3 * entries_, 3 * room_);
}

exact::Shift CellWriter::shift_of(std::size_t face) const {
    if (!face_shifts_.empty()) return face_shifts_[face];
    const std::int32_t id = ranked_ids_[face];
    return id < 0 || seeds_.images == nullptr ? exact::Shift{} : seeds_.images->shift(id);
}

void CellWriter::rank_faces(std::span<const std::int32_t> ids) {
    const std::size_t count = ids.size();
    if (names_.size() < std::max(count, max_ranked)) {
        names_.resize(std::max(count, max_ranked));
        ranks_.resize(names_.size());
    }
    ranked_ids_ = ids;
    bool shifted = !face_shifts_.empty();
    std::size_t walls = 0;
    const auto gather = [&, names = names_.data()](const auto& name_of) {
        for (std::size_t f = 0; f < count; ++f) {
            const std::int32_t id = ids[f];
            walls += id < 0 ? 1 : 0;
            names[f] = id < 0 ? id : name_of(id);
        }
    };
    const std::int32_t* input = seeds_.input.data();
    const SeedImages* images = seeds_.images;
    if (shifted)
        gather([this](std::int32_t id) { return input_of(id); });
    else if (images == nullptr)
        gather([input](std::int32_t id) { return input[id]; });
    else
        gather([&, input](std::int32_t id) {
            if (!images->is_image(id)) return input[id];
            shifted = true;
            return input[images->home(id)];
        });
    shifted_ = shifted;
    wall_faces_ = walls;
    hidden_ = walls_ ? 0 : walls;
    const std::int32_t* keys = names_.data();
    if (!row_places_.empty()) {
        keys_.resize(count);
        const std::int32_t* const places = row_places_.data();
        for (std::size_t f = 0; f < count; ++f)
            keys_[f] = ids[f] < 0 ? ids[f] : places[images == nullptr ? ids[f] : images->home(ids[f])];
        keys = keys_.data();
    }
    if (count > max_ranked) return rank_labels();
    kernels_->rank(keys, static_cast<int>(count), ranks_.data());
    // In a small periodic box a seed is a neighbor more than once.
    if (shifted && !ranks_differ()) rank_labels();
}

bool CellWriter::ranks_differ() const {
    const std::size_t count = ranked_ids_.size();
    if (count > max_marked) return false;
    std::uint64_t marked = 0;
    for (std::size_t f = 0; f < count; ++f) marked |= 1ull << ranks_[f];
    return static_cast<std::size_t>(std::popcount(marked)) == count;
}

void CellWriter::rank_labels() {
    const std::vector<std::int32_t>& keys = row_places_.empty() ? names_ : keys_;
    order_.resize(ranked_ids_.size());
    std::iota(order_.begin(), order_.end(), 0u);
    std::ranges::sort(order_, {}, [&](std::uint32_t f) { return std::pair(keys[f], shift_of(f)); });
    for (std::size_t r = 0; r < order_.size(); ++r) ranks_[order_[r]] = static_cast<std::uint32_t>(r);
}

void CellWriter::place_row(bool with_ids) {
    const std::size_t faces = ranked_ids_.size(), listed = faces - hidden_;
    const auto begin = [&](PlacedRows& rows) {
        rows.cells.push_back(static_cast<std::int32_t>(output_));
        rows.lengths.push_back(static_cast<std::uint32_t>(listed));
    };
    const auto for_listed = [&](auto visit) {  // a face and its entry
        for (std::size_t f = 0; f < faces; ++f)
            if (ranks_[f] >= hidden_) visit(f, ranks_[f] - hidden_);
    };
    const auto grow = [&](auto& values, std::size_t components) {
        values.resize(values.size() + components * listed);
        return values.data() + values.size() - components * listed;
    };
    if (with_ids) {
        begin(new_rows_);
        std::int32_t* const ids = grow(new_rows_.ids, 1);
        for_listed([&](std::size_t f, std::size_t entry) { ids[entry] = names_[f]; });
        std::int8_t* const shifts = periodic_ ? grow(new_rows_.shifts, 3) : nullptr;
        if (shifted_) for_listed([&](std::size_t f, std::size_t entry) { narrow(shift_of(f), shifts + 3 * entry); });
    }
    if (!want_.areas && !want_.normals) return;
    begin(new_values_);
    const MeasureUnit unit = unit_of_cell();
    double* const areas = want_.areas ? grow(new_values_.areas, 1) : nullptr;
    double* const normals = want_.normals ? grow(new_values_.normals, 3) : nullptr;
    for (std::size_t k = 0; k < listed && want_.areas; ++k) areas[k] = unit.area(face_areas_[hidden_ + k]);
    if (want_.normals)
        for_listed([&](std::size_t f, std::size_t entry) { std::ranges::copy(face_normals_[f], normals + 3 * entry); });
}

void CellWriter::end_placing() {
    const auto& [cells, ids, lengths, areas, normals, shifts] = new_rows_;
    out_->place_each(cells, lengths, ids, {{}, {}, shifts});
    out_->place_each(new_values_.cells, new_values_.lengths, {}, {new_values_.areas, new_values_.normals, {}});
    new_rows_.clear();
    new_values_.clear();
    placing_ = false;
}

void CellWriter::write_row() {
    if (placing_) return place_row(true);
    const std::size_t faces = ranked_ids_.size(), count = faces - hidden_;
    if (entries_ + faces > room_) grow(entries_ + faces);
    const std::size_t begin = entries_;
    const auto for_listed = [&](auto visit) {  // a face and its entry
        for (std::size_t f = 0; f < faces; ++f)
            if (ranks_[f] >= hidden_) visit(f, begin + ranks_[f] - hidden_);
    };
    Rows& rows = rows_of_cell();
    if (count > 0) write_steps(rows);
    if (want_.areas) {
        const MeasureUnit unit = unit_of_cell();
        for (std::size_t k = 0; k < count; ++k) areas_[begin + k] = unit.area(face_areas_[hidden_ + k]);
    }
    if (want_.normals)
        for_listed([&](std::size_t f, std::size_t entry) {
            std::ranges::copy(face_normals_[f], normals_.data() + 3 * entry);
        });
    if (shifted_)
        for_listed([&](std::size_t f, std::size_t entry) {
            RowShift kept{rows.listed, static_cast<std::uint32_t>(entry - begin), {}};
            narrow(shift_of(f), kept.shift.data());
            if (kept.shift != std::array<std::int8_t, 3>{}) rows.shifts.push_back(kept);
        });
    ++written_;
    entries_ += count;
    rows.listed += count > 0 ? 1 : 0;
    if (in_parts_ && count == 0) return;
    rows.lengths.push_back(static_cast<std::uint32_t>(count));
    if (in_parts_) rows.cells.push_back(static_cast<std::int32_t>(output_));
}

// The row of a probe counts from one of its neighbors.
void CellWriter::write_steps(Rows& rows) {
    const std::size_t faces = ranked_ids_.size();
    const auto is_seed = [this](std::int32_t id) { return id >= 0 && id != probe_id_; };
    const auto place_of = [this](std::int32_t id) { return seeds_.images == nullptr ? id : seeds_.images->home(id); };
    auto place = static_cast<std::int32_t>(seed_);
    if (probe_ != nullptr) {
        const auto first = std::ranges::find_if(ranked_ids_, is_seed);
        place = first == ranked_ids_.end() ? 0 : place_of(*first);
    }
    std::int16_t* const row = rows.near.add_row(place, faces - hidden_);
    if (wall_faces_ == 0 && !shifted_) {
        const std::int32_t* const ids = ranked_ids_.data();
        const std::uint32_t* const ranks = ranks_.data();
        std::uint32_t bits = 0;  // above the 16th: of steps beyond the longest, on either side
        for (std::size_t f = 0; f < faces; ++f) {
            const auto by = static_cast<std::uint32_t>(ids[f] - place);
            bits |= (by + NearRows::longest_step) | (by + NearRows::longest_step + 1);
            row[ranks[f]] = static_cast<std::int16_t>(by);
        }
        if (bits >> 16 == 0) return;
    }
    order_.resize(faces);
    for (std::size_t f = 0; f < faces; ++f) order_[ranks_[f]] = static_cast<std::uint32_t>(f);
    for (std::size_t rank = hidden_; rank < faces; ++rank) {
        const std::uint32_t f = order_[rank];
        const std::int32_t id = ranked_ids_[f];
        const std::int16_t step = is_seed(id) ? NearWriter::step(place_of(id) - place) : NearRows::far;
        row[rank - hidden_] = step;
        if (step == NearRows::far) rows.near.add_other(names_[f]);
    }
}

void CellWriter::write_polygons() {
    const std::size_t faces = ranked_ids_.size();
    labels_.resize(faces);
    order_.resize(faces);
    for (std::size_t f = 0; f < faces; ++f) {
        labels_[f] = {names_[f], {}};
        narrow(shift_of(f), labels_[f].shift.data());
        order_[ranks_[f]] = static_cast<std::uint32_t>(f);
    }
    polygon_writer_.append(polygons_, labels_, order_, hidden_, place());
}

void CellWriter::clear_rows() {
    for (Rows& rows : rows_) rows.clear();
    entries_ = written_ = 0;
}

void CellWriter::end_rows(std::span<const std::int32_t> cells) {
    const auto of = [this](const auto& values, bool wanted, std::size_t each) {
        return std::span(values.data(), wanted ? each * entries_ : 0);
    };
    const auto near = [this](const Rows& rows) { return rows.near.rows(seeds_.input.data()); };
    if (!in_parts_)
        out_->add_rows(cells, rows_[0].lengths, near(rows_[0]),
                       {of(areas_, want_.areas, 1), of(normals_, want_.normals, 3), {}}, rows_[0].shifts);
    for (std::size_t part = 0; part < rows_.size() && in_parts_; ++part)
        if (const Rows& rows = rows_[part]; !rows.cells.empty())
            out_->add_rows_of_part(part, rows.cells, rows.lengths, near(rows), rows.shifts);
    clear_rows();
}

void CellWriter::end_block(std::span<const std::int32_t> cells) {
    end_rows(cells.last(written_));
    if (want_.vertices) out_->mesh().add(cells, polygon_writer_.block());
    polygon_writer_.clear();
}

}  // namespace votess::cpu

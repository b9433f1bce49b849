// Diagram::trace(): checks rays, and traces them on all threads.
#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/vector3.hpp"
#include "diagram/diagram_state.hpp"
#include "input/settle.hpp"

namespace votess {

std::vector<double> RayCells::integrate(std::span<const double> values, std::span<const double> gradients) const {
    const std::size_t components = planar ? 2 : 3;
    if (!gradients.empty() && gradients.size() != components * values.size())
        refuse("integrate: there are " + std::to_string(values.size()) + " values, but " +
               std::to_string(gradients.size()) + " components of gradients: give " + std::to_string(components) +
               " for each value, or none");
    if (!gradients.empty() && middles.size() != components * seeds.size())
        refuse("integrate: gradients need the middles of pieces: trace with TraceOptions::middles");
    for (const std::int32_t seed : seeds)
        if (static_cast<std::size_t>(seed) >= values.size())
            refuse("integrate: there are " + std::to_string(values.size()) +
                   " values, but a ray passes the cell of seed " + std::to_string(seed) + ": give one for each seed");
    std::vector<double> integrals(offsets.empty() ? 0 : offsets.size() - 1);
    for (std::size_t r = 0; r < integrals.size(); ++r)
        for (auto k = static_cast<std::size_t>(offsets[r]); k < static_cast<std::size_t>(offsets[r + 1]); ++k) {
            const auto seed = static_cast<std::size_t>(seeds[k]);
            double mean = values[seed];  // of the piece
            for (std::size_t j = 0; j < components && !gradients.empty(); ++j)
                mean += gradients[components * seed + j] * middles[components * k + j];
            integrals[r] += mean * lengths[k];
        }
    return integrals;
}

namespace detail {
namespace {

constexpr double share_of_neighbors = 0.5;  // of a call that computes them
constexpr std::size_t rays_per_look = 64;   // after which the user may stop
// More is a mistake in the length. A ray through a thousand million seeds passes some thousand cells a box.
constexpr std::size_t max_cells_of_ray = std::size_t{1} << 24;
constexpr std::size_t max_flights = 8;  // of a thread: while one waits for memory, the others compute

std::string name_of(std::size_t ray) {
    return "ray " + std::to_string(ray);
}

struct Rays {
    Queries origins;
    std::vector<double> directions, lengths;  // copied, see input/snapshot.hpp
};

// Refuses bad directions and lengths.
Rays check_rays(const DiagramState& state, std::vector<double> origins, std::vector<double> directions,
                std::span<const double> lengths) {
    Rays rays{check_queries(state, std::move(origins)), std::move(directions), {lengths.begin(), lengths.end()}};
    const std::size_t count = rays.origins.count();
    if (rays.directions.size() != 3 * count || rays.lengths.size() != count)
        refuse("there are " + std::to_string(count) + " origins, but " + std::to_string(rays.directions.size() / 3) +
               " directions and " + std::to_string(lengths.size()) + " lengths: give one of each for each ray");
    for (std::size_t r = 0; r < count; ++r) {
        const double* d = &rays.directions[3 * r];
        for (std::size_t k = 0; k < 3; ++k)
            if (!std::isfinite(d[k]))
                refuse(name_of(r) + ": component " + number(d[k]) + " of its direction is not finite");
        if (d[0] == 0 && d[1] == 0 && d[2] == 0) refuse(name_of(r) + ": its direction is 0: give another vector");
        if (!(rays.lengths[r] >= 0))
            refuse(name_of(r) + ": its length " + number(rays.lengths[r]) + " is not 0 or more: give lengths");
    }
    return rays;
}

// Returns the direction times a power of two, so that its largest component is from 0.5 to 1.
exact::Point direction_of(const Rays& rays, std::size_t ray) {
    const double* given = &rays.directions[3 * ray];
    const int exponent = std::ilogb(std::max({std::abs(given[0]), std::abs(given[1]), std::abs(given[2])})) + 1;
    exact::Point d;
    for (std::size_t k = 0; k < 3; ++k) {
        d[k] = std::ldexp(given[k], -exponent);
        if (std::ldexp(d[k], exponent) != given[k])
            throw Error(ErrorCode::unsupported, name_of(ray) + ": component " + number(given[k]) +
                                                    " of its direction is too small beside the others: set it to 0");
    }
    return d;
}

// Needs a CallGuard.
void make_cells(DiagramState& state) {
    if (state.cells) return;
    Settled run = run_in(state, state.endless ? state.endless->region() : state.job.region);
    run.want = {.neighbors = true, .volumes = false};
    run.list_walls = false;
    run.progress = Stoppable::within({0, share_of_neighbors});
    const Tessellation t = tessellate(std::move(run));
    state.cells.emplace(*state.job.domain, state.clipper.seeds(), t);
    Stoppable::enter_stage({share_of_neighbors, 1});
}

using Image = cpu::RayTracer::Image;

void check_cells(const Rays& rays, std::size_t ray, double cells) {
    if (cells > max_cells_of_ray)
        throw Error(ErrorCode::unsupported, name_of(ray) + ": its length " + number(rays.lengths[ray]) +
                                                " leads through more than " + std::to_string(max_cells_of_ray) +
                                                " cells: give a shorter length, or shorter rays one after the other");
}

// Returns the image whose cell holds the origin, counted from the seed's place in the domain.
Image image_at(DiagramState& state, cpu::Locator& locator, const exact::Point& x, const cpu::Place& place) {
    const cpu::Locator::Nearest nearest = locator.nearest(x, place);
    if (nearest.home < 0) return {cpu::CellGraph::none, {}};
    Image image{static_cast<std::size_t>(nearest.home), nearest.shift};
    if (const cpu::SeedImages* images = state.clipper.seeds().images)
        for (std::size_t j = 0; j < 3; ++j)
            image.shift[j] += images->shift_in_domain(nearest.home, exact::Shift{})[j] - place.shift[j];
    return image;
}

// Returns the images whose cells hold the origins beyond the near ends of a domain without end, by input; none for
// others. Needs a CallGuard.
std::vector<Image> images_beyond(DiagramState& state, const Queries& origins) {
    std::vector<Image> images(origins.count(), Image{cpu::CellGraph::none, {}});
    std::vector<std::size_t> outside;
    std::vector<double> places;
    make_searchers(state);
    for (std::size_t r = 0; r < origins.count(); ++r) {
        if (r % rays_per_look == 0) check_stop();
        if (state.searchers.front().locator.place(scaled(state.job, origins, r), r)) continue;
        outside.push_back(r);
        places.insert(places.end(), &origins.x[3 * r], &origins.x[3 * r] + 3);
    }
    if (outside.empty()) return images;
    const std::shared_ptr<DiagramState> far = far_state(state, ends_with(state, places));
    const CallGuard turn(*far);
    make_searchers(*far);
    cpu::Locator& locator = far->searchers.front().locator;
    for (const std::size_t r : outside) {
        const exact::Point x = scaled(far->job, origins, r);
        const auto place = locator.place(x, r);
        if (!place) continue;
        images[r] = image_at(*far, locator, x, *place);
        if (images[r].seed != cpu::CellGraph::none)
            images[r].seed = static_cast<std::size_t>(far->clipper.seeds().input[images[r].seed]);
    }
    return images;
}

// The cells of consecutive rays.
struct RayBatch {
    std::size_t begin = 0;
    std::vector<std::size_t> first;  // by ray: of its pieces
    std::vector<std::int32_t> seeds;
    std::vector<double> lengths, middles;
};

// A ray under way.
struct Flight {
    cpu::RayTracer tracer;
    std::size_t ray = 0;
    double speed = 0;                         // length of input over time
    std::vector<solid::Inside::Part> inside;  // of a mesh
};

// Returns the parts of pieces inside.
std::vector<cpu::RayTracer::Piece> cut(std::span<const cpu::RayTracer::Piece> pieces,
                                       std::span<const solid::Inside::Part> inside) {
    std::vector<cpu::RayTracer::Piece> cut;
    std::size_t next = 0;
    for (const cpu::RayTracer::Piece& piece : pieces) {
        while (next < inside.size() && inside[next].end < piece.begin) ++next;
        for (std::size_t k = next; k < inside.size() && inside[k].begin <= piece.end; ++k) {
            const double begin = std::max(piece.begin, inside[k].begin), end = std::min(piece.end, inside[k].end);
            const bool whole = begin == piece.begin && end == piece.end;
            if (begin < end || whole) cut.push_back({piece.image, begin, end});
            if (whole) break;
        }
    }
    return cut;
}

}  // namespace

RayCells trace(DiagramState& state, std::vector<double> origins, std::vector<double> directions,
               std::span<const double> lengths, bool middles) {
    const Rays rays = check_rays(state, std::move(origins), std::move(directions), lengths);
    const std::size_t count = rays.origins.count();
    RayCells out;
    lengthen(out.offsets, count + 1);
    if (state.points.empty()) return out;
    const CallGuard turn(state);
    std::vector<Image> beyond;  // of origins that the domain of the state does not hold
    if (state.endless) beyond = images_beyond(state, rays.origins);
    make_cells(state);
    const cpu::SortedSeeds& seeds = state.clipper.seeds();
    std::vector<std::size_t> sorted(beyond.empty() ? 0 : state.points.size() / 3);
    for (std::size_t i = 0; i < seeds.size() && !sorted.empty(); ++i)
        sorted[static_cast<std::size_t>(seeds.input[i])] = i;
    const std::string_view instructions = cpu::find_kernels(state.job.instructions)->name;
    std::vector<exact::Plane> walls = state.job.domain->walls;
    for (int wall = 0; wall < 6; ++wall)
        if (state.job.domain->has_box_wall(wall) && !state.endless_sides.has(-1 - wall))
            walls.push_back(state.job.domain->box_wall(wall));
    std::mutex adding;
    std::vector<RayBatch> batches;
    for_queries(state, rays.origins, [&](DiagramState::Searcher& searcher, std::size_t begin, std::size_t end) {
        std::vector<Image> starts(end - begin, Image{cpu::CellGraph::none, {}});
        sort_queries(state.job, searcher, rays.origins, begin, end, [](std::size_t) {});
        for (const std::uint64_t key : searcher.order) {
            const auto i = static_cast<std::uint32_t>(key);
            const exact::Point x = scaled(state.job, rays.origins, begin + i);
            starts[i] = image_at(state, searcher.locator, x, searcher.places[i]);
        }
        RayBatch batch{begin, std::vector<std::size_t>(end - begin), {}, {}, {}};
        std::size_t next = begin;
        // Starts rays until one is under way.
        const auto start_next = [&](Flight& flight) {
            while (next < end && !flight.tracer.is_under_way()) {
                const std::size_t r = flight.ray = next++;
                if (r % rays_per_look == 0) check_stop();
                Image start = starts[r - begin];
                if (!beyond.empty() && beyond[r].seed != cpu::CellGraph::none)
                    start = {sorted[beyond[r].seed], beyond[r].shift};
                if (start.seed == cpu::CellGraph::none) continue;
                const exact::Ray ray{scaled(state.job, rays.origins, r), direction_of(rays, r)};
                flight.speed = length3(ray.direction[0], ray.direction[1], ray.direction[2]) / state.job.scale;
                const Domain& domain = *state.job.domain;
                double end = rays.lengths[r] / flight.speed;
                if (state.inside && !domain.is_periodic()) {
                    flight.inside = state.inside->parts(ray, end);
                    if (flight.inside.empty()) continue;
                    end = flight.inside.back().end;
                }
                if (!flight.tracer.start(ray, end, start))
                    refuse(name_of(r) +
                           ": its length is infinite, and no wall ends it: "
                           "give a finite length");
                if (!domain.is_periodic()) continue;
                // Images of a seed bound its cell: none is wider than the domain.
                check_cells(rays, r,
                            flight.tracer.end() * flight.speed * state.job.scale / (2 * domain.covering_radius));
                if (state.inside) flight.inside = state.inside->parts(ray, flight.tracer.end());
            }
            return flight.tracer.is_under_way();
        };
        const auto store = [&](const Flight& flight) {
            std::span<const cpu::RayTracer::Piece> pieces = flight.tracer.pieces();
            std::vector<cpu::RayTracer::Piece> parts;
            if (state.inside) pieces = parts = cut(pieces, flight.inside);
            const std::size_t first = batch.seeds.size(), count = pieces.size();
            batch.first[flight.ray - begin] = first;
            batch.seeds.resize(first + count);
            batch.lengths.resize(first + count);
            for (std::size_t i = 0; i < count; ++i) {
                const cpu::RayTracer::Piece& piece = pieces[i];
                batch.seeds[first + i] = seeds.input[piece.image.seed];
                batch.lengths[first + i] = (piece.end - piece.begin) * flight.speed;
                if (!middles) continue;
                for (const double x : flight.tracer.middle_of(piece)) batch.middles.push_back(x / state.job.scale);
            }
            out.offsets[flight.ray + 1] = static_cast<std::int64_t>(count);
        };
        std::vector<Flight> flights(std::min(max_flights, end - begin),
                                    {{*state.job.domain, seeds, *state.cells, walls, instructions}, 0, 0, {}});
        std::size_t under_way = 0;
        for (Flight& flight : flights) under_way += static_cast<std::size_t>(start_next(flight));
        while (under_way > 0) {
            for (Flight& flight : flights)
                if (flight.tracer.is_under_way()) flight.tracer.look();
            for (Flight& flight : flights) {
                if (!flight.tracer.is_under_way()) continue;
                flight.tracer.step();
                check_cells(rays, flight.ray, static_cast<double>(flight.tracer.pieces().size()));
                if (flight.tracer.is_under_way()) continue;
                store(flight);
                if (!start_next(flight)) --under_way;
            }
        }
        const std::scoped_lock lock(adding);
        batches.push_back(std::move(batch));
    });
    for (std::size_t r = 0; r < count; ++r) out.offsets[r + 1] += out.offsets[r];
    std::ranges::sort(batches, {}, &RayBatch::begin);
    out.seeds.reserve(static_cast<std::size_t>(out.offsets[count]));
    out.lengths.reserve(static_cast<std::size_t>(out.offsets[count]));
    if (middles) out.middles.reserve(3 * static_cast<std::size_t>(out.offsets[count]));
    const auto append = [](auto& to, const auto& from, std::size_t begin, std::size_t end) {
        to.insert(to.end(), from.data() + begin, from.data() + end);
    };
    for (RayBatch& batch : batches) {
        for (std::size_t i = 0; i < batch.first.size(); ++i) {
            const std::size_t r = batch.begin + i, first = batch.first[i];
            const std::size_t last = first + static_cast<std::size_t>(out.offsets[r + 1] - out.offsets[r]);
            append(out.seeds, batch.seeds, first, last);
            append(out.lengths, batch.lengths, first, last);
            if (middles) append(out.middles, batch.middles, 3 * first, 3 * last);
        }
        batch = {};
    }
    return out;
}

}  // namespace detail
}  // namespace votess

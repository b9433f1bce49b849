#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "gpu/domain/device_domain.hpp"
#include "gpu/domain/walls.hpp"
#include "gpu/frames/frame.hpp"
#include "input/settle.hpp"

namespace votess::vulkan::detail {
namespace {

constexpr double margin_spacings = 3.4;  // mean distances between seeds: most uniform cells need less

void check_cell(const TriclinicBox& cell) {
    if (cell.periodic != std::array{true, true, true})
        throw Error(ErrorCode::unsupported, "cell: in recorded frames a triclinic box must repeat along all its edges");
}

void check_weights(const WeightOptions& weights) {
    if (!std::isfinite(weights.least) || !std::isfinite(weights.largest) || !(weights.least <= weights.largest))
        refuse("weights from " + number(weights.least) + " to " + number(weights.largest) +
               " are no range: give finite numbers, the least first");
    if (weights.stride == 0) refuse("weights: their stride must be 1 or more numbers");
}

void check_walls(const PlanOptions& options) {
    if (options.cell) refuse("walls and cell are both given: walls go with a box");
    if (is_periodic(options))
        refuse("walls and a periodic domain are both given: walls go with a box that is not periodic");
}

// Returns how far around a box there are images. Images beyond that cut few cells.
double margin_of(const PlanOptions& options, double spacing) {
    if (options.margin > 0) return options.margin;
    const double heavier = options.weights ? options.weights->largest - options.weights->least : 0;
    return gpu::image_margin(0.5 * margin_spacings * spacing, heavier);
}

double margin_of(const PlanOptions& options, const Box& box, std::uint32_t count) {
    double spacing = 1 / std::cbrt(static_cast<double>(std::max(count, 1u)));
    for (std::size_t k = 0; k < 3; ++k) spacing *= std::cbrt(box.upper[k] - box.lower[k]);
    return margin_of(options, spacing);
}

gpu::CellImages images_of(const PlanOptions& options, const TriclinicBox& cell, std::uint32_t count) {
    double volume = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
        volume += cell.a[k] * (cell.b[l] * cell.c[m] - cell.b[m] * cell.c[l]);
    }
    return gpu::cell_images(cell, margin_of(options, std::cbrt(std::abs(volume) / std::max(count, 1u))));
}

}  // namespace

void check_domain(const PlanOptions& options) {
    if (!(options.margin >= 0)) refuse("margin = " + number(options.margin) + " must be 0 or more");
    if (options.weights) check_weights(*options.weights);
    if (!options.walls.empty()) check_walls(options);
    if (!options.cell) {
        check_box(options.box);
        return;
    }
    const Box none;
    if (options.box.lower != none.lower || options.box.upper != none.upper)
        refuse("box and cell are both given: give either box or cell, not both");
    if (options.periodic != std::array<bool, 3>{})
        refuse("cell and periodic contradict each other: set cell.periodic only");
    check_cell(*options.cell);
}

void check_domain(const PlanOptions& options, const RecordOptions& of_frame) {
    if (of_frame.box) check_box(*of_frame.box);
    if (options.cell ? of_frame.box.has_value() : of_frame.cell.has_value())
        refuse(options.cell ? "a box is given, where the plan has a cell" : "a cell is given, where the plan has none");
    if (of_frame.box && !options.walls.empty())
        refuse("a box is given, but the plan has walls, which need the plan's own box");
    if (of_frame.cell) check_cell(*of_frame.cell);
}

// A quarter more than uniform seeds need.
std::uint32_t usual_images(const PlanOptions& options) {
    const double margin = margin_of(options, options.box, options.max_seeds);
    double larger = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        const double side = options.box.upper[k] - options.box.lower[k];
        if (options.periodic[k]) larger *= 1 + 2 * std::min(margin / side, 1.0);
    }
    if (options.cell) {
        const gpu::CellImages images = images_of(options, *options.cell, options.max_seeds);
        larger = 1 / images.volume;
        for (std::size_t k = 0; k < 3; ++k) larger *= images.box.upper[k] - images.box.lower[k];
    }
    return static_cast<std::uint32_t>(std::min(1.25 * (larger - 1) * options.max_seeds + 1000, 1.0 * max_of_all));
}

void make_walls(PlanState& plan) {
    if (plan.options.walls.empty()) return;
    Settled run;
    run.region.box = plan.options.box;
    run.region.walls = plan.options.walls;
    check_region(run.region);
    const Job job = make_job(std::move(run));
    const Domain& domain = *job.domain;
    for (std::size_t w = 0; w < domain.walls.size(); ++w) {
        bool leaves_some = false;
        for (std::size_t corner = 0; corner < 8; ++corner) {
            exact::Point x;
            for (std::size_t k = 0; k < 3; ++k)
                x[k] = ((corner >> k) & 1) != 0 ? domain.box.upper[k] : domain.box.lower[k];
            leaves_some = leaves_some || inside(domain.walls[w], x);
        }
        if (!leaves_some) refuse("wall " + std::to_string(w) + " leaves nothing of the box");
    }
    plan.box_of_walls = gpu::device_box(job);
    plan.walls = gpu::device_walls(job, plan.box_of_walls);
}

void set_domain(gpu::DeviceSeeds& seeds, const PlanState& plan, const RecordOptions& of_frame) {
    const PlanOptions& options = plan.options;
    const Box box = of_frame.box.value_or(options.box);
    if (options.cell)
        seeds.set_cell(images_of(options, of_frame.cell.value_or(*options.cell), of_frame.count));
    else if (is_periodic(options))
        seeds.set_periodic_box(box, options.periodic, margin_of(options, box, of_frame.count));
    else if (!plan.walls.empty())
        seeds.set_box(plan.box_of_walls, box);
    else
        seeds.set_box(box);
    if (!options.weights) return;
    const auto units = gpu::WeightUnits::between(options.weights->least, options.weights->largest, seeds.units(), 1);
    if (!units)
        throw Error(ErrorCode::unsupported,
                    "weights from " + number(options.weights->least) + " to " + number(options.weights->largest) +
                        " differ by more than four times the square of the box's longest side: take lighter ones for "
                        "as light as that, they have no cell either way");
    seeds.set_weights(units);
}

}  // namespace votess::vulkan::detail

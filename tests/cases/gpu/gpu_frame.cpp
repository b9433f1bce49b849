// Frames recorded into a host's command buffer, on its buffers: include/votess/vulkan.hpp.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <votess/vulkan.hpp>

#include "input/options.hpp"
#include "support/allocations.hpp"
#include "support/generators.hpp"
#include "support/gpu/gpu.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using test::PointSet;
using namespace votess::vulkan;
using votess::CellStatus;
namespace vk = test::vk;

// A host with a device of its own, lent to plans.
struct Host {
    test::Gpu gpu;
    vk::Memory memory{*gpu.device};
    vk::Commands commands{*gpu.device};
    bool float64 = true, probe = true, subgroup_size_control = false;

    [[nodiscard]] HostInstance instance() const {
        return {gpu.instance->handle(), loader.calls().vkGetInstanceProcAddr, gpu.instance->version()};
    }
    [[nodiscard]] HostDevice device() {
        HostDevice host;
        host.host = instance();
        host.physical_device = gpu.adapter.handle;
        host.device = gpu.device->handle();
        host.queue_family = gpu.adapter.queue_family;
        host.features.shaderFloat64 = float64 && gpu.adapter.float64;
        host.subgroup_size_control = subgroup_size_control;  // enabled where the adapter has it
        host.debug_utils = gpu.instance->debug_utils();
        if (probe) gpu.device->table().vkGetDeviceQueue(host.device, host.queue_family, 0, &host.probe_queue);
        return host;
    }
    vk::Loader loader;
};

// Buffers of a frame, which the host can see.
struct Target {
    vk::Buffer seeds, workspace, header, cells, indices, geometry, shifts;
    Frame frame;

    Target(Host& host, const Plan& plan) {
        const BufferSizes& sizes = plan.sizes();
        const auto visible = [&](VkDeviceSize bytes) { return host.memory.buffer(bytes, vk::MemoryKind::download); };
        seeds = host.memory.buffer(sizes.seeds, vk::MemoryKind::upload);
        workspace = host.memory.buffer(sizes.workspace, vk::MemoryKind::device);
        header = visible(sizes.header);
        cells = visible(sizes.cells);
        indices = visible(sizes.indices);
        geometry = visible(sizes.geometry);
        shifts = visible(sizes.shifts);
        frame = plan.frame({.seeds = {seeds.handle()},
                            .workspace = {workspace.handle()},
                            .header = {header.handle()},
                            .cells = {cells.handle()},
                            .indices = {indices.handle()},
                            .geometry = {geometry.handle()},
                            .shifts = {shifts.handle()}});
    }

    template <class Real>
    void write(const Coordinates& points, std::uint32_t stride) {
        const auto to = seeds.as<Real>();
        for (std::size_t i = 0; i < points.size(); ++i) to[i / 3 * stride + i % 3] = static_cast<Real>(points[i]);
        seeds.flush();
    }
    [[nodiscard]] Header head() const {
        Header h;
        std::memcpy(&h, header.mapped().data(), sizeof h);
        return h;
    }
    [[nodiscard]] std::span<const Cell> cell(std::size_t count) const { return cells.as<Cell>().first(count); }
};

void run(Host& host, std::span<const Target* const> targets, std::uint32_t count,
         const std::optional<votess::Box>& box = {}) {
    host.commands.begin();
    host.commands.barrier();
    for (const Target* target : targets) target->frame.record(host.commands.handle(), {.count = count, .box = box});
    host.commands.barrier_to_host();
    host.commands.end();
    host.commands.submit();
    host.commands.wait();
    for (const Target* target : targets)
        for (const vk::Buffer* buffer :
             {&target->header, &target->cells, &target->indices, &target->geometry, &target->shifts})
            buffer->invalidate();
}

void run(Host& host, const Target& target, std::uint32_t count) {
    const Target* const one[] = {&target};
    run(host, one, count);
}

struct Rows {
    std::vector<std::vector<std::int32_t>> rows;
    std::vector<std::vector<std::int8_t>> shifts;  // three an entry, of periodic plans
    std::vector<double> volumes, centroids;
    std::vector<CellStatus> status;
};

// The frame, with what resolve() adds.
template <class Real>
Rows collect(const Plan& plan, const Target& target, std::size_t count, const std::optional<votess::Box>& box = {}) {
    Rows all;
    const std::uint32_t stride = plan.options().stride;
    const auto seeds = target.seeds.as<Real>();
    for (std::size_t i = 0; i < count; ++i) {
        const Cell& cell = target.cell(count)[i];
        const auto row = target.indices.as<std::int32_t>().subspan(cell.row_begin, cell.row_length);
        all.rows.emplace_back(row.begin(), row.end());
        all.shifts.emplace_back();
        for (std::uint32_t k = 0; k < cell.row_length && plan.sizes().shifts > 0; ++k) {
            const auto four = target.shifts.as<std::int8_t>().subspan(4 * (std::size_t{cell.row_begin} + k), 4);
            all.shifts[i].insert(all.shifts[i].end(), four.begin(), four.begin() + 3);
            CHECK(four[3] == 0);
        }
        all.status.push_back(static_cast<CellStatus>(cell.status));
        const auto g = target.geometry.as<float>().subspan(4 * i, 4);
        all.volumes.push_back(g[3]);
        for (std::size_t k = 0; k < 3; ++k) all.centroids.push_back(double{seeds[i * stride + k]} + double{g[k]});
    }
    const Resolved more = plan.resolve(std::span<const Real>(seeds), target.cell(count), {.box = box, .threads = 0});
    for (std::size_t r = 0; r < more.cells.size(); ++r) {
        const std::size_t i = more.cells[r];
        CHECK(all.rows[i].empty());
        all.rows[i].assign(more.indices.begin() + more.indptr[r], more.indices.begin() + more.indptr[r + 1]);
        if (plan.sizes().shifts > 0)
            all.shifts[i].assign(more.shifts.begin() + 3 * more.indptr[r],
                                 more.shifts.begin() + 3 * more.indptr[r + 1]);
        all.volumes[i] = more.volumes[r];
        all.status[i] = more.status[r];
        for (std::size_t k = 0; k < 3; ++k) all.centroids[3 * i + k] = more.centroids[3 * r + k];
    }
    return all;
}

std::string compare(const Rows& rows, const votess::Tessellation& t) {
    for (std::size_t i = 0; i < t.size(); ++i) {
        const std::string where = "cell " + std::to_string(i) + ": ";
        if (rows.status[i] != t.status()[i]) return where + "another status";
        if (!std::ranges::equal(rows.rows[i], t.neighbors(i))) return where + "another row";
        if (!t.shifts().empty() &&
            !std::ranges::equal(rows.shifts[i], t.shifts().subspan(3 * static_cast<std::size_t>(t.indptr()[i]),
                                                                   3 * t.neighbors(i).size())))
            return where + "another shift";
        const double volume = t.volumes()[i];
        if (t.status()[i] != CellStatus::certified) continue;
        // Frames hold float32.
        if (!(volume >= std::numeric_limits<float>::min() && volume <= std::numeric_limits<float>::max())) continue;
        if (!(std::abs(rows.volumes[i] - volume) <= 1e-5 * volume)) return where + "another volume";
        for (std::size_t k = 0; k < 3; ++k)
            if (!(std::abs(rows.centroids[3 * i + k] - t.centroids()[3 * i + k]) <= 1e-4 * std::cbrt(volume)))
                return where + "another centroid";
    }
    return "";
}

void check_header(const Header& h, std::span<const Cell> cells) {
    Header sums{};
    for (const Cell& cell : cells) {
        switch (static_cast<CellStatus>(cell.status)) {
            case CellStatus::certified:
                ++sums.certified;
                break;
            case CellStatus::duplicate:
                ++sums.duplicates;
                break;
            case CellStatus::outside:
                ++sums.outside;
                break;
            default:
                ++sums.unresolved;
        }
        sums.faces += cell.faces;
        sums.entries += cell.row_length;
    }
    CHECK(h.seeds == cells.size());
    CHECK(h.certified == sums.certified);
    CHECK(h.unresolved == sums.unresolved);
    CHECK(h.duplicates == sums.duplicates);
    CHECK(h.outside == sums.outside);
    CHECK(h.faces == sums.faces);
    CHECK(h.entries == sums.entries);
}

PlanOptions options_for(const PointSet& set) {
    PlanOptions options;
    options.most_seeds = static_cast<std::uint32_t>(set.size());
    options.format = SeedFormat::float64;
    options.most_entries = 64 * options.most_seeds;
    votess::Options whole;
    whole.box = set.box;
    options.box = votess::validate({set.points, {}}, whole).box;
    return options;
}

votess::Tessellation on_cpu(const PointSet& set, const PlanOptions& plan) {
    votess::Options options = test::all_options(plan.box);
    options.list_walls = plan.list_walls;
    options.periodic = plan.periodic;
    options.device = "cpu";
    return votess::tessellate(std::span<const double>(set.points), options);
}

std::string check(Host& host, const PointSet& set, PlanOptions options) {
    const Plan plan(host.device(), options);
    Target target(host, plan);
    target.write<double>(set.points, options.stride);
    run(host, target, options.most_seeds);
    check_header(target.head(), target.cell(set.size()));
    return compare(collect<double>(plan, target, set.size()), on_cpu(set, options));
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu frame: every family equals the CPU") {
        Host host;
        const std::size_t n = test::by_size(600, 80);
        const auto families = test::families(n, n + 3);
        // Every plan has pipelines of its own, which take long to compile where sanitizers watch the compiler.
        for (std::size_t i = 0; i < families.size(); i += test::by_size(1, 5)) {
            CAPTURE(families[i].name);
            CHECK(check(host, families[i], options_for(families[i])) == "");
        }
    }

    TEST_CASE("gpu frame: few seeds, with walls in the rows") {
        Host host;
        for (const std::size_t n : {1, 2, 3, 9}) {
            const PointSet set = test::uniform(n, n);
            CAPTURE(n);
            PlanOptions options = options_for(set);
            options.list_walls = true;
            CHECK(check(host, set, options) == "");
        }
    }

    TEST_CASE("gpu frame: chunks, strides, short lists") {
        Host host;
        const PointSet set = test::clustered(test::by_size(3000, 300), 5);
        for (const auto& [chunk, stride, k_init] : {std::array{0u, 4u, 0u}, {100u, 3u, 20u}, {1001u, 7u, 0u}}) {
            PlanOptions options = options_for(set);
            options.chunk_size = chunk;
            options.stride = stride;
            options.k_init = k_init;
            CHECK(check(host, set, options) == "");
        }
    }

    TEST_CASE("gpu frame: a subgroup per cell") {
        Host host;
        const test::UseKernel chosen(test::by_subgroup());
        PlanOptions options;
        for (const PointSet& set :
             {test::uniform(300, 15), test::clustered(300, 16), test::with_duplicates(130, 20, 17), test::bcc(3)}) {
            CAPTURE(set.name);
            options = options_for(set);
            options.chunk_size = 100;
            CHECK(check(host, set, options) == "");
        }
        // With the size asked for, where that can be.
        host.subgroup_size_control = requirements(host.instance(), host.gpu.adapter.handle).subgroup_size_control;
        const PointSet set = test::uniform(300, 18);
        options = options_for(set);
        CHECK(check(host, set, options) == "");
        options.box = test::unit_box();
        options.periodic = {true, false, true};
        CHECK(check(host, set, options) == "");
        options.most_images = 1;  // too few
        CHECK(check(host, set, options) == "");
    }

    TEST_CASE("gpu frame: a box that changes from frame to frame") {
        Host host;
        PointSet set = test::uniform(300, 13);
        PlanOptions options = options_for(set);
        const Plan plan(host.device(), options);
        Target target(host, plan);
        const Target* const one[] = {&target};
        for (const double factor : {1.0, 0.5, 3.0, 1e4}) {
            for (double& x : set.points) x *= factor;
            target.write<double>(set.points, 3);
            const votess::Box box = test::cube(-factor * factor, 2e4 * factor);
            run(host, one, options.most_seeds, box);
            options.box = box;
            CHECK(compare(collect<double>(plan, target, set.size(), box), on_cpu(set, options)) == "");
        }
        host.commands.begin();
        CHECK(test::error_of([&] {
                  target.frame.record(host.commands.handle(), {.count = 1, .box = test::cube(1, 0)});
              }) == votess::ErrorCode::invalid_argument);
        host.commands.end();
    }

    TEST_CASE("gpu frame: periodic boxes, seeds up to a side outside") {
        Host host;
        const auto axes = [](unsigned bits) {
            return std::array<bool, 3>{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
        };
        for (const std::size_t n : {std::size_t{1}, std::size_t{2}, std::size_t{9}, test::by_size(1500, 200)})
            for (unsigned bits = n == 2 ? 6 : 1; bits < 8; bits += static_cast<unsigned>(test::by_size(3, 6))) {
                CAPTURE(n);
                CAPTURE(bits);
                PointSet set = test::uniform(n, n + bits);
                set.box = votess::Box{{-0.25, 0, 0.5}, {0.75, 1.5, 1.75}};
                test::Random random(n * bits);
                for (std::size_t i = 0; i < set.points.size(); ++i) {
                    const std::size_t k = i % 3;
                    const double side = set.box->upper[k] - set.box->lower[k];
                    set.points[i] = set.box->lower[k] + set.points[i] * side;
                    if (axes(bits)[k] && random.below(4) == 0)
                        set.points[i] += side * (random.below(2) == 0 ? 1 : -1) * 0.999;
                }
                set.points[0] = (bits & 1) != 0 ? set.box->upper[0] : set.box->lower[0];
                const votess::Box box = *set.box;
                set.box.reset();
                PlanOptions options = options_for(set);
                options.box = box;
                options.periodic = axes(bits);
                options.list_walls = n == 9;
                options.chunk_size = n == 9 ? 5 : 0;
                const Plan plan(host.device(), options);
                Target target(host, plan);
                target.write<double>(set.points, 3);
                run(host, target, options.most_seeds);
                check_header(target.head(), target.cell(n));
                if (n > 1000) CHECK(target.head().unresolved < n / 10);
                const Rows rows = collect<double>(plan, target, n);
                Rows absolute = rows;  // centroids are relative to the seed as given; the library's lie in the box
                const auto t = on_cpu(set, options);
                for (std::size_t i = 0; i < rows.centroids.size(); ++i) {
                    const std::size_t k = i % 3;
                    const double side = box.upper[k] - box.lower[k];
                    if (options.periodic[k])
                        absolute.centroids[i] -= side * std::round((absolute.centroids[i] - t.centroids()[i]) / side);
                }
                CHECK(compare(absolute, t) == "");
            }
    }

    TEST_CASE("gpu frame: a seed just a side outside of a periodic box, as doubles have it") {
        Host host;
        PointSet set = test::uniform(60, 15);
        set.box.reset();
        test::Random random(16);
        for (int tries = 0; tries < 6; ++tries) {
            PlanOptions options = options_for(set);
            options.periodic = {true, true, true};
            for (std::size_t k = 0; k < 3; ++k) {
                double side = 0;
                do {  // until the rounded place is farther away than a side
                    options.box.lower[k] = random.uniform(-1, 1);
                    options.box.upper[k] = options.box.lower[k] + random.uniform(0.7, 1.5);
                    side = options.box.upper[k] - options.box.lower[k];
                } while (!(static_cast<long double>(options.box.lower[k] - side) <
                           static_cast<long double>(options.box.lower[k]) * 2 - options.box.upper[k]));
                for (std::size_t i = k; i < set.points.size(); i += 3)
                    set.points[i] = options.box.lower[k] + random.uniform(0.01, 0.99) * side;
                set.points[k] = options.box.lower[k] - side;
            }
            const Plan plan(host.device(), options);
            Target target(host, plan);
            target.write<double>(set.points, 3);
            run(host, target, options.most_seeds);
            check_header(target.head(), target.cell(set.size()));
            const auto rows = collect<double>(plan, target, set.size()).rows;
            const auto t = on_cpu(set, options);
            for (std::size_t i = 0; i < t.size(); ++i) CHECK(std::ranges::equal(rows[i], t.neighbors(i)));
        }
    }

    TEST_CASE("gpu frame: periodic lattices, too few places for images, short margins, far seeds") {
        Host host;
        PointSet set = test::uniform(300, 14);
        PlanOptions options = options_for(set);
        options.box = test::unit_box();
        options.periodic = {true, true, true};
        const auto expected = on_cpu(set, options);
        std::uint32_t images = 0;
        for (const double margin : {0.0, 1e-3, 0.1, 7.0}) {
            options.margin = margin;
            options.most_images = margin == 7 ? 30 * options.most_seeds : 0;
            const Plan plan(host.device(), options);
            Target target(host, plan);
            target.write<double>(set.points, 3);
            run(host, target, options.most_seeds);
            if (margin == 0) images = target.head().images;
            CHECK((margin == 1e-3) == (target.head().images < 20));
            CHECK(compare(collect<double>(plan, target, set.size()), expected) == "");
        }
        options.margin = 0;
        REQUIRE(images > 10);
        for (const std::uint32_t places : {1u, images - 1, images}) {
            options.most_images = places;
            const Plan plan(host.device(), options);
            Target target(host, plan);
            target.write<double>(set.points, 3);
            run(host, target, options.most_seeds);
            CHECK(target.head().images == images);
            CHECK((target.head().unresolved == options.most_seeds) == (places < images));
            CHECK(compare(collect<double>(plan, target, set.size()), expected) == "");
        }
        const PointSet lattice = test::bcc(4);
        options = options_for(lattice);
        options.box = test::cube(0, 4);
        options.periodic = {true, true, true};
        CHECK(check(host, lattice, options) == "");
        // Farther away than a side, or along an axis that is not periodic.
        Coordinates far = set.points;
        far[0] = std::numeric_limits<double>::quiet_NaN();
        far[4] = -1.5;
        far[8] = 1.5;
        options = options_for(set);
        options.box = test::unit_box();
        options.periodic = {true, true, false};
        options.margin = 0.05;  // leaves cells to resolve()
        const Plan plan(host.device(), options);
        Target target(host, plan);
        target.write<double>(far, 3);
        run(host, target, options.most_seeds);
        CHECK(target.head().outside == 3);
        const Rows rows = collect<double>(plan, target, set.size());
        // The first three seeds are not there, for resolve() neither.
        const PointSet rest{"rest", {far.begin() + 9, far.end()}, test::unit_box()};
        const auto t = on_cpu(rest, options);
        CHECK(target.head().unresolved > 0);
        for (std::size_t i = 0; i < t.size(); ++i) {
            std::vector<std::int32_t> row(t.neighbors(i).begin(), t.neighbors(i).end());
            for (std::int32_t& id : row) id += 3;
            CHECK(rows.rows[i + 3] == row);
        }
        // Bounds that no common unit divides.
        options.box.lower[0] = -1e-30;
        CHECK(test::error_of([&] { Plan(host.device(), options); }) == votess::ErrorCode::unsupported);
    }

    TEST_CASE("gpu frame: float32 seeds") {
        Host host;
        PointSet set = test::uniform(test::by_size(2000, 200), 6);
        set.box = test::unit_box();
        for (double& x : set.points) x = static_cast<double>(static_cast<float>(x));
        PlanOptions options = options_for(set);
        options.format = SeedFormat::float32;
        options.stride = 4;
        const Plan plan(host.device(), options);
        Target target(host, plan);
        target.write<float>(set.points, 4);
        run(host, target, options.most_seeds);
        CHECK(target.head().unresolved < set.size() / 50);
        CHECK(compare(collect<float>(plan, target, set.size()), on_cpu(set, options)) == "");
    }

    TEST_CASE("gpu frame: seeds outside of the box, not finite, equal") {
        Host host;
        PointSet set = test::uniform(200, 7);
        set.box = votess::Box{{-1e-3, 0, 0}, {1, 1, 1}};
        for (const bool narrow : {false, true}) {
            Coordinates points = set.points;
            const double inf = std::numeric_limits<double>::infinity();
            const double above = narrow ? std::nextafter(1.0f, 2.0f) : std::nextafter(1.0, 2);
            const std::vector<std::pair<std::size_t, double>> bad{
                {0, above},  {7, -1e-30}, {100, std::numeric_limits<double>::quiet_NaN()}, {301, inf}, {402, -inf},
                {500, 1e30}, {31, -2}};
            for (const auto& [at, x] : bad) points[at] = x;
            points[34] = -0.0;   // y of seed 11: on the wall
            points[36] = 1;      // x of seed 12: on the wall
            points[39] = 1e-40;  // a subnormal float
            for (std::size_t k = 0; k < 3; ++k) points[3 * 150 + k] = points[3 * 50 + k];
            if (narrow)
                for (double& x : points) x = static_cast<double>(static_cast<float>(x));
            PlanOptions options = options_for(set);
            options.format = narrow ? SeedFormat::float32 : SeedFormat::float64;
            const Plan plan(host.device(), options);
            Target target(host, plan);
            if (narrow)
                target.write<float>(points, 3);
            else
                target.write<double>(points, 3);
            run(host, target, options.most_seeds);
            check_header(target.head(), target.cell(set.size()));
            CHECK(target.head().outside == bad.size());
            CHECK(target.head().duplicates <= 1);  // a coordinate so small that it was rounded leaves it to resolve()
            const Rows rows =
                narrow ? collect<float>(plan, target, set.size()) : collect<double>(plan, target, set.size());
            CHECK(rows.status[150] == CellStatus::duplicate);
            CHECK(rows.rows[150].empty());
            // As if they had never been there.
            std::vector<std::int32_t> kept;
            Coordinates inside;
            for (std::size_t i = 0; i < set.size(); ++i) {
                if (rows.status[i] == CellStatus::outside) continue;
                kept.push_back(static_cast<std::int32_t>(i));
                inside.insert(inside.end(), points.begin() + static_cast<std::ptrdiff_t>(3 * i),
                              points.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
            }
            REQUIRE(kept.size() + bad.size() == set.size());
            const auto t = on_cpu({"inside", inside, set.box}, options);
            for (std::size_t i = 0; i < kept.size(); ++i) {
                std::vector<std::int32_t> row(t.neighbors(i).begin(), t.neighbors(i).end());
                for (std::int32_t& id : row) id = kept[static_cast<std::size_t>(id)];
                CHECK(rows.rows[static_cast<std::size_t>(kept[i])] == row);
            }
        }
    }

    TEST_CASE("gpu frame: rows that do not fit are counted, and left to resolve()") {
        Host host;
        const PointSet set = test::uniform(test::by_size(1000, 200), 8);
        PlanOptions options = options_for(set);
        options.chunk_size = 150;
        const auto expected = on_cpu(set, options);
        for (const std::uint32_t entries : {1u, 500u, static_cast<std::uint32_t>(expected.indices().size() - 1)}) {
            options.most_entries = entries;
            const Plan plan(host.device(), options);
            Target target(host, plan);
            target.write<double>(set.points, 3);
            run(host, target, options.most_seeds);
            const Header h = target.head();
            CHECK(h.entries > entries);
            CHECK(h.unresolved > 0);
            std::uint32_t written = 0;
            for (const Cell& cell : target.cell(set.size())) {
                written += cell.row_length;
                CHECK(cell.row_begin + cell.row_length <= entries);
            }
            CHECK(written <= entries);
            CHECK(compare(collect<double>(plan, target, set.size()), expected) == "");
        }
    }

    TEST_CASE("gpu frame: moving seeds, fewer seeds, without taking memory; two frames in one command buffer") {
        Host host;
        PointSet set = test::uniform(test::by_size(1500, 300), 9);
        set.box = test::unit_box();
        PlanOptions options = options_for(set);
        const Plan plan(host.device(), options);
        PlanOptions other = options;
        other.list_walls = true;
        other.chunk_size = 200;
        const Plan second(host.device(), other);
        Target target(host, plan), beside(host, second);
        const Target* const both[] = {&target, &beside};
        test::Random random(10);
        for (int frame = 0; frame < 4; ++frame) {
            for (double& x : set.points) x = std::clamp(x + random.uniform(-0.02, 0.02), 0.0, 1.0);
            const std::uint32_t count = options.most_seeds - static_cast<std::uint32_t>(frame) * 37;
            set.points.resize(std::size_t{3} * count);
            target.write<double>(set.points, 3);
            beside.write<double>(set.points, 3);
            run(host, both, count);
            CHECK(compare(collect<double>(plan, target, count), on_cpu(set, options)) == "");
            CHECK(compare(collect<double>(second, beside, count), on_cpu(set, other)) == "");
        }
        // Nothing is taken while recording; but the validation layer does.
        host.commands.begin();
        const auto recording = test::allocations();
        target.frame.record(host.commands.handle(), {.count = 100});
        beside.frame.record(host.commands.handle(), {.count = options.most_seeds - 1});
        const auto after = test::allocations();
        host.commands.end();
        if (recording && !host.gpu.instance->validation()) CHECK(*recording == *after);
    }

    TEST_CASE("gpu frame: no float64, no probe, neighbors or geometry alone, no seeds") {
        const PointSet set = test::uniform(test::by_size(1000, 200), 11);
        for (const bool float64 : {false, true})
            for (const bool probe : {false, true}) {
                Host host;
                host.float64 = float64;
                host.probe = probe;
                CHECK(check(host, set, options_for(set)) == "");
            }
        Host host;
        PlanOptions options = options_for(set);
        options.geometry = false;
        CHECK(Plan(host.device(), options).sizes().geometry == 0);
        const Plan rows_only(host.device(), options);
        Target rows(host, rows_only);
        rows.write<double>(set.points, 3);
        run(host, rows, options.most_seeds);
        const auto t = on_cpu(set, options);
        for (std::size_t i = 0; i < set.size(); ++i) {
            const Cell& cell = rows.cell(set.size())[i];
            if (cell.status != 0) continue;
            CHECK(std::ranges::equal(rows.indices.as<std::int32_t>().subspan(cell.row_begin, cell.row_length),
                                     t.neighbors(i)));
        }
        options.geometry = true;
        options.neighbors = false;
        const Plan geometry_only(host.device(), options);
        CHECK(geometry_only.sizes().indices == 0);
        Target geometry(host, geometry_only);
        geometry.write<double>(set.points, 3);
        run(host, geometry, options.most_seeds);
        for (std::size_t i = 0; i < set.size(); ++i)
            if (geometry.cell(set.size())[i].status == 0)
                CHECK(geometry.geometry.as<float>()[4 * i + 3] == doctest::Approx(t.volumes()[i]).epsilon(1e-5));
        run(host, geometry, 0);
        CHECK(geometry.head().seeds == 0);
        CHECK(geometry.head().certified == 0);
    }

    TEST_CASE("gpu frame: the workspace is as large as the header says") {
        Host host;
        PlanOptions options;
        options.box = test::unit_box();
        for (const std::uint32_t seeds : {1000u, 100000u, 5000000u})
            for (const std::uint32_t chunk : {100u, 10000u}) {
                options.most_seeds = seeds;
                options.chunk_size = chunk;
                const VkDeviceSize workspace = Plan(host.device(), options).sizes().workspace;
                CHECK(workspace < 90 * VkDeviceSize{seeds} + 900 * VkDeviceSize{chunk} + (1u << 20));
                CHECK(workspace > 80 * VkDeviceSize{seeds});
            }
    }

    TEST_CASE("gpu frame: what is refused") {
        Host host;
        const PointSet set = test::uniform(50, 12);
        const PlanOptions good = options_for(set);
        std::string said;
        const auto refused = [&](auto call) {
            const auto code = test::error_of(call, &said);
            return code == votess::ErrorCode::invalid_argument;
        };
        CHECK(refused([&] { Plan({}, good); }));
        PlanOptions options = good;
        options.most_seeds = 0;
        CHECK(refused([&] { Plan(host.device(), options); }));
        CHECK(said == "most_seeds = 0 must be 1 to 134217728");
        options = good;
        options.stride = 2;
        CHECK(refused([&] { Plan(host.device(), options); }));
        options = good;
        options.format = static_cast<SeedFormat>(2);
        CHECK(refused([&] { Plan(host.device(), options); }));
        CHECK(said == "format = 2 is neither float32 nor float64");
        {
            const test::Environment environment("VOTESS_VULKAN_KERNEL", "warp");
            CHECK(refused([&] { Plan(host.device(), good); }));
            CHECK(said == "VOTESS_VULKAN_KERNEL is 'warp': give automatic, invocation or subgroup");
        }
        options = good;
        options.k_init = 1025;
        CHECK(refused([&] { Plan(host.device(), options); }));
        options = good;
        options.box.upper = options.box.lower;
        CHECK(refused([&] { Plan(host.device(), options); }));
        options = good;
        options.most_entries = std::numeric_limits<std::uint32_t>::max();
        if (host.gpu.adapter.limits.maxStorageBufferRange < 4 * VkDeviceSize{options.most_entries})
            CHECK(test::error_of([&] { Plan(host.device(), options); }) == votess::ErrorCode::unsupported);
        const Plan plan(host.device(), good);
        CHECK(refused([&] { Frame().record(VK_NULL_HANDLE, {}); }));
        CHECK(refused([&] { static_cast<void>(plan.frame({})); }));
        CHECK(said == "the buffer of workspace is null");
        Target target(host, plan);
        CHECK(refused([&] { target.frame.record(VK_NULL_HANDLE, {}); }));
        host.commands.begin();
        CHECK(refused([&] { target.frame.record(host.commands.handle(), {.count = 51}); }));
        CHECK(said == "count = 51 is more than most_seeds = 50");
        host.commands.end();
        const std::vector<double> few(10);
        const std::vector<Cell> cells(50);
        CHECK(refused([&] { static_cast<void>(plan.resolve(few, cells)); }));
        CHECK(requirements(host.instance(), host.gpu.adapter.handle).missing.empty());
        CHECK(refused([&] { static_cast<void>(requirements({}, host.gpu.adapter.handle)); }));
    }
}

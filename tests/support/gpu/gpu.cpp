#include "support/gpu/gpu.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "input/settle.hpp"
#include "support/at_end.hpp"
#include "support/text.hpp"

namespace test {

namespace {

// Returns a lower bound of a cell's diameter, from its volume, its neighbors and the walls around it.
double size_of(const votess::Tessellation& t, std::span<const double> points, std::size_t i) {
    double size = t.volumes().empty() ? 0 : std::cbrt(t.volumes()[i]);
    double to_wall[3][2]{};
    for (const std::int32_t j : t.neighbors(i)) {
        if (j < -6) continue;
        if (j < 0) {
            const auto axis = static_cast<std::size_t>(-1 - j) / 2, side = static_cast<std::size_t>(-1 - j) % 2;
            const double wall = side == 0 ? t.box().lower[axis] : t.box().upper[axis];
            to_wall[axis][side] = std::abs(wall - points[3 * i + axis]);
            continue;
        }
        const double* q = points.data() + 3 * static_cast<std::size_t>(j);
        const double* p = points.data() + 3 * i;
        size = std::max(size, std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]) / 2);
    }
    for (const auto& w : to_wall) size = std::max(size, w[0] + w[1]);
    // Without volumes and rows: that of the mean cell.
    return size > 0 ? size : std::cbrt(t.stats().box_volume / static_cast<double>(t.size()));
}

template <class T>
bool equal(std::span<const T> a, std::span<const T> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

std::string text_row(std::span<const std::int32_t> row) {
    std::string all;
    for (const auto j : row) all.append(all.empty() ? "[" : " ").append(std::to_string(j));
    return all + "]";
}

std::string check_cell(const votess::Tessellation& gpu, const votess::Tessellation& cpu, std::span<const double> points,
                       double tolerance, std::size_t i) {
    if (gpu.status()[i] != cpu.status()[i]) return text("status of ", i, ": ", static_cast<int>(gpu.status()[i]));
    if (!equal(gpu.neighbors(i), cpu.neighbors(i)))
        return text("row ", i, ": ", text_row(gpu.neighbors(i)), " instead of ", text_row(cpu.neighbors(i)));
    if (!cpu.face_counts().empty() &&
        (gpu.face_counts()[i] != cpu.face_counts()[i] || gpu.edge_counts()[i] != cpu.edge_counts()[i] ||
         gpu.vertex_counts()[i] != cpu.vertex_counts()[i]))
        return text("counts of ", i, ": ", gpu.face_counts()[i], ' ', gpu.edge_counts()[i], ' ', gpu.vertex_counts()[i],
                    " instead of ", cpu.face_counts()[i], ' ', cpu.edge_counts()[i], ' ', cpu.vertex_counts()[i]);
    if (!cpu.face_areas().empty()) {
        const auto first = static_cast<std::size_t>(cpu.indptr()[i]),
                   end = static_cast<std::size_t>(cpu.indptr()[i + 1]);
        double surface = 0;
        for (std::size_t e = first; e < end; ++e) surface += cpu.face_areas()[e];
        for (std::size_t e = first; e < end; ++e) {
            const double area = gpu.face_areas()[e], exact = cpu.face_areas()[e];
            const double wall = cpu.lists_walls() ? 0 : 6 * std::pow(size_of(cpu, points, i), 2);
            if (area != exact && !(std::abs(area - exact) <=
                                   tolerance * (surface + wall) + 64 * std::numeric_limits<double>::denorm_min()))
                return text("area of the face of ", i, " with ", cpu.indices()[e], " is ", area, " instead of ", exact,
                            ", surface ", surface);
        }
    }
    if (!cpu.volumes().empty()) {
        const double v = gpu.volumes()[i], exact = cpu.volumes()[i];
        if (v != exact && !(std::abs(v - exact) <= tolerance * exact + 64 * std::numeric_limits<double>::denorm_min()))
            return text("volume ", i, " is ", v, " instead of ", exact);
    }
    if (!cpu.centroids().empty()) {
        const double size = size_of(cpu, points, i);
        for (std::size_t a = 0; a < 3; ++a) {
            const double c = gpu.centroids()[3 * i + a], exact = cpu.centroids()[3 * i + a];
            if (std::isnan(c) && std::isnan(exact)) continue;
            if (!(std::abs(c - exact) <= tolerance * size + 4 * 0x1p-53 * std::abs(exact) + 4 * 0x1p-1074))
                return text("centroid ", i, " axis ", a, " is ", c, " instead of ", exact, ", cell size ", size);
        }
    }
    return "";
}

}  // namespace

std::string check_same(const votess::Tessellation& gpu, const votess::Tessellation& cpu, std::span<const double> points,
                       double tolerance) {
    if (gpu.size() != cpu.size()) return text("size ", gpu.size(), " instead of ", cpu.size());
    if (gpu.indptr().size() != cpu.indptr().size() || gpu.volumes().size() != cpu.volumes().size() ||
        gpu.centroids().size() != cpu.centroids().size() || gpu.face_counts().size() != cpu.face_counts().size() ||
        gpu.face_areas().size() != cpu.face_areas().size() || gpu.edge_counts().size() != cpu.edge_counts().size() ||
        gpu.vertex_counts().size() != cpu.vertex_counts().size() || gpu.status().size() != cpu.status().size())
        return "an array has a wrong size";
    for (std::size_t i = 0; i < cpu.size(); ++i) {
        const std::string wrong = check_cell(gpu, cpu, points, tolerance, i);
        if (!wrong.empty()) return wrong;
    }
    if (!equal(gpu.indptr(), cpu.indptr())) return "indptr differs";
    if (!equal(gpu.duplicate_of(), cpu.duplicate_of())) return "duplicate_of differs";
    if (gpu.box().lower != cpu.box().lower || gpu.box().upper != cpu.box().upper) return "the box differs";
    if (gpu.lists_walls() != cpu.lists_walls()) return "lists_walls differs";
    const votess::Stats &a = gpu.stats(), &b = cpu.stats();
    if (a.points != b.points || a.faces != b.faces || a.duplicates != b.duplicates || a.empty_cells != b.empty_cells ||
        a.mean_faces != b.mean_faces || a.box_volume != b.box_volume)
        return text("stats differ: ", a.faces, " faces, ", a.duplicates, " duplicates instead of ", b.faces, ", ",
                    b.duplicates);
    if (a.fallback_cells + a.duplicates > a.points) return text("stats.fallback_cells ", a.fallback_cells);
    const votess::FallbackReasons& why = a.fallback_reasons;
    if (why.uncertain + why.overflow + why.exhausted + why.skipped + why.domain != a.fallback_cells)
        return text("stats.fallback_reasons do not add up to ", a.fallback_cells);
    if (a.volume_sum != b.volume_sum && !(std::abs(a.volume_sum - b.volume_sum) <= tolerance * b.volume_sum + 1e-320))
        return text("stats.volume_sum ", a.volume_sum, " instead of ", b.volume_sum);
    return "";
}

std::string device_name() {
    const char* name = std::getenv("VOTESS_TEST_DEVICE");
    return name != nullptr && *name != '\0' ? name : "lavapipe";
}

votess::gpu::Kernel by_subgroup() {
    static const bool can = votess::gpu::missing_for_subgroups(Gpu().adapter).empty();
    return can ? votess::gpu::Kernel::subgroup : votess::gpu::Kernel::invocation;
}

UseKernel::UseKernel(votess::gpu::Kernel kernel)
    : Environment("VOTESS_VULKAN_KERNEL", kernel == votess::gpu::Kernel::subgroup     ? "subgroup"
                                          : kernel == votess::gpu::Kernel::invocation ? "invocation"
                                                                                      : nullptr) {}

votess::Precision double_precision() {
    static const bool can = Gpu().device->has_float64();
    return can ? votess::Precision::double_ : votess::Precision::single;
}

votess::Tessellator& shared_tessellator() {
    static std::optional<votess::Tessellator> tessellator;
    if (!tessellator) {
        tessellator.emplace();
        at_end([] { tessellator.reset(); });
    }
    return *tessellator;
}

votess::Tessellation GpuRunner::run(const PointSet& set, votess::Options options) {
    options.box = set.box;
    votess::StageClock clock;
    votess::detail::Result result;
    const votess::Job job = votess::make_job(votess::settle({set.points, {}}, options));
    const auto domain = votess::gpu::device_domain(job);
    engine.run(job, domain ? &*domain : nullptr, clock, result);
    result.stats.seconds = clock.seconds();
    return votess::Tessellation(std::make_shared<const votess::detail::Result>(std::move(result)));
}

}  // namespace test

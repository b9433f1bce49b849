// Sinkhorn's iteration on two grids: one has the density, the other the targets. Potentials are soft minima over the
// other grid, of squared distance less its potential. They are smooth over the root of epsilon, which halves from step
// to step; grids become finer with it. A soft minimum is made axis by axis, for a squared distance is a sum over axes.
// Method: Cuturi, Sinkhorn distances (NIPS 2013); Schmitzer, Stabilized sparse scaling algorithms for entropy
// regularized transport problems, SIAM J. Sci. Comput. 41, 2019.
#include "fit/smooth_start.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/progress.hpp"

namespace votess::fit {
namespace {

using Shape = std::array<std::size_t, 3>;

constexpr std::array<double, 2> nodes_per_seed_and_axis{1, 2};  // in the plane, in space
constexpr std::array<double, 2> min_nodes{64.0 * 64, 24.0 * 24 * 24}, max_nodes{256.0 * 256, 64.0 * 64 * 64};
constexpr double max_along_axis = 512;
constexpr double coarsest_steps = 16;  // along the longest axis
constexpr double steps_of_blur = 2;    // of the grid, in the root of epsilon
constexpr int sweeps = 8, last_sweeps = 12;
constexpr double nothing = -1e200;  // the logarithm of no mass
constexpr double negligible = 36;   // as a difference of logarithms
constexpr std::size_t lines_of_task = 16;

struct Field {
    Shape shape{1, 1, 1};
    std::vector<double> values;

    [[nodiscard]] std::size_t size() const { return shape[0] * shape[1] * shape[2]; }
};

// The nodes of a grid along each axis: the middles of equal intervals.
struct Nodes {
    std::array<double, 3> lower{}, step{1, 1, 1};
    Shape shape{1, 1, 1};
    std::int64_t first = 0;  // number of the first node

    [[nodiscard]] double at(std::size_t k, std::size_t i) const {
        return lower[k] + (static_cast<double>(static_cast<std::int64_t>(i) + first) + 0.5) * step[k];
    }
};

class Transport {
public:
    Transport(const Job& job, const Under& density, std::span<const double> places, const Vector& targets,
              const Edges& edges, int dimensions, ThreadPool& pool)
        : job_(job),
          density_(density),
          places_(places),
          targets_(targets),
          dimensions_(static_cast<std::size_t>(dimensions)),
          pool_(pool) {
        for (std::size_t k = 0; k < dimensions_; ++k) {
            const double corner = job.region.cell ? job.region.cell->origin[k] : job.box.lower[k];
            domain_[k] = seeds_[k] = {std::min(corner, corner + edges[k][k]), std::max(corner, corner + edges[k][k])};
            mirrored_[k] = edges[k][k] < 0;
            period_[k] = job.domain->periodic[k] ? std::abs(edges[k][k]) : 0;
            for (std::size_t i = k; i < places.size() && period_[k] == 0; i += 3) {
                seeds_[k][0] = std::min(seeds_[k][0], places[i]);
                seeds_[k][1] = std::max(seeds_[k][1], places[i]);
            }
        }
    }

    [[nodiscard]] std::optional<Vector> weights() {
        double size = 1, longest = 0;
        for (std::size_t k = 0; k < dimensions_; ++k) {
            size *= domain_[k][1] - domain_[k][0];
            longest = std::max(longest, seeds_[k][1] - seeds_[k][0]);
        }
        const double d = static_cast<double>(dimensions_);
        const std::size_t space = dimensions_ - 2;  // 0: the plane
        const double count = std::pow(nodes_per_seed_and_axis[space], d) * static_cast<double>(targets_.size());
        const double finest = std::pow(size / std::clamp(count, min_nodes[space], max_nodes[space]), 1 / d);
        double step = finest;
        while (2 * step < longest / coarsest_steps) step *= 2;
        double epsilon = longest * longest;
        Nodes from, to;  // of the density, of the targets
        Field of_density, of_targets, potential, other;
        for (bool first = true;; first = false, step /= 2) {
            const Nodes next = nodes(domain_, step);
            if (first) {
                potential.shape = next.shape;
                potential.values.assign(potential.size(), 0);
            } else {
                potential = soft_minimum(of_targets, other, to, next, epsilon);
            }
            from = next;
            to = nodes(seeds_, step);
            of_density = density_on(from);
            of_targets = targets_on(to);
            if (of_density.values.empty()) return {};
            const double end = std::pow(steps_of_blur * step, 2);
            const bool last = step <= 1.5 * finest;
            while (epsilon > end) {
                epsilon = std::max(epsilon / 2, end);
                for (int i = 0; i < (last && epsilon == end ? last_sweeps : sweeps); ++i) {
                    check_stop();
                    other = soft_minimum(of_density, potential, from, to, epsilon);
                    potential = soft_minimum(of_targets, other, to, from, epsilon);
                }
            }
            if (last) break;
        }
        Nodes wide = to;  // two more on each side
        wide.first = -2;
        for (std::size_t k = 0; k < dimensions_; ++k) wide.shape[k] += 4;
        return at_places(soft_minimum(of_density, potential, from, wide, epsilon), wide);
    }

private:
    using Bounds = std::array<std::array<double, 2>, 3>;

    [[nodiscard]] Nodes nodes(const Bounds& bounds, double step) const {
        Nodes nodes;
        for (std::size_t k = 0; k < dimensions_; ++k) {
            const double length = bounds[k][1] - bounds[k][0];
            nodes.shape[k] = static_cast<std::size_t>(std::clamp(std::round(length / step), 1.0, max_along_axis));
            nodes.lower[k] = bounds[k][0];
            nodes.step[k] = length / static_cast<double>(nodes.shape[k]);
        }
        return nodes;
    }

    // Returns logarithms of the shares of the mass at nodes; no values without mass.
    [[nodiscard]] Field density_on(const Nodes& nodes) const {
        Field field;
        for (std::size_t k = 0; k < 3; ++k) field.shape[k] = static_cast<std::size_t>(density_.frame.axis(k).count);
        field.values = density_.values;
        for (std::size_t k = 0; k < dimensions_; ++k) field = resampled(field, k, nodes.shape[k], mirrored_[k]);
        if (dimensions_ == 2) field.shape[2] = 1;
        for (std::size_t i = 0; i < field.size() && !job_.region.walls.empty(); ++i)
            if (is_beyond_walls(nodes, i)) field.values[i] = 0;
        return logarithms(std::move(field));
    }

    [[nodiscard]] bool is_beyond_walls(const Nodes& nodes, std::size_t i) const {
        std::array<double, 3> x{};
        for (std::size_t k = 3; k-- > 0; i /= nodes.shape[k])
            if (k < dimensions_) x[k] = nodes.at(k, i % nodes.shape[k]);
        return std::ranges::any_of(job_.region.walls, [&](const Wall& wall) {
            return wall.normal[0] * x[0] + wall.normal[1] * x[1] + wall.normal[2] * x[2] > wall.offset;
        });
    }

    [[nodiscard]] static Field resampled(const Field& from, std::size_t k, std::size_t count, bool mirrored) {
        Field to;
        to.shape = from.shape;
        to.shape[k] = count;
        to.values.assign(to.size(), 0);
        std::size_t inner = 1;
        for (std::size_t j = k + 1; j < 3; ++j) inner *= from.shape[j];
        const std::size_t n = from.shape[k], outer = from.size() / n / inner;
        const double ratio = static_cast<double>(count) / static_cast<double>(n);
        for (std::size_t i = 0; i < n; ++i) {
            const double begin = static_cast<double>(i) * ratio, end = static_cast<double>(i + 1) * ratio;
            for (auto j = static_cast<std::size_t>(begin); j < count && static_cast<double>(j) < end; ++j) {
                const double share =
                    std::min(end, static_cast<double>(j + 1)) - std::max(begin, static_cast<double>(j));
                const std::size_t source = mirrored ? n - 1 - i : i;
                for (std::size_t o = 0; o < outer; ++o)
                    for (std::size_t r = 0; r < inner; ++r)
                        to.values[(o * count + j) * inner + r] += share * from.values[(o * n + source) * inner + r];
            }
        }
        return to;
    }

    // Distributes each target among the nodes around its seed.
    [[nodiscard]] Field targets_on(const Nodes& nodes) const {
        Field field;
        field.shape = nodes.shape;
        field.values.assign(field.size(), 0);
        in_pieces(static_cast<std::size_t>(targets_.size()), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                std::array<std::array<std::size_t, 2>, 3> at{};
                std::array<std::array<double, 2>, 3> share{{{1, 0}, {1, 0}, {1, 0}}};
                for (std::size_t k = 0; k < dimensions_; ++k) {
                    const double x = (places_[3 * i + k] - nodes.lower[k]) / nodes.step[k] - 0.5;
                    const auto n = static_cast<std::int64_t>(nodes.shape[k]),
                               low = static_cast<std::int64_t>(std::floor(x));
                    share[k][1] = x - static_cast<double>(low);
                    share[k][0] = 1 - share[k][1];
                    for (std::int64_t side = 0; side < 2; ++side)
                        at[k][static_cast<std::size_t>(side)] =
                            static_cast<std::size_t>(period_[k] > 0 ? ((low + side) % n + n) % n
                                                                    : std::clamp<std::int64_t>(low + side, 0, n - 1));
                }
                for (std::size_t corner = 0; corner < 8; ++corner) {
                    const std::size_t a = corner & 1, b = corner >> 1 & 1, c = corner >> 2;
                    const double part = share[0][a] * share[1][b] * share[2][c];
                    if (part > 0)
                        field.values[(at[0][a] * nodes.shape[1] + at[1][b]) * nodes.shape[2] + at[2][c]] +=
                            part * targets_[static_cast<Eigen::Index>(i)];
                }
            }
        });
        return logarithms(std::move(field));
    }

    [[nodiscard]] static Field logarithms(Field field) {
        double sum = 0;
        for (const double x : field.values) sum += x;
        if (!(sum > 0)) return {};
        for (double& x : field.values) x = x > 0 ? std::log(x / sum) : nothing;
        return field;
    }

    // Returns the soft minimum at other nodes of squared distance less potential. shares: their logarithms.
    [[nodiscard]] Field soft_minimum(const Field& shares, const Field& potential, const Nodes& from, const Nodes& to,
                                     double epsilon) const {
        Field field = shares;
        for (std::size_t i = 0; i < field.values.size(); ++i)
            field.values[i] = std::max(nothing, field.values[i] + potential.values[i] / epsilon);
        for (std::size_t k = 0; k < dimensions_; ++k) field = along(field, k, from, to, epsilon);
        for (double& x : field.values) x *= -epsilon;
        return field;
    }

    // Sums along an axis: logarithms of sums of exponentials.
    [[nodiscard]] Field along(const Field& from, std::size_t k, const Nodes& of, const Nodes& at,
                              double epsilon) const {
        const std::size_t n = of.shape[k], m = at.shape[k];
        std::vector<double> kernel(m * n);
        for (std::size_t i = 0; i < m; ++i)
            for (std::size_t j = 0; j < n; ++j) {
                double distance = at.at(k, i) - of.at(k, j);
                if (period_[k] > 0) distance -= period_[k] * std::round(distance / period_[k]);
                kernel[i * n + j] = -distance * distance / epsilon;
            }
        Field to;
        to.shape = from.shape;
        to.shape[k] = m;
        to.values.resize(to.size());
        std::size_t inner = 1;
        for (std::size_t j = k + 1; j < 3; ++j) inner *= from.shape[j];
        const std::size_t lines = from.size() / n;
        pool_.run((lines + lines_of_task - 1) / lines_of_task, [&](std::size_t task, unsigned) {
            check_stop();
            std::vector<double> line(n), sum(n);
            for (std::size_t l = task * lines_of_task; l < std::min(lines, (task + 1) * lines_of_task); ++l) {
                const std::size_t outer = l / inner, rest = l % inner;
                for (std::size_t j = 0; j < n; ++j) line[j] = from.values[(outer * n + j) * inner + rest];
                for (std::size_t i = 0; i < m; ++i)
                    to.values[(outer * m + i) * inner + rest] = soft_maximum(line, &kernel[i * n], sum);
            }
        });
        return to;
    }

    [[nodiscard]] static double soft_maximum(const std::vector<double>& line, const double* kernel,
                                             std::vector<double>& sum) {
        double most = sum[0] = line[0] + kernel[0];
        for (std::size_t j = 1; j < line.size(); ++j) {
            sum[j] = line[j] + kernel[j];
            most = sum[j] > most ? sum[j] : most;
        }
        double total = 0;
        for (const double x : sum)
            if (x > most - negligible) total += std::exp(x - most);
        return most + std::log(total);
    }

    // Returns the values at the seeds, by B-splines, which keep a field convex.
    [[nodiscard]] Vector at_places(const Field& field, const Nodes& nodes) const {
        Vector weights(targets_.size());
        in_pieces(static_cast<std::size_t>(targets_.size()), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                std::array<std::size_t, 3> first{};
                std::array<std::array<double, 4>, 3> share{};
                for (std::size_t k = 0; k < 3; ++k) {
                    share[k] = {1, 0, 0, 0};
                    if (k >= dimensions_) continue;
                    const double x =
                        (places_[3 * i + k] - nodes.lower[k]) / nodes.step[k] - 0.5 - static_cast<double>(nodes.first);
                    const double low = std::clamp(std::floor(x), 1.0, static_cast<double>(nodes.shape[k]) - 3),
                                 t = x - low;
                    first[k] = static_cast<std::size_t>(low) - 1;
                    share[k] = {(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                                (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
                }
                double sum = 0;
                for (std::size_t a = 0; a < 4; ++a)
                    for (std::size_t b = 0; b < 4; ++b)
                        for (std::size_t c = 0; c < (dimensions_ == 3 ? 4U : 1U); ++c)
                            sum += share[0][a] * share[1][b] * share[2][c] *
                                   field.values[((first[0] + a) * nodes.shape[1] + first[1] + b) * nodes.shape[2] +
                                                first[2] + c];
                weights[static_cast<Eigen::Index>(i)] = sum;
            }
        });
        weights.array() -= weights.mean();
        return weights;
    }

    const Job& job_;
    const Under& density_;
    std::span<const double> places_;
    const Vector& targets_;
    std::size_t dimensions_;
    ThreadPool& pool_;
    Bounds domain_{}, seeds_{};
    std::array<bool, 3> mirrored_{};
    std::array<double, 3> period_{};  // 0 for none
};

}  // namespace

std::optional<Vector> smooth_start(const Job& job, const Under& density, std::span<const double> places,
                                   const Vector& targets, const Edges& edges, int dimensions, ThreadPool& pool) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            if (i != k && edges[i][k] != 0) return {};
    return Transport(job, density, places, targets, edges, dimensions, pool).weights();
}

}  // namespace votess::fit

#include "moving.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iterator>
#include <random>
#include <span>

namespace bench {
namespace {

constexpr double moves[] = {0, 1e-4, 1e-3, 1e-2, 1e-1};  // up to so many mean spacings along each axis

struct Outcome {
    std::vector<double> ratios;
    double fresh = 0;  // seconds of CPU, median
    double kept = 0;   // share of cells, of the last step
    bool good = true;
};

bool is_inside(const Input& input, const double* x) {
    return std::ranges::all_of(input.walls, [&](const votess::Wall& wall) {
        return wall.normal[0] * x[0] + wall.normal[1] * x[1] + wall.normal[2] * x[2] < wall.offset;
    });
}

// Moves the seeds. Along axes without a period they turn back at the faces of the box. Those that would cross further
// walls stay.
void move(Input& input, double by, std::mt19937_64& random) {
    const std::vector<double> before = input.points;
    for (std::size_t c = 0; c < input.points.size(); ++c) {
        const double share = 2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1;
        double& x = input.points[c];
        x += by * share;
        if (input.cell || input.periodic[c % 3]) continue;
        const double lower = input.box.lower[c % 3], upper = input.box.upper[c % 3];
        if (x < lower) x = 2 * lower - x;
        if (x > upper) x = 2 * upper - x;
    }
    for (std::size_t i = 0; i < input.points.size(); i += 3)
        if (!is_inside(input, &input.points[i])) std::copy_n(&before[i], 3, &input.points[i]);
}

// To the last digit. Centroids of seeds without a cell are NaN.
bool equal(const votess::Tessellation& a, const votess::Tessellation& b) {
    const auto same = [](auto x, auto y) { return std::ranges::equal(std::as_bytes(x), std::as_bytes(y)); };
    return same(a.indptr(), b.indptr()) && same(a.indices(), b.indices()) && same(a.shifts(), b.shifts()) &&
           same(a.volumes(), b.volumes()) && same(a.centroids(), b.centroids()) && same(a.face_areas(), b.face_areas());
}

Outcome measure(Input input, Want want, double by, int steps, std::uint64_t rng_seed) {
    votess::Tessellator follower, other;
    std::mt19937_64 random(rng_seed);
    const double volume = votess::tessellate(input.points, input.options()).stats().box_volume;
    const double spacing = std::cbrt(volume / static_cast<double>(input.size()));
    const auto seconds = [&](votess::Tessellator& tessellator, bool follow, votess::Tessellation& result) {
        votess::Options options = input.options();
        options.device = "cpu";
        options.threads = 1;
        options.follow = follow;
        options.want.volumes = options.want.centroids = options.want.areas = want == Want::full;
        const std::clock_t begin = std::clock();
        result = tessellator.tessellate(input.points, options);
        return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    };
    Outcome outcome;
    std::vector<double> fresh;
    constexpr int warm = 2;  // the first records, or finds that it does not pay
    votess::Tessellation a, b;
    for (int step = -warm; step < steps; ++step) {
        // They take turns in being first.
        const bool follows_first = step % 2 == 0;
        double with = follows_first ? seconds(follower, true, a) : 0;
        const double without = seconds(other, false, b);
        if (!follows_first) with = seconds(follower, true, a);
        outcome.good = outcome.good && equal(a, b);
        outcome.kept = static_cast<double>(a.stats().kept_cells) / static_cast<double>(input.size());
        if (step >= 0) {
            outcome.ratios.push_back(with / without);
            fresh.push_back(without);
        }
        move(input, by * spacing, random);
    }
    outcome.fresh = median(fresh);
    return outcome;
}

}  // namespace

int run_moving_table(const MovingTable& table, const std::vector<PeerVersion>& versions) {
    std::printf(
        "\nCPU time with `follow` over that of a fresh call, one thread, and the share of kept cells,\n"
        "where seeds move by up to so many mean spacings before each call\n%-16s %9s %-9s %9s",
        "input", "n", "want", "ns fresh");
    for (const double by : moves) std::printf("  %-12g", by);
    std::printf("\n");
    Section section{"moving", {}};
    bool good = true;
    for (const std::string& name : table.inputs) {
        for (const std::size_t n : is_file(name) ? std::vector<std::size_t>{0} : table.sizes) {
            const Input input = make_input(name, n, table.rng_seed);
            for (const std::string& want : table.wants) {
                std::vector<Outcome> all;
                for (const double by : moves) {
                    all.push_back(
                        measure(input, want == "full" ? Want::full : Want::neighbors, by, table.steps, table.rng_seed));
                    good = good && all.back().good;
                }
                std::printf("%-16s %9zu %-9s %9.0f", label_of(name).c_str(), input.size(), want.c_str(),
                            1e9 * all.front().fresh / static_cast<double>(input.size()));
                for (std::size_t i = 0; i < all.size(); ++i) {
                    std::printf("  %.3f (%.2f)%s", median(all[i].ratios), all[i].kept, all[i].good ? "" : " WRONG");
                    std::string item = "{\"input\": \"" + label_of(name) +
                                       "\", \"n\": " + std::to_string(input.size()) + ", \"want\": \"" + want +
                                       "\", \"moved\": " + std::to_string(moves[i]) +
                                       ", \"kept\": " + std::to_string(all[i].kept) + ", \"ratios\": [";
                    for (std::size_t k = 0; k < all[i].ratios.size(); ++k)
                        item += (k > 0 ? ", " : "") + std::to_string(all[i].ratios[k]);
                    section.items.push_back(item + "]}");
                }
                std::printf("\n");
                std::fflush(stdout);
            }
        }
    }
    if (!table.json.empty()) write_json(table.json, versions, {section});
    return good ? 0 : 1;
}

}  // namespace bench

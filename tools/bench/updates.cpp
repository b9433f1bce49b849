#include "updates.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <utility>

#include "bench.hpp"
#include "measure.hpp"

namespace bench {
namespace {

// User time of this process: other programs on the machine disturb it less than the clock.
double processor_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

// By `distance` in a random direction; a seed that would leave the box is mirrored by its wall.
void move(Input& input, double distance, std::mt19937_64& random) {
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    for (std::size_t i = 0; i < input.points.size(); i += 3) {
        double direction[3], square;
        do {
            square = 0;
            for (double& x : direction) {
                x = 2 * uniform() - 1;
                square += x * x;
            }
        } while (square > 1 || square < 1e-4);
        for (std::size_t k = 0; k < 3; ++k) {
            const double lower = input.box.lower[k], upper = input.box.upper[k];
            double x = input.points[i + k] + direction[k] * distance / std::sqrt(square);
            x = x < lower ? 2 * lower - x : x;
            x = x > upper ? 2 * upper - x : x;
            input.points[i + k] = std::clamp(x, lower, upper);
        }
    }
}

bool same_lists(const votess::Tessellation& a, const votess::Tessellation& b) {
    return std::equal(a.indptr().begin(), a.indptr().end(), b.indptr().begin(), b.indptr().end()) &&
           std::equal(a.indices().begin(), a.indices().end(), b.indices().begin(), b.indices().end());
}

}  // namespace

int run_update_table(const UpdateTable& table) {
    std::printf("\nUser seconds on the CPU, least of %d; the seeds move by so many mean spacings before each call.\n",
                table.repeats);
    std::printf("%10s %10s %12s %12s %8s %8s\n", "seeds", "moved by", "tessellate", "update", "ratio", "of sums");
    bool all_same = true;
    for (const std::size_t n : table.sizes) {
        for (const double distance : table.distances) {
            Input input = make_input("uniform", n, table.rng_seed);
            std::mt19937_64 random(table.rng_seed + 1);
            votess::Options options;
            options.device = "cpu";
            options.threads = table.threads;
            options.box = input.box;
            options.want.volumes = false;
            double volume = 1;
            for (std::size_t k = 0; k < 3; ++k) {
                volume *= input.box.upper[k] - input.box.lower[k];
            }
            const double step = distance * std::cbrt(volume / static_cast<double>(n));
            votess::Tessellator plain, updated;
            double least[2]{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}, sum[2]{};
            // The first rounds fill the memory that later ones use again, and what update() keeps.
            constexpr int warm_up = 2;
            for (int round = 0; round < warm_up + table.repeats; ++round) {
                votess::Tessellation results[2];
                // Who comes first changes, for the second finds the points in the caches.
                for (const int which : {round % 2, 1 - round % 2}) {
                    const double begin = processor_seconds();
                    results[which] =
                        which == 0 ? plain.tessellate(input.points, options) : updated.update(input.points, options);
                    const double seconds = processor_seconds() - begin;
                    if (round >= warm_up) {
                        least[which] = std::min(least[which], seconds);
                        sum[which] += seconds;
                    }
                }
                all_same = all_same && same_lists(results[0], results[1]);
                move(input, step, random);
            }
            std::printf("%10s %10g %12.4f %12.4f %8.3f %8.3f%s\n", short_number(n).c_str(), distance, least[0],
                        least[1], least[1] / least[0], sum[1] / sum[0], all_same ? "" : "  the lists DIFFER");
            std::fflush(stdout);
        }
    }
    return all_same ? 0 : 1;
}

}  // namespace bench

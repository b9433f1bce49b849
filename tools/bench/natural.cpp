// Natural-neighbor coordinates of votess and CGAL: the same uniform seeds and queries, one thread, in one run.
//   votess_bench_natural [SEEDS] [QUERIES]
// Prints the time for a query, the median of three runs in turns, and the largest difference of a weight. Exits with 1
// when that is above 1e-9 or the neighbors differ. Queries are away from the hull, where only CGAL's coordinates end.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/natural_neighbor_coordinates_3.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>
#include <votess/diagram.hpp>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::int32_t, Kernel>;
using Structure = CGAL::Triangulation_data_structure_3<VertexBase, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, Structure>;
using Row = std::vector<std::pair<std::int32_t, double>>;  // seeds, ascending, and their weights

constexpr int repeats = 3;
constexpr double margin = 0.15, max_different = 1e-9;

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<Row> by_cgal(const Triangulation& triangulation, const std::vector<double>& queries, bool sibson) {
    std::vector<Row> rows;
    for (std::size_t q = 0; q < queries.size(); q += 3) {
        const Kernel::Point_3 x(queries[q], queries[q + 1], queries[q + 2]);
        std::vector<std::pair<Triangulation::Vertex_handle, double>> found;
        double sum = 0;
        if (sibson)
            CGAL::sibson_natural_neighbor_coordinates_3(triangulation, x, std::back_inserter(found), sum);
        else
            CGAL::laplace_natural_neighbor_coordinates_3(triangulation, x, std::back_inserter(found), sum);
        Row& row = rows.emplace_back();
        for (const auto& [vertex, weight] : found) row.emplace_back(vertex->info(), weight / sum);
        std::ranges::sort(row);
    }
    return rows;
}

// The largest difference; infinite when the neighbors are others.
double difference(const std::vector<Row>& theirs, const votess::NaturalCoordinates& ours) {
    double largest = 0;
    for (std::size_t q = 0; q < theirs.size(); ++q) {
        const auto begin = static_cast<std::size_t>(ours.indptr[q]), end = static_cast<std::size_t>(ours.indptr[q + 1]);
        if (theirs[q].size() != end - begin) return HUGE_VAL;
        for (std::size_t e = begin; e < end; ++e) {
            const auto& [seed, weight] = theirs[q][e - begin];
            if (seed != ours.indices[e]) return HUGE_VAL;
            largest = std::max(largest, std::abs(weight - ours.weights[e]));
        }
    }
    return largest;
}

double median(std::array<double, repeats> seconds) {
    std::ranges::sort(seconds);
    return seconds[repeats / 2];
}

}  // namespace

int main(int count, char** arguments) {
    const auto number = [&](int k) { return count > k ? std::stoul(arguments[k]) : 10000ul; };
    const std::size_t seeds = number(1), asked = number(2);
    std::mt19937_64 generator(1);
    std::uniform_real_distribution<double> uniform(0, 1), inner(margin, 1 - margin);
    std::vector<double> points(3 * seeds), queries(3 * asked);
    for (double& x : points) x = uniform(generator);
    for (double& x : queries) x = inner(generator);

    votess::Options options;
    options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
    options.threads = 1;
    double began = now();
    const votess::Diagram diagram(points, options);
    const double sorting = now() - began;
    began = now();
    std::vector<std::pair<Kernel::Point_3, std::int32_t>> sites;
    for (std::size_t i = 0; i < seeds; ++i)
        sites.emplace_back(Kernel::Point_3(points[3 * i], points[3 * i + 1], points[3 * i + 2]), i);
    const Triangulation triangulation(sites.begin(), sites.end());
    std::printf("%zu seeds, %zu queries; Diagram %.4f s, CGAL's triangulation %.4f s\n", seeds, asked, sorting,
                now() - began);
    bool equal = true;
    for (const bool sibson : {true, false}) {
        votess::NaturalOptions of_queries;
        of_queries.method = sibson ? votess::NaturalMethod::sibson : votess::NaturalMethod::laplace;
        std::array<double, repeats> ours{}, theirs{};
        votess::NaturalCoordinates found;
        std::vector<Row> rows;
        for (int k = 0; k < repeats; ++k) {
            began = now();
            found = diagram.natural_neighbors(queries, of_queries);
            ours[static_cast<std::size_t>(k)] = now() - began;
            began = now();
            rows = by_cgal(triangulation, queries, sibson);
            theirs[static_cast<std::size_t>(k)] = now() - began;
        }
        const double each = 1e6 / static_cast<double>(asked), apart = difference(rows, found);
        std::printf("%-8s votess %6.2f us (the first time %.2f), CGAL %6.2f us: %.1f times; weights differ by %.1e\n",
                    sibson ? "Sibson" : "Laplace", median(ours) * each, ours[0] * each, median(theirs) * each,
                    median(theirs) / median(ours), apart);
        equal = equal && apart <= max_different;
    }
    return equal ? 0 : 1;
}

// Cells of ranks against those of one tessellate(), which each rank calls for itself.
//
//   mpirun -np P votess_mpi_tests [POINTS.xyz]
//
// Any number of ranks. Prints failures and exits 1; else rank 0 prints how many runs were compared.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <vector>
#include <votess/mpi.hpp>

#include "mpi/inputs.hpp"
#include "mpi/verify.hpp"
#include "support/arrays.hpp"

namespace {

using test::Input;
using votess::mpi::Cells;

enum class Share { spread, slices, last_has_all, random };

int rank_in(MPI_Comm comm) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    return rank;
}
int size_of(MPI_Comm comm) {
    int size = 0;
    MPI_Comm_size(comm, &size);
    return size;
}

int failures = 0, runs = 0;

void wrong(MPI_Comm comm, const std::string& what) {
    ++failures;
    std::fprintf(stderr, "rank %d of %d: %s\n", rank_in(comm), size_of(comm), what.c_str());
}

std::vector<int> owners_of(const Input& input, Share share, int ranks) {
    std::vector<int> owners(input.size());
    test::Random random(11);
    for (std::size_t i = 0; i < owners.size(); ++i) {
        if (share == Share::spread) owners[i] = static_cast<int>(i) % ranks;
        if (share == Share::slices) owners[i] = static_cast<int>(i * static_cast<std::size_t>(ranks) / owners.size());
        if (share == Share::last_has_all) owners[i] = ranks - 1;
        if (share == Share::random) owners[i] = static_cast<int>(random.below(static_cast<std::uint64_t>(ranks)));
    }
    return owners;
}

// Returns "" when these are the cells of t, else the first difference. Tags are owners.
std::string difference(const votess::mpi::Result& result, const votess::Tessellation& t,
                       const std::vector<int>& owners) {
    const votess::BlockCells& cells = result.cells;
    if (cells.indptr.size() != result.ids.size() + 1) return "indptr has another length";
    std::string longer;
    test::for_common_arrays(cells, t, [&](const auto& array) {
        if (array.per == votess::Per::cell && array.name != "duplicate_of" && !array.of(cells).empty() &&
            array.of(cells).size() != components_of(array, t.planar()) * result.ids.size())
            longer = array.name;
    });
    if (!longer.empty()) return "the array " + longer + " has another length";
    for (std::size_t k = 0; k < result.ids.size(); ++k) {
        const auto i = static_cast<std::size_t>(result.ids[k]);
        const std::string cell = "cell " + std::to_string(i) + ": ";
        for (auto e = static_cast<std::size_t>(cells.indptr[k]); e < static_cast<std::size_t>(cells.indptr[k + 1]); ++e)
            if (const std::int64_t id = cells.indices[e];
                cells.owners[e] != (id < 0 ? -1 : owners[static_cast<std::size_t>(id)]))
                return cell + "a wrong owner";
        if (const std::string array = test::different_cell(cells, k, t, i); !array.empty())
            return cell + array + " differs";
    }
    return "";
}

// Compares the lists of the exchange with those that follow from all rows.
std::string wrong_exchange(const votess::mpi::Result& result, const votess::Tessellation& t,
                           const std::vector<int>& owners, int rank, int ranks) {
    std::vector<std::set<std::int64_t>> send(static_cast<std::size_t>(ranks)), receive(send);
    for (std::size_t i = 0; i < owners.size(); ++i)
        for (const std::int64_t j : t.neighbors(i)) {
            if (j < 0 || owners[i] != rank || owners[static_cast<std::size_t>(j)] == rank) continue;
            const auto other = static_cast<std::size_t>(owners[static_cast<std::size_t>(j)]);
            send[other].insert(static_cast<std::int64_t>(i));
            receive[other].insert(j);
        }
    const auto same = [](const auto& sets, const auto& indptr, const auto& all) {
        if (indptr.size() != sets.size() + 1) return false;
        for (std::size_t r = 0; r < sets.size(); ++r) {
            const auto begin = static_cast<std::size_t>(indptr[r]), end = static_cast<std::size_t>(indptr[r + 1]);
            if (!std::ranges::equal(sets[r], std::span(all).subspan(begin, end - begin))) return false;
        }
        return true;
    };
    if (!same(send, result.send_indptr, result.send)) return "what is to be sent differs";
    if (!same(receive, result.receive_indptr, result.receive)) return "what comes differs";
    return "";
}

void compare(MPI_Comm comm, const Input& input, Share share) {
    const int rank = rank_in(comm), ranks = size_of(comm);
    const std::vector<int> owners = owners_of(input, share, ranks);
    const std::size_t each = input.dimensions();
    std::vector<double> points, radii;
    std::vector<std::int64_t> ids;
    for (std::size_t i = 0; i < input.size(); ++i) {
        if (owners[i] != rank) continue;
        ids.push_back(static_cast<std::int64_t>(i));
        points.insert(points.end(), input.points.begin() + static_cast<std::ptrdiff_t>(each * i),
                      input.points.begin() + static_cast<std::ptrdiff_t>(each * (i + 1)));
        if (!input.radii.empty()) radii.push_back(input.radii[i]);
    }
    votess::Options options = input.options;
    if (input.hull) {
        const auto walls = votess::mpi::hull_walls(comm, points, options);
        options.walls = votess::hull_walls(input.points, options);
        const auto numbers = [](const votess::Wall& wall) { return std::pair(wall.normal, wall.offset); };
        if (!std::ranges::equal(walls, options.walls, {}, numbers, numbers))
            wrong(comm, input.name + ": the hulls differ");
    }
    options.radii = input.radii;
    const votess::Tessellation whole = votess::tessellate(input.points, options);
    options.radii = radii;
    const std::string name = input.name + ", share " + std::to_string(static_cast<int>(share)) + ": ";
    // Slices in the order of ranks have the ids that seeds get by default.
    const auto given = share == Share::slices ? std::span<const std::int64_t>() : std::span<const std::int64_t>(ids);
    ++runs;
    try {
        const auto back = votess::mpi::tessellate(comm, points, given, options);
        if (back.ids != ids) wrong(comm, name + "the ids are others");
        std::string what = difference(back, whole, owners);
        if (what.empty()) what = wrong_exchange(back, whole, owners, rank, ranks);
        if (!what.empty()) wrong(comm, name + what);
        if (back.counts.seeds != input.size()) wrong(comm, name + "another number of seeds");
        const auto differ = [](double a, double b, double tolerance) {
            return a != b && !(std::abs(a - b) <= tolerance * b);
        };
        if (differ(back.counts.volume_sum, whole.stats().volume_sum, 1e-10))
            wrong(comm, name + "another sum of volumes");
        if (input.size() > 0 && differ(back.counts.box_volume, whole.stats().box_volume, 1e-12))
            wrong(comm, name + "another volume of the domain");

        const auto made = votess::mpi::tessellate(comm, points, given, options, Cells::made);
        what = difference(made, whole, owners);
        if (!what.empty()) wrong(comm, name + "made: " + what);
        for (std::size_t k = 0; k < made.points.size(); ++k)
            if (made.points[k] != input.points[each * static_cast<std::size_t>(made.ids[k / each]) + k % each])
                wrong(comm, name + "made: a point is another");
        const std::uint64_t own = made.ids.size();
        std::uint64_t all = 0;
        MPI_Allreduce(&own, &all, 1, MPI_UINT64_T, MPI_SUM, comm);
        const auto dropped = std::ranges::count(whole.status(), votess::CellStatus::outside);
        if (all + static_cast<std::uint64_t>(dropped) != input.size()) wrong(comm, name + "made: not each cell once");
    } catch (const votess::Error& error) {
        wrong(comm, name + error.what());
    }
}

// All ranks must throw the same message, which ends with these words.
void refuses(MPI_Comm comm, const std::string& words, const std::function<void()>& call) {
    ++runs;
    std::string what;
    try {
        call();
    } catch (const votess::Error& error) {
        what = error.what();
    }
    if (!what.ends_with(words)) wrong(comm, "'" + what + "' instead of '" + words + "'");
    const std::uint64_t own = std::hash<std::string>{}(what);
    std::uint64_t least = 0, most = 0;
    MPI_Allreduce(&own, &least, 1, MPI_UINT64_T, MPI_MIN, comm);
    MPI_Allreduce(&own, &most, 1, MPI_UINT64_T, MPI_MAX, comm);
    if (least != most) wrong(comm, "not all ranks throw '" + what + "'");
}
void refuses(MPI_Comm comm, const std::string& words, const std::vector<double>& points,
             const std::vector<std::int64_t>& ids, const votess::Options& options, Cells cells = Cells::handed_in) {
    refuses(comm, words, [&] { (void)votess::mpi::tessellate(comm, points, ids, options, cells); });
}

// Each argument that must be the same on all ranks, with another value on the last one.
void check_agreement(MPI_Comm comm, const std::vector<double>& points, const votess::Options& options) {
    const int last = size_of(comm) - 1;
    const bool is_last = rank_in(comm) == last;
    const auto differs = [&](const std::string& what) {
        return "rank " + std::to_string(last) + ": " + what + " differs from that of rank 0: give all ranks the same";
    };
    const std::vector<std::pair<std::string, std::function<void(votess::Options&)>>> changes{
        {"box", [](votess::Options& o) { o.box->upper[2] = 2; }},
        {"box", [](votess::Options& o) { o.box.reset(); }},
        {"cell", [](votess::Options& o) { o.cell.emplace(); }},
        {"periodic", [](votess::Options& o) { o.periodic[1] = true; }},
        {"walls",
         [](votess::Options& o) {
             o.walls.push_back({{1, 0, 0}, 3});
         }},
        {"outside", [](votess::Options& o) { o.outside = votess::Outside::keep; }},
        {"duplicates", [](votess::Options& o) { o.duplicates = votess::Duplicates::error; }},
        {"want", [](votess::Options& o) { o.want.volumes = false; }},
        {"list_walls", [](votess::Options& o) { o.list_walls = true; }},
        {"min_face", [](votess::Options& o) { o.min_face = 0.1; }},
        {"min_area", [](votess::Options& o) { o.min_area = 0.1; }},
        {"the number of dimensions", [](votess::Options& o) { o.planar = true; }}};
    for (const auto& [name, change] : changes) {
        votess::Options other = options;
        if (is_last) change(other);
        refuses(comm, differs(name), points, {}, other);
    }
    refuses(comm, differs("cells"), points, {}, options, is_last ? Cells::made : Cells::handed_in);

    const auto result = votess::mpi::tessellate(comm, points, {}, options);
    const auto made = votess::mpi::tessellate(comm, points, {}, options, Cells::made);
    votess::VerifyOptions verify;
    if (is_last) verify.sample = 3;
    refuses(comm, differs("sample"), [&] { (void)votess::mpi::verify(comm, result, points, verify); });
    verify.sample.reset();
    verify.rng_seed = is_last ? 2 : 1;
    refuses(comm, differs("rng_seed"), [&] { (void)votess::mpi::verify(comm, result, points, verify); });
    refuses(comm, differs("the result"), [&] {
        (void)votess::mpi::verify(comm, is_last ? made : result, is_last ? std::vector<double>() : points);
    });
    refuses(comm, "() differs from that of rank 0: give all ranks the same", [&] {
        if (is_last)
            (void)votess::mpi::verify(comm, result, points);
        else
            (void)votess::mpi::tessellate(comm, points, {}, options);
    });
}

void check_errors(MPI_Comm comm) {
    const int rank = rank_in(comm), last = size_of(comm) - 1;
    const std::string at_last = "rank " + std::to_string(last) + ": ";
    const bool is_last = rank == last;
    votess::Options options;
    options.box = test::unit_box();
    const double x = (rank + 0.5) / (last + 1);
    const std::vector<double> points{x, 0.1, 0.2, x, 0.7, 0.8};
    const std::vector<std::int64_t> ids{2 * rank, 2 * rank + 1};

    std::vector<double> bad = points;
    if (is_last) bad[4] = std::numeric_limits<double>::quiet_NaN();
    refuses(comm, at_last + "point 1: y = nan is not finite", bad, ids, options);
    bad = points;
    if (is_last) bad.pop_back();
    refuses(comm, at_last + "points hold 5 coordinates, which is not a multiple of 3: the shape must be (N,3)", bad, {},
            options);
    bad = points;
    if (is_last) bad[0] = 1.5;
    refuses(comm,
            at_last +
                "point 0: x = 1.5 is outside the box, which spans 0 to 1, by 0.5: move it, or drop points "
                "outside (Options::outside = drop) or keep them (Options::outside = keep)",
            bad, ids, options);
    std::vector<std::int64_t> twice = ids;
    if (is_last) twice[1] = 0;
    refuses(comm, "id 0 is given twice", points, twice, options);
    if (is_last) twice[1] = -3;
    refuses(comm, at_last + "id 1 = -3 is negative", points, is_last ? twice : ids, options);
    if (last == 0) return;
    refuses(comm, at_last + "it has 0 ids for 2 points, but another rank has ids: give them on all ranks or on none",
            points, is_last ? std::vector<std::int64_t>{} : ids, options);
    const std::vector<double> weights(2);
    votess::Options other = options;
    if (!is_last) other.weights = weights;
    refuses(comm,
            at_last + "it has 0 weights for 2 points, but another rank has weights: give them on all ranks or on none",
            points, ids, other);
    if (is_last) other.radii = weights;
    refuses(comm,
            at_last + "it has 0 weights for 2 points, but another rank has weights: give them on all ranks or on none",
            points, ids, other);
    check_agreement(comm, points, options);
}

// Two communicators at once.
void check_parts() {
    MPI_Comm part = MPI_COMM_NULL;
    const int rank = rank_in(MPI_COMM_WORLD);
    const bool first = rank % 5 < 3;
    MPI_Comm_split(MPI_COMM_WORLD, first ? 0 : 1, -rank, &part);
    for (const Input& input : test::some_inputs(first ? 21 : 22)) compare(part, input, Share::spread);
    MPI_Comm_free(&part);
}

Input from_file(const char* path) {
    Input input;
    input.name = path;
    std::ifstream file(path);
    for (double x = 0; file >> x;) input.points.push_back(x);
    input.options = test::usual_options();
    return input;
}

}  // namespace

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    if (argc > 1) {
        compare(MPI_COMM_WORLD, from_file(argv[1]), Share::spread);
    } else {
        // The ways of distribution take turns: five and four have no common divisor.
        constexpr int every = 5;
        int next = size_of(MPI_COMM_WORLD);
        for (const Input& input : test::all_inputs())
            for (const Share share : {Share::spread, Share::slices, Share::last_has_all, Share::random})
                if (next++ % every == 0) compare(MPI_COMM_WORLD, input, share);
        check_errors(MPI_COMM_WORLD);
        check_parts();
        for (const std::string& what : test::check_verify(MPI_COMM_WORLD)) wrong(MPI_COMM_WORLD, what);
    }
    int all = 0;
    MPI_Allreduce(&failures, &all, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    if (rank_in(MPI_COMM_WORLD) == 0)
        std::printf("%d runs on %d ranks, %d failures\n", runs, size_of(MPI_COMM_WORLD), all);
    MPI_Finalize();
    return all == 0 ? 0 : 1;
}

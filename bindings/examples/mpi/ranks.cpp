// Tessellates over the ranks of MPI and exchanges a field between neighbors. ../cmake builds it if it finds MPI.
//
//     mpirun -np 4 build/ranks
#include <algorithm>
#include <cstdio>
#include <random>
#include <vector>
#include <votess/mpi.hpp>

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    int rank = 0, ranks = 1;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);

    // Each rank may pass any seeds. Here they lie all over the box.
    std::mt19937_64 random(static_cast<unsigned>(rank));
    std::uniform_real_distribution<double> uniform;
    std::vector<double> points(3 * 2000);
    for (double& x : points) x = uniform(random);

    try {
        votess::Options options;
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        options.periodic = {true, true, true};
        const votess::mpi::Result result = votess::mpi::tessellate(MPI_COMM_WORLD, points, {}, options);

        // Sends the volumes that other ranks need and receives those of neighbors on other ranks.
        const auto place = [&](std::int64_t id) {
            return std::lower_bound(result.ids.begin(), result.ids.end(), id) - result.ids.begin();
        };
        std::vector<double> sent, received(result.receive.size());
        for (const std::int64_t id : result.send) sent.push_back(result.cells.volumes[place(id)]);
        std::vector<int> send_counts, send_begins, receive_counts, receive_begins;
        for (int r = 0; r < ranks; ++r) {
            send_begins.push_back(static_cast<int>(result.send_indptr[r]));
            send_counts.push_back(static_cast<int>(result.send_indptr[r + 1] - result.send_indptr[r]));
            receive_begins.push_back(static_cast<int>(result.receive_indptr[r]));
            receive_counts.push_back(static_cast<int>(result.receive_indptr[r + 1] - result.receive_indptr[r]));
        }
        MPI_Alltoallv(sent.data(), send_counts.data(), send_begins.data(), MPI_DOUBLE, received.data(),
                      receive_counts.data(), receive_begins.data(), MPI_DOUBLE, MPI_COMM_WORLD);
        const double smallest = received.empty() ? 1 : *std::min_element(received.begin(), received.end());
        if (rank == 0)
            std::printf("%llu cells, their volumes sum to %.10f; volumes of remote neighbors received: %s\n",
                        static_cast<unsigned long long>(result.counts.seeds), result.counts.volume_sum,
                        smallest > 0 ? "yes" : "no");
    } catch (const votess::Error& error) {
        if (rank == 0) std::fprintf(stderr, "%s\n", error.what());  // the same on all ranks
        MPI_Finalize();
        return 1;
    }
    MPI_Finalize();
    return 0;
}

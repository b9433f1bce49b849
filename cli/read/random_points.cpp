#include <algorithm>
#include <array>
#include <limits>
#include <votess/diagram.hpp>

#include "failure.hpp"
#include "read/input.hpp"

namespace clvotess {
namespace {

// SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014). It uses whole numbers
// only, so seeds are equal on all machines; std::uniform_real_distribution does not promise that.
class SplitMix64 {
public:
    // Skips the first numbers.
    explicit SplitMix64(std::uint64_t state, std::uint64_t skipped = 0) : state_(state + skipped * step) {}

    double uniform() {  // in [0, 1), a multiple of 2^-53
        state_ += step;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        z ^= z >> 31;
        return static_cast<double>(z >> 11) * 0x1p-53;
    }

private:
    static constexpr std::uint64_t step = 0x9e3779b97f4a7c15u;
    std::uint64_t state_;
};

std::size_t dimensions_of(const ReadRequest& request) {
    return request.dimensions == Dimensions::two ? 2 : 3;
}

class RandomPieces : public InputPieces {
public:
    RandomPieces(std::uint64_t count, std::uint64_t rng_seed, const ReadRequest& request, std::size_t rows)
        : count_(count), rng_seed_(rng_seed), rows_(rows), generator_(rng_seed) {
        dimensions = dimensions_of(request);
    }

    bool restart() override {
        generator_ = SplitMix64(rng_seed_);
        left_ = count_;
        return true;
    }
    bool next(Input& piece) override {
        piece.dimensions = dimensions;
        piece.points.resize(dimensions * std::min<std::uint64_t>(left_, rows_));
        for (double& coordinate : piece.points) coordinate = generator_.uniform();
        left_ -= piece.size();
        return piece.size() > 0;
    }

private:
    std::uint64_t count_, rng_seed_, left_ = 0;
    std::size_t rows_;
    SplitMix64 generator_;
};

}  // namespace

Input random_points(std::uint64_t count, std::uint64_t rng_seed, const ReadRequest& request) {
    Input input;
    input.dimensions = dimensions_of(request);
    const std::uint64_t begin = request.share.begin(count);
    input.points.resize(input.dimensions * (request.share.end(count) - begin));
    SplitMix64 generator(rng_seed, input.dimensions * begin);
    for (double& coordinate : input.points) coordinate = generator.uniform();
    return input;
}

Input random_points_in(const votess::TriangleMesh& mesh, std::size_t dimensions, std::uint64_t count,
                       std::uint64_t rng_seed, unsigned threads) {
    Input input;
    input.dimensions = dimensions;
    if (count == 0) return input;
    std::vector<double> lower(dimensions), upper(dimensions);
    for (std::size_t k = 0; k < dimensions; ++k) {
        lower[k] = std::numeric_limits<double>::infinity();
        upper[k] = -lower[k];
        for (std::size_t v = k; v < mesh.vertices.size(); v += dimensions) {
            lower[k] = std::min(lower[k], mesh.vertices[v]);
            upper[k] = std::max(upper[k], mesh.vertices[v]);
        }
    }
    // Its only cell is the inside of the mesh.
    votess::Options options;
    options.mesh = mesh;
    options.planar = dimensions == 2;
    options.threads = threads;
    const votess::Diagram inside(std::span<const double>(lower), options);
    SplitMix64 generator(rng_seed);
    constexpr std::size_t tries = 4096, most_misses = 10'000'000;
    std::vector<double> places(dimensions * tries);
    for (std::size_t misses = 0; input.size() < count;) {
        for (std::size_t i = 0; i < places.size(); ++i)
            places[i] = lower[i % dimensions] + (upper[i % dimensions] - lower[i % dimensions]) * generator.uniform();
        const std::vector<std::int32_t> seeds = inside.locate(places);
        for (std::size_t q = 0; q < tries && input.size() < count; ++q) {
            if (seeds[q] < 0) continue;
            const auto place = places.begin() + static_cast<std::ptrdiff_t>(dimensions * q);
            input.points.insert(input.points.end(), place, place + static_cast<std::ptrdiff_t>(dimensions));
        }
        misses = input.size() == 0 ? misses + tries : 0;
        if (misses > most_misses)
            throw bad_input(
                "no random point lies inside of the mesh, which fills too little of its bounds: give points");
    }
    return input;
}

std::unique_ptr<InputPieces> open_random(std::uint64_t count, std::uint64_t rng_seed, const ReadRequest& request,
                                         std::size_t rows) {
    return std::make_unique<RandomPieces>(count, rng_seed, request, rows);
}

}  // namespace clvotess

#include <algorithm>

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

std::unique_ptr<InputPieces> open_random(std::uint64_t count, std::uint64_t rng_seed, const ReadRequest& request,
                                         std::size_t rows) {
    return std::make_unique<RandomPieces>(count, rng_seed, request, rows);
}

}  // namespace clvotess

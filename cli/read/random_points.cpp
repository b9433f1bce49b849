#include "read/input.hpp"

namespace clvotess {
namespace {

// SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014). Whole-number
// arithmetic only, so the same seeds everywhere; std::uniform_real_distribution does not promise that.
class SplitMix64 {
public:
    // Behind the first `skipped` numbers.
    SplitMix64(std::uint64_t state, std::uint64_t skipped) : state_(state + skipped * step) {}

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

}  // namespace

Input random_points(std::uint64_t count, std::uint64_t rng_seed, const Share& share) {
    Input input;
    const std::uint64_t begin = share.begin(count);
    input.points.resize(3 * (share.end(count) - begin));
    SplitMix64 generator(rng_seed, 3 * begin);
    for (double& coordinate : input.points) coordinate = generator.uniform();
    return input;
}

}  // namespace clvotess

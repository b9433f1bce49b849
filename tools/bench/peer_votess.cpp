#include "bench.hpp"

namespace bench {
namespace {

class Votess final : public Peer {
public:
    [[nodiscard]] std::string name() const override { return "votess"; }
    [[nodiscard]] std::string version() const override { return VOTESS_VERSION_STRING; }
    [[nodiscard]] bool can(Want) const override { return true; }
    [[nodiscard]] bool threaded() const override { return true; }

    // A new Tessellator each time: the peers keep nothing between calls either.
    [[nodiscard]] Answer run(const Input& input, Want want, unsigned threads) const override {
        votess::Options options;
        options.box = input.box;
        options.device = "cpu";
        options.threads = threads;
        options.want.neighbors = true;
        options.want.volumes = options.want.centroids = want == Want::full;

        const Stopwatch stopwatch;
        const votess::Tessellation t = votess::tessellate(input.points, options);
        return {stopwatch.seconds(), t.indices().size(), t.stats().volume_sum};
    }
};

}  // namespace

std::unique_ptr<Peer> make_votess() {
    return std::make_unique<Votess>();
}

}  // namespace bench

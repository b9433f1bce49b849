#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "bench.hpp"

namespace bench {
namespace {

votess::Options options_for(const Input& input, Want want, unsigned threads, const std::string& device) {
    votess::Options options = input.options();
    options.device = device;
    options.threads = threads;
    options.want.neighbors = true;
    options.want.volumes = options.want.centroids = options.want.areas = want == Want::full;
    return options;
}

Answer answer_of(const votess::Tessellation& t, double seconds) {
    const auto areas = t.face_areas();
    return {.seconds = seconds,
            .links = t.indices().size(),
            .volume = t.stats().volume_sum,
            .area = std::accumulate(areas.begin(), areas.end(), 0.0),
            .stats = t.stats()};
}

class Votess final : public Peer {
public:
    explicit Votess(std::string instructions) : instructions_(std::move(instructions)) {}
    [[nodiscard]] std::string name() const override {
        return instructions_.empty() ? "votess" : "votess/" + instructions_;
    }
    [[nodiscard]] std::string version() const override { return VOTESS_VERSION_STRING; }
    [[nodiscard]] bool can(const Input&, Want) const override { return true; }
    [[nodiscard]] std::vector<unsigned> threads(const std::vector<unsigned>& asked) const override { return asked; }

    // A new Tessellator each time: the peers keep nothing between calls either.
    [[nodiscard]] Answer run(const Input& input, Want want, unsigned threads) const override {
        votess::Options options = options_for(input, want, threads, "cpu");
        options.instructions = instructions_;
        const Stopwatch stopwatch;
        const votess::Tessellation t = votess::tessellate(input.points, options);
        if (want != Want::proof) return answer_of(t, stopwatch.seconds());
        const Stopwatch checking;
        const votess::VerifyReport report = votess::verify(t, input.points);
        if (!report.proven) throw std::runtime_error("not proven: " + report.failure + report.unproven);
        return answer_of(t, checking.seconds());
    }

private:
    std::string instructions_;
};

// One Tessellator for all runs: it holds the device, its pipelines and buffers.
class VotessOn final : public Peer {
public:
    explicit VotessOn(const std::string& device) : device_(device) {
        const Input one{"", {0.5, 0.5, 0.5}, {{0, 0, 0}, {1, 1, 1}}};
        const auto t = tessellator_.tessellate(one.points, options_for(one, Want::neighbors, 1, device));
        info_ = describe(device, t.stats().device);
    }
    [[nodiscard]] std::string name() const override { return "votess:" + device_; }
    [[nodiscard]] std::string version() const override {
        return std::string(VOTESS_VERSION_STRING) + " on " + info_.name +
               (info_.description.empty() ? "" : " (" + info_.description + ")");
    }
    [[nodiscard]] bool can(const Input&, Want want) const override { return want != Want::proof; }
    // The CPU's share, cells that the device leaves to it, is as quick as allowed.
    [[nodiscard]] std::vector<unsigned> threads(const std::vector<unsigned>& asked) const override {
        return {*std::max_element(asked.begin(), asked.end())};
    }
    [[nodiscard]] double volume_error() const override { return 1e-5; }
    void prepare(const Input& input, Want want, unsigned threads) const override {
        static_cast<void>(run(input, want, threads));
    }

    [[nodiscard]] Answer run(const Input& input, Want want, unsigned threads) const override {
        const votess::Options options = options_for(input, want, threads, device_);
        const Stopwatch stopwatch;
        const votess::Tessellation t = tessellator_.tessellate(input.points, options);
        return answer_of(t, stopwatch.seconds());
    }

private:
    std::string device_;
    votess::DeviceInfo info_;
    mutable votess::Tessellator tessellator_;
};

}  // namespace

votess::DeviceInfo describe(const std::string& device, const std::string& name) {
    const std::vector<votess::DeviceInfo> all = votess::devices();
    for (const votess::DeviceInfo& info : all) {
        if (info.id == device) {
            return info;
        }
    }
    for (const votess::DeviceInfo& info : all) {
        if (info.name == name) {
            return info;
        }
    }
    return {device, name, ""};
}

std::unique_ptr<Peer> make_votess(const std::string& instructions) {
    return std::make_unique<Votess>(instructions);
}

std::unique_ptr<Peer> make_votess_on(const std::string& device) {
    return std::make_unique<VotessOn>(device);
}

}  // namespace bench

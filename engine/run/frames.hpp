// Frames of points in the host's memory, on a Vulkan device. The form without Vulkan's types, for the C interface.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "result/frame_rows.hpp"
#include "votess/votess.hpp"

namespace votess {

namespace gpu {
class HostFrames;
}

// See votess/frames.h. 0: automatic.
struct FramesSettings {
    std::uint32_t max_points = 0;
    std::optional<std::pair<double, double>> weights;  // least and largest
    std::uint32_t max_entries = 0, max_images = 0;
    double margin = 0;
    bool gradients = false;
    // For memory that another API maps: the UUID of the device, and whether points and weights are float64.
    std::optional<std::array<std::uint8_t, 16>> uuid;
    bool wide = false;
};

// One call at a time: a second one throws invalid_use, and so does each in a child of fork().
class Frames {
public:
    // Opens the device, or takes that of other frames. Throws invalid_argument for options that frames do not have, and
    // as Plan() of votess/vulkan.hpp.
    Frames(const FramesSettings& settings, const Options& options, const Frames* share);
    ~Frames();
    Frames(const Frames&) = delete;
    Frames& operator=(const Frames&) = delete;

    // Returns one line: device, kernel, numbers.
    [[nodiscard]] std::string device() const;
    // weights: empty without Frames::weights.
    [[nodiscard]] detail::FrameRows run(std::span<const double> points, std::span<const double> weights);
    [[nodiscard]] detail::FrameRows run(std::span<const float> points, std::span<const double> weights);
    // Returns the cells of the last run, all of them: the CPU makes those that the device left.
    [[nodiscard]] detail::FrameRows resolve();

    // Sets the derivatives of a number by the points and weights of the last run, 3N and N. given: for arrays that its
    // cells have.
    void vjp(const detail::FrameVectors& given, double* by_points, double* by_weights);

    // For frames with a UUID, see votess/frames.h.
    [[nodiscard]] detail::ExportedArrays exported();
    void submit(std::uint32_t count, std::uint64_t after, std::uint64_t done);
    void submit_vjp(const Want& given, std::uint64_t after, std::uint64_t done);
    void signal(std::uint64_t value);
    void wait(std::uint64_t value);
    std::size_t resolve_exported();

private:
    struct State;
    template <class Real>
    detail::FrameRows run_any(std::span<const Real> points, std::span<const double> weights);
    std::unique_ptr<State> state_;
};

}  // namespace votess

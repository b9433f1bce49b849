// Frames of points in the host's memory: a plan with buffers and commands of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/thread_pool.hpp"
#include "gpu/frames/frame_buffers.hpp"
#include "gpu/frames/gradients.hpp"
#include "gpu/vulkan/commands.hpp"
#include "result/frame_rows.hpp"
#include "votess/vulkan.hpp"

namespace votess::gpu {

// One call at a time. The device leaves rows in the order in which it made them. The host puts them in the order of the
// points, with those of resolve().
class HostFrames {
public:
    // options: their format is float64, and points of float32 are widened. Throws as Plan().
    // gradients: whether there is vjp().
    HostFrames(std::shared_ptr<vulkan::Device> device, const votess::vulkan::PlanOptions& options, const Want& want,
               unsigned threads, bool gradients = false);

    [[nodiscard]] const std::shared_ptr<vulkan::Device>& device() const { return device_; }
    [[nodiscard]] const votess::vulkan::Plan& plan() const { return plan_; }

    // Returns the cells of at most max_seeds points. weights: one each in a plan with weights, else none. Throws
    // device_lost, out_of_memory, `cancelled`.
    template <class Real>
    [[nodiscard]] detail::FrameRows run(std::span<const Real> points, std::span<const double> weights) {
        begin(points.size() / 3, sizeof(Real) == sizeof(float));
        std::ranges::copy(points, seeds_.as<double>().begin());
        std::ranges::copy(weights, weights_.as<double>().begin());
        submit();
        return gather();
    }
    // Whether a run has succeeded since the last one that failed.
    [[nodiscard]] bool has_run() const { return has_run_; }
    // Returns the cells of the last run. Those without a certificate are made on the CPU.
    [[nodiscard]] detail::FrameRows resolve();
    [[nodiscard]] const Want& want() const { return want_; }
    [[nodiscard]] bool has_gradients() const { return gradients_.has_value(); }
    // Sets the derivatives of a number by the points and weights of the last run, 3N and N. Throws invalid_use for
    // unresolved cells.
    void vjp(const detail::FrameVectors& given, double* by_points, double* by_weights);

private:
    void begin(std::size_t count, bool narrow);
    void submit();
    [[nodiscard]] detail::FrameRows gather();

    std::shared_ptr<vulkan::Device> device_;
    votess::vulkan::Plan plan_;
    Want want_;
    ThreadPool pool_;
    vulkan::Memory memory_;
    vulkan::Buffer seeds_, weights_;
    std::optional<FrameBuffers> buffers_;
    std::optional<Gradients> gradients_;
    vulkan::Commands commands_;
    votess::vulkan::Resolved more_;  // cells of the last run that the CPU made
    std::size_t count_ = 0;
    bool narrow_ = false;  // the points were float32
    bool fresh_ = true;    // the frame keeps no cells
    bool has_run_ = false;
};

}  // namespace votess::gpu

#include "run/frames.hpp"

#include <algorithm>
#include <limits>

#if VOTESS_HAVE_VULKAN
#include <atomic>
#include <cmath>

#include "core/errors.hpp"
#include "core/one_call.hpp"
#include "core/system.hpp"
#include "core/text.hpp"
#include "gpu/device_choice.hpp"
#include "gpu/frames/exported_frames.hpp"
#include "gpu/frames/frame.hpp"
#include "gpu/frames/host_frames.hpp"
#include "input/settle.hpp"
#endif

namespace votess {

#if VOTESS_HAVE_VULKAN

namespace {

void check_options(const Options& options) {
    const auto refuse_if = [](bool set, const char* name, const char* why) {
        if (set) refuse("frames: Options::" + std::string(name) + " " + why);
    };
    const Want& want = options.want;
    refuse_if(options.planar, "planar", "is set: frames are of space");
    refuse_if(options.mesh.has_value(), "mesh", "is given: use tessellate(), or give Options::box or Options::cell");
    refuse_if(options.only.has_value(), "only", "is given: a frame makes all cells, leave it out");
    refuse_if(options.min_face > 0, "min_face", "is given: a frame has all faces, leave it out");
    refuse_if(options.min_area > 0, "min_area", "is given: a frame has all faces, leave it out");
    refuse_if(options.duplicates != Duplicates::merge, "duplicates",
              "= error: a frame gives such points the status duplicate, leave it out");
    refuse_if(options.outside == Outside::keep, "outside",
              "= keep: a frame gives points outside the status outside, leave it out");
    refuse_if(options.precision != Precision::single, "precision",
              "= double: frames hold float32, use tessellate() or leave it out");
    refuse_if(!options.weights.empty(), "weights", "are given: frames have a range, and each run its weights");
    refuse_if(!options.radii.empty(), "radii", "are given: frames have a range of weights, the squares of radii");
    refuse_if(exceeds(want, {.centroids = true, .areas = true}), "want",
              "has more than neighbors, volumes, centroids and areas, which frames make");
    if (options.cell) return;
    refuse_if(!options.box, "box", "is missing: frames need a box, or Options::cell, that all of them share");
    for (std::size_t k = 0; k < 3; ++k)
        refuse_if(!std::isfinite(options.box->lower[k]) || !std::isfinite(options.box->upper[k]), "box",
                  "has an infinite bound: frames need a finite one");
}

votess::vulkan::PlanOptions plan_of(const FramesSettings& settings, const Settled& run) {
    constexpr std::uint32_t most = vulkan::detail::max_of_all, usual_row = 20;
    if (settings.max_points == 0 || settings.max_points > most)
        refuse("max_points = " + std::to_string(settings.max_points) + ": give 1 to " + std::to_string(most));
    if (!(settings.margin >= 0) || !std::isfinite(settings.margin))
        refuse("margin = " + number(settings.margin) + ": give a length, or 0 for a usual one");
    // Offsets are int32.
    constexpr std::uint64_t max_entries = std::numeric_limits<std::int32_t>::max();
    const std::uint64_t entries =
        settings.max_entries != 0 ? settings.max_entries : usual_row * std::uint64_t{settings.max_points};
    votess::vulkan::PlanOptions plan;
    plan.max_seeds = settings.max_points;
    if (run.region.cell)
        plan.cell = run.region.cell;
    else
        plan.box = *run.region.box;
    plan.periodic = run.region.periodic;
    if (settings.weights) plan.weights = {.least = settings.weights->first, .largest = settings.weights->second};
    plan.walls = run.region.walls;
    plan.margin = settings.margin;
    plan.max_images = settings.max_images;
    plan.format =
        settings.uuid && !settings.wide ? votess::vulkan::SeedFormat::float32 : votess::vulkan::SeedFormat::float64;
    plan.neighbors = run.want.neighbors;
    plan.geometry = run.want.volumes || run.want.centroids;
    plan.areas = run.want.areas;
    plan.list_walls = run.list_walls;
    plan.max_entries = static_cast<std::uint32_t>(std::min(entries, max_entries));
    plan.chunk_size = run.chunk_size;
    plan.k_init = run.k_init;
    plan.follow = run.follow;
    return plan;
}

std::shared_ptr<gpu::vulkan::Device> open_device(const std::string& name) {
    if (name == "cpu")
        refuse(
            "Options::device = cpu: frames need a Vulkan device, give gpu, lavapipe or an index, or use tessellate()");
    if (auto device = gpu::choose_device(name)) return device;
    try {
        return gpu::choose_device("lavapipe");
    } catch (const Error& error) {
        if (error.code() != ErrorCode::unsupported) throw;
        throw Error(ErrorCode::unsupported, std::string("frames need a Vulkan device: ") + error.what() +
                                                ". Use tessellate(), or install a driver, such as Mesa's lavapipe");
    }
}

}  // namespace

struct Frames::State {
    std::optional<gpu::HostFrames> frames;
    std::optional<gpu::ExportedFrames> exported;  // one of both
    std::atomic_flag at_work;
    system::HomeProcess home;  // where the device was opened

    void check_process() const {
        if (home.is_this()) return;
        throw Error(
            ErrorCode::unsupported,
            "these frames opened a device before fork(), and the child process cannot use it: make frames there, "
            "or start the process afresh instead of by fork()");
    }
    [[nodiscard]] OneCall call() {
        check_process();
        return {at_work, "these frames are in use by another call: make frames for each thread"};
    }
};

Frames::Frames(const FramesSettings& settings, const Options& options, const Frames* share)
    : state_(std::make_unique<State>()) {
    check_options(options);
    const Settled run = settle(options);
    const votess::vulkan::PlanOptions plan = plan_of(settings, run);
    if (settings.uuid) {
        if (share != nullptr) refuse("share: frames with exported memory have a device of their own, leave it out");
        state_->exported.emplace(*settings.uuid, plan, run.want, run.threads, settings.gradients);
        return;
    }
    if (share != nullptr && !share->state_->frames)
        refuse("share: frames with exported memory do not share their device, leave it out");
    if (share != nullptr) share->state_->check_process();
    state_->frames.emplace(share != nullptr ? share->state_->frames->device() : open_device(run.device), plan, run.want,
                           run.threads, settings.gradients);
}

Frames::~Frames() {
    if (!state_->home.is_this()) (void)state_.release();  // the device is the parent's
}

std::string Frames::device() const {
    const auto line = [](const auto& frames) {
        return frames.device()->adapter().name + ": " + frames.plan().kernel();
    };
    return state_->frames ? line(*state_->frames) : line(*state_->exported);
}

template <class Real>
detail::FrameRows Frames::run_any(std::span<const Real> points, std::span<const double> weights) {
    const OneCall call = state_->call();
    if (!state_->frames) refuse("these frames have exported memory: submit frames to them");
    const votess::vulkan::PlanOptions& plan = state_->frames->plan().options();
    const std::size_t count = points.size() / 3;
    if (count > plan.max_seeds)
        refuse(std::to_string(count) + " points are more than max_points = " + std::to_string(plan.max_seeds) +
               ": make frames for more");
    if (plan.weights && weights.size() != count)
        refuse("weights are missing: these frames were made with a range of weights, give one for each point");
    if (!plan.weights && !weights.empty())
        refuse("weights are given, but these frames have none: make frames with a range of weights");
    return state_->frames->run(points, weights);
}

detail::FrameRows Frames::run(std::span<const double> points, std::span<const double> weights) {
    return run_any(points, weights);
}

detail::FrameRows Frames::run(std::span<const float> points, std::span<const double> weights) {
    return run_any(points, weights);
}

detail::FrameRows Frames::resolve() {
    const OneCall call = state_->call();
    if (!state_->frames) refuse("these frames have exported memory: resolve that");
    if (!state_->frames->has_run())
        throw Error(ErrorCode::invalid_use,
                    "resolve() completes the last run, and there is none: run these frames first");
    return state_->frames->resolve();
}

namespace {

gpu::ExportedFrames& exported_of(std::optional<gpu::ExportedFrames>& frames) {
    if (!frames) refuse("these frames have no exported memory: make frames with the UUID of a device");
    return *frames;
}

void check_order(std::uint64_t after, std::uint64_t done) {
    if (done <= after)
        refuse("done = " + std::to_string(done) + " must be above after = " + std::to_string(after) +
               ": the values of the semaphore only grow");
}

void check_gradients(const auto& frames) {
    if (!frames.has_gradients()) refuse("these frames compute no gradient: set that option when you make them");
}

}  // namespace

void Frames::vjp(const detail::FrameVectors& given, double* by_points, double* by_weights) {
    const OneCall call = state_->call();
    if (!state_->frames) refuse("these frames have exported memory: submit the gradient");
    gpu::HostFrames& frames = *state_->frames;
    check_gradients(frames);
    if (!frames.has_run())
        throw Error(ErrorCode::invalid_use,
                    "gradients are those of the last run, and there is none: run these frames first");
    const auto check = [](bool is_given, bool has, const char* name) {
        if (is_given && !has)
            refuse(std::string("vectors for ") + name + " are given, but the cells have none: put them into want");
    };
    check(given.volumes != nullptr, frames.want().volumes, "volumes");
    check(given.centroids != nullptr, frames.want().centroids, "centroids");
    check(given.centroids != nullptr, frames.want().volumes, "centroids, which need volumes too,");
    check(given.face_areas != nullptr, frames.want().areas, "areas");
    frames.vjp(given, by_points, by_weights);
}

detail::ExportedArrays Frames::exported() {
    const OneCall call = state_->call();
    return exported_of(state_->exported).arrays();
}

void Frames::submit(std::uint32_t count, std::uint64_t after, std::uint64_t done) {
    const OneCall call = state_->call();
    gpu::ExportedFrames& frames = exported_of(state_->exported);
    const std::uint32_t most = frames.plan().options().max_seeds;
    if (count > most)
        refuse(std::to_string(count) + " points are more than max_points = " + std::to_string(most) +
               ": make frames for more");
    check_order(after, done);
    frames.submit(count, after, done);
}

void Frames::submit_vjp(const Want& given, std::uint64_t after, std::uint64_t done) {
    const OneCall call = state_->call();
    gpu::ExportedFrames& frames = exported_of(state_->exported);
    check_gradients(frames);
    check_order(after, done);
    frames.submit_vjp(given, after, done);
}

void Frames::signal(std::uint64_t value) {
    exported_of(state_->exported).signal(value);
}

void Frames::wait(std::uint64_t value) {
    exported_of(state_->exported).wait(value);
}

std::size_t Frames::resolve_exported() {
    const OneCall call = state_->call();
    return exported_of(state_->exported).resolve();
}

#else

struct Frames::State {};

Frames::Frames(const FramesSettings&, const Options&, const Frames*) {
    throw Error(ErrorCode::unsupported, "frames need Vulkan, and this votess was built without it: use tessellate()");
}
Frames::~Frames() = default;
std::string Frames::device() const {
    return {};
}
detail::FrameRows Frames::run(std::span<const double>, std::span<const double>) {
    return {};
}
detail::FrameRows Frames::run(std::span<const float>, std::span<const double>) {
    return {};
}
detail::FrameRows Frames::resolve() {
    return {};
}
detail::ExportedArrays Frames::exported() {
    return {};
}
void Frames::vjp(const detail::FrameVectors&, double*, double*) {}
void Frames::submit(std::uint32_t, std::uint64_t, std::uint64_t) {}
void Frames::submit_vjp(const Want&, std::uint64_t, std::uint64_t) {}
void Frames::signal(std::uint64_t) {}
void Frames::wait(std::uint64_t) {}
std::size_t Frames::resolve_exported() {
    return 0;
}

#endif

}  // namespace votess

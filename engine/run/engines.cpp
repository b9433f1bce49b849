#include "run/engines.hpp"

#include <algorithm>
#include <optional>
#include <thread>
#include <utility>

#include "core/home_process.hpp"
#include "core/progress.hpp"
#include "cpu/cpu_engine.hpp"
#include "input/options.hpp"
#include "input/snapshot.hpp"
#include "polytope/cell_kernels.hpp"
#if VOTESS_HAVE_VULKAN
#include "gpu/device_choice.hpp"
#include "gpu/device_domain.hpp"
#include "gpu/gpu_engine.hpp"
#endif

namespace votess {

struct Engines::State {
    ~State() { forget_gpu(); }
    void forget_gpu() {
        if (!gpu_home.is_this()) (void)gpu.release();
        gpu.reset();
    }

    cpu::CpuClipper clipper;  // and its threads, for both engines
    cpu::CpuEngine cpu{clipper};
    Snapshot snapshot;
    std::unique_ptr<Engine> gpu;
    std::string gpu_name;  // the device name that chose it
    HomeProcess gpu_home;  // where it was opened
};

Engines::Engines() : state_(std::make_unique<State>()) {}
Engines::~Engines() = default;

Engine& Engines::cpu() {
    return state_->cpu;
}

Points Engines::take(const Points& points, unsigned threads) {
    return state_->snapshot.take(points, state_->clipper.pool_of(threads));
}

Snapshot& Engines::snapshot() {
    return state_->snapshot;
}

void Engines::forget_gpu() {
    state_->forget_gpu();
}

void Engines::put(const std::string& device, std::unique_ptr<Engine> engine) {
    state_->gpu = std::move(engine);
    state_->gpu_name = device;
    state_->gpu_home = {};
}

#if VOTESS_HAVE_VULKAN

// Finding out that there is no GPU takes 40 ms, as long as 10,000 cells take on one core; opening one takes longer.
constexpr std::size_t least_to_look = 10000;

Engine& Engines::choose(const Job& job, StageClock& clock) {
    const std::string& device = job.options.device;
    if (device == "cpu" || (device == "auto" && !gpu::device_clips(job))) return state_->cpu;
    if (state_->gpu && !state_->gpu_home.is_this())
        throw Error(ErrorCode::unsupported,
                    "device '" + device +
                        "': this Tessellator has opened one before fork(), and the child process cannot use it: use "
                        "the CPU there, or start the process anew instead of by fork()");
    if (state_->gpu && state_->gpu_name == device) return *state_->gpu;
    if (device == "auto" && job.points.count() < least_to_look) {
        if (job.options.log)
            job.options.log("the CPU takes fewer than " + std::to_string(least_to_look) +
                            " seeds: it is done before a GPU is found");
        return state_->cpu;
    }
    const StageClock::Within opening(clock, &StageSeconds::open);
    auto chosen = gpu::choose_device(device);
    if (!chosen) return state_->cpu;
    forget_gpu();  // before another one takes its memory
    put(device, std::make_unique<gpu::GpuEngine>(std::move(chosen), state_->clipper));
    return *state_->gpu;
}

#else

Engine& Engines::choose(const Job& job, StageClock&) {
    const std::string& device = job.options.device;
    if (device != "cpu" && device != "auto")
        throw Error(ErrorCode::unsupported, "device '" + device + "': this votess was built without Vulkan, use cpu");
    return state_->cpu;
}

#endif

std::vector<DeviceInfo> Engines::devices() {
    const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
    std::vector<DeviceInfo> all{{"cpu", "CPU",
                                 std::to_string(threads) + (threads == 1 ? " thread, " : " threads, ") +
                                     cpu::best_kernels().name + " instructions, exact in double precision"}};
#if VOTESS_HAVE_VULKAN
    const auto vulkan = gpu::list_devices();
    all.insert(all.end(), vulkan.begin(), vulkan.end());
#endif
    return all;
}

namespace {

detail::Result run_job(Engine& engine, const Job& job, StageClock& clock) {
    detail::Result result;
    engine.run(job, clock, result);
    result.stats.seconds = clock.seconds();
    return result;
}

}  // namespace

detail::Result run_on(Engines& engines, const Points& points, const Options& options, detail::Result arrays) {
    StageClock clock;
    Progress progress(options.progress);
    progress.postpone();  // a refusal of short input comes before any report
    std::optional<Stoppable> stoppable(std::in_place, progress);
    check_options(options);
    check_shape(points);
    Job job = validate(engines.take(points, options.threads), options);
    stoppable.reset();  // an engine has its own
    job.arrays = &arrays;
    job.snapshot = &engines.snapshot();
    bool on_cpu = false;
    try {
        Engine& engine = engines.choose(job, clock);
        on_cpu = &engine == &engines.cpu();
        return run_job(engine, job, clock);
    } catch (const Error& error) {
        const bool device_failed = error.code() == ErrorCode::device_lost || error.code() == ErrorCode::out_of_memory;
        // After a failure the engine's device may be unusable.
        if (device_failed) engines.forget_gpu();
        const bool device_cannot = device_failed || error.code() == ErrorCode::unsupported;
        if (!device_cannot || options.device != "auto" || on_cpu) throw;
        if (options.log) options.log(std::string("the CPU takes over: ") + error.what());
    }
    job.arrays = nullptr;  // which the failed run may have taken
    return run_job(engines.cpu(), job, clock);
}

}  // namespace votess

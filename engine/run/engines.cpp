#include "run/engines.hpp"

#include <optional>
#include <utility>

#include "core/processors.hpp"
#include "core/progress.hpp"
#include "cpu/cpu_engine.hpp"
#include "input/settle.hpp"
#include "input/snapshot.hpp"
#include "polytope/cell_kernels.hpp"
#if VOTESS_HAVE_VULKAN
#include "core/system.hpp"
#include "gpu/device_choice.hpp"
#include "gpu/gpu_engine.hpp"
#endif

namespace votess {

#if VOTESS_HAVE_VULKAN

namespace detail {

// Finding out that there is no GPU takes 40 ms, as long as 10,000 cells take on one core; opening one takes longer.
constexpr std::size_t min_seeds = 10000;

// The engine of an open GPU, and its name in Options::device.
class OpenGpu {
public:
    ~OpenGpu() { close(); }
    void close() {
        if (!home_.is_this()) (void)engine_.release();
        engine_.reset();
    }
    void put(const std::string& device, std::unique_ptr<gpu::GpuEngine> engine) {
        engine_ = std::move(engine);
        name_ = device;
        home_ = {};
    }
    // Returns null when the CPU runs the job. domain: null when no device clips it.
    gpu::GpuEngine* find(const Job& job, const gpu::DeviceDomain* domain, ExactClipper& clipper, StageClock& clock);

private:
    std::unique_ptr<gpu::GpuEngine> engine_;
    std::string name_;
    system::HomeProcess home_;  // where it was opened
};

gpu::GpuEngine* OpenGpu::find(const Job& job, const gpu::DeviceDomain* domain, ExactClipper& clipper,
                              StageClock& clock) {
    const std::string& device = job.device;
    const bool is_auto = device == "auto";
    if (is_auto && domain == nullptr) return nullptr;
    if (engine_ && !home_.is_this())
        throw Error(ErrorCode::unsupported,
                    "device '" + device +
                        "': this Tessellator opened one before fork(), and the child process cannot use it: use the "
                        "CPU there, or start the process afresh instead of by fork()");
    if (engine_ && name_ == device) return engine_.get();
    if (is_auto && job.points.count() < min_seeds) {
        if (job.log)
            job.log("the CPU takes fewer than " + std::to_string(min_seeds) +
                    " seeds: it is done before a GPU is found");
        return nullptr;
    }
    const StageClock::Within opening(clock, &StageSeconds::open);
    auto chosen = gpu::choose_device(device);
    if (!chosen) return nullptr;
    close();  // before another one takes its memory
    put(device, std::make_unique<gpu::GpuEngine>(std::move(chosen), clipper));
    return engine_.get();
}

}  // namespace detail

#endif

struct Engines::State {
    cpu::CpuClipper clipper;  // with its threads, for both engines
    cpu::CpuEngine cpu{clipper};
    Snapshot snapshot;
#if VOTESS_HAVE_VULKAN
    detail::OpenGpu gpu;
#endif
};

Engines::Engines() : state_(std::make_unique<State>()) {}
Engines::~Engines() = default;

ThreadPool& Engines::pool_of(unsigned threads) {
    return state_->clipper.pool_of(threads);
}

Snapshot& Engines::snapshot() {
    return state_->snapshot;
}

#if VOTESS_HAVE_VULKAN

void Engines::put(const std::string& device, std::unique_ptr<gpu::GpuEngine> engine) {
    state_->gpu.put(device, std::move(engine));
}

void Engines::run(const Job& job, StageClock& clock, detail::Result& result) {
    const std::string& device = job.device;
    if (device == "cpu" || job.only) return state_->cpu.run(job, clock, result);
    std::optional<Job> again;
    try {
        const std::optional<gpu::DeviceDomain> domain = gpu::device_domain(job);
        const gpu::DeviceDomain* const clipped = domain ? &*domain : nullptr;
        if (gpu::GpuEngine* gpu = state_->gpu.find(job, clipped, state_->clipper, clock))
            return gpu->run(job, clipped, clock, result);
    } catch (const Error& error) {
        const bool device_failed = error.code() == ErrorCode::device_lost || error.code() == ErrorCode::out_of_memory;
        if (device_failed) state_->gpu.close();  // its device may be unusable
        if (device != "auto" || (!device_failed && error.code() != ErrorCode::unsupported)) throw;
        if (job.log) job.log(std::string("the CPU takes over: ") + error.what());
        result = {};
        again = job;
        again->arrays = nullptr;  // the failed run may have taken them
    }
    state_->cpu.run(again ? *again : job, clock, result);
}

#else

void Engines::run(const Job& job, StageClock& clock, detail::Result& result) {
    const std::string& device = job.device;
    if (device != "cpu" && device != "auto")
        throw Error(ErrorCode::unsupported, "device '" + device + "': this votess was built without Vulkan, use cpu");
    state_->cpu.run(job, clock, result);
}

#endif

std::vector<DeviceInfo> Engines::devices() {
    const unsigned threads = system::processors();
    std::vector<DeviceInfo> all{{"cpu", "CPU",
                                 std::to_string(threads) + (threads == 1 ? " thread, " : " threads, ") +
                                     cpu::best_kernels().name + " instructions, exact in double precision"}};
#if VOTESS_HAVE_VULKAN
    const auto vulkan = gpu::list_devices();
    all.insert(all.end(), vulkan.begin(), vulkan.end());
#endif
    return all;
}

detail::Result run_on(Engines& engines, Settled run, detail::Result arrays) {
    StageClock clock;
    Progress progress(run.progress);
    progress.postpone();  // a refusal of short input comes before any report
    std::optional<Stoppable> stoppable(std::in_place, progress);
    ThreadPool& pool = engines.pool_of(run.threads);
    run.points = engines.snapshot().take(run.points, pool);
    Job job = make_job(std::move(run), &pool);
    stoppable.reset();  // an engine has its own
    job.arrays = &arrays;
    job.snapshot = &engines.snapshot();
    detail::Result result;
    engines.run(job, clock, result);
    result.stats.seconds = clock.seconds();
    return result;
}

}  // namespace votess

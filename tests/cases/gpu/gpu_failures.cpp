// The GPU engine when the device fails or the user stops it: it throws the right error, leaks nothing, and the next run
// is normal.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <set>
#include <thread>
#include <type_traits>

#include "input/settle.hpp"
#include "run/engines.hpp"
#include "support/child.hpp"
#include "support/gpu/gpu.hpp"

namespace {

using test::Gpu;
using test::GpuRunner;
using test::PointSet;
using votess::ErrorCode;
using votess::Options;

// An entry of the device's table that fails at every call after some good ones.
template <auto entry, class Type = decltype(entry)>
struct Failing;
template <auto entry, class... Arguments>
struct Failing<entry, VkResult (VKAPI_PTR* VolkDeviceTable::*)(Arguments...)> {
    static inline VkResult(VKAPI_PTR* original)(Arguments...);
    static inline VkResult result;
    static inline std::atomic<int> calls;  // threads make pipelines
    static inline int good_calls;

    static VKAPI_ATTR VkResult VKAPI_CALL call(Arguments... arguments) {
        if (calls++ >= good_calls) return result;
        const VkResult done = original(arguments...);
        calls -= done == VK_TIMEOUT;  // repeated waits depend on the machine
        return done;
    }
    static void into(Gpu& gpu, VkResult failure, int after) {
        original = gpu.original.*entry;
        result = failure;
        calls = 0;
        good_calls = after;
        gpu.device->table().*entry = call;
    }
};

Options usual_options() {
    Options options = test::all_options();
    options.chunk_size = 200;
    return options;
}

const PointSet& usual_set() {
    static const PointSet set = test::uniform(test::by_size(600, 400), 111);
    return set;
}

// Fails the entry at its first, second, ... last call during a run.
template <auto entry>
void fail_everywhere(VkResult failure, ErrorCode code, const votess::gpu::EngineLimits& limits = {}) {
    std::optional<Gpu> kept(std::in_place);
    const auto expected = test::run(usual_set(), usual_options());
    Gpu& gpu = *kept;
    Failing<entry>::into(gpu, failure, 1 << 30);
    {
        GpuRunner runner(gpu, limits);
        CHECK(test::check_same(runner.run(usual_set(), usual_options()), expected, usual_set().points, 1e-5) == "");
    }
    const int calls = Failing<entry>::calls;
    CHECK(calls > 0);
    std::set<int> all{0, calls / 2};
    if (!test::reduced()) all.insert({std::min(1, calls - 1), calls - 1});
    for (const int after : all) {
        CAPTURE(after);
        CAPTURE(calls);
        // A device makes its pipelines once.
        if constexpr (std::is_same_v<decltype(entry), decltype(&VolkDeviceTable::vkCreateComputePipelines)>)
            kept.emplace();
        Failing<entry>::into(gpu, failure, after);
        {
            GpuRunner runner(gpu, limits);
            std::string message;
            CHECK(test::error_of([&] { (void)runner.run(usual_set(), usual_options()); }, &message) == code);
            CHECK(message.find('\n') == std::string::npos);
            CHECK(!message.empty());
        }
        gpu.device->table() = gpu.original;
    }
    GpuRunner runner(gpu, limits);
    CHECK(test::check_same(runner.run(usual_set(), usual_options()), expected, usual_set().points, 1e-5) == "");
}

// A Tessellator's engines that have opened the tests' device under this name.
struct OpenEngines {
    Gpu gpu;
    votess::cpu::CpuClipper clipper;
    std::unique_ptr<votess::Engines> engines = std::make_unique<votess::Engines>();

    explicit OpenEngines(const std::string& device) {
        engines->put(device, std::make_unique<votess::gpu::GpuEngine>(gpu.device, clipper));
    }
    [[nodiscard]] votess::Tessellation run(const PointSet& set, const Options& options) const {
        return votess::Tessellation(std::make_shared<const votess::detail::Result>(
            votess::run_on(*engines, votess::settle({set.points, {}}, options))));
    }
};

// Stops a run at this fraction.
votess::ProgressCallback stop_at(double fraction) {
    return [fraction](double now) { return now < fraction; };
}
// Each call outlasts the interval between calls, so that also a run of milliseconds meets `fraction` before its end.
votess::ProgressCallback slowly_stop_at(double fraction) {
    return [fraction](double now) {
        if (now >= fraction) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(101));
        return true;
    };
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu: a device lost at any submission") {
        fail_everywhere<&VolkDeviceTable::vkQueueSubmit>(VK_ERROR_DEVICE_LOST, ErrorCode::device_lost);
    }

    TEST_CASE("gpu: a device lost at any wait") {
        fail_everywhere<&VolkDeviceTable::vkWaitForFences>(VK_ERROR_DEVICE_LOST, ErrorCode::device_lost);
    }

    TEST_CASE("gpu: a device lost between parts") {
        fail_everywhere<&VolkDeviceTable::vkQueueSubmit>(VK_ERROR_DEVICE_LOST, ErrorCode::device_lost,
                                                         {.max_seeds = 300});
    }

    TEST_CASE("gpu: no memory for a block, a buffer, a pipeline, a descriptor pool or a recording") {
        fail_everywhere<&VolkDeviceTable::vkAllocateMemory>(VK_ERROR_OUT_OF_DEVICE_MEMORY, ErrorCode::out_of_memory);
        fail_everywhere<&VolkDeviceTable::vkCreateBuffer>(VK_ERROR_OUT_OF_DEVICE_MEMORY, ErrorCode::out_of_memory);
        fail_everywhere<&VolkDeviceTable::vkCreateComputePipelines>(VK_ERROR_OUT_OF_HOST_MEMORY,
                                                                    ErrorCode::out_of_memory);
        fail_everywhere<&VolkDeviceTable::vkCreateDescriptorPool>(VK_ERROR_OUT_OF_HOST_MEMORY,
                                                                  ErrorCode::out_of_memory);
        fail_everywhere<&VolkDeviceTable::vkBeginCommandBuffer>(VK_ERROR_OUT_OF_HOST_MEMORY, ErrorCode::out_of_memory);
    }

    TEST_CASE("gpu: with auto the CPU takes over from a device that fails, else the error is the user's") {
        struct Case {
            const char* device;
            VkResult failure;
            ErrorCode code;
        };
        const std::string name = test::device_name();
        const auto& set = usual_set();
        for (const Case& c : {Case{"auto", VK_ERROR_DEVICE_LOST, ErrorCode::device_lost},
                              Case{"auto", VK_ERROR_OUT_OF_DEVICE_MEMORY, ErrorCode::out_of_memory},
                              Case{"auto", VK_ERROR_UNKNOWN, ErrorCode::unsupported},
                              Case{name.c_str(), VK_ERROR_DEVICE_LOST, ErrorCode::device_lost},
                              Case{name.c_str(), VK_ERROR_OUT_OF_DEVICE_MEMORY, ErrorCode::out_of_memory},
                              Case{name.c_str(), VK_ERROR_UNKNOWN, ErrorCode::unsupported}}) {
            CAPTURE(c.device);
            CAPTURE(c.failure);
            OpenEngines open(c.device);
            Gpu& gpu = open.gpu;
            std::vector<std::string> lines;
            Options options = usual_options();
            options.box = set.box;
            options.device = c.device;
            options.log = [&](std::string_view line) { lines.emplace_back(line); };
            const auto run = [&] { return open.run(set, options); };
            const auto expected = test::run(set);
            const auto good = run();
            CHECK(good.stats().device == gpu.adapter.name);
            CHECK(test::check_same(good, expected, set.points, 1e-5) == "");
            CHECK(lines.empty());
            Failing<&VolkDeviceTable::vkQueueSubmit>::into(gpu, c.failure, 3);
            if (c.device == std::string("auto")) {
                const auto replaced = run();
                CHECK(replaced.stats().device != gpu.adapter.name);
                CHECK(test::check_identical(replaced, expected) == "");
                REQUIRE(lines.size() == 1);
                CHECK(lines[0].rfind("the CPU takes over: ", 0) == 0);
            } else {
                std::string message;
                CHECK(test::error_of(run, &message) == c.code);
                CHECK(message.find("vkQueueSubmit") != std::string::npos);
                CHECK(lines.empty());
            }
            gpu.device->table() = gpu.original;
            // On a device that was opened again, where there is one.
            CHECK(test::check_same(run(), expected, set.points, 1e-5) == "");
        }
    }

    TEST_CASE("gpu: a child made by fork() cannot use the device of its parent, and does not touch it") {
        const auto& set = usual_set();
        const auto expected = test::run(set);
        for (const char* device : {"auto", "gpu"}) {
            CAPTURE(device);
            OpenEngines open(device);
            Gpu& gpu = open.gpu;
            std::vector<std::string> lines;
            Options options = usual_options();
            options.box = set.box;
            options.device = device;
            options.log = [&](std::string_view line) { lines.emplace_back(line); };
            const auto run = [&] { return open.run(set, options); };
            CHECK(run().stats().device == gpu.adapter.name);
            CHECK(test::in_child([&]() -> std::string {
                      // Any call on the device ends the child from here on.
                      gpu.device->table() = {};
                      std::string message;
                      if (options.device == "gpu") {
                          if (test::error_of(run, &message) != ErrorCode::unsupported) return "no error";
                          if (message.find("fork()") == std::string::npos) return message;
                          options.device = "cpu";
                          if (auto failure = test::check_identical(run(), expected); !failure.empty()) return failure;
                      } else {
                          if (auto failure = test::check_identical(run(), expected); !failure.empty()) return failure;
                          if (lines.size() != 1 || lines[0].find("fork()") == std::string::npos) return "no reason";
                      }
                      open.engines.reset();
                      return "";
                  }) == "");
            CHECK(run().stats().device == gpu.adapter.name);
        }
    }

    TEST_CASE("gpu: the CPU does not take over after the user's errors and stops") {
        const OpenEngines open("auto");
        Options options = usual_options();
        options.device = "auto";
        const auto run = [&] { return open.run(usual_set(), options); };
        options.progress = stop_at(0);
        CHECK(test::error_of(run) == ErrorCode::cancelled);
        options.progress = nullptr;
        options.box = test::cube(0, 0.5);
        CHECK(test::error_of(run) == ErrorCode::invalid_argument);
        options.box.reset();
        CHECK(run().stats().device == open.gpu.adapter.name);
    }

    TEST_CASE("gpu: auto takes the device for what the device clips, and else the CPU") {
        const OpenEngines open("auto");
        const std::string& device = open.gpu.adapter.name;
        const PointSet set = test::uniform(400, 31);
        Options usual = test::all_options(test::unit_box());
        usual.device = "auto";
        const auto device_of = [&](const Options& options) { return open.run(set, options).stats().device; };
        CHECK(device_of(usual) == device);
        Options periodic = usual;
        periodic.periodic = {true, true, true};
        const PointSet large = test::uniform(2000, 32);
        CHECK(open.run(large, periodic).stats().device == device);
        periodic.box->lower[0] = 0x1p-80;  // not a whole number of units
        CHECK(device_of(periodic) == device);
        Options dropped = usual;
        dropped.box->upper[0] = 0.5;
        dropped.outside = votess::Outside::drop;
        CHECK(device_of(dropped) == device);
        Options walls = usual;
        walls.walls.push_back({{1, 1, 1}, 4});
        CHECK(device_of(walls) == device);
        const std::vector<double> radii(set.points.size() / 3, 0.01);
        Options weighted = usual;
        weighted.radii = radii;
        CHECK(device_of(weighted) == device);
        weighted.walls = walls.walls;
        CHECK(device_of(weighted) == device);
        // A box along the axes around it has too many images.
        Options oblique;
        oblique.device = "auto";
        oblique.cell = votess::TriclinicBox{{0, 0, 0}, {100, 100, 100}, {1, -1, 0}, {1, 1, -2}, {true, true, true}};
        const PointSet few = test::uniform(100, 33);
        CHECK(open.run(few, oblique).stats().device == "cpu");
    }

    TEST_CASE("gpu: the fractions of a run grow from 0 to 1, whoever reports them") {
        PointSet set = test::uniform(300, 112);
        std::copy_n(set.points.begin(), 300, set.points.end() - 300);  // duplicates, and images of them
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            Options options = test::all_options(set.box);
            options.periodic.fill(periodic);
            options.device = test::device_name();
            options.chunk_size = 100;
            std::vector<double> fractions;
            int slow = 0;
            options.progress = [&](double fraction) {
                fractions.push_back(fraction);
                // So slow that the next look at the clock calls back.
                if (fraction > 0.5 && ++slow < 8) std::this_thread::sleep_for(std::chrono::milliseconds(105));
                return true;
            };
            (void)votess::tessellate(set.points, options);
            CHECK(std::is_sorted(fractions.begin(), fractions.end()));
            CHECK(fractions.front() == 0);
            CHECK(fractions.back() == 1);
        }
    }

    TEST_CASE("gpu: cancelled at the beginning, in between and at the end, then used again") {
        votess::Tessellator tessellator;
        const PointSet large = test::uniform(test::by_size(8000, 2000), 112);
        Options options = test::all_options(large.box);
        options.device = test::device_name();
        options.chunk_size = 500;
        const auto whole = tessellator.tessellate(large.points, options);
        for (const double fraction : {0.0, 0.3, 1.0}) {
            CAPTURE(fraction);
            options.progress = stop_at(fraction);
            CHECK(test::error_of([&] { (void)tessellator.tessellate(large.points, options); }) == ErrorCode::cancelled);
            // Smaller, larger and with other pipelines, while the device may still work on the stopped run.
            for (const std::size_t n : {200, 2500}) {
                const PointSet set = test::clustered(n, n);
                Options other = test::all_options(set.box);
                const auto expected = votess::tessellate(set.points, other);
                other.device = test::device_name();
                other.k_init = n == 200 || fraction == 0.3 ? 0 : 40;
                CHECK(test::check_same(tessellator.tessellate(set.points, other), expected, set.points, 1e-5) == "");
            }
        }
        options.progress = nullptr;
        CHECK(test::check_identical(tessellator.tessellate(large.points, options), whole) == "");
    }

    TEST_CASE("gpu: cancelled, then a set that needs larger buffers") {
        Gpu gpu;
        const PointSet small = test::uniform(test::by_size(4000, 1500), 114);
        for (int round = 0; round < 2; ++round) {
            GpuRunner runner(gpu);
            Options options = test::all_options();
            options.chunk_size = 1000;
            options.progress = stop_at(0.06);
            const auto code = test::error_of([&] { (void)runner.run(small, options); });
            CHECK((!code || code == ErrorCode::cancelled));
            options.progress = nullptr;
            options.chunk_size = 0;
            options.k_init = round % 2 == 0 ? 0 : 100;
            const PointSet set = test::uniform(small.size() + 500, 115);
            CHECK(test::check_same(runner.run(set, options), test::run(set), set.points, 1e-5) == "");
        }
    }

    TEST_CASE("gpu: cancelled in a part, and an engine that ends while its device works") {
        Gpu gpu;
        const PointSet large = test::uniform(test::by_size(4000, 1500), 113);
        for (const double fraction : {0.06, 0.3}) {
            GpuRunner runner(gpu, {.max_seeds = 1500});
            Options options = test::all_options();
            options.chunk_size = 300;
            options.progress = slowly_stop_at(fraction);
            CHECK(test::error_of([&] { (void)runner.run(large, options); }) == ErrorCode::cancelled);
            if (fraction > 0.1) break;
            options.progress = nullptr;
            CHECK(test::check_same(runner.run(usual_set(), options), test::run(usual_set()), usual_set().points,
                                   1e-5) == "");
        }
    }

    TEST_CASE("gpu: an exception of the progress callback passes through") {
        votess::Tessellator tessellator;
        const auto& set = usual_set();
        Options options = test::all_options(set.box);
        options.device = test::device_name();
        options.progress = [](double) -> bool { throw std::runtime_error("mine"); };
        CHECK_THROWS_WITH((void)tessellator.tessellate(set.points, options), "mine");
        options.progress = nullptr;
        CHECK(test::check_same(tessellator.tessellate(set.points, options), test::run(set), set.points, 1e-5) == "");
    }
}

// A program with Vulkan of its own, as a host of votess would be: see `usage` in arguments.cpp.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "check/check.hpp"
#include "frames.hpp"
#include "png.hpp"

namespace {

using namespace host;

std::vector<votess::vulkan::Plan> make_plans(const HostDevice& device, const Arguments& arguments) {
    const votess::vulkan::HostDevice handles = device.for_votess(arguments.probe);
    std::vector<votess::vulkan::Plan> plans;
    plans.emplace_back(handles, votess::vulkan::PlanOptions{
                                    .most_seeds = arguments.seeds, .box = {{0, 0, 0}, {1, 1, 1}}, .stride = 4});
    if (arguments.plans == 2) {
        // As different as may be: half of the box, walls in the rows, no geometry, other tuning.
        plans.emplace_back(handles, votess::vulkan::PlanOptions{.most_seeds = arguments.seeds + 100,
                                                                .box = {{0, 0, 0}, {1, 1, 0.5}},
                                                                .stride = 4,
                                                                .geometry = false,
                                                                .list_walls = true,
                                                                .chunk_size = 512,
                                                                .k_init = 12});
    }
    return plans;
}

std::string picture_file(const std::string& folder, std::uint32_t frame) {
    std::string digits = std::to_string(frame);
    if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
    return (std::filesystem::path(folder) / ("frame-" + digits + ".png")).string();
}

// The cells of a frame that is still in its buffers are right, for each plan, and its picture shows those of the first.
void check_frame(const Arguments& arguments, const Frames& frames, const std::vector<votess::vulkan::Plan>& plans,
                 std::uint32_t frame) {
    const std::vector<float> seeds = frames.seeds(frame);
    for (std::size_t p = 0; p < plans.size(); ++p) {
        const Results results = frames.results(frame, p);
        const votess::vulkan::Header& header = results.header;
        const Comparison comparison = compare(plans[p], seeds, results, 1e-5);
        const std::string where = "frame " + std::to_string(frame) + ", plan " + std::to_string(p) + ": ";
        if (!comparison.difference.empty()) throw std::runtime_error(where + comparison.difference);
        // Leaving everything to resolve() would be right too.
        if (header.unresolved > header.seeds / 10 + 10) {
            throw std::runtime_error(where + std::to_string(header.unresolved) + " cells are unresolved");
        }
        std::printf(
            "%s%u seeds, %u certified, %u resolved, %u duplicates, %u outside, %u entries: rows as on the CPU, "
            "volumes within %.1e\n",
            where.c_str(), header.seeds, header.certified, comparison.resolved, header.duplicates, header.outside,
            header.entries, comparison.worst_volume);
    }
    const std::string difference =
        compare_picture(frames.view(frame), arguments.width, seeds, frames.results(frame, 0), frames.cells_seen(frame));
    if (!difference.empty()) throw std::runtime_error("picture: " + difference);
}

void run(const Arguments& arguments, Messages& messages) {
    const HostDevice device({.name = arguments.device, .validate = arguments.validate, .float64 = arguments.float64},
                            messages);
    const std::vector<votess::vulkan::Plan> plans = make_plans(device, arguments);
    Frames frames(
        device, plans,
        {.seeds = arguments.seeds, .width = arguments.width, .height = arguments.height, .samples = arguments.samples});
    const auto finish = [&](std::uint32_t frame) {
        const std::span<const std::byte> picture = frames.wait_for(frame);
        if (arguments.output.empty()) return;
        write_png(picture_file(arguments.output, frame), picture, arguments.width, arguments.height);
    };
    for (std::uint32_t frame = 0; frame < arguments.frames; ++frame) {
        if (frame >= Frames::in_flight) finish(frame - Frames::in_flight);
        frames.submit(frame);
    }
    const std::uint32_t left = arguments.frames - std::min(arguments.frames, Frames::in_flight);
    for (std::uint32_t frame = left; frame < arguments.frames; ++frame) finish(frame);
    std::printf("%s\n", device.properties().deviceName);
    for (std::uint32_t frame = left; frame < arguments.frames; ++frame) {
        check_frame(arguments, frames, plans, frame);
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const Arguments arguments = read_arguments(argc, argv);
        if (arguments.help) {
            std::fputs(usage, stdout);
            return 0;
        }
        if (!arguments.output.empty()) {
            check_png();
            std::filesystem::create_directories(arguments.output);
        }
        Messages messages;
        run(arguments, messages);
        for (const std::string& message : messages.lines()) std::fprintf(stderr, "validation: %s\n", message.c_str());
        return messages.lines().empty() ? 0 : 1;
    } catch (const BadUsage& error) {
        std::fprintf(stderr, "votess_host: %s\n%s", error.what(), usage);
        return 2;
    } catch (const NoDevice& error) {
        std::printf("skipped: %s\n", error.what());
        return 77;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "votess_host: %s\n", error.what());
        return 1;
    }
}

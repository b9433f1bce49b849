#include "arguments.hpp"

#include <charconv>
#include <string_view>

namespace host {
namespace {

std::uint32_t number(std::string_view option, std::string_view text, std::uint32_t least, std::uint32_t most) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value < least || value > most) {
        throw BadUsage(std::string(option) + ": not a number from " + std::to_string(least) + " to " +
                       std::to_string(most) + ": " + std::string(text));
    }
    return value;
}

}  // namespace

const char* const usage =
    "usage: votess_host [options]\n"
    "Seeds move in a shader, votess finds their cells in the same command buffer, and a shader draws them.\n"
    "  --frames N          frames to compute (8)\n"
    "  --seeds N           seeds (2000)\n"
    "  --size WxH          of the pictures (640x480)\n"
    "  --samples N         rays per pixel along each axis (2)\n"
    "  --output DIR        write the pictures there, DIR/frame-0000.png and so on; default: nothing is written\n"
    "  --device NAME|N     part of the name of a Vulkan device, lavapipe, or its index\n"
    "  --plans 1|2         2: a second plan, with other options, in the same command buffers\n"
    "  --validate 0|1|2    1: under the validation layer, whose messages are failures; 2: with missing barriers (0)\n"
    "  --no-float64        make the device without shaderFloat64\n"
    "  --no-probe          give votess no queue\n"
    "Exit codes: 0 the cells of the last two frames are right, 1 they are not or something failed, 2 bad usage, 77 "
    "there is "
    "no\n"
    "such Vulkan device.\n";

Arguments read_arguments(int argc, char** argv) {
    Arguments arguments;
    for (int i = 1; i < argc; ++i) {
        const std::string_view option = argv[i];
        const auto value = [&]() -> std::string_view {
            if (i + 1 == argc) throw BadUsage(std::string(option) + " needs a value");
            return argv[++i];
        };
        if (option == "--frames") {
            arguments.frames = number(option, value(), 1, 1000000);
        } else if (option == "--seeds") {
            arguments.seeds = number(option, value(), 1, 100000000);
        } else if (option == "--samples") {
            arguments.samples = number(option, value(), 1, 16);
        } else if (option == "--plans") {
            arguments.plans = number(option, value(), 1, 2);
        } else if (option == "--size") {
            const std::string_view size = value();
            const std::size_t x = size.find('x');
            if (x == std::string_view::npos) throw BadUsage("--size: not WxH: " + std::string(size));
            arguments.width = number(option, size.substr(0, x), 1, 4096);
            arguments.height = number(option, size.substr(x + 1), 1, 4096);
        } else if (option == "--output") {
            arguments.output = value();
        } else if (option == "--device") {
            arguments.device = value();
        } else if (option == "--validate") {
            arguments.validate = number(option, value(), 0, 2);
        } else if (option == "--no-float64") {
            arguments.float64 = false;
        } else if (option == "--no-probe") {
            arguments.probe = false;
        } else if (option == "--help" || option == "-h") {
            arguments.help = true;
        } else {
            throw BadUsage("unknown option " + std::string(option));
        }
    }
    return arguments;
}

}  // namespace host

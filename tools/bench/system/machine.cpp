// Where and when a run took place, and writing JSON files.
#include "system/machine.hpp"

#include <sys/utsname.h>

#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace bench {
namespace {

struct Machine {
    std::string cpu = "unknown", system = "unknown", compiler, flags;
    unsigned logical_cores = std::thread::hardware_concurrency();
    std::string date;
};

// The value of the first "key<separator>value" line of a file.
std::string value_of(const char* file, std::string_view key, char separator) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with(key)) {
            const std::size_t at = line.find(separator);
            if (at != std::string::npos) {
                const std::size_t first = line.find_first_not_of(" \"", at + 1);
                const std::size_t last = line.find_last_not_of(" \"");
                return first == std::string::npos ? "" : line.substr(first, last - first + 1);
            }
        }
    }
    return "";
}

Machine machine() {
    Machine m;
    if (const std::string cpu = value_of("/proc/cpuinfo", "model name", ':'); !cpu.empty()) {
        m.cpu = cpu;
    }
    utsname name{};
    if (uname(&name) == 0) {
        m.system = std::string(name.sysname) + ' ' + name.machine;
        if (const std::string pretty = value_of("/etc/os-release", "PRETTY_NAME", '='); !pretty.empty()) {
            m.system = pretty + ", " + m.system;
        }
    }
#if defined(__clang__)
    m.compiler = __VERSION__;
#else
    m.compiler = std::string("GCC ") + __VERSION__;
#endif
    m.flags = BENCH_FLAGS;
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    localtime_r(&now, &parts);
    char date[32];
    std::strftime(date, sizeof date, "%Y-%m-%d %H:%M", &parts);
    m.date = date;
    return m;
}

}  // namespace

std::string in_quotes(std::string_view text) {
    std::ostringstream out;
    out << '"';
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            out << '\\' << c;
        } else if (static_cast<unsigned char>(c) < 0x20) {
            out << "\\u00" << std::hex << std::setw(2) << std::setfill('0') << static_cast<int>(c) << std::dec;
        } else {
            out << c;
        }
    }
    out << '"';
    return out.str();
}

std::string machine_json() {
    const Machine m = machine();
    return "{\"cpu\": " + in_quotes(m.cpu) + ", \"logical_cores\": " + std::to_string(m.logical_cores) +
           ", \"system\": " + in_quotes(m.system) + ", \"compiler\": " + in_quotes(m.compiler) +
           ", \"flags\": " + in_quotes(m.flags) + ", \"date\": " + in_quotes(m.date) + '}';
}

void print_machine() {
    const Machine m = machine();
    std::printf("%s, %u logical cores, %s, %s\n%s, flags:%s\n", m.cpu.c_str(), m.logical_cores, m.system.c_str(),
                m.date.c_str(), m.compiler.c_str(), m.flags.c_str());
}

void write_whole(const std::string& file, const std::string& text) {
    const std::string temporary = file + ".part";
    std::ofstream stream(temporary);
    stream << text;
    stream.close();
    std::error_code error;
    if (stream.fail() || (std::filesystem::rename(temporary, file, error), error)) {
        std::filesystem::remove(temporary, error);
        throw std::runtime_error("cannot write " + file);
    }
}

}  // namespace bench

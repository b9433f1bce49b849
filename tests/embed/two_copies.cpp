// Loads two copies of libvotess into one process, beside a Vulkan host that has volk's global function pointers loaded
// for its own device. Both copies must give the same rows, in turns and from two threads at once, while the host goes
// on. Usage: two_copies LIBRARY. Returns 0, 1 on a failure, 77 without lavapipe.
#include <dlfcn.h>
#include <unistd.h>
#include <votess/votess.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "host.hpp"

namespace {

void require(bool condition, const std::string& what) {
    if (!condition) throw std::runtime_error(what);
}

// Throws when the host's device no longer works.
void use(const host::Device& host) {
    host::run_once(host, [](VkCommandBuffer) {});
}

struct Rows {
    std::vector<std::int64_t> indptr;
    std::vector<std::int32_t> indices;
    double volume = 0;
    bool operator==(const Rows& other) const { return indptr == other.indptr && indices == other.indices; }
};

// One copy of the library. It stays loaded because drivers that it opened leave threads behind.
class Copy {
public:
    explicit Copy(const std::filesystem::path& file) : library_(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
        require(library_ != nullptr, "dlopen " + file.string());
    }
    Copy(const Copy&) = delete;
    Copy& operator=(const Copy&) = delete;

    [[nodiscard]] void* address() const { return dlsym(library_, "votess_tessellate"); }

    [[nodiscard]] Rows tessellate(const std::vector<double>& points, const char* device) const {
        votess_options options;
        require(get<decltype(votess_options_init)>("votess_options_init")(&options, sizeof options) == VOTESS_OK,
                "options");
        options.device = device;
        options.has_box = 1;
        for (int axis = 0; axis < 3; ++axis) {
            options.box_lower[axis] = 0;
            options.box_upper[axis] = 1;
        }
        votess_result* result = nullptr;
        if (get<decltype(votess_tessellate)>("votess_tessellate")(nullptr, points.data(), points.size() / 3, &options,
                                                                  &result) != VOTESS_OK) {
            throw std::runtime_error(std::string(device) + ": " +
                                     get<decltype(votess_last_error)>("votess_last_error")());
        }
        Rows rows{array<std::int64_t>(result, "indptr"), array<std::int32_t>(result, "indices"), 0};
        const auto volumes = array<double>(result, "volumes");
        rows.volume = std::accumulate(volumes.begin(), volumes.end(), 0.0);
        get<decltype(votess_result_free)>("votess_result_free")(result);
        return rows;
    }

private:
    // The header declares the type; this program does not link the function.
    template <class Function>
    Function* get(const char* name) const {
        void* symbol = dlsym(library_, name);
        require(symbol != nullptr, std::string("no symbol ") + name);
        return reinterpret_cast<Function*>(symbol);
    }
    template <class T>
    [[nodiscard]] std::vector<T> array(const votess_result* result, const char* name) const {
        votess_array array;
        require(get<decltype(votess_result_array)>("votess_result_array")(result, name, &array) == VOTESS_OK, name);
        const T* first = static_cast<const T*>(array.data);
        return std::vector<T>(first, first + array.length);
    }

    void* library_;
};

// A temporary folder.
struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("votess_two_copies_" + std::to_string(getpid()));
    Folder() { std::filesystem::create_directory(path); }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
};

void run(const char* library, const host::Device& host) {
    const Folder folder;
    const std::filesystem::path first = folder.path / "libfirst.so", second = folder.path / "libsecond.so";
    std::filesystem::copy_file(library, first);
    std::filesystem::copy_file(library, second);
    const Copy a(first), b(second);
    require(a.address() != b.address(), "the two files were loaded as one library");

    std::mt19937_64 random(7);
    std::vector<double> points(3 * 2000);
    for (double& x : points) x = static_cast<double>(random() >> 11) * 0x1p-53;

    const Rows expected = a.tessellate(points, "cpu");
    require(expected.indices.size() > 10 * points.size() / 3 && std::abs(expected.volume - 1) < 1e-12,
            "the rows of the CPU are wrong");
    const auto check = [&](const Copy& copy, const char* device) {
        const Rows rows = copy.tessellate(points, device);
        require(rows == expected, std::string("other rows from ") + device);
        require(std::abs(rows.volume - 1) < 1e-5, std::string("other volumes from ") + device);
    };
    for (const char* device : {"lavapipe", "cpu", "lavapipe"}) {
        check(a, device);
        check(b, device);
    }
    // Each copy in a thread, then both threads on the other's copy.
    for (const bool swapped : {false, true}) {
        std::array<std::string, 2> failures;
        const auto work = [&](const Copy& copy, bool device_first, std::string& failure) {
            try {
                for (int turn = 0; turn < 2; ++turn) check(copy, (turn % 2 == 0) == device_first ? "lavapipe" : "cpu");
            } catch (const std::exception& error) {
                failure = error.what();
            }
        };
        std::thread one(work, std::cref(swapped ? b : a), true, std::ref(failures[0]));
        std::thread two(work, std::cref(swapped ? a : b), swapped, std::ref(failures[1]));
        std::string host_failure;
        try {
            for (int turn = 0; turn < 100; ++turn) use(host);
        } catch (const std::exception& error) {
            host_failure = error.what();
        }
        one.join();
        two.join();
        require(host_failure.empty(), "the host: " + host_failure);
        for (const std::string& failure : failures) require(failure.empty(), "in a thread: " + failure);
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: two_copies LIBRARY\n");
        return 2;
    }
    try {
        const host::Device host("lavapipe", nullptr);
        use(host);
        run(argv[1], host);
        use(host);
    } catch (const host::NoDevice& error) {
        std::printf("skipped: %s\n", error.what());
        return 77;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "two_copies: %s\n", error.what());
        return 1;
    }
    std::printf("two copies and the host's volk: the same rows\n");
    return 0;
}

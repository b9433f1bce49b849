// Voronoi cells by Vulkan for a program in CUDA, without a copy. votess makes the cells of a frame. A kernel of CUDA
// reads their rows in the same memory, and moves each seed to the centroid of its cell. A timeline semaphore orders
// both, so the host submits step after step without a wait.
//
// Returns 0; 1 on an error; 77 without a device of CUDA. CMakeLists.txt says how to build it.
#include <cuda_runtime.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <random>
#include <span>

#include "exported_frame.hpp"
#include "move.hpp"

constexpr std::uint32_t count = 100000;  // seeds
constexpr int steps = 20;

void check(cudaError_t result, const char* call) {
    if (result != cudaSuccess) throw std::runtime_error(std::string(call) + ": " + cudaGetErrorString(result));
}

Uuid uuid_of(int device) {
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, device), "cudaGetDeviceProperties");
    if (properties.timelineSemaphoreInteropSupported == 0)
        throw std::runtime_error("this device of CUDA cannot import timeline semaphores");
    return std::bit_cast<Uuid>(properties.uuid);
}

// The exported buffer and semaphore in CUDA.
class Imported {
public:
    explicit Imported(const ExportedFrame& frame) {
        cudaExternalMemoryHandleDesc memory{};
        memory.type = cudaExternalMemoryHandleTypeOpaqueFd;
        memory.handle.fd = frame.memory_descriptor();
        memory.size = frame.memory_size();
        memory.flags = cudaExternalMemoryDedicated;  // as it was allocated
        check(cudaImportExternalMemory(&memory_, &memory), "cudaImportExternalMemory");
        cudaExternalMemoryBufferDesc all{};
        all.size = frame.places().end;
        void* address = nullptr;
        check(cudaExternalMemoryGetMappedBuffer(&address, memory_, &all), "cudaExternalMemoryGetMappedBuffer");
        begin_ = static_cast<std::byte*>(address);

        cudaExternalSemaphoreHandleDesc semaphore{};
        semaphore.type = cudaExternalSemaphoreHandleTypeTimelineSemaphoreFd;
        semaphore.handle.fd = frame.semaphore_descriptor();
        check(cudaImportExternalSemaphore(&semaphore_, &semaphore), "cudaImportExternalSemaphore");
    }
    ~Imported() {
        cudaDeviceSynchronize();
        cudaDestroyExternalSemaphore(semaphore_);
        cudaFree(begin_);
        cudaDestroyExternalMemory(memory_);
    }
    Imported(const Imported&) = delete;
    Imported& operator=(const Imported&) = delete;

    template <class T>
    [[nodiscard]] T* at(vk::DeviceSize place) const {
        return reinterpret_cast<T*>(begin_ + place);
    }
    // Enqueue a wait until the semaphore has the value, and an order to set it.
    void wait(std::uint64_t value) const {
        cudaExternalSemaphoreWaitParams params{};
        params.params.fence.value = value;
        check(cudaWaitExternalSemaphoresAsync(&semaphore_, &params, 1), "cudaWaitExternalSemaphoresAsync");
    }
    void signal(std::uint64_t value) const {
        cudaExternalSemaphoreSignalParams params{};
        params.params.fence.value = value;
        check(cudaSignalExternalSemaphoresAsync(&semaphore_, &params, 1), "cudaSignalExternalSemaphoresAsync");
    }

private:
    cudaExternalMemory_t memory_ = nullptr;
    cudaExternalSemaphore_t semaphore_ = nullptr;
    std::byte* begin_ = nullptr;
};

// Returns an array of CUDA in the memory of the host.
template <class T>
std::vector<T> copied(const T* from, std::size_t size) {
    std::vector<T> to(size);
    check(cudaMemcpy(to.data(), from, size * sizeof(T), cudaMemcpyDeviceToHost), "cudaMemcpy");
    return to;
}

// Returns the standard deviation of the volumes in units of their mean.
double spread(const std::vector<float4>& geometry) {
    double sum = 0;
    for (const float4& g : geometry) sum += std::pow(static_cast<double>(g.w) * count - 1, 2);
    return std::sqrt(sum / count);
}

// Compares the last rows with those of the CPU.
bool equals_cpu(const std::vector<float4>& seeds, const std::vector<votess::vulkan::Cell>& cells,
                const std::vector<int>& indices, const votess::Box& box) {
    std::vector<double> points;
    for (const float4& seed : seeds) points.insert(points.end(), {seed.x, seed.y, seed.z});
    votess::Options options;
    options.box = box;
    const votess::Tessellation expected = votess::tessellate(points, options);
    std::uint32_t certified = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (cells[i].status != static_cast<std::uint32_t>(votess::CellStatus::certified)) continue;
        ++certified;
        if (!std::ranges::equal(expected.neighbors(i),
                                std::span(indices).subspan(cells[i].row_begin, cells[i].row_length)))
            return false;
    }
    std::printf("%u of %u cells certified on the GPU\n", certified, count);
    return certified > 0.99 * count;
}

int run() {
    int devices = 0;
    if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
        std::printf("cuda_frames: no device of CUDA\n");
        return 77;
    }
    check(cudaSetDevice(0), "cudaSetDevice");
    const votess::Box box{{0, 0, 0}, {1, 1, 1}};
    const ExportedFrame frame(count, box, uuid_of(0));
    const Imported imported(frame);
    const auto& places = frame.places();
    const Rows rows{imported.at<float4>(places.seeds), imported.at<const uint4>(places.cells),
                    imported.at<const int>(places.indices), imported.at<const float4>(places.geometry), count};

    std::vector<float4> seeds(count);
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (float4& seed : seeds) seed = {uniform(random), uniform(random), uniform(random), 0};
    check(cudaMemcpy(rows.seeds, seeds.data(), count * sizeof(float4), cudaMemcpyHostToDevice), "cudaMemcpy");
    unsigned* pairs = nullptr;
    check(cudaMalloc(&pairs, sizeof *pairs), "cudaMalloc");
    check(cudaMemset(pairs, 0, sizeof *pairs), "cudaMemset");

    // Odd values: CUDA is done with the seeds. Even ones: the rows are there.
    std::uint64_t value = 1;
    imported.signal(value);
    for (int step = 0; step <= steps; ++step) {
        frame.submit(value, value + 1);
        imported.wait(value + 1);
        value += 2;
        if (step == steps) break;
        check(move_to_centroids(rows, pairs, nullptr), "move_to_centroids");
        imported.signal(value);
    }

    const double deviation = spread(copied(rows.geometry, count));
    std::printf("%d steps; %.2f neighbors a cell; volumes differ by %.2f of their mean, at first by 0.42\n", steps,
                2.0 * copied(pairs, 1).front() / steps / count, deviation);
    check(cudaFree(pairs), "cudaFree");
    const auto* const cells = imported.at<const votess::vulkan::Cell>(places.cells);
    const auto* const header = imported.at<const votess::vulkan::Header>(places.header);
    const bool same = equals_cpu(copied(rows.seeds, count), copied(cells, count),
                                 copied(rows.indices, copied(header, 1).front().entries), box);
    std::printf("rows %s those of the CPU\n", same ? "equal" : "differ from");
    return same && deviation < 0.3 ? 0 : 1;
}

int main() {
    try {
        return run();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "cuda_frames: %s\n", error.what());
        return 1;
    }
}

// A command buffer that is recorded, submitted and waited for, many times.
#pragma once

#include <chrono>
#include <cstdint>

#include "gpu/vulkan/recorder.hpp"

namespace votess::gpu::vulkan {

class Commands : public Recorder {
public:
    // timestamps: the most that one recording may hold; 0 = none.
    explicit Commands(Device& device, std::uint32_t timestamps = 0);
    ~Commands();  // waits for submitted work

    void begin();  // waits for the previous submission and drops its recording
    void end();

    // Records the time at which all earlier commands are done. Returns its index for seconds(); `no_timestamp` where
    // timestamps are unsupported or the pool is full.
    static constexpr std::uint32_t no_timestamp = UINT32_MAX;
    std::uint32_t timestamp();
    // Returns the time between two timestamps of the finished submission; 0 when one of them is no_timestamp.
    [[nodiscard]] double seconds(std::uint32_t from, std::uint32_t to) const;

    // Returns the buffer, while it is recorded.
    [[nodiscard]] VkCommandBuffer handle() const { return commands_; }

    void submit();
    // Begins, records by record(), ends and submits.
    void submit(const auto& record) {
        begin();
        record();
        end();
        submit();
    }
    // Returns whether nothing is running. Throws device_lost as the waits do.
    [[nodiscard]] bool finished();
    // Waits at most `timeout`. Returns whether the work has finished.
    bool wait_for(std::chrono::nanoseconds timeout);
    void wait();

private:
    enum class State { idle, recording, ready, running };

    void expect(State state, const char* call) const;
    void make_objects(std::uint32_t timestamps);
    void destroy() noexcept;

    State state_ = State::idle;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    VkQueryPool queries_ = VK_NULL_HANDLE;
    std::uint32_t query_capacity_ = 0;
    std::uint32_t query_count_ = 0;
};

}  // namespace votess::gpu::vulkan

// The host's compute shader: seeds drift along a flow.
#pragma once

#include "bindings.hpp"
#include "shaders/push.h"

namespace host {

class Moving {
public:
    Moving(const HostDevice& device, std::uint32_t max_sets);

    // source, target: vec4 a seed
    [[nodiscard]] VkDescriptorSet set(VkBuffer source, VkBuffer target) const;
    void record(VkCommandBuffer commands, VkDescriptorSet set, const MovePush& push) const;

private:
    Bindings bindings_;
    Owned<VkPipeline> pipeline_;
};

}  // namespace host

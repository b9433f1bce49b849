// The graphics pipelines of pictures.
#pragma once

#include "picture/vulkan/images.hpp"
#include "shared/picture.h"

namespace votess::gpu {

struct Pipelines {
    OwnedSampler sampler;
    OwnedSetLayout set_layout;  // binding 0: surfaces, 1: occlusion
    OwnedPipelineLayout layout;
    OwnedPipeline surface, occlusion, solid, flat, stroke;

    Pipelines(vulkan::Device& device, const RenderPasses& passes);
};

}  // namespace votess::gpu

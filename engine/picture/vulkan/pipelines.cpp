#include "picture/vulkan/pipelines.hpp"

#include <cstddef>
#include <span>
#include <vector>

#include "picture/scene.hpp"
#include "shaders.hpp"

namespace votess::gpu {
namespace {

using picture::FillVertex;
using picture::Stroke;
using vulkan::check;

OwnedShader shader(vulkan::Device& device, std::span<const std::uint32_t> spirv) {
    VkShaderModuleCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    info.codeSize = spirv.size_bytes();
    info.pCode = spirv.data();
    OwnedShader module(device);
    check(device.table().vkCreateShaderModule(device.handle(), &info, nullptr, module.out()), "vkCreateShaderModule");
    return module;
}

// What a pipeline reads from its buffer; every device has these formats.
struct Attributes {
    VkVertexInputRate rate = VK_VERTEX_INPUT_RATE_VERTEX;
    std::uint32_t stride = 0;
    std::vector<VkVertexInputAttributeDescription> fields;
};

Attributes fill_attributes() {
    return {VK_VERTEX_INPUT_RATE_VERTEX,
            sizeof(FillVertex),
            {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(FillVertex, position)},
             {1, 0, VK_FORMAT_R8G8B8A8_SNORM, offsetof(FillVertex, normal)},
             {2, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(FillVertex, color)},
             {3, 0, VK_FORMAT_R32_SFLOAT, offsetof(FillVertex, edge)}}};
}

Attributes place_attributes() {
    Attributes places = fill_attributes();
    places.fields.resize(1);
    return places;
}

Attributes stroke_attributes() {
    return {VK_VERTEX_INPUT_RATE_INSTANCE,
            sizeof(Stroke),
            {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Stroke, from)},
             {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Stroke, to)},
             {2, 0, VK_FORMAT_R32_SFLOAT, offsetof(Stroke, half_width)},
             {3, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(Stroke, color)}}};
}

struct Shape {
    const char* name;
    std::span<const std::uint32_t> vertex, fragment;
    VkRenderPass pass;
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
    Attributes attributes = {};
    bool depth_test = false, depth_write = false, blend = false;
};

OwnedPipeline pipeline(vulkan::Device& device, VkPipelineLayout layout, const Shape& shape) {
    const OwnedShader vertex = shader(device, shape.vertex), fragment = shader(device, shape.fragment);
    VkPipelineShaderStageCreateInfo stages[2]{};
    for (auto& stage : stages) {
        stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        stage.pName = "main";
    }
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
    stages[0].module = vertex.get();
    stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[1].module = fragment.get();

    const VkVertexInputBindingDescription buffer{0, shape.attributes.stride, shape.attributes.rate};
    VkPipelineVertexInputStateCreateInfo input{};
    input.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;
    input.vertexBindingDescriptionCount = shape.attributes.fields.empty() ? 0 : 1;
    input.pVertexBindingDescriptions = &buffer;
    input.vertexAttributeDescriptionCount = static_cast<std::uint32_t>(shape.attributes.fields.size());
    input.pVertexAttributeDescriptions = shape.attributes.fields.data();

    VkPipelineInputAssemblyStateCreateInfo assembly{};
    assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;

    VkPipelineViewportStateCreateInfo viewport{};
    viewport.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
    viewport.viewportCount = 1;
    viewport.scissorCount = 1;

    VkPipelineRasterizationStateCreateInfo raster{};
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
    raster.lineWidth = 1;

    VkPipelineMultisampleStateCreateInfo multisample{};
    multisample.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    multisample.rasterizationSamples = shape.samples;

    VkPipelineDepthStencilStateCreateInfo depth{};
    depth.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO;
    depth.depthTestEnable = shape.depth_test;
    depth.depthWriteEnable = shape.depth_write;
    depth.depthCompareOp = VK_COMPARE_OP_LESS_OR_EQUAL;

    VkPipelineColorBlendAttachmentState blend{};
    blend.blendEnable = shape.blend;
    blend.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA;
    blend.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    blend.colorBlendOp = VK_BLEND_OP_ADD;
    blend.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    blend.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    blend.alphaBlendOp = VK_BLEND_OP_ADD;
    blend.colorWriteMask =
        VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    VkPipelineColorBlendStateCreateInfo blending{};
    blending.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
    blending.attachmentCount = 1;
    blending.pAttachments = &blend;

    const VkDynamicState changing[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{};
    dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = changing;

    VkGraphicsPipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &multisample;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blending;
    info.pDynamicState = &dynamic;
    info.layout = layout;
    info.renderPass = shape.pass;
    OwnedPipeline made(device);
    check(device.table().vkCreateGraphicsPipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, made.out()),
          "vkCreateGraphicsPipelines");
    device.name(made.get(), VK_OBJECT_TYPE_PIPELINE, shape.name);
    return made;
}

OwnedSampler make_sampler(vulkan::Device& device) {
    VkSamplerCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
    info.addressModeU = info.addressModeV = info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    OwnedSampler sampler(device);
    check(device.table().vkCreateSampler(device.handle(), &info, nullptr, sampler.out()), "vkCreateSampler");
    return sampler;
}

OwnedSetLayout make_set_layout(vulkan::Device& device) {
    VkDescriptorSetLayoutBinding bindings[2]{};
    for (std::uint32_t i = 0; i < 2; ++i) {
        bindings[i] = {i, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    }
    VkDescriptorSetLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    info.bindingCount = 2;
    info.pBindings = bindings;
    OwnedSetLayout layout(device);
    check(device.table().vkCreateDescriptorSetLayout(device.handle(), &info, nullptr, layout.out()),
          "vkCreateDescriptorSetLayout");
    return layout;
}

OwnedPipelineLayout make_layout(vulkan::Device& device, VkDescriptorSetLayout set) {
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(PicturePush)};
    VkPipelineLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    info.setLayoutCount = 1;
    info.pSetLayouts = &set;
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &push;
    OwnedPipelineLayout layout(device);
    check(device.table().vkCreatePipelineLayout(device.handle(), &info, nullptr, layout.out()),
          "vkCreatePipelineLayout");
    return layout;
}

}  // namespace

Pipelines::Pipelines(vulkan::Device& device, const RenderPasses& passes)
    : sampler(make_sampler(device)),
      set_layout(make_set_layout(device)),
      layout(make_layout(device, set_layout.get())) {
    const auto make = [&](const Shape& shape) { return pipeline(device, layout.get(), shape); };
    surface = make({.name = "picture_depth",
                    .vertex = shaders::picture_place_vertex,
                    .fragment = shaders::picture_depth,
                    .pass = passes.surface.get(),
                    .attributes = place_attributes(),
                    .depth_test = true,
                    .depth_write = true});
    occlusion = make({.name = "picture_occlusion",
                      .vertex = shaders::picture_whole,
                      .fragment = shaders::picture_occlusion,
                      .pass = passes.occlusion.get()});
    Shape fill{.name = "picture_solid",
               .vertex = shaders::picture_fill_vertex,
               .fragment = shaders::picture_solid,
               .pass = passes.color.get(),
               .samples = Formats::samples,
               .attributes = fill_attributes(),
               .depth_test = true,
               .depth_write = true};
    solid = make(fill);
    fill.name = "picture_flat";
    fill.fragment = shaders::picture_flat;
    flat = make(fill);
    stroke = make({.name = "picture_stroke",
                   .vertex = shaders::picture_stroke_vertex,
                   .fragment = shaders::picture_stroke,
                   .pass = passes.color.get(),
                   .samples = Formats::samples,
                   .attributes = stroke_attributes(),
                   .depth_test = true,
                   .blend = true});
}

}  // namespace votess::gpu

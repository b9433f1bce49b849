// What the shaders are told of a frame; its buffers they declare themselves.
layout(push_constant) uniform Push {
    uint side;    // the seeds are side^3
    float time;   // in seconds
    float width;  // of the picture in pixels, and its height
} push;

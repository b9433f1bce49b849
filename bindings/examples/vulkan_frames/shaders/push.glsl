// Push constants of all shaders; struct Push in main.cpp has the same members.
layout(push_constant) uniform Push {
    uint count;    // seeds
    uint samples;  // rays a pixel along each axis
    float time;    // seconds
    float step;    // seconds since the previous frame; 0: place the seeds
    vec2 size;     // of the picture, pixels
} push;

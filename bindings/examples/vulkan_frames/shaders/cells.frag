// Draws the cells in perspective, colored by volume, one octant cut open. Rays walk from cell to cell. A ray leaves a
// cell through the nearest bisector, the plane halfway to a neighbor, and enters the neighbor's cell. So a ray needs
// the rows of neighbors only.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "push.glsl"
layout(std430, binding = 0) readonly buffer Seeds { vec4 seeds[]; };
layout(std430, binding = 1) readonly buffer Cells { uvec4 cells[]; };       // status, row_begin, row_length, faces
layout(std430, binding = 2) readonly buffer Indices { int indices[]; };     // rows of neighbors
layout(std430, binding = 3) readonly buffer Geometry { vec4 geometry[]; };  // centroid relative to the seed, volume
layout(location = 0) out vec4 color;

const uint CERTIFIED = 0u;
const int NONE = -1;
const float FAR = 1e4;

bool certified(int cell) {
    return cells[cell].x == CERTIFIED;
}

// Pending cells, which wait for Plan::resolve(), have no row; rays end there.
bool solid(int cell) {
    const vec3 p = seeds[cell].xyz;
    return !certified(cell) || !(p.x > 0.5 && p.y < 0.5 && p.z > 0.5);
}

float distance_squared(vec3 a, vec3 b) {
    return dot(a - b, a - b);
}

// Returns the cell that holds the point, NONE if no cell is certified where it looks first. It starts at the nearest of
// a few seeds and walks to a neighbor while one is nearer. It may end one cell away next to a pending cell.
int locate(vec3 point) {
    int here = NONE;
    float nearest = FAR;
    for (int i = 0; i < int(push.count); i += int(push.count) / 20 + 1) {
        const float d = distance_squared(point, seeds[i].xyz);
        if (d < nearest && certified(i)) {
            nearest = d;
            here = i;
        }
    }
    if (here == NONE) return NONE;
    for (int last = NONE; last != here;) {
        last = here;
        const uvec4 cell = cells[here];
        for (uint k = cell.y; k < cell.y + cell.z; ++k) {
            const int j = indices[k];
            const float d = distance_squared(point, seeds[j].xyz);
            if (d < nearest && certified(j)) {
                nearest = d;
                here = j;
            }
        }
    }
    return here;
}

struct Hit {
    int cell;    // the first solid one; NONE: the ray meets none
    int before;  // the cell that the ray came from; NONE: it starts in `cell`
    float t;     // distance along the ray
};

// Follows a ray from its origin in `cell` up to distance `end`.
Hit trace(int cell, vec3 origin, vec3 direction, float end) {
    Hit hit = Hit(cell, NONE, 0.0);
    for (uint steps = 0u; steps < push.count && hit.cell != NONE && !solid(hit.cell); ++steps) {
        const uvec4 row = cells[hit.cell];
        const vec3 seed = seeds[hit.cell].xyz;
        hit.before = hit.cell;
        hit.cell = NONE;
        float nearest = end;
        for (uint k = row.y; k < row.y + row.z; ++k) {
            const vec3 normal = seeds[indices[k]].xyz - seed;
            const float slope = dot(normal, direction);
            const float t = dot(normal, 0.5 * normal + seed - origin) / slope;
            if (slope > 0.0 && t < nearest) {
                nearest = t;
                hit.cell = indices[k];
            }
        }
        hit.t = max(hit.t, nearest);
    }
    return hit;
}

// Returns where a ray is inside the unit box: from x to y, if x < y.
vec2 inside_box(vec3 origin, vec3 direction) {
    const vec3 slope = mix(direction, vec3(1e-9), lessThan(abs(direction), vec3(1e-9)));
    const vec3 a = -origin / slope, b = (1.0 - origin) / slope;
    const vec3 near = min(a, b), far = max(a, b);
    return vec2(max(max(near.x, near.y), max(near.z, 0.0)), min(min(far.x, far.y), min(far.z, FAR)));
}

// Returns the outward normal of the wall that the point lies on.
vec3 wall_normal(vec3 point) {
    const vec3 from_middle = point - 0.5, size = abs(from_middle);
    const float largest = max(size.x, max(size.y, size.z));
    return sign(from_middle) * (size.x == largest ? vec3(1, 0, 0) : size.y == largest ? vec3(0, 1, 0) : vec3(0, 0, 1));
}

// Returns the distance from a point of a face to the face's nearest edge: the next bisector or wall in the face's plane.
float to_edge(int cell, int other, vec3 point, vec3 normal) {
    float nearest = FAR;
    const vec3 to_wall = min(point, 1.0 - point) / sqrt(max(1.0 - normal * normal, vec3(1e-6)));
    for (int axis = 0; axis < 3; ++axis)
        if (abs(normal[axis]) < 0.9999) nearest = min(nearest, to_wall[axis]);
    const uvec4 row = cells[cell];
    const vec3 seed = seeds[cell].xyz;
    for (uint k = row.y; k < row.y + row.z; ++k) {
        const vec3 to = seeds[indices[k]].xyz - seed;
        const float slope = length(to - dot(to, normal) * normal);
        if (indices[k] != other && slope > 1e-4 * length(to))
            nearest = min(nearest, dot(to, seed + 0.5 * to - point) / slope);
    }
    return nearest;
}

// Each doubling of the volume is a quarter of the scale, whose middle is the mean volume. Linear colors.
vec3 color_of_volume(float volume) {
    const vec3 scale[5] = vec3[](vec3(0.040, 0.024, 0.150), vec3(0.020, 0.145, 0.330), vec3(0.110, 0.440, 0.400),
                                 vec3(0.900, 0.560, 0.170), vec3(0.740, 0.110, 0.080));
    const float x = clamp(0.5 + 0.25 * log2(volume * float(push.count)), 0.0, 1.0) * 4.0;
    const int step = min(int(x), 3);
    return mix(scale[step], scale[step + 1], x - float(step));
}

// Whether a ray from a face outwards meets no solid cell within `reach`.
bool is_open(Hit hit, vec3 point, vec3 direction, float reach) {
    if (hit.before == NONE) return true;  // the face lies on a wall
    return trace(hit.before, point, direction, min(inside_box(point, direction).y, reach)).cell == NONE;
}

// Returns the color of a surface under a lamp and a sky that near cells darken. `pixel`: a pixel's width there.
vec3 shade(Hit hit, vec3 point, vec3 normal, vec3 lamp, float pixel, uint sample_id) {
    // A sample looks at one direction of the sky; the golden angle spreads the samples evenly.
    const float turn = 2.39996323 * float(sample_id);
    const float share = (float(sample_id) + 0.5) / float(push.samples * push.samples);
    const vec3 disk = vec3(sqrt(share) * cos(turn), sqrt(share) * sin(turn), sqrt(1.0 - share));
    const vec3 side = normalize(cross(normal, abs(normal.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0)));
    const float sky = is_open(hit, point, mat3(side, cross(normal, side), normal) * disk, 0.2) ? 1.0 : 0.3;
    const vec3 light = normalize(lamp + 0.05 * vec3(disk.xy, disk.x - disk.y));  // soft shadows
    const float facing = dot(normal, light);
    const float lit = facing > 0.0 && is_open(hit, point, light, FAR) ? facing : 0.0;
    const vec3 arriving = 0.72 * sky * (0.7 + 0.3 * normal.z) * vec3(0.88, 0.94, 1.0) + lit * vec3(1.0, 0.95, 0.86);
    if (!certified(hit.cell)) return 0.35 * arriving;
    const float edge = smoothstep(0.6 * pixel, 1.4 * pixel, to_edge(hit.cell, hit.before, point, normal));
    return mix(0.16, 1.0, edge) * color_of_volume(geometry[hit.cell].w) * arriving;
}

// Returns the linear color at a place of the picture: 0 is its middle, y runs from -1 to 1.
vec3 look(vec2 at, uint sample_id) {
    const float turn = -0.95 + 0.3 * sin(0.3 * push.time), half_view = 0.262;
    const vec3 to_eye = vec3(3.1 * cos(turn), 3.1 * sin(turn), 1.55), eye = vec3(0.5, 0.5, 0.49) + to_eye;
    const vec3 forward = normalize(-to_eye), right = normalize(cross(forward, vec3(0, 0, 1)));
    const vec3 up = cross(right, forward);
    const vec3 direction = normalize(forward + half_view * (at.x * right - at.y * up));
    const vec3 lamp = normalize(vec3(0.55 * to_eye.xy - 1.1 * right.xy, 2.6));

    const vec2 within = inside_box(eye, direction);
    // From the box on, where float32 is finer than from the eye.
    const vec3 start = eye + within.x * direction;
    const int first = within.x < within.y ? locate(start) : NONE;
    Hit hit = Hit(NONE, NONE, 0.0);
    if (first != NONE) hit = trace(first, start, direction, within.y - within.x);
    if (hit.cell == NONE)
        return mix(vec3(0.93, 0.95, 0.97), vec3(0.55, 0.63, 0.72),
                   clamp(0.15 + 0.55 * length(at - vec2(0.0, 0.1)), 0.0, 1.0));
    const vec3 point = start + hit.t * direction;
    const vec3 normal =
        hit.before == NONE ? wall_normal(point) : normalize(seeds[hit.before].xyz - seeds[hit.cell].xyz);
    return shade(hit, point, normal, lamp, 2.0 * half_view / push.size.y * (within.x + hit.t), sample_id);
}

void main() {
    vec3 sum = vec3(0.0);
    for (uint s = 0u; s < push.samples * push.samples; ++s) {
        const vec2 inside_pixel = (vec2(s % push.samples, s / push.samples) + 0.5) / float(push.samples);
        sum += look((2.0 * (floor(gl_FragCoord.xy) + inside_pixel) - push.size) / push.size.y, s);
    }
    color = vec4(pow(sum / float(push.samples * push.samples), vec3(1.0 / 2.2)), 1.0);
}

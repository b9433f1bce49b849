// Rays through the cells, in the buffers that votess wrote. A ray leaves a cell through the nearest bisector between
// its seed and a neighbor, and is in that neighbor's cell then. Needs push.count and push.cut.

layout(std430, binding = 0) readonly buffer Seeds { vec4 seeds[]; };
layout(std430, binding = 1) readonly buffer Cells { uvec4 cells[]; };  // status, row_begin, row_length, faces
layout(std430, binding = 2) readonly buffer Indices { int indices[]; };
layout(std430, binding = 3) readonly buffer Geometry { vec4 geometry[]; };  // centroid from the seed, volume

const uint CERTIFIED = 0u;
const uint MOST_STEPS = 1000u;  // of a walk or a ray
const int NONE = -1;
const int UNKNOWN = -2;  // no cell at all is certified

bool certified(int cell) {
    return cells[cell].x == CERTIFIED;
}

// Cells that are not certified have no row, so that rays end there.
bool solid(int cell) {
    if (!certified(cell)) return true;
    const bool beyond = seeds[cell].x > push.cut.x && seeds[cell].y < push.cut.y && seeds[cell].z > push.cut.z;
    return !beyond && geometry[cell].w <= push.cut.w;
}

float distance_squared(vec3 a, vec3 b) {
    const vec3 d = a - b;
    return dot(d, d);
}

// The cell that holds a point: from seed to the neighbor nearest to the point until none is nearer. Walks over cells
// with rows only; NONE where there is none.
int locate(vec3 point) {
    int here = 0;
    while (here < int(push.count) && !certified(here)) ++here;
    if (here == int(push.count)) return NONE;
    float nearest = distance_squared(point, seeds[here].xyz);
    int without_row = NONE;
    for (uint steps = 0u; steps < MOST_STEPS; ++steps) {
        const uvec4 cell = cells[here];
        const int last = here;
        float nearest_without_row = nearest;
        without_row = NONE;
        for (uint e = cell.y; e < cell.y + cell.z; ++e) {
            const int j = indices[e];
            if (j < 0) continue;  // a wall
            const float d = distance_squared(point, seeds[j].xyz);
            if (certified(j)) {
                if (d < nearest) {
                    nearest = d;
                    here = j;
                }
            } else if (d < nearest_without_row) {
                nearest_without_row = d;
                without_row = j;
            }
        }
        if (here == last) break;
    }
    return without_row != NONE ? without_row : here;
}

struct Hit {
    int cell;     // NONE: the ray left the box
    int from;     // the cell before it; NONE: the ray came in through a wall
    float t;      // where on the ray
};

// Follows a ray that is in `cell` at its origin to the first solid cell before `end`.
Hit trace(int cell, vec3 origin, vec3 direction, float end) {
    Hit hit = Hit(NONE, NONE, 0.0);
    for (uint steps = 0u; steps < MOST_STEPS; ++steps) {
        if (solid(cell)) {
            hit.cell = cell;
            return hit;
        }
        const uvec4 row = cells[cell];
        const vec3 seed = seeds[cell].xyz;
        float nearest = end;
        int next = NONE;
        for (uint e = row.y; e < row.y + row.z; ++e) {
            const int j = indices[e];
            if (j < 0) continue;
            const vec3 normal = seeds[j].xyz - seed;
            const float slope = dot(normal, direction);
            if (slope <= 0.0) continue;
            const float t = dot(normal, 0.5 * normal + (seed - origin)) / slope;
            if (t < nearest) {
                nearest = t;
                next = j;
            }
        }
        if (next == NONE) return hit;
        hit.t = max(hit.t, nearest);
        hit.from = cell;
        cell = next;
    }
    return hit;
}

// From a point of a face, whose unit normal is given, to its nearest edge: where the next bisector or wall meets it.
float to_edge(int cell, int other, vec3 point, vec3 normal) {
    float nearest = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const float slope = sqrt(1.0 - normal[axis] * normal[axis]);
        if (slope > 1e-3) nearest = min(nearest, min(point[axis], 1.0 - point[axis]) / slope);
    }
    const uvec4 row = cells[cell];
    const vec3 seed = seeds[cell].xyz;
    for (uint e = row.y; e < row.y + row.z; ++e) {
        const int j = indices[e];
        if (j < 0 || j == other) continue;
        const vec3 n = seeds[j].xyz - seed;
        const float slope = length(n - dot(n, normal) * normal);
        if (slope > 1e-4 * length(n)) nearest = min(nearest, dot(n, seed + 0.5 * n - point) / slope);
    }
    return nearest;
}

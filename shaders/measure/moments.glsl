// What the corners of a cell add up to, and the promise for its volume, centroid and areas.
//
// With R the farthest vertex, rounding to units moves the faces of a cell by at most m = quantum (R + 1)
// (clip/filter.glsl). The volume changes by m times the surface, which is at most that of the ball around it, 4 pi R^2.
//
// In a power diagram the error of the centroid must be below twice the tolerance times the cell's size. The move from the
// center to the seed rounds the centroid by a few units in the last place of the tilt.
#ifndef VOTESS_MEASURE_MOMENTS_GLSL
#define VOTESS_MEASURE_MOMENTS_GLSL

#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "measure/exact_planes.glsl"
#include "numbers/number.glsl"

struct Moments {
    Number sum;          // six volumes
    Vector first;        // and 24 times their centroids
    float error;         // a bound of the roundings, in the unit of rounding_error()
    float area_error;    // of all areas together, where that of the volume does not bound it
    float farthest;      // R^2
    float extent;        // the same of the cell alone, from where it is measured
};

Number volume;
Vector mass_center;
float volume_error, area_error;
float min_surface;  // of a body with this volume: a ball's
float length_of_cell;
float centroid_error;  // in a power diagram; the error is yet to be divided by the volume
bool is_in_range;

Moments no_moments() {
    const Number zero = number(0.0);
    return Moments(zero, Vector(zero, zero, zero), 0.0, 0.0, 0.0, 0.0);
}

// Sets the volume and the centroid of the sums; defined where corners are measured.
void divide(Moments all);
// Return bounds of the roundings' share of the volume and of all areas; defined where corners are measured.
float rounding_error(Moments all, float radius);
float rounding_error_of_areas(Moments all, float min_surface);
// Returns half of the length by which the centroid errs at most where the volume errs by all of itself; 0 where that is a
// few times the cell's own size.
float arm_of_centroid(Moments all, float radius);

void conclude(Moments all) {
    divide(all);
    const float radius = sqrt(all.farthest);
    is_in_range = all.farthest < farthest_of_range;
    // Slightly more than the bound, for its own roundings.
    volume_error = rounding_error(all, radius);
    length_of_cell = pow(max(rounded(volume), 0.0), 1.0 / 3.0);
    min_surface = 4.8 * length_of_cell * length_of_cell;
    area_error = rounding_error_of_areas(all, min_surface);
    if (weighted == 0u) return;
    // The centroid is relative to the seed.
    mass_center = Vector(minus(mass_center.x, exact_difference(px, cx)), minus(mass_center.y, exact_difference(py, cy)),
                         minus(mass_center.z, exact_difference(pz, cz)));
    centroid_error = volume_error * arm_of_centroid(all, radius) + number_unit * 4.0 * float(tilt_length) * max(rounded(volume), 0.0);
}

// Areas of tiny faces may come out negative.
Number not_negative(Number area) {
    return rounded(area) < 0.0 ? number(0.0) : area;
}

bool is_measured(float tolerance) {
    const bool is_centroid_right =
        weighted == 0u || centroid_error <= tolerance * rounded(volume) * length_of_cell;
    const bool are_areas_right = want_geometry != 2u || area_error <= tolerance * min_surface;
    return volume_error <= tolerance * rounded(volume) && is_in_range && is_centroid_right && are_areas_right;
}

#endif

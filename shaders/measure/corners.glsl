// How a cell is measured: in float64 by tetrahedra, in float32 as a polyhedron with refined vertices.
#ifndef VOTESS_MEASURE_CORNERS_GLSL
#define VOTESS_MEASURE_CORNERS_GLSL
#ifdef GEOMETRY_FLOAT64
#include "measure/tetrahedra.glsl"
#else
#include "measure/polyhedron.glsl"
#endif
#endif

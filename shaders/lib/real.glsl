// The numbers that a cell is clipped and measured in, and their unit roundoffs.
// Variants: CLIP_FLOAT64, GEOMETRY_FLOAT64. Needs float_unit.
#ifdef CLIP_FLOAT64
#define real double
#define real4 dvec4
const double unit = 1.1102230246251565e-16LF;
#else
#define real float
#define real4 vec4
const float unit = float_unit;
#endif
#ifdef GEOMETRY_FLOAT64
#define geometry_real double
const double geometry_unit = 1.1102230246251565e-16LF;
#else
#define geometry_real float
const float geometry_unit = float_unit;
#endif

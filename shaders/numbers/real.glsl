// The numbers that a cell is clipped in, and their unit roundoff. Variant: CLIP_FLOAT64. Needs float_unit.
#ifdef CLIP_FLOAT64
#define real double
#define real4 dvec4
const double unit = 1.1102230246251565e-16LF;
#else
#define real float
#define real4 vec4
const float unit = float_unit;
#endif

// C interface of votess/picture.hpp, which describes the options. Rules and errors are those of votess/votess.h.
#ifndef VOTESS_PICTURE_H
#define VOTESS_PICTURE_H

#include <votess/votess.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct votess_picture_options {
    uint32_t struct_size;    // set by votess_picture_options_init
    uint32_t width, height;  // pixels
    uint32_t threads;
    const double* values;  // to color the cells by; NULL for the volumes
    size_t value_count;    // N
    const char* label;     // beside the color bar; NULL for "volume"
    double range[2];       // of the colors; NaN for that of the cells shown
    double azimuth, elevation;
    double cut_at[3];                 // NaN for the middle
    double slice_value;               // of the coordinate slice_axis
    double gap;                       // between pieces of cells in a mesh
    int32_t slice_axis;               // 0, 1, 2 = x, y, z; -1 for no slice
    int32_t cut;                      // 0 corner, 1 half, 2 cells, 3 none
    int32_t scale;                    // 0 automatic, 1 linear, 2 logarithmic
    int32_t colormap;                 // 0 tide, 1 ember, 2 gray
    int32_t wall_cells;               // 0 automatic, 1 show, 2 hide
    int32_t edges, seeds, color_bar;  // 1 or 0, as the next
    int32_t skip_open, frame;
    int32_t planar;         // 1: votess_render_pieces() gets pieces of the plane; votess_render() knows
    uint8_t background[4];  // RGBA
} votess_picture_options;

// Writes the defaults. size: sizeof(votess_picture_options).
VOTESS_API votess_status votess_picture_options_init(votess_picture_options* options, size_t size);

// Draws the cells, see render() in picture.hpp. points, count: the array given to votess_tessellate. options: NULL for
// the defaults. pixels: size = 4 * width * height bytes, RGBA, rows from the top, from the left. left_out: number of
// cells that reach infinity; may be NULL.
VOTESS_API votess_status votess_render(const votess_result* result, const double* points, size_t count,
                                       const votess_picture_options* options, uint8_t* pixels, size_t size,
                                       uint64_t* left_out);

// Draws pieces of cells, or any closed triangle meshes, see render() in picture.hpp. options: as above, with values for
// each piece, which are required. Slices are refused. In the plane arrays are as for ".geojson", and seeds are refused.
VOTESS_API votess_status votess_render_pieces(const votess_piece_arrays* pieces, const votess_picture_options* options,
                                              uint8_t* pixels, size_t size);

#ifdef __cplusplus
}
#endif

#endif

// Prints volumes and neighbors of the cells of a cubic lattice of points in a periodic box, through the C interface.
//
//     cc -std=c11 cells.c $(pkg-config --cflags --libs votess) -o cells
//     ./cells
//
// ../cmake builds it with CMake.
#include <inttypes.h>
#include <stdio.h>
#include <votess/votess.h>

enum { SIDE = 4, COUNT = SIDE * SIDE * SIDE };

static void print(const votess_result* result) {
    const size_t cells = votess_result_size(result);
    votess_array array;  // votess.h lists the names and types
    votess_result_array(result, "volumes", &array);
    const double* volumes = array.data;
    // Row i of the neighbors is indices[indptr[i]] to indices[indptr[i + 1] - 1].
    votess_result_array(result, "indptr", &array);
    const int64_t* indptr = array.data;
    votess_result_array(result, "indices", &array);
    const int32_t* indices = array.data;
    double sum = 0;
    for (size_t i = 0; i < cells; ++i) sum += volumes[i];
    for (size_t i = 0; i < cells && i < 3; ++i) {
        printf("cell %zu: volume %g, neighbors", i, volumes[i]);
        for (int64_t k = indptr[i]; k < indptr[i + 1]; ++k) printf(" %" PRId32, indices[k]);
        printf("\n");
    }
    printf("sum of the volumes of %zu cells: %g\n", cells, sum);
}

int main(void) {
    double points[3 * COUNT];
    for (int i = 0; i < COUNT; ++i) {
        points[3 * i] = i % SIDE + 0.5;
        points[3 * i + 1] = i / SIDE % SIDE + 0.5;
        points[3 * i + 2] = i / (SIDE * SIDE) + 0.5;
    }

    votess_options options;
    votess_options_init(&options, sizeof options);  // neighbors and volumes; options.want requests more
    options.has_box = 1;
    for (int axis = 0; axis < 3; ++axis) {
        options.box_lower[axis] = 0;
        options.box_upper[axis] = SIDE;
        options.periodic[axis] = 1;
    }

    // For many sets of points, votess_tessellator_new() makes a tessellator that keeps memory between calls.
    votess_result* result = NULL;
    if (votess_tessellate(NULL, points, COUNT, &options, &result) != VOTESS_OK) {
        fprintf(stderr, "cells: %s\n", votess_last_error());
        return 1;
    }
    print(result);
    votess_result_free(result);  // frees its arrays too
    return 0;
}

// What a result holds, by known answers.
#include <math.h>
#include <stdlib.h>

#include "check.h"

// Eight cubes: 27 vertices, of which the one in the middle is shared by all cells.
void check_mesh(votess_tessellator* tessellator) {
    votess_options options = options_with_box(2);
    options.want = VOTESS_WANT_FACES | VOTESS_WANT_NORMALS | VOTESS_WANT_SURFACES | VOTESS_WANT_RADII;
    votess_result* result = NULL;
    votess_delaunay* dual = NULL;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    size_t length = 99;
    CHECK(votess_result_vertices(result, &length) != NULL && length == 81);
    CHECK(votess_result_indices(result, &length) != NULL && length == 48);
    CHECK(votess_result_face_normals(result, &length) != NULL && length == 144);
    const int64_t* offsets = votess_result_face_offsets(result, &length);
    CHECK(offsets != NULL && length == 49 && offsets[48] == 192);
    CHECK(votess_result_face_vertices(result, &length) != NULL && length == 192);
    const int64_t* cell_vertices = votess_result_cell_vertex_indptr(result, &length);
    CHECK(cell_vertices != NULL && length == 9 && cell_vertices[8] == 64);
    CHECK(votess_result_cell_vertex_indices(result, &length) != NULL && length == 64);
    const double* surfaces = votess_result_surface_areas(result, &length);
    CHECK(surfaces != NULL && length == 8 && fabs(surfaces[3] - 6) < 1e-13);
    const double* radii = votess_result_security_radii(result, &length);
    CHECK(radii != NULL && length == 8 && fabs(radii[3] - sqrt(3)) < 1e-13);
    CHECK(votess_result_shifts(result, &length) == NULL && length == 0);
    CHECK(votess_result_least_face(result) == 0);
    uint64_t tiny = 1;
    CHECK(votess_count_tiny_faces(result, cube, 8, &tiny) == VOTESS_OK && tiny == 0);
    CHECK_FAILS(votess_count_tiny_faces(result, cube, 8, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "tiny_faces");
    CHECK(votess_result_lists_walls(result) == 1);

    CHECK(votess_delaunay_new(result, &dual) == VOTESS_OK);
    CHECK(votess_delaunay_tetrahedra(dual, &length) == NULL && length == 0);
    CHECK(votess_delaunay_tetrahedra_centers(dual, &length) == NULL && length == 0);
    const int64_t* polytopes = votess_delaunay_polytope_indptr(dual, &length);
    CHECK(polytopes != NULL && length == 2 && polytopes[1] == 8);
    const int32_t* seeds = votess_delaunay_polytope_indices(dual, &length);
    for (int k = 0; seeds != NULL && k < 8; ++k) CHECK(seeds[k] == k);
    CHECK(votess_delaunay_polytope_centers(dual, &length) != NULL && length == 1);
    CHECK(votess_delaunay_polytope_shifts(dual, &length) == NULL && length == 0);
    CHECK(votess_delaunay_tetrahedra_shifts(dual, &length) == NULL && length == 0);
    votess_delaunay_free(dual);
    votess_result_free(result);
    votess_delaunay_free(NULL);

    options.want = VOTESS_WANT_VOLUMES;
    options.min_face = 2;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    CHECK(votess_result_least_face(result) == 2);
    CHECK(votess_result_indices(result, &length) == NULL && length == 0);
    CHECK_FAILS(votess_delaunay_new(result, &dual), VOTESS_ERROR_INVALID_ARGUMENT, "faces");
    CHECK(dual == NULL);
    CHECK_FAILS(votess_delaunay_new(NULL, &dual), VOTESS_ERROR_INVALID_ARGUMENT, "result");
    votess_result_free(result);
}

void check_cube(votess_tessellator* tessellator) {
    votess_options options = options_with_box(2);
    options.want =
        VOTESS_WANT_NEIGHBORS | VOTESS_WANT_VOLUMES | VOTESS_WANT_CENTROIDS | VOTESS_WANT_COUNTS | VOTESS_WANT_AREAS;
    votess_result* result = NULL;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    if (result == NULL) return;

    size_t length = 99;
    CHECK(votess_result_size(result) == 8);
    const int64_t* indptr = votess_result_indptr(result, &length);
    CHECK(length == 9);
    const int32_t* indices = votess_result_indices(result, &length);
    CHECK(length == 24);
    CHECK(indices == votess_result_indices(result, NULL));
    const double* areas = votess_result_face_areas(result, &length);
    CHECK(length == 24);
    for (int k = 0; areas != NULL && k < 24; ++k) CHECK(areas[k] == 1);
    const double* volumes = votess_result_volumes(result, &length);
    CHECK(length == 8);
    const double* centroids = votess_result_centroids(result, &length);
    CHECK(length == 24);
    const uint32_t* faces = votess_result_face_counts(result, &length);
    CHECK(length == 8);
    const uint32_t* edges = votess_result_edge_counts(result, &length);
    CHECK(length == 8);
    const uint32_t* vertices = votess_result_vertex_counts(result, &length);
    CHECK(length == 8);
    const uint8_t* status = votess_result_status(result, &length);
    CHECK(length == 8);
    CHECK(votess_result_duplicate_of(result, &length) == NULL && length == 0);
    CHECK(votess_result_lists_walls(result) == 0);

    CHECK(indptr && indices && volumes && centroids && faces && edges && vertices && status);
    if (indptr && indices && volumes && centroids && faces && edges && vertices && status) {
        for (int i = 0; i < 8; ++i) {
            CHECK(indptr[i] == 3 * i && indptr[i + 1] == 3 * (i + 1));
            int previous = -1;
            for (int64_t k = indptr[i]; k < indptr[i + 1]; ++k) {
                const int changed = indices[k] ^ i;  // the number of a corner has one bit for each axis
                CHECK(changed == 1 || changed == 2 || changed == 4);
                CHECK(indices[k] > previous);
                previous = indices[k];
            }
            CHECK(fabs(volumes[i] - 1) < 1e-13);
            for (int axis = 0; axis < 3; ++axis) CHECK(fabs(centroids[3 * i + axis] - cube[3 * i + axis]) < 1e-13);
            CHECK(faces[i] == 6 && edges[i] == 12 && vertices[i] == 8);
            CHECK(status[i] == VOTESS_CELL_CERTIFIED);
        }
    }

    double lower[3] = {9, 9, 9}, upper[3] = {9, 9, 9};
    CHECK(votess_result_box(result, lower, upper) == VOTESS_OK);
    for (int axis = 0; axis < 3; ++axis) CHECK(lower[axis] == 0 && upper[axis] == 2);

    votess_stats stats;
    memset(&stats, 0xff, sizeof stats);
    stats.struct_size = sizeof stats;
    CHECK(votess_result_stats(result, &stats) == VOTESS_OK);
    CHECK(stats.struct_size == sizeof stats);
    CHECK(stats.points == 8 && stats.faces == 48 && stats.mean_faces == 6);
    CHECK(stats.duplicates == 0 && stats.empty_cells == 0 && stats.fallback_cells == 0);
    CHECK(stats.fallback_uncertain + stats.fallback_overflow + stats.fallback_exhausted + stats.fallback_skipped +
              stats.fallback_domain ==
          0);
    CHECK(stats.exact_cells <= 8);
    CHECK(stats.tiny_faces == 0);
    CHECK(fabs(stats.volume_sum - 8) < 1e-12 && fabs(stats.box_volume - 8) < 1e-12);
    CHECK(stats.seconds_total >= 0 && stats.seconds_clip >= 0);
    CHECK(memchr(stats.device, 0, sizeof stats.device) != NULL && stats.device[0] != '\0');
    CHECK(stats.precision == VOTESS_PRECISION_SINGLE || stats.precision == VOTESS_PRECISION_DOUBLE);

    int passed = 0;
    uint32_t skipped = 99;
    char failure[256] = "x";
    size_t sampled = 99;
    CHECK(votess_verify(result, cube, 8, 3, 1, &passed, &skipped, &sampled, failure, sizeof failure) == VOTESS_OK);
    CHECK(passed == 1 && skipped == 0 && sampled == 3 && strcmp(failure, "") == 0);
    CHECK(votess_verify(result, cube, 8, VOTESS_SAMPLE_AUTOMATIC, 1, &passed, NULL, &sampled, NULL, 0) == VOTESS_OK);
    CHECK(passed == 1 && sampled == 8);
    double moved[24];
    memcpy(moved, cube, sizeof moved);
    moved[0] = 0.75;
    CHECK(votess_verify(result, moved, 8, 8, 1, &passed, NULL, NULL, failure, sizeof failure) == VOTESS_OK);
    CHECK(passed == 0 && strlen(failure) > 0);
    char cut[6] = "xxxxx";
    CHECK(votess_verify(result, moved, 8, 8, 1, &passed, NULL, NULL, cut, sizeof cut) == VOTESS_OK);
    CHECK(passed == 0 && strlen(cut) == 5 && strncmp(cut, failure, 5) == 0);
    CHECK(votess_verify(result, moved, 8, 8, 1, &passed, NULL, NULL, NULL, 0) == VOTESS_OK);
    CHECK(passed == 0);

    CHECK_FAILS(votess_verify(result, cube, 7, 8, 1, &passed, NULL, NULL, NULL, 0), VOTESS_ERROR_INVALID_ARGUMENT,
                "8 cells");
    CHECK_FAILS(votess_verify(result, NULL, 8, 8, 1, &passed, NULL, NULL, NULL, 0), VOTESS_ERROR_INVALID_ARGUMENT,
                "points");
    CHECK_FAILS(votess_verify(result, cube, 8, 8, 1, NULL, NULL, NULL, NULL, 0), VOTESS_ERROR_INVALID_ARGUMENT,
                "passed");
    CHECK_FAILS(votess_verify(result, cube, 8, 8, 1, &passed, NULL, NULL, NULL, 4), VOTESS_ERROR_INVALID_ARGUMENT,
                "failure");
    CHECK_FAILS(votess_verify(NULL, cube, 8, 8, 1, &passed, NULL, NULL, NULL, 0), VOTESS_ERROR_INVALID_ARGUMENT,
                "result");
    CHECK_FAILS(votess_result_box(result, NULL, upper), VOTESS_ERROR_INVALID_ARGUMENT, "lower");
    CHECK_FAILS(votess_result_box(result, lower, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "upper");
    CHECK_FAILS(votess_result_stats(result, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "stats");
    votess_result_free(result);
}

// What a result tells of its domain.
void check_domains(votess_tessellator* tessellator) {
    votess_options options = options_with_box(2);
    votess_result* result = NULL;
    double vectors[4][3] = {{9, 9, 9}};
    int32_t periodic[3] = {9, 9, 9}, has_cell = 9;
    size_t length = 99;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    CHECK(votess_result_periodic(result, periodic) == VOTESS_OK && !periodic[0] && !periodic[1] && !periodic[2]);
    CHECK(votess_result_cell(result, &has_cell, vectors[0], vectors[1], vectors[2], vectors[3]) == VOTESS_OK);
    CHECK(has_cell == 0 && vectors[0][0] == 9);
    CHECK(votess_result_walls(result, &length) == NULL && length == 0);
    CHECK(votess_result_weights(result, &length) == NULL && length == 0);
    CHECK_FAILS(votess_result_periodic(result, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "periodic");
    CHECK_FAILS(votess_result_cell(result, NULL, vectors[0], vectors[1], vectors[2], vectors[3]),
                VOTESS_ERROR_INVALID_ARGUMENT, "has_cell");
    CHECK_FAILS(votess_result_cell(result, &has_cell, vectors[0], vectors[1], NULL, vectors[3]),
                VOTESS_ERROR_INVALID_ARGUMENT, "b is NULL");
    votess_result_free(result);

    const double radii[8] = {0, 0.5, 0.25, 0, 0, 0, 0, 0};
    options.periodic[1] = 1;
    options.radii = radii;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    CHECK(votess_result_periodic(result, periodic) == VOTESS_OK && !periodic[0] && periodic[1] == 1 && !periodic[2]);
    const double* weights = votess_result_weights(result, &length);
    CHECK(weights != NULL && length == 8 && weights[1] == 0.25 && weights[2] == 0.0625);
    votess_result_free(result);

    const double walls[8] = {1, 1, 1, 5, -1, 0, 0, 0};  // x + y + z <= 5, x >= 0
    options = options_with_box(2);
    options.walls = walls;
    options.wall_count = 2;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    const double* told = votess_result_walls(result, &length);
    CHECK(told != NULL && length == 8 && memcmp(told, walls, sizeof walls) == 0);
    votess_result_free(result);

    CHECK(votess_options_init(&options, sizeof options) == VOTESS_OK);
    options.has_cell = 1;
    options.cell_origin[2] = -1;
    options.cell_a[0] = options.cell_b[1] = 2;
    options.cell_b[0] = 0.5;
    options.cell_c[2] = 4;
    for (unsigned axes = 0; axes < 8; ++axes) {
        for (unsigned k = 0; k < 3; ++k) options.periodic[k] = (int32_t)(axes >> k & 1);
        if (axes != 0 && axes != 7) {
            CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                        "cell and periodic contradict each other");
            continue;
        }
        CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
        CHECK(votess_result_periodic(result, periodic) == VOTESS_OK && periodic[0] && periodic[1] && periodic[2]);
        CHECK(votess_result_cell(result, &has_cell, vectors[0], vectors[1], vectors[2], vectors[3]) == VOTESS_OK);
        const double expected[4][3] = {{0, 0, -1}, {2, 0, 0}, {0.5, 2, 0}, {0, 0, 4}};
        CHECK(has_cell == 1 && memcmp(vectors, expected, sizeof expected) == 0);
        votess_result_free(result);
    }
    memset(options.periodic, 0, sizeof options.periodic);
    options.cell_periodic[1] = 0;
    const double inside[9] = {0.5, 0.5, 0, 5.5, 1.5, 0, -7.5, 1, 2};
    CHECK(votess_tessellate(tessellator, inside, 3, &options, &result) == VOTESS_OK);
    CHECK(votess_result_periodic(result, periodic) == VOTESS_OK && periodic[0] && !periodic[1] && periodic[2]);
    double places[9];
    CHECK(votess_wrapped_points(result, inside, 3, places) == VOTESS_OK);
    CHECK(places[0] == 0.5 && places[3] == 1.5 && places[4] == 1.5 && places[6] == 0.5 && places[8] == 2);
    CHECK_FAILS(votess_wrapped_points(result, inside, 2, places), VOTESS_ERROR_INVALID_ARGUMENT, "coordinates");
    CHECK_FAILS(votess_wrapped_points(result, inside, 3, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "places");
    votess_result_free(result);
}

void check_null_result(void) {
    double corner[3];
    votess_stats stats;
    stats.struct_size = sizeof stats;
    size_t length = 99;
    CHECK_FAILS(votess_result_box(NULL, corner, corner), VOTESS_ERROR_INVALID_ARGUMENT, "result");
    CHECK_FAILS(votess_result_stats(NULL, &stats), VOTESS_ERROR_INVALID_ARGUMENT, "result");
    int32_t flags[3];
    CHECK_FAILS(votess_result_periodic(NULL, flags), VOTESS_ERROR_INVALID_ARGUMENT, "result");
    CHECK_FAILS(votess_result_cell(NULL, flags, corner, corner, corner, corner), VOTESS_ERROR_INVALID_ARGUMENT,
                "result");
    CHECK(votess_result_walls(NULL, &length) == NULL && length == 0);
    CHECK(votess_result_size(NULL) == 0);
    CHECK(votess_result_lists_walls(NULL) == 0);
    CHECK(votess_result_indptr(NULL, &length) == NULL && length == 0);
    length = 99;
    CHECK(votess_result_status(NULL, &length) == NULL && length == 0);
    CHECK(votess_result_volumes(NULL, NULL) == NULL);
    CHECK(votess_result_face_areas(NULL, NULL) == NULL);
    votess_result_free(NULL);
    votess_tessellator_free(NULL);
}

void check_walls_and_defaults(void) {
    const double points[6] = {0.25, 0.5, 0.5, 0.75, 0.5, 0.5};
    votess_options options = options_with_box(1);
    CHECK(options.want == (VOTESS_WANT_NEIGHBORS | VOTESS_WANT_VOLUMES));
    options.list_walls = 1;
    votess_result* result = NULL;
    CHECK(votess_tessellate(NULL, points, 2, &options, &result) == VOTESS_OK);
    if (result != NULL) {
        const int32_t expected[12] = {-6, -5, -4, -3, -1, 1, -6, -5, -4, -3, -2, 0};
        size_t length = 0;
        const int32_t* indices = votess_result_indices(result, &length);
        CHECK(length == 12 && indices != NULL && memcmp(indices, expected, sizeof expected) == 0);
        CHECK(votess_result_lists_walls(result) == 1);
        CHECK(votess_result_centroids(result, &length) == NULL && length == 0);  // not wanted
        CHECK(votess_result_face_areas(result, &length) == NULL && length == 0);
        votess_result_free(result);
    }
    result = NULL;
    options.want = VOTESS_WANT_AREAS;
    CHECK(votess_tessellate(NULL, points, 2, &options, &result) == VOTESS_OK);
    if (result != NULL) {
        const double expected[12] = {0.5, 0.5, 0.5, 0.5, 1, 1, 0.5, 0.5, 0.5, 0.5, 1, 1};
        size_t length = 0;
        const double* areas = votess_result_face_areas(result, &length);
        CHECK(length == 12 && areas != NULL && memcmp(areas, expected, sizeof expected) == 0);
        CHECK(votess_result_indices(result, &length) != NULL && length == 12);  // areas add neighbors
        CHECK(votess_result_volumes(result, &length) == NULL && length == 0);
        votess_result_free(result);
    }

    // No options at all: the default box is wider than the points by half of (0.5 / cbrt(2)) on each side.
    result = NULL;
    CHECK(votess_tessellate(NULL, points, 2, NULL, &result) == VOTESS_OK);
    if (result != NULL) {
        double lower[3], upper[3];
        CHECK(votess_result_box(result, lower, upper) == VOTESS_OK);
        const double margin = 0.5 * 0.5 / cbrt(2.0);
        CHECK(fabs(lower[0] - (0.25 - margin)) < 1e-12 && fabs(upper[2] - (0.5 + margin)) < 1e-12);
        size_t length = 0;
        CHECK(votess_result_volumes(result, &length) != NULL && length == 2);
        votess_result_free(result);
    }
}

void check_empty_and_float(votess_tessellator* tessellator) {
    votess_result* result = NULL;
    size_t length = 99;
    CHECK(votess_tessellate(tessellator, NULL, 0, NULL, &result) == VOTESS_OK);
    if (result != NULL) {
        CHECK(votess_result_size(result) == 0);
        const int64_t* indptr = votess_result_indptr(result, &length);
        CHECK(length == 1 && indptr != NULL && indptr[0] == 0);
        CHECK(votess_result_indices(result, &length) == NULL && length == 0);
        votess_result_free(result);
    }

    float narrow[24];
    for (int i = 0; i < 24; ++i) narrow[i] = (float)cube[i];
    const votess_options options = options_with_box(2);
    result = NULL;
    CHECK(votess_tessellate_f32(tessellator, narrow, 8, &options, &result) == VOTESS_OK);
    if (result != NULL) {
        const double* volumes = votess_result_volumes(result, &length);
        CHECK(length == 8 && volumes != NULL && fabs(volumes[7] - 1) < 1e-13);
        votess_result_free(result);
    }
    narrow[10] = (float)NAN;
    CHECK_FAILS(votess_tessellate_f32(tessellator, narrow, 8, NULL, &result), VOTESS_ERROR_INVALID_ARGUMENT, "3");
    CHECK(result == NULL);
}

void check_duplicates(votess_tessellator* tessellator) {
    const double points[9] = {0.25, 0.5, 0.5, 0.75, 0.5, 0.5, 0.25, 0.5, 0.5};
    votess_options options = options_with_box(1);
    votess_result* result = NULL;
    CHECK(votess_tessellate(tessellator, points, 3, &options, &result) == VOTESS_OK);
    if (result != NULL) {
        size_t length = 0;
        const int32_t* duplicate_of = votess_result_duplicate_of(result, &length);
        CHECK(length == 3 && duplicate_of != NULL && duplicate_of[0] == -1 && duplicate_of[1] == -1 &&
              duplicate_of[2] == 0);
        const uint8_t* status = votess_result_status(result, &length);
        CHECK(length == 3 && status != NULL && status[2] == VOTESS_CELL_DUPLICATE);
        votess_result_free(result);
    }
    options.duplicates = VOTESS_DUPLICATES_ERROR;
    CHECK_FAILS(votess_tessellate(tessellator, points, 3, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "2");
    CHECK(result == NULL);
}

// In the middle of the cube, at a seed, and outside.
static void check_probes(const votess_diagram* diagram) {
    const double queries[9] = {1, 1, 1, 0.5, 0.5, 0.5, 3, 0, 0};
    const uint32_t want = VOTESS_WANT_VOLUMES | VOTESS_WANT_FACES;
    votess_result* probes = NULL;
    CHECK(votess_diagram_probe(diagram, queries, 3, want, 1, NULL, &probes) == VOTESS_OK && probes != NULL);
    size_t length = 0;
    CHECK(votess_result_size(probes) == 3);
    // An octahedron that reaches no wall.
    const int64_t* indptr = votess_result_indptr(probes, &length);
    CHECK(length == 4 && indptr[1] == 8 && indptr[3] == 8);
    const int32_t* indices = votess_result_indices(probes, &length);
    CHECK(length == 8 && indices[0] == 0 && indices[7] == 7);
    const double* volumes = votess_result_volumes(probes, &length);
    CHECK(length == 3 && fabs(volumes[0] - 9.0 / 16) < 1e-12 && volumes[1] == 0 && volumes[2] == 0);
    const uint8_t* status = votess_result_status(probes, &length);
    CHECK(length == 3 && status[0] == VOTESS_CELL_CERTIFIED && status[1] == VOTESS_CELL_DUPLICATE &&
          status[2] == VOTESS_CELL_OUTSIDE);
    const int32_t* duplicate_of = votess_result_duplicate_of(probes, &length);
    CHECK(length == 3 && duplicate_of[0] == -1 && duplicate_of[1] == 0);
    // What asks for a whole diagram.
    votess_delaunay* delaunay = NULL;
    int passed = 0;
    double places[9];
    CHECK_FAILS(votess_delaunay_new(probes, &delaunay), VOTESS_ERROR_INVALID_ARGUMENT, "cells of probes");
    CHECK_FAILS(votess_verify(probes, queries, 3, 1, 1, &passed, NULL, NULL, NULL, 0), VOTESS_ERROR_INVALID_ARGUMENT,
                "cells of probes");
    CHECK_FAILS(votess_wrapped_points(probes, queries, 3, places), VOTESS_ERROR_INVALID_ARGUMENT, "cells of probes");
    votess_result_free(probes);

    CHECK(votess_diagram_probe(diagram, NULL, 0, want, 0, NULL, &probes) == VOTESS_OK);
    CHECK(votess_result_size(probes) == 0);
    votess_result_free(probes);
    CHECK_FAILS(votess_diagram_probe(diagram, queries, 3, 1u << 20, 0, NULL, &probes), VOTESS_ERROR_INVALID_ARGUMENT,
                "want is 1048576");
    CHECK_FAILS(votess_diagram_probe(diagram, queries, 3, want, 0, queries, &probes), VOTESS_ERROR_INVALID_ARGUMENT,
                "weights");
    CHECK_FAILS(votess_diagram_probe(diagram, NULL, 1, want, 0, NULL, &probes), VOTESS_ERROR_INVALID_ARGUMENT,
                "queries");
    CHECK_FAILS(votess_diagram_probe(NULL, queries, 1, want, 0, NULL, &probes), VOTESS_ERROR_INVALID_ARGUMENT,
                "diagram");
    CHECK_FAILS(votess_diagram_probe(diagram, queries, 1, want, 0, NULL, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "out");
    CHECK(probes == NULL);
}

// As far from all eight seeds, on one of them, and outside.
static void check_natural(const votess_diagram* diagram) {
    const double queries[9] = {1, 1, 1, 0.5, 0.5, 0.5, 3, 0, 0};
    votess_natural* natural = NULL;
    CHECK(votess_natural_new(diagram, queries, 3, VOTESS_NATURAL_SIBSON, 1, 1, NULL, &natural) == VOTESS_OK);
    size_t length = 0;
    const int64_t* indptr = votess_natural_indptr(natural, &length);
    CHECK(length == 4 && indptr[1] == 8 && indptr[2] == 9 && indptr[3] == 9);
    const int32_t* indices = votess_natural_indices(natural, &length);
    CHECK(length == 9 && indices[0] == 0 && indices[7] == 7 && indices[8] == 0);
    const double* weights = votess_natural_weights(natural, &length);
    CHECK(length == 9 && fabs(weights[0] - 0.125) < 1e-12 && fabs(weights[7] - 0.125) < 1e-12 && weights[8] == 1);
    const double* gradients = votess_natural_gradients(natural, &length);
    CHECK(length == 27 && gradients[0] < 0 && gradients[26] != gradients[26]);
    votess_natural_free(natural);
    votess_natural_free(NULL);
    CHECK(votess_natural_indptr(NULL, &length) == NULL && length == 0);

    const double values[16] = {0, 1, 2, 1, 4, 1, 6, 1, 8, 1, 10, 1, 12, 1, 14, 1};
    double field[6] = {0};
    CHECK(votess_diagram_interpolate(diagram, values, 2, queries, 3, VOTESS_NATURAL_LAPLACE, 1, NULL, field, NULL) ==
          VOTESS_OK);
    CHECK(fabs(field[0] - 7) < 1e-12 && fabs(field[1] - 1) < 1e-12 && field[2] == 0 && field[4] != field[4]);
    CHECK_FAILS(votess_natural_new(diagram, queries, 3, 2, 1, 0, NULL, &natural), VOTESS_ERROR_INVALID_ARGUMENT,
                "method is 2");
    CHECK_FAILS(votess_natural_new(diagram, queries, 3, VOTESS_NATURAL_LAPLACE, 1, 1, NULL, &natural),
                VOTESS_ERROR_INVALID_ARGUMENT, "gradients");
    CHECK_FAILS(votess_natural_new(NULL, queries, 3, 0, 1, 0, NULL, &natural), VOTESS_ERROR_INVALID_ARGUMENT,
                "diagram");
    CHECK(natural == NULL);
    CHECK_FAILS(votess_diagram_interpolate(diagram, NULL, 1, queries, 3, 0, 1, NULL, field, NULL),
                VOTESS_ERROR_INVALID_ARGUMENT, "values");
    CHECK_FAILS(votess_diagram_interpolate(diagram, values, 0, queries, 3, 0, 1, NULL, field, NULL),
                VOTESS_ERROR_INVALID_ARGUMENT, "components");
}

static int note_fraction(double fraction, void* user) {
    double* last = user;
    const int grows = fraction >= *last;
    *last = fraction;
    return grows;
}

static int stop_at_once(double fraction, void* user) {
    return fraction < 0 && user == NULL;
}

// Another handle of the same seeds, whose queries report and can be stopped.
static void check_views(const votess_diagram* diagram) {
    votess_options options;
    CHECK(votess_options_init(&options, sizeof options) == VOTESS_OK);
    double last = -1, grid[8];
    const double values[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const size_t shape[3] = {2, 2, 2};
    options.progress = note_fraction;
    options.progress_user = &last;
    votess_diagram* view = NULL;
    CHECK(votess_diagram_view(diagram, &options, &view) == VOTESS_OK && votess_diagram_size(view) == 8);
    CHECK(votess_diagram_to_grid(view, values, 1, shape, VOTESS_GRID_MEAN, -1, grid, NULL) == VOTESS_OK);
    CHECK(last == 1);
    votess_diagram_free(view);

    options.progress = stop_at_once;
    CHECK(votess_diagram_view(diagram, &options, &view) == VOTESS_OK);
    const double query[3] = {0.4, 0.6, 0.5};
    int32_t seed = 0;
    votess_result* probes = NULL;
    votess_natural* natural = NULL;
    CHECK_FAILS(votess_diagram_locate(view, query, 1, &seed), VOTESS_ERROR_CANCELLED, "progress");
    CHECK_FAILS(votess_diagram_probe(view, query, 1, VOTESS_WANT_VOLUMES, 0, NULL, &probes), VOTESS_ERROR_CANCELLED,
                "progress");
    CHECK_FAILS(votess_natural_new(view, query, 1, 0, 1, 0, NULL, &natural), VOTESS_ERROR_CANCELLED, "progress");
    CHECK_FAILS(votess_diagram_interpolate(view, values, 1, query, 1, 0, 1, NULL, grid, NULL), VOTESS_ERROR_CANCELLED,
                "progress");
    CHECK_FAILS(votess_diagram_to_grid(view, values, 1, shape, 0, -1, grid, NULL), VOTESS_ERROR_CANCELLED, "progress");
    CHECK(probes == NULL && natural == NULL);
    CHECK(votess_diagram_locate(diagram, query, 1, &seed) == VOTESS_OK);
    votess_diagram_free(view);
    CHECK_FAILS(votess_diagram_view(NULL, &options, &view), VOTESS_ERROR_INVALID_ARGUMENT, "diagram");
    CHECK(view == NULL);
    CHECK_FAILS(votess_diagram_view(diagram, &options, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "out");
}

static void check_grids(const votess_diagram* diagram) {
    const double values[16] = {0, 1, 2, 1, 4, 1, 6, 1, 8, 1, 10, 1, 12, 1, 14, 1};
    const size_t shape[3] = {1, 2, 3}, none[3] = {1, 0, 3}, huge[3] = {SIZE_MAX, SIZE_MAX, 2};
    double grid[12], sum = 0;
    size_t without_place = 9;
    for (int32_t method = VOTESS_GRID_MEAN; method <= VOTESS_GRID_SIBSON; ++method) {
        CHECK(votess_diagram_to_grid(diagram, values, 2, shape, method, -1, grid, &without_place) == VOTESS_OK);
        if (method != VOTESS_GRID_DTFE) CHECK(without_place == 0 && fabs(grid[11] - 1) < 1e-12);
    }
    CHECK(votess_diagram_to_grid(diagram, values, 2, shape, VOTESS_GRID_MEAN, 2, grid, NULL) == VOTESS_OK);
    for (int i = 0; i < 4; i += 2) sum += grid[i] / 2;
    CHECK(fabs(sum - 7 * 2) < 1e-12 && fabs(grid[1] - 2) < 1e-12);  // the box is two long
    CHECK_FAILS(votess_diagram_to_grid(diagram, values, 2, none, 0, -1, grid, NULL), VOTESS_ERROR_INVALID_ARGUMENT,
                "shape[1] = 0");
    CHECK_FAILS(votess_diagram_to_grid(diagram, values, 2, huge, 0, -1, grid, NULL), VOTESS_ERROR_INVALID_ARGUMENT,
                "shape[0]");
    CHECK_FAILS(votess_diagram_to_grid(diagram, values, 2, shape, 4, -1, grid, NULL), VOTESS_ERROR_INVALID_ARGUMENT,
                "method = 4");
    CHECK_FAILS(votess_diagram_to_grid(diagram, values, 2, shape, 0, 3, grid, NULL), VOTESS_ERROR_INVALID_ARGUMENT,
                "project = 3");
    CHECK_FAILS(votess_diagram_to_grid(diagram, NULL, 2, shape, 0, -1, grid, NULL), VOTESS_ERROR_INVALID_ARGUMENT,
                "values");
    CHECK_FAILS(votess_diagram_to_grid(diagram, values, 2, NULL, 0, -1, grid, NULL), VOTESS_ERROR_INVALID_ARGUMENT,
                "shape");
}

// A power diagram: a query between two equal seeds.
static void check_weighted_probes(void) {
    votess_options options = options_with_box(2);
    const double seeds[6] = {0.5, 1, 1, 1.5, 1, 1}, weights[2] = {0, 0}, query[3] = {1, 1, 1}, weight = 0.125;
    options.weights = weights;
    votess_diagram* diagram = NULL;
    CHECK(votess_diagram_new(seeds, 2, &options, &diagram) == VOTESS_OK);
    votess_result* probes = NULL;
    CHECK(votess_diagram_probe(diagram, query, 1, VOTESS_WANT_VOLUMES, 0, &weight, &probes) == VOTESS_OK);
    const double* volumes = votess_result_volumes(probes, NULL);
    // Bisectors move by weight / (2 distance) = 1/8.
    CHECK(volumes != NULL && fabs(volumes[0] - 4 * 2 * (0.25 + 0.125)) < 1e-12);
    votess_result_free(probes);
    votess_diagram_free(diagram);
}

void check_diagram(void) {
    votess_options options = options_with_box(2);
    votess_diagram* diagram = NULL;
    CHECK(votess_diagram_new(cube, 8, &options, &diagram) == VOTESS_OK && diagram != NULL);
    CHECK(votess_diagram_size(diagram) == 8);
    // Inside of a cell, on a vertex of all eight, and outside.
    const double queries[9] = {1.9, 0.1, 1.9, 1, 1, 1, 3, 0, 0};
    int32_t seeds[3] = {9, 9, 9};
    CHECK(votess_diagram_locate(diagram, queries, 3, seeds) == VOTESS_OK);
    CHECK(seeds[0] == 5 && seeds[1] == 0 && seeds[2] == -1);
    CHECK(votess_diagram_locate(diagram, NULL, 0, NULL) == VOTESS_OK);
    CHECK_FAILS(votess_diagram_locate(diagram, NULL, 1, seeds), VOTESS_ERROR_INVALID_ARGUMENT, "queries");
    CHECK_FAILS(votess_diagram_locate(diagram, queries, 1, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "seeds");
    CHECK_FAILS(votess_diagram_locate(NULL, queries, 1, seeds), VOTESS_ERROR_INVALID_ARGUMENT, "diagram");
    CHECK_FAILS(votess_diagram_locate(diagram, queries, (size_t)1 << 40, seeds), VOTESS_ERROR_UNSUPPORTED,
                "at most 2147483647");
    check_views(diagram);
    check_probes(diagram);
    check_natural(diagram);
    check_grids(diagram);
    check_weighted_probes();
    votess_diagram_free(diagram);
    votess_diagram_free(NULL);
    options.device = "gpu";
    CHECK_FAILS(votess_diagram_new(cube, 8, &options, &diagram), VOTESS_ERROR_UNSUPPORTED, "CPU");
    CHECK(diagram == NULL && votess_diagram_size(NULL) == 0);
    CHECK_FAILS(votess_diagram_new(NULL, 8, NULL, &diagram), VOTESS_ERROR_INVALID_ARGUMENT, "points");
    CHECK_FAILS(votess_diagram_new(cube, 8, NULL, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "out");
}

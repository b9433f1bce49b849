// Uses the C interface as a C11 program would, error paths included. Returns 0 when all is well, else prints what is
// not.
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <pthread.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include <votess/votess.h>

static int failures = 0;

#define CHECK(condition)                                                                                 \
    do {                                                                                                 \
        if (!(condition)) {                                                                              \
            fprintf(stderr, "c_consumer.c:%d: not true: %s; last error: \"%s\"\n", __LINE__, #condition, \
                    votess_last_error());                                                                \
            ++failures;                                                                                  \
        }                                                                                                \
    } while (0)

// The call must fail with this status and a one-line message that holds this text.
#define CHECK_FAILS(call, expected, text)                                                                             \
    do {                                                                                                              \
        const votess_status status_ = (call);                                                                         \
        const char* message_ = votess_last_error();                                                                   \
        if (status_ != (expected) || strstr(message_, text) == NULL || strchr(message_, '\n') != NULL) {              \
            fprintf(stderr, "c_consumer.c:%d: %s: status %d, message \"%s\"; expected %d, \"%s\"\n", __LINE__, #call, \
                    (int)status_, message_, (int)(expected), text);                                                   \
            ++failures;                                                                                               \
        }                                                                                                             \
    } while (0)

static const double cube[24] = {0.5, 0.5, 0.5, 0.5, 0.5, 1.5, 0.5, 1.5, 0.5, 0.5, 1.5, 1.5,
                                1.5, 0.5, 0.5, 1.5, 0.5, 1.5, 1.5, 1.5, 0.5, 1.5, 1.5, 1.5};

static votess_options options_with_box(double side) {
    votess_options options;
    CHECK(votess_options_init(&options, sizeof options) == VOTESS_OK);
    options.has_box = 1;
    for (int axis = 0; axis < 3; ++axis) {
        options.box_lower[axis] = 0;
        options.box_upper[axis] = side;
    }
    return options;
}

// Uniform numbers in [0, 1): a 64-bit linear congruential generator (Knuth's MMIX constants).
static double* random_points(size_t count, uint64_t seed) {
    double* points = malloc(3 * count * sizeof *points);
    if (points == NULL) {
        fprintf(stderr, "c_consumer.c: no memory for %zu points\n", count);
        exit(2);
    }
    for (size_t i = 0; i < 3 * count; ++i) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(seed >> 11) / 9007199254740992.0;
    }
    return points;
}

static void check_version(void) {
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", VOTESS_VERSION_MAJOR, VOTESS_VERSION_MINOR, VOTESS_VERSION_PATCH);
    CHECK(strcmp(votess_version_string(), text) == 0);
    CHECK(strcmp(votess_version_string(), VOTESS_VERSION_STRING) == 0);
    CHECK(votess_version() == VOTESS_VERSION_MAJOR * 1000000u + VOTESS_VERSION_MINOR * 1000u + VOTESS_VERSION_PATCH);
    CHECK(votess_sizeof_options() == sizeof(votess_options));
    CHECK(votess_sizeof_stats() == sizeof(votess_stats));
    CHECK(strcmp(votess_last_error(), "") == 0);
}

// Eight cubes: 27 vertices, of which the one in the middle is shared by all cells.
static void check_mesh(votess_tessellator* tessellator) {
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

static void check_cube(votess_tessellator* tessellator) {
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
    CHECK(stats.exact_cells <= 8);
    CHECK(fabs(stats.volume_sum - 8) < 1e-12 && fabs(stats.box_volume - 8) < 1e-12);
    CHECK(stats.seconds_total >= 0 && stats.seconds_clip >= 0);
    CHECK(memchr(stats.device, 0, sizeof stats.device) != NULL && stats.device[0] != '\0');
    CHECK(stats.precision == VOTESS_PRECISION_SINGLE || stats.precision == VOTESS_PRECISION_DOUBLE);
    CHECK(stats.reserved == 0);

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

static void check_null_result(void) {
    double corner[3];
    votess_stats stats;
    stats.struct_size = sizeof stats;
    size_t length = 99;
    CHECK_FAILS(votess_result_box(NULL, corner, corner), VOTESS_ERROR_INVALID_ARGUMENT, "result");
    CHECK_FAILS(votess_result_stats(NULL, &stats), VOTESS_ERROR_INVALID_ARGUMENT, "result");
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

static void check_walls_and_defaults(void) {
    const double points[6] = {0.25, 0.5, 0.5, 0.75, 0.5, 0.5};
    votess_options options = options_with_box(1);
    CHECK(options.want == (VOTESS_WANT_NEIGHBORS | VOTESS_WANT_VOLUMES));
    options.walls = 1;
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

static void check_empty_and_float(votess_tessellator* tessellator) {
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

static void check_duplicates(votess_tessellator* tessellator) {
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

static void check_bad_input(votess_tessellator* tessellator) {
    votess_result* result = NULL;
    const votess_options good = options_with_box(2);
    votess_options options = good;
    double points[24];

    memcpy(points, cube, sizeof points);
    points[13] = INFINITY;
    CHECK_FAILS(votess_tessellate(tessellator, points, 8, NULL, &result), VOTESS_ERROR_INVALID_ARGUMENT, "4");
    memcpy(points, cube, sizeof points);
    points[17] = 2.5;
    CHECK_FAILS(votess_tessellate(tessellator, points, 8, &good, &result), VOTESS_ERROR_INVALID_ARGUMENT, "2.5");
    CHECK_FAILS(votess_tessellate(tessellator, NULL, 8, &good, &result), VOTESS_ERROR_INVALID_ARGUMENT, "points");
    CHECK_FAILS(votess_tessellate(tessellator, cube, SIZE_MAX / 2, &good, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "count");
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &good, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "out");
    CHECK_FAILS(votess_tessellator_new(NULL), VOTESS_ERROR_INVALID_ARGUMENT, "out");

    options.box_upper[1] = options.box_lower[1];
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "box");
    options = good;
    options.want |= 1u << 20;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "1048576");
    options = good;
    options.duplicates = 2;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "duplicates is 2");
    options = good;
    options.reserved = 7;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "reserved is 7");
    options = good;
    options.threads = 5000;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "5000");
    options = good;
    options.kernel = 7;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "kernel is 7");
    options = good;
    options.precision = -1;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "precision is -1");
    options.precision = 2;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "precision is 2");
    options.precision = VOTESS_PRECISION_DOUBLE + 256;  // not cut to a byte
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "257");
    options = good;
    options.k_init = 1025;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "1025");
    options = good;
    options.device = "abacus\n";
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "abacus");
    options.device = "";
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "lavapipe");
    CHECK(result == NULL);

    // A failure sets *out to NULL whatever was there.
    result = (votess_result*)points;
    CHECK_FAILS(votess_tessellate(tessellator, NULL, 8, &good, &result), VOTESS_ERROR_INVALID_ARGUMENT, "points");
    CHECK(result == NULL);
    // A success leaves the message of the last failure alone.
    CHECK(votess_tessellate(tessellator, cube, 8, &good, &result) == VOTESS_OK);
    CHECK(strstr(votess_last_error(), "points") != NULL);
    votess_result_free(result);
}

static void check_tuning(votess_tessellator* tessellator) {
    votess_options options = options_with_box(2);
    CHECK(options.precision == VOTESS_PRECISION_SINGLE && options.k_init == 0 && options.chunk_size == 0);
    CHECK(options.reserved == 0 && options.kernel == VOTESS_KERNEL_AUTOMATIC && options.device == NULL);
    CHECK(options.instructions == NULL);
    options.device = "cpu";
    options.k_init = 1024;
    options.chunk_size = UINT32_MAX;
    options.precision = VOTESS_PRECISION_DOUBLE;
    votess_result* result = NULL;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    if (result == NULL) return;
    votess_stats stats;
    stats.struct_size = sizeof stats;
    CHECK(votess_result_stats(result, &stats) == VOTESS_OK && stats.precision == VOTESS_PRECISION_DOUBLE);
    votess_result_free(result);
    options.instructions = "baseline";
    options.precision = VOTESS_PRECISION_SINGLE;
    result = NULL;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    CHECK(votess_result_stats(result, &stats) == VOTESS_OK && stats.precision == VOTESS_PRECISION_DOUBLE);  // the CPU
    votess_result_free(result);
    options.instructions = "mmx";
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "avx512");
    options.struct_size = (uint32_t)offsetof(votess_options, instructions);  // of a header that had no such field
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    votess_result_free(result);
}

// A program built against the first header, whose structs ended earlier: what lies beyond is neither read nor written.
static void check_first_struct_sizes(votess_tessellator* tessellator) {
    const size_t first_options = offsetof(votess_options, precision), first_stats = offsetof(votess_stats, precision);
    CHECK(first_options == offsetof(votess_options, log_user) + sizeof(void*));
    CHECK(first_stats == offsetof(votess_stats, device) + 256);

    votess_options options;
    memset(&options, 0xee, sizeof options);
    CHECK(votess_options_init(&options, first_options) == VOTESS_OK);
    CHECK(options.struct_size == first_options && options.want == (VOTESS_WANT_NEIGHBORS | VOTESS_WANT_VOLUMES));
    const unsigned char* bytes = (const unsigned char*)&options;
    for (size_t i = first_options; i < sizeof options; ++i) CHECK(bytes[i] == 0xee);
    votess_result* result = NULL;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    if (result == NULL) return;

    votess_stats stats;
    memset(&stats, 0xee, sizeof stats);
    stats.struct_size = (uint32_t)first_stats;
    CHECK(votess_result_stats(result, &stats) == VOTESS_OK);
    CHECK(stats.struct_size == first_stats && stats.points == 8);
    bytes = (const unsigned char*)&stats;
    for (size_t i = first_stats; i < sizeof stats; ++i) CHECK(bytes[i] == 0xee);
    votess_result_free(result);

    // What the caller has is read, if it is only part of what is new.
    options.struct_size = (uint32_t)offsetof(votess_options, chunk_size);
    options.precision = VOTESS_PRECISION_DOUBLE;
    options.k_init = 1024;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &result) == VOTESS_OK);
    votess_result_free(result);
    options.k_init = 1025;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "k_init");
}

static void check_struct_sizes(votess_tessellator* tessellator) {
    votess_options options;
    CHECK_FAILS(votess_options_init(NULL, sizeof options), VOTESS_ERROR_INVALID_ARGUMENT, "options");
    CHECK_FAILS(votess_options_init(&options, 0), VOTESS_ERROR_INVALID_ARGUMENT, "size is 0");
    CHECK_FAILS(votess_options_init(&options, 16), VOTESS_ERROR_INVALID_ARGUMENT, "size is 16");

    votess_result* result = NULL;
    options = options_with_box(2);
    options.struct_size = 0;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "struct_size is 0");
    options.struct_size = offsetof(votess_options, log_user);
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "struct_size is");

    // Memory that was not initialized.
    CHECK_FAILS(votess_options_init(&options, (size_t)-1), VOTESS_ERROR_INVALID_ARGUMENT, "largest known is 4096");
    options = options_with_box(2);
    const uint32_t too_large[] = {0xffffffffu, 0x80000000u, 0xeeeeeeeeu, VOTESS_LARGEST_STRUCT + 1};
    for (size_t i = 0; i < sizeof too_large / sizeof *too_large; ++i) {
        options.struct_size = too_large[i];
        CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                    "largest known is 4096");
    }
    CHECK(result == NULL);

    // A program built against a newer header: the fields that this library lacks are neither read nor written.
    struct newer_options {
        votess_options options;
        unsigned char beyond[64];
    } newer;
    memset(&newer, 0xee, sizeof newer);
    CHECK(votess_options_init(&newer.options, sizeof newer) == VOTESS_OK);
    CHECK(newer.options.struct_size == sizeof(votess_options));
    for (size_t i = 0; i < sizeof newer.beyond; ++i) CHECK(newer.beyond[i] == 0xee);
    newer.options.struct_size = sizeof newer;
    CHECK(votess_tessellate(tessellator, cube, 8, &newer.options, &result) == VOTESS_OK);
    if (result == NULL) return;

    struct newer_stats {
        votess_stats stats;
        unsigned char beyond[64];
    } stats;
    memset(&stats, 0xee, sizeof stats);
    stats.stats.struct_size = sizeof stats;
    CHECK(votess_result_stats(result, &stats.stats) == VOTESS_OK);
    CHECK(stats.stats.struct_size == sizeof stats && stats.stats.points == 8);
    for (size_t i = 0; i < sizeof stats.beyond; ++i) CHECK(stats.beyond[i] == 0xee);
    stats.stats.struct_size = 0;
    CHECK_FAILS(votess_result_stats(result, &stats.stats), VOTESS_ERROR_INVALID_ARGUMENT, "struct_size is 0");
    stats.stats.struct_size = 0xffffffffu;
    CHECK_FAILS(votess_result_stats(result, &stats.stats), VOTESS_ERROR_INVALID_ARGUMENT, "struct_size is 4294967295");
    stats.stats.struct_size = 40;
    CHECK_FAILS(votess_result_stats(result, &stats.stats), VOTESS_ERROR_INVALID_ARGUMENT, "struct_size is 40");
    votess_result_free(result);
}

struct calls {
    int count;
    int stop_after;  // cancel at this call; 0 = never
    double last_fraction;
    int in_order;
    int lines;
    int line_ends;
};

static int on_progress(double fraction, void* user) {
    struct calls* calls = user;
    ++calls->count;
    if (!(fraction >= calls->last_fraction && fraction <= 1)) calls->in_order = 0;
    calls->last_fraction = fraction;
    return calls->stop_after == 0 || calls->count < calls->stop_after;
}

static void on_log(const char* message, void* user) {
    struct calls* calls = user;
    ++calls->lines;
    if (strchr(message, '\n') != NULL) ++calls->line_ends;
}

static void check_callbacks(votess_tessellator* tessellator) {
    const size_t count = getenv("VOTESS_TEST_REDUCED") != NULL ? 20000 : 200000;  // set under sanitizers
    double* points = random_points(count, 1);
    votess_options options = options_with_box(1);
    struct calls calls = {0, 0, 0, 1, 0, 0};
    options.threads = 1;
    options.progress = on_progress;
    options.progress_user = &calls;
    options.log = on_log;
    options.log_user = &calls;
    votess_result* result = NULL;
    CHECK(votess_tessellate(tessellator, points, count, &options, &result) == VOTESS_OK);
    CHECK(calls.count > 0 && calls.in_order == 1 && calls.line_ends == 0);
    if (result != NULL) {
        const double* volumes = votess_result_volumes(result, NULL);
        double sum = 0;
        for (size_t i = 0; volumes != NULL && i < count; ++i) sum += volumes[i];
        CHECK(fabs(sum - 1) < 1e-9);
        int passed = 0;
        CHECK(votess_verify(result, points, count, 4, 1, &passed, NULL, NULL, NULL, 0) == VOTESS_OK && passed == 1);
    }
    votess_result_free(result);

    calls = (struct calls){0, 1, 0, 1, 0, 0};
    CHECK(votess_tessellate(tessellator, points, count, &options, &result) == VOTESS_ERROR_CANCELLED);
    CHECK(result == NULL && strlen(votess_last_error()) > 0);

    // The tessellator serves on after a cancelled run.
    options.progress = NULL;
    options.log = NULL;
    CHECK(votess_tessellate(tessellator, points, 1000, &options, &result) == VOTESS_OK);
    CHECK(votess_result_size(result) == 1000);
    votess_result_free(result);
    free(points);
}

// Seeds that move, then others, by a tessellator that is kept.
static void check_moving(votess_tessellator* tessellator) {
    const size_t count = 3000;
    double* points = random_points(count, 1);
    const votess_options options = options_with_box(1);
    votess_result* result = NULL;
    for (int step = 0; step < 3; ++step) {
        votess_result* fresh = NULL;
        CHECK(votess_tessellate(NULL, points, count, &options, &fresh) == VOTESS_OK);
        CHECK(votess_tessellate(tessellator, points, count, &options, &result) == VOTESS_OK);
        size_t length = 0, other_length = 0;
        const int32_t* ids = votess_result_indices(fresh, &length);
        const int32_t* other_ids = votess_result_indices(result, &other_length);
        CHECK(length > 0 && length == other_length);
        if (ids != NULL && other_ids != NULL && length == other_length)
            CHECK(memcmp(ids, other_ids, length * sizeof *ids) == 0);
        votess_result_free(fresh);
        votess_result_free(result);
        for (size_t i = 0; i < 3 * count; ++i) points[i] += (points[i] < 0.5 ? 1e-4 : -1e-4) * (double)(i % 7);
    }
    const float few[6] = {0.25f, 0.25f, 0.25f, 0.75f, 0.5f, 0.5f};
    CHECK(votess_tessellate_f32(tessellator, few, 2, &options, &result) == VOTESS_OK);
    CHECK(votess_result_size(result) == 2);
    votess_result_free(result);
    free(points);
}

// One tessellator used by several at once.
struct shared_use {
    votess_tessellator* tessellator;
    const double* points;
    size_t count;
    int calls, refused;
    votess_tessellator* to_free;
};

static int use_again(double fraction, void* user) {
    struct shared_use* use = user;
    (void)fraction;
    votess_result* result = NULL;
    ++use->calls;
    CHECK_FAILS(votess_tessellate(use->tessellator, use->points, use->count, NULL, &result), VOTESS_ERROR_INVALID_USE,
                "in use by another call");
    CHECK(result == NULL);
    return 1;
}

static int free_once(double fraction, void* user) {
    struct shared_use* use = user;
    (void)fraction;
    ++use->calls;
    votess_tessellator_free(use->to_free);
    use->to_free = NULL;
    return 1;
}

static void* use_often(void* user) {
    struct shared_use* use = user;
    for (int k = 0; k < 100; ++k) {
        votess_result* result = NULL;
        const votess_status status = votess_tessellate(use->tessellator, use->points, use->count, NULL, &result);
        ++use->calls;
        if (status == VOTESS_ERROR_INVALID_USE && result == NULL) ++use->refused;
        if (status == VOTESS_OK && votess_result_size(result) != use->count) use->calls = -1000;
        if (status != VOTESS_OK && status != VOTESS_ERROR_INVALID_USE) use->calls = -1000;
        votess_result_free(result);
    }
    return NULL;
}

static void check_one_call_at_a_time(votess_tessellator* tessellator) {
    const size_t count = 300;
    double* points = random_points(count, 5);
    struct shared_use use = {tessellator, points, count, 0, 0, NULL};
    votess_options options = options_with_box(1);
    options.progress = use_again;
    options.progress_user = &use;
    votess_result* result = NULL;
    CHECK(votess_tessellate(tessellator, points, count, &options, &result) == VOTESS_OK);
    CHECK(use.calls > 0 && votess_result_size(result) == count);
    votess_result_free(result);

    enum { threads = 4 };
    pthread_t thread[threads];
    struct shared_use uses[threads];
    for (int k = 0; k < threads; ++k) {
        uses[k] = (struct shared_use){tessellator, points, count, 0, 0, NULL};
        CHECK(pthread_create(&thread[k], NULL, use_often, &uses[k]) == 0);
    }
    int refused = 0;
    for (int k = 0; k < threads; ++k) {
        CHECK(pthread_join(thread[k], NULL) == 0);
        CHECK(uses[k].calls == 100);
        refused += uses[k].refused;
    }
    CHECK(refused < threads * 100);

    // Freed by its own callback.
    votess_tessellator* freed = NULL;
    CHECK(votess_tessellator_new(&freed) == VOTESS_OK);
    use = (struct shared_use){tessellator, points, count, 0, 0, freed};
    options.progress = free_once;
    CHECK(votess_tessellate(freed, points, count, &options, &result) == VOTESS_OK);
    CHECK(use.calls > 0 && votess_result_size(result) == count);
    votess_result_free(result);
    free(points);
}

// The thread sanitizer knows no threads of children.
#if defined __has_feature
#if __has_feature(thread_sanitizer)
#define __SANITIZE_THREAD__ 1
#endif
#endif
#if defined __SANITIZE_THREAD__
static const uint32_t child_threads = 1;
#else
static const uint32_t child_threads = 3;
#endif

// A child made by fork() uses and frees the tessellator of its parent.
static void check_fork(void) {
    const size_t count = 5000;
    double* points = random_points(count, 6);
    votess_tessellator* tessellator = NULL;
    CHECK(votess_tessellator_new(&tessellator) == VOTESS_OK);
    votess_options options = options_with_box(1);
    options.device = "cpu";
    options.threads = 3;
    votess_result* result = NULL;
    CHECK(votess_tessellate(tessellator, points, count, &options, &result) == VOTESS_OK);
    for (int uses = 0; uses < 2; ++uses) {
        fflush(stderr);
        const pid_t child = fork();
        CHECK(child >= 0);
        if (child == 0) {
            alarm(60);  // ends one that hangs
            failures = 0;
            votess_result* again = NULL;
            options.threads = child_threads;
            if (uses > 0) {
                CHECK(votess_tessellate(tessellator, points, count, &options, &again) == VOTESS_OK);
                size_t length = 0, other_length = 0;
                const int32_t* ids = votess_result_indices(result, &length);
                const int32_t* other_ids = votess_result_indices(again, &other_length);
                CHECK(ids != NULL && other_ids != NULL && length == other_length);
                if (failures == 0) CHECK(memcmp(ids, other_ids, length * sizeof *ids) == 0);
            }
            votess_result_free(again);
            votess_tessellator_free(tessellator);
            votess_result_free(result);
            _exit(failures == 0 ? 0 : 1);
        }
        int status = 1;
        CHECK(waitpid(child, &status, 0) == child);
        CHECK(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    }
    votess_result_free(result);
    CHECK(votess_tessellate(tessellator, points, count, &options, &result) == VOTESS_OK);
    votess_result_free(result);
    votess_tessellator_free(tessellator);
    free(points);
}

static void check_result_outlives_tessellator(void) {
    votess_tessellator* tessellator = NULL;
    CHECK(votess_tessellator_new(&tessellator) == VOTESS_OK && tessellator != NULL);
    const votess_options options = options_with_box(2);
    votess_result* first = NULL;
    votess_result* second = NULL;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &first) == VOTESS_OK);
    CHECK(votess_tessellate(tessellator, cube, 4, &options, &second) == VOTESS_OK);
    votess_tessellator_free(tessellator);
    CHECK(votess_result_size(first) == 8 && votess_result_size(second) == 4);
    const double* volumes = votess_result_volumes(first, NULL);
    CHECK(volumes != NULL && fabs(volumes[3] - 1) < 1e-13);
    votess_result_free(first);
    volumes = votess_result_volumes(second, NULL);
    CHECK(volumes != NULL && fabs(volumes[3] - 2) < 1e-13);
    votess_result_free(second);
}

static void check_devices(void) {
    const size_t count = votess_device_count();
    CHECK(count >= 1);
    int have_cpu = 0;
    for (size_t i = 0; i < count; ++i) {
        char id[64], name[256], description[1024], cut[3];
        CHECK(votess_device_info(i, id, sizeof id, name, sizeof name, description, sizeof description) == VOTESS_OK);
        CHECK(strlen(id) > 0 && strlen(name) > 0);
        if (strcmp(id, "cpu") == 0) have_cpu = 1;
        CHECK(votess_device_info(i, cut, sizeof cut, NULL, 0, NULL, 0) == VOTESS_OK);
        CHECK(strlen(cut) <= 2 && strncmp(cut, id, strlen(cut)) == 0);

        votess_options options = options_with_box(2);
        options.device = id;
        votess_result* result = NULL;
        CHECK(votess_tessellate(NULL, cube, 8, &options, &result) == VOTESS_OK);
        votess_result_free(result);
    }
    CHECK(have_cpu == 1);
    // What this machine may lack is there or told to be missing.
    const char* const others[] = {"gpu", "lavapipe", "0", "999999"};
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
        votess_options options = options_with_box(2);
        options.device = others[i];
        votess_result* result = NULL;
        const votess_status status = votess_tessellate(NULL, cube, 8, &options, &result);
        CHECK(status == VOTESS_OK || status == VOTESS_ERROR_UNSUPPORTED);
        CHECK((status == VOTESS_OK) == (result != NULL));
        votess_result_free(result);
    }
    char id[8];
    CHECK_FAILS(votess_device_info(count, id, sizeof id, NULL, 0, NULL, 0), VOTESS_ERROR_INVALID_ARGUMENT, "index is");
    CHECK_FAILS(votess_device_info(0, id, sizeof id, NULL, 8, NULL, 0), VOTESS_ERROR_INVALID_ARGUMENT, "name");
}

int main(void) {
    check_version();
    votess_tessellator* tessellator = NULL;
    CHECK(votess_tessellator_new(&tessellator) == VOTESS_OK && tessellator != NULL);
    check_cube(NULL);
    check_cube(tessellator);
    check_mesh(tessellator);
    check_null_result();
    check_walls_and_defaults();
    check_empty_and_float(tessellator);
    check_duplicates(tessellator);
    check_bad_input(tessellator);
    check_tuning(tessellator);
    check_first_struct_sizes(tessellator);
    check_struct_sizes(tessellator);
    check_callbacks(tessellator);
    check_moving(tessellator);
    check_one_call_at_a_time(tessellator);
    votess_tessellator_free(tessellator);
    check_fork();
    check_result_outlives_tessellator();
    check_devices();
    if (failures != 0) {
        fprintf(stderr, "c_consumer: %d checks failed\n", failures);
        return 1;
    }
    printf("c_consumer: votess %s, all checks passed\n", votess_version_string());
    return 0;
}

// Uses the C interface as a C program does: lists and volumes, refusals, sizes of structs, callbacks, devices, a
// diagram, a stream. Results in depth are checked through Python, which calls every function of votess.h. Prints each
// check that fails; returns 0 when all pass.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <votess/frames.h>
#include <votess/stream.h>
#include <votess/votess.h>

static int failures = 0;

#define CHECK(condition)                                                                                 \
    do {                                                                                                 \
        if (!(condition)) {                                                                              \
            fprintf(stderr, "%s:%d: not true: %s; last error: \"%s\"\n", __FILE__, __LINE__, #condition, \
                    votess_last_error());                                                                \
            ++failures;                                                                                  \
        }                                                                                                \
    } while (0)

// The call must fail with this status and a message of one line that holds this text.
#define CHECK_FAILS(call, expected, text)                                                                             \
    do {                                                                                                              \
        const votess_status status_ = (call);                                                                         \
        const char* message_ = votess_last_error();                                                                   \
        if (status_ != (expected) || strstr(message_, text) == NULL || strchr(message_, '\n') != NULL) {              \
            fprintf(stderr, "%s:%d: %s: status %d, message \"%s\"; expected %d, \"%s\"\n", __FILE__, __LINE__, #call, \
                    (int)status_, message_, (int)(expected), text);                                                   \
            ++failures;                                                                                               \
        }                                                                                                             \
    } while (0)
#define CHECK_REFUSES(call, text) CHECK_FAILS(call, VOTESS_ERROR_INVALID_ARGUMENT, text)

// Returns the first element of an array and sets *length to its rows. A failure is reported.
static const void* data_of(votess_status status, const votess_array* array, size_t* length) {
    CHECK(status == VOTESS_OK);
    if (length != NULL) *length = array->length;
    return array->data;
}
static votess_array last;
// ARRAY(zones, handle, "labels", &length)
#define ARRAY(type, handle, name, length) data_of(votess_##type##_array(handle, name, &last), &last, length)

// Corners of a cube of side 1 in the middle of a box of side 2. Bit 4 of a number is x, bit 2 is y, bit 1 is z.
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

// Eight unit cubes, each with three neighbors and three walls.
static void check_cube(const votess_result* result) {
    size_t length = 99;
    CHECK(votess_result_size(result) == 8);
    const int64_t* indptr = ARRAY(result, result, "indptr", &length);
    CHECK(indptr != NULL && length == 9);
    CHECK(last.kind == 'i' && last.bytes == 8 && last.components == 1);
    const int32_t* indices = ARRAY(result, result, "indices", &length);
    CHECK(indices != NULL && length == 24 && indices == ARRAY(result, result, "indices", NULL));
    CHECK(last.kind == 'i' && last.bytes == 4);
    const double* volumes = ARRAY(result, result, "volumes", &length);
    CHECK(volumes != NULL && length == 8 && last.kind == 'f' && last.bytes == 8);
    const uint8_t* status = ARRAY(result, result, "status", &length);
    CHECK(status[7] == VOTESS_CELL_CERTIFIED && length == 8 && last.kind == 'u' && last.bytes == 1);
    for (int i = 0; failures == 0 && i < 8; ++i) {
        CHECK(indptr[i] == 3 * i && indptr[i + 1] == 3 * (i + 1) && fabs(volumes[i] - 1) < 1e-13);
        for (int64_t k = indptr[i]; k < indptr[i + 1]; ++k) {
            const int changed = indices[k] ^ i;
            CHECK(changed == 1 || changed == 2 || changed == 4);
            CHECK(k == indptr[i] || indices[k] > indices[k - 1]);
        }
    }
    CHECK(ARRAY(result, result, "centroids", &length) == NULL && length == 0 && last.components == 3);  // not wanted
    const double* box = ARRAY(result, result, "box", &length);
    CHECK(length == 2 && last.components == 3 && box[0] == 0 && box[5] == 2);
    CHECK(ARRAY(result, result, "cell", &length) == NULL && length == 0);  // not triclinic
    last.length = 5;
    CHECK_REFUSES(votess_result_array(result, "volume", &last), "name is 'volume': the arrays of result are indices, ");
    CHECK(last.data == NULL && last.length == 0 &&
          strstr(votess_last_error(), ", weights, box, periodic, cell, walls") != NULL);
    CHECK_REFUSES(votess_result_array(result, NULL, &last), "name is NULL");
    CHECK_REFUSES(votess_result_array(result, "volumes", NULL), "array is NULL");

    votess_stats stats;
    memset(&stats, 0xff, sizeof stats);
    stats.struct_size = sizeof stats;
    CHECK(votess_result_stats(result, &stats) == VOTESS_OK);
    CHECK(stats.points == 8 && stats.faces == 48 && stats.duplicates == 0 && fabs(stats.volume_sum - 8) < 1e-12);
    CHECK(memchr(stats.device, 0, sizeof stats.device) != NULL && stats.device[0] != '\0');
}

static void check_tessellations(void) {
    votess_tessellator* tessellator = NULL;
    CHECK(votess_tessellator_new(&tessellator) == VOTESS_OK && tessellator != NULL);
    const votess_options options = options_with_box(2);
    float narrow[24];
    for (int i = 0; i < 24; ++i) narrow[i] = (float)cube[i];
    votess_result *first = NULL, *second = NULL, *none = NULL;
    CHECK(votess_tessellate(tessellator, cube, 8, &options, &first) == VOTESS_OK);
    CHECK(votess_tessellate_f32(tessellator, narrow, 8, &options, &second) == VOTESS_OK);
    CHECK(votess_tessellate(tessellator, NULL, 0, NULL, &none) == VOTESS_OK && votess_result_size(none) == 0);
    votess_tessellator_free(tessellator);  // results outlive it
    check_cube(first);
    check_cube(second);
    votess_result_free(second);
    votess_result_free(none);

    int passed = 0;
    uint32_t skipped = 0;
    size_t sampled = 0;
    uint64_t tiny = 5;
    char failure[256] = "x", unproven[256] = "x", cut[6] = "xxxxx";
    CHECK(votess_verify(first, cube, 8, 3, 1, &passed, NULL, &skipped, &sampled, &tiny, failure, sizeof failure,
                        unproven, sizeof unproven) == VOTESS_OK);
    CHECK(passed == 1 && sampled == 3 && tiny == 0 && strcmp(failure, "") == 0 && strstr(unproven, "sampled") != NULL);
    double moved[24];
    memcpy(moved, cube, sizeof moved);
    moved[0] = 0.75;
    CHECK(votess_verify(first, moved, 8, 8, 1, &passed, NULL, NULL, NULL, NULL, failure, sizeof failure, NULL, 0) ==
          VOTESS_OK);
    CHECK(passed == 0 && strlen(failure) > 5);
    CHECK(votess_verify(first, moved, 8, 8, 1, &passed, NULL, NULL, NULL, NULL, cut, sizeof cut, NULL, 0) == VOTESS_OK);
    CHECK(strlen(cut) == 5 && strncmp(cut, failure, 5) == 0);
    CHECK_REFUSES(votess_verify(first, cube, 7, 8, 1, &passed, NULL, NULL, NULL, NULL, NULL, 0, NULL, 0), "8 cells");
    CHECK_REFUSES(votess_verify(first, cube, 8, 8, 1, &passed, NULL, NULL, NULL, NULL, NULL, 4, NULL, 0), "failure");
    CHECK_REFUSES(votess_verify(first, cube, 8, 8, 1, &passed, NULL, NULL, NULL, NULL, NULL, 0, NULL, 4), "unproven");
    votess_result_free(first);

    CHECK(votess_result_size(NULL) == 0);
    CHECK_REFUSES(votess_result_array(NULL, "volumes", &last), "result is NULL");
    CHECK(last.data == NULL && last.length == 0);
    votess_stats stats;
    stats.struct_size = sizeof stats;
    CHECK_REFUSES(votess_result_stats(NULL, &stats), "result");
    votess_result_free(NULL);
    votess_tessellator_free(NULL);
}

// The cube as a mesh, around one seed at each of its corners.
static int count_bytes(const votess_bytes* bytes, void* user) {
    *(uint64_t*)user += bytes->count;
    return 1;
}

static int count_files(const votess_bytes* piece, void* user) {
    *(int*)user += piece->file != NULL && piece->count > 0;
    return 1;
}

// The result: eight cubes, each with three faces inside.
static void check_pieces(const votess_result* result) {
    votess_pieces* pieces = NULL;
    CHECK_REFUSES(votess_pieces_new(result, -1, 1, NULL, NULL, &pieces), "gap is -1");
    CHECK_REFUSES(votess_pieces_new(NULL, 0, 1, NULL, NULL, &pieces), "result");
    CHECK(votess_pieces_new(result, 0, 5000, NULL, NULL, &pieces) == VOTESS_ERROR_INVALID_ARGUMENT);
    CHECK(strncmp(votess_last_error(), "threads = 5000: give", 20) == 0);  // the parameter
    CHECK(pieces == NULL && votess_pieces_new(result, 0, 1, NULL, NULL, &pieces) == VOTESS_OK);
    size_t length = 0;
    const double* volumes = ARRAY(pieces, pieces, "volumes", &length);
    CHECK(fabs(volumes[7] - 0.125) < 1e-14 && length == 8);
    const int64_t ids[8] = {8, 7, 6, 5, 4, 3, 2, 1};
    votess_piece_arrays arrays = {sizeof arrays,
                                  0,
                                  8,
                                  ARRAY(pieces, pieces, "indptr", NULL),
                                  ids,
                                  ARRAY(pieces, pieces, "vertex_offsets", NULL),
                                  ARRAY(pieces, pieces, "vertices", NULL),
                                  ARRAY(pieces, pieces, "triangle_offsets", NULL),
                                  ARRAY(pieces, pieces, "triangles", NULL),
                                  ARRAY(pieces, pieces, "on_surface", &length),
                                  ARRAY(pieces, pieces, "centroids", NULL),
                                  ARRAY(pieces, pieces, "sources", NULL),
                                  0,
                                  NULL,
                                  NULL};
    CHECK(length == (size_t)arrays.triangle_offsets[8]);
    CHECK(ARRAY(pieces, pieces, "sources", &length) != NULL && length == (size_t)arrays.triangle_offsets[8]);
    uint64_t bytes = 0;
    CHECK(votess_write_pieces(&arrays, ".stl", count_bytes, &bytes) == VOTESS_OK && bytes == 84 + 50 * length);
    int files = 0;
    CHECK(votess_write_pieces(&arrays, ".foam", count_files, &files) == VOTESS_OK && files == 5);
    votess_mesh_quality quality = {0};
    CHECK_REFUSES(votess_measure_pieces(&arrays, &quality), "quality.struct_size");
    quality.struct_size = sizeof quality;
    CHECK(votess_measure_pieces(&arrays, &quality) == VOTESS_OK && quality.cells == 8 && quality.wrong_cells == 0);
    const int32_t* const sources = arrays.sources;
    arrays.sources = NULL;
    CHECK_REFUSES(votess_write_pieces(&arrays, ".foam", count_files, &files), "pieces.sources is NULL");
    const int32_t far_away[3] = {-1, 8, 8};
    arrays.sources = far_away;
    CHECK_REFUSES(votess_write_pieces(&arrays, ".foam", count_files, &files), "pieces.sources[0] is -1");
    arrays.sources = sources;
    CHECK_REFUSES(votess_write_pieces(&arrays, ".vtu", count_bytes, &bytes), "known are .glb .obj .stl .3mf");
    CHECK_REFUSES(votess_write_pieces(&arrays, ".stl", NULL, NULL), "write");
    CHECK_REFUSES(votess_write_pieces(NULL, ".stl", count_bytes, &bytes), "pieces");
    const int32_t wrong[3] = {0, 1, 99};
    const int64_t one[9] = {0, 1, 1, 1, 1, 1, 1, 1, 1};
    arrays.triangles = wrong;
    arrays.triangle_offsets = one;
    CHECK_REFUSES(votess_write_pieces(&arrays, ".obj", count_bytes, &bytes), "pieces.triangles[2] is 99");
    arrays.centroids = NULL;
    arrays.triangles = NULL;
    CHECK_REFUSES(votess_write_pieces(&arrays, ".obj", count_bytes, &bytes), "pieces.triangles is NULL");
    arrays.struct_size = 8;
    CHECK_REFUSES(votess_write_pieces(&arrays, ".obj", count_bytes, &bytes), "struct_size");
    votess_pieces_free(pieces);
    votess_pieces_free(NULL);
    CHECK_REFUSES(votess_pieces_array(NULL, "volumes", &last), "pieces is NULL");
}

static void check_mesh(void) {
    static const int32_t triangles[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                          2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    votess_options options;
    CHECK(votess_options_init(&options, sizeof options) == VOTESS_OK);
    options.want = VOTESS_WANT_VOLUMES | VOTESS_WANT_SURFACES | VOTESS_WANT_NEIGHBORS;
    options.has_mesh = 1;
    options.mesh_vertices = cube;
    options.mesh_vertex_count = 8;
    options.mesh_triangles = triangles;
    options.mesh_triangle_count = 12;
    votess_result* result = NULL;
    CHECK(votess_tessellate(NULL, cube, 8, &options, &result) == VOTESS_OK);
    CHECK(votess_result_in_mesh(result) == 1 && votess_result_in_mesh(NULL) == 0);
    size_t length = 0;
    const double* volumes = ARRAY(result, result, "volumes", &length);
    CHECK(length == 8);
    for (size_t i = 0; i < length; ++i) CHECK(fabs(volumes[i] - 0.125) < 1e-14);
    const double* areas = ARRAY(result, result, "mesh_areas", &length);
    CHECK(length == 8);
    for (size_t i = 0; i < length; ++i) CHECK(fabs(areas[i] - 0.75) < 1e-14);
    CHECK(ARRAY(result, result, "indices", &length) != NULL && length == 24);
    check_pieces(result);
    votess_result_free(result);
}

// Numbers that only C can pass: enums beyond their values, which a conversion to a byte would hide, and counts without
// their array.
static void check_refusals(void) {
    const votess_options good = options_with_box(2);
    votess_options options = good;
    votess_result* result = (votess_result*)&options;  // a failure sets it to NULL
    CHECK_REFUSES(votess_tessellate(NULL, NULL, 8, &good, &result), "points");
    CHECK(result == NULL);
    CHECK_REFUSES(votess_tessellate(NULL, cube, SIZE_MAX / 2, &good, &result), "count");
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &good, NULL), "out");
    CHECK_REFUSES(votess_tessellator_new(NULL), "out");
    options.want |= 1u << 20;
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result), "1048576");
    options = good;
    options.duplicates = 2;
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result), "duplicates = 2");
    options = good;
    options.outside = 256;
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result), "options.outside = 256");
    options = good;
    options.precision = VOTESS_PRECISION_DOUBLE + 256;
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result), "precision = 257");
    options = good;
    options.wall_count = 2;
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result), "wall_count is 2");
    options = good;
    options.has_mesh = 1;
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result), "options.mesh: it has no triangles");
    options.mesh_triangle_count = 4;
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result), "options.mesh_triangles");
    options = good;
    options.device = "abacus\n";
    CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result), "abacus");
    CHECK(result == NULL);
    // A success keeps the message of the last failure.
    CHECK(votess_tessellate(NULL, cube, 8, &good, &result) == VOTESS_OK);
    CHECK(strstr(votess_last_error(), "abacus") != NULL);
    votess_result_free(result);
}

static void check_struct_sizes(void) {
    votess_options options;
    CHECK_REFUSES(votess_options_init(NULL, sizeof options), "options");
    CHECK_REFUSES(votess_options_init(&options, 0), "size is 0");
    CHECK_REFUSES(votess_options_init(&options, 16), "size is 16");
    CHECK_REFUSES(votess_options_init(&options, (size_t)-1), "largest known is 4096");
    votess_result* result = NULL;
    options = options_with_box(2);
    const uint32_t wrong[] = {0, offsetof(votess_options, log_user), VOTESS_LARGEST_STRUCT + 1, 0xffffffffu};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        options.struct_size = wrong[i];
        CHECK_REFUSES(votess_tessellate(NULL, cube, 8, &options, &result),
                      i < 2 ? "smallest" : "largest known is 4096");
    }
    CHECK(result == NULL);

    // A program built against a newer header: the library neither reads nor writes the fields that it lacks.
    struct newer_options {
        votess_options options;
        unsigned char beyond[64];
    } newer;
    memset(&newer, 0xee, sizeof newer);
    CHECK(votess_options_init(&newer.options, sizeof newer) == VOTESS_OK);
    CHECK(newer.options.struct_size == sizeof(votess_options));
    for (size_t i = 0; i < sizeof newer.beyond; ++i) CHECK(newer.beyond[i] == 0xee);
    newer.options.struct_size = sizeof newer;
    CHECK(votess_tessellate(NULL, cube, 8, &newer.options, &result) == VOTESS_OK);
    struct newer_stats {
        votess_stats stats;
        unsigned char beyond[64];
    } stats;
    memset(&stats, 0xee, sizeof stats);
    stats.stats.struct_size = sizeof stats;
    CHECK(votess_result_stats(result, &stats.stats) == VOTESS_OK);
    CHECK(stats.stats.struct_size == sizeof stats && stats.stats.points == 8);
    for (size_t i = 0; i < sizeof stats.beyond; ++i) CHECK(stats.beyond[i] == 0xee);
    const uint32_t wrong_stats[] = {0, 40, 0xffffffffu};
    for (size_t i = 0; i < sizeof wrong_stats / sizeof *wrong_stats; ++i) {
        stats.stats.struct_size = wrong_stats[i];
        CHECK_REFUSES(votess_result_stats(result, &stats.stats), i < 2 ? "smallest" : "largest");
    }
    votess_result_free(result);
}

struct calls {
    votess_tessellator* tessellator;  // the one that is running; freed by the first call of `free_it`
    int count, lines;
    int stop;  // the call that cancels; 0: none
    double last_fraction;
};

static int on_progress(double fraction, void* user) {
    struct calls* calls = user;
    CHECK(fraction >= calls->last_fraction && fraction <= 1);
    calls->last_fraction = fraction;
    votess_result* result = NULL;
    CHECK_FAILS(votess_tessellate(calls->tessellator, cube, 8, NULL, &result), VOTESS_ERROR_INVALID_USE,
                "in use by another call");
    return ++calls->count != calls->stop;
}

static int free_it(double fraction, void* user) {
    struct calls* calls = user;
    (void)fraction;
    ++calls->count;
    votess_tessellator_free(calls->tessellator);
    calls->tessellator = NULL;
    return 1;
}

static void on_log(const char* message, void* user) {
    ++((struct calls*)user)->lines;
    CHECK(strlen(message) > 0 && strchr(message, '\n') == NULL);
}

static void check_callbacks(void) {
    votess_options options = options_with_box(2);
    struct calls calls = {NULL, 0, 0, 0, 0};
    CHECK(votess_tessellator_new(&calls.tessellator) == VOTESS_OK);
    options.progress = on_progress;
    options.log = on_log;
    options.progress_user = options.log_user = &calls;
    votess_result* result = NULL;
    CHECK(votess_tessellate(calls.tessellator, cube, 8, &options, &result) == VOTESS_OK);
    CHECK(calls.count > 0 && calls.last_fraction == 1);
    votess_result_free(result);
    calls.stop = calls.count + 1;
    calls.last_fraction = 0;
    CHECK_FAILS(votess_tessellate(calls.tessellator, cube, 8, &options, &result), VOTESS_ERROR_CANCELLED, "progress");
    CHECK(result == NULL && calls.count == calls.stop);
    // The tessellator serves on, and its own callback may free it.
    options.progress = free_it;
    CHECK(votess_tessellate(calls.tessellator, cube, 8, &options, &result) == VOTESS_OK);
    CHECK(votess_result_size(result) == 8 && calls.tessellator == NULL);
    votess_result_free(result);
}

static void check_devices(void) {
    const size_t count = votess_device_count();
    int have_cpu = 0;
    for (size_t i = 0; i < count; ++i) {
        char id[64], name[256], description[1024], cut[3];
        CHECK(votess_device_info(i, id, sizeof id, name, sizeof name, description, sizeof description) == VOTESS_OK);
        CHECK(strlen(id) > 0 && strlen(name) > 0);
        if (strcmp(id, "cpu") == 0) have_cpu = 1;
        CHECK(votess_device_info(i, cut, sizeof cut, NULL, 0, NULL, 0) == VOTESS_OK);
        CHECK(strlen(cut) <= 2 && strncmp(cut, id, strlen(cut)) == 0);
    }
    CHECK(have_cpu == 1);
    char id[8];
    CHECK_REFUSES(votess_device_info(count, id, sizeof id, NULL, 0, NULL, 0), "index is");
    CHECK_REFUSES(votess_device_info(0, id, sizeof id, NULL, 8, NULL, 0), "name");
}

static void check_diagram(void) {
    const votess_options options = options_with_box(2);
    votess_diagram* diagram = NULL;
    CHECK(votess_diagram_new(cube, 8, &options, &diagram) == VOTESS_OK && votess_diagram_size(diagram) == 8);
    // Inside of a cell, on a vertex of all eight, and outside.
    const double queries[9] = {1.9, 0.1, 1.9, 1, 1, 1, 3, 0, 0};
    int32_t seeds[3] = {9, 9, 9};
    CHECK(votess_diagram_locate(diagram, queries, 3, seeds) == VOTESS_OK);
    CHECK(seeds[0] == 5 && seeds[1] == 0 && seeds[2] == -1);
    CHECK_FAILS(votess_diagram_locate(diagram, queries, (size_t)1 << 40, seeds), VOTESS_ERROR_UNSUPPORTED,
                "at most 2147483647");
    const size_t shape[3] = {1, 1, 1};
    double grid[1];
    CHECK_REFUSES(votess_diagram_to_grid(diagram, cube, 1, shape, 4, -1, grid, NULL), "method = 4");
    CHECK_REFUSES(votess_diagram_to_grid(diagram, cube, 1, shape, 0, 3, grid, NULL), "project = 3");
    const double along[6] = {1, 0, 0, 0, 1, 0}, lengths[2] = {0.5, 0.25}, backward[1] = {-1};
    votess_rays* rays = NULL;
    CHECK_REFUSES(votess_rays_new(diagram, queries, along, backward, 1, 0, &rays), "its length -1");
    CHECK(rays == NULL);
    CHECK(votess_rays_new(diagram, queries, along, lengths, 2, 1, &rays) == VOTESS_OK);
    size_t rows = 0, pieces = 0;
    const int64_t* offsets = ARRAY(rays, rays, "offsets", &rows);
    CHECK(ARRAY(rays, rays, "lengths", &pieces) != NULL);
    CHECK(rows == 3 && offsets[0] == 0 && (size_t)offsets[2] == pieces);
    CHECK(*(const int32_t*)ARRAY(rays, rays, "seeds", NULL) == seeds[0]);
    CHECK(ARRAY(rays, rays, "middles", &rows) != NULL && rows == pieces && last.components == 3);
    votess_rays_free(rays);
    votess_rays_free(NULL);
    votess_natural* natural = NULL;
    CHECK_REFUSES(votess_natural_new(diagram, queries, 1, 9, 1, 0, NULL, &natural), "method is 9");
    votess_diagram_free(diagram);
    votess_diagram_free(NULL);
}

static void check_fit(void) {
    const votess_options options = options_with_box(2);
    // The plane between the seeds is at x = 0.5, where |x - p|^2 - w are equal.
    const double points[6] = {0.5, 1, 1, 1.5, 1, 1};
    const double targets[2] = {2, 6}, shares[2] = {1, 3};
    votess_fit_options fit_options;
    CHECK(votess_fit_options_init(&fit_options, sizeof fit_options) == VOTESS_OK);
    CHECK(fit_options.tolerance == 1e-9 && fit_options.max_steps == 200 && fit_options.normalize == 0);
    votess_fit* fit = NULL;
    CHECK_REFUSES(votess_fit_volumes(points, 2, shares, &options, NULL, &fit), "normalize");
    CHECK(fit == NULL);
    fit_options.normalize = 1;
    CHECK(votess_fit_volumes(points, 2, shares, &options, &fit_options, &fit) == VOTESS_OK);
    size_t length = 0;
    const double* weights = ARRAY(fit, fit, "weights", &length);
    CHECK(length == 2);
    const double error = weights[1] - weights[0] - 1;
    CHECK(error < 1e-8 && error > -1e-8);
    votess_fit_stats stats;
    stats.struct_size = 1;
    CHECK_REFUSES(votess_fit_get_stats(fit, &stats), "stats.struct_size is 1");
    stats.struct_size = sizeof stats;
    CHECK(votess_fit_get_stats(fit, &stats) == VOTESS_OK);
    CHECK(stats.steps > 0 && stats.tessellations > stats.steps && stats.residual <= 1e-9 && stats.seconds_total > 0);
    votess_result* result = NULL;
    CHECK(votess_fit_result(fit, &result) == VOTESS_OK);
    votess_fit_free(fit);
    CHECK(votess_result_size(result) == 2);
    votess_result_free(result);
    fit_options.max_steps = 0;
    CHECK_FAILS(votess_fit_volumes(points, 2, targets, &options, &fit_options, &fit), VOTESS_ERROR_NOT_CONVERGED,
                "raise fit_options.max_steps");
    weights = ARRAY(fit, fit, "weights", &length);
    CHECK(fit != NULL && weights[1] == 0 && length == 2);
    CHECK_REFUSES(votess_fit_result(fit, &result), "did not converge");
    CHECK(result == NULL);
    votess_fit_free(fit);
    votess_fit_free(NULL);
}

static void check_zones(void) {
    const votess_options options = options_with_box(2);
    const double values[8] = {1, 4, 5, 6, 7, 8, 3, 2};  // minima at the opposite corners 0 and 7
    votess_result* result = NULL;
    CHECK(votess_tessellate(NULL, cube, 8, &options, &result) == VOTESS_OK);
    votess_zones *zones = NULL, *merged = NULL;
    CHECK_REFUSES(votess_zones_new(result, NULL, 8, 0, &zones), "values");
    CHECK_REFUSES(votess_zones_new(result, values, 7, 0, &zones), "7 values for 8 seeds");
    CHECK_REFUSES(votess_zones_new(NULL, values, 8, 0, &zones), "result");
    CHECK(votess_zones_new(result, values, 8, 0, &zones) == VOTESS_OK);
    votess_result_free(result);
    size_t length = 0;
    const int32_t expected[8] = {0, 0, 0, 1, 0, 1, 1, 1};
    CHECK(memcmp(ARRAY(zones, zones, "labels", &length), expected, sizeof expected) == 0 && length == 8);
    CHECK_REFUSES(votess_zones_merge(zones, NAN, &merged), "threshold");
    CHECK(merged == NULL && votess_zones_merge(zones, 3, &merged) == VOTESS_OK);
    votess_zones_free(zones);
    const int32_t* cores = ARRAY(zones, merged, "cores", &length);
    CHECK(cores[0] == 0 && length == 1);
    votess_zones_free(merged);
    votess_zones_free(NULL);
    CHECK_REFUSES(votess_zones_array(NULL, "labels", &last), "zones is NULL");
}

static void check_groups(void) {
    votess_options options = options_with_box(2);
    options.want |= VOTESS_WANT_AREAS | VOTESS_WANT_SURFACES;
    const int64_t labels[8] = {7, 7, 7, 7, -3, -3, -3, -3};  // halves of the cube
    votess_result* result = NULL;
    CHECK(votess_tessellate(NULL, cube, 8, &options, &result) == VOTESS_OK);
    votess_groups* groups = NULL;
    CHECK_REFUSES(votess_groups_new(result, labels, 7, &groups), "7 labels for 8 seeds");
    CHECK_REFUSES(votess_groups_new(result, NULL, 8, &groups), "labels");
    CHECK(votess_groups_new(result, labels, 8, &groups) == VOTESS_OK);
    votess_result_free(result);
    size_t length = 0;
    const int64_t* names = ARRAY(groups, groups, "labels", &length);
    CHECK(names[0] == -3 && names[1] == 7 && length == 2);
    CHECK(ARRAY(groups, groups, "mesh_areas", &length) == NULL && length == 0);
    votess_groups_free(groups);
    votess_groups_free(NULL);
    CHECK_REFUSES(votess_groups_array(NULL, "labels", &last), "groups is NULL");
}

static int take_bytes(const votess_bytes* piece, void* user) {
    return piece != NULL && user == NULL;
}

static void check_mesh_indices(void) {
    const int64_t rows[2] = {0, 1}, corners_of[2] = {0, 3};
    const int32_t corners[3] = {0, 1, 2};
    int32_t neighbor = -1;
    votess_mesh mesh = {0};
    mesh.struct_size = sizeof mesh;
    mesh.cells = 1;
    mesh.vertex_count = 3;
    mesh.indptr = mesh.cell_vertex_indptr = rows;
    mesh.indices = &neighbor;
    mesh.face_offsets = corners_of;
    mesh.face_vertices = mesh.cell_vertex_indices = corners;
    mesh.vertices = cube;
    CHECK(votess_write_mesh(&mesh, ".ply", take_bytes, NULL) == VOTESS_OK);
    CHECK_REFUSES(votess_write_mesh(&mesh, ".foam", take_bytes, NULL), "cell 0 is not closed");
    const int64_t no_rows[1] = {0};
    votess_mesh empty = {0};
    empty.struct_size = sizeof empty;
    empty.indptr = empty.face_offsets = empty.cell_vertex_indptr = no_rows;
    int files = 0;
    CHECK(votess_write_mesh(&empty, ".foam", count_files, &files) == VOTESS_OK && files == 5);
    votess_mesh_quality quality = {0};
    CHECK_REFUSES(votess_measure_mesh(&empty, &quality), "quality.struct_size");
    quality.struct_size = sizeof quality;
    CHECK(votess_measure_mesh(&empty, &quality) == VOTESS_OK && quality.cells == 0);
    CHECK_REFUSES(votess_measure_mesh(&mesh, &quality), "cell 0 is not closed");
    neighbor = 1;
    CHECK_REFUSES(votess_write_mesh(&mesh, ".ply", take_bytes, NULL), "mesh.indices[0] is 1, but there are 1 cells");
}

static void check_network(void) {
    votess_options options = options_with_box(2);
    options.want |= VOTESS_WANT_FACES;
    votess_result* result = NULL;
    CHECK(votess_tessellate(NULL, cube, 8, &options, &result) == VOTESS_OK);
    votess_network* network = NULL;
    CHECK_REFUSES(votess_network_new(result, cube, 7, &network), "21 coordinates");
    double other[24];
    memcpy(other, cube, sizeof other);
    other[4] = NAN;
    CHECK_REFUSES(votess_network_new(result, other, 8, &network), "point 1: y = nan is not finite");
    CHECK(votess_network_new(result, cube, 8, &network) == VOTESS_OK);
    votess_result_free(result);
    size_t length = 0;
    CHECK(ARRAY(network, network, "points", &length) != NULL && length == 27 && last.components == 3);
    CHECK(ARRAY(network, network, "shifts", &length) == NULL && length == 0);
    double radius = 0;
    int32_t vertex = -1;
    CHECK(votess_network_largest_included(network, &radius, &vertex) == VOTESS_OK && vertex >= 0);
    const double* radii = ARRAY(network, network, "vertex_radii", &length);
    CHECK(radii[vertex] == radius && length == 27);
    votess_network_free(network);
    votess_network_free(NULL);
    CHECK_REFUSES(votess_network_array(NULL, "edges", &last), "network is NULL");
}

static void check_alpha(void) {
    const votess_options options = options_with_box(2);
    votess_result* result = NULL;
    CHECK(votess_tessellate(NULL, cube, 8, &options, &result) == VOTESS_OK);
    votess_alpha* alpha = NULL;
    const int32_t copies[3] = {1, 2, 1};
    CHECK_REFUSES(votess_alpha_new(result, cube, 8, copies, &alpha), "not periodic");
    CHECK_REFUSES(votess_alpha_new(result, cube, 7, NULL, &alpha), "21 coordinates");
    CHECK_REFUSES(votess_alpha_new(NULL, cube, 8, NULL, &alpha), "result");
    CHECK(alpha == NULL && votess_alpha_new(result, cube, 8, NULL, &alpha) == VOTESS_OK);
    votess_result_free(result);
    size_t length = 0;
    const double* values = data_of(votess_alpha_array(alpha, 3, "values", &last), &last, &length);
    CHECK(length == 6 && values[0] == 0.75 && values[5] == 0.75);  // the tetrahedra around a diagonal
    CHECK(votess_alpha_array(alpha, 1, "seeds", &last) == VOTESS_OK && last.length == 19 && last.components == 2);
    CHECK(data_of(votess_alpha_array(alpha, 0, "shifts", &last), &last, &length) == NULL && length == 0);
    CHECK_REFUSES(votess_alpha_array(alpha, 4, "values", &last), "k is 4");
    CHECK_REFUSES(votess_alpha_array(alpha, 0, "edges", &last),
                  "the arrays of alpha are seeds, shifts, values, gabriel");
    votess_alpha_free(alpha);
    votess_alpha_free(NULL);
    CHECK_REFUSES(votess_alpha_array(NULL, 0, "values", &last), "alpha is NULL");
}

#define SEEDS 3000

struct stream {
    const double* points;
    const votess_result* whole;
    size_t next, rows;
    int readings, stop;  // stop: the reading that cancels; 0: none
};

static int restart(void* user) {
    struct stream* stream = user;
    stream->next = 0;
    return ++stream->readings == stream->stop ? VOTESS_STREAM_STOP : VOTESS_STREAM_GO_ON;
}

static int next(votess_stream_seeds* seeds, void* user) {
    struct stream* stream = user;
    if (stream->next == SEEDS) return VOTESS_STREAM_END;
    seeds->count = SEEDS / 4;
    seeds->points = stream->points + 3 * stream->next;
    stream->next += seeds->count;
    return VOTESS_STREAM_GO_ON;
}

static int begin(const votess_stream_head* head, void* user) {
    (void)user;
    CHECK(head->seeds == SEEDS && head->duplicates == 0 && head->periodic == 0 && head->box_upper[1] == 1);
    return VOTESS_STREAM_GO_ON;
}

// The rows must be those of the whole result.
static int rows(const votess_stream_rows* some, void* user) {
    struct stream* stream = user;
    const int64_t* indptr = ARRAY(result, stream->whole, "indptr", NULL);
    const int32_t* indices = ARRAY(result, stream->whole, "indices", NULL);
    size_t volumes = 0, centroids = 0;
    (void)ARRAY(stream, some, "volumes", &volumes);
    (void)ARRAY(stream, some, "centroids", &centroids);
    CHECK(some->first == stream->rows && some->count > 0 && volumes == some->count && centroids == 0);
    const int64_t* of_rows = ARRAY(stream, some, "indptr", NULL);
    const int64_t* ids = ARRAY(stream, some, "indices", NULL);
    for (size_t i = 0; i <= some->count; ++i) CHECK(of_rows[i] == indptr[some->first + i]);
    for (size_t e = 0; e < some->entries; ++e) CHECK(ids[e] == indices[(size_t)of_rows[0] + e]);
    stream->rows += some->count;
    return VOTESS_STREAM_GO_ON;
}

static void check_stream(void) {
    static double points[3 * SEEDS];
    uint64_t state = 5;
    for (size_t i = 0; i < 3 * SEEDS; ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 9007199254740992.0;
    }
    votess_options options = options_with_box(1);
    options.device = "cpu";
    votess_result* whole = NULL;
    CHECK(votess_tessellate(NULL, points, SEEDS, &options, &whole) == VOTESS_OK);
    struct stream user = {points, whole, 0, 0, 0, 0};
    votess_stream stream = {sizeof stream, 1, 1000000, NULL, restart, next, begin, rows, &user, 0, 0};
    votess_stream_counts counts = {sizeof counts, 0, 0, 0, 0, 0, 0, 0, 0, "", ""};
    votess_stats stats;
    stats.struct_size = sizeof stats;
    CHECK(votess_tessellate_stream(&stream, &options, &counts, &stats) == VOTESS_OK);
    CHECK(user.rows == SEEDS && counts.blocks > 1 && counts.passed == 1 && counts.failure[0] == '\0');
    CHECK(stats.points == SEEDS && fabs(stats.volume_sum - 1) < 1e-6);
    user.stop = user.readings + 1;
    CHECK_FAILS(votess_tessellate_stream(&stream, &options, &counts, NULL), VOTESS_ERROR_CANCELLED, "callback restart");
    CHECK_REFUSES(votess_tessellate_stream(&stream, &options, NULL, NULL), "needs counts");
    stream.memory = 5;
    CHECK_REFUSES(votess_tessellate_stream(&stream, &options, &counts, NULL), "stream.memory = 5 bytes is too little");
    stream.verify = 2;
    CHECK_REFUSES(votess_tessellate_stream(&stream, &options, &counts, NULL), "verify is 2");
    stream.rows = NULL;
    CHECK_REFUSES(votess_tessellate_stream(&stream, &options, NULL, NULL), "stream.rows");
    stream.struct_size = 4;
    CHECK_REFUSES(votess_tessellate_stream(&stream, &options, NULL, NULL), "struct_size");
    CHECK_REFUSES(votess_tessellate_stream(NULL, NULL, NULL, NULL), "stream is NULL");
    votess_result_free(whole);
}

// Refusals, which open no device; tests in Python have one.
static void check_frames(void) {
    votess_options options = options_with_box(2);
    options.device = "cpu";
    votess_frames_options frames = {0};
    votess_frames* made = (votess_frames*)&frames;
    votess_frame_cells* cells = (votess_frame_cells*)&frames;
    CHECK_REFUSES(votess_frames_new(&frames, &options, NULL, &made), "frames.struct_size is 0");
    CHECK(made == NULL);
    frames.struct_size = sizeof frames;
    CHECK_REFUSES(votess_frames_new(NULL, &options, NULL, &made), "frames is NULL");
    CHECK_REFUSES(votess_frames_new(&frames, &options, NULL, &made), "max_points = 0");
    frames.max_points = 10;
    CHECK_REFUSES(votess_frames_new(&frames, NULL, NULL, &made), "options.box is missing");
    CHECK_REFUSES(votess_frames_new(&frames, &options, NULL, &made), "options.device = cpu");
    options.outside = VOTESS_OUTSIDE_KEEP;
    CHECK_REFUSES(votess_frames_new(&frames, &options, NULL, &made), "options.outside = keep");
    CHECK_REFUSES(votess_frames_run(NULL, cube, NULL, 8, &cells), "frames is NULL");
    CHECK(cells == NULL);
    CHECK_REFUSES(votess_frames_resolve(NULL, &cells), "frames is NULL");
    CHECK_REFUSES(votess_frames_device(NULL, NULL, 0), "frames is NULL");
    CHECK_REFUSES(votess_frame_cells_array(NULL, "status", &last), "cells is NULL");
    CHECK(votess_frame_cells_unresolved(NULL) == 0 && votess_frame_cells_kept(NULL) == 0);
    options.outside = VOTESS_OUTSIDE_DROP;
    frames.exported = 5;
    CHECK_REFUSES(votess_frames_new(&frames, &options, NULL, &made), "frames.exported = 5");
    votess_frames_export arrays = {0};
    CHECK_REFUSES(votess_frames_get_export(NULL, &arrays), "frames is NULL");
    CHECK_REFUSES(votess_frames_submit(NULL, 1, 1, 2), "frames is NULL");
    CHECK_REFUSES(votess_frames_signal(NULL, 1), "frames is NULL");
    CHECK_REFUSES(votess_frames_wait(NULL, 1), "frames is NULL");
    CHECK_REFUSES(votess_frames_resolve_exported(NULL, NULL), "frames is NULL");
    votess_frames_free(NULL);
    votess_frame_cells_free(NULL);
}

int main(void) {
    check_version();
    check_tessellations();
    check_mesh();
    check_refusals();
    check_struct_sizes();
    check_callbacks();
    check_devices();
    check_diagram();
    check_fit();
    check_zones();
    check_groups();
    check_mesh_indices();
    check_network();
    check_alpha();
    check_stream();
    check_frames();
    if (failures != 0) {
        fprintf(stderr, "c_consumer: %d checks failed\n", failures);
        return 1;
    }
    printf("c_consumer: votess %s, all checks passed\n", votess_version_string());
    return 0;
}

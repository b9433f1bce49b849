// Options: what is refused, what they imply, and structs of other sizes.
#include <math.h>
#include <stddef.h>

#include "check.h"

void check_bad_input(votess_tessellator* tessellator) {
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
                "duplicates = 2");
    options = good;
    options.outside = 256;  // not cut to a byte
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "outside = 256");
    options = good;
    options.wall_count = 2;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "wall_count is 2");
    options = good;
    options.threads = 5000;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT, "5000");
    options = good;
    options.precision = -1;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "precision = -1");
    options.precision = 2;
    CHECK_FAILS(votess_tessellate(tessellator, cube, 8, &options, &result), VOTESS_ERROR_INVALID_ARGUMENT,
                "precision = 2");
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

void check_implied_want(void) {
    votess_options options;
    CHECK(votess_options_init(&options, sizeof options) == VOTESS_OK);
    const struct {
        uint32_t want;
        double min_face;
        uint32_t implied;
    } cases[] = {
        {0, 0, 0},
        {VOTESS_WANT_VOLUMES, 0, VOTESS_WANT_VOLUMES},
        {0, 0.5, VOTESS_WANT_AREAS | VOTESS_WANT_NEIGHBORS},
        {VOTESS_WANT_NORMALS, 0, VOTESS_WANT_NORMALS | VOTESS_WANT_NEIGHBORS},
        {VOTESS_WANT_FACES, 0, VOTESS_WANT_FACES | VOTESS_WANT_VERTICES | VOTESS_WANT_NEIGHBORS},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        uint32_t want = 1u << 30;
        options.want = cases[i].want;
        options.min_face = cases[i].min_face;
        CHECK(votess_options_implied_want(&options, &want) == VOTESS_OK && want == cases[i].implied);
    }
    const double none[1] = {0};
    uint32_t want = 0;
    CHECK(votess_options_implied_want(NULL, &want) == VOTESS_OK);
    CHECK(want == (VOTESS_WANT_NEIGHBORS | VOTESS_WANT_VOLUMES));
    options.weights = options.radii = none;
    CHECK_FAILS(votess_options_implied_want(&options, &want), VOTESS_ERROR_INVALID_ARGUMENT, "weights and radii");
    CHECK_FAILS(votess_options_implied_want(&options, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "want");
}

void check_want_of(void) {
    uint32_t want = 1u << 30;
    CHECK(votess_want_of("face_areas, counts,status", &want) == VOTESS_OK);
    CHECK(want == (VOTESS_WANT_AREAS | VOTESS_WANT_COUNTS));
    CHECK_FAILS(votess_want_of("face_area", &want), VOTESS_ERROR_INVALID_ARGUMENT, "face_areas");
    CHECK_FAILS(votess_want_of(NULL, &want), VOTESS_ERROR_INVALID_ARGUMENT, "names");
    CHECK_FAILS(votess_want_of("faces", NULL), VOTESS_ERROR_INVALID_ARGUMENT, "want");
}

void check_tuning(votess_tessellator* tessellator) {
    votess_options options = options_with_box(2);
    CHECK(options.precision == VOTESS_PRECISION_SINGLE && options.k_init == 0 && options.chunk_size == 0);
    CHECK(options.device == NULL && options.instructions == NULL);
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
}

void check_struct_sizes(votess_tessellator* tessellator) {
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

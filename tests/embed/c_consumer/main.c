// Uses the C interface as a C11 program would, error paths included. Returns 0 when all is well, else prints what is
// not.
#include <stdlib.h>

#include "check.h"

int failures = 0;

const double cube[24] = {0.5, 0.5, 0.5, 0.5, 0.5, 1.5, 0.5, 1.5, 0.5, 0.5, 1.5, 1.5,
                         1.5, 0.5, 0.5, 1.5, 0.5, 1.5, 1.5, 1.5, 0.5, 1.5, 1.5, 1.5};

votess_options options_with_box(double side) {
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
double* random_points(size_t count, uint64_t seed) {
    double* points = malloc(3 * count * sizeof *points);
    if (points == NULL) {
        fprintf(stderr, "c_consumer: no memory for %zu points\n", count);
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

int main(void) {
    check_version();
    votess_tessellator* tessellator = NULL;
    CHECK(votess_tessellator_new(&tessellator) == VOTESS_OK && tessellator != NULL);
    check_cube(NULL);
    check_cube(tessellator);
    check_mesh(tessellator);
    check_diagram();
    check_domains(tessellator);
    check_null_result();
    check_walls_and_defaults();
    check_empty_and_float(tessellator);
    check_duplicates(tessellator);
    check_bad_input(tessellator);
    check_implied_want();
    check_want_of();
    check_tuning(tessellator);
    check_struct_sizes(tessellator);
    check_callbacks(tessellator);
    check_moving(tessellator);
    check_one_call_at_a_time(tessellator);
    votess_tessellator_free(tessellator);
    check_fork();
    check_result_outlives_tessellator();
    check_devices();
    check_stream();
    if (failures != 0) {
        fprintf(stderr, "c_consumer: %d checks failed\n", failures);
        return 1;
    }
    printf("c_consumer: votess %s, all checks passed\n", votess_version_string());
    return 0;
}

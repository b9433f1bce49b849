// Checks that go on after a failure, and what the files of this program share.
#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>
#include <string.h>
#include <votess/votess.h>

extern int failures;

#define CHECK(condition)                                                                                 \
    do {                                                                                                 \
        if (!(condition)) {                                                                              \
            fprintf(stderr, "%s:%d: not true: %s; last error: \"%s\"\n", __FILE__, __LINE__, #condition, \
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
            fprintf(stderr, "%s:%d: %s: status %d, message \"%s\"; expected %d, \"%s\"\n", __FILE__, __LINE__, #call, \
                    (int)status_, message_, (int)(expected), text);                                                   \
            ++failures;                                                                                               \
        }                                                                                                             \
    } while (0)

extern const double cube[24];  // corners of a cube of side 1 in the middle of one of side 2
votess_options options_with_box(double side);
// Uniform numbers in [0, 1), to be freed.
double* random_points(size_t count, uint64_t seed);

// results.c
void check_cube(votess_tessellator* tessellator);
void check_mesh(votess_tessellator* tessellator);
void check_diagram(void);
void check_domains(votess_tessellator* tessellator);
void check_null_result(void);
void check_walls_and_defaults(void);
void check_empty_and_float(votess_tessellator* tessellator);
void check_duplicates(votess_tessellator* tessellator);
// options.c
void check_bad_input(votess_tessellator* tessellator);
void check_implied_want(void);
void check_want_of(void);
void check_tuning(votess_tessellator* tessellator);
void check_struct_sizes(votess_tessellator* tessellator);
// calls.c
void check_callbacks(votess_tessellator* tessellator);
void check_moving(votess_tessellator* tessellator);
void check_one_call_at_a_time(votess_tessellator* tessellator);
void check_fork(void);
void check_result_outlives_tessellator(void);
void check_devices(void);
// stream.c
void check_stream(void);

#endif

// How calls run: callbacks, tessellators that are kept, threads, forks, devices.
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "check.h"

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

void check_callbacks(votess_tessellator* tessellator) {
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
void check_moving(votess_tessellator* tessellator) {
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

void check_one_call_at_a_time(votess_tessellator* tessellator) {
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
void check_fork(void) {
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

void check_result_outlives_tessellator(void) {
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

void check_devices(void) {
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

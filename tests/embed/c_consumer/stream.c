// votess/stream.h: seeds and rows in pieces.
#include <stdlib.h>
#include <votess/stream.h>

#include "check.h"

#define SEEDS 3000

typedef struct {
    const double* points;
    size_t next, readings;
    votess_result* whole;
    uint64_t rows, begun;
    int stop;  // with this reading
} Stream;

static int restart(void* user) {
    Stream* stream = user;
    stream->next = 0;
    ++stream->readings;
    return (int)stream->readings == stream->stop ? VOTESS_STREAM_STOP : VOTESS_STREAM_GO_ON;
}

static int next(votess_stream_seeds* seeds, void* user) {
    Stream* stream = user;
    if (stream->next == SEEDS) return VOTESS_STREAM_END;
    seeds->count = SEEDS / 4;
    seeds->points = stream->points + 3 * stream->next;
    stream->next += seeds->count;
    return VOTESS_STREAM_GO_ON;
}

static int begin(const votess_stream_head* head, void* user) {
    Stream* stream = user;
    ++stream->begun;
    CHECK(head->seeds == SEEDS && head->duplicates == 0 && head->periodic == 0 && head->box_upper[1] == 1);
    return VOTESS_STREAM_GO_ON;
}

// As those of the whole result.
static int rows(const votess_stream_rows* some, void* user) {
    Stream* stream = user;
    size_t length = 0;
    const int64_t* indptr = votess_result_indptr(stream->whole, &length);
    const int32_t* indices = votess_result_indices(stream->whole, &length);
    CHECK(some->first == stream->rows && some->count > 0);
    CHECK(some->indptr != NULL && some->volumes != NULL && some->centroids == NULL && some->shifts == NULL);
    for (size_t i = 0; i <= some->count; ++i) CHECK(some->indptr[i] == indptr[some->first + i]);
    for (size_t e = 0; e < some->entries; ++e) CHECK(some->neighbors[e] == indices[(size_t)some->indptr[0] + e]);
    stream->rows += some->count;
    return VOTESS_STREAM_GO_ON;
}

void check_stream(void) {
    votess_options options = options_with_box(1);
    options.device = "cpu";
    double* points = random_points(SEEDS, 5);
    Stream user = {points, 0, 0, NULL, 0, 0, 0};
    CHECK(votess_tessellate(NULL, points, SEEDS, &options, &user.whole) == VOTESS_OK);
    votess_stream stream = {sizeof stream, 0, 1000000, NULL, restart, next, begin, rows, &user};
    votess_stream_counts counts = {sizeof counts, 0, 0, 0, 0, 0, 0, 0, 0, ""};
    votess_stats stats;
    stats.struct_size = sizeof stats;
    CHECK(votess_tessellate_stream(&stream, &options, &counts, &stats) == VOTESS_OK);
    CHECK(user.rows == SEEDS && user.begun == 1 && user.readings == 2);
    CHECK(counts.blocks > 1 && counts.largest_block < SEEDS && counts.temporary_bytes > 32 * SEEDS);
    CHECK(stats.points == SEEDS && stats.volume_sum > 0.999999 && stats.volume_sum < 1.000001);

    CHECK(counts.passed == 0 && counts.sampled == 0);

    user.rows = user.next = 0;
    stream.verify = 1;
    CHECK(votess_tessellate_stream(&stream, &options, &counts, NULL) == VOTESS_OK);
    CHECK(counts.passed == 1 && counts.sampled == 64 && counts.checks_skipped == VOTESS_CHECK_EULER);
    CHECK(counts.failure[0] == '\0');
    CHECK_FAILS(votess_tessellate_stream(&stream, &options, NULL, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "needs counts");
    stream.verify = 2;
    CHECK_FAILS(votess_tessellate_stream(&stream, &options, &counts, NULL), VOTESS_ERROR_INVALID_ARGUMENT,
                "verify is 2");
    stream.verify = 0;
    user.readings = 2;

    user.rows = user.next = 0;
    stream.restart = NULL;  // once
    stream.begin = NULL;
    CHECK(votess_tessellate_stream(&stream, &options, NULL, NULL) == VOTESS_OK);
    CHECK(user.rows == SEEDS);

    stream.restart = restart;
    user.stop = (int)user.readings + 2;
    CHECK_FAILS(votess_tessellate_stream(&stream, &options, NULL, NULL), VOTESS_ERROR_CANCELLED, "callback restart");
    stream.memory = 7;
    CHECK_FAILS(votess_tessellate_stream(&stream, &options, NULL, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "memory = 7");
    stream.rows = NULL;
    CHECK_FAILS(votess_tessellate_stream(&stream, &options, NULL, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "stream.rows");
    stream.struct_size = 4;
    CHECK_FAILS(votess_tessellate_stream(&stream, &options, NULL, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "struct_size");
    CHECK_FAILS(votess_tessellate_stream(NULL, NULL, NULL, NULL), VOTESS_ERROR_INVALID_ARGUMENT, "stream is NULL");
    votess_result_free(user.whole);
    free(points);
}

// votess/stream.h.
#include <votess/stream.h>

#include <algorithm>
#include <cstring>
#include <votess/stream.hpp>

#include "c/handles.hpp"

using namespace votess::c;

namespace {

constexpr std::size_t first_stream_size = offsetof(votess_stream, user) + sizeof(votess_stream::user);
constexpr std::size_t first_counts_size =
    offsetof(votess_stream_counts, temporary_bytes) + sizeof(votess_stream_counts::temporary_bytes);

// Calls back. Returns false when the callback ends the stream.
template <typename Function>
bool going_on(const char* callback, const Function& function) {
    const int answer = call_back(callback, function);
    if (answer == VOTESS_STREAM_STOP)
        throw votess::Error(votess::ErrorCode::cancelled, std::string("cancelled by the callback ") + callback);
    return answer != VOTESS_STREAM_END;
}

class Source : public votess::StreamSource {
public:
    explicit Source(const votess_stream& stream) : stream_(stream) {}
    bool restart() override {
        return stream_.restart != nullptr && going_on("restart", [this] { return stream_.restart(stream_.user); });
    }
    bool next(votess::StreamSeeds& seeds) override {
        votess_stream_seeds some{};
        if (!going_on("next", [&] { return stream_.next(&some, stream_.user); })) return false;
        seeds.points = coordinates(some.points, some.count);
        if (some.weights != nullptr) seeds.weights = {some.weights, some.count};
        if (some.radii != nullptr) seeds.radii = {some.radii, some.count};
        return true;
    }

private:
    const votess_stream& stream_;
};

class Sink : public votess::StreamSink {
public:
    explicit Sink(const votess_stream& stream) : stream_(stream) {}
    void begin(const votess::StreamHead& head) override {
        if (stream_.begin == nullptr) return;
        votess_stream_head said{head.seeds, head.entries, head.duplicates ? 1 : 0, head.periodic ? 1 : 0, {}, {}};
        if (!head.options.cell && head.options.box) {
            std::ranges::copy(head.options.box->lower, said.box_lower);
            std::ranges::copy(head.options.box->upper, said.box_upper);
        }
        (void)going_on("begin", [&] { return stream_.begin(&said, stream_.user); });
    }
    void rows(const votess::StreamRows& rows) override {
        const auto out = [](const auto& array) { return array.empty() ? nullptr : array.data(); };
        votess_stream_rows some{};
        some.first = rows.first;
        some.count = rows.status.size();
        some.entries = rows.neighbors.size();
        some.status = reinterpret_cast<const std::uint8_t*>(out(rows.status));
        some.duplicate_of = out(rows.duplicate_of);
        some.indptr = out(rows.indptr);
        some.neighbors = out(rows.neighbors);
        some.shifts = out(rows.shifts);
        some.areas = out(rows.areas);
        some.normals = out(rows.normals);
        some.volumes = out(rows.volumes);
        some.centroids = out(rows.centroids);
        some.surface_areas = out(rows.surface_areas);
        some.security_radii = out(rows.security_radii);
        some.face_counts = out(rows.face_counts);
        some.edge_counts = out(rows.edge_counts);
        some.vertex_counts = out(rows.vertex_counts);
        (void)going_on("rows", [&] { return stream_.rows(&some, stream_.user); });
    }

private:
    const votess_stream& stream_;
};

}  // namespace

votess_status votess_tessellate_stream(const votess_stream* stream, const votess_options* options,
                                       votess_stream_counts* counts, votess_stats* stats) {
    return guarded([&] {
        require(stream, "stream");
        require_struct_size(stream->struct_size, first_stream_size, "stream.struct_size",
                            "set it to sizeof(votess_stream)");
        if (stream->next == nullptr || stream->rows == nullptr) refuse("stream.next or stream.rows is NULL");
        if (counts != nullptr)
            require_struct_size(counts->struct_size, first_counts_size, "counts.struct_size",
                                "set it to sizeof(votess_stream_counts)");
        if (options != nullptr && (options->weights != nullptr || options->radii != nullptr))
            refuse("weights and radii of a stream come with its seeds: leave them NULL in the options");
        if (stats != nullptr) check_stats(*stats);
        if (stream->verify != 0 && stream->verify != 1)
            refuse("stream.verify is " + std::to_string(stream->verify) + ": give 0 or 1");
        if (stream->verify == 1 && (counts == nullptr || counts->struct_size < sizeof(votess_stream_counts)))
            refuse("stream.verify needs counts, with the report of it, of struct_size sizeof(votess_stream_counts)");
        Source source(*stream);
        Sink sink(*stream);
        const votess::StreamResult result =
            votess::tessellate_stream(source, sink, convert_options(options, 0),
                                      {.memory = stream->memory,
                                       .temporary = stream->temporary == nullptr ? "" : stream->temporary,
                                       .verify = stream->verify == 1});
        if (counts != nullptr) {
            votess_stream_counts found{};
            found.struct_size = counts->struct_size;
            found.blocks = result.blocks;
            found.largest_block = result.largest_block;
            found.asked_cells = result.asked_cells;
            found.temporary_bytes = result.temporary_bytes;
            if (result.verified) {
                std::size_t sampled = 0;
                int passed = 0;
                write_report(*result.verified,
                             {&passed, &found.checks_skipped, &sampled, found.failure, sizeof found.failure});
                found.passed = passed;
                found.sampled = sampled;
            }
            std::memcpy(counts, &found, std::min<std::size_t>(counts->struct_size, sizeof found));
        }
        if (stats != nullptr) write_stats(result.stats, *stats);
    });
}

// votess/stream.h.
#include <votess/stream.h>

#include <algorithm>
#include <votess/stream.hpp>

#include "c/handles.hpp"

using namespace votess::c;

namespace {

constexpr std::size_t first_stream_size = offsetof(votess_stream, user) + sizeof(votess_stream::user);
constexpr std::size_t first_counts_size =
    offsetof(votess_stream_counts, temporary_bytes) + sizeof(votess_stream_counts::temporary_bytes);

// Calls back. Returns false when the callback ends the stream.
template <typename Function>
bool continues(const char* callback, const Function& function) {
    const int answer = call_back(callback, function);
    if (answer == VOTESS_STREAM_STOP)
        throw votess::Error(votess::ErrorCode::cancelled, std::string("cancelled by the callback ") + callback);
    return answer != VOTESS_STREAM_END;
}

class Source : public votess::StreamSource {
public:
    Source(const votess_stream& stream, std::size_t dimensions) : stream_(stream), dimensions_(dimensions) {}
    bool restart() override {
        return stream_.restart != nullptr && continues("restart", [this] { return stream_.restart(stream_.user); });
    }
    bool next(votess::StreamSeeds& seeds) override {
        votess_stream_seeds piece{};
        if (!continues("next", [&] { return stream_.next(&piece, stream_.user); })) return false;
        seeds.points = coordinates(piece.points, piece.count, "points", "count", dimensions_);
        if (piece.weights != nullptr) seeds.weights = {piece.weights, piece.count};
        if (piece.radii != nullptr) seeds.radii = {piece.radii, piece.count};
        return true;
    }

private:
    const votess_stream& stream_;
    std::size_t dimensions_;
};

// What votess_stream_rows::cells points to.
struct Piece {
    const votess::StreamRows& rows;
    bool planar;
};

class Sink : public votess::StreamSink {
public:
    Sink(const votess_stream& stream, bool planar) : stream_(stream), planar_(planar) {}
    void begin(const votess::StreamHead& head) override {
        if (stream_.begin == nullptr) return;
        votess_stream_head c_head{head.seeds, head.entries, head.duplicates ? 1 : 0, head.periodic ? 1 : 0, {}, {}};
        if (!head.options.cell && head.options.box) {
            std::ranges::copy(head.options.box->lower, c_head.box_lower);
            std::ranges::copy(head.options.box->upper, c_head.box_upper);
        }
        (void)continues("begin", [&] { return stream_.begin(&c_head, stream_.user); });
    }
    void rows(const votess::StreamRows& rows) override {
        const Piece piece{rows, planar_};
        const votess_stream_rows c_rows{rows.first, rows.status.size(), rows.indices.size(), &piece};
        (void)continues("rows", [&] { return stream_.rows(&c_rows, stream_.user); });
    }

private:
    const votess_stream& stream_;
    bool planar_;
};

}  // namespace

votess_status votess_stream_array(const votess_stream_rows* rows, const char* name, votess_array* array) {
    return expose(rows, "rows", name, array, [](const votess_stream_rows& of) {
        require(of.cells, "rows.cells");
        const Piece& piece = *static_cast<const Piece*>(of.cells);
        std::vector<NamedArray> arrays{named("indptr", piece.rows.indptr)};
        votess::for_row_arrays([&](const auto& row, std::size_t) {
            arrays.push_back(named(row.name.data(), row.of(piece.rows), components_of(row, piece.planar)));
        });
        return arrays;
    });
}

votess_status votess_tessellate_stream(const votess_stream* stream, const votess_options* options,
                                       votess_stream_counts* counts, votess_stats* stats) {
    return guarded([&] {
        require(stream, "stream");
        const votess_stream given =
            read_struct(*stream, "stream.struct_size", "set it to sizeof(votess_stream)", first_stream_size);
        if (given.next == nullptr || given.rows == nullptr) refuse("stream.next or stream.rows is NULL");
        if (counts != nullptr)
            require_struct_size(counts->struct_size, first_counts_size, "counts.struct_size",
                                "set it to sizeof(votess_stream_counts)");
        if (options != nullptr && (options->weights != nullptr || options->radii != nullptr))
            refuse("options.weights or options.radii is set: a stream gets them with its seeds, leave both NULL");
        if (stats != nullptr) check_stats(*stats);
        for (const auto& [name, flag] : {std::pair("verify", given.verify), std::pair("hull", given.hull)})
            if (flag != 0 && flag != 1)
                refuse("stream." + std::string(name) + " is " + std::to_string(flag) + ": give 0 or 1");
        if (given.verify == 1 && (counts == nullptr || counts->struct_size < sizeof(votess_stream_counts)))
            refuse(
                "stream.verify needs counts for its report: give counts of struct_size sizeof(votess_stream_counts)");
        const votess::Options converted = convert_options(options, 0);
        Source source(given, dimensions_of(converted));
        Sink sink(given, converted.planar);
        const votess::StreamResult result =
            votess::tessellate_stream(source, sink, converted,
                                      {.memory = given.memory,
                                       .temporary = given.temporary == nullptr ? "" : given.temporary,
                                       .verify = given.verify == 1,
                                       .hull = given.hull == 1});
        if (counts != nullptr) {
            votess_stream_counts c_counts{};
            c_counts.blocks = result.blocks;
            c_counts.largest_block = result.largest_block;
            c_counts.asked_cells = result.asked_cells;
            c_counts.temporary_bytes = result.temporary_bytes;
            if (result.verified) {
                std::size_t sampled = 0;
                int passed = 0;
                write_report(*result.verified,
                             {&passed, nullptr, &c_counts.checks_skipped, &sampled, nullptr, c_counts.failure,
                              sizeof c_counts.failure, c_counts.unproven, sizeof c_counts.unproven});
                c_counts.passed = passed;
                c_counts.sampled = sampled;
            }
            write_struct(c_counts, *counts);
        }
        if (stats != nullptr) write_stats(result.stats, *stats);
    });
}

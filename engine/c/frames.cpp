// votess/frames.h.
#include "run/frames.hpp"

#include <votess/frames.h>

#include <algorithm>
#include <array>

#include "c/handles.hpp"

using namespace votess::c;

struct votess_frames {
    votess::Frames frames;
};

struct votess_frame_cells {
    votess::detail::FrameRows rows;
};

namespace {

template <class T>
std::span<const T> all(const votess::Buffer<T>& array) {
    return {array.data(), array.size()};
}

template <class Real>
votess_status run_frame(votess_frames* frames, const Real* points, const double* weights, std::size_t count,
                        votess_frame_cells** out) noexcept {
    return create(out, frames, "frames", [&](auto& of) {
        const std::span<const double> given(weights, weights == nullptr ? 0 : count);
        return votess_frame_cells{of.frames.run(coordinates(points, count), given)};
    });
}

}  // namespace

votess_status votess_frames_new(const votess_frames_options* frames, const votess_options* options,
                                const votess_frames* share, votess_frames** out) {
    return create(out, [&] {
        require(frames, "frames");
        require_struct_size(frames->struct_size, sizeof *frames, "frames.struct_size",
                            "set it to sizeof(votess_frames_options)");
        votess::FramesSettings settings{.max_points = frames->max_points,
                                        .weights = {},
                                        .max_entries = frames->max_entries,
                                        .max_images = frames->max_images,
                                        .margin = frames->margin,
                                        .gradients = frames->gradients != 0,
                                        .uuid = {},
                                        .wide = false};
        if (frames->exported != 0) {
            if (frames->exported != VOTESS_EXPORT_FLOAT32 && frames->exported != VOTESS_EXPORT_FLOAT64)
                refuse("frames.exported = " + std::to_string(frames->exported) +
                       ": give VOTESS_EXPORT_FLOAT32, VOTESS_EXPORT_FLOAT64 or 0");
            std::ranges::copy(frames->device_uuid, settings.uuid.emplace().begin());
            settings.wide = frames->exported == VOTESS_EXPORT_FLOAT64;
        }
        if (frames->has_weights != 0) settings.weights.emplace(frames->least_weight, frames->largest_weight);
        constexpr std::size_t any_count = 1;  // weights and radii are refused
        return votess_frames{
            {settings, convert_options(options, any_count), share == nullptr ? nullptr : &share->frames}};
    });
}

void votess_frames_free(votess_frames* frames) {
    delete frames;
}

votess_status votess_frames_device(const votess_frames* frames, char* text, size_t size) {
    return guarded([&] {
        require_text_buffer(text, size, "text");
        require(frames, "frames");
        copy_text(frames->frames.device(), text, size);
    });
}

votess_status votess_frames_run(votess_frames* frames, const double* points, const double* weights, size_t count,
                                votess_frame_cells** out) {
    return run_frame(frames, points, weights, count, out);
}

votess_status votess_frames_run_f32(votess_frames* frames, const float* points, const double* weights, size_t count,
                                    votess_frame_cells** out) {
    return run_frame(frames, points, weights, count, out);
}

votess_status votess_frames_resolve(votess_frames* frames, votess_frame_cells** out) {
    return create(out, frames, "frames", [&](auto& of) { return votess_frame_cells{of.frames.resolve()}; });
}

votess_status votess_frames_vjp(votess_frames* frames, const float* volumes, const double* centroids,
                                const float* face_areas, double* by_points, double* by_weights) {
    return guarded(frames, "frames", [&](auto& of) {
        require(by_points, "by_points");
        require(by_weights, "by_weights");
        of.frames.vjp({volumes, centroids, face_areas}, by_points, by_weights);
    });
}

votess_status votess_frames_get_export(votess_frames* frames, votess_frames_export* out) {
    return guarded([&] {
        require(out, "out");
        require(frames, "frames");
        require_struct_size(out->struct_size, sizeof *out, "out.struct_size", "set it to sizeof(votess_frames_export)");
        write_struct<votess_frames_export>(frames->frames.exported(), *out);
    });
}

votess_status votess_frames_submit(votess_frames* frames, uint32_t count, uint64_t after, uint64_t done) {
    return guarded(frames, "frames", [&](auto& of) { of.frames.submit(count, after, done); });
}

votess_status votess_frames_submit_vjp(votess_frames* frames, uint32_t given, uint64_t after, uint64_t done) {
    return guarded(frames, "frames", [&](auto& of) {
        constexpr std::uint32_t known = VOTESS_WANT_VOLUMES | VOTESS_WANT_CENTROIDS | VOTESS_WANT_AREAS;
        if ((given & ~known) != 0)
            refuse("given = " + std::to_string(given) +
                   ": give VOTESS_WANT_VOLUMES, VOTESS_WANT_CENTROIDS and VOTESS_WANT_AREAS");
        of.frames.submit_vjp({.neighbors = false,
                              .volumes = (given & VOTESS_WANT_VOLUMES) != 0,
                              .centroids = (given & VOTESS_WANT_CENTROIDS) != 0,
                              .areas = (given & VOTESS_WANT_AREAS) != 0},
                             after, done);
    });
}

votess_status votess_frames_signal(votess_frames* frames, uint64_t value) {
    return guarded(frames, "frames", [&](auto& of) { of.frames.signal(value); });
}

votess_status votess_frames_wait(votess_frames* frames, uint64_t value) {
    return guarded(frames, "frames", [&](auto& of) { of.frames.wait(value); });
}

votess_status votess_frames_resolve_exported(votess_frames* frames, uint64_t* resolved) {
    return guarded(frames, "frames", [&](auto& of) {
        const std::size_t cells = of.frames.resolve_exported();
        if (resolved != nullptr) *resolved = cells;
    });
}

void votess_frame_cells_free(votess_frame_cells* cells) {
    delete cells;
}

size_t votess_frame_cells_unresolved(const votess_frame_cells* cells) {
    return value_of<size_t>(cells, "cells is NULL", [](const votess_frame_cells& of) { return of.rows.unresolved; });
}

size_t votess_frame_cells_kept(const votess_frame_cells* cells) {
    return value_of<size_t>(cells, "cells is NULL", [](const votess_frame_cells& of) { return of.rows.kept; });
}

votess_status votess_frame_cells_array(const votess_frame_cells* cells, const char* name, votess_array* array) {
    return expose(cells, "cells", name, array, [](const votess_frame_cells& of) {
        const votess::detail::FrameRows& r = of.rows;
        const bool narrow = r.centroids64.empty();
        return std::array{
            named("status", all(r.status)),
            named("indptr", all(r.indptr)),
            named("indices", all(r.indices)),
            named("shifts", all(r.shifts), 3),
            named("face_areas", all(r.face_areas)),
            named("volumes", all(r.volumes)),
            narrow ? named("centroids", all(r.centroids32), 3) : named("centroids", all(r.centroids64), 3)};
    });
}

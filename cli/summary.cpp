#include "summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "failure.hpp"
#include "files/numbers.hpp"

namespace clvotess {
namespace {

using Stages = std::array<std::pair<const char*, double>, 10>;

Stages stages_of(const Summary& summary) {
    const votess::StageSeconds& seconds = summary.stats.seconds;
    return {{{"total", summary.seconds_total},
             {"open", seconds.open},
             {"read", summary.seconds_read},
             {"upload", seconds.upload},
             {"sort", seconds.sort},
             {"knn", seconds.knn},
             {"clip", seconds.clip},
             {"fallback", seconds.fallback},
             {"download", seconds.download},
             {"write", summary.seconds_write}}};
}

struct Reason {
    const char* name;
    const char* meaning;
    std::uint64_t cells;
};

std::array<Reason, 5> fallback_reasons(const votess::Stats& stats) {
    const votess::FallbackReasons& reasons = stats.fallback_reasons;
    return {{{"uncertain", "undecided in floating point", reasons.uncertain},
             {"overflow", "too large for the device", reasons.overflow},
             {"exhausted", "with a search that ended early", reasons.exhausted},
             {"skipped", "skipped after failures of the device", reasons.skipped},
             {"domain", "in a domain that the device cannot clip", reasons.domain}}};
}

std::string reasons_of(const votess::Stats& stats) {
    std::string text;
    for (const Reason& reason : fallback_reasons(stats))
        if (reason.cells > 0) text += (text.empty() ? "" : ", ") + std::to_string(reason.cells) + " " + reason.meaning;
    return text;
}

std::optional<std::uint64_t> tiny_faces(const Summary& summary) {
    if (!summary.stats.tiny_faces && summary.verified) return summary.verified->tiny_faces;
    return summary.stats.tiny_faces;
}

std::string rounded(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string json_number(double value) {
    return std::isfinite(value) ? to_text(value) : "null";
}

}  // namespace

namespace {

// Add the numbers of another frame.
void add(const votess::Stats& one, votess::Stats& sum) {
    sum.device = one.device;
    sum.threads = one.threads;
    sum.points += one.points;
    sum.faces += one.faces;
    sum.volume_sum += one.volume_sum;
    sum.box_volume += one.box_volume;
    sum.moved_vertices = one.moved_vertices;  // all frames have one mesh
    sum.moved_distance = one.moved_distance;
    sum.duplicates += one.duplicates;
    sum.empty_cells += one.empty_cells;
    sum.fallback_cells += one.fallback_cells;
    sum.fallback_reasons.uncertain += one.fallback_reasons.uncertain;
    sum.fallback_reasons.overflow += one.fallback_reasons.overflow;
    sum.fallback_reasons.exhausted += one.fallback_reasons.exhausted;
    sum.fallback_reasons.skipped += one.fallback_reasons.skipped;
    sum.fallback_reasons.domain += one.fallback_reasons.domain;
    sum.exact_cells += one.exact_cells;
    sum.kept_cells += one.kept_cells;
    if (one.tiny_faces) sum.tiny_faces = sum.tiny_faces.value_or(0) + *one.tiny_faces;
    for (double votess::StageSeconds::*stage :
         {&votess::StageSeconds::open, &votess::StageSeconds::upload, &votess::StageSeconds::sort,
          &votess::StageSeconds::knn, &votess::StageSeconds::clip, &votess::StageSeconds::fallback,
          &votess::StageSeconds::download, &votess::StageSeconds::total})
        sum.seconds.*stage += one.seconds.*stage;
    sum.peak_memory_bytes = std::max(sum.peak_memory_bytes, one.peak_memory_bytes);
    sum.precision = one.precision;
    const std::uint64_t cells = sum.points - sum.empty_cells;
    sum.mean_faces = cells > 0 ? static_cast<double>(sum.faces) / static_cast<double>(cells) : 0;
}

// Returns how many cells are verified: all by a proof, else those that every point has clipped.
std::uint64_t verified_cells(const votess::VerifyReport& report, std::uint64_t points) {
    return report.proven ? points : report.sampled;
}

void add(const votess::VerifyReport& one, votess::VerifyReport& sum) {
    sum.sampled += one.sampled;
    sum.proven &= one.proven;
    if (sum.unproven.empty()) sum.unproven = one.unproven;
    if (one.tiny_faces) sum.tiny_faces = sum.tiny_faces.value_or(0) + *one.tiny_faces;
}

}  // namespace

void Summary::add(const Summary& one, std::uint64_t number, std::uint64_t points) {
    if (domain.empty()) {
        stats = one.stats;
        domain = one.domain;
        domain_json = one.domain_json;
        plane_from = one.plane_from;
        fit = one.fit;
        verified = one.verified;
        streamed = one.streamed;
        if (frames) frames = {0, number, number, points, points, false};
    } else {
        clvotess::add(one.stats, stats);
        if (fit) fit = {fit->steps + one.fit->steps, std::max(fit->residual, one.fit->residual)};
        if (verified) clvotess::add(*one.verified, *verified);
        if (streamed) {
            streamed->blocks += one.streamed->blocks;
            streamed->largest_block = std::max(streamed->largest_block, one.streamed->largest_block);
            streamed->asked_cells += one.streamed->asked_cells;
            streamed->temporary_bytes = std::max(streamed->temporary_bytes, one.streamed->temporary_bytes);
        }
    }
    if (!frames) return;
    frames->moving_domain |= one.domain != domain;
    ++frames->count;
    frames->last = number;
    frames->min_points = std::min(frames->min_points, points);
    frames->max_points = std::max(frames->max_points, points);
}

std::string json_string(const std::string& text) {
    std::string result = "\"";
    for (std::size_t at = 0; at < text.size();) {
        const char c = text[at];
        const std::size_t length = utf8_length(std::string_view(text).substr(at));
        if (c == '"' || c == '\\') {
            result += {'\\', c};
        } else if (static_cast<unsigned char>(c) < 0x20) {
            char code[8];
            std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(c));
            result += code;
        } else if (length == 0) {
            result += "\\ufffd";  // JSON holds UTF-8 only
        } else {
            result += text.substr(at, length);
        }
        at += std::max<std::size_t>(length, 1);
    }
    return result + "\"";
}

void Summary::set_mesh(const std::string& file, const Surface& surface) {
    mesh = file;
    triangles = surface.triangles.size() / (surface.planar ? 2 : 3);
    mesh_parts = surface.planar ? "edges" : "triangles";
}

void Summary::set_domain(const votess::Tessellation& tessellation, const DomainFrom& from) {
    domain = domain_text(tessellation, from);
    domain_json = clvotess::domain_json(tessellation, from);
}

void Summary::set_dimensions(bool planar, Dimensions requested) {
    plane_from.reset();
    if (planar) plane_from = requested == Dimensions::two ? "option" : "assumed";
}

std::string Summary::failure() const {
    if (!verified || verified->passed) return {};
    return "verification failed, no file was written: " + verified->failure;
}

std::string plain_summary(const Summary& summary) {
    const votess::Stats& stats = summary.stats;
    std::string text;
    const auto line = [&text](std::string name, const std::string& value) {
        name.resize(14, ' ');
        text += name + value + "\n";
    };
    line("points", std::to_string(stats.points));
    if (!summary.input_note.empty()) line("input", summary.input_note);
    if (const auto& frames = summary.frames) {
        const std::string least = std::to_string(frames->min_points), greatest = std::to_string(frames->max_points);
        line("frames", std::to_string(frames->count) + ", from number " + std::to_string(frames->first) + " to " +
                           std::to_string(frames->last) + ", of " + (least == greatest ? "" : least + " to ") +
                           greatest + " points");
    }
    if (summary.plane_from)
        line("dimensions",
             std::string("2, ") + *summary.plane_from +
                 (summary.plane_from == std::string("assumed") ? ": the points have two coordinates" : ""));
    line("domain",
         summary.domain + (summary.frames && summary.frames->moving_domain ? "; moves from frame to frame" : ""));
    if (!summary.mesh.empty())
        line("mesh", summary.mesh + ", " + std::to_string(summary.triangles) + " " + summary.mesh_parts +
                         (stats.moved_vertices == 0
                              ? ""
                              : "; " + std::to_string(stats.moved_vertices) + " vertices moved by at most " +
                                    rounded("%.2g", stats.moved_distance)));
    line(summary.plane_from ? "mean edges" : "mean faces", rounded("%.4f", stats.mean_faces));
    if (summary.has_volumes && std::isfinite(stats.box_volume)) {
        const double error =
            stats.box_volume > 0 ? std::abs(stats.volume_sum - stats.box_volume) / stats.box_volume : 0;
        line(summary.plane_from ? "area sum" : "volume sum",
             rounded("%.10g", stats.volume_sum) + (summary.mesh.empty() ? " of the box's " : " of the mesh's ") +
                 rounded("%.10g", stats.box_volume) + ", relative difference " + rounded("%.1e", error));
    }
    if (summary.fit)
        line("fit", std::to_string(summary.fit->steps) + " steps, largest error of a volume " +
                        rounded("%.1e", summary.fit->residual) + " of its target");
    if (stats.duplicates > 0) line("duplicates", std::to_string(stats.duplicates));
    if (stats.empty_cells > 0) line("empty cells", std::to_string(stats.empty_cells));
    if (const auto tiny = tiny_faces(summary); tiny.value_or(0) > 0)
        line(summary.plane_from ? "tiny edges" : "tiny faces", std::to_string(*tiny) + " below 1e-9 of the mean " +
                                                                   (summary.plane_from ? "length" : "area") +
                                                                   "; --min-face 1e-6 drops them");
    if (stats.fallback_cells > 0)
        line("fallback", std::to_string(stats.fallback_cells) + " cells: " + reasons_of(stats));
    line("exact", std::to_string(stats.exact_cells) + " cells needed exact arithmetic");
    if (summary.verified) {
        std::string result = summary.verified->passed ? "yes" : "NO";
        for (const std::string& check : summary.verified->skipped) result += ", without " + check;
        if (summary.verified->proven)
            result += ", all cells proven";
        else if (summary.mesh.empty() || summary.verified->sampled > 0)
            result += ", " + std::to_string(summary.verified->sampled) + " of " + std::to_string(stats.points) +
                      " cells checked against every point";
        if (!summary.verified->unproven.empty()) result += ", no proof: " + summary.verified->unproven;
        line("verified", result);
    }
    line("device", stats.device +
                       (stats.threads == 1 ? ", 1 thread" : ", " + std::to_string(stats.threads) + " threads") +
                       (summary.ranks ? " a rank" : ""));
    if (const auto& ranks = summary.ranks) {
        line("ranks", std::to_string(ranks->ranks) + ", which exchanged " + std::to_string(ranks->ghosts_received) +
                          " seeds in " + std::to_string(ranks->rounds) + " rounds; " +
                          std::to_string(ranks->ghosts_needed) + " are neighbors");
    }
    if (summary.streamed) {
        constexpr double giga = 1e9;
        line("blocks",
             std::to_string(summary.streamed->blocks) + ", of at most " +
                 std::to_string(summary.streamed->largest_block) + " points; " +
                 std::to_string(summary.streamed->asked_cells) + " cells completed by other blocks; " +
                 rounded("%.3g GB of temporary files", static_cast<double>(summary.streamed->temporary_bytes) / giga));
    }
    std::string times;
    for (const auto& [name, seconds] : stages_of(summary)) {
        if (seconds > 0) times += (times.empty() ? "" : "  ") + std::string(name) + " " + rounded("%.3f", seconds);
    }
    line("seconds", times);
    line("peak memory", rounded("%.1f MiB", static_cast<double>(stats.peak_memory_bytes) / (1024.0 * 1024.0)));
    return text;
}

std::string json_summary(const Summary& summary) {
    const votess::Stats& stats = summary.stats;
    std::string text = "{";
    const auto member = [&text](const char* name, const std::string& value) {
        if (text.back() != '{') text += ", ";
        text += json_string(name) + ": " + value;
    };
    member("version", json_string(VOTESS_VERSION_STRING));
    member("device", json_string(stats.device));
    member("points", std::to_string(stats.points));
    member("domain", summary.domain_json);
    member("faces", std::to_string(stats.faces));
    member("mean_faces", json_number(stats.mean_faces));
    member("volume_sum", summary.has_volumes ? json_number(stats.volume_sum) : "null");
    member("box_volume", json_number(stats.box_volume));
    member("duplicates", std::to_string(stats.duplicates));
    member("empty_cells", std::to_string(stats.empty_cells));
    member("fallback_cells", std::to_string(stats.fallback_cells));
    text += ", \"fallback_reasons\": {";
    for (const Reason& reason : fallback_reasons(stats)) member(reason.name, std::to_string(reason.cells));
    text += "}";
    member("exact_cells", std::to_string(stats.exact_cells));
    member("kept_cells", std::to_string(stats.kept_cells));
    const auto tiny = tiny_faces(summary);
    member("tiny_faces", tiny ? std::to_string(*tiny) : "null");
    member("threads", std::to_string(stats.threads));
    text += ", \"seconds\": {";
    for (const auto& [name, seconds] : stages_of(summary)) member(name, json_number(seconds));
    text += "}";
    member("peak_memory_bytes", std::to_string(stats.peak_memory_bytes));
    member("verified", !summary.verified ? "null" : summary.verified->passed ? "true" : "false");
    member("proven", !summary.verified ? "null" : summary.verified->proven ? "true" : "false");
    const bool unproven = summary.verified && !summary.verified->unproven.empty();
    member("unproven", unproven ? json_string(summary.verified->unproven) : "null");
    member("verified_cells",
           summary.verified ? std::to_string(verified_cells(*summary.verified, stats.points)) : "null");
    if (!summary.input_note.empty()) member("input", json_string(summary.input_note));
    if (!summary.mesh.empty()) {
        member("mesh", json_string(summary.mesh));
        member(summary.mesh_parts, std::to_string(summary.triangles));
        member("moved_vertices", std::to_string(stats.moved_vertices));
        member("moved_distance", json_number(stats.moved_distance));
    }
    if (summary.plane_from) {
        member("dimensions", "2");
        member("dimensions_from", json_string(*summary.plane_from));
    }
    if (const auto& ranks = summary.ranks) {
        member("ranks", std::to_string(ranks->ranks));
        member("rounds", std::to_string(ranks->rounds));
        member("ghosts_received", std::to_string(ranks->ghosts_received));
        member("ghosts_needed", std::to_string(ranks->ghosts_needed));
    }
    if (const auto& fit = summary.fit) {
        text += ", \"fit\": {";
        member("steps", std::to_string(fit->steps));
        member("residual", json_number(fit->residual));
        text += "}";
    }
    if (const auto& frames = summary.frames) member("frames", std::to_string(frames->count));
    if (const auto& streamed = summary.streamed) {
        member("blocks", std::to_string(streamed->blocks));
        member("largest_block", std::to_string(streamed->largest_block));
        member("asked_cells", std::to_string(streamed->asked_cells));
        member("temporary_bytes", std::to_string(streamed->temporary_bytes));
    }
    return text + "}\n";
}

}  // namespace clvotess

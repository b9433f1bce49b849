// The table on stdout and the JSON file.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <limits>
#include <sstream>

#include "measure.hpp"
#include "system/machine.hpp"

namespace bench {
namespace {

std::string measurement_json(const Measurement& m, const std::vector<Measurement>& all) {
    std::ostringstream out;
    out << std::setprecision(std::numeric_limits<double>::max_digits10);
    out << "{\"input\": " << in_quotes(m.input) << ", \"n\": " << m.n << ", \"want\": " << in_quotes(name_of(m.want))
        << ", \"peer\": " << in_quotes(m.peer) << ", \"threads\": " << m.threads << ", \"seconds\": [";
    for (std::size_t i = 0; i < m.seconds.size(); ++i) {
        out << (i > 0 ? ", " : "") << m.seconds[i];
    }
    out << ']';
    if (m.seconds.empty()) {
        out << ", \"note\": " << in_quotes(m.note) << '}';
        return out.str();
    }
    const double middle = median(m.seconds);
    out << ", \"median\": " << middle << ", \"kcells_per_second\": " << static_cast<double>(m.n) / middle / 1000
        << ", \"mean_neighbors\": " << static_cast<double>(m.answer.links) / static_cast<double>(m.n)
        << ", \"bounded\": " << (m.bounded ? "true" : "false") << ", \"volume_sum\": " << m.answer.volume
        << ", \"area_sum\": " << m.answer.area << ", \"times_votess\": {";
    bool first = true;
    for (const Measurement& v : all) {
        if (v.peer == "votess" && same_task(v, m) && !v.seconds.empty()) {
            out << (first ? "" : ", ") << '"' << v.threads << "\": " << middle / median(v.seconds);
            first = false;
        }
    }
    out << '}';
    for (const Measurement& v : all) {
        if (m.peer.starts_with("votess") && v.peer == "voro++" && same_task(v, m) && !v.seconds.empty()) {
            out << ", \"rate_to_voropp\": " << median(v.seconds) / middle;
        }
    }
    if (m.answer.stats) {
        const votess::Stats& stats = *m.answer.stats;
        out << ", \"device\": " << in_quotes(stats.device) << ", \"stage_seconds\": " << stages_json(m.stages)
            << ", \"fallback_cells\": " << stats.fallback_cells << ", \"exact_cells\": " << stats.exact_cells;
    }
    out << '}';
    return out.str();
}

// Prints the stages of a run on a device, medians in seconds, and its ratios to the other runs.
void print_device(const Measurement& m, const std::vector<Measurement>& group) {
    std::printf("%s, %s, after a warm-up run that compiles its pipelines:\n ", m.peer.c_str(),
                m.answer.stats->device.c_str());
    for (const Stage& stage : stages) {
        std::printf(" %s %.4f", stage.name, median_of(stage, m.stages));
    }
    std::printf(" seconds; %llu cells left to the CPU\n",
                static_cast<unsigned long long>(m.answer.stats->fallback_cells));
    for (const Measurement& v : group) {
        if ((v.peer == "votess" || v.peer == "voro++") && !v.seconds.empty()) {
            const double ratio = median(v.seconds) / median(m.seconds);
            std::printf("  rate of %s : %s, %u thread%s = %.3f (1 : %.2f)\n", m.peer.c_str(), v.peer.c_str(), v.threads,
                        v.threads == 1 ? "" : "s", ratio, 1 / ratio);
        }
    }
}

}  // namespace

double median_of(const Stage& stage, const std::vector<votess::StageSeconds>& runs) {
    std::vector<double> seconds;
    for (const votess::StageSeconds& run : runs) {
        seconds.push_back(run.*stage.seconds);
    }
    return median(std::move(seconds));
}

std::string stages_json(const std::vector<votess::StageSeconds>& runs) {
    std::ostringstream out;
    out << std::setprecision(6) << '{';
    for (const Stage& stage : stages) {
        out << (&stage == stages ? "\"" : ", \"") << stage.name << "\": [";
        for (std::size_t i = 0; i < runs.size(); ++i) {
            out << (i > 0 ? ", " : "") << runs[i].*stage.seconds;
        }
        out << ']';
    }
    out << '}';
    return out.str();
}

std::string_view name_of(Want want) {
    return want == Want::full ? "full" : want == Want::proof ? "proof" : "neighbors";
}

Want want_of(std::string_view name) {
    return name == "full" ? Want::full : name == "proof" ? Want::proof : Want::neighbors;
}

void print_table(const std::vector<Measurement>& group) {
    if (group.empty()) {
        return;
    }
    const Measurement& head = group.front();
    int name_width = 8;
    for (const Measurement& m : group) {
        name_width = std::max(name_width, static_cast<int>(m.peer.size()));
    }
    std::printf("\n%s, n = %zu, %s\n%-*s %7s %11s %10s %15s", head.input.c_str(), head.n,
                std::string(name_of(head.want)).c_str(), name_width, "", "threads", "seconds", "kcells/s",
                "neighbors/cell");
    for (const Measurement& v : group) {
        if (v.peer == "votess") {
            const std::string title = "votess(" + std::to_string(v.threads) + ")";
            std::printf("  time / %s", title.c_str());
        }
    }
    std::printf("\n");
    for (const Measurement& m : group) {
        std::printf("%-*s %7u ", name_width, m.peer.c_str(), m.threads);
        if (m.seconds.empty()) {
            std::printf(" %s\n", m.note.c_str());
            continue;
        }
        const double middle = median(m.seconds);
        std::printf("%11.4f %10.1f %14.3f%s", middle, static_cast<double>(m.n) / middle / 1000,
                    static_cast<double>(m.answer.links) / static_cast<double>(m.n), m.bounded ? " " : "*");
        for (const Measurement& v : group) {
            if (v.peer == "votess" && !v.seconds.empty()) {
                const int width = 9 + static_cast<int>(std::to_string(v.threads).size()) + 6;
                std::printf("  %*.2f", width, middle / median(v.seconds));
            }
        }
        std::printf("\n");
    }
    if (std::any_of(group.begin(), group.end(), [](const Measurement& m) { return !m.bounded; })) {
        std::printf("* of the unbounded diagram, without the box\n");
    }
    for (const Measurement& m : group) {
        if (m.peer.starts_with("votess:") && !m.seconds.empty()) {
            print_device(m, group);
        }
    }
}

std::string short_number(std::size_t n) {
    int zeros = 0;
    std::size_t digits = n;
    for (; digits > 0 && digits % 10 == 0; digits /= 10) {
        ++zeros;
    }
    return zeros >= 3 ? std::to_string(digits) + 'e' + std::to_string(zeros) : std::to_string(n);
}

void print_ratios(const std::vector<Measurement>& measurements) {
    std::vector<std::string> peers;
    for (const Measurement& m : measurements) {
        if (m.peer != "votess" && std::find(peers.begin(), peers.end(), m.peer) == peers.end()) {
            peers.push_back(m.peer);
        }
    }
    if (peers.empty()) {
        return;
    }
    const auto width_of = [](const std::string& peer) { return std::max(8, static_cast<int>(peer.size())); };
    std::printf("\n%-44s", "votess on one thread: times as fast as");
    for (const std::string& peer : peers) {
        std::printf(" %*s", width_of(peer), peer.c_str());
    }
    std::printf("\n");
    for (const Measurement& mine : measurements) {
        if (mine.peer != "votess" || mine.threads != 1 || mine.seconds.empty()) {
            continue;
        }
        const std::string task = mine.input + ", " + short_number(mine.n) + ", " + std::string(name_of(mine.want));
        std::printf("%-44s", task.c_str());
        for (const std::string& peer : peers) {
            const auto theirs = std::find_if(measurements.begin(), measurements.end(), [&](const Measurement& m) {
                return m.peer == peer && same_task(m, mine) && !m.seconds.empty();
            });
            if (theirs == measurements.end()) {
                std::printf(" %*s", width_of(peer), "-");
            } else {
                std::printf(" %*.2f", width_of(peer), theirs->seconds_per_cell() / mine.seconds_per_cell());
            }
        }
        std::printf("\n");
    }
}

Section section_of(const std::vector<Measurement>& measurements) {
    Section section{"measurements", {}};
    for (const Measurement& m : measurements) {
        section.items.push_back(measurement_json(m, measurements));
    }
    return section;
}

void write_json(const std::string& file, const std::vector<PeerVersion>& peers, const std::vector<Section>& sections) {
    std::ostringstream out;
    out << "{\n  \"machine\": " << machine_json() << ",\n  \"versions\": {";
    for (std::size_t i = 0; i < peers.size(); ++i) {
        out << (i > 0 ? ", " : "") << in_quotes(peers[i].name) << ": " << in_quotes(peers[i].version);
    }
    out << '}';
    for (const Section& section : sections) {
        out << ",\n  " << in_quotes(section.name) << ": [";
        for (std::size_t i = 0; i < section.items.size(); ++i) {
            out << (i > 0 ? ",\n    " : "\n    ") << section.items[i];
        }
        out << "\n  ]";
    }
    out << "\n}\n";
    write_whole(file, out.str());
}

}  // namespace bench

#include "measure.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numeric>
#include <string_view>

namespace bench {
namespace {

constexpr std::size_t max_repeats = 200;
constexpr const char* failed = "failed: ";
// Rounding costs Voro++ a face in millions of these; ties and the sphere's center cost every inexact peer more.
constexpr std::string_view in_general_position[] = {"uniform",   "clustered", "jittered", "periodic",
                                                    "triclinic", "radii",     "smooth"};

struct Entry {
    const Contestant* contestant;
    Measurement measurement;
    std::string key;
};

Entry entry_for(const Contestant& contestant) {
    const auto& [peer, input, want, threads] = contestant;
    Entry entry{&contestant, {}, {}};
    Measurement& m = entry.measurement;
    m.input = input->name;
    m.n = input->size();
    m.want = want;
    m.peer = peer->name();
    m.bounded = peer->bounded(*input);
    m.threads = threads;
    m.volume_error = peer->volume_error();
    m.expected_links = input->links;
    m.box_volume = input->volume();
    entry.key = m.peer + '/' + std::to_string(threads) + '/' + m.input + '/' + std::string(name_of(want));
    return entry;
}

bool finished(const Measurement& m, const Repeats& repeats, double pace) {
    if (!m.note.empty()) {
        return true;
    }
    if (m.seconds.empty()) {
        return false;
    }
    const double together = std::accumulate(m.seconds.begin(), m.seconds.end(), 0.0);
    if (together >= repeats.patience || pace * static_cast<double>(m.n) > repeats.limit) {
        return true;
    }
    return m.seconds.size() >= static_cast<std::size_t>(repeats.count) &&
           (together >= repeats.at_least || m.seconds.size() >= max_repeats);
}

void run_once(Entry& entry, const Repeats& repeats, double& pace) {
    const auto& [peer, input, want, threads] = *entry.contestant;
    Measurement& m = entry.measurement;
    const auto give_up = [&m](const std::string& note) {
        m.seconds.clear();
        m.note = note;
    };
    try {
        if (m.seconds.empty()) {
            if (pace * static_cast<double>(m.n) > repeats.limit) {
                m.note = "left out: over --limit";
                return;
            }
            peer->prepare(*input, want, threads);
        }
        m.answer = peer->run(*input, want, threads);
        m.seconds.push_back(m.answer.seconds);
        if (m.answer.stats) {
            m.stages.push_back(m.answer.stats->seconds);
        }
        pace = std::max(pace, m.answer.seconds / static_cast<double>(std::max<std::size_t>(1, m.n)));
    } catch (const votess::Error& error) {
        // A feature that the processor or device lacks is not a failure.
        give_up((error.code() == votess::ErrorCode::unsupported ? "left out: " : failed) + std::string(error.what()));
    } catch (const std::exception& error) {
        give_up(failed + std::string(error.what()));
    }
}

bool close(double a, double b, double relative) {
    return std::abs(a - b) <= relative * std::max(std::abs(a), std::abs(b));
}

}  // namespace

bool same_task(const Measurement& a, const Measurement& b) {
    return a.input == b.input && a.n == b.n && a.want == b.want;
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

double Measurement::seconds_per_cell() const {
    return median(seconds) / static_cast<double>(n);
}

std::vector<Measurement> Timekeeper::measure(const std::vector<Contestant>& contestants, const Repeats& repeats) {
    std::vector<Entry> entries;
    for (const Contestant& contestant : contestants) {
        entries.push_back(entry_for(contestant));
    }
    const auto done = [&](const Entry& entry) {
        const auto pace = paces_.find(entry.key);
        return finished(entry.measurement, repeats, pace == paces_.end() ? 0 : pace->second);
    };
    for (std::size_t round = 0; !std::all_of(entries.begin(), entries.end(), done); ++round) {
        for (std::size_t k = 0; k < entries.size(); ++k) {
            // Each round begins with another one, so that caches and clocks affect all of them equally.
            Entry& entry = entries[(k + round) % entries.size()];
            if (!done(entry)) {
                run_once(entry, repeats, paces_[entry.key]);
            }
        }
    }
    std::vector<Measurement> measurements;
    for (Entry& entry : entries) {
        measurements.push_back(std::move(entry.measurement));
    }
    return measurements;
}

int check(const std::vector<Measurement>& group) {
    int complaints = 0;
    const auto complain = [&](const Measurement& m, const std::string& what) {
        std::fprintf(stderr, "check: %s n=%zu %s: %s\n", m.input.c_str(), m.n, m.peer.c_str(), what.c_str());
        ++complaints;
    };
    const auto is_mine = [](const Measurement& m) { return m.peer.starts_with("votess"); };
    for (const Measurement& m : group) {
        const bool mine = is_mine(m);
        if (m.seconds.empty()) {
            if (mine && m.note.starts_with(failed)) {
                complain(m, m.note);
            }
            continue;
        }
        if (m.bounded && m.want == Want::full && !close(m.answer.volume, m.box_volume, m.volume_error)) {
            complain(m, "the volumes do not fill the box");
        }
        if (mine && m.answer.links != m.expected_links.value_or(m.answer.links)) {
            complain(m, std::to_string(m.answer.links) + " neighbors instead of " + std::to_string(*m.expected_links) +
                            ", as ties have to be decided");
        }
        const auto reference = std::ranges::find_if(
            group, [&](const Measurement& v) { return is_mine(v) && !v.seconds.empty() && same_task(v, m); });
        if (reference == group.end()) {
            continue;
        }
        const Measurement& votess = *reference;
        if (mine && m.answer.links != votess.answer.links) {
            complain(m, "another number of neighbors with other threads, instructions or on another device");
        }
        if (std::ranges::count(in_general_position, m.input) > 0) {
            const auto ours = static_cast<double>(votess.answer.links), theirs = static_cast<double>(m.answer.links);
            if (m.bounded ? !close(ours, theirs, 1e-4) : theirs < ours * (1 - 1e-4)) {
                complain(m,
                         std::to_string(m.answer.links) + " neighbors, votess " + std::to_string(votess.answer.links));
            }
            if (m.answer.area > 0 && votess.answer.area > 0 && !close(m.answer.area, votess.answer.area, 1e-5)) {
                complain(m, "the face areas have another sum than those of votess");
            }
        }
    }
    return complaints;
}

}  // namespace bench

// Sums over groups: the entries of the rows are sorted by the groups on both sides.
#include "votess/groups.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "core/progress.hpp"
#include "input/option_name.hpp"
#include "input/supports.hpp"

namespace votess {
namespace {

constexpr std::size_t rows_per_stop = 4096;

std::size_t index_of(std::int32_t number) {
    return static_cast<std::size_t>(number);
}

struct Contact {
    std::int64_t count = 0;
    double area = 0;
};

// Returns the sums of a value of each cell by group; nothing where the tessellation lacks it.
std::vector<double> sums(std::span<const double> values, const std::vector<std::int32_t>& group, std::size_t groups) {
    if (values.empty()) return {};
    std::vector<double> result(groups);
    for (std::size_t i = 0; i < values.size(); ++i) result[index_of(group[i])] += values[i];
    return result;
}

}  // namespace

Groups groups(const Tessellation& t, std::span<const std::int64_t> labels) {
    require(t, "groups");
    const auto refuse = [](const std::string& message) {
        throw Error(ErrorCode::invalid_argument, "groups(): " + message);
    };
    if (t.indptr().size() != t.size() + 1) refuse("the tessellation has no rows, set " + option("want.neighbors"));
    if (labels.size() != t.size())
        refuse(std::to_string(labels.size()) + " labels for " + std::to_string(t.size()) + " seeds: give one for each");

    Groups out;
    out.labels.assign(labels.begin(), labels.end());
    std::ranges::sort(out.labels);
    out.labels.erase(std::ranges::unique(out.labels).begin(), out.labels.end());
    std::vector<std::int32_t> group(labels.size());
    for (std::size_t i = 0; i < labels.size(); ++i)
        group[i] = static_cast<std::int32_t>(std::ranges::lower_bound(out.labels, labels[i]) - out.labels.begin());
    out.members.resize(labels.size());
    std::iota(out.members.begin(), out.members.end(), 0);
    std::ranges::stable_sort(out.members, {}, [&](std::int32_t i) { return group[index_of(i)]; });
    out.member_indptr.assign(out.size() + 1, 0);
    for (const std::int32_t g : group) ++out.member_indptr[index_of(g) + 1];
    std::partial_sum(out.member_indptr.begin(), out.member_indptr.end(), out.member_indptr.begin());

    // Both groups get the sum over the rows of the lower one, so that their areas are equal.
    const std::span<const double> areas = t.face_areas();
    std::vector<std::map<std::int32_t, Contact>> contacts(out.size());
    std::vector<double> within(out.size());  // areas of faces between cells of the same group
    for (std::size_t m = 0; m < out.members.size(); ++m) {
        if (m % rows_per_stop == 0) check_stop();
        const std::size_t i = index_of(out.members[m]);
        const std::int32_t own = group[i];
        for (auto k = static_cast<std::size_t>(t.indptr()[i]); k < static_cast<std::size_t>(t.indptr()[i + 1]); ++k) {
            const std::int32_t neighbor = t.indices()[k];
            const std::int32_t other = neighbor < 0 ? neighbor : group[index_of(neighbor)];
            if (other == own) {
                if (!areas.empty()) within[index_of(own)] += areas[k];
                continue;
            }
            if (other >= 0 && other < own) continue;
            Contact& contact = contacts[index_of(own)][other];
            ++contact.count;
            if (!areas.empty()) contact.area += areas[k];
        }
    }
    for (std::size_t g = 0; g < out.size(); ++g)
        for (const auto& [other, contact] : contacts[g])
            if (other > static_cast<std::int32_t>(g)) contacts[index_of(other)][static_cast<std::int32_t>(g)] = contact;
    out.indptr.push_back(0);
    for (const auto& own : contacts) {
        for (const auto& [other, contact] : own) {
            out.indices.push_back(other);
            out.counts.push_back(contact.count);
            if (!areas.empty()) out.areas.push_back(contact.area);
        }
        out.indptr.push_back(static_cast<std::int64_t>(out.indices.size()));
    }
    out.volumes = sums(t.volumes(), group, out.size());
    if (!areas.empty()) out.surface_areas = sums(t.surface_areas(), group, out.size());
    for (std::size_t g = 0; g < out.surface_areas.size(); ++g) out.surface_areas[g] -= within[g];
    out.mesh_areas = sums(t.mesh_areas(), group, out.size());
    return out;
}

}  // namespace votess

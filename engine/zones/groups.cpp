// Sums over groups: the entries of the rows are sorted by the groups on both sides.
#include "votess/groups.hpp"

#include <algorithm>
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
    std::int32_t other = 0;  // group, or wall if negative
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

    // Of each group: its contacts with walls and with groups of larger numbers. The latter get the same sums.
    const std::span<const double> areas = t.face_areas();
    std::vector<Contact> contacts;
    std::vector<std::size_t> offsets{0};
    std::vector<std::int64_t> walls(out.size()), lower(out.size());
    std::vector<double> within(out.size());  // areas of faces between cells of the same group
    std::vector<Contact> faces;
    for (std::size_t g = 0; g < out.size(); ++g) {
        const auto own = static_cast<std::int32_t>(g);
        faces.clear();
        for (auto m = out.member_indptr[g]; m < out.member_indptr[g + 1]; ++m) {
            if (m % rows_per_stop == 0) check_stop();
            const std::size_t i = index_of(out.members[static_cast<std::size_t>(m)]);
            for (auto k = static_cast<std::size_t>(t.indptr()[i]); k < static_cast<std::size_t>(t.indptr()[i + 1]);
                 ++k) {
                const std::int32_t neighbor = t.indices()[k];
                const std::int32_t other = neighbor < 0 ? neighbor : group[index_of(neighbor)];
                const double area = areas.empty() ? 0 : areas[k];
                if (other == own) within[g] += area;
                if (other < 0 || other > own) faces.push_back({other, 1, area});
            }
        }
        std::ranges::stable_sort(faces, {}, &Contact::other);
        for (std::size_t k = 0; k < faces.size(); ++k) {
            if (k > 0 && faces[k].other == faces[k - 1].other) {
                ++contacts.back().count;
                contacts.back().area += faces[k].area;
                continue;
            }
            contacts.push_back(faces[k]);
            ++(faces[k].other < 0 ? walls[g] : lower[index_of(faces[k].other)]);
        }
        offsets.push_back(contacts.size());
    }
    // A row: walls, groups of smaller numbers, groups of larger ones.
    out.indptr.push_back(0);
    std::vector<std::size_t> next;  // place of the next group of a smaller number
    for (std::size_t g = 0; g < out.size(); ++g) {
        next.push_back(static_cast<std::size_t>(out.indptr[g] + walls[g]));
        out.indptr.push_back(out.indptr[g] + static_cast<std::int64_t>(offsets[g + 1] - offsets[g]) + lower[g]);
    }
    const auto entries = static_cast<std::size_t>(out.indptr.back());
    out.indices.resize(entries);
    out.counts.resize(entries);
    out.areas.resize(areas.empty() ? 0 : entries);
    const auto place = [&](std::size_t at, std::int32_t other, const Contact& contact) {
        out.indices[at] = other;
        out.counts[at] = contact.count;
        if (!areas.empty()) out.areas[at] = contact.area;
    };
    for (std::size_t g = 0; g < out.size(); ++g)
        for (std::size_t c = offsets[g]; c < offsets[g + 1]; ++c) {
            const std::int32_t other = contacts[c].other;
            const auto at = static_cast<std::size_t>(out.indptr[g]) + c - offsets[g];
            if (other < 0) {
                place(at, other, contacts[c]);
                continue;
            }
            place(at + static_cast<std::size_t>(lower[g]), other, contacts[c]);
            place(next[index_of(other)]++, static_cast<std::int32_t>(g), contacts[c]);
        }
    out.volumes = sums(t.volumes(), group, out.size());
    // Without faces nothing lies within a group.
    if (!areas.empty() || t.indices().empty()) out.surface_areas = sums(t.surface_areas(), group, out.size());
    for (std::size_t g = 0; g < out.surface_areas.size(); ++g) out.surface_areas[g] -= within[g];
    out.mesh_areas = sums(t.mesh_areas(), group, out.size());
    return out;
}

}  // namespace votess

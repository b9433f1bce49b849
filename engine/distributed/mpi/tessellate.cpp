// Seeds travel to the blocks of their regions, one on each rank, and cells travel back.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "core/arithmetic.hpp"
#include "core/errors.hpp"
#include "distributed/blocks/messages.hpp"
#include "distributed/mpi/exchange.hpp"
#include "distributed/mpi/pack_cells.hpp"
#include "distributed/mpi/run_on_ranks.hpp"
#include "input/hull_of_parts.hpp"
#include "input/seeds.hpp"
#include "input/settle.hpp"
#include "plane/sheet.hpp"

namespace votess::mpi {
namespace {

constexpr std::size_t sample_of_all = 1000000, min_sample = 64, max_sample = 2048;  // places: in all, in each block

class Run {
public:
    Run(MPI_Comm comm, std::span<const double> points, std::span<const std::int64_t> ids)
        : ranks_(comm), points_(points.begin(), points.end()), ids_(ids.begin(), ids.end()) {}
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    Result operator()(std::span<const CommonArgument> common, const std::function<Settled()>& settle, Cells where) {
        ranks_.agree("tessellate", common);
        ranks_.together([&] { whole_ = settle(); });
        dimensions_ = whole_.region.planar ? 2 : 3;
        first_ = ranks_.maximum(std::uint64_t{ids_.size()}) > 0
                     ? 0
                     : ranks_.sum_before(std::uint64_t{points_.size() / dimensions_});
        ranks_.together([&] {
            check_input();
            if (dimensions_ == 2) points_ = in_sheet({points_, {}});
        });
        assign_ids();
        split_domain();
        send_seeds();
        clip();
        Result result = where == Cells::made ? keep() : send_back();
        result.options = options_of(domain_->whole());
        result.options.progress = {};
        counts_.bytes = ranks_.sum(ranks_.bytes_sent());
        result.counts = counts_;
        return result;
    }

private:
    [[nodiscard]] std::size_t count() const { return points_.size() / 3; }  // after check_input()
    [[nodiscard]] std::size_t ranks() const { return static_cast<std::size_t>(ranks_.size()); }

    // Returns false when the user stops this rank, and throws when another rank has failed. Progress never goes back,
    // although a block starts again at 0 with its pending cells.
    bool going_on(double fraction) {
        ranks_.check_others();
        done_ = std::max(done_, fraction);
        return !whole_.progress || whole_.progress(done_);
    }

    void check_input() {
        const std::size_t dimensions = dimensions_, count = points_.size() / dimensions;
        if (points_.size() % dimensions != 0)
            refuse("points hold " + std::to_string(points_.size()) + " coordinates, which is not a multiple of " +
                   std::to_string(dimensions) + ": the shape must be (N," + std::to_string(dimensions) + ")");
        for (std::size_t i = 0; i < points_.size(); ++i)
            if (!std::isfinite(points_[i])) {
                char number[32];
                std::snprintf(number, sizeof number, "%.17g", points_[i]);
                refuse("point " + std::to_string(first_ + i / dimensions) + ": " + "xyz"[i % dimensions] + " = " +
                       number + " is not finite");
            }
        if (!ids_.empty() && ids_.size() != count)
            refuse(std::to_string(ids_.size()) + " ids for " + std::to_string(count) + " points");
        for (std::size_t i = 0; i < ids_.size(); ++i)
            if (ids_[i] < 0) refuse("id " + std::to_string(i) + " = " + std::to_string(ids_[i]) + " is negative");
    }

    // Checks that ids, weights and radii are given on all ranks that have points, or on none, and each id once. Without
    // ids seeds are numbered. Radii become weights.
    void assign_ids() {
        counts_.seeds = ranks_.sum(std::uint64_t{count()});
        const auto require_on_all = [&](std::size_t own, const std::string& name) {
            const bool given = ranks_.maximum(std::uint64_t{own}) > 0;
            ranks_.together([&] {
                if (given && own != count())
                    refuse("it has " + std::to_string(own) + " " + name + " for " + std::to_string(count()) +
                           " points, but another rank has " + name + ": give them on all ranks or on none");
            });
            return given;
        };
        const Weights& given = whole_.weights;
        require_on_all(given.are_radii ? 0 : given.given.size(), "weights");
        require_on_all(given.are_radii ? given.given.size() : 0, "radii");
        for (std::size_t i = 0; i < given.given.size(); ++i) weights_.push_back(given[i]);
        if (!require_on_all(ids_.size(), "ids")) {
            for (std::size_t i = 0; i < count(); ++i) ids_.push_back(static_cast<std::int64_t>(first_ + i));
            return;
        }
        // Each id is checked by one rank.
        std::vector<std::vector<std::int64_t>> to(ranks());
        for (const std::int64_t id : ids_) to[static_cast<std::uint64_t>(id) % ranks()].push_back(id);
        std::vector<Message> messages;
        for (const auto& some : to) messages.push_back(to_bytes(some));
        std::vector<std::int64_t> all;
        for (const Message& message : ranks_.exchange(messages)) append_bytes(message, all);
        std::ranges::sort(all);
        ranks_.together([&] {
            const auto twice = std::ranges::adjacent_find(all);
            if (twice != all.end()) refuse("id " + std::to_string(*twice) + " is given twice");
        });
    }

    void split_domain() {
        const Box bounds = ranks_.bounds_of(points_);
        std::vector<double> sample;
        Settled watched = whole_;
        watched.progress = [this](double fraction) { return going_on(fraction); };
        ranks_.together([&] {
            domain_.emplace(watched, bounds, counts_.seeds);
            status_ = domain_->check(points_, whole_.weights, first_);
            std::vector<double> inside;
            for (std::size_t i = 0; i < count(); ++i) {
                if (status_[i] == CellStatus::outside) continue;
                inside_.push_back(i);
                inside.insert(inside.end(), &points_[3 * i], &points_[3 * i] + 3);
            }
            places_ = domain_->places(inside);
        });
        const double total = std::max(1.0, ranks_.sum(static_cast<double>(inside_.size())));
        const std::size_t of_block = std::clamp(sample_of_all / ranks(), min_sample, max_sample);
        const double share = std::min(1.0, static_cast<double>(of_block * ranks()) / total);
        const auto taken = static_cast<std::size_t>(std::ceil(share * static_cast<double>(inside_.size())));
        for (std::size_t k = 0; k < taken; ++k) {
            const std::size_t i = k * inside_.size() / taken;
            sample.insert(sample.end(), &places_[3 * i], &places_[3 * i] + 3);
        }
        std::vector<double> all;
        for (const Message& message : ranks_.gather_all(to_bytes(sample))) append_bytes(message, all);
        ranks_.together([&] { domain_->split(all, ranks()); });
    }

    void send_seeds() {
        const std::vector<std::uint32_t> block_of = domain_->blocks_of(places_);
        places_ = {};
        std::vector<Seeds> to(ranks());
        for (std::size_t s = 0; s < inside_.size(); ++s) {
            const std::size_t i = inside_[s];
            to[block_of[s]].add(ids_[i], points_, weights_, i);
        }
        std::vector<Message> messages;
        for (const Seeds& seeds : to) messages.push_back(to_message(seeds));
        to.clear();
        const std::vector<Message> from = ranks_.exchange(messages);
        ranks_.together([&] {
            for (std::size_t r = 0; r < from.size(); ++r) {
                Seeds seeds;
                read_message(from[r], seeds);
                seeds.tags.assign(seeds.size(), static_cast<std::int32_t>(r));
                made_.add(seeds);
            }
            made_ = made_.sorted();
        });
        counts_.largest_block = ranks_.maximum(std::uint64_t{made_.ids.size()});
    }

    void clip() {
        using namespace blocks;
        std::optional<LocalBlock> block;
        Message outline;
        ranks_.together([&] {
            Settled run = domain_->of_blocks();
            run.want.neighbors = true;  // cells travel with their rows
            block.emplace(run, made_);
            outline = votess::to_message(summary_of(block->outline()).tiles);
        });
        const std::vector<Message> outlines = ranks_.gather_all(outline);
        const auto own = static_cast<std::size_t>(ranks_.rank());
        std::vector<Message> to(ranks());
        const auto for_others = [&](const auto& make) {
            ranks_.together([&] {
                for (std::size_t r = 0; r < ranks(); ++r) to[r] = r == own ? Message{} : make(r);
            });
            return ranks_.exchange(to);
        };
        const auto halos = for_others([&](std::size_t r) {
            return blocks::to_message(block->halo_for(read_outline(outlines[r])), block->outline());
        });
        ranks_.together([&] {
            std::vector<Outline> others(ranks());
            Seeds all;
            for (std::size_t r = 0; r < ranks(); ++r) {
                if (r == own) continue;
                others[r] = read_outline(outlines[r]);
                Seeds halo;
                read_halo(halos[r], halo, others[r]);
                all.add(halo);
            }
            block->clip(std::move(others), own, std::move(all));
        });
        const auto requests = for_others([&](std::size_t r) { return votess::to_message(block->requests()[r]); });
        ranks_.together([&] {
            std::vector<Requests> all(ranks());
            for (std::size_t r = 0; r < ranks(); ++r) read_message(requests[r], all[r]);
            const std::vector<Seeds> replies = block->reply(all);
            for (std::size_t r = 0; r < ranks(); ++r) to[r] = votess::to_message(replies[r]);
        });
        const auto replies = ranks_.exchange(to);
        Message far;
        ranks_.together([&] {
            block->complete(joined<Seeds>(replies), *domain_);
            far = votess::to_message(block->far());
        });
        std::vector<Message> all_far;
        if (domain_->endless()) all_far = ranks_.gather_all(far);
        ranks_.together([&] { cells_ = block->finish(joined<FarCells>(all_far), *domain_); });
        counts_.given = ranks_.sum(block->counts().given);
        counts_.needed = ranks_.sum(block->counts().needed);
        counts_.tested = ranks_.sum(block->counts().tested);
        counts_.questions = ranks_.sum(block->counts().questions);
        counts_.exact_cells = ranks_.sum(block->counts().exact_cells);
        double volume = 0;
        for (const double v : cells_.volumes) volume += v;
        counts_.volume_sum = ranks_.sum(volume);
        ranks_.together([&] {
            counts_.box_volume =
                domain_->volume(std::span(made_.points).first(std::min<std::size_t>(3, made_.points.size())));
        });
        counts_.box_volume = ranks_.maximum(counts_.box_volume);
    }

    Result keep() {
        Result result;
        result.ids = std::move(made_.ids);
        result.points = dimensions_ == 2 ? out_of_sheet(made_.points) : std::move(made_.points);
        result.weights = std::move(made_.weights);
        result.cells = std::move(cells_);
        return result;
    }

    Result send_back() {
        std::vector<std::vector<std::size_t>> of_owner(ranks());
        for (std::size_t i = 0; i < made_.tags.size(); ++i)
            of_owner[static_cast<std::size_t>(made_.tags[i])].push_back(i);
        std::vector<Message> to;
        SomeCells own;
        ranks_.together([&] {
            std::swap(own.places, of_owner[static_cast<std::size_t>(ranks_.rank())]);
            for (const auto& cells : of_owner) to.push_back(pack(made_.ids, cells_, cells, dimensions_ == 2));
            own.ids = std::move(made_.ids);
            own.cells = std::move(cells_);
            if (own.places.empty()) own.cells = {};
        });
        made_ = {};
        const std::vector<Message> from = ranks_.exchange(to);
        to = {};
        Result result;
        ranks_.together([&] {
            result.ids = ids_;
            result.weights = weights_;
            result.cells = unpack(from, ids_, status_, whole_, std::move(own));
        });
        list_exchange(result);
        return result;
    }

    // Rows are symmetric: another rank needs those of my seeds that have neighbors of its own.
    void list_exchange(Result& result) const {
        std::vector<std::vector<std::int64_t>> lists(ranks());
        std::vector<Message> messages;
        ranks_.together([&] {
            for (std::size_t i = 0; i + 1 < result.cells.indptr.size(); ++i)
                for (auto e = static_cast<std::size_t>(result.cells.indptr[i]);
                     e < static_cast<std::size_t>(result.cells.indptr[i + 1]); ++e) {
                    const std::int32_t owner = result.cells.owners[e];
                    if (owner < 0 || owner == ranks_.rank()) continue;
                    auto& list = lists[static_cast<std::size_t>(owner)];
                    if (list.empty() || list.back() != result.ids[i]) list.push_back(result.ids[i]);
                }
            for (auto& list : lists) {
                if (!std::ranges::is_sorted(list)) std::ranges::sort(list);
                messages.push_back(to_bytes(list));
            }
        });
        const std::vector<Message> from = ranks_.exchange(messages);
        ranks_.together([&] {
            result.send_indptr.assign(1, 0);
            result.receive_indptr.assign(1, 0);
            for (std::size_t r = 0; r < ranks(); ++r) {
                result.send.insert(result.send.end(), lists[r].begin(), lists[r].end());
                append_bytes(from[r], result.receive);
                result.send_indptr.push_back(static_cast<std::int64_t>(result.send.size()));
                result.receive_indptr.push_back(static_cast<std::int64_t>(result.receive.size()));
            }
        });
    }

    Ranks ranks_;
    // The caller's arrays, copied once: another thread may write into them.
    std::vector<double> points_;
    std::vector<std::int64_t> ids_;
    Settled whole_;
    std::size_t dimensions_ = 3;
    std::vector<double> weights_;
    std::uint64_t first_ = 0;  // number of the first point, in messages
    std::optional<BlockDomain> domain_;
    std::vector<CellStatus> status_;
    std::vector<std::size_t> inside_;
    std::vector<double> places_;
    Seeds made_;  // tags: the ranks that handed them in
    BlockCells cells_;
    Counts counts_;
    double done_ = 0;  // the last argument of the progress callback
};

}  // namespace

std::vector<Wall> hull_of_ranks(MPI_Comm comm, std::span<const double> points, const Region& given) {
    const Ranks ranks(comm);
    ranks.agree("hull_walls", std::array{CommonArgument{"the number of dimensions", Hash().mix(given.planar).value()}});
    std::optional<HullOfParts> hull;
    ranks.together([&] {
        hull.emplace(given);
        hull->add(std::vector<double>(points.begin(), points.end()));  // read once, see input/snapshot.hpp
    });
    std::vector<double> corners;
    for (const Message& message : ranks.gather_all(to_bytes(hull->corners()))) append_bytes(message, corners);
    const std::uint64_t count = ranks.sum(std::uint64_t{points.size() / (given.planar ? 2 : 3)});
    std::vector<Wall> walls;
    ranks.together([&] {
        HullOfParts all(given);
        all.add(corners);
        walls = all.walls(count);
    });
    return walls;
}

Result run_on_ranks(MPI_Comm comm, std::span<const double> points, std::span<const std::int64_t> ids,
                    std::span<const CommonArgument> common, const std::function<Settled()>& settle, Cells cells) {
    return Run(comm, points, ids)(common, settle, cells);
}

}  // namespace votess::mpi

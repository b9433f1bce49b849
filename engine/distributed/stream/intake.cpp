#include "distributed/stream/intake.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <thread>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "plane/sheet.hpp"
#include "query/locator.hpp"

namespace votess::stream {
namespace {

constexpr std::size_t task_seeds = 4096;
constexpr std::uint32_t no_block = std::numeric_limits<std::uint32_t>::max();

// Returns whether float32 holds the coordinates.
bool is_single(std::span<const double> points) {
    return std::ranges::all_of(points, [](double x) { return static_cast<double>(static_cast<float>(x)) == x; });
}

Job job_of(std::uint64_t first, const StreamSeeds& some, Settled run) {
    run.points = {some.points, {}, first};
    run.weights = weights_of(some.weights, some.radii);
    return make_job(std::move(run));
}

// Writes the seeds of each block in batches.
class BlockWriter {
public:
    BlockWriter(Intake::BlockSpools& to, std::size_t blocks, std::size_t batch_size)
        : to_(to), batch_size_(batch_size), batches_(blocks) {}

    void add(std::uint32_t block, std::uint64_t id, const double* point, const double* weight) {
        Batch& batch = batches_[block];
        batch.ids.push_back(static_cast<std::int64_t>(id));
        batch.points.insert(batch.points.end(), point, point + 3);
        if (weight != nullptr) batch.weights.push_back(*weight);
        if (batch.ids.size() == batch_size_) write(block);
    }
    void end() {
        for (std::size_t b = 0; b < batches_.size(); ++b) write(b);
    }

private:
    struct Batch {
        std::vector<std::int64_t> ids;
        std::vector<double> points, weights;
    };
    void write(std::size_t block) {
        Batch& batch = batches_[block];
        to_.counts[block] += batch.ids.size();
        to_.ids[block].append(std::span<const std::int64_t>(batch.ids));
        to_.points[block].append(std::span<const double>(batch.points));
        to_.weights[block].append(std::span<const double>(batch.weights));
        batch.ids.clear(), batch.points.clear(), batch.weights.clear();
    }

    Intake::BlockSpools& to_;
    std::size_t batch_size_;
    std::vector<Batch> batches_;
};

}  // namespace

Intake::Intake(StreamSource& source, const Settled& whole, bool hull, const std::string& folder, DiskUse& use,
               std::uint64_t memory, Stages& stages)
    : source_(source),
      region_(whole.region.planar ? in_sheet(whole.region, 1) : whole.region),
      planar_(whole.region.planar),
      stages_(stages),
      pool_(whole.threads),
      max_at_once_(std::clamp<std::size_t>(static_cast<std::size_t>(memory / 400), 1000, 250000)),
      max_sampled_(std::clamp<std::size_t>(static_cast<std::size_t>(memory / 800), 1000, 1000000)),
      bounds_(empty_box) {
    if (hull) hull_.emplace(whole.region);
    if (source_.restart()) return;
    file_.emplace(folder, use);
    copied_points_.emplace(*file_);
    copied_weights_.emplace(*file_);
}

template <class Task>
void Intake::read(const Task& task) {
    std::uint64_t first = 0;
    if (scanned_ && copied_points_) {
        for (Spool* copied : {&*copied_points_, &*copied_weights_}) copied->release_as_read();
        std::vector<double> points, weights;
        while (copied_points_->remaining() > 0) {
            const auto count =
                std::min<std::size_t>(max_at_once_, static_cast<std::size_t>(copied_points_->remaining() / 3));
            points.resize(3 * count);
            copied_points_->read(std::span(points));
            weights.resize(weighted_ ? count : 0);
            copied_weights_->read(std::span(weights));
            const std::span<const double> beside(weights), none;
            task(first, StreamSeeds{points, radii_ ? none : beside, radii_ ? beside : none});
            first += count;
        }
        return;
    }
    if (scanned_ && !source_.restart()) throw Error(ErrorCode::invalid_use, "the source of seeds did not restart");
    StreamSeeds some;
    std::vector<double> points, weights;  // read once, see input/snapshot.hpp
    while (some = {}, source_.next(some)) {
        const std::size_t dimensions = planar_ ? 2 : 3;
        if (some.points.size() % dimensions != 0)
            refuse("points of a piece hold " + std::to_string(some.points.size()) +
                   " coordinates, which is not a multiple of " + std::to_string(dimensions) +
                   ": the shape must be (N," + std::to_string(dimensions) + ")");
        const std::size_t count = some.points.size() / dimensions;
        for (const auto& [values, name] : {std::pair(some.weights, "weights"), {some.radii, "radii"}})
            if (!values.empty() && values.size() != count)
                refuse(std::string(name) + " of a piece hold " + std::to_string(values.size()) + " numbers for " +
                       std::to_string(count) + " points");
        if (count > 0) check_kind(first, some);
        for (std::size_t begin = 0; begin < count; begin += max_at_once_) {
            const std::size_t size = std::min(max_at_once_, count - begin);
            const auto copy = [](std::span<const double> values, std::vector<double>& to) {
                to.assign(values.begin(), values.end());
            };
            const std::span<const double> beside = some.radii.empty() ? some.weights : some.radii;
            const std::span given = some.points.subspan(dimensions * begin, dimensions * size);
            if (planar_)
                points = in_sheet({given, {}});
            else
                copy(given, points);
            copy(beside.empty() ? beside : beside.subspan(begin, size), weights);
            task(first, some.radii.empty() ? StreamSeeds{points, weights, {}} : StreamSeeds{points, {}, weights});
            first += size;
        }
    }
    if (scanned_ && first != seeds_)
        throw Error(ErrorCode::invalid_use, "the source gave " + std::to_string(seeds_) + " seeds, then " +
                                                std::to_string(first) +
                                                ": it must give the same seeds at each reading");
}

void Intake::check_kind(std::uint64_t first, const StreamSeeds& some) {
    const bool weighted = !some.weights.empty() || !some.radii.empty();
    const bool all_like_this = weighted == weighted_ && (some.weights.empty() || !radii_);
    if ((first > 0 || scanned_) && !all_like_this)
        refuse("some pieces of seeds have weights, others have radii or neither");
    if (!some.weights.empty() && !some.radii.empty())
        refuse(option("weights") + " and " + option("radii") +
               " are both given: weights are the squares of radii, give one of them");
    weighted_ = weighted;
    radii_ |= !some.radii.empty();
}

void Intake::check(std::uint64_t first, const StreamSeeds& some) {
    std::vector<CellStatus> outside;
    const Box box = check_points({some.points, {}, first}, region_, outside);
    include(bounds_, box);
    singles_ = singles_ && is_single(some.points);
}

// Keeps every 2^k-th seed, with the least k that fits.
void Intake::take_sample(std::uint64_t first, std::span<const double> points) {
    for (std::size_t i = 0; i < points.size() / 3; ++i) {
        if ((first + i) % every_ != 0) continue;
        sample_.insert(sample_.end(), &points[3 * i], &points[3 * i] + 3);
        if (sample_.size() < 3 * max_sampled_) continue;
        std::size_t kept = 0;
        for (std::size_t s = 0; s < sample_.size() / 3; s += 2, ++kept)
            std::copy_n(&sample_[3 * s], 3, &sample_[3 * kept]);
        sample_.resize(3 * kept);
        every_ *= 2;
    }
}

void Intake::scan() {
    read([&](std::uint64_t first, const StreamSeeds& some) {
        check(first, some);
        if (hull_) hull_->add(planar_ ? std::span<const double>(out_of_sheet(some.points)) : some.points);
        take_sample(first, some.points);
        seeds_ = first + some.points.size() / 3;
        if (copied_points_) {
            copied_points_->append(some.points);
            copied_weights_->append(some.weights);
            copied_weights_->append(some.radii);
        }
        stages_.at(0, 1);
    });
    scanned_ = true;
}

blocks::Partition Intake::partition(Settled of_blocks, std::size_t blocks) {
    Outside& outside = of_blocks.region.outside;
    if (outside == Outside::error) outside = Outside::drop;  // distribute() finds it
    const Job job = job_of(0, {sample_, {}, {}}, std::move(of_blocks));
    std::vector<exact::Point> places;
    for (std::size_t i = 0; i < sample_.size() / 3; ++i) {
        if (!job.outside.empty() && job.outside[i] == CellStatus::outside) continue;
        if (const auto place = cpu::place_in(*job.domain, point_of(sample_, i, job.scale))) places.push_back(place->at);
    }
    sample_ = {};
    return {std::move(places), blocks};
}

Intake::BlockSpools Intake::distribute(const Settled& of_blocks, std::size_t blocks, TemporaryFile& ids,
                                       TemporaryFile& seeds) {
    const blocks::Partition partition = this->partition(of_blocks, blocks);
    BlockSpools spools{std::vector(blocks, Spool(ids)),
                       std::vector(blocks, Spool(seeds)),
                       std::vector(blocks, Spool(seeds)),
                       std::vector(blocks, empty_box),
                       std::vector(blocks, -infinity),
                       std::vector<std::uint64_t>(blocks),
                       {}};
    BlockWriter writer(spools, blocks, std::clamp<std::size_t>(4 * max_at_once_ / blocks, 64, 1 << 15));
    std::vector<exact::Point> places;
    std::vector<std::uint32_t> block_of;
    read([&](std::uint64_t first, const StreamSeeds& some) {
        const Job job = job_of(first, some, of_blocks);
        const std::size_t count = some.points.size() / 3;
        places.resize(count);
        block_of.assign(count, no_block);
        pool_.run(ceil_div(count, task_seeds), [&](std::size_t task, unsigned) {
            for (std::size_t i = task * task_seeds; i < std::min(count, (task + 1) * task_seeds); ++i) {
                if (!job.outside.empty() && job.outside[i] == CellStatus::outside) continue;
                const auto place = cpu::place_in(*job.domain, point_of(some.points, i, job.scale));
                if (!place)
                    refuse("point " + std::to_string(first + i) +
                           " lies more than 500 million periods away from the box");
                places[i] = place->at;
                block_of[i] = static_cast<std::uint32_t>(partition.block_of(place->at));
            }
        });
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t block = block_of[i];
            if (block == no_block) continue;
            if (spools.inside.empty()) spools.inside.assign(&some.points[3 * i], &some.points[3 * i] + 3);
            double weight = 0;
            if (weighted_) weight = some.radii.empty() ? some.weights[i] : some.radii[i] * some.radii[i];
            include(spools.boxes[block], places[i]);
            spools.heaviest[block] = std::max(spools.heaviest[block], weighted_ ? job.domain->weights[i] : 0);
            writer.add(block, first + i, &some.points[3 * i], weighted_ ? &weight : nullptr);
        }
        stages_.at(first + count, seeds_);
    });
    writer.end();
    file_.reset();
    return spools;
}

}  // namespace votess::stream

// Seeds are distributed to blocks, which are in memory one after the other: to make halos, to clip
// cells, and in part to reply to other blocks. Then rows are joined in input order.
#include <algorithm>
#include <cmath>
#include <string>

#include "core/errors.hpp"
#include "core/huge_pages.hpp"
#include "core/system.hpp"
#include "distributed/blocks/local_block.hpp"
#include "distributed/blocks/messages.hpp"
#include "distributed/stream/assembler.hpp"
#include "distributed/stream/intake.hpp"
#include "distributed/stream/plan.hpp"
#include "distributed/stream/run_stream.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "plane/sheet.hpp"
#include "verify/row_checker.hpp"

namespace votess::stream {
namespace {

using blocks::Requests;

std::string in_units(std::uint64_t bytes) {
    constexpr double mega = 1e6, giga = 1e9;
    const bool large = static_cast<double>(bytes) >= giga;
    const double number = static_cast<double>(bytes) / (large ? giga : mega);
    const std::string text = std::to_string(std::ceil(10 * number) / 10);
    return text.substr(0, text.find('.') + 2) + (large ? " GB" : " MB");
}

// Messages between blocks wait in files. Each is read once, in the order of writing.
void put(Spool& spool, std::uint64_t from, const Message& message) {
    if (message.empty()) return;
    spool.append(std::span<const std::uint64_t>(&from, 1));
    spool.append(std::span<const std::byte>(message));
}

// Calls task(from, message).
template <class Task>
void for_messages(Spool& spool, const Task& task) {
    while (spool.remaining() > 0) {
        const auto from = spool.read_piece<std::uint64_t>();
        task(static_cast<std::size_t>(from[0]), spool.read_piece<std::byte>());
    }
}

class Run final : public RunBlocks {
public:
    Run(StreamSource& source, StreamSink& sink, const Settled& given, const StreamOptions& stream)
        : sink_(sink),
          given_(given),
          stream_(stream),
          stages_(given),
          intake_(source, given, stream.hull, stream.temporary, use_, stream.memory, stages_) {}

    StreamResult operator()() {
        stages_.begin(&StageSeconds::upload, 0.04, "reading the seeds");
        intake_.scan();
        plan();
        distribute();
        make_halos();
        clip();
        reply();
        finish_pending();
        write_rows();
        verify();
        stages_.end();
        result_.options = options_of(domain_->whole());
        result_.options.progress = given_.progress;
        result_.stats.seconds = stages_.seconds();
        result_.temporary_bytes = use_.peak();
        return std::move(result_);
    }

private:
    // The temporary files of a block.
    struct Block {
        Block(TemporaryFile& seeds, const Layout& layout, TemporaryFile& file, TemporaryFile& ids, Spool own)
            : tiles(seeds),
              halos(seeds),
              requests(seeds),
              pending(seeds),
              replies(seeds),
              border(seeds),
              rows(layout, file, std::move(own)),
              pending_rows(layout, file, Spool(ids)) {
            for (Spool* read_once : {&halos, &requests, &pending, &replies}) read_once->release_as_read();
        }
        Spool tiles, halos, requests, pending, replies;
        Spool border;  // rows of other blocks, to verify
        std::size_t halo_seeds = 0;
        RowStore rows, pending_rows;
    };

    // Chooses the domain and the number of blocks, and checks the room on the disk.
    void plan() {
        Settled plain = given_;
        plain.progress = {};
        if (stream_.hull) plain.region.walls = intake_.hull_walls();
        domain_.emplace(std::move(plain), intake_.bounds(), intake_.seeds());
        const Kind kind{of_blocks().want, is_periodic(), intake_.weighted(), intake_.singles(), stream_.verify};
        count_ = blocks_for(stream_.memory, intake_.seeds(), kind);
        result_.blocks = count_;
        const std::uint64_t needed = bytes_on_disk(intake_.seeds(), count_, kind);
        const std::string folder = temporary_folder(stream_.temporary);
        stages_.log("about " + in_units(needed) + " of temporary files in " + folder);
        if (const std::uint64_t room = free_bytes(folder); room < needed)
            throw Error(ErrorCode::storage, "temporary files take about " + in_units(needed) + ", but '" + folder +
                                                "' has room for " + in_units(room) +
                                                ": free some, or choose another folder");
        layout_.emplace(domain_->whole(), intake_.seeds());
    }

    [[nodiscard]] const Settled& of_blocks() const { return domain_->of_blocks(); }
    [[nodiscard]] bool is_periodic() const { return domain_->whole().region.is_periodic(); }

    void distribute() {
        stages_.begin(
            &StageSeconds::upload, 0.1,
            "distributing " + std::to_string(intake_.seeds()) + " seeds to " + std::to_string(count_) + " blocks");
        for (auto* file : {&ids_, &seeds_, &rows_}) file->emplace(stream_.temporary, use_);
        spools_.emplace(intake_.distribute(of_blocks(), count_, *ids_, *seeds_));
        result_.stats.box_volume = domain_->volume(spools_->inside);
        for (std::size_t b = 0; b < count_; ++b) {
            blocks_.emplace_back(*seeds_, *layout_, *rows_, *ids_, spools_->ids[b]);
            result_.largest_block = std::max(result_.largest_block, spools_->counts[b]);
            blocks::Outline& outline = outlines_.emplace_back();
            if (spools_->counts[b] > 0) outline = blocks::outline_of({{spools_->boxes[b], 0, spools_->heaviest[b]}});
        }
    }

    // Reads the seeds of a block. more: seeds that will be added.
    [[nodiscard]] Seeds seeds_of(std::size_t b, std::size_t more = 0) {
        const auto all = [more](Spool& spool, std::size_t each, auto& to) {
            if (spool.size() == 0) return;
            spool.rewind();
            reserve_in_huge_pages(to, static_cast<std::size_t>(spool.size()) + each * more);
            to.resize(static_cast<std::size_t>(spool.size()));
            spool.read(std::span(to));
        };
        Seeds seeds;
        all(spools_->ids[b], 1, seeds.ids);
        all(spools_->points[b], 3, seeds.points);
        all(spools_->weights[b], 1, seeds.weights);
        tag(b, seeds);
        return seeds;
    }

    // Calls task(seeds) for the seeds of a block, piece by piece.
    template <class Task>
    void for_seeds(std::size_t b, const Task& task) {
        constexpr std::uint64_t at_once = 65536;
        Spool &ids = spools_->ids[b], &points = spools_->points[b], &weights = spools_->weights[b];
        for (Spool* spool : {&ids, &points, &weights}) spool->rewind();
        Seeds some;
        while (ids.remaining() > 0) {
            const auto count = static_cast<std::size_t>(std::min(at_once, ids.remaining()));
            some.ids.resize(count);
            some.points.resize(3 * count);
            some.weights.resize(weights.size() > 0 ? count : 0);
            ids.read(std::span(some.ids));
            points.read(std::span(some.points));
            weights.read(std::span(some.weights));
            tag(b, some);
            task(some);
        }
    }

    // A proof needs to know the blocks of neighbors.
    void tag(std::size_t b, Seeds& seeds) const {
        if (stream_.verify) seeds.tags.assign(seeds.size(), static_cast<std::int32_t>(b));
    }

    // Keeps the rows of a block that others need for a proof: those of the first `count` cells.
    void keep_border(std::size_t b, const blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped) {
        if (!stream_.verify || !layout_->rows() || domain_->endless()) return;
        const Rows rows{run.result.indptr, run.result.indices, run.result.shifts};
        const std::vector<BorderRows> border = border_rows(run.seeds, rows, count, skipped, count_);
        for (std::size_t to = 0; to < count_; ++to) put(blocks_[to].border, b, to_message(border[to]));
    }

    [[nodiscard]] blocks::Outline outline_of(std::size_t b) {
        blocks_[b].tiles.rewind();
        return blocks::outline_of(blocks_[b].tiles.read_rest<blocks::Tile>());
    }

    void make_halos() {
        stages_.begin(&StageSeconds::sort, 0.2, "making halos between blocks");
        for (std::size_t b = 0; b < count_; ++b) {
            stages_.at(b, count_);
            system::give_back_memory();
            if (spools_->counts[b] == 0) continue;
            const blocks::LocalBlock block(of_blocks(), seeds_of(b));
            blocks_[b].tiles.append(std::span(block.outline().tiles));
            for (std::size_t to = 0; to < count_; ++to) {
                if (to == b) continue;
                const Seeds halo = block.halo_for(outlines_[to]);
                blocks_[to].halo_seeds += halo.size();
                put(blocks_[to].halos, b, to_message(halo));
            }
        }
    }

    void clip() {
        stages_.begin(&StageSeconds::clip, 0.72, "");
        for (std::size_t b = 0; b < count_; ++b) {
            system::give_back_memory();
            if (spools_->counts[b] == 0) continue;
            stages_.log("clipping block " + std::to_string(b + 1) + " of " + std::to_string(count_));
            Settled part = of_blocks();
            part.progress = stages_.within(b, count_);
            blocks::LocalBlock block(part, seeds_of(b, blocks_[b].halo_seeds));
            std::vector<blocks::Outline> others = outlines_;
            Seeds halo;
            for_messages(blocks_[b].halos, [&](std::size_t from, const Message& message) {
                Seeds some;
                read_message(message, some);
                halo.add(some);
                others[from] = outline_of(from);
            });
            block.clip(std::move(others), b, std::move(halo));
            const auto count = static_cast<std::size_t>(spools_->counts[b]);
            const std::vector<std::uint32_t> skipped = skip_far(block.run(), count, block.pending());
            keep_border(b, block.run(), count, skipped);
            domain_->complete(block.run().result);
            blocks_[b].rows.add(block.run(), count, skipped);
            for (std::size_t to = 0; to < count_; ++to) put(blocks_[to].requests, b, to_message(block.requests()[to]));
            if (block.pending().empty()) continue;
            const blocks::PendingCells pending = block.pending_cells();
            put(blocks_[b].pending, b, message_of(pending));
            if (!domain_->endless()) result_.stats.faces -= pending.faces;
            result_.asked_cells += pending.cells.size();
        }
    }

    // Sets far cells aside. Returns their rows and those that are skipped already, ascending, and adds the statistics.
    std::vector<std::uint32_t> skip_far(blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped) {
        std::vector<std::uint32_t> all = far_.take(*domain_, run, count, skipped);
        all.insert(all.end(), skipped.begin(), skipped.end());
        std::ranges::sort(all);
        Stats some = run.result.stats;
        if (domain_->endless()) {  // the faces of a domain without end are the entries of its rows
            some.faces = run.result.indices.size();
            for (const std::uint32_t row : all)
                some.faces -= static_cast<std::uint64_t>(run.result.indptr[row + 1] - run.result.indptr[row]);
        }
        add_stats(some);
        return all;
    }

    void add_stats(const Stats& some) {
        Stats& stats = result_.stats;
        stats.faces += some.faces;
        stats.duplicates += some.duplicates;
        stats.empty_cells += some.empty_cells;
        stats.exact_cells += some.exact_cells;
        stats.threads = some.threads;
    }

    void reply() {
        stages_.begin(&StageSeconds::fallback, 0.76, "finishing cells that reach other blocks");
        const Job job = make_job(of_blocks());
        for (std::size_t b = 0; b < count_; ++b) {
            system::give_back_memory();
            stages_.at(b, count_);
            if (blocks_[b].requests.size() == 0) continue;
            std::vector<std::size_t> from;
            std::vector<Requests> all;
            for_messages(blocks_[b].requests, [&](std::size_t block, const Message& message) {
                from.push_back(block);
                read_message(message, all.emplace_back());
            });
            blocks::NearSeeds near(job, outline_of(b), all);
            for_seeds(b, [&](const Seeds& some) { near.add(some, some.size()); });
            const std::vector<Seeds> replies = blocks::reply(of_blocks(), near, all);
            for (std::size_t r = 0; r < all.size(); ++r) put(blocks_[from[r]].replies, b, to_message(replies[r]));
        }
    }

    void finish_pending() {
        for (std::size_t b = 0; b < count_; ++b) {
            Block& block = blocks_[b];
            for_messages(block.pending, [&](std::size_t, const Message& message) {
                blocks::PendingCells pending;
                read_message(message, pending);
                Seeds replies;
                for_messages(block.replies, [&](std::size_t, const Message& some) {
                    Seeds seeds;
                    read_message(some, seeds);
                    replies.add(seeds);
                });
                blocks::Run run;
                blocks::finish_pending(of_blocks(), pending, replies, run);
                run.result.stats.exact_cells = 0;  // counted by clip()
                const std::vector<std::uint32_t> skipped = skip_far(run, pending.cells.size(), {});
                keep_border(b, run, pending.cells.size(), skipped);
                domain_->complete(run.result);
                block.pending_rows.ids().append(std::span<const std::int64_t>(pending.cells.ids));
                block.pending_rows.add(run, pending.cells.size(), skipped);
            });
        }
        find_far();
        if (!stream_.verify) {
            spools_.reset();
            seeds_.reset();
        }
        system::give_back_memory();
    }

    // Finds the cells that reach beyond the near ends.
    void find_far() {
        far_rows_.emplace(*layout_, *rows_, Spool(*ids_));
        if (far_.ids.empty()) return;
        std::ranges::sort(far_.ids);
        blocks::Run run;
        blocks::find_far(*domain_, far_, far_.ids, run);
        Stats some = run.result.stats;
        some.faces = run.result.indices.size();
        add_stats(some);
        domain_->complete(run.result);
        far_rows_->ids().append(std::span<const std::int64_t>(far_.ids));
        far_rows_->add(run, far_.ids.size(), {});
        far_ = {};
    }

    void write_rows() {
        stages_.begin(&StageSeconds::download, stream_.verify ? 0.95 : 1, "writing rows");
        StreamHead head;
        head.seeds = intake_.seeds();
        head.periodic = is_periodic();
        head.options = options_of(domain_->whole());
        std::vector<std::vector<RowStore*>> stores{{}, {}, {&*far_rows_}};
        for (Block& block : blocks_) {
            stores[0].push_back(&block.rows);
            stores[1].push_back(&block.pending_rows);
        }
        for (const auto& group : stores)
            for (RowStore* store : group) {
                if (!stream_.verify) store->release_as_read();
                head.entries += store->entries();
                head.duplicates |= store->has_duplicates();
            }
        // Bytes of a cell in memory: its arrays as read and in order, and ids in 64 bits.
        double bytes = 2 * static_cast<double>(layout_->bytes_of(Per::cell)) + 24;
        if (head.seeds > 0)
            bytes += (2 * static_cast<double>(layout_->bytes_of(Per::entry)) + 8) * static_cast<double>(head.entries) /
                     static_cast<double>(head.seeds);
        const auto max_cells =
            static_cast<std::size_t>(std::max(1000.0, 0.4 * static_cast<double>(stream_.memory) / bytes));
        ThreadPool pool(given_.threads);
        Assembler assembler(*layout_, head, stores, pool);
        sink_.begin(head);
        if (stream_.verify)
            checker_.emplace(checked_run(*domain_, head.seeds, result_.stats.box_volume), sample(), *this);
        Stats& stats = result_.stats;
        do {
            const StreamRows rows = assembler.next(max_cells);
            if (checker_) checker_->take(rows);
            sink_.rows(rows);
            for (const double volume : rows.volumes) stats.volume_sum += volume;
            stats.empty_cells += static_cast<std::uint64_t>(std::ranges::count(rows.status, CellStatus::outside));
            stages_.at(assembler.first(), head.seeds);
        } while (assembler.first() < head.seeds);
        stats.points = head.seeds;
        stats.device = "cpu";
        const std::uint64_t cells = stats.points - stats.empty_cells;
        if (domain_->whole().region.planar) stats.faces -= Sheet::more_faces * cells;
        stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
        stats.peak_memory_bytes = system::peak_memory();
    }

    // Blocks are read for each round of the sample, so there is one: as many cells as the usual budget pays for, and no
    // more than fit a tenth of the memory with what the blocks reply.
    [[nodiscard]] RowChecker::Sample sample() const {
        constexpr double bytes_of_reply = 2000, share = 0.1;
        const double room =
            share * static_cast<double>(stream_.memory) / (bytes_of_reply * static_cast<double>(count_ + 1));
        const std::size_t cells = sample_size(intake_.seeds(), count_, is_periodic());
        RowChecker::Sample sample;
        sample.unproven = "";
        sample.max_cells = sample.first_round = std::max(min_sample, std::min(cells, static_cast<std::size_t>(room)));
        return sample;
    }

    void verify() {
        if (!checker_) return;
        stages_.begin(&StageSeconds::download, 1, "checking the cells");
        result_.verified = checker_->report();
    }

    void for_proofs(const Prove& prove) override {
        ThreadPool pool(given_.threads);
        for (std::size_t b = 0; b < count_; ++b) {
            stages_.at(blocks_checked_++, passes * count_);
            system::give_back_memory();
            if (spools_->counts[b] == 0) continue;
            Block& block = blocks_[b];
            BorderRows border;
            block.border.rewind();
            for_messages(block.border, [&](std::size_t, const Message& message) {
                BorderRows some;
                read_message(message, some);
                border.add(some);
            });
            Seeds own = seeds_of(b);
            const std::vector<std::int64_t> ids = own.ids;
            StreamHead head;
            head.seeds = ids.size();
            head.duplicates = block.rows.has_duplicates();
            prove(std::move(own), border, [&](const Visit& visit) {
                Assembler assembler(*layout_, head, {{&block.rows}, {&block.pending_rows}}, pool, ids);
                while (assembler.first() < head.seeds) visit(assembler.next(rows_to_prove), {});
            });
        }
    }

    // Is called twice, to find the seeds of the sample and to clip their cells.
    void for_blocks(const std::function<void(Seeds)>& task) override {
        for (std::size_t b = 0; b < count_; ++b) {
            stages_.at(blocks_checked_++, passes * count_);
            system::give_back_memory();
            Seeds all = seeds_of(b);
            all.tags = {};
            Spool& spool = blocks_[b].rows.of(Layout::status);
            spool.rewind();
            const auto status = spool.read_rest<CellStatus>();
            Seeds seeds;
            for (std::size_t i = 0; i < all.size(); ++i)
                if (takes_part(status[i])) seeds.add(all, i);
            task(std::move(seeds));
        }
    }

    // Over all blocks: at most three for a proof, and two for a sample.
    static constexpr std::uint64_t passes = 5;
    static constexpr std::size_t rows_to_prove = std::size_t{1} << 14;  // at once in a stream of them

    StreamSink& sink_;
    const Settled& given_;
    const StreamOptions& stream_;
    Stages stages_;
    DiskUse use_;
    Intake intake_;
    std::optional<BlockDomain> domain_;
    std::size_t count_ = 1;
    std::optional<Layout> layout_;
    std::optional<TemporaryFile> ids_, seeds_, rows_;
    std::optional<Intake::BlockSpools> spools_;
    std::vector<Block> blocks_;
    blocks::FarCells far_;
    std::optional<RowStore> far_rows_;
    std::vector<blocks::Outline> outlines_;  // for blocks that get no halo
    std::optional<RowChecker> checker_;
    std::uint64_t blocks_checked_ = 0;
    StreamResult result_;
};

}  // namespace

StreamResult run_stream(StreamSource& source, StreamSink& sink, const Settled& whole, const StreamOptions& stream) {
    if (stream.memory < StreamOptions::least_memory)
        refuse("StreamOptions::memory = " + std::to_string(stream.memory) + " bytes is too little: give at least " +
               std::to_string(StreamOptions::least_memory));
    if (!whole.weights.empty())
        refuse(option("weights") + " and " + option("radii") +
               " of a stream come from its source with the points: leave them "
               "out of the options");
    (void)free_bytes(temporary_folder(stream.temporary));  // throws if it cannot be used
    try {
        return Run(source, sink, whole, stream)();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "out of memory: lower StreamOptions::memory, for smaller blocks");
    }
}

}  // namespace votess::stream

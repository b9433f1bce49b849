// tessellate_stream(): seeds are dealt out to blocks, which are in memory one after the other: for their layers, for
// their cells, and in part for what other blocks ask them. Then rows come together.
#include "votess/stream.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/peak_memory.hpp"
#include "distributed/blocks/local_block.hpp"
#include "distributed/blocks/messages.hpp"
#include "distributed/stream/assembler.hpp"
#include "distributed/stream/intake.hpp"
#include "distributed/stream/plan.hpp"
#include "input/implied_wants.hpp"
#include "input/options.hpp"
#include "verify/row_checker.hpp"

namespace votess {
namespace {

using namespace stream;
using blocks::Questions;

std::string in_units(std::uint64_t bytes) {
    constexpr double mega = 1e6, giga = 1e9;
    const bool large = static_cast<double>(bytes) >= giga;
    const double number = static_cast<double>(bytes) / (large ? giga : mega);
    const std::string text = std::to_string(std::ceil(10 * number) / 10);
    return text.substr(0, text.find('.') + 2) + (large ? " GB" : " MB");
}

// What blocks say to each other waits as well. Each message is read once, in the order in which they came.
void put(Spool& spool, std::uint64_t from, const Message& message) {
    if (message.empty()) return;
    const std::array<std::uint64_t, 2> head{from, message.size()};
    spool.append(std::span<const std::uint64_t>(head));
    spool.append(std::span<const std::byte>(message));
}

// Calls task(from, message).
template <class Task>
void for_messages(Spool& spool, const Task& task) {
    while (spool.left() > 0) {
        std::array<std::uint64_t, 2> head{};
        spool.read(std::span<std::uint64_t>(head));
        Message message(static_cast<std::size_t>(head[1]));
        spool.read(std::span(message));
        task(static_cast<std::size_t>(head[0]), message);
    }
}

class Run final : public RunBlocks {
public:
    Run(StreamSource& source, StreamSink& sink, const Options& options, const StreamOptions& stream)
        : sink_(sink),
          options_(options),
          stream_(stream),
          stages_(options),
          intake_(source, options_, stream.temporary, stream.memory, stages_) {}

    StreamResult operator()() {
        stages_.begin(&StageSeconds::upload, 0.04, "looking at the seeds");
        intake_.look();
        settle();
        deal();
        make_layers();
        clip();
        answer();
        finish_asked();
        hand_out();
        verify();
        stages_.end();
        result_.options = *settled_;
        result_.options.progress = options_.progress;
        result_.stats.seconds = stages_.seconds();
        return std::move(result_);
    }

private:
    // What a block has in temporary files.
    struct Block {
        Block(TemporaryFile& seeds, const Layout& layout, TemporaryFile& rows, TemporaryFile& ids, Spool own)
            : tiles(seeds),
              layers(seeds),
              questions(seeds),
              asked(seeds),
              answers(seeds),
              settled(layout, rows, std::move(own)),
              late(layout, rows, Spool(ids)) {}
        Spool tiles, layers, questions, asked, answers;
        RowStore settled, late;
    };

    void settle() {
        Options plain = options_;
        plain.progress = {};
        domain_.emplace(plain, intake_.bounds(), intake_.seeds());
        settled_ = domain_->options();
        settled_->want = with_implied(*settled_);
        const Kind kind{settled_->want, domain_is_periodic(), intake_.weighted()};
        count_ = blocks_for(stream_.memory, intake_.seeds(), kind);
        result_.blocks = count_;
        const std::uint64_t needed = bytes_on_disk(intake_.seeds(), count_, kind);
        const std::string folder = temporary_folder(stream_.temporary);
        stages_.say("about " + in_units(needed) + " of temporary files in " + folder);
        if (const std::uint64_t room = free_bytes(folder); room < needed)
            throw Error(ErrorCode::storage, "temporary files take about " + in_units(needed) + ", but '" + folder +
                                                "' has room for " + in_units(room) +
                                                ": free some, or give another folder for them");
        layout_.emplace(settled_->want, kind.periodic, intake_.seeds());
    }

    [[nodiscard]] bool domain_is_periodic() const {
        const auto& axes = settled_->cell ? settled_->cell->periodic : settled_->periodic;
        return std::ranges::count(axes, true) > 0;
    }

    void deal() {
        stages_.begin(
            &StageSeconds::upload, 0.1,
            "dealing " + std::to_string(intake_.seeds()) + " seeds out to " + std::to_string(count_) + " blocks");
        for (auto* file : {&ids_, &seeds_, &rows_}) file->emplace(stream_.temporary);
        dealt_.emplace(intake_.deal(*settled_, count_, *ids_, *seeds_));
        result_.stats.box_volume = domain_->volume(dealt_->inside);
        for (std::size_t b = 0; b < count_; ++b) {
            blocks_.emplace_back(*seeds_, *layout_, *rows_, *ids_, dealt_->ids[b]);
            result_.largest_block = std::max(result_.largest_block, dealt_->counts[b]);
            blocks::Outline& outline = outlines_.emplace_back();
            if (dealt_->counts[b] > 0) outline = blocks::outline_of({{dealt_->boxes[b], 0, dealt_->heaviest[b]}});
        }
    }

    // The seeds of a block, again from the first on.
    [[nodiscard]] Seeds seeds_of(std::size_t b) {
        const auto all = [](Spool& spool, auto& to) {
            spool.rewind();
            to.resize(static_cast<std::size_t>(spool.size() / sizeof(to[0])));
            spool.read(std::span(to));
        };
        Seeds seeds;
        all(dealt_->ids[b], seeds.ids);
        all(dealt_->points[b], seeds.points);
        all(dealt_->weights[b], seeds.weights);
        return seeds;
    }

    void put_tiles(std::size_t b, const blocks::TiledSeeds& tiled) {
        Writer writer;
        writer.put(tiled.outline.tiles);
        writer.put(tiled.order);
        writer.put(tiled.begin);
        put(blocks_[b].tiles, b, writer.take());
    }
    [[nodiscard]] blocks::TiledSeeds tiles_of(std::size_t b) {
        blocks::TiledSeeds tiled;
        blocks_[b].tiles.rewind();
        for_messages(blocks_[b].tiles, [&](std::size_t, const Message& message) {
            Reader reader(message);
            std::vector<blocks::Tile> tiles;
            reader.get(tiles);
            reader.get(tiled.order);
            reader.get(tiled.begin);
            tiled.outline = blocks::outline_of(std::move(tiles));
        });
        return tiled;
    }

    void make_layers() {
        stages_.begin(&StageSeconds::sort, 0.2, "making layers between blocks");
        for (std::size_t b = 0; b < count_; ++b) {
            stages_.at(b, count_);
            give_back_memory();
            if (dealt_->counts[b] == 0) continue;
            const blocks::LocalBlock block(*settled_, seeds_of(b));
            put_tiles(b, block.tiled());
            for (std::size_t to = 0; to < count_; ++to)
                if (to != b) put(blocks_[to].layers, b, to_message(block.layer_for(outlines_[to]), block.outline()));
        }
    }

    void clip() {
        stages_.begin(&StageSeconds::clip, 0.72, "");
        for (std::size_t b = 0; b < count_; ++b) {
            give_back_memory();
            if (dealt_->counts[b] == 0) continue;
            stages_.say("clipping block " + std::to_string(b + 1) + " of " + std::to_string(count_));
            Options options = *settled_;
            options.progress = stages_.within(b, count_);
            blocks::LocalBlock block(options, seeds_of(b), tiles_of(b));
            std::vector<blocks::Outline> others = outlines_;
            Seeds given;
            for_messages(blocks_[b].layers, [&](std::size_t from, const Message& message) {
                Seeds layer;
                from_message(message, layer, others[from]);
                given.add(layer);
            });
            block.clip(std::move(others), b, std::move(given));
            blocks_[b].settled.add(block.run(), static_cast<std::size_t>(dealt_->counts[b]), block.asking());
            for (std::size_t to = 0; to < count_; ++to)
                put(blocks_[to].questions, b, to_message(block.questions()[to]));
            add_stats(block.run().result.stats);
            if (block.asking().empty()) continue;
            const blocks::Asked asked = block.asked();
            put(blocks_[b].asked, b, asked_message(asked));
            result_.stats.faces -= asked.faces;
            result_.asked_cells += asked.cells.size();
        }
    }

    [[nodiscard]] static Message asked_message(const blocks::Asked& asked) {
        Writer writer;
        for (const Seeds* seeds : {&asked.cells, &asked.friends}) {
            writer.put(seeds->ids);
            writer.put(seeds->points);
            writer.put(seeds->weights);
        }
        return writer.take();
    }

    void add_stats(const Stats& some) {
        Stats& stats = result_.stats;
        stats.faces += some.faces;
        stats.duplicates += some.duplicates;
        stats.empty_cells += some.empty_cells;
        stats.exact_cells += some.exact_cells;
        stats.threads = some.threads;
    }

    // A block is asked only with those of its seeds that may cut a cell which asks.
    void answer() {
        stages_.begin(&StageSeconds::fallback, 0.76, "asking other blocks");
        for (std::size_t b = 0; b < count_; ++b) {
            give_back_memory();
            stages_.at(b, count_);
            if (blocks_[b].questions.size() == 0) continue;
            std::vector<std::pair<std::size_t, Questions>> asked;
            for_messages(blocks_[b].questions, [&](std::size_t from, const Message& message) {
                from_message(message, asked.emplace_back(from, Questions{}).second);
            });
            blocks::Run run;
            run.seeds = seeds_near(b, asked);
            run.prepare(*settled_);
            blocks::Responder responder(*settled_, run);
            for (const auto& [from, questions] : asked)
                put(blocks_[from].answers, b, to_message(responder.answer(questions)));
        }
    }

    [[nodiscard]] Seeds seeds_near(std::size_t b, const std::vector<std::pair<std::size_t, Questions>>& asked) {
        const Seeds all = seeds_of(b);
        const blocks::TiledSeeds tiled = tiles_of(b);
        const Job job = validate({}, *settled_);
        const blocks::Nearness nearness(*job.domain);
        std::vector<bool> near(tiled.outline.tiles.size());
        for (const auto& [from, questions] : asked) blocks::mark_near(tiled.outline, nearness, questions, near);
        std::vector<bool> taken(all.size());
        for (std::size_t t = 0; t < near.size(); ++t)
            for (std::size_t k = tiled.begin[t]; k < tiled.begin[t + 1] && near[t]; ++k) taken[tiled.order[k]] = true;
        Seeds seeds;
        for (std::size_t i = 0; i < all.size(); ++i)
            if (taken[i]) seeds.add(all, i);
        return seeds;
    }

    void finish_asked() {
        for (Block& block : blocks_) {
            for_messages(block.asked, [&](std::size_t, const Message& message) {
                blocks::Asked asked;
                Reader reader(message);
                for (Seeds* seeds : {&asked.cells, &asked.friends}) {
                    reader.get(seeds->ids);
                    reader.get(seeds->points);
                    reader.get(seeds->weights);
                }
                Seeds answers;
                for_messages(block.answers, [&](std::size_t, const Message& some) {
                    Seeds seeds;
                    from_message(some, seeds);
                    answers.add(seeds);
                });
                blocks::Run run;
                blocks::finish_asked(*settled_, asked, answers, run);
                block.late.ids().append(std::span<const std::int64_t>(asked.cells.ids));
                block.late.add(run, asked.cells.size(), {});
                Stats some = run.result.stats;
                some.exact_cells = 0;  // counted before they asked
                add_stats(some);
            });
        }
        result_.temporary_bytes = ids_->size() + seeds_->size() + rows_->size() + intake_.bytes();
        if (!stream_.verify) {
            dealt_.reset();
            seeds_.reset();
        }
        give_back_memory();
    }

    void hand_out() {
        stages_.begin(&StageSeconds::download, stream_.verify ? 0.95 : 1, "writing rows");
        StreamHead head;
        head.seeds = intake_.seeds();
        head.periodic = domain_is_periodic();
        head.options = *settled_;
        std::vector<RowStore*> stores;
        for (Block& block : blocks_) stores.push_back(&block.settled);
        for (Block& block : blocks_) stores.push_back(&block.late);
        for (const RowStore* store : stores) {
            head.entries += store->entries();
            head.duplicates |= store->has_duplicates();
        }
        // What is at hand at once: the arrays as they are read and in order, ids also in 64 bits.
        double bytes = 2 * static_cast<double>(layout_->bytes_of_cell()) + 24;
        if (head.seeds > 0)
            bytes += (2 * static_cast<double>(layout_->bytes_of_entry()) + 8) * static_cast<double>(head.entries) /
                     static_cast<double>(head.seeds);
        const auto most = static_cast<std::size_t>(std::max(1000.0, 0.4 * static_cast<double>(stream_.memory) / bytes));
        ThreadPool pool(options_.threads);
        Assembler assembler(*layout_, head, std::move(stores), count_, pool);
        sink_.begin(head);
        if (stream_.verify)
            checker_.emplace(CheckedRun{domain_->options(), head.seeds, result_.stats.box_volume}, sample(), *this);
        Stats& stats = result_.stats;
        do {
            const StreamRows rows = assembler.next(most);
            if (checker_) checker_->take(rows);
            sink_.rows(rows);
            for (const double volume : rows.volumes) stats.volume_sum += volume;
            stats.empty_cells += static_cast<std::uint64_t>(std::ranges::count(rows.status, CellStatus::outside));
            stages_.at(assembler.first(), head.seeds);
        } while (assembler.first() < head.seeds);
        stats.points = head.seeds;
        stats.device = "cpu";
        const std::uint64_t cells = stats.points - stats.empty_cells;
        stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
        stats.peak_memory_bytes = peak_memory();
    }

    // Blocks are read for each round of the sample, so there is one: as many cells as the usual budget pays for, and no
    // more than fit a tenth of the memory with what the blocks reply.
    [[nodiscard]] RowChecker::Sample sample() const {
        constexpr double bytes_of_reply = 2000, share = 0.1;
        const double room =
            share * static_cast<double>(stream_.memory) / (bytes_of_reply * static_cast<double>(count_ + 1));
        const std::size_t cells = sample_size(intake_.seeds(), count_, domain_is_periodic());
        RowChecker::Sample sample;
        sample.most = sample.at_once = std::max(least_sample, std::min(cells, static_cast<std::size_t>(room)));
        return sample;
    }

    void verify() {
        if (!checker_) return;
        stages_.begin(&StageSeconds::download, 1, "checking the cells");
        result_.verified = checker_->report();
    }

    // Is called twice, to find the seeds of the sample and to clip their cells.
    void for_blocks(const std::function<void(Seeds)>& task) override {
        for (std::size_t b = 0; b < count_; ++b) {
            stages_.at(blocks_checked_++, 2 * count_);
            give_back_memory();
            const Seeds all = seeds_of(b);
            Spool& spool = blocks_[b].settled.of(Array::status);
            spool.rewind();
            const auto status = spool.read_rest<CellStatus>();
            Seeds seeds;
            for (std::size_t i = 0; i < all.size(); ++i)
                if (takes_part(status[i])) seeds.add(all, i);
            task(std::move(seeds));
        }
    }

    StreamSink& sink_;
    const Options& options_;
    const StreamOptions& stream_;
    Stages stages_;
    Intake intake_;
    std::optional<BlockDomain> domain_;
    std::optional<Options> settled_;
    std::size_t count_ = 1;
    std::optional<Layout> layout_;
    std::optional<TemporaryFile> ids_, seeds_, rows_;
    std::optional<Intake::Dealt> dealt_;
    std::vector<Block> blocks_;
    std::vector<blocks::Outline> outlines_;  // to those that were given no layer
    std::optional<RowChecker> checker_;
    std::uint64_t blocks_checked_ = 0;
    StreamResult result_;
};

}  // namespace

StreamSource::~StreamSource() = default;
StreamSink::~StreamSink() = default;
void StreamSink::begin(const StreamHead&) {}

StreamResult tessellate_stream(StreamSource& source, StreamSink& sink, const Options& options,
                               const StreamOptions& stream) {
    if (stream.memory < StreamOptions::least_memory)
        throw Error(ErrorCode::invalid_argument, "memory = " + std::to_string(stream.memory) +
                                                     " bytes is too little: give at least " +
                                                     std::to_string(StreamOptions::least_memory));
    if (!options.weights.empty() || !options.radii.empty())
        throw Error(
            ErrorCode::invalid_argument,
            "weights and radii of a stream come from its source with the points: leave them out of the options");
    (void)free_bytes(temporary_folder(stream.temporary));  // is it there?
    try {
        return Run(source, sink, options, stream)();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "out of memory: give tessellate_stream() less of it, for smaller blocks");
    }
}

}  // namespace votess

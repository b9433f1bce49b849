// Joins the cells of all blocks in input order, some at a time.
#pragma once

#include <vector>

#include "core/thread_pool.hpp"
#include "distributed/stream/row_store.hpp"

namespace votess::stream {

class Assembler {
public:
    // groups: of stores; each group has cells that those before it skipped. only: the ids of the cells, ascending, if
    // these are not 0, 1, ...
    Assembler(const Layout& layout, const StreamHead& head, const std::vector<std::vector<RowStore*>>& groups,
              ThreadPool& pool, std::span<const std::int64_t> only = {});

    // Returns the cells from first() on, at most max_cells. They are valid until the next call.
    [[nodiscard]] StreamRows next(std::size_t max_cells);
    [[nodiscard]] std::uint64_t first() const { return first_; }

private:
    struct Part {  // of a store
        RowStore* store;
        Cursor<std::int64_t> ids;
        Cursor<RowStore::Duplicate> duplicates;
        std::vector<std::uint32_t> places, lengths;  // of its cells in this call, relative to first()
    };
    template <class Task>
    void for_parts(const Task& task);
    [[nodiscard]] std::uint64_t place(std::int64_t id) const {
        return only_.empty() ? static_cast<std::uint64_t>(id) : place_of(id, only_);
    }
    void find(Part& part, std::uint64_t end);
    void take_cells(Part& part, std::size_t array);
    void take_entries(Part& part, std::size_t array);
    template <class T>
    [[nodiscard]] std::span<const T> as(std::size_t array) const;

    const Layout& layout_;
    const StreamHead& head_;
    std::vector<std::vector<Part>> groups_;
    ThreadPool& pool_;
    std::span<const std::int64_t> only_;
    std::uint64_t first_ = 0;
    std::int64_t entries_ = 0;  // of the rows before first()
    std::array<std::vector<std::byte>, detail::row_array_count> arrays_;
    std::vector<std::int64_t> indptr_, indices_, duplicate_of_;
};

}  // namespace votess::stream

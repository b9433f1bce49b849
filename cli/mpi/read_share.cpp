// Each rank reads its rows of .npy and .h5 files. Other files can only be read from the start: rank 0 reads them and
// distributes the rows.
#include "mpi/read_share.hpp"

#include <algorithm>
#include <bit>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "files/numbers.hpp"

namespace clvotess {
namespace {

// Bytes between ranks. Each function that lists values packs them on rank 0, and takes them out again, in that order,
// on the others.
class Pack {
public:
    Pack() = default;  // packs
    explicit Pack(std::vector<char> packed) : bytes_(std::move(packed)), takes_(true) {}

    template <class T>
    void operator()(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        copy(&value, sizeof value);
    }
    template <class T>
    void operator()(std::vector<T>& values) {
        resize(values);
        copy(values.data(), values.size() * sizeof(T));
    }
    void operator()(std::string& text) {
        resize(text);
        copy(text.data(), text.size());
    }
    template <class T>
    void operator()(std::optional<T>& value) {
        bool has_value = value.has_value();
        (*this)(has_value);
        if (has_value) (*this)(takes_ ? value.emplace() : *value);
    }
    void operator()(std::variant<double, std::string>& value) {
        bool is_text = value.index() == 1;
        (*this)(is_text);
        if (takes_ && is_text) value = std::string();
        std::visit(*this, value);
    }
    // Calls use() for each of the values.
    template <class T, class Use>
    void each(std::vector<T>& values, const Use& use) {
        resize(values);
        for (T& value : values) use(value);
    }
    std::vector<char> take() { return std::move(bytes_); }

private:
    template <class Values>
    void resize(Values& values) {
        std::uint64_t count = values.size();
        (*this)(count);
        values.resize(count);
    }
    void copy(void* values, std::size_t count) {
        auto* const bytes = static_cast<char*>(values);
        if (takes_)
            std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), count, bytes);
        else
            bytes_.insert(bytes_.end(), bytes, bytes + count);
        at_ += count;
    }
    std::vector<char> bytes_;
    std::size_t at_ = 0;
    bool takes_ = false;
};

// Lists the properties of the whole file. rows: their number.
void list_whole(Pack& pack, Input& input, std::uint64_t& rows) {
    FileDomain& domain = input.domain;
    pack(domain.box);
    pack(domain.periodic);
    pack(domain.periodic_from);
    pack(domain.cell);
    pack(domain.walls);
    pack.each(input.units, [&](Attribute& unit) {
        pack(unit.name);
        pack(unit.value);
    });
    pack(input.note);
    pack.each(input.columns, [&](InputColumn& column) {
        pack(column.name);
        pack(column.width);
    });
    pack(rows);
    pack(input.dimensions);
}

void list_rows(Pack& pack, Input& rows) {
    pack(rows.points);
    pack(rows.ids);
    for (InputColumn& column : rows.columns) pack(column.values);
}

std::vector<char> pack_rows(const Input& input, const Share& share) {
    const std::size_t begin = share.begin(input.size()), count = share.end(input.size()) - begin;
    const auto part = [&]<class T>(const std::vector<T>& all, std::size_t each) {
        const auto first = all.begin() + static_cast<std::ptrdiff_t>(all.empty() ? 0 : each * begin);
        return std::vector<T>(first, first + static_cast<std::ptrdiff_t>(all.empty() ? 0 : each * count));
    };
    Input rows;
    rows.points = part(input.points, input.dimensions);
    rows.ids = part(input.ids, 1);
    for (const InputColumn& column : input.columns)
        rows.columns.push_back({.name = {}, .values = part(column.values, column.width)});
    Pack pack;
    list_rows(pack, rows);
    return pack.take();
}

InputShare deal(const Ranks& ranks, const Arguments& arguments) {
    Input all;
    std::vector<char> whole;
    std::vector<std::vector<char>> rows;
    const auto parts = static_cast<std::uint64_t>(ranks.size());
    ranks.first_alone([&] {
        ReadRequest request = arguments.read;
        if (!arguments.threads_given) request.threads = 1;
        all = read_input(arguments.input, request);
        refuse_large_integers(all.columns, "clvotess-mpi");
        std::uint64_t count = all.size();
        Pack pack;
        list_whole(pack, all, count);
        whole = pack.take();
        for (std::uint64_t r = 0; r < parts; ++r) rows.push_back(pack_rows(all, {r, parts}));
        all = {};
    });
    ranks.broadcast(whole);
    std::vector<char> own = ranks.deal(std::move(rows));
    InputShare share;
    ranks.together([&] {
        Pack of_file(std::move(whole)), of_rows(std::move(own));
        list_whole(of_file, share.input, share.rows);
        list_rows(of_rows, share.input);
    });
    return share;
}

// Each rank has dropped the z of its own points.
void check_one_z(const Ranks& ranks, const std::string& path, const Input& input) {
    const std::vector<std::uint64_t> sizes = ranks.gather(input.size());
    const std::vector<std::uint64_t> all = ranks.gather(std::bit_cast<std::uint64_t>(input.dropped_z));
    std::optional<double> first;
    for (std::size_t r = 0; r < all.size(); ++r) {
        if (sizes[r] == 0) continue;
        const double z = std::bit_cast<double>(all[r]);
        if (!first) first = z;
        ranks.together([&] {
            if (z != *first)
                throw bad_input(path + ": a point has z = " + to_text(z) + ", another has " + to_text(*first) +
                                ": points of the plane have one z; choose others, or name two --columns of a table");
        });
    }
}

}  // namespace

InputShare read_share(const Ranks& ranks, const Arguments& arguments) {
    const Share own{static_cast<std::uint64_t>(ranks.rank()), static_cast<std::uint64_t>(ranks.size())};
    InputShare share;
    if (!arguments.random_count && !reads_shares(arguments.input, arguments.read)) {
        share = deal(ranks, arguments);
    } else {
        ranks.together([&] {
            ReadRequest request = arguments.read;
            request.share = own;
            share.input = arguments.random_count ? random_points(*arguments.random_count, arguments.rng_seed, request)
                                                 : read_input(arguments.input, request);
            refuse_large_integers(share.input.columns, "clvotess-mpi");
        });
        share.rows = ranks.sum(std::uint64_t{share.input.size()});
        check_one_z(ranks, arguments.input, share.input);
    }
    share.first = ranks.sum_before(std::uint64_t{share.input.size()});
    share.has_ids = ranks.any(!share.input.ids.empty());
    ranks.together([&] {
        if (share.has_ids && share.input.ids.size() != share.input.size())
            throw bad_input(arguments.input + ": some of its files have ids, others have not");
    });
    return share;
}

}  // namespace clvotess

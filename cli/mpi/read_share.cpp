// Each rank reads its rows of .npy and .h5 files. Other files can only be read from the start: rank 0 reads them and
// distributes the rows.
#include "mpi/read_share.hpp"

#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>

#include "files/numbers.hpp"

namespace clvotess {
namespace {

// Packs what rank 0 has read.
class Packer {
public:
    template <class T>
    void put(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        const std::uint64_t count = values.size();
        append(&count, sizeof count);
        append(values.data(), values.size_bytes());
    }
    void put(const std::string& text) { put(std::span<const char>(text)); }
    template <class T>
    void put_one(const T& value) {
        put(std::span<const T>(&value, 1));
    }
    std::vector<char> take() { return std::move(bytes_); }

private:
    void append(const void* from, std::size_t count) {
        if (count > 0)
            bytes_.insert(bytes_.end(), static_cast<const char*>(from), static_cast<const char*>(from) + count);
    }
    std::vector<char> bytes_;
};

class Unpacker {
public:
    explicit Unpacker(const std::vector<char>& bytes) : bytes_(bytes) {}

    template <class T>
    std::vector<T> take() {
        std::uint64_t count = 0;
        std::memcpy(&count, bytes_.data() + at_, sizeof count);
        std::vector<T> values(count);
        if (count > 0) std::memcpy(values.data(), bytes_.data() + at_ + sizeof count, count * sizeof(T));
        at_ += sizeof count + count * sizeof(T);
        return values;
    }
    std::string take_text() {
        const std::vector<char> text = take<char>();
        return {text.begin(), text.end()};
    }
    template <class T>
    T take_one() {
        return take<T>()[0];
    }

private:
    const std::vector<char>& bytes_;
    std::size_t at_ = 0;
};

// Packs the properties of the whole file.
std::vector<char> pack_whole(const Input& input) {
    Packer pack;
    const FileDomain& domain = input.domain;
    pack.put(std::span<const votess::Box>(domain.box ? &*domain.box : nullptr, domain.box ? 1 : 0));
    pack.put_one(domain.periodic);
    pack.put_one(domain.periodic_from);
    pack.put(std::span<const votess::TriclinicBox>(domain.cell ? &*domain.cell : nullptr, domain.cell ? 1 : 0));
    pack.put(std::span<const votess::Wall>(domain.walls));
    pack.put_one(std::uint64_t{input.units.size()});
    for (const auto& [name, value] : input.units) {
        const auto* const text = std::get_if<std::string>(&value);
        pack.put(name);
        pack.put_one(static_cast<char>(text != nullptr));
        if (text != nullptr)
            pack.put(*text);
        else
            pack.put_one(std::get<double>(value));
    }
    pack.put(input.note);
    pack.put_one(std::uint64_t{input.columns.size()});
    for (const InputColumn& column : input.columns) {
        pack.put(column.name);
        pack.put_one(std::uint64_t{column.width});
    }
    pack.put_one(std::uint64_t{input.size()});
    pack.put_one(std::uint64_t{input.dimensions});
    return pack.take();
}

// Returns the number of rows of the file.
std::uint64_t unpack_whole(const std::vector<char>& bytes, Input& input) {
    Unpacker unpack(bytes);
    FileDomain& domain = input.domain;
    if (const auto box = unpack.take<votess::Box>(); !box.empty()) domain.box = box[0];
    domain.periodic = unpack.take_one<std::array<bool, 3>>();
    domain.periodic_from = unpack.take_one<DomainSource>();
    if (const auto cell = unpack.take<votess::TriclinicBox>(); !cell.empty()) domain.cell = cell[0];
    domain.walls = unpack.take<votess::Wall>();
    for (auto left = unpack.take_one<std::uint64_t>(); left > 0; --left) {
        Attribute& unit = input.units.emplace_back();
        unit.name = unpack.take_text();
        if (unpack.take_one<char>() != 0)
            unit.value = unpack.take_text();
        else
            unit.value = unpack.take_one<double>();
    }
    input.note = unpack.take_text();
    for (auto left = unpack.take_one<std::uint64_t>(); left > 0; --left) {
        InputColumn& column = input.columns.emplace_back();
        column.name = unpack.take_text();
        column.width = unpack.take_one<std::uint64_t>();
    }
    const auto rows = unpack.take_one<std::uint64_t>();
    input.dimensions = unpack.take_one<std::uint64_t>();
    return rows;
}

template <class T>
std::span<const T> part(const std::vector<T>& all, std::size_t begin, std::size_t end, std::size_t each) {
    return all.empty() ? std::span<const T>() : std::span(all).subspan(each * begin, each * (end - begin));
}

std::vector<char> pack_rows(const Input& input, const Share& share) {
    const std::size_t begin = share.begin(input.size()), end = share.end(input.size());
    Packer pack;
    pack.put(part(input.points, begin, end, input.dimensions));
    pack.put(part(input.ids, begin, end, 1));
    for (const InputColumn& column : input.columns) pack.put(part(column.values, begin, end, column.width));
    return pack.take();
}

void unpack_rows(const std::vector<char>& bytes, Input& input) {
    Unpacker unpack(bytes);
    input.points = unpack.take<double>();
    input.ids = unpack.take<std::int64_t>();
    for (InputColumn& column : input.columns) column.values = unpack.take<double>();
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
        whole = pack_whole(all);
        for (std::uint64_t r = 0; r < parts; ++r) rows.push_back(pack_rows(all, {r, parts}));
        all = {};
    });
    ranks.broadcast(whole);
    const std::vector<char> own = ranks.deal(std::move(rows));
    InputShare share;
    ranks.together([&] {
        share.rows = unpack_whole(whole, share.input);
        unpack_rows(own, share.input);
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

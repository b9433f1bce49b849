// Packed arrays: every value comes back, in as few bytes as promised, and damaged ones are refused.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "core/bytes.hpp"
#include "core/disk_space.hpp"
#include "distributed/stream/spool.hpp"
#include "support/random.hpp"

namespace {

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

// Returns the bytes that the values take, without their head.
template <class T>
std::size_t packed_size(const std::vector<T>& values) {
    votess::Writer writer;
    writer.pack(values);
    const votess::Message message = writer.take();
    votess::Reader reader(message);
    std::vector<T> back;
    reader.unpack(back, values.size());
    reader.end();
    CHECK(same(back, values));
    return message.size() - sizeof(votess::PackedHead);
}

// Integers in a random range of random width, in any order or ascending.
template <class T>
std::vector<T> integers(std::size_t count, bool ascending, test::Random& random) {
    const std::uint64_t mask = ~std::uint64_t{0} >> random.below(64);
    const std::uint64_t from = random.next();
    std::vector<T> values(count);
    for (T& value : values) value = static_cast<T>(from + (random.next() & mask));
    if (ascending) std::ranges::sort(values);
    return values;
}

template <class T>
void check_integers(test::Random& random) {
    for (int k = 0; k < 100; ++k) {
        const std::vector<T> values = integers<T>(random.below(300), k % 2 == 0, random);
        CHECK(packed_size(values) <= values.size() * sizeof(T));
    }
    using Limits = std::numeric_limits<T>;
    CHECK(packed_size(std::vector<T>{Limits::min(), Limits::max(), 0}) == 3 * sizeof(T));
    CHECK(packed_size(std::vector<T>{Limits::min(), Limits::max()}) <= 2 * sizeof(T));
    CHECK(packed_size(std::vector<T>(1000, Limits::max())) == 0);
    CHECK(packed_size(std::vector<T>{}) == 0);
}

}  // namespace

TEST_CASE("packed: integers come back, in the fewest bytes") {
    test::Random random(1);
    check_integers<std::uint8_t>(random);
    check_integers<std::int8_t>(random);
    check_integers<std::int32_t>(random);
    check_integers<std::uint32_t>(random);
    check_integers<std::int64_t>(random);
    check_integers<std::uint64_t>(random);
    std::vector<std::int64_t> ids;
    for (std::int64_t id = 5'000'000'000; ids.size() < 1000; id += 1 + static_cast<std::int64_t>(random.below(100)))
        ids.push_back(id);
    CHECK(packed_size(ids) == 1000);
    for (std::int64_t& id : ids) id = 5'000'000'000 + static_cast<std::int64_t>(random.below(60000));
    CHECK(packed_size(ids) == 2000);
    CHECK(packed_size(std::vector(50, votess::CellStatus::certified)) == 0);
}

TEST_CASE("packed: float64 takes the room of float32 where that holds it") {
    test::Random random(2);
    std::vector<double> values(999);
    for (double& value : values) value = static_cast<float>(random.uniform(-1, 1));
    values[7] = -0.0, values[8] = std::numeric_limits<double>::infinity(), values[9] = 0x1p-149;
    CHECK(packed_size(values) == 4 * values.size());
    for (const double other : {0.1, 1e300, 0x1p-150, 1 + 0x1p-24}) {
        values[10] = other;
        CHECK(packed_size(values) == 8 * values.size());
    }
}

TEST_CASE("packed: files are read in steps of any length") {
    test::Random random(3);
    votess::stream::DiskUse use;
    votess::stream::TemporaryFile file("", use);
    votess::stream::Spool ids(file), points(file), statuses(file);
    std::vector<std::int64_t> all_ids;
    std::vector<double> all_points;
    std::vector<votess::CellStatus> all_statuses;
    for (int piece = 0; piece < 30; ++piece) {
        const std::size_t count = piece == 3 ? 70'000 : random.below(500);
        std::vector<double> some(3 * count);
        for (double& x : some) x = piece % 2 == 0 ? static_cast<float>(random.uniform()) : random.uniform();
        auto some_ids = integers<std::int64_t>(count, piece % 3 != 0, random);
        const std::vector some_statuses(count, static_cast<votess::CellStatus>(piece % 3));
        ids.append(std::span<const std::int64_t>(some_ids));
        points.append(std::span<const double>(some));
        statuses.append(std::span<const votess::CellStatus>(some_statuses));
        all_ids.insert(all_ids.end(), some_ids.begin(), some_ids.end());
        all_points.insert(all_points.end(), some.begin(), some.end());
        all_statuses.insert(all_statuses.end(), some_statuses.begin(), some_statuses.end());
    }
    CHECK(ids.size() == all_ids.size());
    CHECK(use.peak() < 30 * all_ids.size());
    const auto check = [&](votess::stream::Spool spool, const auto& all) {
        for (const std::size_t most : {50, 3000, 1'000'000}) {
            spool.rewind();
            std::remove_cvref_t<decltype(all)> back(all.size());
            for (std::size_t at = 0; at < all.size();) {
                const std::size_t count = std::min<std::size_t>(all.size() - at, random.below(most));
                spool.read(std::span(back).subspan(at, count));
                at += count;
                CHECK(spool.remaining() == all.size() - at);
            }
            CHECK(same(back, all));
        }
    };
    check(ids, all_ids);
    check(points, all_points);
    check(statuses, all_statuses);
}

TEST_CASE("packed: what has been read leaves the disk, and nothing else does") {
    using votess::stream::Spool;
    test::Random random(5);
    votess::stream::DiskUse use;
    {
        votess::stream::TemporaryFile file("", use);
        std::vector<Spool> spools(3, Spool(file));
        std::vector<std::vector<double>> all(spools.size());
        for (int piece = 0; piece < 60; ++piece)
            for (std::size_t s = 0; s < spools.size(); ++s) {
                std::vector<double> some(random.below(s == 2 ? 20 : 60'000));
                for (double& x : some) x = random.uniform();
                spools[s].append(std::span<const double>(some));
                all[s].insert(all[s].end(), some.begin(), some.end());
            }
        const auto read = [&](std::size_t s) {
            std::vector<double> back(all[s].size());
            for (std::size_t at = 0; at < back.size();) {
                const std::size_t count = std::min<std::size_t>(back.size() - at, random.below(100'000));
                spools[s].read(std::span(back).subspan(at, count));
                at += count;
            }
            CHECK(same(back, all[s]));
        };
        const std::uint64_t whole = use.now();
        CHECK(whole > 8 * (all[0].size() + all[1].size()));
        spools[0].release_as_read();
        read(0);
        const std::uint64_t half = use.now();
        for (const std::size_t s : {1, 2}) read(s), spools[s].rewind();
        CHECK(use.now() == half);
        spools[1].release_as_read();
        read(1);
        read(2);
        CHECK(use.peak() == whole);
        // Each end of a piece may leave a page.
        const auto file_of_one = votess::system::File::temporary(votess::system::temporary_folder());
        if (votess::system::release_disk_space(file_of_one, 0, 4096)) {
            CHECK(half < 0.7 * static_cast<double>(whole));
            CHECK(use.now() < 0.3 * static_cast<double>(whole));
        }
    }
    CHECK(use.now() == 0);
}

// Bytes are not changed on the way, but other versions may send others.
TEST_CASE("packed: damaged messages are refused or give other values, and ask for no more memory than they have") {
    test::Random random(4);
    std::size_t refused = 0;
    for (int k = 0; k < 3000; ++k) {
        votess::Writer writer;
        const std::size_t count = 1 + random.below(20);
        writer.pack(integers<std::int64_t>(count, k % 2 == 0, random));
        votess::Message message = writer.take();
        for (std::size_t times = 1 + random.below(3); times > 0; --times)
            message[random.below(message.size())] = static_cast<std::byte>(random.next());
        if (random.chance(0.2)) message.resize(random.below(message.size()));
        votess::Reader reader(message);
        std::vector<std::int64_t> back;
        try {
            reader.unpack(back, count);
            CHECK(back.size() <= count);
        } catch (const votess::Error& error) {
            CHECK(error.code() == votess::ErrorCode::invalid_argument);
            ++refused;
        }
    }
    CHECK(refused > 1000);
}

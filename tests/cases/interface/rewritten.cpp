// Another thread writes into the arrays of a call. The cells may then be anyone's, but the call ends, and what it
// returns is whole. This is a data race by construction: builds with the thread sanitizer leave this file out.
#include <doctest/doctest.h>

#include <atomic>
#include <limits>
#include <span>
#include <string>
#include <thread>
#include <vector>
#include <votess/diagram.hpp>
#include <votess/stream.hpp>

#include "support/check.hpp"
#include "support/random.hpp"
#include "support/solids.hpp"

namespace {

// Writes into an array until it is destroyed, and then brings its numbers back.
template <class Real>
class Rewriter {
public:
    explicit Rewriter(std::vector<Real>& values, double range = 1)
        : values_(values), before_(values), thread_([this, range] { write(range); }) {}
    ~Rewriter() {
        stop_ = true;
        thread_.join();
        values_ = before_;
    }
    Rewriter(const Rewriter&) = delete;
    Rewriter& operator=(const Rewriter&) = delete;

private:
    void put(std::size_t i, Real value) { std::atomic_ref<Real>(values_[i]).store(value, std::memory_order_relaxed); }
    // Bad numbers stay for a moment only, so that most runs are not refused at once.
    void write(double range) {
        constexpr Real infinity = std::numeric_limits<Real>::infinity(), largest = std::numeric_limits<Real>::max();
        const Real bad[] = {std::numeric_limits<Real>::quiet_NaN(),
                            infinity,
                            -infinity,
                            largest,
                            -largest,
                            std::numeric_limits<Real>::denorm_min(),
                            static_cast<Real>(-3 * range)};
        test::Random random(7);
        for (std::size_t round = 0; !stop_; ++round) {
            for (int k = 0; k < 2000; ++k)
                put(random.below(values_.size()),
                    static_cast<Real>(random.uniform(0, round % 2 == 0 ? range : 0.1 * range)));
            // A crowd where there was none.
            for (std::size_t i = 0, at = random.below(values_.size()); i < values_.size() / 4; ++i)
                put((at + i) % values_.size(), static_cast<Real>(0.25 * range));
            std::this_thread::yield();
            if (round % 8 != 0) continue;
            const std::size_t i = random.below(values_.size());
            for (const Real value : bad) put(i, value);
            put(i, before_[i]);
        }
    }

    std::vector<Real>& values_;
    std::vector<Real> before_;
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

// "": the call returned so many whole cells, or refused its input.
template <class Call>
std::string outcome(std::size_t cells, const Call& call) {
    try {
        const votess::Tessellation t = call();
        if (t.size() != cells) return "other cells";
        if (!t.indptr().empty() && static_cast<std::size_t>(t.indptr().back()) != t.indices().size()) return "no rows";
        for (const std::int32_t id : t.indices())
            if (id >= static_cast<std::int32_t>(cells)) return "a neighbor that does not exist";
        return "";
    } catch (const votess::Error& error) {
        return error.code() == votess::ErrorCode::invalid_argument || error.code() == votess::ErrorCode::unsupported
                   ? ""
                   : error.what();
    }
}

struct Domain {
    std::string name;
    votess::Options options;
};

std::vector<Domain> domains() {
    votess::Options box;
    box.box = test::unit_box();
    box.device = "cpu";
    box.threads = 2;
    box.want.areas = box.want.normals = box.want.counts = true;
    std::vector<Domain> all{{"box", box}};
    all.push_back({"seeds dropped, places", box});
    all.back().options.outside = votess::Outside::drop;
    all.back().options.want.faces = true;
    all.push_back({"periodic", box});
    all.back().options.periodic = {true, true, false};
    all.back().options.outside = votess::Outside::drop;
    all.push_back({"walls", box});
    all.back().options.walls = test::octahedron(0.6);
    all.back().options.outside = votess::Outside::drop;
    all.push_back({"no box", box});
    all.back().options.box.reset();
    all.push_back({"triclinic", box});
    all.back().options.box.reset();
    all.back().options.cell =
        votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.2, 1}, {true, true, true}};
    all.push_back({"skewed, walls", all.back().options});
    all.back().options.cell->c = {7.3, 5.2, 1};
    all.back().options.cell->periodic = {true, false, true};
    all.back().options.outside = votess::Outside::drop;
    static const test::Solid octant = test::cuboid(0.5, 1.25);
    all.push_back({"mesh", box});
    all.back().options.want.counts = false;
    all.back().options.box = test::cube(-1, 2);
    all.back().options.mesh = octant.mesh();
    return all;
}

struct Source final : votess::StreamSource {
    explicit Source(std::span<const double> all) : points(all) {}
    bool restart() override {
        at = 0;
        return true;
    }
    bool next(votess::StreamSeeds& seeds) override {
        if (at == points.size()) return false;
        const std::size_t size = std::min<std::size_t>(points.size() - at, 3000);
        seeds.points = points.subspan(at, size);
        at += size;
        return true;
    }
    std::span<const double> points;
    std::size_t at = 0;
};
struct Sink final : votess::StreamSink {
    void begin(const votess::StreamHead&) override {}
    void rows(const votess::StreamRows&) override {}
};

}  // namespace

TEST_SUITE("interface") {
    TEST_CASE("points that another thread rewrites are no danger") {
        for (const Domain& domain : domains()) {
            CAPTURE(domain.name);
            const std::size_t n = domain.name == "box" ? test::by_size(9000, 5000) : test::by_size(2500, 600);
            std::vector<double> points = test::clustered(n, 91).points, weights(n, 0.01);
            if (domain.name == "box")  // nearly all of them in one bucket of the sort
                for (std::size_t i = 30; i < points.size(); ++i) points[i] = 0.2 + 0.02 * points[i];
            std::vector<float> narrow(points.begin(), points.end());
            const auto before = votess::tessellate(points, domain.options);
            votess::Tessellator tessellator;
            {
                const Rewriter rewriter(points);
                const Rewriter rewriter_of_weights(weights, 0.01);
                const Rewriter rewriter_of_floats(narrow);
                votess::Options options = domain.options;
                for (int again = domain.name == "box" && !test::reduced() ? 0 : 2; again < 3; ++again)
                    CHECK(outcome(n, [&] { return tessellator.tessellate(points, options); }) == "");
                CHECK(outcome(n, [&] { return tessellator.tessellate(narrow, options); }) == "");
                options.weights = weights;
                CHECK(outcome(n, [&] { return tessellator.tessellate(points, options); }) == "");
            }
            CHECK(test::check_identical(before, tessellator.tessellate(points, domain.options)) == "");
        }
    }

    TEST_CASE("queries and streamed seeds that another thread rewrites are no danger") {
        const std::size_t n = test::by_size(1500, 1000);
        std::vector<double> points = test::clustered(n, 92).points, queries = test::uniform(n, 93).points;
        votess::Options options;
        options.box = test::unit_box();
        options.threads = 2;
        const Rewriter rewriter(points);
        const Rewriter rewriter_of_queries(queries);
        const auto refused = [](const auto& call) {
            try {
                call();
            } catch (const votess::Error& error) {
                return error.code() != votess::ErrorCode::internal;
            }
            return true;
        };
        CHECK(refused([&] {
            const votess::Diagram diagram(points, options);
            for (const std::int32_t seed : diagram.locate(queries)) CHECK(seed < static_cast<std::int32_t>(n));
            (void)diagram.probe(queries);
            (void)diagram.natural_neighbors(queries);
        }));
        CHECK(refused([&] {
            Source source(points);
            Sink sink;
            (void)votess::tessellate_stream(source, sink, options,
                                            {.memory = votess::StreamOptions::least_memory, .temporary = ""});
        }));
    }
}

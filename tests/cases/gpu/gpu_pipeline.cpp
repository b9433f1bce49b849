// A Vulkan device has the CPU's answer: every family, every option, every division of the work into pieces.
#include <doctest/doctest.h>

#include <cmath>

#include "support/gpu/gpu.hpp"
#include "support/random.hpp"

namespace {

using test::PointSet;
using votess::Options;
using votess::Tessellation;

std::string compare(votess::Tessellator& tessellator, const PointSet& set, Options options = test::all_options()) {
    options.device = test::device_name();
    options.box = set.box;
    const Tessellation gpu = tessellator.tessellate(set.points, options);
    options.device = "cpu";
    return test::check_same(gpu, votess::tessellate(set.points, options), set.points, test::tolerance(options));
}

// Inputs with certain cells, ties, overflows, lost digits, duplicates.
std::vector<PointSet> samples(std::size_t n) {
    return {test::uniform(n, 61),
            test::clustered(n, 62),
            test::nested_clusters(n, 63),
            test::near_duplicates(n, 64),
            test::far_from_origin(n, 65),
            test::on_walls(n, 66),
            test::with_duplicates(n, n / 10, 67),
            test::fcc(test::by_size(8, 5)),
            test::jittered(test::by_size(8, 5), 0.01, 68),
            test::on_sphere_and_center(n, 69),
            test::on_oblique_line(n, 70)};
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu: every family equals the CPU") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        struct Variant {
            votess::gpu::Kernel kernel;
            std::size_t n;
        };
        for (const auto& [kernel, n] : {Variant{votess::gpu::Kernel::invocation, test::by_size(200, 60)},
                                        {votess::gpu::Kernel::invocation, test::by_size(600, 100)},
                                        {test::by_subgroup(), test::by_size(200, 60)}})
            for (const PointSet& set : test::families(n, n + 1)) {
                CAPTURE(static_cast<int>(kernel));
                CAPTURE(set.name);
                CAPTURE(n);
                const test::UseKernel chosen(kernel);
                CHECK(compare(tessellator, set) == "");
            }
    }

    TEST_CASE("gpu: many uniform seeds, hardly any of them left to the CPU") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        const PointSet set = test::uniform(test::by_size(10000, 1500), 71);
        Options options = test::all_options(set.box);
        options.threads = 0;
        options.device = "cpu";
        const Tessellation cpu = votess::tessellate(set.points, options);
        options.device = test::device_name();
        for (const auto kernel : {votess::gpu::Kernel::invocation, test::by_subgroup()}) {
            CAPTURE(static_cast<int>(kernel));
            const test::UseKernel chosen(kernel);
            const Tessellation gpu = tessellator.tessellate(set.points, options);
            CHECK(gpu.stats().fallback_cells < set.size() / 100);
            CHECK(gpu.stats().precision == votess::Precision::single);
            CHECK(gpu.stats().device != "CPU");
            CHECK(test::check_same(gpu, cpu, set.points, 1e-5) == "");
            CHECK(votess::verify(gpu, set.points).failure == "");
        }
    }

    TEST_CASE("gpu: clusters of the size of the coarse coordinates' steps among spread seeds") {
        // Coordinates are about 2^62 units; searches for far neighbors use only the upper 32 bits.
        votess::Tessellator& tessellator = test::shared_tessellator();
        for (const int exponent : {-26, -28, -30})
            for (const unsigned k : {12u, 64u}) {
                test::Random random(static_cast<std::uint64_t>(k - exponent));
                PointSet set{"clusters", {}, test::unit_box()};
                const double size = std::ldexp(1.0, exponent);
                for (std::size_t cluster = 0; cluster < test::by_size(8, 3); ++cluster) {
                    const double center[3] = {random.uniform(0, 0.9), random.uniform(0, 0.9), random.uniform(0, 0.9)};
                    for (int i = 0; i < 90; ++i)
                        for (const double c : center) set.points.push_back(c + size * random.uniform());
                }
                Options options = test::all_options();
                options.k_init = k;
                CAPTURE(exponent);
                CAPTURE(k);
                CHECK(compare(tessellator, set, options) == "");
                const test::UseKernel chosen(test::by_subgroup());
                if (k == 64) CHECK(compare(tessellator, set, options) == "");
            }
    }

    TEST_CASE("gpu: tuning options change nothing") {
        struct Variant {
            std::string name;
            Options options = test::all_options();
            votess::gpu::Kernel kernel = votess::gpu::Kernel::automatic;
        };
        std::vector<Variant> variants;
        const auto vary = [&](std::string name, auto&& change) {
            change(variants.emplace_back(Variant{std::move(name)}).options);
        };
        const auto vary_subgroup = [&](const std::string& name, auto&& change) {
            vary("kernel subgroup" + name, change);
            variants.back().kernel = test::by_subgroup();
        };
        vary("k_init 1", [](Options& o) { o.k_init = 1; });
        vary("k_init 1024", [](Options& o) { o.k_init = 1024; });
        vary("precision double", [](Options& o) { o.precision = test::double_precision(); });
        vary("chunk_size 7", [](Options& o) { o.chunk_size = 7; });
        vary("chunk_size 100", [](Options& o) { o.chunk_size = 100; });
        vary("grid_resolution 1", [](Options& o) { o.grid_resolution = 1; });
        vary("grid_resolution 64", [](Options& o) { o.grid_resolution = 64; });
        vary("grid_resolution 1025", [](Options& o) { o.grid_resolution = 1025; });
        vary("grid_resolution 2^20", [](Options& o) { o.grid_resolution = 1u << 20; });
        vary_subgroup("", [](Options&) {});
        vary_subgroup(", precision double", [](Options& o) { o.precision = test::double_precision(); });
        vary_subgroup(", chunk_size 7", [](Options& o) { o.chunk_size = 7; });
        vary("3 threads", [](Options& o) { o.threads = 3, o.chunk_size = 64; });
        vary("no walls", [](Options& o) { o.list_walls = false; });
        votess::Tessellator& tessellator = test::shared_tessellator();
        for (const auto& [name, options, kernel] : variants)
            for (const PointSet& set : samples(test::by_size(150, 40))) {
                CAPTURE(name);
                CAPTURE(set.name);
                const test::UseKernel chosen(kernel);
                CHECK(compare(tessellator, set, options) == "");
            }
        Options one;
        one.chunk_size = 1;
        CHECK(compare(tessellator, test::with_duplicates(70, 10, 72), one) == "");
    }

    TEST_CASE("gpu: what is wanted changes nothing in the rest") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        const PointSet set = test::with_duplicates(test::by_size(300, 100), 20, 73);
        for (unsigned bits = 0; bits < 64; ++bits) {
            CAPTURE(bits);
            Options options = test::all_options();
            options.want = {(bits & 1) != 0, (bits & 8) != 0, (bits & 16) != 0, (bits & 2) != 0, (bits & 32) != 0};
            options.list_walls = (bits & 4) != 0;
            CHECK(compare(tessellator, set, options) == "");
            const test::UseKernel chosen(test::by_subgroup());
            if (bits % 9 == 0) CHECK(compare(tessellator, set, options) == "");
        }
    }

    TEST_CASE("gpu: float32 input") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        for (PointSet set : samples(test::by_size(500, 100))) {
            CAPTURE(set.name);
            std::vector<float> narrow(set.points.begin(), set.points.end());
            set.points.assign(narrow.begin(), narrow.end());
            Options options = test::all_options(set.box);
            const Tessellation cpu = votess::tessellate(std::span<const float>(narrow), options);
            options.device = test::device_name();
            const Tessellation gpu = tessellator.tessellate(std::span<const float>(narrow), options);
            CHECK(test::check_same(gpu, cpu, set.points, 1e-5) == "");
        }
    }

    TEST_CASE("gpu: boxes larger than the points, flat, and touching them") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        const std::size_t n = test::by_size(150, 50);
        for (const double room : {1e-3, 1.0, 1e3, 1e9, 1e15}) {
            PointSet set = test::uniform(n, 74);
            set.box = test::cube(-room, 1 + room / 3);
            CAPTURE(room);
            CHECK(compare(tessellator, set) == "");
        }
        for (const double thickness : {1e-3, 1e-15, 0x1p-500})
            for (const std::size_t axis : {0, 1, 2})
                for (const bool two : {false, true}) {
                    PointSet set = test::uniform(n, 75);
                    const auto flatten = [&](std::size_t a) {
                        for (std::size_t i = a; i < set.points.size(); i += 3) set.points[i] *= thickness;
                        set.box->upper[a] *= thickness;
                    };
                    flatten(axis);
                    if (two) flatten((axis + 1) % 3);
                    CAPTURE(thickness);
                    CAPTURE(axis);
                    CAPTURE(two);
                    CHECK(compare(tessellator, set) == "");
                }
        for (const PointSet& base : {test::uniform(n, 76), test::cubic(5), test::clustered(n, 77)}) {
            PointSet set = base;  // the box is the points' bounds
            set.box = votess::Box{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
            for (std::size_t i = 0; i < set.points.size(); ++i) {
                set.box->lower[i % 3] = std::min(set.box->lower[i % 3], set.points[i]);
                set.box->upper[i % 3] = std::max(set.box->upper[i % 3], set.points[i]);
            }
            CAPTURE(set.name);
            CHECK(compare(tessellator, set) == "");
        }
    }

    TEST_CASE("gpu: no seeds, one, two, three") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        for (const std::size_t n : {0, 1, 2, 3, 4, 5, 8, 9})
            for (const bool with_box : {false, true}) {
                CAPTURE(n);
                CAPTURE(with_box);
                PointSet set = test::uniform(n, n + 80);
                if (!with_box) set.box.reset();
                CHECK(compare(tessellator, set) == "");
                const test::UseKernel chosen(test::by_subgroup());
                CHECK(compare(tessellator, set) == "");
            }
        PointSet same{"same", {}, std::nullopt};
        for (int i = 0; i < 300; ++i) {
            same.points.insert(same.points.end(), {0.25, -3, 7e5});
            if (i < 3 || i == 64 || i == 65 || i == 299) CHECK(compare(tessellator, same) == "");
        }
    }

    TEST_CASE("gpu: one Tessellator, sizes up and down, options changing") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        test::Random random(81);
        for (const std::size_t full : {500, 3, 1000, 0, 1, 64, 2000, 2, 700, 1500}) {
            const std::size_t n = test::by_size(full, full / 10);
            Options options = test::all_options();
            options.list_walls = random.chance(0.5);
            options.want = {random.chance(0.8), random.chance(0.8), random.chance(0.5), random.chance(0.5),
                            random.chance(0.5)};
            options.threads = 1 + static_cast<unsigned>(random.below(3));
            options.chunk_size = random.chance(0.3) ? 300 : 0;
            if (random.chance(0.3)) {
                options.precision = test::double_precision();
                options.want = test::all_options().want;  // fewer kernels to compile
            }
            const test::UseKernel chosen(random.chance(0.5) ? test::by_subgroup() : votess::gpu::Kernel::automatic);
            CAPTURE(n);
            CHECK(compare(tessellator, random.chance(0.5) ? test::uniform(n, n) : test::clustered(n, n), options) ==
                  "");
        }
    }

    TEST_CASE("gpu: duplicates are refused with the CPU's message") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        const auto refusal = [&](const PointSet& set, const char* device) {
            Options options = test::all_options(set.box);
            options.duplicates = votess::Duplicates::error;
            options.device = device;
            std::string message;
            const auto code = test::error_of([&] { (void)tessellator.tessellate(set.points, options); }, &message);
            return code ? std::to_string(static_cast<int>(*code)) + message : std::string();
        };
        const std::string device = test::device_name();
        PointSet one = test::uniform(500, 82), far = test::far_from_origin(500, 83);
        for (PointSet* set : {&one, &far})
            for (std::size_t a = 0; a < 3; ++a) set->points[3 * 321 + a] = set->points[3 * 20 + a];
        for (const PointSet& set : {one, far, test::with_duplicates(600, 90, 84), test::near_duplicates(400, 85),
                                    test::uniform(300, 86), test::on_oblique_plane(300, 87)}) {
            CAPTURE(set.name);
            CHECK(refusal(set, device.c_str()) == refusal(set, "cpu"));
        }
        CHECK(refusal(one, device.c_str()) != "");
        CHECK(compare(tessellator, one) == "");
    }
}

// Qhull: the Voronoi diagram as the lower hull of lifted points, one thread, with the options that SciPy uses.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <type_traits>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include "bench.hpp"

namespace bench {
namespace {

using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

// Qhull hands its own state to callbacks and nothing of ours; being first, it leads back to the whole.
struct Run {
    qhT qh{};
    Pairs pairs;
    std::int32_t points = 0;
};

static_assert(std::is_standard_layout_v<Run>);

// One ridge of the Voronoi diagram: the face between two seeds.
void add_pair(qhT* qh, FILE*, vertexT* a, vertexT* b, setT*, boolT) {
    Run& run = *reinterpret_cast<Run*>(qh);
    const int i = qh_pointid(qh, a->point);
    const int j = qh_pointid(qh, b->point);
    if (i < run.points && j < run.points) {  // option Qz adds a point at infinity
        run.pairs.emplace_back(i, j);
    }
}

class Qhull final : public Peer {
public:
    [[nodiscard]] std::string name() const override { return "qhull"; }
    [[nodiscard]] std::string version() const override { return qh_version2; }
    [[nodiscard]] bool can(const Input& input, Want want) const override {
        return input.plain() && want == Want::neighbors;
    }
    [[nodiscard]] bool bounded(const Input&) const override { return false; }

    [[nodiscard]] Answer run(const Input& input, Want, unsigned) const override {
        std::vector<double> points = input.points;  // Qhull asks for a mutable array
        char command[] = "qhull v Qbb Qc Qz";
        char* message = nullptr;
        std::size_t length = 0;
        FILE* const messages = open_memstream(&message, &length);
        if (messages == nullptr) {
            throw std::runtime_error("open_memstream failed");
        }

        const Stopwatch stopwatch;
        Run run;
        run.points = static_cast<std::int32_t>(input.size());
        qh_zero(&run.qh, messages);
        const int code = qh_new_qhull(&run.qh, 3, run.points, points.data(), False, command, nullptr, messages);
        Answer answer;
        if (code == 0) {
            boolT lower = True;
            int centers = 0;
            setT* vertices = qh_markvoronoi(&run.qh, run.qh.facet_list, nullptr, True, &lower, &centers);
            qh_settempfree(&run.qh, &vertices);
            qh_eachvoronoi_all(&run.qh, nullptr, add_pair, False, qh_RIDGEall, False);
            const Rows rows = rows_from_pairs(input.size(), run.pairs);
            answer = {stopwatch.seconds(), rows.indices.size(), 0};
        }
        qh_freeqhull(&run.qh, qh_ALL);
        int current = 0, total = 0;
        qh_memfreeshort(&run.qh, &current, &total);
        std::fclose(messages);
        std::string text = message != nullptr ? message : "";
        std::free(message);
        if (code != 0) {
            throw std::runtime_error(text.substr(0, text.find('\n')));
        }
        return answer;
    }
};

}  // namespace

std::unique_ptr<Peer> make_qhull() {
    return std::make_unique<Qhull>();
}

}  // namespace bench

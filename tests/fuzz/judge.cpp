#include "fuzz/judge.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <sstream>

#include "oracle/certificate.hpp"
#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/text.hpp"

namespace test::fuzz {
namespace {

constexpr std::size_t few = 100;  // all cells of so many seeds are proven
constexpr std::size_t proven_of_many = 16;
constexpr std::size_t jobs_per_proof = 16;  // of a long history, whose other jobs are compared with fresh ones
constexpr double max_seconds = 2, max_megabytes = 200;  // for few seeds

double processor_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double peak_megabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

struct Answer {
    votess::Tessellation t;
    std::string refusal;  // "": t is the answer
    bool proper = false;  // the refusal blames the input
};

Answer ask(votess::Tessellator& tessellator, const Job& job, const std::string& device) {
    Answer answer;
    setenv("VOTESS_VULKAN_KERNEL", job.by_subgroup ? "subgroup" : "invocation", 1);
    try {
        answer.t = tessellator.tessellate(job.points, job.options(device));
    } catch (const votess::Error& error) {
        answer.refusal = error.what();
        answer.proper =
            error.code() == votess::ErrorCode::invalid_argument || error.code() == votess::ErrorCode::unsupported;
    } catch (const std::exception& error) {
        answer.refusal = error.what();
    }
    return answer;
}

// Compares the rows with those of the same seeds in another order.
std::string check_shuffled(const votess::Tessellation& t, const Job& job, const std::string& device,
                           std::uint64_t number) {
    Random random(number);
    const auto order = permutation(job.size(), random);
    std::vector<std::int32_t> place(order.size());
    Job other = job;
    for (std::size_t i = 0; i < order.size(); ++i) {
        place[order[i]] = static_cast<std::int32_t>(i);
        std::copy_n(&job.points[3 * order[i]], 3, &other.points[3 * i]);
        if (!job.weights.empty()) other.weights[i] = job.weights[order[i]];
    }
    votess::Tessellator fresh;
    const Answer answer = ask(fresh, other, device);
    if (!answer.refusal.empty()) return "order: refused in another order: " + answer.refusal;
    const auto faces = [](const votess::Tessellation& of, std::size_t i, const std::vector<std::int32_t>* to) {
        std::vector<ExactFace> row;
        for (std::size_t k = 0; k < of.neighbors(i).size(); ++k) {
            ExactFace face{of.neighbors(i)[k], {}};
            if (to != nullptr && face.id >= 0) face.id = (*to)[static_cast<std::size_t>(face.id)];
            if (!of.shifts().empty())
                std::copy_n(&of.shifts()[3 * (static_cast<std::size_t>(of.indptr()[i]) + k)], 3, face.shift.begin());
            row.push_back(face);
        }
        std::ranges::sort(row);
        return row;
    };
    for (std::size_t i = 0; i < order.size(); ++i)
        if (t.status()[i] != answer.t.status()[static_cast<std::size_t>(place[i])] ||
            faces(t, i, &place) != faces(answer.t, static_cast<std::size_t>(place[i]), nullptr))
            return text("order: cell ", i, " depends on the order of the seeds");
    return "";
}

// Returns whether the oracle's integers are so long that it takes much time.
bool spans_many_binades(const Job& job) {
    double least = 1, largest = 0;
    for (const double x : job.points)
        if (x != 0) least = std::min(least, std::abs(x)), largest = std::max(largest, std::abs(x));
    return least < 0x1p-400 * largest;
}

std::string check_answer(const votess::Tessellation& t, const Job& job, const std::string& device,
                         std::uint64_t number) {
    const votess::Options options = job.options(device);
    const bool single = t.stats().precision == votess::Precision::single;
    if (options.want.neighbors && job.closed)
        for (std::size_t i = 0; i < t.size(); ++i)
            for (const std::int32_t j : t.neighbors(i))
                if (j < 0 && j > -7) return text("domain: a wall of the box cuts the polyhedron: cell ", i);
    if (options.want.neighbors && options.want.volumes && !single && t.size() > 0)
        if (const std::string wrong = check_domain(t); !wrong.empty()) return "contradiction: " + wrong;
    if (options.want.neighbors) {
        std::vector<std::size_t> cells;
        if (t.size() > few || spans_many_binades(job)) {
            Random random(number);
            const std::size_t proven = t.size() > few ? proven_of_many : 1;
            for (std::size_t k = 0; k < proven; ++k) cells.push_back(random.below(t.size()));
        }
        if (const std::string wrong = check_certificate(t, job.points, options, cells); !wrong.empty())
            return "exact: " + wrong;
    }
    try {
        const std::string wrong = votess::verify(t, job.points, {t.size() > few ? 64u : 0u, number}).failure;
        if (!wrong.empty()) return "verify: " + wrong;
    } catch (const std::exception& error) {
        return std::string("verify: threw ") + error.what();
    }
    if (t.size() > few && options.want.neighbors && t.stats().duplicates == 0)
        return check_shuffled(t, job, device, number);
    return "";
}

}  // namespace

std::string sort_of(const std::string& failure) {
    std::istringstream words(failure.substr(0, failure.find(';')));
    std::string sort;
    for (std::string word; words >> word;)
        if (word.find_first_of("0123456789") == std::string::npos) sort += (sort.empty() ? "" : " ") + word;
    return sort;
}

Judgement judge(const Case& c, const std::string& device, bool measure, votess::Tessellator& kept) {
    Judgement judgement;
    for (std::size_t k = 0; k < c.jobs.size() && judgement.right(); ++k) {
        const Job& job = c.jobs[k];
        ++judgement.jobs;
        const double seconds = processor_seconds(), megabytes = peak_megabytes();
        const Answer answer = ask(kept, job, device);
        const double took = processor_seconds() - seconds, more = peak_megabytes() - megabytes;
        std::string& wrong = judgement.failure;
        if (!answer.refusal.empty() && !(answer.proper && job.may_refuse)) {
            wrong = (answer.proper ? "refused: " : "threw: ") + answer.refusal;
        } else if (measure && job.size() <= few && took > max_seconds) {
            wrong = text("slow: ", took, " s of processor time for ", job.size(), " seeds");
        } else if (measure && job.size() <= few && more > max_megabytes) {
            wrong = text("memory: ", more, " MB for ", job.size(), " seeds");
        } else if (!answer.refusal.empty()) {
            ++judgement.refused;
        } else {
            if (c.jobs.size() <= jobs_per_proof || k % jobs_per_proof == c.number % jobs_per_proof)
                wrong = check_answer(answer.t, job, device, c.number);
            judgement.cells += answer.t.size();
            judgement.fallback_cells += answer.t.stats().fallback_cells;
        }
        if (wrong.empty() && c.jobs.size() > 1) {
            votess::Tessellator fresh;
            const Answer other = ask(fresh, job, device);
            if (other.refusal != answer.refusal)
                wrong = "reuse: refused with '" + answer.refusal + "', and with '" + other.refusal + "' afresh";
            else if (answer.refusal.empty())
                wrong = check_identical(answer.t, other.t);
            if (!wrong.empty() && !wrong.starts_with("reuse")) wrong = "reuse: " + wrong;
        }
        if (!wrong.empty() && c.jobs.size() > 1) wrong += text(" (job ", k, ')');
    }
    return judgement;
}

}  // namespace test::fuzz

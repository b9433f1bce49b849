#include "fuzz/job.hpp"

#include <cstdio>
#include <cstdlib>
#include <istream>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include "polytope/cell_kernels.hpp"
#include "support/check.hpp"

namespace test::fuzz {
namespace {

template <class Range>
void write_numbers(std::ostream& out, const Range& numbers) {
    for (const double x : numbers) {
        char digits[40];
        std::snprintf(digits, sizeof digits, " %a", x);
        out << digits;
    }
}

template <std::size_t N>
std::array<double, N> read_numbers(std::istream& in) {
    std::array<double, N> numbers{};
    for (double& x : numbers) {
        std::string word;
        if (!(in >> word)) throw std::runtime_error("too few numbers");
        char* end = nullptr;
        x = std::strtod(word.c_str(), &end);
        if (*end != '\0') throw std::runtime_error("'" + word + "' is no number");
    }
    return numbers;
}

std::array<double, 3> part(const double* x) {
    return {x[0], x[1], x[2]};
}

void read_line(const std::string& word, std::istream& in, Case& c) {
    if (word == "kind") {
        in >> c.kind >> c.number;
        return;
    }
    if (word == "job") {
        c.jobs.emplace_back();
        return;
    }
    if (c.jobs.empty()) throw std::runtime_error("'" + word + "' before the first job");
    Job& job = c.jobs.back();
    if (word == "box") {
        const auto x = read_numbers<6>(in);
        job.box = votess::Box{part(&x[0]), part(&x[3])};
    } else if (word == "periodic") {
        for (bool& axis : job.periodic) in >> axis;
    } else if (word == "cell") {
        const auto x = read_numbers<12>(in);
        job.cell = votess::TriclinicBox{part(&x[0]), part(&x[3]), part(&x[6]), part(&x[9])};
    } else if (word == "edges") {
        for (bool& axis : job.cell.value().periodic) in >> axis;
    } else if (word == "wall") {
        const auto x = read_numbers<4>(in);
        job.walls.push_back({part(&x[0]), x[3]});
    } else if (word == "seed") {
        const auto x = read_numbers<3>(in);
        job.points.insert(job.points.end(), x.begin(), x.end());
        if ((in >> std::ws).good()) job.weights.push_back(read_numbers<1>(in)[0]);
    } else if (word == "want") {
        in >> job.want;
    } else if (word == "grid") {
        in >> job.grid_resolution;
    } else if (word == "threads") {
        in >> job.threads;
    } else if (word == "instructions") {
        in >> job.instructions;
    } else if (word == "k_init") {
        in >> job.k_init;
    } else if (word == "chunk") {
        in >> job.chunk_size;
    } else if (word == "drop") {
        job.drop = true;
    } else if (word == "keep") {
        job.keep = true;
    } else if (word == "list_walls") {
        job.list_walls = true;
    } else if (word == "follow") {
        job.follow = true;
    } else if (word == "may_refuse") {
        job.may_refuse = true;
    } else if (word == "closed") {
        job.closed = true;
    } else if (word == "double") {
        job.double_precision = true;
    } else if (word == "subgroup") {
        job.by_subgroup = true;
    } else {
        throw std::runtime_error("'" + word + "' is not known");
    }
}

}  // namespace

votess::Options Job::options(const std::string& device) const {
    votess::Options options = all_options(box);
    options.device = device;
    options.periodic = periodic;
    options.cell = cell;
    options.walls = walls;
    options.outside = keep ? votess::Outside::keep : drop ? votess::Outside::drop : votess::Outside::error;
    options.list_walls = list_walls;
    options.follow = follow;
    bool* const wants[] = {&options.want.neighbors, &options.want.volumes, &options.want.centroids,
                           &options.want.counts,    &options.want.areas,   &options.want.normals,
                           &options.want.surfaces,  &options.want.radii,   &options.want.vertices,
                           &options.want.faces};
    for (std::size_t bit = 0; bit < std::size(wants); ++bit) *wants[bit] = (want >> bit & 1) != 0;
    options.weights = weights;
    options.grid_resolution = grid_resolution;
    options.threads = threads;
    options.k_init = k_init;
    options.chunk_size = chunk_size;
    if (double_precision) options.precision = votess::Precision::double_;
    if (votess::cpu::find_kernels(instructions) != nullptr) options.instructions = instructions;
    return options;
}

Job Job::without(std::size_t first, std::size_t end) const {
    Job job = *this;
    const auto a = static_cast<std::ptrdiff_t>(first), b = static_cast<std::ptrdiff_t>(end);
    job.points.erase(job.points.begin() + 3 * a, job.points.begin() + 3 * b);
    if (!weights.empty()) job.weights.erase(job.weights.begin() + a, job.weights.begin() + b);
    return job;
}

void write(const Case& c, std::ostream& out) {
    out << "kind " << c.kind << ' ' << c.number << '\n';
    for (const Job& job : c.jobs) {
        out << "job\n";
        if (job.box) {
            out << "box";
            write_numbers(out, job.box->lower);
            write_numbers(out, job.box->upper);
            out << '\n';
        }
        if (job.periodic != std::array<bool, 3>{})
            out << "periodic " << job.periodic[0] << ' ' << job.periodic[1] << ' ' << job.periodic[2] << '\n';
        if (job.cell) {
            out << "cell";
            for (const auto* v : {&job.cell->origin, &job.cell->a, &job.cell->b, &job.cell->c}) write_numbers(out, *v);
            const auto& [a, b, c] = job.cell->periodic;
            out << '\n';
            if (!(a && b && c)) out << "edges " << a << ' ' << b << ' ' << c << '\n';  // that repeat; default all
        }
        for (const votess::Wall& wall : job.walls) {
            out << "wall";
            write_numbers(out, wall.normal);
            write_numbers(out, std::array{wall.offset});
            out << '\n';
        }
        out << "want " << job.want << "\ngrid " << job.grid_resolution << "\nthreads " << job.threads << '\n';
        if (!job.instructions.empty()) out << "instructions " << job.instructions << '\n';
        if (job.k_init != 0) out << "k_init " << job.k_init << '\n';
        if (job.chunk_size != 0) out << "chunk " << job.chunk_size << '\n';
        for (const auto& [name, on] :
             {std::pair{"drop", job.drop}, std::pair{"keep", job.keep}, std::pair{"list_walls", job.list_walls},
              std::pair{"follow", job.follow}, std::pair{"may_refuse", job.may_refuse}, std::pair{"closed", job.closed},
              std::pair{"double", job.double_precision}, std::pair{"subgroup", job.by_subgroup}})
            if (on) out << name << '\n';
        for (std::size_t i = 0; i < job.size(); ++i) {
            out << "seed";
            write_numbers(out, part(&job.points[3 * i]));
            if (!job.weights.empty()) write_numbers(out, std::array{job.weights[i]});
            out << '\n';
        }
    }
}

Case read(std::istream& in) {
    Case c;
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        std::istringstream words(line);
        std::string word;
        if (!(words >> word) || word[0] == '#') continue;
        try {
            read_line(word, words, c);
        } catch (const std::runtime_error& error) {
            throw std::runtime_error("line " + std::to_string(number) + ": " + error.what());
        }
    }
    return c;
}

}  // namespace test::fuzz

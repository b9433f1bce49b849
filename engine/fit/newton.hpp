// Damped Newton steps to the weights of given volumes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/thread_pool.hpp"
#include "fields/masses.hpp"
#include "fit/laplacian.hpp"
#include "input/settle.hpp"
#include "votess/fit.hpp"

namespace votess::fit {

// A density on a grid over the domain, of the mean 1.
struct Under {
    fields::Frame frame;
    std::vector<double> values;
};

// With a density all volumes are masses, in units of its mean.
struct Problem {
    std::vector<double> points;           // 3N, along a Hilbert curve
    std::span<const std::int32_t> given;  // N, their places among the points of the caller
    double scale = 1;                     // of the coordinates, a power of two
    std::vector<double> places;           // 3N, the points inside a periodic domain
    Vector targets;                       // N volumes
    Vector start;                         // N weights, with which each seed has a cell
    Edges edges{};                        // of the domain
    Settled run;                          // its region and how it works
    int dimensions = 3;                   // 2: the cells are those of a sheet, see plane/sheet.hpp
    std::optional<Under> density;
    ThreadPool* pool = nullptr;  // for masses
    bool is_part = false;        // for a start of more seeds, without progress of its own
};

struct Weighted {
    Vector weights, volumes;
    // With neighbors, volumes, areas, and centroids or faces. In the plane under a density with neighbors alone.
    Tessellation tessellation;
    Masses masses;                          // with a density
    std::optional<fields::FlatCells> flat;  // with a density, in the plane
    [[nodiscard]] std::span<const double> even_volumes() const {
        return flat ? flat->volumes() : tessellation.volumes();
    }
    [[nodiscard]] std::span<const double> face_areas() const {
        return flat ? flat->areas() : tessellation.face_areas();
    }
    double residual = 0;  // largest |volume - target| / target
};

// The steps. Each counts itself in `out`, and adds its seconds.
//
// The size of a cell alone is about linear in its weight, and so is that of cells that grow together. So a step solves
// for the cube roots of volumes, in the plane for the square roots of areas. It aims at a goal between volumes and
// targets, on a logarithmic scale. Cells that it leaves empty are revived in the cells around them.
//
// In tight clusters cells come to lie far from their seeds, and short steps lead there. So a fit of a part of the seeds
// comes first (Mérigot 2011).
//
// Under a density that is 0 in places, cells there have no mass, and no derivative. So a share of the mass, the lift,
// is spread evenly over the domain. After each step it sinks as far as no cell loses most of its mass.
//
// Between parts of a domain that cells do not connect, or hardly, the derivatives tell nothing, and no step comes
// nearer. But the targets' weights are the maximum of a concave function, whose gradient is the targets minus the
// volumes (Aurenhammer, Hoffmann and Aronov 1998). So damped steps climb it, also where that empties cells for a while.
class Newton {
public:
    Newton(Problem problem, const FitOptions& options, VolumeFit& out);

    // Steps until now() is within the tolerance. Starts from `weights`, or from Problem::start where they leave a cell
    // empty. Returns false when steps end before; why() is the remedy.
    [[nodiscard]] bool run(Vector weights);
    [[nodiscard]] const Weighted& now() const { return now_; }  // the best so far
    [[nodiscard]] const std::string& why() const { return why_; }
    // Returns |volume - target| / target of each point.
    [[nodiscard]] Vector errors(const Weighted& of) const;
    // Returns the runner of now(), which can follow its cells.
    [[nodiscard]] Runner take_runner() { return std::move(runner_); }

private:
    // Returns a diagram near the last one, or elsewhere.
    [[nodiscard]] Weighted tessellate(Vector weights);
    [[nodiscard]] Weighted tessellate(Vector weights, Runner& runner);
    void forget();                     // the last diagram: the next one is far from it
    void measure(Weighted& of) const;  // at this lift
    void sink();                       // lowers the lift
    [[nodiscard]] std::vector<double> areas() const;
    // Returns the diagram after a step.
    [[nodiscard]] Weighted trial(const Vector& step);
    // Returns a diagram with small cells revived as far as that is possible. before: with cells of all seeds. Each
    // attempt has to leave fewer of them than this share. most: the share of cells that may be small at first.
    [[nodiscard]] Weighted revived(Weighted next, const Tessellation& before, const Vector& least, int attempts,
                                   double left, double most);
    [[nodiscard]] Vector goal() const;
    [[nodiscard]] Vector step_to(const Vector& goal);
    // Takes a step. Returns false if no step leads on.
    [[nodiscard]] bool advance();
    // Takes the longest step that empties no cell and comes nearer. Returns false if none does.
    [[nodiscard]] bool approach();
    // Returns the mean derivative of a volume by its weight; where hardly two cells touch, that of cells as wide as the
    // box of the seeds.
    [[nodiscard]] double damping_unit() const;
    // Takes a damped step upward. Returns false if none is left.
    [[nodiscard]] bool climb();
    // Keeps the diagram if it is the best one without empty cells since steps lead upward.
    void keep_best();
    void choose_share();
    // Moves to the diagram that a fit of fewer seeds leads to, if that is nearer.
    void start_from_fewer();
    void fill();
    [[nodiscard]] double smallest() const;  // volume / target

    Problem problem_;
    const FitOptions& options_;
    VolumeFit& out_;
    Runner runner_;
    bool has_cells_ = false;  // of the last call, in runner_
    Matrix matrix_;
    Weighted now_;
    std::optional<Weighted> best_;  // before steps upward, and of them
    double lift_ = 0;
    double share_ = 1;      // of the way from volumes to targets, for the goal
    bool filling_ = false;  // the goal lets only the smallest cells grow
    double filled_ = 0;     // volume / target of the smallest cell, at which filling ends
    double damping_ = 0;    // of the next step upward, 0 while others come nearer
    double climbed_ = 0;    // residual at which steps upward end
    double first_residual_ = 0;
    std::string why_;
};

}  // namespace votess::fit

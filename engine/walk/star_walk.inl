// The functions of StarWalk, one part for each step of the walk.
#pragma once

#include "walk/star_walk.hpp"

namespace votess::cpu {

// ---- Which planes are candidates ----

// Guesses from the stretch alone, so that the last bits do not depend on the number of threads.
template <class Isa>
void StarWalk<Isa>::guess_reach(std::size_t group) {
    const int level = std::min(1, hierarchy_.top_level());
    const std::size_t seeds = level == 1 ? group_size * box_fan : group_size, first = group * group_size;
    const Box box = hierarchy_.box(level, first / seeds);
    double longest = 0, volume = 1;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, box.upper[k] - box.lower[k]);
    for (int k = 0; k < 3; ++k) volume *= std::max(box.upper[k] - box.lower[k], 0.01 * longest);
    const double count = static_cast<double>(std::min(seeds, seeds_.size() - first / seeds * seeds));
    typical_reach_ = 5 * std::pow(volume / count, 2.0 / 3);
    reach_margin_ = min_reach_margin;
}

template <class Isa>
void StarWalk<Isa>::begin(std::size_t first, std::size_t last, Keep keep) {
    clear_planes();
    cells_.begin(seeds_, first, last, static_cast<std::int32_t>(wall_places_.size()), keep == Keep::places);
    make_room(cells_.locals());
    keep_ = keep;
    probing_ = false;
    own_images_ = std::numeric_limits<double>::infinity();
    any_wrapped_ = seeds_.images != nullptr && seeds_.images->any_wrapped();
    any_rough_ = seeds_.images != nullptr && seeds_.images->any_rough();
    low_ = {};
    moved_ = false;
    window_home_ = ~std::size_t{0};
    guess_reach(first / group_size);
}

template <class Isa>
void StarWalk<Isa>::begin_probes(std::size_t group, Keep keep) {
    begin(0, 0, keep);
    probing_ = true;
    if (seeds_.images != nullptr) own_images_ = nearest_translation(*domain_);
    guess_reach(group);
}

template <class Isa>
void StarWalk<Isa>::look_around(const Box& box, double lightest) {
    probes_box_ = box;
    lightest_probe_ = lightest;
    window_home_ = ~std::size_t{0};
}

template <class Isa>
void StarWalk<Isa>::open_window(std::size_t home, double reach2) {
    window_home_ = home;
    Box box = probing_ ? probes_box_ : window_.home_box(home);
    if (weighted_) find_tilt(home, box);
    const WeightTilt* tilt = weighted_ ? &tilt_ : nullptr;
    const double radius = std::sqrt(reach2) * 1.02;
    is_bent_ = is_bent_ && (bent_.stretch > min_stretch || bent_.max_turned > min_turned * radius);
    const Window::Bent* bent = is_bent_ ? &bent_ : nullptr;
    window_open_ = window_.open(home, box, radius, tilt, cells_, bent);
    // A home may span far more than its surroundings, where the curve leaves a cluster.
    if (!window_open_) {
        box = {p_, p_};
        is_bent_ = false;
        window_open_ = window_.open(home, box, radius, tilt, cells_, nullptr);
        window_home_ = ~std::size_t{0};
    }
    if (!window_open_) return;
    collect_near_walls(box, is_bent_ ? window_.reach() * bent_.longest + bent_.max_turned : window_.reach());
    if (weighted_ && seeds_.images != nullptr) sure_images_ = sure_by_weights(box);
    sure_images_known_ = false;
    sure_box_ = box;
    for (std::size_t s = home * Window::home_seeds; s < seed_ && !probing_; ++s)
        if (cells_.holds(static_cast<std::int64_t>(s)) && cells_.done(s)) window_.hide(s);
}

template <class Isa>
void StarWalk<Isa>::find_tilt(std::size_t home, const Box& box) {
    tilt_ = {};
    tilt_.largest = largest_coordinate(hierarchy_.box(hierarchy_.top_level(), 0));
    for (std::size_t k = 0; k < 3; ++k) tilt_.origin[k] = 0.5 * (box.lower[k] + box.upper[k]);
    home_tilt_length_ = 0;
    is_bent_ = false;
    if (probing_) {
        tilt_.base = lightest_ = lightest_probe_;
        return;
    }
    const std::size_t group = home * Window::home_groups;
    const WeightBlock& bounds = hierarchy_.weight_bounds(0, group / box_fan);
    for (std::size_t k = 0; k < 3; ++k) tilt_.slope[k] = bounds.slope[k][group % box_fan];
    is_bent_ = find_bend(home) && (bent_.stretch > min_stretch || bent_.bend.steepest >= min_steepest);
    home_tilt_length_ = length_of(tilt_);
    const std::size_t begin = home * Window::home_seeds, end = std::min(begin + Window::home_seeds, seeds_.size());
    tilt_.base = lightest_ = seeds_.weights[begin];
    tilt_.least = 0;
    for (std::size_t s = begin; s < end; ++s) {
        tilt_.least =
            std::min(tilt_.least, least_residual(tilt_, seeds_.weights[s], {seeds_.x[s], seeds_.y[s], seeds_.z[s]}));
        lightest_ = std::min(lightest_, seeds_.weights[s]);
    }
    if (is_bent_) lay_bend(home);
}

// Returns |a|.
template <class Isa>
double StarWalk<Isa>::length_of(const WeightTilt& tilt) {
    const double square = tilt.slope[0] * tilt.slope[0] + tilt.slope[1] * tilt.slope[1] + tilt.slope[2] * tilt.slope[2];
    return 0.5 * std::sqrt(square) * (1 + 8 * unit);
}

// Fits how the slope of the weights changes from home to home along the curve, and sets that of this home. Any bend is
// right; a good one puts the moved seeds into the middle of their cells. Returns false if none explains the slopes.
//
// Homes without a slope have rough weights, or lie where smooth ones are least or greatest.
template <class Isa>
bool StarWalk<Isa>::find_bend(std::size_t home) {
    constexpr std::size_t homes_around = 6;
    constexpr double ridge = 1e-2;            // of the spread
    constexpr double max_unexplained = 0.15;  // of the variance of slopes
    const std::size_t homes = seeds_.size() / Window::home_seeds;
    const std::size_t begin = home < homes_around ? 0 : home - homes_around;
    const std::size_t end = std::min(homes, home + homes_around + 1);
    if (home >= homes) return false;
    std::array<exact::Point, 2 * homes_around + 1> at, slope;
    exact::Point center{}, mean{}, here{};
    std::size_t count = 0;
    for (std::size_t h = begin; h < end; ++h) {
        const std::size_t group = h * Window::home_groups, i = group % box_fan;
        const BoxBlock& boxes = hierarchy_.block(0, group / box_fan);
        const WeightBlock& weights = hierarchy_.weight_bounds(0, group / box_fan);
        const bool sloped = weights.slope[0][i] != 0 || weights.slope[1][i] != 0 || weights.slope[2][i] != 0;
        if (!sloped && h != home) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            at[count][k] =
                0.25 * (boxes.lower[k][i] + boxes.upper[k][i] + boxes.lower[k][i + 1] + boxes.upper[k][i + 1]);
            slope[count][k] = weights.slope[k][i];
            center[k] += at[count][k];
            mean[k] += slope[count][k];
        }
        if (h == home) here = at[count];
        if (sloped)
            ++count;
        else
            for (std::size_t k = 0; k < 3; ++k) center[k] -= at[count][k];
    }
    if (count < homes_around) return false;
    for (std::size_t k = 0; k < 3; ++k) center[k] /= static_cast<double>(count), mean[k] /= static_cast<double>(count);
    double m[3][6] = {}, variance = 0;  // squares of places, and their products with slopes
    for (std::size_t h = 0; h < count; ++h) {
        for (std::size_t k = 0; k < 3; ++k) at[h][k] -= center[k], slope[h][k] -= mean[k];
        for (std::size_t i = 0; i < 3; ++i) {
            variance += slope[h][i] * slope[h][i];
            for (std::size_t j = 0; j < 3; ++j) {
                m[i][j] += at[h][i] * at[h][j];
                m[i][3 + j] += at[h][i] * slope[h][j];
            }
        }
    }
    const double more = ridge * (m[0][0] + m[1][1] + m[2][2]);
    double explained = 0, products[3][3];
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) products[i][j] = m[i][3 + j];
        m[i][i] += more;
    }
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            if (j == i) continue;
            const double by = m[j][i] / m[i][i];
            for (std::size_t k = i; k < 6; ++k) m[j][k] -= by * m[i][k];
        }
    WeightBend& bend = bent_.bend;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const double by = 0.5 * (m[i][3 + j] / m[i][i] + m[j][3 + i] / m[j][j]);
            bend.bend[i][j] = 0.5 * by;
            explained += by * products[i][j];
        }
    const bool does_explain = explained > (1 - max_unexplained) * variance;
    if (!does_explain || !bound_bend()) return false;
    for (std::size_t k = 0; k < 3; ++k) {
        tilt_.slope[k] = mean[k];
        for (std::size_t j = 0; j < 3; ++j) tilt_.slope[k] += 2 * bend.bend[k][j] * (here[j] - center[j]);
    }
    return true;
}

// Returns false if the bend is too steep for the bounds of a window.
template <class Isa>
bool StarWalk<Isa>::bound_bend() {
    constexpr double least = 1e-3;
    WeightBend& bend = bent_.bend;
    bend.largest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        double others = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            const double size = std::abs(bend.bend[i][j]);
            bend.largest = std::max(bend.largest, size);
            others += j == i ? 0 : size;
        }
        bend.downward[i] = std::max(0.0, (others - bend.bend[i][i]) * (1 + 8 * unit));
    }
    for (const double steepest : {0.1, 0.3, 0.5, 0.65, 0.8, 0.9}) {  // by Cholesky
        const auto& b = bend.bend;
        const double first = steepest - b[0][0], by = b[0][1] / first, second = steepest - b[1][1] - by * b[0][1];
        const double across = -b[1][2] - by * b[0][2];
        const double third = steepest - b[2][2] - b[0][2] * b[0][2] / first - across * across / second;
        bend.steepest = steepest;
        if (first > least && second > least && third > least) return find_metric();
    }
    return false;
}

// Returns false if it differs too much from lengths in space, for floats.
template <class Isa>
bool StarWalk<Isa>::find_metric() {
    const WeightBend& bend = bent_.bend;
    double a[3][3], c[3][3];  // A, and its cofactors
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) a[i][j] = (i == j ? 1 : 0) - bend.bend[i][j];
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
            c[i][j] = a[p][r] * a[q][s] - a[p][s] * a[q][r];
        }
    const double determinant = a[0][0] * c[0][0] + a[0][1] * c[0][1] + a[0][2] * c[0][2];
    const double most = 1 + *std::max_element(bend.downward, bend.downward + 3), least = 1 - bend.steepest;
    if (!(most < max_stretch * least && determinant > 0)) return false;
    bent_.stretch = most / least;
    bent_.gain = std::cbrt(determinant);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            bent_.metric[i][j] = a[i][j] / bent_.gain;
            bent_.inverse[i][j] = c[i][j] / determinant * bent_.gain;
        }
    bent_.longest = std::sqrt(most / bent_.gain) * (1 + 8 * unit);
    bent_.longest_inverse = std::sqrt(bent_.gain / least) * (1 + 8 * unit);
    return true;
}

// Finds what the bend leaves of the weights of the home, and how it moves its seeds.
template <class Isa>
void StarWalk<Isa>::lay_bend(std::size_t home) {
    bent_.tilt = tilt_;
    const std::size_t begin = home * Window::home_seeds, end = begin + Window::home_seeds;
    // The slope is that at the middle of the boxes of its groups.
    const std::size_t group = home * Window::home_groups, i = group % box_fan;
    const BoxBlock& boxes = hierarchy_.block(0, group / box_fan);
    for (std::size_t k = 0; k < 3; ++k)
        bent_.tilt.origin[k] =
            0.25 * (boxes.lower[k][i] + boxes.upper[k][i] + boxes.lower[k][i + 1] + boxes.upper[k][i + 1]);
    bent_.tilt.least = std::numeric_limits<double>::infinity();
    bent_.max_turned = 0;
    WeightBend& bend = bent_.bend;
    bend.steepest_slope = std::max({std::abs(tilt_.slope[0]), std::abs(tilt_.slope[1]), std::abs(tilt_.slope[2])});
    double largest = 0;  // of y.A.y
    for (std::size_t s = begin; s < end; ++s) {
        const exact::Point x{seeds_.x[s], seeds_.y[s], seeds_.z[s]};
        const Four turn = turn_at(x);
        double bends = 0, size = 0, square = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double y = x[k] - bent_.tilt.origin[k], by = 0.5 * turn.x[k] * y;
            bends += by;
            size += std::abs(by);
            square += y * y;
        }
        largest = std::max(largest, square - bends + 64 * unit * (square + size));
        const double rho = least_residual(bent_.tilt, seeds_.weights[s], x) - bends - 64 * unit * size;
        bent_.tilt.least = std::min(bent_.tilt.least, rho);
        bent_.max_turned = std::max(bent_.max_turned, 0.5 * std::sqrt(dot(wide(turn), wide(turn))) * (1 + 8 * unit));
    }
    bend.radius = std::sqrt(largest) * (1 + 1e-12);
}

// Returns by how much the slope at a place differs from that of the tilt.
template <class Isa>
Four StarWalk<Isa>::turn_at(const exact::Point& x) const {
    Four turn{};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t j = 0; j < 3; ++j) turn.x[k] += 2 * bent_.bend.bend[k][j] * (x[j] - bent_.tilt.origin[j]);
    return turn;
}

// Finds the tilt at the seed.
template <class Isa>
void StarWalk<Isa>::tilt_alone() {
    own_tilt_ = tilt_;
    turn_ = {};
    turned_ = 0;
    if (is_bent_) {
        const Four turn = turn_at(p_);
        for (std::size_t k = 0; k < 3; ++k) {
            own_tilt_.slope[k] += turn.x[k];
            turn_.x[k] = own_tilt_.slope[k] - tilt_.slope[k];
        }
        turned_ = 0.5 * std::sqrt(dot(wide(turn_), wide(turn_))) * (1 + 8 * unit);
    }
    own_tilt_.least = least_residual(own_tilt_, weight_, p_);
    tilt_length_ = is_bent_ ? length_of(own_tilt_) : home_tilt_length_;
}

template <class Isa>
double StarWalk<Isa>::residual(double weight, const exact::Point& x) const {
    double rest = weight - tilt_.base;
    for (std::size_t k = 0; k < 3; ++k) rest -= tilt_.slope[k] * (x[k] - tilt_.origin[k]);
    return rest;
}

// Rounded down, also for a place that is rounded.
template <class Isa>
double StarWalk<Isa>::least_residual(const WeightTilt& tilt, double weight, const exact::Point& x) const {
    double rest = weight - tilt.base, size = std::abs(rest), steepness = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double by = tilt.slope[k] * (x[k] - tilt.origin[k]);
        rest -= by;
        size += std::abs(by);
        steepness += std::abs(tilt.slope[k]);
    }
    const double places = seeds_.images == nullptr ? 0 : steepness * seeds_.images->largest_coordinate();
    return rest - 16 * unit * (size + places);
}

// Whether a candidate may coincide with the seed. Window integers are exact to half a unit each.
template <class Isa>
bool StarWalk<Isa>::may_coincide() const {
    constexpr float near = 2;
    const CandidatePlanes& c = candidates_;
    bool any = false;
    for (int i = near_walls_end_; i < c.count; ++i)
        any |= std::abs(c.nx[i]) <= near && std::abs(c.ny[i]) <= near && std::abs(c.nz[i]) <= near;
    return any;
}

template <class Isa>
bool StarWalk<Isa>::gather_candidates() {
    double reach2 = reach_margin_ * typical_reach_;
    const std::size_t home = probing_ ? Window::no_home : seed_ / Window::home_seeds;
    if (window_home_ != home) open_window(home, reach2);
    if (!window_open_ || !(probing_ || window_.holds(seed_))) return false;
    const double scale = window_.scale();
    if (weighted_) {
        tilt_alone();
        own_weight_ = window_.weight(residual(weight_, p_));
        for (std::size_t k = 0; k < 3; ++k) move_.x[k] = 0.5 * own_tilt_.slope[k] * scale;
        const double length = home_tilt_length_ * scale, span = window_.weight_span(own_weight_);
        weight_rounding_ = bounds::weight_rounding(span, length, window_.extent());
    }
    reach2 = std::min(reach2, window_.reach() * window_.reach());
    const auto p = probing_ ? window_.position(p_) : window_.position(seed_);
    if (!probing_) window_.hide(seed_);
    have_candidates_ = true;
    own_place_ = p;
    scale_ = scale;
    unscale_ = 1 / scale;
    if (seeds_.images != nullptr) set_image_reach(weighted_ ? sure_image_reach() : seeds_.images->min_reach());
    planes_known_ = 0;
    selected_ = CandidatePlanes::capacity;
    const int most = !weighted_              ? max_candidates
                     : window_.covered() > 0 ? max_weighted_candidates
                                             : max_crowded_candidates;
    for (int tries = 0;; ++tries) {
        const double reach = std::sqrt(reach2) * scale;
        set_longest((is_bent_ ? reach * bent_.longest : reach) * (1 + 0x1p-20) + quantum);
        candidates_.count = 0;
        if (!add_near_walls()) return false;
        const double square = reach2 * scale * scale, near_square = near_share * square;
        SelectLimits limits{static_cast<float>(near_square), static_cast<float>(square), 0};
        if (weighted_) {
            const double rounding =
                weight_rounding_ + bounds::turn_rounding(2 * turned_ * scale, longest_of_window * window_.extent());
            const double distance = 0.5 * (is_bent_ ? reach * bent_.longest : reach);
            limits.slack = static_cast<float>(bounds::select_slack(distance, window_.extent(), rounding));
        }
        if (select(p, limits) && candidates_.count <= most) {
            const double complete = window_.covered() * window_.covered() * scale * scale;
            covered_ = covered_by_search(std::min(square, complete));
            near_covered_ = covered_by_search(std::min(near_square, complete));
            window_covered_ = weighted_ ? covered_by_search(complete) : 0;
            // Seeds are denser than they were. Heavy seeds may crowd one cell only.
            if (weighted_ ? tries == 1 : tries > 0) typical_reach_ = reach2 / reach_margin_;
            break;
        }
        if (tries == (weighted_ ? max_weighted_shrinks : max_shrinks) ||
            (weighted_ && tries == 0 && is_buried(p, limits)))
            return false;
        reach2 *= weighted_ ? weighted_shrink : shrink;
    }
    selected_ = candidates_.count;
    if (weighted_)  // the reach does not bound the candidates
        set_longest(std::max(longest_, std::sqrt(double{candidates_.longest_squared}) * (1 + 0x1p-20) + quantum));
    return true;
}

// Whether very many seeds of the window own the place of the moved seed. The clipper soon finds its cell, if it has
// one.
template <class Isa>
bool StarWalk<Isa>::is_buried(const std::array<std::int32_t, 3>& p, SelectLimits limits) {
    candidates_.count = candidates_.near = 0;
    limits.near_squared = limits.distance_squared = 0;
    return !select(p, limits) || candidates_.count > max_candidates;
}

template <class Isa>
bool StarWalk<Isa>::select(const std::array<std::int32_t, 3>& p, const SelectLimits& limits) {
    if (!is_bent_) return Isa::select(window_.seeds(), p.data(), own_weight_, limits, candidates_);
    BentLimits bent{limits, {}, {}};
    for (std::size_t k = 0; k < 3; ++k) {
        bent.turn[k] = static_cast<float>(turn_.x[k] * scale_);
        bent.metric[k] = static_cast<float>(bent_.metric[k][k]);
        bent.metric[3 + k] = static_cast<float>(2 * bent_.metric[(k + 1) % 3][(k + 2) % 3]);
    }
    return Isa::select_bent(window_.seeds(), p.data(), own_weight_, bent, candidates_);
}

// Sets the length and the margin that depends on it.
template <class Isa>
void StarWalk<Isa>::set_longest(double length) {
    longest_ = length;
    const bounds::FloatMargin m =
        weighted_ ? bounds::float_margin(longest_, tilt_length_ * scale_,
                                         weight_rounding_ + bounds::turn_rounding(2 * turned_ * scale_, longest_))
                  : bounds::float_margin(longest_);
    rounding_by_square_ = m.by_square;
    rounding_ = m.constant;
}

// Returns the squared security radius within which all vertices are cut off by candidates only, after a search within
// `square`.
//
// In a bent window lengths are those of G. Of |N|_G^2 floats lose at most 24 e max_stretch of it, less than 2^-12. As
// |N| <= longest_inverse |N|_G and |n|_G <= |N|_G + q longest, h / |n|_G is at least distance (1 - 2^-13) - quantum
// longest_inverse where select_slack() has distance * longest for its distance.
template <class Isa>
double StarWalk<Isa>::covered_by_search(double square) const {
    const double covered = is_bent_ ? std::sqrt(square) * (1 - 0x1p-12) - 2 * bent_.longest_inverse * quantum
                                    : std::sqrt(square) * (1 - 0x1p-20) - (weighted_ ? 2 : 1) * quantum;
    return covered > 0 ? covered * covered : 0;
}

template <class Isa>
bool StarWalk<Isa>::add_candidate(std::int32_t id) {
    CandidatePlanes& c = candidates_;
    if (c.count == CandidatePlanes::capacity) return false;
    Four n;
    double h, square;
    plane_through(id, n, h, square);
    const double length = std::sqrt(square);
    if (!(length < longest_normal)) return false;
    if (length * (1 + 0x1p-20) > longest_) set_longest(length * (1 + 0x1p-20));
    const int i = c.count++;
    c.nx[i] = static_cast<float>(n.x[0]);
    c.ny[i] = static_cast<float>(n.x[1]);
    c.nz[i] = static_cast<float>(n.x[2]);
    c.h[i] = static_cast<float>(h);
    c.id[i] = id;
    if (c.count % 16 == 1) pad_candidates();
    return true;
}

// Removes the candidates from beyond the window that are not planes of the cell so far. A search finds them again.
template <class Isa>
void StarWalk<Isa>::forget_candidates() {
    CandidatePlanes& c = candidates_;
    int to = selected_;
    for (int i = selected_; i < c.count; ++i) {
        bool used = false;
        for (int slot = 0; slot < planes_; ++slot) used |= ((planes_known_ >> slot) & 1) != 0 && id_[slot] == c.id[i];
        if (!used) continue;
        for (float* axis : {c.nx, c.ny, c.nz, c.h}) axis[to] = axis[i];
        c.id[to++] = c.id[i];
    }
    c.count = to;
    pad_candidates();
}

template <class Isa>
void StarWalk<Isa>::pad_candidates() {
    CandidatePlanes& c = candidates_;
    for (int k = c.count; k < c.count + 16; ++k) {
        c.nx[k] = c.ny[k] = c.nz[k] = 0;
        c.h[k] = CandidatePlanes::never;
    }
}

template <class Isa>
bool StarWalk<Isa>::is_candidate(std::int32_t id) const {
    bool any = false;  // in vectors
    for (int i = 0; i < candidates_.count; ++i) any |= candidates_.id[i] == id;
    return any;
}

// The nearest seed is a neighbor, and the midpoint lies inside their face. Any way along the face leads to an edge.
template <class Isa>
bool StarWalk<Isa>::begin_anywhere() {
    if (!have_candidates_ && !gather_candidates()) return false;
    if (candidates_.count == 0 && !add_nearest_wall()) return false;
    const CandidatePlanes& c = candidates_;
    if (!weighted_) return begin_at_face(static_cast<int>(std::min_element(c.h, c.h + c.count) - c.h));
    for (int i = 0; i < c.count; ++i)
        value_[i] = c.h[i] / std::sqrt(c.nx[i] * c.nx[i] + c.ny[i] * c.ny[i] + c.nz[i] * c.nz[i]);
    const auto nearest = std::min_element(value_.begin(), value_.begin() + c.count);
    if (*nearest < parallel * static_cast<float>(longest_)) return begin_outside();
    return begin_at_face(static_cast<int>(nearest - value_.begin()));
}

// The seed lies outside of its cell, or nearly. The clipper finds an edge, or that the cell is empty. It takes the
// candidate that owns the middle of what is left, until none does, then those that own a vertex. A few are enough.
template <class Isa>
bool StarWalk<Isa>::begin_outside() {
    const std::int32_t own = own_id_;
    probe_.start(base_.point, *domain_, own);
    bool at_vertex = false;
    for (int tries = 0; tries < max_owners; ++tries) {
        std::array<double, 3> at = probe_.middle();
        std::array<const CellPlane*, 3> planes{};
        if (at_vertex) planes = probe_.corner_planes(nearest_vertex(at));
        std::int32_t owner = owner_of(at, planes);
        if (owner < 0 && !at_vertex) {
            const std::optional<std::int32_t> done = done_owner_of(at);
            if (!done) return false;
            owner = *done;
        }
        if (owner >= 0 && probe_.clip(owner, exact_plane(owner))) {
            if (!probe_.empty()) continue;
        } else if (at_vertex && owner >= 0) {
            return false;  // rounding hides which planes meet there
        } else if (!at_vertex) {
            probe_.drop_if_flat();
        }
        if (probe_.empty()) {
            used_exact_ = probe_.used_exact();
            return empty_ = true;
        }
        if (!std::exchange(at_vertex, true)) continue;
        // In a periodic box the cell begins with images of the seed, which are not candidates.
        // The clipper decides ties.
        if (probe_.met_tie() || std::ranges::any_of(planes, [own](const CellPlane* plane) { return plane->id == own; }))
            return false;
        const int a = new_slot(planes[0]->id), b = new_slot(planes[1]->id);
        start_ = edge_of(a, b);
        return true;
    }
    return false;
}

// Returns the vertex of probe_ that is nearest to a place, and moves the place there. Those on images of the seed come
// last.
template <class Isa>
int StarWalk<Isa>::nearest_vertex(std::array<double, 3>& place) const {
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    bool inner = false;
    for (int slot = 0; slot < probe_.slots(); ++slot) {
        if (!probe_.alive(slot)) continue;
        const auto planes = probe_.corner_planes(slot);
        const bool own = std::ranges::any_of(planes, [this](const CellPlane* plane) { return plane->id == own_id_; });
        const auto x = probe_.position(slot);
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) square += (x[k] - place[k]) * (x[k] - place[k]);
        if (nearest >= 0 && (own == inner ? own : square >= least)) continue;
        nearest = slot;
        least = square;
        inner = !own;
    }
    place = probe_.position(nearest);
    return nearest;
}

// Returns a done seed whose power at a place relative to the seed is less than that of the seed, about, or -1. Returns
// nothing where very many may have.
template <class Isa>
std::optional<std::int32_t> StarWalk<Isa>::done_owner_of(const std::array<double, 3>& place) {
    Four x = move_;
    for (std::size_t k = 0; k < 3; ++k) x.x[k] += place[k] * scale_;
    std::int32_t owner = -1;
    const bool ended = for_done_seeds(ball_around(x, dot(wide(x), wide(x))), [&](std::int32_t id) {
        Four n;
        double h, square;
        plane_through(id, n, h, square);
        if (dot(wide(n), wide(x)) > h) owner = id;
        return owner >= 0;
    });
    if (ended && owner < 0) return std::nullopt;
    return owner;
}

// Returns the seed among the candidates with the least power at a place relative to the seed, about, if that is less
// than the power of the seed, or -1. Skips some planes.
template <class Isa>
std::int32_t StarWalk<Isa>::owner_of(const std::array<double, 3>& place,
                                     const std::array<const CellPlane*, 3>& skipped) {
    const CandidatePlanes& c = candidates_;
    float x[3];
    for (std::size_t k = 0; k < 3; ++k) x[k] = static_cast<float>(place[k] * scale_ + move_.x[k]);
    for (int i = 0; i < c.count; ++i) {
        const float value = c.h[i] - (c.nx[i] * x[0] + c.ny[i] * x[1] + c.nz[i] * x[2]);
        value_[i] = c.id[i] >= 0 ? value : 0;
    }
    for (;;) {
        const auto owner = std::min_element(value_.begin(), value_.begin() + c.count) - value_.begin();
        if (!(value_[owner] < 0)) return -1;
        const std::int32_t id = c.id[owner];
        const auto is_skipped = [&](const CellPlane* plane) { return plane != nullptr && plane->id == id; };
        if (std::ranges::none_of(skipped, is_skipped)) return id;
        value_[owner] = 0;
    }
}

template <class Isa>
bool StarWalk<Isa>::begin_at_face(int nearest) {
    const CandidatePlanes& c = candidates_;
    const int a = new_slot(c.id[nearest]);
    need_plane(a);
    const auto& n = n_[a].x;
    const double foot = h_[a] / square_[a];
    const double skew[3] = {0.61803398875 * n[1], 0.7548776662 * n[2],
                            0.5698402910 * n[0] + std::sqrt(0.5 * square_[a])};
    Ray ray;
    float size = 0;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        ray.o[k] = static_cast<float>(foot * n[k]);
        ray.d[k] = static_cast<float>(n[i] * skew[j] - n[j] * skew[i]);
        size += std::abs(ray.d[k]);
    }
    ray.limit = parallel * size * static_cast<float>(longest_);
    int hit = first_hit(ray);
    if (hit < 0) {
        const Wide from{ray.o[0], ray.o[1], ray.o[2], 0}, against{-ray.d[0], -ray.d[1], -ray.d[2], 0};
        Line line{};
        wide(line.ab) = against;
        cross(against, from, wide(line.e));
        line.norms2 = dot(against, against);
        line.longest2 = square_[a];
        if (!add_along(line, {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(a)})) return false;
        hit = first_hit(ray);
    }
    if (hit < 0) return false;
    start_ = edge_of(a, new_slot(c.id[hit]));
    return true;
}

// Returns the bits of those of eight seeds beyond the candidates that may cut off the vertex.
template <class Isa>
unsigned StarWalk<Isa>::find_inside(std::size_t begin, const GroupTest& test) const {
    if (weighted_) return find_inside_weighted(begin, test);
    return Isa::inside_ball(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], test, covered_);
}

template <class Isa>
unsigned StarWalk<Isa>::find_inside_weighted(std::size_t begin, const GroupTest& test) const {
    double excess[box_fan];
    const double *x = &seeds_.x[begin], *y = &seeds_.y[begin], *z = &seeds_.z[begin], *w = &seeds_.weights[begin];
    const auto& [a, b, c, free] = move_.x;
    for (int i = 0; i < box_fan; ++i) {
        const double nx = (x[i] - p_[0]) * scale_, ny = (y[i] - p_[1]) * scale_, nz = (z[i] - p_[2]) * scale_;
        const double square = nx * nx + ny * ny + nz * nz, heavier = (w[i] - weight_) * scale_ * scale_;
        const double tilted = 2 * (nx * a + ny * b + nz * c), more = heavier - tilted;
        const double slack = 8 * margin * (square + std::abs(more)) + 8 * unit * (std::abs(heavier) + std::abs(tilted));
        excess[i] = nx * test.v[0] + ny * test.v[1] + nz * test.v[2] - 0.5 * (square - more) + slack + test.slack;
    }
    unsigned inside = 0;
    // NaN if the seed is padding, infinitely far away.
    for (int i = 0; i < box_fan; ++i) inside |= static_cast<unsigned>(excess[i] >= 0) << i;
    return inside;
}

// Calls visit(id) for the done seeds in groups near a ball, until it returns true or the groups are very many, as where
// all cells meet in a place. Returns whether it ended so.
template <class Isa>
template <class Visit>
bool StarWalk<Isa>::for_done_seeds(const Ball& ball, Visit visit) {
    int groups = 0;
    std::size_t nodes = 1;
    nodes_[0] = {hierarchy_.top_level(), 0};
    while (nodes > 0) {
        const auto [level, index] = nodes_[--nodes];
        unsigned near = near_boxes(level, index, ball);
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            const std::size_t begin = Hierarchy::first_seed(level, child);
            const std::size_t end = Hierarchy::first_seed(level, child + 1);
            if (!cells_.overlaps(begin, end)) continue;
            if (level > 0) {
                nodes_[nodes++] = {level - 1, child};
                continue;
            }
            if (++groups > max_done_groups) return true;
            for (std::size_t i = begin; i < end; ++i)
                if (cells_.holds(static_cast<std::int64_t>(i)) && cells_.done(i) && visit(static_cast<std::int32_t>(i)))
                    return true;
        }
    }
    return false;
}

// In a power diagram done seeds matter to a cell that has no vertex yet. If the cell is not empty, none of them is its
// neighbor and none cuts off its first vertex. If it is empty, some of them cover all of space. Returns true when the
// cell is empty or the clipper must decide.
template <class Isa>
bool StarWalk<Isa>::is_hidden(const std::int32_t* three, const Third& third, const Four& x) {
    empty_ = false;
    return for_done_seeds(ball_around(x, third.length2), [&](std::int32_t id) {
        const int side = side_of(id, three, third, x);
        empty_ = side > 0;
        return side >= 0;
    });
}

template <class Isa>
typename StarWalk<Isa>::Ball StarWalk<Isa>::ball_around(const Four& x, double length2) const {
    Ball ball;
    double size = 0;
    for (int k = 0; k < 3; ++k) {
        const double offset = x.x[k] * unscale_;
        ball.center.lower[k] = ball.center.upper[k] = p_[k] + offset;
        size = std::max(size, std::abs(p_[k]) + std::abs(offset));
    }
    const double x2 = dot(wide(x), wide(x));
    ball.radius = in_places(bounds::widest_reach(x2), size);
    if (!weighted_) return ball;
    const double length = std::sqrt(length2);
    ball.radius = in_places(bounds::max_distance(std::sqrt(x2), length), size);
    ball.off = in_places(2 * margin * length, size);
    return ball;
}

template <class Isa>
unsigned StarWalk<Isa>::near_boxes(std::int32_t level, std::uint32_t index, const Ball& ball) const {
    const double square = ball.radius * ball.radius;
    const BoxBlock& boxes = hierarchy_.block(level, index);
    return weighted_ ? Isa::near_heavier(boxes, hierarchy_.weight_bounds(level, index), ball.center,
                                         {own_tilt_, ball.off, square, 0})
                     : Isa::near_boxes(boxes, ball.center, square);
}

template <class Isa>
int StarWalk<Isa>::side_of(std::int32_t id, const std::int32_t* three, const Third& third, const Four& x) {
    if (const int sure = sure_side(id, third, relative_error(third), x); sure != 0) return sure;
    used_exact_ = true;
    return exact::side_of_vertex(base_.point, exact_plane(three[0]), exact_plane(three[1]), exact_plane(three[2]),
                                 exact_plane(id));
}

// Visits the groups in boxes that pass a test, some boxes of a level at once: their tests overlap in the processor. The
// lowest pending boxes come first, because the test may become stricter with a visit. test(level): the test of the
// blocks of a level. visit(groups): returns false to stop.
template <class Isa>
template <class Test, class Visit>
void StarWalk<Isa>::search_groups(Test test, Visit visit) {
    const int root = std::max(0, hierarchy_.top_level() - 1);
    pending_[root].count = 1;
    pending_[root].at[0] = 0;
    for (int level = root; level <= root;) {
        Pending& from = pending_[level];
        const int batch = std::min(from.count, max_batch);
        from.count -= batch;
        const std::uint32_t *index = from.at + from.count, *const end = index + batch;
        std::uint32_t* const begin = level > 0 ? pending_[level - 1].at : groups_.data();
        std::uint32_t* to = begin;
        const auto near = test(level);
        for (; index != end; ++index)
            if (level > 0 || !cells_.block_done(*index)) to += Isa::list_bits(near(*index), *index * box_fan, to);
        if (level == 0) {
            if (!visit(std::span<const std::uint32_t>(begin, to))) return;
        } else {
            pending_[--level].count = static_cast<int>(to - begin);
        }
        while (level <= root && pending_[level].count == 0) ++level;
    }
}

// Finds the seeds of some groups in the ball that are not done. Returns the number of groups that have any. Without
// branches, which would be mispredicted.
template <class Isa>
int StarWalk<Isa>::find_all_inside(std::span<const std::uint32_t> groups, const GroupTest& test, Found* found) const {
    int open = 0, count = 0;
    for (const std::uint32_t group : groups) {
        found[open].group = group;
        open += static_cast<int>(!cells_.group_done(group));
    }
    for (int i = 0; i < open; ++i) {
        const std::uint32_t group = found[i].group;
        const unsigned inside = find_inside(std::size_t{group} * group_size, test);
        found[count] = {group, inside};
        count += static_cast<int>(inside != 0);
    }
    return count;
}

// Removes the own seed and three others from those found. Returns the number of groups that have more.
template <class Isa>
int StarWalk<Isa>::leave_out(const std::int32_t* three, int count, Found* found) const {
    const std::int32_t ids[4] = {own_id_, three[0], three[1], three[2]};
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        auto [group, inside] = found[i];
        for (const std::int32_t id : ids) {
            const std::uint32_t place = static_cast<std::uint32_t>(id) - group * static_cast<std::uint32_t>(group_size);
            inside &= ~(static_cast<unsigned>(place < group_size) << (place % group_size));
        }
        found[kept] = {group, inside};
        kept += static_cast<int>(inside != 0);
    }
    return kept;
}

// Visits the groups near a ball. The ball may shrink meanwhile.
template <class Isa>
template <class Visit>
void StarWalk<Isa>::search_ball(const Ball& ball, Visit visit) {
    if (weighted_) {
        search_groups(
            [&](int level) {
                const BoxBlock* const boxes = &hierarchy_.block(level, 0);
                const WeightBlock* const weights = &hierarchy_.weight_bounds(level, 0);
                const HeavierTest near(own_tilt_, ball.off, ball.radius * ball.radius, 0);
                return [=, &center = ball.center](std::uint32_t index) {
                    return Isa::near_heavier(boxes[index], weights[index], center, near);
                };
            },
            visit);
    } else {
        search_groups(
            [&](int level) {
                const BoxBlock* const boxes = &hierarchy_.block(level, 0);
                const Box center{ball.center.lower, ball.center.lower};
                const double square = ball.radius * ball.radius;
                return [=](std::uint32_t index) { return Isa::near_boxes(boxes[index], center, square); };
            },
            visit);
    }
}

// Returns a group whose box is near a vertex: the nearest box of each level leads to the next. Returns no_group if that
// is too far away for numbers.
template <class Isa>
std::uint32_t StarWalk<Isa>::group_near(const Four& x) const {
    constexpr double too_far = 1e300;  // as places without a box
    using Longs __attribute__((vector_size(32), may_alias)) = std::int64_t;
    const auto lesser = [](const Wide& a, const Wide& b, Wide& out) { out = a < b ? a : b; };
    std::uint32_t node = 0;
    for (int level = std::max(0, hierarchy_.top_level() - 1); level >= 0; --level) {
        const BoxBlock& boxes = hierarchy_.block(level, node);
        Wide squares[2]{};
        for (std::size_t k = 0; k < 3; ++k) {
            const double at = p_[k] + x.x[k] * unscale_;
            for (int half = 0; half < 2; ++half) {
                const auto& lower = reinterpret_cast<const Wide&>(boxes.lower[k][4 * half]);
                const auto& upper = reinterpret_cast<const Wide&>(boxes.upper[k][4 * half]);
                const Wide below = lower - at, above = at - upper;
                Wide gap = below > above ? below : above;
                gap = gap < 0 ? Wide{} : gap;
                squares[half] += gap * gap;
            }
        }
        // The index of a box takes the place of the last bits.
        Wide nearest;
        for (int half = 0; half < 2; ++half) {
            lesser(squares[half], Wide{} + too_far, squares[half]);  // not NaN
            Longs& named = reinterpret_cast<Longs&>(squares[half]);
            named = (named & -box_fan) | (Longs{0, 1, 2, 3} + 4 * half);
        }
        lesser(squares[0], squares[1], nearest);
        lesser(nearest, __builtin_shufflevector(nearest, nearest, 2, 3, 0, 1), nearest);
        const double least = std::min(nearest[0], nearest[1]);
        if (!(least < 0.5 * too_far)) return no_group;
        node = node * box_fan + static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(least) % box_fan);
    }
    return node;
}

// Adds seeds of the window that may cut off a vertex within its reach. In floats, as the candidates.
//
// Twice H - N.X is computed at once, with N.(turn - 2 X): rounding is at most twice as large.
template <class Isa>
bool StarWalk<Isa>::add_of_window(const Four& x, double x2, const std::int32_t* three, int& added) {
    constexpr int lanes = 8, step = 64;                                               // most steps have none
    const double longest = std::max(longest_, longest_of_window * window_.extent());  // of seeds not in the window too
    const bounds::FloatMargin m = bounds::float_margin(
        longest, tilt_length_ * scale_, weight_rounding_ + bounds::turn_rounding(2 * turned_ * scale_, longest));
    const auto limit = static_cast<float>(4 * (m.by_square * x2 + m.constant));
    float along[3];
    for (std::size_t k = 0; k < 3; ++k) along[k] = static_cast<float>(turn_.x[k] * scale_ - 2 * x.x[k]);
    const auto [px, py, pz] = own_place_;
    const WindowSeeds seeds = window_.seeds();
    const auto excess = [&](int i) {
        const auto nx = static_cast<float>(seeds.x[i] - px), ny = static_cast<float>(seeds.y[i] - py),
                   nz = static_cast<float>(seeds.z[i] - pz);
        return nx * (nx + along[0]) + ny * (ny + along[1]) + nz * (nz + along[2]) + (own_weight_ - seeds.weight[i]);
    };
    for (int begin = 0; begin < seeds.count; begin += step) {
        const int end = std::min(begin + step, seeds.count);
        float least[lanes];
        std::fill_n(least, lanes, std::numeric_limits<float>::infinity());
        for (int i = begin; i < end; i += lanes)
            for (int k = 0; k < lanes; ++k) {
                const float one = excess(i + k);
                least[k] = one < least[k] ? one : least[k];
            }
        if (*std::min_element(least, least + lanes) > limit) continue;
        for (int i = begin; i < end; ++i) {
            if (excess(i) > limit) continue;
            const std::int32_t id = seeds.id[i];
            if (id == three[0] || id == three[1] || id == three[2] || is_candidate(id)) continue;
            if (!add_candidate(id)) return false;
            if (++added == max_new_seeds) return true;
        }
    }
    return true;
}

// Adds seeds beyond the candidates that may lie in the ball around the vertex, which shrinks with each.
//
// The edge is searched again only after max_new_seeds of them. It begins at a proven vertex, where n.x - h <= 0 for all
// seeds. Along the edge n.x - h is linear. If it is >= 0 at some vertex, it is so at all vertices behind, and the
// search around those has found the seed.
template <class Isa>
bool StarWalk<Isa>::add_inside(const Line& line, double length2, const Four& vertex, const std::int32_t* three,
                               int& added) {
    Four x = vertex;
    Ball ball;
    GroupTest test{p_, scale_, {}, 0};
    auto look_around = [&](double length2) {
        ball = ball_around(x, length2);
        for (int k = 0; k < 3; ++k) test.v[k] = x.x[k];
        test.slack =
            weighted_ ? 8 * margin * length2 + bounds::image_step * tilt_length_ * scale_ : 2 * margin * length2;
    };
    look_around(length2);
    bool room = true;
    const auto visit = [&](std::span<const std::uint32_t> groups) {
        Found found[max_found];
        const int count = leave_out(three, find_all_inside(groups, test, found), found);
        bool moved = false;
        for (int i = 0; i < count; ++i) {
            const std::size_t begin = std::size_t{found[i].group} * group_size;
            unsigned inside = found[i].inside;
            if (moved) inside &= find_inside(begin, test);
            while (inside != 0) {
                const auto id = static_cast<std::int32_t>(begin) + std::countr_zero(inside);
                inside &= inside - 1;
                Third third;
                Four nearer;
                plane_through(id, third.n, third.h, third.square);
                if (is_candidate(id)) continue;  // not certainly inside
                const double excess = dot(wide(third.n), wide(x)) - third.h;
                if (!add_candidate(id)) return room = false;
                if (++added == max_new_seeds) return false;
                if (excess > 0 && solve(line, third, nearer)) {
                    x = nearer;
                    look_around(error_length2(line, third, dot(wide(x), wide(x))));
                    inside &= find_inside(begin, test);
                    moved = true;
                }
            }
        }
        return true;
    };
    // A large ball may hold very many seeds. Those near its center cut off nearly as much of the edge as all together.
    // Mostly it holds none.
    if (4 * length2 > far_share * covered_) {
        bool any = false;
        search_ball(ball, [&](std::span<const std::uint32_t> groups) {
            Found found[max_found];
            any = leave_out(three, find_all_inside(groups, test, found), found) > 0;
            return !any;
        });
        if (!any) return true;
        for (std::uint32_t last = no_group;;) {
            const std::uint32_t group = group_near(x);
            if (group == std::exchange(last, group) || group == no_group) break;
            if (!visit({&last, 1})) return room;
        }
    }
    search_ball(ball, visit);
    return room;
}

// Visits places along a ray that are farther and farther from the seed, beyond the candidates. nearest: the place of
// its line that is nearest to the seed. visit(x, |x|^2): returns true to stop. Returns whether it has.
template <class Isa>
template <class Visit>
bool StarWalk<Isa>::step_along(const Wide& nearest, const Wide& along, Visit visit) const {
    constexpr int max_steps = 12;
    const double square = dot(along, along), start2 = dot(nearest, nearest);
    double length2 = std::max({covered_, 0.25 * longest_ * longest_, 2 * start2});
    for (int step = 0; step < max_steps; ++step, length2 *= 4) {
        Four x;
        wide(x) = nearest + std::sqrt((length2 - start2) / square) * along;
        // Planes that are parallel have no line: NaN.
        if (!(dot(wide(x), wide(x)) < infinity)) return false;
        if (visit(x, length2)) return true;
    }
    return false;
}

// Adds seeds or a wall from beyond the candidates that cut off an edge far from the seed. Returns false if there are
// none.
template <class Isa>
bool StarWalk<Isa>::add_along(const Line& line, const OpenEdge& edge) {
    Wide nearest;
    cross(wide(line.e), wide(line.ab), nearest);
    nearest *= 1 / dot(wide(line.ab), wide(line.ab));
    const std::int32_t three[3] = {id_[edge.a], id_[edge.b], id_[edge.a]};
    int added = 0;
    bool room = true;
    step_along(nearest, -wide(line.ab), [&](const Four& x, double x2) {
        const double length2 = error_length2(line, {}, x2);
        room = add_wall_before(x, length2, false, -wide(line.ab), added) &&
               (added > 0 || add_inside(line, length2, x, three, added));
        return !room || added > 0;
    });
    return room && added > 0;
}

// ---- From vertex to vertex along the edges ----

// planes: planes_, in a register if possible. Without a branch, which would be mispredicted.
template <class Isa>
int StarWalk<Isa>::slot_of(std::int32_t local, int& planes) {
    const unsigned known = slot_[static_cast<std::size_t>(local)], next = static_cast<unsigned>(planes);
    const bool is_new = known >= next;
    const unsigned slot = is_new ? next : known;
    slot_[static_cast<std::size_t>(local)] = static_cast<std::uint16_t>(slot);
    local_[static_cast<std::size_t>(planes)] = local;
    planes = static_cast<int>(next + is_new);
    return static_cast<int>(slot);
}

// Sets the edges a -> b, b -> c, c -> a of a vertex.
template <class Isa>
template <Star::Keep Kept>
void StarWalk<Isa>::link_corner(int a, int b, int c, int vertex) {
    const std::uint64_t bit_a = 1ull << a, bit_b = 1ull << b, bit_c = 1ull << c;
    out_[a] |= bit_b;
    in_[a] |= bit_c;
    out_[b] |= bit_c;
    in_[b] |= bit_a;
    out_[c] |= bit_a;
    in_[c] |= bit_b;
    if constexpr (Kept != Keep::nothing) {
        shape_.a[vertex] = static_cast<std::uint8_t>(a);
        shape_.b[vertex] = static_cast<std::uint8_t>(b);
        shape_.c[vertex] = static_cast<std::uint8_t>(c);
    }
    if constexpr (Kept == Keep::places)
        from_vertex_[a][b] = from_vertex_[b][c] = from_vertex_[c][a] = static_cast<std::uint8_t>(vertex);
}

template <class Isa>
void StarWalk<Isa>::clear_planes() {
    std::uint16_t* const slots = slot_.data();
    const std::uint16_t none = none_;
    // Those behind the last plane are of earlier cells.
    for (int p = 0; p < planes_; p += lane_step) {
        for (int k = p; k < p + lane_step; ++k) out_[k] = in_[k] = 0;
#pragma GCC unroll 8
        for (int k = p; k < p + lane_step; ++k) slots[local_[k]] = none;
    }
    planes_ = 0;
}

template <class Isa>
bool StarWalk<Isa>::build(std::size_t seed) {
    seed_ = seed;
    own_id_ = static_cast<std::int32_t>(seed);
    p_ = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    base_ = {p_, {}};
    if (weighted_) weight_ = seeds_.weights[seed];
    if (any_wrapped_) {
        const auto& low = seeds_.images->low(own_id_);
        low_ = {{low[0], low[1], low[2], 0}};
        base_ = seeds_.images->base(seed);
        moved_ = !seeds_.images->is_exact(seed);
    }
    const bool done = build_cell<false>();
    if (done) cells_.set_done(seed);
    if (have_candidates_) {  // it is hidden
        if (!done) window_.show(seed, own_place_[0], own_weight_);
    } else if (done && window_open_ && window_home_ == seed / Window::home_seeds) {
        window_.hide(seed);
    }
    return done;
}

template <class Isa>
bool StarWalk<Isa>::build(const Probe& probe) {
    ++seed_;  // invalidates the walls of another seed
    own_id_ = static_cast<std::int32_t>(seeds_.places());
    p_ = probe.place.at;
    base_ = {probe.x, probe.place.shift};
    const auto& low = probe.place.low;
    low_ = {{low[0], low[1], low[2], 0}};
    if (weighted_) weight_ = probe.weight;
    if (seeds_.images != nullptr) {
        moved_ = low != std::array<double, 3>{};
        any_wrapped_ = seeds_.images->any_wrapped() || moved_;
        any_rough_ = seeds_.images->any_rough();
    }
    return build_cell<true>() && !empty_ && !may_coincide();
}

template <class Isa>
template <bool Alone>
bool StarWalk<Isa>::build_cell() {
    clear_planes();
    own_local_ = cells_.local(own_id_);
    vertices_ = ends_ = 0;
    planes_known_ = open_ = 0;
    scale_ = unscale_ = 1;
    move_ = {};
    have_candidates_ = used_exact_ = met_tie_ = false;
    power_found_ = min_power;
    ties_.clear();
    tie_slots_.clear();
    if (keep_ == Keep::nothing) return complete<Keep::nothing, Alone>();
    return keep_ == Keep::corners ? complete<Keep::corners, Alone>() : complete<Keep::places, Alone>();
}

// Alone: no other cell has handed over vertices.
template <class Isa>
template <Star::Keep Kept, bool Alone>
bool StarWalk<Isa>::complete() {
    if constexpr (!Alone)
        if (!read_known<Kept>()) return false;
    empty_ = false;
    reached_ = 0;
    near_misses_ = 0;
    largest_distance2_ = largest_length2_ = 0;
    if (vertices_ == 0 && !find_first<Kept>()) {
        if (empty_) faces_ = edges_ = 0;
        return empty_;
    }
    if (open_ != 0 && !have_candidates_ && !gather_candidates()) return false;
    find_open_planes();
    while (open_ != 0) {
        if (candidates_.count > crowded) forget_candidates();
        const int a = std::countr_zero(open_), b = std::countr_zero(open_edges(a));
        OpenEdge edges[2] = {edge_of(a, b)};
        Line lines[2];
        std::int32_t ids[2];
        draw_line(edges[0], lines[0]);
        const std::uint64_t others = open_ & ~(1ull << a | 1ull << b);
        const bool guessed = others != 0 && (others & (others - 1)) == 0;
        if (guessed) {  // most likely the three meet in the last vertex
            ids[0] = cells_.id(local_[std::countr_zero(others)]);
        } else {
            // Two edges at once: their searches overlap in the processor. They have no plane in common, so the vertex
            // of one does not close the other.
            const std::uint64_t apart = others & ~(in_[a] & ~out_[a]);
            const int c = std::countr_zero(apart != 0 ? apart : open_);
            edges[1] = edge_of(c, std::countr_zero(open_edges(c)));
            draw_line(edges[1], lines[1]);
            Ray rays[2];
            int hits[2];
            for (int k = 0; k < 2; ++k) aim(lines[k], rays[k]);
            Isa::first_hits(candidates_, candidates_.near, rays, 2, hits);
            for (int k = 0; k < 2; ++k) ids[k] = hits[k] < 0 ? no_plane : candidates_.id[hits[k]];
        }
        for (int k = 0, count = guessed ? 1 : 2; k < count; ++k)
            if (is_open(edges[k]) && !close<Kept>(edges[k], lines[k], ids[k], guessed)) return false;
    }
    const double needed = reached_ * unscale_ * unscale_;
    if (needed > 0) {
        adapt_reach(needed);
        power_found_ = std::max(power_found_, weighted_ ? power_within(largest_distance2_, largest_length2_)
                                                        : bounds::power((1 + 4 * margin) * 0.25 * needed, weight_));
    }
    return collect_faces();
}

// Learns from a cell. needed: the largest squared security radius of the vertices found. Not inlined, which would cost
// complete() registers.
template <class Isa>
void StarWalk<Isa>::adapt_reach(double needed) {
    reach_margin_ = std::clamp(reach_margin_ + margin_step * (near_misses_ - allowed_misses), min_reach_margin,
                               weighted_ ? max_weighted_margin : max_reach_margin);
    // Long cells may reach farther than seeds are worth a search.
    if (needed < typical_reach_ || candidates_.count < enough_candidates)
        typical_reach_ += (std::min(needed, 4 * typical_reach_) - typical_reach_) / 16;
}

// Finds the first vertex of a cell that has none. The starting edge is a guess. It may have no end while seeds near it
// are not candidates, or a plane that is parallel to it may cut it off, which then takes the place of its second plane.
template <class Isa>
template <Star::Keep Kept>
bool StarWalk<Isa>::find_first() {
    int candidates = 0;
    cut_by_ = no_plane;
    for (int tries = 0; tries < max_starts; ++tries) {
        start_failed_ = false;
        if (tries > 0 && candidates_.count == candidates && cut_by_ != no_plane) {
            start_ = edge_of(start_.a, new_slot(cut_by_));
        } else if (!begin_anywhere() || empty_ || candidates_.count == candidates) {
            return false;
        }
        candidates = candidates_.count;
        cut_by_ = no_plane;
        need_plane(start_.a);
        need_plane(start_.b);
        Line line;
        draw_line(start_, line);
        if (close<Kept>(start_, line, no_plane, false)) return true;
        if (!start_failed_) return false;
    }
    return false;
}

template <class Isa>
void StarWalk<Isa>::read_position(const KnownVertex& known, int vertex) {
    numbers_[vertex] = known.vertex;
    const std::size_t owner = cells_.owner(known.vertex);
    Wide from = wide(cells_.seed_position(owner)) - Wide{p_[0], p_[1], p_[2], 0};
    if (cells_.has_lows()) from += wide(cells_.seed_low(owner)) - wide(low_);
    wide(position_[vertex]) = wide(cells_.position(known.vertex)) + from;
}

template <class Isa>
template <Star::Keep Kept>
bool StarWalk<Isa>::read_known() {
    make_room(cells_.locals());
    const auto handed = cells_.known(seed_);
    if (const double power = cells_.power_of_ties(seed_); power != Neighborhood::no_tie) {
        used_exact_ = met_tie_ = true;
        power_found_ = power;
    }
    if (handed.size() > max_vertices - 4) return false;
    int planes = 0, vertices = 0, ties = 0;
    for (const KnownVertex& known : handed) {
        if (planes > max_planes - 4) {
            planes_ = planes;
            return false;
        }
        if (known.is_tie()) {
            planes_ = planes;
            if (!read_tie(known, vertices++)) return false;
            planes = planes_;
            ++ties;
            continue;
        }
        if constexpr (Kept == Keep::places) read_position(known, vertices);
        const int a = slot_of(known.cells[0], planes), b = slot_of(known.cells[1], planes),
                  c = slot_of(known.cells[2], planes);
        link_corner<Kept>(a, b, c, vertices++);
    }
    planes_ = planes, vertices_ = vertices, ends_ += 3 * (vertices - ties);
    find_open();
    return true;
}

// Finds the planes that vertices of other cells leave open.
template <class Isa>
void StarWalk<Isa>::find_open() {
    std::uint64_t open = 0;
    for (int p = 0; p < planes_; p += lane_step)
        for (int k = p; k < p + lane_step; ++k) open |= open_bit(k);
    open_ = open;
}

template <class Isa>
bool StarWalk<Isa>::read_tie(const KnownVertex& known, int vertex) {
    if (keep_ == Keep::places) read_position(known, vertex);
    if (known.is_ordered()) return link_ring(cells_.tie(known), vertex);
    tied_cells_.clear();
    for (const std::int32_t cell : cells_.tie(known))
        if (cell != own_local_) tied_cells_.push_back(cell);
    return link_polygon(tied_cells_, vertex);
}

// Faces are the planes that have edges. A plane that was tried as a start may have none.
template <class Isa>
bool StarWalk<Isa>::collect_faces() {
    int edges = 0, faces = 0;
    const int planes = planes_;
    for (int p = 0; p < planes; ++p) {
        face_[faces] = cells_.id(local_[p]);
        face_slot_[faces] = static_cast<std::uint8_t>(p);
        const int own = std::popcount(out_[p]);
        edges += own;
        faces += own != 0 ? 1 : 0;
    }
    faces_ = faces;
    edges_ = edges / 2;
    return edges == ends_;  // no edge was found twice in the same direction
}

template <class Isa>
void StarWalk<Isa>::draw_line(const OpenEdge& edge, Line& line) const {
    const Wide &na = wide(n_[edge.a]), &nb = wide(n_[edge.b]);
    const double square_a = square_[edge.a], square_b = square_[edge.b];
    cross(na, nb, wide(line.ab));
    wide(line.e) = h_[edge.a] * nb - h_[edge.b] * na;
    line.square = dot(wide(line.ab), wide(line.ab));
    line.norms2 = square_a * square_b;
    line.longest2 = std::max(square_a, square_b);
}

// Returns false when the planes are too nearly parallel, or too large or small to square.
template <class Isa>
bool StarWalk<Isa>::is_drawn(const OpenEdge& edge, const Line& line) const {
    return square_[edge.a] > smallest_square && square_[edge.b] > smallest_square && line.norms2 < largest_product &&
           line.square * worst_condition2 > line.norms2;
}

// In floats, because the hit is a guess.
template <class Isa>
void StarWalk<Isa>::aim(const Line& line, Ray& ray) const {
    // e x ab / |ab|^2 is the point of the line that is nearest to the seed.
    Wide across;
    cross(wide(line.e), wide(line.ab), across);
    narrow(across * (1 / line.square), ray.o);
    // About 1 / |ab|, without waiting for a root. Only the size of the floats depends on it.
    const double inverse = std::bit_cast<double>(0x5fe6eb50c7b537a9 - (std::bit_cast<std::uint64_t>(line.square) >> 1));
    narrow(wide(line.ab) * -inverse, ray.d);
    ray.limit = parallel * static_cast<float>(longest_);
}

template <class Isa>
int StarWalk<Isa>::first_hit(const Ray& ray) {
    int hit;
    Isa::first_hits(candidates_, candidates_.count, &ray, 1, &hit);
    return hit;
}

// Cramer's rule: (ha nb x nc + hb nc x na + hc na x nb) / det = (e x nc + hc ab) / det. Returns false when the planes
// are too nearly parallel, or meet behind the start of the edge.
template <class Isa>
bool StarWalk<Isa>::solve(const Line& line, Third& c, Four& x) const {
    const double determinant = dot(wide(c.n), wide(line.ab));
    c.norms2 = line.norms2 * c.square;
    c.determinant2 = determinant * determinant;
    if (!(determinant < 0 && c.norms2 < worst_condition2 * c.determinant2 && c.square > smallest_square)) return false;
    Wide across;
    cross(wide(line.e), wide(c.n), across);
    wide(x) = (across + c.h * wide(line.ab)) * (1 / determinant);
    return true;
}

template <class Isa>
template <Star::Keep Kept>
bool StarWalk<Isa>::close(const OpenEdge& edge, const Line& line, std::int32_t id, bool guessed) {
    if (!is_drawn(edge, line)) return false;
    bool searched = false, cutting = false;  // cutting: the candidate cuts off the end of the edge so far
    for (int pick = 0; pick < max_picks; ++pick) {
        if (id == no_plane) {
            Ray ray;
            aim(line, ray);
            const int hit = first_hit(ray);
            cutting = guessed = false;
            if (hit < 0) {
                if (!add_along(line, edge)) return false;
                continue;
            }
            id = candidates_.id[hit];
        }
        const std::int32_t three[3] = {id_[edge.a], id_[edge.b], id};
        Third third;
        Four x;
        plane_through(id, third.n, third.h, third.square);
        const bool solved = solve(line, third, x);
        const double x2 = solved ? dot(wide(x), wide(x)) : infinity;
        third.length2 = error_length2(line, third, x2);
        if (!(x2 < longest_normal * longest_normal)) {
            if (guessed) {
                id = no_plane;
                continue;
            }
            start_failed_ = true;
            if (cutting) {
                cut_by_ = id;
                return false;
            }
            // The planes meet too far away. Walls or seeds cut off the edge before.
            int added = 0;
            if (solved && !add_wall_before(x, third.length2, false, -wide(line.ab), added)) return false;
            if (added == 0 && !add_along(line, edge)) return false;
            id = no_plane;
            continue;
        }
        float v[4];
        narrow(wide(x), v);
        v[3] = static_cast<float>(rounding_by_square_ * x2 + rounding_);
        const double reach2 = reach_squared(x2, third);
        double square = x2, search2 = reach2;
        if (!plain_ && is_bent_) {
            square = bent_square(x);
            search2 = bent_reach_squared(square, third);
        }
        const int count = in_reach(search2);
        tied_.clear();
        if (const int touching = Isa::touching(candidates_, count, v, three, 0); touching >= 0) {
            const int lane = examine(v, three, third, x, touching, count);
            cutting = lane >= 0;
            if (cutting) {
                id = candidates_.id[lane];
                guessed = false;
                continue;
            }
        }
        if ((search2 > covered_ && !searched) || !(reach2 < walls_within2_)) {
            int added = 0;
            if (!add_wall_before(x, third.length2, search2 <= covered_, -wide(line.ab), added)) return false;
            if (added == 0 && search2 > covered_ && !searched) {
                near_misses_ += 4 * square < missed_share * covered_ ? 1 : 0;
                if (!(search2 <= window_covered_ ? add_of_window(x, x2, three, added)
                                                 : add_inside(line, third.length2, x, three, added)))
                    return false;
                searched = vertices_ > 0 && added < max_new_seeds;
            }
            if (added > 0) {
                id = no_plane;
                continue;
            }
        }
        if (!plain_) {
            if (seeds_.images != nullptr && !(reach2 < images_within2_ && x2 > images_beyond2_) &&
                !images_known(x, x2, reach2, third.length2))
                return false;
            if (weighted_ && vertices_ == 0 && is_hidden(three, third, x)) return false;
            if (weighted_) {
                largest_distance2_ = std::max(largest_distance2_, distance_squared(x));
                largest_length2_ = std::max(largest_length2_, third.length2);
            }
        }
        reached_ = std::max(reached_, 4 * square);
        if (tied_.empty()) return add_vertex<Kept>(edge, id, third, x);
        if (!add_tie(edge, id, third, x)) return false;
        find_open_planes();
        return !is_open(edge);
    }
    return false;
}

// Returns an upper bound on the power of vertices from the squares of their distance from the seed and of their length.
template <class Isa>
double StarWalk<Isa>::power_within(double distance2, double length2) const {
    const double distance = bounds::max_distance(std::sqrt(distance2), std::sqrt(length2)) * unscale_;
    return bounds::power((1 + 4 * margin) * distance * distance, weight_);
}

// ---- Images that are not among the sorted ones ----

// Where heavy seeds far away are not in the window, each vertex is tested by itself.
template <class Isa>
void StarWalk<Isa>::find_sure_images() {
    image_shifts_known_ = false;
    if (window_.covered() > 0) sure_images_ = std::max(sure_images_, sure_without_images(sure_box_, home_length()));
    sure_images_known_ = true;
    set_image_reach(sure_image_reach());
}

// Whether all images near the vertex are present, with rounding small enough to decide.
template <class Isa>
bool StarWalk<Isa>::images_known(const Four& x, double x2, double reach2, double length2) {
    if (!weighted_) set_image_reach(seeds_.images->reach(p_));
    if (!(x2 > images_beyond2_)) return false;
    if (reach2 < images_within2_) return true;
    if (!(reach2 * unscale_ * unscale_ < own_images_ * own_images_ * (1 - 4 * margin))) return false;
    if (weighted_) {
        if (owners_present(x, length2)) return true;
        if (!sure_images_known_) find_sure_images();
        if (reach2 < images_within2_) return true;
    }
    return !any_missing_image(ball_around(x, length2), 0.5 * std::sqrt(reach2) * unscale_);
}

// Whether all images that may own the place of a vertex are present, even if they have the largest weight. The owner is
// also the nearest of its images, so within the covering radius.
template <class Isa>
bool StarWalk<Isa>::owners_present(const Four& x, double length2) const {
    exact::Point place;
    double size = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double offset = (x.x[k] - move_.x[k]) * unscale_;
        place[k] = p_[k] + offset;
        size = std::max(size, std::abs(p_[k]) + std::abs(offset));
    }
    const double square = bounds::back(power_within(distance_squared(x), length2), domain_->largest_weight);
    const double within = std::min(std::sqrt(square), domain_->covering_radius) * (1 + 4 * margin);
    return within + in_places(2 * margin * std::sqrt(length2), size) < seeds_.images->reach(place);
}

// Returns a length below which no missing image cuts off a vertex of the seeds in a box, by the test of
// owners_present(). The place of such a vertex is within that length of a seed moved by the tilt |a|, so its distance D
// from an owner has D^2 <= (length + |a|)^2 + `heavier`, and the reach is less than there by at most the length.
template <class Isa>
double StarWalk<Isa>::sure_by_weights(const Box& home) const {
    Box moved;
    for (std::size_t k = 0; k < 3; ++k) {
        moved.lower[k] = home.lower[k] - 0.5 * tilt_.slope[k];
        moved.upper[k] = home.upper[k] - 0.5 * tilt_.slope[k];
    }
    const double reach = seeds_.images->reach(moved) * (1 - 4 * margin), tilt = home_tilt_length_,
                 heavier = std::max(0.0, domain_->largest_weight - lightest_);
    if (reach == 0) return 0;
    const double by_weights = 0.5 * (reach * reach - tilt * tilt - heavier) / (reach + tilt);
    return std::max({0.0, by_weights, reach - domain_->covering_radius}) * (1 - 4 * margin);
}

// Calls visit() for the shifts by which an image may come nearer than `distance` to a box. Returns false if they are
// very many.
template <class Isa>
template <class Visit>
bool StarWalk<Isa>::for_shifts_around(const Box& around, double distance, Visit visit) const {
    constexpr double max_shifts = 343;
    exact::Point center;
    double half2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        center[k] = 0.5 * (around.lower[k] + around.upper[k]);
        half2 += (around.upper[k] - center[k]) * (around.upper[k] - center[k]);
    }
    const ShiftRange range = shifts_around(*domain_, hierarchy_.box(hierarchy_.top_level(), 0), center,
                                           distance + std::sqrt(half2) * (1 + 8 * unit));
    double count = 1;
    for (std::size_t j = 0; j < 3; ++j) count *= 1.0 + range.upper[j] - range.lower[j];
    if (!(count < max_shifts)) return false;
    for (int i = range.lower[0]; i <= range.upper[0]; ++i)
        for (int j = range.lower[1]; j <= range.upper[1]; ++j)
            for (int k = range.lower[2]; k <= range.upper[2]; ++k)
                if (i != 0 || j != 0 || k != 0) visit(std::array<int, 3>{i, j, k});
    return true;
}

// Returns a box as the images by a shift see it, with room for rounding.
template <class Isa>
Box StarWalk<Isa>::seen_from_images(const Box& box, const std::array<double, 3>& by) const {
    Box moved;
    for (std::size_t k = 0; k < 3; ++k) {
        const double slack = 16 * unit * (std::abs(by[k]) + seeds_.images->largest_coordinate());
        moved.lower[k] = box.lower[k] - by[k] - slack;
        moved.upper[k] = box.upper[k] - by[k] + slack;
    }
    return moved;
}

template <class Isa>
std::array<double, 3> StarWalk<Isa>::translation(const std::array<int, 3>& shift) const {
    std::array<double, 3> by{};
    for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k) by[k] += domain_->reduced.vector[j][k] * shift[j];
    return by;
}

// Calls visit() for the groups of seeds, as seen from their images by a shift, that pass the test of near_heavier(), or
// without weights, whose distance is less than the root of `square`, unless all these images are present. by: the
// shift. The test may change between calls.
template <class Isa>
template <class Visit>
void StarWalk<Isa>::for_groups(const Box& around, const std::array<double, 3>& by, const HeavierTest& test,
                               Visit visit) {
    std::size_t nodes = 1;
    nodes_[0] = {hierarchy_.top_level(), 0};
    while (nodes > 0) {
        const auto [level, index] = nodes_[--nodes];
        const BoxBlock& boxes = hierarchy_.block(level, index);
        unsigned near = weighted_ ? Isa::near_heavier(boxes, hierarchy_.weight_bounds(level, index), around, test)
                                  : Isa::near_boxes(boxes, around, test.square);
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            if (Hierarchy::first_seed(level, child) >= seeds_.size()) break;  // these are images
            Box images = hierarchy_.box(level, child);
            for (std::size_t k = 0; k < 3; ++k) images.lower[k] += by[k], images.upper[k] += by[k];
            if (seeds_.images->are_present(images)) continue;
            if (level > 0)
                nodes_[nodes++] = {level - 1, child};
            else if (!visit(std::size_t{child} * group_size))
                return;
        }
    }
}

// Returns a length, at most the given one, below which no missing image cuts off a vertex of the seeds in a box. Lists
// the shifts that matter for the given length.
//
// A vertex that a cell must lose lies in the cell of an image that is within the covering radius of it, so farther
// images need not be excluded.
template <class Isa>
double StarWalk<Isa>::sure_without_images(const Box& home, double length) {
    image_shifts_.clear();
    const double near = seeds_.images->reach(home);
    const double from_seed = length + home_tilt_length_, heavier = std::max(0.0, domain_->largest_weight - lightest_);
    const double distance =
        (from_seed + std::min(std::sqrt(from_seed * from_seed + heavier), domain_->covering_radius)) * (1 + 4 * margin);
    image_shifts_known_ = true;
    if (distance < near) return length;
    double sure = length;
    const bool few = for_shifts_around(home, distance, [&](const std::array<int, 3>& shift) {
        if (sure == 0) return;
        const std::array<double, 3> by = translation(shift);
        const Box around = seen_from_images(home, by);
        WeightTilt tilt = tilt_;
        for (std::size_t k = 0; k < 3; ++k) tilt.origin[k] -= by[k];
        HeavierTest test(tilt, length, 0, near);
        bool any = false;
        for_groups(around, by, test, [&](std::size_t begin) {
            for (std::size_t s = begin; s < seeds_.group_end(begin); ++s) {
                const double apart = std::max(near, distance_to_seed(around, s)),
                             square = apart * apart * (1 - 8 * unit);
                const double most = std::max(0.0, largest_residual(tilt, s) - tilt.least);
                const double within = apart == 0 ? 0 : std::max(0.0, 0.5 * (square - most) / apart * (1 - 8 * unit));
                if (within >= length ||
                    seeds_.images->is_present({seeds_.x[s] + by[0], seeds_.y[s] + by[1], seeds_.z[s] + by[2]}))
                    continue;
                any = true;
                sure = std::min(sure, within);
            }
            if (any) test = {tilt, sure, 0, near};
            return !any || sure > 0;
        });
        if (any) image_shifts_.push_back(shift);
    });
    image_shifts_known_ = few && sure > 0;
    return few ? sure : 0;
}

// Returns the distance of a seed from a box, rounded down.
template <class Isa>
double StarWalk<Isa>::distance_to_seed(const Box& box, std::size_t seed) const {
    const double at[3] = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        const double gap = std::max({0.0, at[k] - box.upper[k], box.lower[k] - at[k]});
        square += gap * gap;
    }
    return std::sqrt(square) * (1 - 8 * unit);
}

// Rounded up.
template <class Isa>
double StarWalk<Isa>::largest_residual(const WeightTilt& tilt, std::size_t seed) const {
    const double at[3] = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    double rest = seeds_.weights[seed] - tilt.base, size = std::abs(rest);
    for (int k = 0; k < 3; ++k) {
        const double by = tilt.slope[k] * (at[k] - tilt.origin[k]);
        rest -= by;
        size += std::abs(by);
    }
    return rest + 16 * unit * size;
}

template <class Isa>
bool StarWalk<Isa>::any_missing_image(const Ball& ball, double length) {
    const exact::Point& center = ball.center.lower;
    const double near = seeds_.images->reach(center), square = ball.radius * ball.radius;
    double distance = ball.radius;
    if (weighted_) {
        const double heavier = std::max(0.0, domain_->largest_weight - weight_), from_seed = ball.radius + tilt_length_;
        distance = tilt_length_ + std::min(std::sqrt(from_seed * from_seed + heavier), domain_->covering_radius) +
                   2 * ball.off;
        distance *= 1 + 4 * margin;
    }
    if (distance < near) return false;
    bool any = false;
    const auto search = [&](const std::array<int, 3>& shift) {
        if (any) return;
        const std::array<double, 3> by = translation(shift);
        const Box around = seen_from_images(ball.center, by);
        WeightTilt tilt = own_tilt_;
        for (std::size_t k = 0; k < 3; ++k) tilt.origin[k] -= by[k];
        for_groups(around, by, {tilt, ball.off, square, near}, [&](std::size_t begin) {
            for (std::size_t s = begin; s < seeds_.group_end(begin); ++s) {
                const double apart = distance_to_seed(around, s);
                const double most = weighted_ ? std::max(0.0, largest_residual(tilt, s) - tilt.least) : 0;
                any = any ||
                      (apart * apart * (1 - 8 * unit) - 2 * ball.off * apart < square + most &&
                       !seeds_.images->is_present({seeds_.x[s] + by[0], seeds_.y[s] + by[1], seeds_.z[s] + by[2]}));
            }
            return !any;
        });
    };
    if (weighted_ && image_shifts_known_ && length + turned_ <= home_length()) {
        for (const auto& shift : image_shifts_) search(shift);
        return any;
    }
    return !for_shifts_around(ball.center, distance, search) || any;
}

// Examines the candidates that come too near to a vertex, from `lane` on. Returns one that cuts it off, or -1; tied_
// then holds those through it.
template <class Isa>
int StarWalk<Isa>::examine(const float* v, const std::int32_t* three, const Third& third, const Four& x, int lane,
                           int count) {
    const double relative = relative_error(third);
    bool begun = false;
    for (; lane >= 0; lane = Isa::touching(candidates_, count, v, three, lane + 1)) {
        const std::int32_t id = candidates_.id[lane];
        const int sure = sure_side(id, third, relative, x);
        if (sure > 0) return lane;
        if (sure < 0 || std::find(tied_.begin(), tied_.end(), id) != tied_.end()) continue;
        used_exact_ = true;
        if (!begun) begin_tie(three);
        begun = true;
        std::optional<int> side;
        if (id >= 0 && tied_seeds_.usable()) side = tied_seeds_.side(difference_to(id));
        if (!side) {
            side = exact::side_of_vertex(base_.point, exact_plane(three[0]), exact_plane(three[1]),
                                         exact_plane(three[2]), exact_plane(id));
            if (side == 0) tied_seeds_.give_up();
        }
        if (side > 0) return lane;
        if (side == 0) tied_.push_back(id);
    }
    return -1;
}

// Begins a vertex of three planes. With weights or walls tied_seeds_ is not usable.
template <class Isa>
void StarWalk<Isa>::begin_tie(const std::int32_t* three) {
    if (weighted_ || three[0] < 0 || three[1] < 0 || three[2] < 0)
        tied_seeds_.give_up();
    else
        tied_seeds_.begin(difference_to(three[0]), difference_to(three[1]), difference_to(three[2]));
}

// Returns the vector to another seed.
template <class Isa>
exact::Differences StarWalk<Isa>::difference_to(std::int32_t id) const {
    if (seeds_.images != nullptr) return exact::differences(base_.point, exact_plane(id));
    const auto i = static_cast<std::size_t>(id);
    return {
        {exact::two_sum(seeds_.x[i], -p_[0]), exact::two_sum(seeds_.y[i], -p_[1]), exact::two_sum(seeds_.z[i], -p_[2])},
        true};
}

// Returns a bound on the error of n.x, in units of |n| and the length of the vertex.
template <class Isa>
double StarWalk<Isa>::relative_error(const Third& third) const {
    return (weighted_ ? bounds::weighted_factor : bounds::solved_factor) * third.condition() +
           (weighted_ ? 40 : 8) * unit;
}

// Returns the side of a plane on which the vertex lies, or 0 if rounding may decide.
template <class Isa>
int StarWalk<Isa>::sure_side(std::int32_t id, const Third& third, double relative, const Four& x) {
    Four n;
    double h, square;
    plane_through(id, n, h, square);
    const double excess = dot(wide(n), wide(x)) - h;
    const double bound = std::sqrt(square * third.length2) * relative + 12 * unit * size_of_h(h, square);
    return excess > bound ? 1 : excess < -bound ? -1 : 0;
}

template <class Isa>
void StarWalk<Isa>::store_position(const Third& third, const Four& x) {
    Wide position = (wide(x) - wide(move_)) * unscale_;
    position[3] = third.norms2 / third.determinant2 * third.length2 * unscale_ * unscale_;
    wide(position_[vertices_]) = position;
    numbers_[vertices_] = cells_.place(own_local_, position_[vertices_]);
}

template <class Isa>
template <Star::Keep Kept>
bool StarWalk<Isa>::add_vertex(const OpenEdge& edge, std::int32_t id, const Third& third, const Four& x) {
    if (planes_ > max_planes - 2 || vertices_ > max_vertices - 4) return false;
    const int c = new_slot(id);
    // Known planes too, because a branch would be mispredicted.
    planes_known_ |= 1ull << c;
    id_[c] = id;
    wide(n_[c]) = wide(third.n);
    h_[c] = third.h;
    square_[c] = third.square;
    if constexpr (Kept == Keep::places) store_position(third, x);
    cells_.give({own_local_, local_[edge.b], local_[edge.a], local_[c]},
                Kept == Keep::places ? numbers_[vertices_] : 0);
    link_corner<Kept>(edge.b, edge.a, c, vertices_++);
    ends_ += 3;
    open_ =
        (open_ & ~(1ull << edge.a | 1ull << edge.b | 1ull << c)) | open_bit(edge.a) | open_bit(edge.b) | open_bit(c);
    return true;
}

// Adds a vertex of more than three planes.
template <class Isa>
bool StarWalk<Isa>::add_tie(const OpenEdge& edge, std::int32_t id, const Third& third, const Four& x) {
    if (vertices_ > max_vertices - 4) return false;
    met_tie_ = true;
    if (keep_ == Keep::places) store_position(third, x);
    tied_cells_.assign({own_local_, local_[edge.a], local_[edge.b], cells_.local(id)});
    for (const std::int32_t other : tied_) tied_cells_.push_back(cells_.local(other));
    const double power = power_within(distance_squared(x), third.length2);
    if (give_polygons(power)) return link_ring(ring_, vertices_++);
    cells_.give_tie(tied_cells_, numbers_[vertices_], power);
    return link_polygon(std::span(tied_cells_).subspan(1), vertices_++);
}

// Hands the vertex of tied_cells_ to the others, each with its polygon, and sets ring_ to that of this cell. Returns
// false where there are walls or weights. Each cell then calls link_polygon().
template <class Isa>
bool StarWalk<Isa>::give_polygons(double power) {
    if (probing_ || !tied_seeds_.usable() || !tied_seeds_.wrap()) return false;
    const std::span cells(tied_cells_);
    for (std::size_t k = cells.size(); k-- > 0;) {
        ring_.clear();
        for (const std::uint8_t seed : tied_seeds_.around(k)) ring_.push_back(cells[seed]);
        if (k > 0) cells_.give_polygon(cells[k], ring_, numbers_[vertices_], power);
    }
    return true;
}

// Finds out which of the planes through a vertex own an edge there.
template <class Isa>
bool StarWalk<Isa>::link_polygon(std::span<const std::int32_t> cells, int vertex) {
    if (cells.size() > max_ties || ((weighted_ || !seeds_.beyond.empty()) && any_parallel(cells))) return false;
    used_exact_ = true;
    corner_planes_.clear();
    for (const std::int32_t cell : cells) corner_planes_.push_back(exact_plane(cells_.id(cell)));
    std::array<const exact::Plane*, max_ties> pointers;
    for (std::size_t k = 0; k < cells.size(); ++k) pointers[k] = &corner_planes_[k];
    std::array<int, max_ties> room;
    ring_.clear();
    for (const int k : exact::corner_polygon(base_.point, std::span(pointers).first(cells.size()),
                                             std::span(room).first(cells.size())))
        ring_.push_back(cells[static_cast<std::size_t>(k)]);
    return ring_.size() >= 3 && link_ring(ring_, vertex);
}

// ring: in the order of corner_polygon().
template <class Isa>
bool StarWalk<Isa>::link_ring(std::span<const std::int32_t> ring, int vertex) {
    const std::size_t count = ring.size();
    if (planes_ + count > max_planes || ends_ + count > 4 * max_vertices) return false;
    std::array<std::uint8_t, max_ties> slots;
    for (std::size_t k = 0; k < count; ++k) {
        make_room(ring[k]);
        slots[k] = static_cast<std::uint8_t>(slot_of(ring[k], planes_));
    }
    for (std::size_t k = 0; k < count; ++k) {
        const int a = slots[k], b = slots[k + 1 == count ? 0 : k + 1];
        out_[a] |= 1ull << b;
        in_[b] |= 1ull << a;
        from_vertex_[a][b] = static_cast<std::uint8_t>(vertex);
    }
    if (keep_ != Keep::nothing) {
        const auto begin = std::ssize(tie_slots_);
        tie_slots_.insert(tie_slots_.end(), slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(count));
        ties_.push_back({vertex, begin, std::ssize(tie_slots_)});
    }
    ends_ += static_cast<int>(count);
    for (std::size_t k = 0; k < count; ++k) open_ = (open_ & ~(1ull << slots[k])) | open_bit(slots[k]);
    return true;
}

// ---- The finished cell: measures, polygons, normals ----

// Whether the vector to a seed is the difference of two doubles for each coordinate.
template <class Isa>
bool StarWalk<Isa>::is_difference(std::int32_t id) const {
    return seeds_.images == nullptr ||
           (!moved_ && !seeds_.images->is_rough(id) && seeds_.images->low(id) == std::array<double, 3>{});
}

// Plain: no weights, no images.
template <class Isa>
template <bool Plain>
void StarWalk<Isa>::shape_planes(std::span<const std::uint32_t> ranks) {
    CellShape& shape = shape_;
    const Wide at{p_[0], p_[1], p_[2], 0};
    const double *x = seeds_.x.begin(), *y = seeds_.y.begin(), *z = seeds_.z.begin();  // kept in registers
    for (int face = 0; face < faces_; ++face) {
        const std::uint32_t rank = ranks[static_cast<std::size_t>(face)];
        shape.rank[face_slot_[face]] = static_cast<std::uint8_t>(rank);
        const std::int32_t id = face_[face];
        Wide& plane = reinterpret_cast<Wide&>(shape.plane[rank]);
        if (id < 0) {
            Four n;
            double h;
            wall_plane(id, n, h);
            plane = 0.5 * unscale_ * wide(n);
            continue;
        }
        if (Plain || is_difference(id)) {
            plane = 0.5 * (Wide{x[id], y[id], z[id], 0} - at);
        } else {
            const auto difference = exact::differences(base_.point, exact_plane(id)).x;
            plane = 0.5 * Wide{difference[0].high, difference[1].high, difference[2].high, 0};
        }
        if (!Plain && weighted_) plane[3] = 0.25 * (weight_ - weight_of(id));
    }
}

template <class Isa>
std::array<double, 3> StarWalk<Isa>::corner(const std::array<unsigned, 3>& ranks) const {
    const auto plane = [&](unsigned rank) {
        int face = 0;
        while (shape_.rank[face_slot_[face]] != rank) ++face;
        return exact_plane(face_[face]);
    };
    return exact::near_vertex(base_.point, plane(ranks[0]), plane(ranks[1]), plane(ranks[2]));
}

template <class Isa>
CellShape* StarWalk<Isa>::shape(std::span<const std::uint32_t> ranks) {
    CellShape& shape = shape_;
    shape.planes = faces_;
    shape.slots = planes_;
    shape.corners = vertices_;
    shape.weighted = weighted_;
    shape.exact = this;
    if (plain_)
        shape_planes<true>(ranks);
    else
        shape_planes<false>(ranks);
    for (const Tie& tie : ties_) {
        if (!shape.add_polygon(std::span(tie_slots_.begin() + tie.begin, tie_slots_.begin() + tie.end))) return nullptr;
        // The last corner replaces the vertex.
        const auto from = static_cast<std::size_t>(--shape.corners), to = static_cast<std::size_t>(tie.vertex);
        shape.a[to] = shape.a[from], shape.b[to] = shape.b[from], shape.c[to] = shape.c[from];
    }
    return &shape;
}

template <class Isa>
bool StarWalk<Isa>::knows_vertices() const {
    constexpr double accepted_error = 4e-10;
    Wide largest{};  // squares
    for (int v = 0; v < vertices_; ++v) {
        const Wide square = wide(position_[v]) * wide(position_[v]);
        largest = square > largest ? square : largest;
    }
    return bounds::solved_factor * std::sqrt(std::sqrt(largest[3])) <=
           accepted_error * std::sqrt(std::max({largest[0], largest[1], largest[2]}));
}

// Walks around face b: from the vertex that has a -> b along both to the one that has b -> a.
template <class Isa>
void StarWalk<Isa>::polygons(std::span<const std::uint32_t> ranks, CellPolygons& out) const {
    out.clear();
    out.positions.resize(static_cast<std::size_t>(vertices_));
    for (std::size_t v = 0; v < out.positions.size(); ++v) {
        const auto& x = position_[v].x;
        out.positions[v] = {x[0], x[1], x[2]};
    }
    out.shared.assign(numbers_.begin(), numbers_.begin() + vertices_);
    std::array<unsigned, max_planes> key;  // the rank, then the plane
    for (unsigned p = 0, faces = 0; p < static_cast<unsigned>(planes_); ++p)
        if (out_[p] != 0) key[p] = ranks[faces++] << 8 | p;
    out.corners.resize(static_cast<std::size_t>(ends_));
    std::uint32_t* corner = out.corners.data();
    std::array<std::uint8_t, max_vertices> next;  // a, by the vertex that has a -> b
    for (int b = 0; b < planes_; ++b) {
        if (out_[b] == 0) continue;
        unsigned least = ~0u;
        for (std::uint64_t rest = out_[b]; rest != 0; rest &= rest - 1) {
            const int a = std::countr_zero(rest);
            next[from_vertex_[a][b]] = static_cast<std::uint8_t>(a);
            least = std::min(least, key[a]);
        }
        out.first_across.push_back(least >> 8);
        const unsigned first = from_vertex_[least & 0xff][b];
        unsigned v = first;
        do {
            *corner++ = v;
            v = from_vertex_[b][next[v]];
        } while (v != first);
        out.offsets.push_back(static_cast<std::uint32_t>(corner - out.corners.data()));
    }
}

template <class Isa>
void StarWalk<Isa>::normals(std::vector<std::array<double, 3>>& out) {
    out.clear();
    for (const std::int32_t id : faces()) out.push_back(unit_normal(base_.point, exact_plane(id)));
}

// ---- Bisector planes in floats, in doubles and exactly ----

template <class Isa>
void StarWalk<Isa>::plane_through(std::int32_t id, Four& n, double& h, double& square) {
    if (id < 0) {
        wall_plane(id, n, h);
        square = 2 * h;
        if (weighted_) h += dot(wide(n), wide(move_));
        return;
    }
    const auto i = static_cast<std::size_t>(id);
    const Wide q{seeds_.x[i], seeds_.y[i], seeds_.z[i], 0}, p{p_[0], p_[1], p_[2], 0};
    wide(n) = q - p;
    if (!plain_ && seeds_.images != nullptr && (any_wrapped_ || seeds_.images->is_image(id))) add_low(id, n);
    wide(n) *= scale_;
    square = dot(wide(n), wide(n));
    h = 0.5 * square;
    if (!plain_ && weighted_)
        h = 0.5 * (square + (weight_ - weight_of(id)) * scale_ * scale_) + dot(wide(n), wide(move_));
}

// Adds the rounding errors of coordinates.
template <class Isa>
void StarWalk<Isa>::add_low(std::int32_t id, Four& n) const {
    // If places nearly cancel, a third double would be missing, and so would the rounding error of this sum.
    if ((moved_ || any_rough_) && may_cancel(id, n)) {
        const auto [x, y, z] = exact::differences(base_.point, exact_plane(id)).x;
        wide(n) = Wide{x.high, y.high, z.high, 0};
        return;
    }
    const auto& low = seeds_.images->low(id);
    wide(n) += Wide{low[0], low[1], low[2], 0} - wide(low_);
}

template <class Isa>
bool StarWalk<Isa>::may_cancel(std::int32_t id, const Four& n) const {
    const double size = closest_moved * seeds_.images->largest_coordinate();
    return (moved_ && dot(wide(n), wide(n)) < size * size) || (any_rough_ && seeds_.images->is_rough(id));
}

template <class Isa>
void StarWalk<Isa>::need_plane(int slot) {
    if (((planes_known_ >> slot) & 1) != 0) return;
    planes_known_ |= 1ull << slot;
    id_[slot] = cells_.id(local_[slot]);
    plane_through(id_[slot], n_[slot], h_[slot], square_[slot]);
}

// Finds n_, h_, square_ and id_ of the planes that have open edges.
template <class Isa>
void StarWalk<Isa>::find_open_planes() {
    for (std::uint64_t slots = open_ & ~planes_known_; slots != 0; slots &= slots - 1)
        need_plane(std::countr_zero(slots));
}

template <class Isa>
exact::Plane StarWalk<Isa>::exact_plane(std::int32_t id) const {
    if (id < 0) return walls_[static_cast<std::size_t>(wall_places_[static_cast<std::size_t>(-1 - id)])].plane;
    if (seeds_.images != nullptr)
        return with_power(seeds_.images->bisector(base_, seeds_.images->home(id), seeds_.images->shift(id)), id);
    const auto i = static_cast<std::size_t>(id);
    return with_power(exact::Plane::bisector({seeds_.x[i], seeds_.y[i], seeds_.z[i]}), id);
}

template <class Isa>
exact::Plane StarWalk<Isa>::with_power(exact::Plane plane, std::int32_t id) const {
    if (weighted_) plane.power = exact::two_sum(weight_, -weight_of(id));
    return plane;
}

// Whether two planes may be one. The face then belongs to the wall or the farther seed, which the clipper decides.
template <class Isa>
bool StarWalk<Isa>::any_parallel(std::span<const std::int32_t> cells) {
    constexpr double nearly = 1e-20;
    std::array<Four, max_ties> normals;
    std::array<double, max_ties> squares;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (const std::int32_t id = cells_.id(cells[i]); id < 0) {  // a seed on a wall has no mirror image
            normals[i] = wall_of(id).normal;
            squares[i] = 1;
        } else {
            double h;
            plane_through(id, normals[i], h, squares[i]);
        }
        for (std::size_t j = 0; j < i; ++j) {
            Wide across;
            cross(wide(normals[i]), wide(normals[j]), across);
            if (dot(across, across) <= nearly * squares[i] * squares[j] && dot(wide(normals[i]), wide(normals[j])) > 0)
                return true;
        }
    }
    return false;
}

// ---- Walls: the walk handles a wall as the bisector of the seed and its mirror image ----

template <class Isa>
void StarWalk<Isa>::begin_job(const Domain& domain) {
    domain_ = &domain;
    weighted_ = domain.has_weights();
    weight_ = own_weight_ = 0;
    is_bent_ = false;
    tilt_ = {};
    tilt_length_ = home_tilt_length_ = weight_rounding_ = turned_ = 0;
    plain_ = !weighted_ && seeds_.images == nullptr;
    walls_.clear();
    wall_error_ = 0;
    wall_places_.assign(6 + domain.walls.size(), -1);
    double size = largest_coordinate(domain.box);
    for (int k = 0; k < 3; ++k) size = std::max(size, std::abs(domain.origin[k]));
    for (std::size_t w = 0; w < wall_places_.size(); ++w) {
        const int of_box = static_cast<int>(w);
        if (w < 6 && !domain.has_box_wall(of_box)) continue;
        wall_places_[w] = static_cast<std::int32_t>(walls_.size());
        Wall wall{};
        wall.id = -1 - of_box;
        wall.plane = w < 6 ? domain.box_wall(of_box) : domain.walls[w - 6];
        wall.mirror_of = ~std::size_t{0};
        if (wall.plane.is_oblique()) {
            const CellPlane at_origin = make_plane({}, wall.id, wall.plane);
            const double inverse = 1 / at_origin.norm;
            for (std::size_t k = 0; k < 3; ++k) wall.normal.x[k] = at_origin.n[k] * inverse;
            wall.offset = at_origin.h * inverse;
            wall.error = 64 * unit * (4 * size + std::abs(wall.offset));
        } else {
            const int axis = of_box / 2;
            wall.normal.x[axis] = of_box % 2 == 0 ? -1 : 1;
            wall.offset = of_box % 2 == 0 ? -domain.box.lower[axis] : domain.box.upper[axis];
        }
        wall_error_ = std::max(wall_error_, wall.error);
        walls_.push_back(wall);
    }
}

// Returns a lower bound of the distance of the moved seed inside the wall.
template <class Isa>
double StarWalk<Isa>::distance_to(const Wall& wall) const {
    const auto& n = wall.normal.x;
    double inside = wall.offset - (n[0] * p_[0] + n[1] * p_[1] + n[2] * p_[2]) - wall.error;
    if (weighted_) inside += along_tilt(own_tilt_, wall.normal) - 8 * unit * tilt_length_;
    return inside;
}

// Nearer than `reach` to a box.
template <class Isa>
void StarWalk<Isa>::collect_near_walls(const Box& home, double reach) {
    near_walls_.clear();
    const std::size_t few = walls_.size() - domain_->wall_tree.size();
    for (std::size_t w = 0; w < few; ++w) {
        const auto& n = walls_[w].normal.x;
        double farthest = 0;
        for (int k = 0; k < 3; ++k) farthest += n[k] * (n[k] > 0 ? home.upper[k] : home.lower[k]);
        if (walls_[w].offset - farthest + along_tilt(tilt_, walls_[w].normal) - 2 * walls_[w].error < reach)
            near_walls_.push_back({w, 0});
    }
}

// Adds only the nearest of many walls, as most of the others bound other cells. close() adds those that cut a vertex.
template <class Isa>
bool StarWalk<Isa>::add_near_walls() {
    const double reach = longest_;  // before the walls lengthen it
    candidates_.near = 0;
    for (NearWall& near : near_walls_) {
        const Wall& wall = walls_[near.wall];
        near.distance = distance_to(wall);
        if (2 * near.distance * scale_ * (1 - margin) < reach && !add_wall(wall)) return false;
    }
    double next = std::numeric_limits<double>::infinity();
    if (domain_->wall_tree.size() > 0) {
        const Wall* const nearest = find_nearest_of_many(reach / (2 * scale_ * (1 - margin)), next);
        if (nearest != nullptr && !add_wall(*nearest)) return false;
    }
    const double within = std::max(0.0, 2 * next * scale_ * (1 - margin));
    walls_within2_ = within * within;
    near_walls_end_ = candidates_.count;
    return true;
}

// Returns the nearest of many walls, or null if none is within a distance. next: set to a bound below the distances of
// all others.
template <class Isa>
const typename StarWalk<Isa>::Wall* StarWalk<Isa>::find_nearest_of_many(double within, double& next) {
    const WallTree& tree = domain_->wall_tree;
    const std::size_t first = walls_.size() - tree.size();
    const Wall* found = nullptr;
    double nearest = next = within;
    const exact::Point seed{p_[0], p_[1], p_[2]};
    const auto wall_of_node = [&](std::size_t node) -> const Wall& { return walls_[first + tree.wall(node)]; };
    wall_nodes_.assign(1, 0);
    while (!wall_nodes_.empty()) {
        const std::size_t node = wall_nodes_.back();
        wall_nodes_.pop_back();
        if (!tree.may_exclude(node, seed, 0.5 * std::max(0.0, next) + wall_error_ + tilt_length_)) continue;
        const Wall& wall = wall_of_node(node);
        if (const double distance = distance_to(wall); distance < nearest)
            next = std::exchange(nearest, distance), found = &wall;
        else
            next = std::min(next, distance);
        std::size_t later = 2 * node + 1, sooner = later + 1;
        if (later >= tree.size()) continue;
        if (sooner < tree.size() && distance_to(wall_of_node(later)) < distance_to(wall_of_node(sooner)))
            std::swap(later, sooner);
        for (const std::size_t child : {later, sooner})
            if (child < tree.size()) wall_nodes_.push_back(static_cast<std::uint32_t>(child));
    }
    return found;
}

// Returns false also if the wall may be one plane with another. The first then has the face, which the clipper decides
// by taking walls in order.
template <class Isa>
bool StarWalk<Isa>::add_wall(const Wall& wall) {
    constexpr float nearly = 1e-5f;
    constexpr std::int32_t last_of_box = -6;
    if (!add_candidate(wall.id)) return false;
    CandidatePlanes& c = candidates_;
    const int i = c.near++, last = c.count - 1;  // one of many walls may be as near as seeds of the window
    const auto swap_lanes = [&c](int a, int b) {
        for (float* axis : {c.nx, c.ny, c.nz, c.h}) std::swap(axis[a], axis[b]);
        std::swap(c.id[a], c.id[b]);
    };
    swap_lanes(i, last);
    if (last >= selected_) {  // a seed of the window stays one
        if (i < selected_) swap_lanes(last, selected_);
        ++selected_;
    }
    for (int j = 0; j < c.count; ++j) {
        if (j == i || c.id[j] >= 0 || (c.id[j] >= last_of_box && wall.id >= last_of_box)) continue;
        const float apart = std::abs(c.nx[i] - c.nx[j]) + std::abs(c.ny[i] - c.ny[j]) + std::abs(c.nz[i] - c.nz[j]);
        if (apart <= nearly * (std::abs(c.nx[i]) + std::abs(c.ny[i]) + std::abs(c.nz[i]))) return false;
    }
    return true;
}

template <class Isa>
bool StarWalk<Isa>::add_nearest_wall() {
    const auto nearest = std::ranges::min_element(walls_, {}, [&](const Wall& wall) { return distance_to(wall); });
    return nearest != walls_.end() && add_wall(*nearest);  // a periodic domain has no walls
}

// Adds the wall that cuts an edge first, of those that may cut off or touch its vertex x and are no candidates, if
// there is one. along: from the seed's side of these walls to x. near: the vertex is within the reach of the window.
// Searches many walls for those that may cut the edge before the first one so far.
template <class Isa>
bool StarWalk<Isa>::add_wall_before(const Four& x, double length2, bool near, const Wide& along, int& added) {
    constexpr double parallel = 0x1p40;
    const double length = std::sqrt(length2), slack = 2 * margin * length;
    const Wall* first = nullptr;
    double farthest = 0;
    const auto is_before = [&](const Wall& wall, double distance) {
        const Wide& n = wide(wall.normal);
        const double beyond = dot(n, wide(x)) - distance * scale_ + slack;
        if (!(beyond >= 0) || is_candidate(wall.id)) return false;
        const double from_wall = beyond / std::max(dot(n, along), std::numeric_limits<double>::min());
        if (first != nullptr && from_wall <= farthest) return false;
        first = &wall;
        farthest = from_wall;
        return true;
    };
    const WallTree& tree = domain_->wall_tree;
    const std::size_t few = walls_.size() - tree.size();
    if (near)
        for (const NearWall& wall : near_walls_) (void)is_before(walls_[wall.wall], wall.distance);
    else
        for (std::size_t w = 0; w < few; ++w) (void)is_before(walls_[w], distance_to(walls_[w]));
    if (tree.size() > 0) {
        const double speed = std::sqrt(dot(along, along));
        exact::Point place;
        double tolerance = 0;
        const auto go_to_first = [&] {  // returns false if nothing is before it
            const double back = farthest * speed;
            if (!(back < parallel * length)) return false;
            double size = 0;
            for (int k = 0; k < 3; ++k) {
                const double offset = (x.x[k] - farthest * along[k] - move_.x[k]) * unscale_;
                place[static_cast<std::size_t>(k)] = p_[k] + offset;
                size += std::abs(p_[k]) + std::abs(offset);
            }
            tolerance = in_places(2 * margin * (length + back), size);
            return true;
        };
        wall_nodes_.clear();
        if (go_to_first()) wall_nodes_.push_back(0);
        for (std::size_t k = 0; k < wall_nodes_.size(); ++k) {  // level by level, so that all directions come early
            const std::size_t node = wall_nodes_[k];
            if (!tree.may_exclude(node, place, tolerance)) continue;
            const Wall& wall = walls_[few + tree.wall(node)];
            if (is_before(wall, distance_to(wall)) && !go_to_first()) break;
            for (std::size_t child = 2 * node + 1; child <= 2 * node + 2 && child < tree.size(); ++child)
                wall_nodes_.push_back(static_cast<std::uint32_t>(child));
        }
    }
    if (first == nullptr) return true;
    ++added;
    return add_wall(*first);
}

template <class Isa>
void StarWalk<Isa>::wall_plane(std::int32_t id, Four& n, double& h) {
    Wall& wall = wall_of(id);
    if (wall.mirror_of != seed_) {
        wall.mirror_of = seed_;
        wall.n = {};
        wall.h = 0;
        if (!wall.plane.is_oblique()) {
            const int axis = (-1 - id) / 2;
            const double distance = wall.plane.wall - p_[static_cast<std::size_t>(axis)];
            wall.n.x[axis] = 2 * distance;
            wall.h = 2 * distance * distance;
        } else {  // moves are along walls
            const CellPlane plane = make_plane(base_.point, id, wall.plane);
            if (plane.reliable && plane.h > 0) {
                std::ranges::copy(mirror_image(plane), wall.n.x);
                wall.h = 2 * plane.h / (plane.norm * plane.norm) * plane.h;
            }
        }
    }
    wide(n) = wide(wall.n) * scale_;
    h = wall.h * scale_ * scale_;
}

}  // namespace votess::cpu

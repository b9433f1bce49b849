// The exact diagram of any domain by definition, in rational arithmetic: periodic boxes, walls, weights. A cell is the
// intersection of half-spaces; a face is the part of one plane that lies in all others and has positive area.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include <votess/votess.hpp>

namespace test {

struct ExactFace {
    std::int32_t id = 0;
    std::array<int, 3> shift{};
    friend auto operator<=>(const ExactFace&, const ExactFace&) = default;
};

struct ExactDomainCell {
    std::vector<ExactFace> faces;  // ascending, walls included; none: the cell has no interior
    double volume = 0;
};

// Returns the face that a row lists at place k.
ExactFace face_of(const votess::Tessellation& t, std::size_t i, std::size_t k);

// reach: images by -reach .. reach along each periodic axis are looked at, from where the seeds lie inside the box;
// none: those that can touch the cell. options: box, periodic, cell, planes and weights.
ExactDomainCell exact_cell(std::span<const double> points, const votess::Options& options, std::size_t i,
                           std::optional<int> reach = {});

// Rows with shifts, volumes and statuses of all cells against exact_cell(); "" when equal. t: with neighbors, volumes
// and walls, of distinct seeds.
std::string check_against_half_spaces(const votess::Tessellation& t, std::span<const double> points,
                                      const votess::Options& options, std::optional<int> reach = {});

// Volumes fill the domain, rows are symmetric with opposite shifts, empty cells have nothing.
std::string check_domain(const votess::Tessellation& t);

}  // namespace test

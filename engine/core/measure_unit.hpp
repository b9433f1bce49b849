// The units of measures of cells. Measures of a sheet are stored as those of the plane: its volumes as areas, its areas
// as lengths. So they stay in the range of double where those of the plane do.
#pragma once

namespace votess {

// Converts measures in a unit to those of a result.
class MeasureUnit {
public:
    MeasureUnit() = default;
    // length: what stands for 1, a power of two. thickness: of the sheet, another one, in the unit of the result; 0 in
    // space.
    MeasureUnit(double length, double thickness)
        : length_(length), across_(thickness > 0 ? length / thickness : length) {}

    [[nodiscard]] double length(double x) const { return x * length_; }
    // No product leaves the range unless the measure does.
    [[nodiscard]] double area(double x) const { return x * across_ * length_; }
    [[nodiscard]] double volume(double x) const { return x * across_ * length_ * length_; }

private:
    double length_ = 1;
    double across_ = 1;  // the length divided by the thickness
};

}  // namespace votess

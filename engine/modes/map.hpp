#pragma once
/// Maps of the modes over two coefficients of friction, all others fixed.
#include <string>
#include <vector>

#include "engine/modes/prepare.hpp"

namespace pantin::detail::modes {

/// Column i stands for the coefficient low + (high - low) i / (size - 1) of contact `across`, row j
/// for that of contact `up`; both where it rolls and where it slides. Neither is among `fixed`.
struct Slice {
  std::size_t across = 0, up = 1;
  Real low = 0, high = 1;
  std::size_t size = 256;  // columns, and rows; at least 2
  Friction fixed;          // of all contacts; those of the two axes are not read

  Real at(std::size_t i) const {
    return low + (high - low) * static_cast<Real>(i) / static_cast<Real>(size - 1);
  }
};

/// a x y + b x + c y + d of the coefficients across (x) and up (y). 0 on a hyperbola.
struct Bilinear {
  Real a = 0, b = 0, c = 0, d = 0;

  Real at(Real x, Real y) const { return (a * x + c) * y + (b * x + d); }
  /// Where it is 0 at this x; not finite where nowhere.
  Real up_at(Real x) const { return -(b * x + d) / (a * x + c); }
};

/// A region in a slice. Its boundaries lie on the hyperbolas of X, which does not belong to it, and
/// of the forms, which do.
struct Cut {
  Bilinear divisor;
  std::array<Bilinear, 4> forms;
  int form_count = 0;

  /// The sign of X if the mode has forces there, else 0.
  int branch_at(Real x, Real y) const;
};
Cut cut(const Region& r, const Slice& slice);

struct ModeMap {
  std::size_t size = 0;
  std::vector<std::int32_t> regions;  // those that may reach into the slice, in Prepared::regions
  std::vector<std::uint32_t> cells;   // rows from below; bit k: mode regions[k] is feasible
  bool complete = true;               // false, and no cells: more than 32 regions

  std::uint32_t cell(std::size_t column, std::size_t row) const {
    return cells[row * size + column];
  }
};

/// Fills whole spans of every row: along a row each branch of a region is one interval. Refilling a
/// map allocates nothing.
void draw_by_spans(const Prepared& p, const Slice& slice, ModeMap& map);
/// Evaluates every region at every pixel; the same map but for pixels on a boundary.
void draw_by_pixels(const Prepared& p, const Slice& slice, ModeMap& map);

/// A character for each mode of a map: of three contacts or two 1 = 3S, 2 = R1S2, 3 = R1S3,
/// 4 = R2S1, 5 = R2S3, 6 = R3S1, 7 = R3S2, of more in the order of the map from 1 to 9 and on from
/// a. [Trinkle & Zeng 1995]
char character_of(const Prepared& p, const ModeMap& map, std::size_t k);
/// `columns` by `rows` cells of the map as text, highest row first. A cell shows the character of
/// every mode that is feasible there, a dot if none is.
std::string as_text(const Prepared& p, const ModeMap& map, std::size_t columns, std::size_t rows);
/// "1 3S", ...: a line for each mode that is feasible somewhere in the map.
std::string legend_of(const Prepared& p, const ModeMap& map);
/// A line for each pixel: both coefficients, the number of modes, their names.
std::string as_csv(const Prepared& p, const Slice& slice, const ModeMap& map);

}  // namespace pantin::detail::modes

#include "engine/modes/map.hpp"

#include <algorithm>
#include <cstdio>

#include "engine/base/check.hpp"

namespace pantin::detail::modes {
namespace {

constexpr std::size_t kMostInMap = 32;

/// Own frictions along the slice's axes: their places, or 3.
struct Axes {
  std::size_t x = 3, y = 3;
  OwnFriction fixed{};
};

Axes axes_of(const Region& r, const Slice& slice) {
  Axes axes;
  for (std::size_t k = 0; k < static_cast<std::size_t>(r.variables()); ++k) {
    if (r.contacts[k] == slice.across) axes.x = k;
    if (r.contacts[k] == slice.up) axes.y = k;
  }
  axes.fixed = own(r, slice.fixed);
  return axes;
}

/// One term of a form: a coefficient times the frictions among `variables` in `mask`.
template <std::size_t N>
struct Term {
  Real coefficient;
  std::size_t mask;
  std::array<std::uint8_t, N> variables;
};

/// Adds a term, its fixed frictions multiplied out.
template <std::size_t N>
void add_term(Bilinear& sum, const Term<N>& of, const Axes& axes) {
  bool x = false, y = false;
  Real term = of.coefficient;
  for (std::size_t i = 0; i < N; ++i) {
    if (!(of.mask >> i & 1)) continue;
    if (of.variables[i] == axes.x)
      x = true;
    else if (of.variables[i] == axes.y)
      y = true;
    else
      term *= axes.fixed[of.variables[i]];
  }
  (x ? (y ? sum.a : sum.b) : (y ? sum.c : sum.d)) += term;
}

/// Columns [first, last) of a row.
struct Span {
  int first = 0, last = 0;
};

/// The first whole number not below t and the first above it, within -1 and size + 1.
struct Bounds {
  int ceiling, above;
};
Bounds bounds_of(Real t, Real size) {
  const Real within = std::clamp(t, -1.0, size);
  const int down = static_cast<int>(within + 2) - 2;
  const bool whole = static_cast<Real>(down) == within;
  return {whole ? down : down + 1, down + 1};
}

/// Whether a form may be 0.
enum class Zero : std::uint8_t { taken, left_out };

/// The spans of a row in the branches X > 0 and X < 0.
struct RowSpans {
  Span plus, minus;
  Real size;

  explicit RowSpans(int columns)
      : plus{0, columns}, minus{0, columns}, size(static_cast<Real>(columns)) {}

  /// A form p + q i, in columns i, that must have the sign of the branch, or may be 0.
  void restrict_to(Real p, Real q, Zero zero) {
    const bool strict = zero == Zero::left_out;
    if (q == 0) {
      if (p < 0 || (strict && p == 0)) plus.last = 0;
      if (p > 0 || (strict && p == 0)) minus.last = 0;
      return;
    }
    const Bounds at = bounds_of(-p / q, size);
    Span& above = q > 0 ? plus : minus;
    Span& below = q > 0 ? minus : plus;
    above.first = std::max(above.first, strict ? at.above : at.ceiling);
    below.last = std::min(below.last, strict ? at.ceiling : at.above);
  }
};

void fill(std::uint32_t* row, Span span, std::uint32_t bit) {
  for (int i = span.first; i < span.last; ++i) row[i] |= bit;
}

/// Cells of a row, and the bit of a mode in them.
struct RowCells {
  std::uint32_t* cells;
  std::uint32_t bit;
};

void draw_row(const Cut& c, Real y, const Slice& slice, const RowCells& row) {
  const Real step = (slice.high - slice.low) / static_cast<Real>(slice.size - 1);
  RowSpans spans(static_cast<int>(slice.size));
  const auto restrict_to = [&](const Bilinear& f, Zero zero) {
    const Real slope = f.a * y + f.b;
    spans.restrict_to(f.c * y + f.d + slope * slice.low, slope * step, zero);
  };
  restrict_to(c.divisor, Zero::left_out);
  for (int i = 0; i < c.form_count; ++i)
    restrict_to(c.forms[static_cast<std::size_t>(i)], Zero::taken);
  fill(row.cells, spans.plus, row.bit);
  fill(row.cells, spans.minus, row.bit);
}

/// So many neighbouring pixels of a row are tested together.
constexpr std::size_t kLanes = 32;

/// Evaluates what Cut::branch_at does, to the bit, without branches: all forms at all pixels.
class Lanes {
 public:
  Lanes(const Slice& slice, std::size_t first) : count_(std::min(kLanes, slice.size - first)) {
    for (std::size_t i = 0; i < kLanes; ++i) x_[i] = slice.at(first + std::min(i, count_ - 1));
  }
  void draw(const Cut& c, Real y, const RowCells& row) {
    std::array<Real, kLanes> over, least, most;
    for (std::size_t i = 0; i < kLanes; ++i) over[i] = c.divisor.at(x_[i], y);
    least = most = over;  // the sign of X is tested anyway
    for (int f = 0; f < c.form_count; ++f) {
      const Bilinear& form = c.forms[static_cast<std::size_t>(f)];
      for (std::size_t i = 0; i < kLanes; ++i) {
        const Real value = form.at(x_[i], y);
        least[i] = value < least[i] ? value : least[i];
        most[i] = value > most[i] ? value : most[i];
      }
    }
    for (std::size_t i = 0; i < count_; ++i) {
      // Integer arithmetic instead of logic: no branch.
      const std::uint32_t plus = over[i] > 0, minus = over[i] < 0;
      const std::uint32_t above = least[i] >= 0, below = most[i] <= 0;
      row.cells[i] |= row.bit & -((plus & above) | (minus & below));
    }
  }

 private:
  std::array<Real, kLanes> x_;
  std::size_t count_;
};

void take_regions(const Prepared& p, const Slice& slice, ModeMap& map) {
  PANTIN_ASSERT(slice.size >= 2 && slice.across != slice.up);
  PANTIN_ASSERT(slice.across < p.count && slice.up < p.count);
  map.size = slice.size;
  map.regions.clear();
  for (std::size_t i = 0; i < p.regions.size(); ++i) {
    const Region& r = p.regions[i];
    const Axes axes = axes_of(r, slice);
    OwnFriction low = axes.fixed, high = axes.fixed;
    for (const std::size_t k : {axes.x, axes.y})
      if (k < 3) low[k] = slice.low, high[k] = slice.high;
    if (box(r, low, high) != BoxVerdict::outside)
      map.regions.push_back(static_cast<std::int32_t>(i));
  }
  map.complete = map.regions.size() <= kMostInMap;
  map.cells.assign(map.complete ? slice.size * slice.size : 0, 0);
}

std::uint32_t all_in(const ModeMap& map) {
  std::uint32_t all = 0;
  for (const std::uint32_t cell : map.cells) all |= cell;
  return all;
}

const Region& region_of(const Prepared& p, const ModeMap& map, std::size_t k) {
  return p.regions[static_cast<std::size_t>(map.regions[k])];
}

std::string characters_in(const Prepared& p, const ModeMap& map, std::uint32_t cell) {
  std::string found;
  for (std::size_t k = 0; k < map.regions.size(); ++k)
    if (cell >> k & 1) found += character_of(p, map, k);
  return found.empty() ? "." : found;
}

}  // namespace

int Cut::branch_at(Real x, Real y) const {
  const Real over = divisor.at(x, y);
  const int branch = (over > 0) - (over < 0);
  for (int i = 0; i < form_count; ++i)
    if (branch * forms[static_cast<std::size_t>(i)].at(x, y) < 0) return 0;
  return branch;
}

Cut cut(const Region& r, const Slice& slice) {
  const Axes axes = axes_of(r, slice);
  Cut out;
  constexpr std::array<std::uint8_t, 3> kAll{0, 1, 2};
  for (std::size_t mask = 0; mask < 8; ++mask)
    add_term<3>(out.divisor, {r.divisor[mask], mask, kAll}, axes);
  out.form_count = r.form_count();
  for (int i = 0; i < out.form_count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    for (std::size_t mask = 0; mask < 4; ++mask)
      add_term<2>(out.forms[at], {r.forms[at][mask], mask, form_variables(r.kind, i)}, axes);
  }
  return out;
}

void draw_by_spans(const Prepared& p, const Slice& slice, ModeMap& map) {
  take_regions(p, slice, map);
  if (!map.complete) return;
  std::array<Cut, kMostInMap> cuts;
  for (std::size_t k = 0; k < map.regions.size(); ++k) cuts[k] = cut(region_of(p, map, k), slice);
  for (std::size_t j = 0; j < slice.size; ++j)
    for (std::size_t k = 0; k < map.regions.size(); ++k)
      draw_row(cuts[k], slice.at(j), slice, {&map.cells[j * slice.size], 1u << k});
}

void draw_by_pixels(const Prepared& p, const Slice& slice, ModeMap& map) {
  take_regions(p, slice, map);
  if (!map.complete) return;
  for (std::size_t k = 0; k < map.regions.size(); ++k) {
    const Cut c = cut(region_of(p, map, k), slice);
    for (std::size_t first = 0; first < slice.size; first += kLanes) {
      Lanes lanes(slice, first);
      for (std::size_t j = 0; j < slice.size; ++j)
        lanes.draw(c, slice.at(j), {&map.cells[j * slice.size + first], 1u << k});
    }
  }
}

char character_of(const Prepared& p, const ModeMap& map, std::size_t k) {
  const Region& r = region_of(p, map, k);
  if (p.count > 3) return static_cast<char>(k < 9 ? '1' + k : 'a' + (k - 9));
  if (r.kind == Kind::three_slide) return '1';
  const int other = r.contacts[1] < r.contacts[0] ? r.contacts[1] : r.contacts[1] - 1;
  return static_cast<char>('2' + 2 * r.contacts[0] + other);
}

std::string as_text(const Prepared& p, const ModeMap& map, std::size_t columns, std::size_t rows) {
  const auto nearest = [&](std::size_t i, std::size_t count) {
    return count < 2 ? 0 : (2 * i * (map.size - 1) + count - 1) / (2 * (count - 1));
  };
  std::vector<std::string> cells;
  std::size_t width = 1;
  for (std::size_t j = rows; j-- > 0;)
    for (std::size_t i = 0; i < columns; ++i) {
      cells.push_back(characters_in(p, map, map.cell(nearest(i, columns), nearest(j, rows))));
      width = std::max(width, cells.back().size());
    }
  std::string text;
  auto cell = cells.begin();
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < columns; ++i, ++cell) {
      text += *cell;
      text += i + 1 == columns ? "\n" : std::string(width + 1 - cell->size(), ' ');
    }
  return text;
}

std::string legend_of(const Prepared& p, const ModeMap& map) {
  const std::uint32_t all = all_in(map);
  std::string text;
  for (std::size_t k = 0; k < map.regions.size(); ++k)
    if (all >> k & 1)
      text += character_of(p, map, k) + (" " + short_name(p, region_of(p, map, k))) + "\n";
  return text;
}

std::string as_csv(const Prepared& p, const Slice& slice, const ModeMap& map) {
  std::string text = "mu" + std::to_string(slice.across + 1) + ",mu" +
                     std::to_string(slice.up + 1) + ",count,modes\n";
  for (std::size_t j = 0; j < map.size && map.complete; ++j)
    for (std::size_t i = 0; i < map.size; ++i) {
      std::string names;
      int count = 0;
      for (std::size_t k = 0; k < map.regions.size(); ++k)
        if (map.cell(i, j) >> k & 1)
          names += (count++ ? " " : "") + short_name(p, region_of(p, map, k));
      char numbers[80];
      std::snprintf(numbers, sizeof numbers, "%.9g,%.9g,%d,", slice.at(i), slice.at(j), count);
      text += numbers + names + "\n";
    }
  return text;
}

}  // namespace pantin::detail::modes

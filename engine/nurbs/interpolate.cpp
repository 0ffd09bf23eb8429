// Interpolating splines, and sweeps that rotate.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "engine/nurbs/makers.hpp"

namespace pantin::detail::nurbs {
namespace {

using std::to_string;

/// A banded square system, solved for many right-hand sides at once.
class BandSystem {
 public:
  struct Entry {
    std::size_t row, column;
    Real value;
  };
  BandSystem(std::size_t size, std::span<const Entry> entries);

  /// In place; false if it has no solution, or only an uncertain one.
  bool solve(Rows& right);

 private:
  Real& at(std::size_t row, std::size_t column) {
    return band_[row * width_ + (column + below_ - row)];
  }
  std::size_t end(std::size_t row) const { return std::min(size_, row + below_ + above_ + 1); }
  void swap_rows(std::size_t a, std::size_t b, Rows& right);

  std::size_t size_, below_ = 0, above_ = 0;  // entries of a row beside the diagonal
  std::size_t width_ = 0;                     // of a row, fill-in by exchanged rows included
  std::vector<Real> band_;
};

BandSystem::BandSystem(std::size_t size, std::span<const Entry> entries) : size_(size) {
  for (const Entry& e : entries) {
    if (e.row > e.column) below_ = std::max(below_, e.row - e.column);
    if (e.row < e.column) above_ = std::max(above_, e.column - e.row);
  }
  width_ = 2 * below_ + above_ + 1;
  band_.assign(size * width_, 0);
  for (const Entry& e : entries) at(e.row, e.column) += e.value;
}

// Exchanges two rows, from column `a` on.
void BandSystem::swap_rows(std::size_t a, std::size_t b, Rows& right) {
  if (a == b) return;
  for (std::size_t j = a; j < end(a); ++j) std::swap(at(a, j), at(b, j));
  const auto side = [&](std::size_t row) { return &right.points[row * right.across]; };
  std::swap_ranges(side(a), side(a) + right.across, side(b));
}

// Elimination with row exchanges.
bool BandSystem::solve(Rows& right) {
  const auto side = [&](std::size_t row) { return &right.points[row * right.across]; };
  for (std::size_t k = 0; k < size_; ++k) {
    const std::size_t last = std::min(size_, k + below_ + 1);
    std::size_t best = k;
    for (std::size_t i = k + 1; i < last; ++i)
      if (std::abs(at(i, k)) > std::abs(at(best, k))) best = i;
    swap_rows(k, best, right);
    const Real pivot = at(k, k);
    if (!(std::abs(pivot) > 1e-14)) return false;
    for (std::size_t i = k + 1; i < last; ++i) {
      const Real part = at(i, k) / pivot;
      if (part == 0) continue;
      for (std::size_t j = k; j < end(k); ++j) at(i, j) -= part * at(k, j);
      for (std::size_t c = 0; c < right.across; ++c) side(i)[c] = side(i)[c] - part * side(k)[c];
    }
  }
  for (std::size_t k = size_; k-- > 0;) {
    for (std::size_t j = k + 1; j < end(k); ++j)
      for (std::size_t c = 0; c < right.across; ++c)
        side(k)[c] = side(k)[c] - at(k, j) * side(j)[c];
    for (std::size_t c = 0; c < right.across; ++c) side(k)[c] = (1 / at(k, k)) * side(k)[c];
  }
  return true;
}

// Clamped knots for interpolation at parameters: means of `degree` neighbours. [Piegl & Tiller
// 1997, Eq. 9.8]
Knots mean_knots(std::span<const Real> at, int degree) {
  const int count = static_cast<int>(at.size());
  Knots knots{.degree = degree, .values = {}};
  knots.values.assign(static_cast<std::size_t>(degree + 1), at.front());
  for (int i = 1; i < count - degree; ++i) {
    Real sum = 0;
    for (int j = i; j < i + degree; ++j) sum += at[static_cast<std::size_t>(j)];
    knots.values.push_back(sum / degree);
  }
  knots.values.insert(knots.values.end(), static_cast<std::size_t>(degree + 1), at.back());
  return knots;
}

// Order of cyclic unknowns that keeps neighbours close, so that the band is narrow: from both ends
// in turns.
std::size_t folded(std::size_t i, std::size_t count) {
  return i < (count + 1) / 2 ? 2 * i : 2 * (count - 1 - i) + 1;
}

// Rows of control points such that the spline takes the given rows at the parameters.
std::optional<Rows> through(const Knots& knots, std::span<const Real> at, const Rows& rows) {
  const std::size_t count = at.size(), across = rows.across;
  if (count == 0) return std::nullopt;
  const auto place = [&](std::size_t i) { return knots.is_periodic ? folded(i, count) : i; };
  std::vector<BandSystem::Entry> entries;
  entries.reserve(count * static_cast<std::size_t>(knots.degree + 1));
  Rows right{std::vector<Weighted>(rows.points.size()), across};
  const auto copy_row = [&](const Rows& from, std::size_t row, Rows& to, std::size_t at_row) {
    std::copy_n(from.points.begin() + static_cast<std::ptrdiff_t>(row * across), across,
                to.points.begin() + static_cast<std::ptrdiff_t>(at_row * across));
  };
  Basis basis;
  for (std::size_t i = 0; i < count; ++i) {
    const int span = knots.span_at(at[i]);
    write_basis(knots, {span, at[i]}, 0, basis);
    for (int j = 0; j <= knots.degree; ++j) {
      const auto column = static_cast<std::size_t>(span - knots.degree + j) % count;
      entries.push_back({place(i), place(column), basis[0][j]});
    }
    copy_row(rows, i, right, place(i));
  }
  if (!BandSystem(count, entries).solve(right)) return std::nullopt;
  // The first control points of a periodic spline are repeated at its end.
  const auto all = static_cast<std::size_t>(knots.count());
  Rows solved{std::vector<Weighted>(all * across), across};
  for (std::size_t i = 0; i < all; ++i) copy_row(right, place(i % count), solved, i);
  // Weights that are equal in all rows stay equal to the last digit.
  for (std::size_t c = 0; c < across; ++c) {
    const Real weight = rows.points[c].w;
    bool is_one = true;
    for (std::size_t i = c; i < rows.points.size(); i += across)
      is_one = is_one && rows.points[i].w == weight;
    for (std::size_t i = c; is_one && i < solved.points.size(); i += across)
      solved.points[i].w = weight;
  }
  return solved;
}

Rows rows_of(std::span<const Vec3> points, std::size_t across) {
  Rows rows{{}, across};
  for (Vec3 p : points) rows.points.push_back(Weighted(p, 1));
  return rows;
}

// Parameters by chord length; for periodic curves one more, which closes. Fails if two are equal.
Result<std::vector<Real>> by_chords(std::span<const Vec3> points, Ends ends) {
  std::vector<Real> at{0};
  const std::size_t last = points.size() - (ends == Ends::open ? 1 : 0);
  for (std::size_t i = 0; i < last; ++i) {
    const Real chord = glm::distance(points[i], points[(i + 1) % points.size()]);
    if (!(chord > 0) || !std::isfinite(chord))
      return Error{"points " + to_string(i) + " and " + to_string((i + 1) % points.size()) +
                   ": found a distance of " + to_string(chord) +
                   ", expected points that are apart and finite"};
    at.push_back(at.back() + chord);
  }
  const Real whole = at.back();
  for (Real& t : at) t /= whole;
  at.back() = 1;
  return at;
}

std::optional<Error> misfit(std::size_t count, int degree) {
  if (degree < 1 || degree > kMostDegree)
    return Error{"found degree " + to_string(degree) + ", expected 1 to " + to_string(kMostDegree)};
  if (count > static_cast<std::size_t>(degree)) return std::nullopt;
  return Error{"found " + to_string(count) + " points, expected at least " + to_string(degree + 1) +
               " for degree " + to_string(degree)};
}

const Error kSingular{"points: found parameters that no spline of this degree fits"};

// Knots that repeat with period 1 and give every parameter a basis function of its own: at the
// parameters for odd degrees, midway for even ones.
Knots periodic_knots(std::span<const Real> at, int degree) {
  const int count = static_cast<int>(at.size()) - 1;
  const auto repeated = [&](int i) {
    const int round = i >= 0 ? i / count : -((-i + count - 1) / count);
    return at[static_cast<std::size_t>(i - round * count)] + round;
  };
  Knots knots{.degree = degree, .values = {}, .is_periodic = true};
  for (int i = -degree; i <= count + degree; ++i)
    knots.values.push_back(degree % 2 == 1 ? repeated(i) : (repeated(i) + repeated(i - 1)) / 2);
  return knots;
}

}  // namespace

Result<Curve> interpolated(std::span<const Vec3> points, int degree, Ends ends) {
  if (const auto wrong = misfit(points.size(), degree)) return *wrong;
  const auto at = by_chords(points, ends);
  if (!at) return at.errors();
  const bool closes = ends == Ends::periodic;
  const Knots knots = closes ? periodic_knots(*at, degree) : mean_knots(*at, degree);
  std::vector<Real> places(at->begin(), at->begin() + static_cast<std::ptrdiff_t>(points.size()));
  for (Real& t : places) t = knots.inside(t);
  auto solved = through(knots, places, rows_of(points, 1));
  if (!solved) return kSingular;
  return Curve{knots, std::move(solved->points)};
}

Result<Surface> interpolated(const PointGrid& grid, std::array<int, 2> degrees) {
  const std::size_t columns = grid.columns > 0 ? static_cast<std::size_t>(grid.columns) : 0;
  if (columns == 0 || grid.points.empty() || grid.points.size() % columns != 0)
    return Error{"found " + to_string(grid.points.size()) + " points in rows of " +
                 to_string(grid.columns) + ", expected whole rows"};
  const std::size_t rows = grid.points.size() / columns;
  if (const auto wrong = misfit(rows, degrees[0])) return *wrong;
  if (const auto wrong = misfit(columns, degrees[1])) return *wrong;
  std::vector<Real> u(rows, 0), v(columns, 0);
  std::vector<Vec3> strip;
  for (std::size_t j = 0; j < columns; ++j) {
    strip.clear();
    for (std::size_t i = 0; i < rows; ++i) strip.push_back(grid.points[i * columns + j]);
    const auto at = by_chords(strip, Ends::open);
    if (!at) return Error{"column " + to_string(j) + ", " + at.errors()[0].message};
    for (std::size_t i = 0; i < rows; ++i) u[i] += (*at)[i] / Real(columns);
  }
  for (std::size_t i = 0; i < rows; ++i) {
    const auto at = by_chords(grid.points.subspan(i * columns, columns), Ends::open);
    if (!at) return Error{"row " + to_string(i) + ", " + at.errors()[0].message};
    for (std::size_t j = 0; j < columns; ++j) v[j] += (*at)[j] / Real(rows);
  }
  u.back() = v.back() = 1;
  const Knots by_u = mean_knots(u, degrees[0]), by_v = mean_knots(v, degrees[1]);
  auto half = through(by_u, u, rows_of(grid.points, columns));
  if (!half) return kSingular;
  auto whole = through(by_v, v, turned(*half));
  if (!whole) return kSingular;
  return Surface{by_u, by_v, turned(*whole).points};
}

// ---- Sweeps ------------------------------------------------------------------------------------

namespace {

struct Station {
  Vec3 at, tangent, normal;
};

Vec3 any_across(Vec3 v) {
  const Vec3 a = glm::abs(v);
  const Vec3 axis =
      a.x < a.y && a.x < a.z ? Vec3(1, 0, 0) : (a.y < a.z ? Vec3(0, 1, 0) : Vec3(0, 0, 1));
  return glm::normalize(glm::cross(v, axis));
}

Vec3 mirrored(Vec3 v, Vec3 across) {
  const Real length = glm::dot(across, across);
  return length > 0 ? v - 2 * glm::dot(across, v) / length * across : v;
}

// Rotation-minimising frames along a path, by two reflections each. [Wang 2008]
std::vector<Station> stations_on(const Curve& path, std::span<const Real> at) {
  std::vector<Station> all;
  for (Real t : at) {
    const CurveDerivatives d = evaluate(path, t, 1);
    Station here{d[0], glm::normalize(d[1]), Vec3(0)};
    if (all.empty()) {
      here.normal = any_across(here.tangent);
    } else {
      const Station& before = all.back();
      const Vec3 step = here.at - before.at;
      const Vec3 normal = mirrored(before.normal, step), tangent = mirrored(before.tangent, step);
      here.normal = mirrored(normal, here.tangent - tangent);
    }
    all.push_back(here);
  }
  return all;
}

}  // namespace

Surface swept_turning(const Curve& section, const Curve& path, int stations) {
  const int degree = std::min(3, stations - 1);
  std::vector<Real> at;
  const Range range = path.knots.domain();
  for (int i = 0; i < stations; ++i)
    at.push_back(i + 1 == stations ? range.high : range.low + range.width() * i / (stations - 1));
  Rows rows{{}, section.points.size()};
  for (const Station& s : stations_on(path, at)) {
    const Vec3 side = glm::cross(s.tangent, s.normal);
    for (const Weighted& w : section.points) {
      const Vec3 p = w.point();
      rows.points.push_back(Weighted(s.at + p.x * s.normal + p.y * side, w.w));
    }
  }
  const Knots along = mean_knots(at, degree);
  auto solved = through(along, at, rows);  // regular: the knots are means
  return {along, section.knots, std::move(solved->points)};
}

}  // namespace pantin::detail::nurbs

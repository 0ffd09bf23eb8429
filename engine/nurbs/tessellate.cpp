#include "engine/nurbs/tessellate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/trim_tiles.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr int kMostCuts = 64;  // of a piece, one way
constexpr int kProbes = 5;     // of a piece, one way, for its bend
constexpr Real kWeld = 1e-9;   // of the size, plus the skin's tolerance: closer corners coincide

/// Sides of the square of parameters, in the order of Edge.
bool is_of_u(Edge edge) { return edge == Edge::u_low || edge == Edge::u_high; }

/// Parameters at which a face is cut, both ends included.
struct Lines {
  std::vector<Real> u, v;
};

/// The sagitta of a step h at second derivative `bend` is bend h^2 / 8. Each direction gets half of
/// the tolerance.
int cuts_for(Real bend, Real width, Real chord) {
  const Real cuts = std::ceil(width * std::sqrt(bend / (4 * chord)));
  return std::isfinite(cuts) ? static_cast<int>(std::clamp(cuts, Real(1), Real(kMostCuts)))
                             : kMostCuts;
}

/// The normal part of a second derivative; the tangential part does not curve.
Real bend_of(Vec3 first, Vec3 second) {
  const Real speed = glm::length(first);
  if (!(speed > 0)) return glm::length(second);
  return glm::length(second - glm::dot(second, first) / (speed * speed) * first);
}

std::vector<Real> lines_along(const Face& face, Along way, Real chord) {
  const bool is_u = way == Along::u;
  const Knots& own = is_u ? face.u() : face.v();
  const Range across = (is_u ? face.v() : face.u()).domain();
  const std::vector<Real> breaks = own.breaks();
  const int others = kProbes * static_cast<int>((is_u ? face.v() : face.u()).spans().size());
  std::vector<Real> lines{breaks.front()};
  const int least = breaks.size() < 4 ? 3 : 1;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const Range piece{breaks[i], breaks[i + 1]};
    Real bend = 0;
    for (int j = 0; j < kProbes; ++j)
      for (int k = 0; k < others; ++k) {
        const Real t = piece.low + piece.width() * (j + 0.5) / kProbes;
        const Real s = across.low + across.width() * k / (others - 1);
        const Jet jet = is_u ? face.at(t, s) : face.at(s, t);
        bend = std::max(bend, is_u ? bend_of(jet.u, jet.uu) : bend_of(jet.v, jet.vv));
      }
    const int cuts = std::max(least, cuts_for(bend, piece.width(), chord));
    for (int j = 1; j < cuts; ++j) lines.push_back(piece.low + piece.width() * j / cuts);
    lines.push_back(piece.high);
  }
  return lines;
}

/// Points along one edge of a face, in its own direction, corners included.
struct Polyline {
  std::vector<Real> at;
  std::vector<Vec3> points;
};

class Cutter {
 public:
  Cutter(const Skin& skin, Real chord) : skin_(skin), chord_(chord) {
    for (const Face& face : skin.faces())
      lines_.push_back({lines_along(face, Along::u, chord), lines_along(face, Along::v, chord)});
  }
  Tessellation run();

 private:
  struct EdgeOf {
    int face;
    Edge edge;
    auto operator<=>(const EdgeOf&) const = default;
  };
  const std::vector<Real>& lines_of(const EdgeOf& e) const {
    const Lines& lines = lines_[static_cast<std::size_t>(e.face)];
    return is_of_u(e.edge) ? lines.v : lines.u;
  }
  std::array<Real, 2> parameters(const EdgeOf& e, Real t) const;
  Polyline own_line(const EdgeOf& e) const;
  void lay_edges();
  void lay_joined(const EdgeOf& from);
  Vec3 welded(Vec3 corner);
  std::uint32_t add(int face, std::array<Real, 2> at, Vec3 point);
  void cut(int face);
  struct Row {
    std::vector<Real> at;
    std::vector<std::uint32_t> vertices;
  };
  enum class Turn : std::uint8_t { left, right };
  void zip(const Row& outer, const Row& inner, Turn turn);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);

  const Skin& skin_;
  Real chord_;
  std::vector<Lines> lines_;
  std::map<EdgeOf, Polyline> edges_;
  std::vector<Vec3> corners_;
  Tessellation made_;
};

std::array<Real, 2> Cutter::parameters(const EdgeOf& e, Real t) const {
  const Face& face = skin_.face(e.face);
  switch (e.edge) {
    case Edge::u_low:
      return {face.u().low(), t};
    case Edge::u_high:
      return {face.u().high(), t};
    case Edge::v_low:
      return {t, face.v().low()};
    case Edge::v_high:
      break;
  }
  return {t, face.v().high()};
}

/// Merges corners that coincide: the first one found is used.
Vec3 Cutter::welded(Vec3 corner) {
  const Real near = kWeld * skin_.size() + skin_.tolerance();
  for (const Vec3 known : corners_)
    if (glm::distance(known, corner) <= near) return known;
  return corners_.emplace_back(corner);
}

Polyline Cutter::own_line(const EdgeOf& e) const {
  Polyline line;
  for (const Real t : lines_of(e)) {
    const auto at = parameters(e, t);
    line.at.push_back(t), line.points.push_back(skin_.face(e.face).at(at[0], at[1]).s);
  }
  return line;
}

/// Gives the other side of a joined edge the same points, at its own parameters.
void Cutter::lay_joined(const EdgeOf& from) {
  const Polyline& line = edges_.at(from);
  std::optional<EdgeOf> to;
  std::vector<std::pair<Real, Vec3>> pairs;
  for (std::size_t i = 0; i < line.at.size(); ++i) {
    const auto at = parameters(from, line.at[i]);
    const auto there = skin_.across({from.face, at[0], at[1]}, from.edge);
    if (!there) return;
    if (!to) {
      for (int k = 0; k < kEdges && !to; ++k) {
        const EdgeOf e{there->face, static_cast<Edge>(k)};
        if (skin_.neighbour(e.face, e.edge) != from.face || edges_.contains(e)) continue;
        const auto on = parameters(e, is_of_u(e.edge) ? there->v : there->u);
        const Vec3 point = skin_.face(e.face).at(on[0], on[1]).s;
        if (glm::distance(point, line.points[i]) <= skin_.tolerance() + kWeld * skin_.size())
          to = e;
      }
      if (!to) return;
    }
    pairs.emplace_back(is_of_u(to->edge) ? there->v : there->u, line.points[i]);
  }
  // On a closed line the ends do not give the direction.
  if (pairs[1].first > pairs[pairs.size() - 2].first) std::reverse(pairs.begin(), pairs.end());
  const std::vector<Real>& own = lines_of(*to);
  pairs.front().first = own.front(), pairs.back().first = own.back();
  Polyline other;
  for (const auto& [t, point] : pairs) other.at.push_back(t), other.points.push_back(point);
  edges_.emplace(*to, std::move(other));
}

void Cutter::lay_edges() {
  std::vector<EdgeOf> order;
  for (int f = 0; f < static_cast<int>(skin_.faces().size()); ++f)
    for (int k = 0; k < kEdges; ++k) order.push_back({f, static_cast<Edge>(k)});
  // The finer side of a joined edge decides where it is cut.
  std::stable_sort(order.begin(), order.end(), [&](const EdgeOf& a, const EdgeOf& b) {
    return lines_of(a).size() > lines_of(b).size();
  });
  for (const EdgeOf& e : order) {
    if (edges_.contains(e)) continue;
    Polyline line = own_line(e);
    line.points.front() = welded(line.points.front());
    line.points.back() = welded(line.points.back());
    const bool is_point = std::all_of(line.points.begin(), line.points.end(), [&](Vec3 p) {
      return glm::distance(p, line.points.front()) <= kWeld * skin_.size();
    });
    if (is_point) std::fill(line.points.begin(), line.points.end(), line.points.front());
    edges_.emplace(e, std::move(line));
    if (skin_.neighbour(e.face, e.edge)) lay_joined(e);
  }
  // Both ends of a periodic direction share one line.
  for (int f = 0; f < static_cast<int>(skin_.faces().size()); ++f) {
    const Face& face = skin_.face(f);
    if (face.u().is_periodic) edges_[{f, Edge::u_high}] = edges_[{f, Edge::u_low}];
    if (face.v().is_periodic) edges_[{f, Edge::v_high}] = edges_[{f, Edge::v_low}];
  }
}

std::uint32_t Cutter::add(int face, std::array<Real, 2> at, Vec3 point) {
  made_.points.push_back(point);
  made_.normals.push_back(normal_at(skin_.face(face), at[0], at[1]));
  made_.places.push_back({face, at[0], at[1]});
  return static_cast<std::uint32_t>(made_.points.size() - 1);
}

void Cutter::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::vector<Vec3>& p = made_.points;
  if (p[a] != p[b] && p[b] != p[c] && p[c] != p[a]) made_.triangles.push_back({a, b, c});
}

/// Triangles between two parallel rows of vertices, the inner one left or right of the outer one.
void Cutter::zip(const Row& outer, const Row& inner, Turn turn) {
  std::size_t i = 0, j = 0;
  while (i + 1 < outer.at.size() || j + 1 < inner.at.size()) {
    const bool is_outer =
        j + 1 >= inner.at.size() ||
        (i + 1 < outer.at.size() && outer.at[i + 1] + outer.at[i] <= inner.at[j + 1] + inner.at[j]);
    const std::uint32_t a = outer.vertices[i], b = inner.vertices[j],
                        next = is_outer ? outer.vertices[++i] : inner.vertices[++j];
    if (turn == Turn::left)
      add_triangle(a, next, b);
    else
      add_triangle(a, b, next);
  }
}

/// A grid of the inner lines, and four strips from it to the edges.
void Cutter::cut(int f) {
  const Lines& lines = lines_[static_cast<std::size_t>(f)];
  const Face& face = skin_.face(f);
  const std::size_t columns = lines.v.size() - 2, rows = lines.u.size() - 2;
  std::vector<std::uint32_t> grid;
  for (std::size_t i = 1; i <= rows; ++i)
    for (std::size_t j = 1; j <= columns; ++j)
      grid.push_back(add(f, {lines.u[i], lines.v[j]}, face.at(lines.u[i], lines.v[j]).s));
  const auto at = [&](std::size_t i, std::size_t j) { return grid[i * columns + j]; };
  for (std::size_t i = 0; i + 1 < rows; ++i)
    for (std::size_t j = 0; j + 1 < columns; ++j) {
      add_triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      add_triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  const std::vector<Real> inner_u(lines.u.begin() + 1, lines.u.end() - 1);
  const std::vector<Real> inner_v(lines.v.begin() + 1, lines.v.end() - 1);
  for (int k = 0; k < kEdges; ++k) {
    const EdgeOf e{f, static_cast<Edge>(k)};
    const Polyline& line = edges_.at(e);
    Row outer{line.at, {}}, inner{is_of_u(e.edge) ? inner_v : inner_u, {}};
    for (std::size_t i = 0; i < line.at.size(); ++i)
      outer.vertices.push_back(add(f, parameters(e, line.at[i]), line.points[i]));
    const bool is_low = e.edge == Edge::u_low || e.edge == Edge::v_low;
    for (std::size_t i = 0; i < inner.at.size(); ++i)
      inner.vertices.push_back(is_of_u(e.edge) ? at(is_low ? 0 : rows - 1, i)
                                               : at(i, is_low ? 0 : columns - 1));
    // Along u the inside is left of the low end of v; along v it is right of the low end of u.
    zip(outer, inner, is_of_u(e.edge) != is_low ? Turn::left : Turn::right);
  }
}

Tessellation Cutter::run() {
  lay_edges();
  bool any_trim = false;
  for (int f = 0; f < static_cast<int>(skin_.faces().size()); ++f) {
    const std::size_t first = made_.triangles.size();
    cut(f);
    if (!skin_.face(f).trim()) continue;
    trim_tiles(skin_, {f, first}, chord_, made_);
    any_trim = true;
  }
  if (any_trim) drop_unused_points(made_);
  return std::move(made_);
}

/// The other side of a tessellation of an ellipsoid by charts.
Tessellation turned_over(Tessellation made) {
  for (Vec3& n : made.normals) n = -n;
  for (Place& place : made.places) place.u = -place.u;
  for (auto& t : made.triangles) std::swap(t[1], t[2]);
  return made;
}

/// Six sides of a cube projected to the ellipsoid, since its charts overlap.
Tessellation of_ellipsoid(const Skin& skin, Real chord) {
  const Vec3 half = *skin.half_axes();
  const Real most = std::max({half.x, half.y, half.z}), least = std::min({half.x, half.y, half.z});
  const int cuts = std::clamp(cuts_for(most * most / least, kPi / 2, chord), 4, 2 * kMostCuts);
  Tessellation made;
  for (int side = 0; side < 6; ++side) {
    const auto first = static_cast<std::uint32_t>(made.points.size());
    const int axis = side / 2, sign = side % 2 == 0 ? 1 : -1;
    for (int i = 0; i <= cuts; ++i)
      for (int j = 0; j <= cuts; ++j) {
        Vec3 d(0);
        d[axis] = sign;
        // Exactly -1 and 1 at the ends, so that sides meet to the bit.
        const auto run = [&](int k) {
          const int from_middle = 2 * k - cuts;
          return std::abs(from_middle) == cuts
                     ? Real(from_middle > 0 ? 1 : -1)
                     : std::copysign(std::tan(kPi / 4 * std::abs(from_middle) / cuts),
                                     Real(from_middle));
        };
        d[(axis + 1) % 3] = run(i), d[(axis + 2) % 3] = sign * run(j);
        const Vec3 unit = d / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z), p = half * unit;
        const ChartPoint at = chart_point(half, p);
        made.points.push_back(p), made.normals.push_back(glm::normalize(unit / half));
        made.places.push_back({at.chart, at.u, at.v});
      }
    const auto row = static_cast<std::uint32_t>(cuts + 1);
    for (std::uint32_t i = 0; i + 1 < row; ++i)
      for (std::uint32_t j = 0; j + 1 < row; ++j) {
        const std::uint32_t a = first + i * row + j, b = a + row;
        made.triangles.push_back({a, b, b + 1}), made.triangles.push_back({a, b + 1, a + 1});
      }
  }
  return made;
}

}  // namespace

Vec3 normal_at(const Face& face, Real u, Real v) {
  const Range us = face.u().domain(), vs = face.v().domain();
  const Real least = 1e-9 * face.size() * face.size() / (us.width() * vs.width());
  const auto normal = [&](Real s, Real t) {
    const Jet j = face.at(s, t);
    const Vec3 n = glm::cross(j.u, j.v);
    const Real length = glm::length(n);
    return length > least ? n / length : Vec3(0);
  };
  Vec3 n = normal(u, v);
  for (Real inwards = 1e-5; n == Vec3(0) && inwards < 1; inwards *= 10)
    n = normal(u + inwards * (us.middle() - u), v + inwards * (vs.middle() - v));
  return n == Vec3(0) ? Vec3(0, 1, 0) : n;
}

Tessellation tessellate(const Skin& skin, Real chord) {
  if (!skin.half_axes()) return Cutter(skin, chord).run();
  Tessellation made = of_ellipsoid(skin, chord);
  return skin.is_ellipsoid_cavity() ? turned_over(std::move(made)) : made;
}

}  // namespace pantin::detail::nurbs

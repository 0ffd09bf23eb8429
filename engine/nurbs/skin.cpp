#include "engine/nurbs/skin.hpp"

#include <algorithm>
#include <cmath>

#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/makers.hpp"

namespace pantin::detail::nurbs {
namespace {

bool is_of_u(Edge edge) { return edge == Edge::u_low || edge == Edge::u_high; }
bool is_low(Edge edge) { return edge == Edge::u_low || edge == Edge::v_low; }

// Parameters at a fraction of an edge.
std::array<Real, 2> along(const Face& face, Edge edge, Real share) {
  const Range u = face.u().domain(), v = face.v().domain();
  const Range& own = is_of_u(edge) ? u : v;
  const Range& other = is_of_u(edge) ? v : u;
  const Real fixed = is_low(edge) ? own.low : own.high, free = other.low + share * other.width();
  return is_of_u(edge) ? std::array{fixed, free} : std::array{free, fixed};
}

Vec3 point_along(const Face& face, Edge edge, Real share) {
  const auto at = along(face, edge, share);
  return face.at(at[0], at[1]).s;
}

constexpr int kProbes = 9;

// Whether every sample of one edge is on the other; their parametrisations may differ.
bool do_meet(const Curve& one, const Curve& two, Real tolerance) {
  const Wire other(two);
  const Range range = one.knots.domain();
  for (int i = 0; i < kProbes; ++i) {
    const Real t = range.low + range.width() * i / (kProbes - 1);
    if (closest_point(other, evaluate(one, t, 0)[0]).distance > tolerance) return false;
  }
  return true;
}

Curve edge_curve(const Face& face, Edge edge) {
  const Along way = is_of_u(edge) ? Along::u : Along::v;
  const Knots& k = is_of_u(edge) ? face.u() : face.v();
  Curve curve = isoline(face.surface(), way, is_low(edge) ? k.low() : k.high());
  curve.knots.is_periodic = false;
  return curve;
}

bool is_open_edge(const Face& face, Edge edge) {
  return !(is_of_u(edge) ? face.u() : face.v()).is_periodic;
}

}  // namespace

Skin::Skin(std::vector<Surface> faces, Real tolerance)
    : sources_(std::move(faces)), tolerance_(tolerance) {
  make_faces(sources_);
  join(tolerance_);
}

Skin::Skin(Vec3 half_axes, OuterSide side)
    : half_axes_(half_axes), is_cavity_(side == OuterSide::in) {
  auto six = charts(half_axes);
  if (is_cavity_)
    for (Surface& chart : six) chart = inside_out(chart);
  make_faces({six.begin(), six.end()});
}

namespace {

bool lies_in_plane(const Surface& s) {
  const auto at = [&](int i, int j) { return s.at(i, j).point(); };
  const Vec3 corner = at(0, 0);
  const Vec3 across = glm::cross(at(s.u.count() - 1, 0) - corner, at(0, s.v.count() - 1) - corner);
  const Real area = glm::length(across);
  if (!(area > 0)) return false;  // a closed surface
  for (int i = 0; i < s.u.count(); ++i)
    for (int j = 0; j < s.v.count(); ++j)
      if (!(std::abs(glm::dot(across, at(i, j) - corner)) <= 1e-12 * area * std::sqrt(area)))
        return false;
  return true;
}

}  // namespace

void Skin::make_faces(const std::vector<Surface>& surfaces) {
  faces_.clear(), size_ = 0;
  for (const Surface& s : surfaces) faces_.emplace_back(s);
  for (const Face& f : faces_) size_ = std::max(size_, f.size());
  joins_.assign(faces_.size() * kEdges, {});
  is_flat_ = surfaces.size() == 1 && lies_in_plane(surfaces.front());
  Hash hash;
  hash_fields(hash, *this);
  fingerprint_ = hash.value();
}

const char* Skin::restored() {
  if (half_axes_) {
    const Vec3 h = *half_axes_;
    for (int i = 0; i < 3; ++i)
      if (!(h[i] > 0) || !std::isfinite(h[i])) return "is an ellipsoid of no size";
    *this = Skin(h, is_cavity_ ? OuterSide::in : OuterSide::out);
    return nullptr;
  }
  if (sources_.empty()) return "is a skin without faces";
  if (!(tolerance_ >= 0) || !std::isfinite(tolerance_))
    return "has a tolerance that is not finite or below 0";
  for (const Surface& s : sources_)
    if (!errors_of(s, "surface").empty()) return "is a surface that cannot be evaluated";
  *this = Skin(std::move(sources_), tolerance_);
  return nullptr;
}

Skin Skin::ellipsoid(Vec3 half_axes) { return Skin(half_axes, OuterSide::out); }
Skin Skin::ellipsoid_cavity(Vec3 half_axes) { return Skin(half_axes, OuterSide::in); }

void Skin::join(Real tolerance) {
  const int edges = static_cast<int>(faces_.size()) * kEdges;
  const auto face_at = [&](int e) -> const Face& { return face(e / kEdges); };
  const auto edge_at = [](int e) { return static_cast<Edge>(e % kEdges); };
  for (int e = 0; e < edges; ++e) {
    if (!is_open_edge(face_at(e), edge_at(e))) continue;
    const Curve one = edge_curve(face_at(e), edge_at(e));
    const Vec3 begin = point_along(face_at(e), edge_at(e), 0);
    const Vec3 end = point_along(face_at(e), edge_at(e), 1);
    for (int f = e + 1; f < edges; ++f) {
      if (!is_open_edge(face_at(f), edge_at(f))) continue;
      const Vec3 from = point_along(face_at(f), edge_at(f), 0);
      const Vec3 to = point_along(face_at(f), edge_at(f), 1);
      const bool forward =
          std::max(glm::distance(begin, from), glm::distance(end, to)) <= tolerance;
      const bool backward =
          std::max(glm::distance(begin, to), glm::distance(end, from)) <= tolerance;
      if (!forward && !backward) continue;
      // A degenerate edge (one point) joins nothing.
      const Vec3 middle = point_along(face_at(e), edge_at(e), 0.5);
      if (glm::distance(begin, end) <= tolerance && glm::distance(begin, middle) <= tolerance)
        continue;
      // The ends of a closed edge coincide: a point a quarter along it gives the direction.
      const Vec3 quarter = point_along(face_at(e), edge_at(e), 0.25);
      const bool is_against =
          !forward ||
          (backward && glm::distance(quarter, point_along(face_at(f), edge_at(f), 0.75)) <
                           glm::distance(quarter, point_along(face_at(f), edge_at(f), 0.25)));
      if (!do_meet(one, edge_curve(face_at(f), edge_at(f)), tolerance)) continue;
      joins_[static_cast<std::size_t>(e)] = {f / kEdges, edge_at(f), is_against};
      joins_[static_cast<std::size_t>(f)] = {e / kEdges, edge_at(e), is_against};
    }
  }
}

std::optional<int> Skin::neighbour(int face, Edge edge) const {
  const Join& to = join_of(face, edge);
  return to.face < 0 ? std::nullopt : std::optional(to.face);
}

std::optional<Place> Skin::across(const Place& at, Edge edge) const {
  const Face& from = face(at.face);
  const Vec3 point = from.at(at.u, at.v).s;
  if (half_axes_) {
    const ChartPoint to = chart_point(*half_axes_, point);
    return Place{to.chart, is_cavity_ ? -to.u : to.u, to.v};
  }
  const Join& to = join_of(at.face, edge);
  if (to.face < 0) return std::nullopt;
  const Range run = is_of_u(edge) ? from.v().domain() : from.u().domain();
  const Real share = ((is_of_u(edge) ? at.v : at.u) - run.low) / run.width();
  const auto start = along(face(to.face), to.edge, to.is_backward ? 1 - share : share);
  const NearestPoint there = closest_from(face(to.face), point, start);
  return Place{to.face, there.u, there.v};
}

}  // namespace pantin::detail::nurbs

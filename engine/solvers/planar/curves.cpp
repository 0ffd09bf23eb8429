#include "engine/solvers/planar/curves.hpp"

#include <algorithm>
#include <cmath>

#include "engine/nurbs/curve_pair.hpp"
#include "engine/solvers/planar/island.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::detail::planar {
namespace {

/// Relative rotation (rad), and displacement as a fraction of the smaller curve's size, after which
/// all pairs are searched again; and the largest gap of a kept pair, as a fraction of that size.
constexpr Real kSearchTurn = 0.05, kSearchWay = 0.05, kKept = 0.5;
// Contact points nearer than this fraction of the smaller curve's size are the same.
constexpr Real kSame = 1e-3;
constexpr std::size_t kMostPairs = 16;
// How far beside a point a straight piece may begin, of the domain; curvature limits of straight
// pieces, of 1 / size.
constexpr Real kBeside[] = {-1e-6, 1e-6}, kStraight = 1e-6, kBends = 0.01;

Real cross(Vec3 a, Vec3 b) { return a.x * b.y - a.y * b.x; }

struct Turn2 {
  Real cosine, sine;
  explicit Turn2(Real angle) : cosine(std::cos(angle)), sine(std::sin(angle)) {}
  Vec3 operator()(Vec3 v) const {
    return {cosine * v.x - sine * v.y, sine * v.x + cosine * v.y, 0};
  }
  Vec3 back(Vec3 v) const { return {cosine * v.x + sine * v.y, cosine * v.y - sine * v.x, 0}; }
};

Vec3 flat(Vec3 v) { return {v.x, v.y, 0}; }

/// Both curves at the current poses.
struct Standing {
  Vec3 origin_a, origin_b;  // of the curves, from b's mass centre
  Turn2 turn_b;
  Pose a_in_b;
};
Standing standing(const FlatCurve& c, const Motions& m) {
  const Vec3 at_a = m.position[c.a], at_b = m.position[c.b];
  const Vec3 origin_a = flat(at_a - at_b) + Turn2(at_a.z)(c.sides[0].arm);
  const Vec3 origin_b = Turn2(at_b.z)(c.sides[1].arm);
  const Turn2 turn_b(at_b.z + c.sides[1].angle);
  const Real half =
      0.5 * std::remainder(at_a.z + c.sides[0].angle - at_b.z - c.sides[1].angle, 2 * kPi);
  return {origin_a,
          origin_b,
          turn_b,
          {turn_b.back(origin_a - origin_b), Quat(std::cos(half), 0, 0, std::sin(half))}};
}

/// The data of a contact point relative to the mass centres.
struct Seen {
  const FlatCurve& curve;
  const Standing& at;
  const Motions& m;
};
PlaceNow placed(const Seen& s, const nurbs::CurveContact& f, PlaceNow now) {
  now.place.t_a = f.t, now.place.t_b = f.b.u, now.gap = f.gap;
  now.normal = s.at.turn_b(f.normal);
  now.arm_b = s.at.origin_b + s.at.turn_b(f.on_b);
  now.arm_a =
      s.at.origin_b + s.at.turn_b(f.on_a) - flat(s.m.position[s.curve.a] - s.m.position[s.curve.b]);
  return now;
}

Real size_of(const FlatCurve& c) {
  return std::min(c.sides[0].wire->size(), c.sides[1].wire->size());
}

}  // namespace

namespace {

/// Whether the curve is straight on at least one side of t, as at the end of a box's side.
bool is_straight(const nurbs::CurvePieces& curve, Real t) {
  const nurbs::Range domain = curve.knots().domain();
  for (const Real beside : kBeside) {
    const auto d = curve.at(domain.clamped(t + beside * domain.width()));
    const Real speed = glm::length(d[1]);
    if (std::abs(cross(d[1], d[2])) * curve.size() < kStraight * speed * speed * speed) return true;
  }
  return false;
}

/// Straight lines in contact, as a box on a table: the point of a is fixed, and projected onto b.
nurbs::CurveContact lying(const nurbs::CurvePieces& a, const nurbs::CurvePieces& b,
                          const Pose& a_in_b, const CurvePlace& from) {
  nurbs::CurveContact out;
  out.t = from.t_a, out.on_a = to_world(a_in_b, a.at(from.t_a)[0]);
  const auto q = b.at(from.t_b);
  const Real length = glm::length(q[1]);
  const Real to = from.t_b + glm::dot(out.on_a - q[0], q[1]) / (length * length);
  out.b.u = b.knots().inside(to);
  if (!(std::abs(out.b.u - to) < 1e-9) && !b.knots().is_periodic)
    out.status = nurbs::ContactStatus::left_patch;
  else
    out.status = nurbs::ContactStatus::found;
  const auto foot = b.at(out.b.u);
  out.on_b = foot[0];
  out.normal = Vec3(foot[1].y, -foot[1].x, 0) / glm::length(foot[1]);
  out.gap = glm::dot(out.normal, out.on_a - out.on_b);
  return out;
}

/// Whether the control polygon turns to the left only, at most once around: its right is outside.
bool is_convex(const nurbs::Curve& curve) {
  const std::size_t count = curve.points.size();
  const auto at = [&](std::size_t i) { return curve.points[i % count].point(); };
  std::vector<Vec3> edges;
  for (std::size_t i = 0; i + (curve.knots.is_periodic ? 0 : 1) < count; ++i)
    if (const Vec3 edge = at(i + 1) - at(i); glm::length(edge) > 0)
      edges.push_back(glm::normalize(edge));
  const bool closed = curve.knots.is_periodic || glm::length(at(count - 1) - at(0)) < 1e-12;
  Real turned = 0;
  for (std::size_t i = 0; i < edges.size() && (closed || i + 1 < edges.size()); ++i) {
    const Vec3 p = edges[i], q = edges[(i + 1) % edges.size()];
    const Real turn = std::atan2(cross(p, q), glm::dot(p, q));
    if (turn < -1e-9) return false;
    turned += turn;
  }
  return turned < 2 * kPi + 1e-6;
}

/// Whether no piece of it is straight.
bool bends(const nurbs::CurvePieces& curve) {
  constexpr int kSamples = 256;
  const nurbs::Range domain = curve.knots().domain();
  for (int i = 0; i < kSamples; ++i) {
    const auto d = curve.at(domain.low + (i + 0.5) / kSamples * domain.width());
    const Real speed = glm::length(d[1]);
    if (!(cross(d[1], d[2]) * curve.size() > kBends * speed * speed * speed)) return false;
  }
  return true;
}

}  // namespace

Pose pose_between(const FlatCurve& curve, const Motions& m) { return standing(curve, m).a_in_b; }

PlaceNow follow(const FlatCurve& c, const CurvePlace& from, const Motions& m) {
  const Standing at = standing(c, m);
  const nurbs::CurvePieces &a = *c.sides[0].pieces, &b = *c.sides[1].pieces;
  const nurbs::CurveContact f = nurbs::track_planar(a, b, at.a_in_b, {from.t_a, from.t_b});
  PlaceNow now{.status = f.status, .place = from};
  now.place.lies = c.lifts && f.status == nurbs::ContactStatus::degenerate &&
                   (is_straight(a, from.t_a) || is_straight(b, from.t_b));
  if (now.place.lies) {
    const nurbs::CurveContact lain = lying(a, b, at.a_in_b, from);
    now.status = lain.status;
    return placed({c, at, m}, lain, now);
  }
  if (f.status != nurbs::ContactStatus::found) return now;
  if (c.rolls) now.place.slip += a.way(from.t_a, f.t) + b.way(from.t_b, f.b.u);
  return placed({c, at, m}, f, now);
}

void append_place_rows(const FlatCurve& c, const PlaceNow* at, std::vector<Row>& rows) {
  const auto add = [&](Vec3 way, Real residual) {
    Row row;
    row.add(c.a, at ? Vec3(way.x, way.y, cross(at->arm_a, way)) : Vec3(0));
    row.add(c.b, at ? Vec3(-way.x, -way.y, -cross(at->arm_b, way)) : Vec3(0));
    row.c = residual;
    rows.push_back(row);
  };
  const Vec3 n = at ? at->normal : Vec3(0);
  add(n, at ? at->gap : 0);
  if (c.rolls) add({-n.y, n.x, 0}, at ? at->place.slip : 0);
}

bool meets_once(const FlatCurve& c) {
  const auto &a = *c.sides[0].wire, &b = *c.sides[1].wire;
  return is_convex(a.curve()) && is_convex(b.curve()) &&
         (bends(*c.sides[0].pieces) || bends(*c.sides[1].pieces));
}

bool is_search_due(const FlatCurve& c, const Pose& searched, const Motions& m) {
  if (c.meets_once && c.places[0].used) return false;
  if (std::any_of(c.places.begin(), c.places.end(), [](const auto& p) { return p.lies; }))
    return true;
  const Pose now = pose_between(c, m);
  const Quat turn = glm::conjugate(searched.rotation) * now.rotation;
  return 2 * std::atan2(std::abs(turn.z), std::abs(turn.w)) > kSearchTurn ||
         glm::distance(now.position, searched.position) > kSearchWay * size_of(c);
}

void search_places(FlatCurve& c, const Motions& m) {
  if (c.known && (!c.lifts || !is_search_due(c, c.searched, m))) return;
  const Pose now = pose_between(c, m);
  nurbs::CurveContact found[kMostPairs];
  const Real reach = c.lifts && c.known ? kKept * size_of(c) : size_of(c);
  const std::size_t count =
      nurbs::find_planar(*c.sides[0].wire, *c.sides[1].wire, now, {reach, found});
  std::array<CurvePlace, kMostPlaces> kept{};
  std::size_t places = 0;
  for (std::size_t i = 0; i < count && places < c.most_places(); ++i) {
    CurvePlace& place = kept[places++];
    place = {.used = true, .t_a = found[i].t, .t_b = found[i].b.u};
    for (const CurvePlace& old : c.places) {
      if (!old.used) continue;
      const auto apart = glm::distance(c.sides[1].pieces->at(old.t_b)[0], found[i].on_b);
      const auto apart_a =
          glm::distance(to_world(now, c.sides[0].pieces->at(old.t_a)[0]), found[i].on_a);
      if (std::max(apart, apart_a) > kSame * size_of(c) + 2 * std::abs(found[i].gap)) continue;
      place = old;
    }
  }
  // Active contact points are kept, even if the search missed them.
  for (const CurvePlace& old : c.places) {
    if (!old.used || !old.presses) continue;
    const bool is_there = std::any_of(kept.begin(), kept.begin() + places, [&](const auto& k) {
      return k.t_a == old.t_a && k.t_b == old.t_b;
    });
    if (!is_there && places < c.most_places()) kept[places++] = old;
  }
  c.places = kept, c.searched = now, c.known = true;
}

}  // namespace pantin::detail::planar

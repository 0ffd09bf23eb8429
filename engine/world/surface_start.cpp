#include "engine/world/surface_start.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/nurbs/curve_pair.hpp"
#include "engine/nurbs/plane_curves.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostPairs = 16;
constexpr Real kFlat = 1e-9;       // relative to its size: tolerance of a planar curve
constexpr Real kSamePlane = 1e-6;  // rad, and relative to the smaller size
/// rad: between the normals of joined faces.
constexpr Real kSmoothEnough = 1e-3;

std::string shown(Real x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

nurbs::Place place_on_edge(const nurbs::Skin& skin, int face, nurbs::Edge edge, Real share) {
  const nurbs::Range u = skin.face(face).u().domain(), v = skin.face(face).v().domain();
  switch (edge) {
    case nurbs::Edge::u_low:
      return {face, u.low, v.low + share * v.width()};
    case nurbs::Edge::u_high:
      return {face, u.high, v.low + share * v.width()};
    case nurbs::Edge::v_low:
      return {face, u.low + share * u.width(), v.low};
    case nurbs::Edge::v_high:
      break;
  }
  return {face, u.low + share * u.width(), v.high};
}

std::string crease_in(const ContactSurface& surface, const char* side) {
  if (!surface.skin || surface.skin->half_axes()) return {};
  int number = 0;
  for (const nurbs::Face& face : surface.skin->faces()) {
    const std::string name = std::string(side) + ", face " + std::to_string(number++);
    for (const nurbs::Flaw& flaw : nurbs::flaws_of(face.surface(), name))
      if (flaw.kind == nurbs::FlawKind::crease)
        return "found " + flaw.text + " rad, expected a smooth surface";
  }
  return {};
}

Real size_of(const ContactSurface& s) { return s.curve ? s.curve->size() : s.skin->size(); }

/// The largest distance of a curve from the plane z = 0, m.
Real height_of(const nurbs::Wire& curve) {
  Real most = 0;
  for (const nurbs::Weighted& w : curve.curve().points)
    most = std::max(most, std::abs(w.point().z));
  return most;
}
bool is_flat(const nurbs::Wire& curve) { return height_of(curve) <= kFlat * curve.size(); }

/// Why two curves are not in one plane with the same orientation.
std::string plane_fault(const SurfaceContact& c, const Pose& a_in_b) {
  for (const auto& [side, name] : {std::pair{&c.on_a, "a"}, {&c.on_b, "b"}})
    if (!is_flat(*side->curve))
      return "found a curve of \"" + std::string(name) + "\" that leaves its plane z = 0 by " +
             shown(height_of(*side->curve)) + " m, expected a planar curve to touch a curve";
  const Vec3 up = a_in_b.rotation * Vec3(0, 0, 1);
  const Real tilt = std::atan2(glm::length(glm::cross(up, Vec3(0, 0, 1))), up.z);
  if (tilt > kSamePlane)
    return "found curves whose planes are tilted by " + shown(tilt * (180 / kPi)) +
           " degrees, expected them in one plane" + (tilt > 3 ? ", seen from the same side" : "");
  const Real apart = std::abs(a_in_b.position.z);
  if (apart > kSamePlane * std::min(size_of(c.on_a), size_of(c.on_b)))
    return "found curves in planes " + shown(apart) + " m apart, expected them in one plane";
  return {};
}

/// The alternative for faces that touch all over, or along a line.
constexpr const char* kInstead =
    "shapes with these surfaces collide instead, by faces, edges and corners";

/// Whether every face of a surface is flat.
bool is_flat(const nurbs::Skin& skin) {
  for (const nurbs::Face& face : skin.faces()) {
    const nurbs::Jet middle = face.at(face.u().domain().middle(), face.v().domain().middle());
    const Vec3 across = glm::cross(middle.u, middle.v);
    for (const nurbs::Weighted& w : face.surface().points)
      if (!(std::abs(glm::dot(across, w.point() - middle.s)) <=
            kFlat * face.size() * glm::length(across)))
        return false;
  }
  return true;
}

/// The least distance of two curves, or of a curve and a surface, m; sampled along a.
Real apart(const SurfaceContact& c, const Pose& a_in_b) {
  Real least = 1e300;
  for (const Vec3 p :
       nurbs::points_along(c.on_a.curve->curve(), 1e-3 * c.on_a.curve->size()).points) {
    const Vec3 at = to_world(a_in_b, p);
    if (c.on_b.curve) {
      least = std::min(least, nurbs::closest_point(*c.on_b.curve, at).distance);
      continue;
    }
    for (const nurbs::Face& face : c.on_b.skin->faces())
      least = std::min(least, nurbs::closest_point(face, at).distance);
  }
  return least;
}

/// The outward unit normal; zero at a singular point.
Vec3 normal_at(const nurbs::Skin& skin, const nurbs::Place& at) {
  const nurbs::Jet jet = skin.face(at.face).at(at.u, at.v);
  const Vec3 across = glm::cross(jet.u, jet.v);
  const Real length = glm::length(across);
  return length > 0 ? across / length : Vec3(0);
}

/// Which of two surfaces face the other with their inner side at the nearest points: "both", "that
/// of a", "that of b", or an empty string.
std::string turned_away(const nurbs::Meeting& meeting, const nurbs::ClosestPair& closest) {
  const Vec3 way = closest.on_a - closest.on_b;
  const bool a = glm::dot(meeting.a_in_b.rotation * normal_at(meeting.a, closest.at.a), way) > 0;
  const bool b = glm::dot(normal_at(meeting.b, closest.at.b), way) < 0;
  return a && b ? "both" : a ? "that of a" : b ? "that of b" : "";
}

/// Why two surfaces that face one another cannot touch from outside: with the gap of `pair` closed
/// they would cross, as a ball and a socket narrower than it. Empty: they can.
std::string would_cross(const SurfaceContact& c, const Pose& a_in_b,
                        const nurbs::CommonNormal& pair) {
  if (c.on_a.curve) return {};
  const Pose closed{a_in_b.position - pair.gap * pair.normal, a_in_b.rotation};
  const nurbs::CommonNormal touching = nurbs::track({*c.on_a.skin, *c.on_b.skin, closed}, pair.at);
  if (touching.status != nurbs::ContactStatus::found || touching.least_curvature > 0) return {};
  return "found surfaces that cross where their gap of " + shown(pair.gap) +
         " m is closed, expected a hollow wider than what lies in it";
}

/// Relative curvature, times the size, below which a place of contact is uncertain.
constexpr Real kNearlyConforming = 1e-3;
/// Of the size: pairs of points this far apart are different, and gaps that differ by less equal.
constexpr Real kOtherPlace = 1e-2, kSameGap = 1e-6;

std::string far_apart(const SurfaceContact& c, const Pose& a_in_b, Real reach) {
  if (c.on_a.curve)
    return "found a curve " + shown(apart(c, a_in_b)) + " m from " +
           (c.on_b.curve ? "a curve" : "a surface") +
           ", not facing it or conforming with it, expected one outside the other, within " +
           shown(reach) + " m";
  const nurbs::Meeting meeting{*c.on_a.skin, *c.on_b.skin, a_in_b};
  const nurbs::ClosestPair closest = nurbs::closest_pair(meeting);
  if (!closest.is_on_edge &&
      nurbs::track(meeting, closest.at).status == nurbs::ContactStatus::degenerate)
    return std::string(
               "found surfaces that conform where they are nearest (ContactDegenerate), expected "
               "them to touch in a point; ") +
           kInstead;
  const std::string inner = turned_away(meeting, closest);
  if (!closest.is_on_edge && closest.distance <= reach && !inner.empty())
    return "found surfaces " + shown(closest.distance) +
           " m apart that face each other with an inner side, " + inner +
           ", expected outer sides to face each other: \"inside_out\" flips a surface";
  return "found surfaces " + shown(closest.distance) + " m apart" +
         (closest.is_on_edge ? ", nearest at an edge" : "") +
         ", expected them to face each other within " + shown(reach) + " m";
}

}  // namespace

std::shared_ptr<const nurbs::Wire> contact_curve(const nurbs::Curve& curve, OuterSide side) {
  nurbs::Curve made = nurbs::closed_up(curve);
  const bool is_round = made.knots.is_periodic && is_flat(nurbs::Wire(made));
  const bool is_clockwise = is_round && nurbs::area_around(made) < 0;
  if (is_clockwise != (side == OuterSide::left)) made = nurbs::reversed(made);
  return std::make_shared<const nurbs::Wire>(std::move(made));
}

std::string curve_fault(const nurbs::Wire& wire) {
  for (const nurbs::Flaw& flaw : nurbs::flaws_of(wire.curve(), "the curve")) {
    if (flaw.kind == nurbs::FlawKind::crease)
      return "found a corner of " + shown(flaw.size * (180 / kPi)) +
             " degrees at t = " + shown(flaw.knot) +
             ", expected a smooth curve: round it, as \"rounding\" does";
    if (flaw.kind == nurbs::FlawKind::singular_point)
      return "found " + flaw.text + ", expected a smooth curve";
  }
  if (!is_flat(wire)) return {};
  if (const auto at = nurbs::crossing_of(wire.curve()))
    return "found a curve that crosses itself at t = " + shown((*at)[0]) + " and " +
           shown((*at)[1]) + ", expected one that does not";
  return {};
}

std::size_t find_pairs(const SurfaceContact& c, const Pose& a_in_b, const PairReach& to) {
  const auto& [reach, out] = to;
  if (!c.on_a.curve) return nurbs::find_contacts({*c.on_a.skin, *c.on_b.skin, a_in_b}, reach, out);
  nurbs::CurveContact found[kMostPairs];
  const nurbs::CurveReach wanted{reach, std::span(found).first(std::min(out.size(), kMostPairs))};
  const std::size_t count = c.on_b.curve
                                ? nurbs::find_planar(*c.on_a.curve, *c.on_b.curve, a_in_b, wanted)
                                : nurbs::find_on_face(*c.on_a.curve, *c.on_b.skin, a_in_b, wanted);
  for (std::size_t i = 0; i < count; ++i) {
    const nurbs::CurveContact& f = found[i];
    out[i] = {f.status, {{0, f.t, 0}, f.b}, f.on_a, f.on_b, f.normal, f.gap, f.least_curvature};
  }
  return count;
}

std::string crease_between(const ContactSurface& surface, const char* side) {
  if (!surface.skin || surface.skin->half_axes()) return {};
  const nurbs::Skin& skin = *surface.skin;
  Real sharpest = kSmoothEnough;
  std::string text;
  for (int face = 0; face < static_cast<int>(skin.faces().size()); ++face)
    for (int e = 0; e < nurbs::kEdges; ++e) {
      const auto edge = static_cast<nurbs::Edge>(e);
      const auto other = skin.neighbour(face, edge);
      if (!other || *other < face) continue;
      for (const Real share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        const nurbs::Place at = place_on_edge(skin, face, edge, share);
        const auto there = skin.across(at, edge);
        if (!there) continue;
        const Vec3 n = normal_at(skin, at), m = normal_at(skin, *there);
        const Real angle = std::atan2(glm::length(glm::cross(n, m)), glm::dot(n, m));
        if (n == Vec3(0) || m == Vec3(0) || !(angle > sharpest)) continue;
        sharpest = angle;
        text = std::string(side) + ": faces " + std::to_string(face) + " and " +
               std::to_string(*other) + " meet at an angle of " + shown(angle * 180 / kPi) +
               " degrees, at u " + shown(at.u) + ", v " + shown(at.v) + " of the first";
      }
    }
  return text;
}

std::string fit_between(const SurfaceContact& c, const PairPoses& bodies) {
  if (c.on_a.curve || c.on_b.curve) return {};
  if (is_flat(*c.on_a.skin) && is_flat(*c.on_b.skin))
    return std::string(
               "both surfaces are flat and cannot touch in a point (ContactDegenerate), so the "
               "joint has no effect; ") +
           kInstead;
  const Pose a_in_b =
      compose(inverse(compose(bodies.b, c.on_b.pose)), compose(bodies.a, c.on_a.pose));
  nurbs::CommonNormal found[kMostPairs];
  const Real reach = std::min(size_of(c.on_a), size_of(c.on_b));
  if (find_pairs(c, a_in_b, {reach, found}) > 0) return {};
  const nurbs::Meeting meeting{*c.on_a.skin, *c.on_b.skin, a_in_b};
  const nurbs::ClosestPair closest = nurbs::closest_pair(meeting);
  if (closest.is_on_edge ||
      nurbs::track(meeting, closest.at).status != nurbs::ContactStatus::degenerate)
    return {};
  return std::string(
             "the surfaces conform where they are nearest, along a line or an area "
             "(ContactDegenerate), where the joint has no effect; ") +
         kInstead;
}

std::string doubt_of_place(const SurfaceContact& c, const PairPoses& bodies) {
  if (!c.known) return {};
  const Pose a_in_b =
      compose(inverse(compose(bodies.b, c.on_b.pose)), compose(bodies.a, c.on_a.pose));
  const Real size = std::min(size_of(c.on_a), size_of(c.on_b));
  nurbs::CommonNormal found[kMostPairs];
  const std::size_t count = find_pairs(c, a_in_b, {size, found});
  if (count == 0) return {};
  const auto nearest = std::min_element(found, found + count, [](const auto& x, const auto& y) {
    return std::abs(x.gap) < std::abs(y.gap);
  });
  if (is_place_uncertain(c, nearest->least_curvature))
    return "the surfaces nearly conform where they touch (relative curvature " +
           shown(nearest->least_curvature) + " 1/m), so that the place of contact is uncertain";
  if (c.lifts && c.spots > 1) return {};  // several places are tracked
  for (std::size_t i = 0; i < count; ++i)
    if (glm::distance(found[i].on_b, nearest->on_b) > kOtherPlace * size &&
        std::abs(std::abs(found[i].gap) - std::abs(nearest->gap)) < kSameGap * size)
      return "two pairs of points " + shown(glm::distance(found[i].on_b, nearest->on_b)) +
             " m apart have the same gap, so that which of them touches is uncertain: place the "
             "bodies nearer to one";
  return {};
}

bool is_place_uncertain(const SurfaceContact& c, Real least_curvature) {
  return std::abs(least_curvature) * std::min(size_of(c.on_a), size_of(c.on_b)) < kNearlyConforming;
}

std::uint8_t usual_spots(const SurfaceContact& c) {
  const bool is_single =
      c.on_a.skin && c.on_b.skin && c.on_a.skin->is_convex() && c.on_b.skin->is_convex();
  return c.lifts && !is_single ? 4 : 1;
}

std::string place_surfaces(SurfaceContact& c, const PairPoses& bodies) {
  if (const char* why = c.restored()) return std::string("found a joint that ") + why;
  for (const auto& [surface, side] : {std::pair{&c.on_a, "surface a"}, {&c.on_b, "surface b"}})
    if (std::string crease = crease_in(*surface, side); !crease.empty()) return crease;
  const Pose a_in_b =
      compose(inverse(compose(bodies.b, c.on_b.pose)), compose(bodies.a, c.on_a.pose));
  if (c.on_b.curve)
    if (std::string why = plane_fault(c, a_in_b); !why.empty()) return why;
  if (c.known) return {};
  const Real reach = std::min(size_of(c.on_a), size_of(c.on_b));
  nurbs::CommonNormal found[kMostPairs];
  if (const std::size_t count = find_pairs(c, a_in_b, {reach, found}); count > 0) {
    const auto nearest = std::min_element(found, found + count, [](const auto& x, const auto& y) {
      return std::abs(x.gap) < std::abs(y.gap);
    });
    if (std::string why = would_cross(c, a_in_b, *nearest); !why.empty()) return why;
    c.at = nearest->at, c.known = true;
    return {};
  }
  return c.lifts ? std::string() : far_apart(c, a_in_b, reach);
}

}  // namespace pantin::detail

#include "engine/modes/lamina_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "engine/modes/outline.hpp"

namespace pantin::detail {

using modes::Vec2;

namespace {

using enum LaminaFault::Place;

constexpr Real kTouch = 1e-6;        // of the outline's extent: a point this near is on it
constexpr Real kLeastArea = 1e-12;   // of the extent's square
constexpr Real kLeastExtent = 1e-9;  // m
constexpr Real kForEver = 1e6;       // s
constexpr Real kSameNormal = 1e-6;

std::string text(Real number) {
  std::array<char, 32> digits{};
  std::snprintf(digits.data(), digits.size(), "%.6g", static_cast<double>(number));
  return digits.data();
}
std::string text(Vec2 p) { return "[" + text(p.x + 0.0) + ", " + text(p.y + 0.0) + "]"; }  // no -0

/// Moves the start of a finger's path, and the end of a steady one.
void shift(FingerPlan& finger, Vec2 by) {
  finger.point = finger.point + by;
  finger.path[0].at = finger.point;
  if (finger.path.size() == 2) finger.path[1].at = finger.path[1].at + by;
}

/// Places a point finger on the edge of an outline that it touches, or in front of it.
LaminaFinding place_on_edge(const LaminaPlan& lamina, FingerPlan& finger) {
  const Real tolerance = kTouch * modes::extent(lamina.outline);
  const modes::Nearest at = modes::nearest_edge(lamina.outline, finger.point, tolerance);
  const modes::Edge edge = modes::edge_of(lamina.outline, at.edge);
  const Vec2 across = edge.normal;
  const bool told = length(finger.normal) > 0;
  finger.touches = at.distance <= tolerance;
  if (!finger.touches) {
    if (!told) finger.normal = across;
    if (!modes::is_inside(lamina.outline, finger.point)) return std::nullopt;
    return LaminaFault{point, 0, "a point " + text(at.distance) + " m inside the outline",
                       "one on it or outside"};
  }
  shift(finger, -dot(across, finger.point - edge.from) * across);
  if (at.is_corner && !told)
    return LaminaFault{point, 0, "a corner of the outline", "a \"normal\" too"};
  if (!at.is_corner && told && length(finger.normal - across) > kSameNormal)
    return LaminaFault{normal, 0, text(finger.normal), "the edge's own, " + text(across)};
  if (!told) finger.normal = across;
  return std::nullopt;
}

/// Places a flat finger: a corner of the lamina touches it, or is in front of it.
LaminaFinding place_on_corner(const LaminaPlan& lamina, FingerPlan& finger) {
  const Real size = modes::extent(lamina.outline);
  Real least = 1e300;
  for (const Vec2 c : lamina.outline) least = std::min(least, dot(finger.normal, c - finger.point));
  finger.touches = least <= kTouch * size;
  if (finger.touches && least > -kTouch * size) shift(finger, least * finger.normal);
  if (!(least < -kTouch * size)) return std::nullopt;
  return LaminaFault{point, 0, "a flat finger " + text(-least) + " m inside the outline",
                     "it outside"};
}

}  // namespace

Vec2 first_velocity(const FingerPlan& finger) {
  const Waypoint &a = finger.path[0], &b = finger.path[1];
  return 1 / (b.time - a.time) * (b.at - a.at);
}

LaminaFinding check_outline(std::vector<Vec2>& corners) {
  const std::size_t count = corners.size();
  if (count < 3)
    return LaminaFault{outline, 0, std::to_string(count) + " corners", "three corners or more"};
  const Real size = modes::extent(corners);
  if (!(size >= kLeastExtent))
    return LaminaFault{outline, 0, "an outline " + text(size) + " m large", "1e-9 m or more"};
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = (i + 1) % count;
    if (!(length(corners[next] - corners[i]) > kTouch * size))
      return LaminaFault{corner, next, "the previous corner again", "another"};
  }
  if (const auto pair = modes::crossing(corners))
    return LaminaFault{outline, 0,
                       "edges from corners " + std::to_string(pair->first) + " and " +
                           std::to_string(pair->second) + " that intersect",
                       "none that do"};
  const Real area = modes::area(corners);
  if (std::abs(area) <= kLeastArea * size * size)
    return LaminaFault{outline, 0, "corners on one line", "an outline that encloses an area"};
  if (area < 0) std::reverse(corners.begin(), corners.end());
  return std::nullopt;
}

void start_path(FingerPlan& finger) { finger.path = {{0, finger.point}}; }

LaminaFinding add_waypoint(FingerPlan& finger, const Waypoint& next) {
  const Real before = finger.path.back().time;
  finger.path.push_back(next);
  if (next.time > before) return std::nullopt;
  return LaminaFault{LaminaFault::Place::finger, 0,
                     "time " + text(next.time) + " after " + text(before), "a later one"};
}

void move_steadily(FingerPlan& finger, Vec2 velocity) {
  if (finger.path.size() > 1) return;
  finger.path.push_back({kForEver, finger.point + kForEver * velocity});
}

LaminaFinding place_finger(const LaminaPlan& lamina, FingerPlan& finger) {
  const bool is_bare = lamina.outline.empty();
  if (const Real size = length(finger.normal); size > 0)
    finger.normal = 1 / size * finger.normal;
  else if (is_bare || finger.flat)
    return LaminaFault{LaminaFault::Place::finger, 0, "no \"normal\"",
                       "one: two numbers, into the lamina"};
  if (is_bare) return std::nullopt;
  return finger.flat ? place_on_corner(lamina, finger) : place_on_edge(lamina, finger);
}

std::vector<LaminaFault> repeated(const LaminaPlan& lamina, const FingerPlan& finger) {
  std::vector<LaminaFault> faults;
  for (const FingerPlan& other : lamina.fingers) {
    if (other.name == finger.name)
      faults.push_back(
          {LaminaFault::Place::finger, 0, "the name \"" + finger.name + "\" again", "another"});
    else if (length(other.point - finger.point) == 0 && length(other.normal - finger.normal) == 0)
      faults.push_back({LaminaFault::Place::finger, 0,
                        "the point and the normal of \"" + other.name + "\" again",
                        "another contact"});
  }
  return faults;
}

LaminaFinding check_load(const LaminaPlan& lamina) {
  if (lamina.load() != Vec3(0)) return std::nullopt;
  return LaminaFault{load, 0, "no load",
                     "a \"force\", a \"torque\" or weight: without a load every admissible mode "
                     "holds with zero force"};
}

}  // namespace pantin::detail

#include "engine/world/surface_start.hpp"

#include <algorithm>
#include <cstdio>

namespace pantin::detail {
namespace {

constexpr std::size_t kMostPairs = 16;

std::string shown(Real x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
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

}  // namespace

std::string place_surfaces(SurfaceContact& c, const StartPoses& bodies) {
  if (const char* why = c.restored()) return std::string("found a joint that ") + why;
  for (const auto& [surface, side] : {std::pair{&c.on_a, "surface a"}, {&c.on_b, "surface b"}})
    if (std::string crease = crease_in(*surface, side); !crease.empty()) return crease;
  if (c.known || c.on_a.curve) return {};
  const Pose a_in_b =
      compose(inverse(compose(bodies.b, c.on_b.pose)), compose(bodies.a, c.on_a.pose));
  const nurbs::Meeting meeting{*c.on_a.skin, *c.on_b.skin, a_in_b};
  nurbs::CommonNormal found[kMostPairs];
  const Real reach = std::min(c.on_a.skin->size(), c.on_b.skin->size());
  if (const std::size_t count = nurbs::find_contacts(meeting, reach, found); count > 0) {
    const auto nearest = std::min_element(found, found + count, [](const auto& x, const auto& y) {
      return std::abs(x.gap) < std::abs(y.gap);
    });
    c.at = nearest->at, c.known = true;
    return {};
  }
  if (c.lifts) return {};
  const nurbs::ClosestPair closest = nurbs::closest_pair(meeting);
  if (!closest.is_on_edge &&
      nurbs::track(meeting, closest.at).status == nurbs::ContactStatus::degenerate)
    return "found surfaces that fit one another where they are nearest (ContactDegenerate), "
           "expected them to touch in a point";
  return "found surfaces " + shown(closest.distance) + " m apart" +
         (closest.is_on_edge ? ", nearest at an edge" : "") +
         ", expected them to face one another within " + shown(reach) + " m";
}

}  // namespace pantin::detail

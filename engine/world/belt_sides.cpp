#include "engine/world/belt_sides.hpp"

#include <cstdio>

namespace pantin::detail {
namespace {

constexpr Real kLevel = 1e-6;  // tolerance for points at one height, m, and relative to the height

/// 1 if the pulleys follow one another anticlockwise; else -1.
Real sense_of(const Belt& belt, PulleyPoses bodies) {
  Real twice = 0;
  const std::size_t count = belt.pulleys.size();
  const auto centre = [&](std::size_t k) {
    return to_world(bodies[k % count], belt.pulleys[k % count].anchor);
  };
  for (std::size_t i = 0; i < count; ++i)
    twice += centre(i).x * centre(i + 1).y - centre(i).y * centre(i + 1).x;
  return twice >= 0 ? 1 : -1;
}

std::string levels_fault(const Belt& belt, PulleyPoses bodies) {
  const Real first = to_world(bodies[0], belt.pulleys[0].anchor).z;
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const Real z = to_world(bodies[i], belt.pulleys[i].anchor).z;
    if (std::abs(z - first) <= kLevel * (1 + std::abs(first))) continue;
    char text[160];
    std::snprintf(
        text, sizeof text,
        "pulleys 0 and %zu at z = %.4g and %.4g m, expected them in one plane parallel to xy", i,
        first, z);
    return text;
  }
  return {};
}

}  // namespace

std::string lay_round(Belt& belt, PulleyPoses bodies, const BeltSides& sides) {
  const Real sense = sense_of(belt, bodies);
  const std::size_t count = belt.pulleys.size();
  for (std::size_t i = 0; i < count; ++i) {
    const bool turned_over = sides.crossed && count == 2 && i == 1;
    belt.pulleys[i].sense = sides.is_outside[i] != turned_over ? -sense : sense;
  }
  if (std::string why = levels_fault(belt, bodies); !why.empty()) return why;
  if (!lay_belt(belt, bodies)) return "consecutive pulleys that overlap, expected them apart";
  return fault_of(belt, bodies, sides.crossed ? Crossing::allowed : Crossing::refused);
}

}  // namespace pantin::detail

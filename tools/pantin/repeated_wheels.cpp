#include "tools/pantin/repeated_wheels.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/joints/primitives.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"

namespace pantin::program {

using namespace detail;

namespace {

/// Sine of an angle, and part of a distance: less is rounding.
constexpr Real kAligned = 1e-6;

/// A wheel in the world as it stands.
struct WheelPlace {
  Entity joint, ground, body;
  Vec3 hub{0}, axle{0};
};

WheelPlace place_of(const World& world, std::uint32_t link) {
  const Link& l = world.links.values()[link];
  const Pose& at = world.bodies[l.b].pose;
  return {world.links.owners()[link], l.a, l.b, to_world(at, l.joint.anchor_b),
          at.rotation * axis_of(l.joint.frames.b(), 0)};
}

bool is_across(Vec3 v, Vec3 axle) {
  return glm::length(glm::cross(v, axle)) > kAligned * glm::length(v);
}

/// The bodies that do not move along a wheel's axle relative to it: itself, and those that hinges
/// about the axle and fixed joints tie to it.
std::vector<Entity> carriers_of(const World& world, const WheelPlace& wheel) {
  std::vector<Entity> all{wheel.body};
  for (const Link& l : world.links.values()) {
    if (l.a != wheel.body && l.b != wheel.body) continue;
    const bool is_hinge =
        l.joint.kind == JointKind::hinge &&
        !is_across(world.bodies[l.b].pose.rotation * axis_of(l.joint.frames.b(), 0), wheel.axle);
    if (is_hinge || l.joint.kind == JointKind::fixed) all.push_back(l.a == wheel.body ? l.b : l.a);
  }
  return all;
}

bool share_an_axle(const World& world, const WheelPlace& one, const WheelPlace& two) {
  if (one.ground != two.ground || is_across(one.axle, two.axle) ||
      is_across(two.hub - one.hub, one.axle))
    return false;
  const std::vector<Entity> of_one = carriers_of(world, one), of_two = carriers_of(world, two);
  return std::any_of(of_one.begin(), of_one.end(), [&](Entity e) {
    return std::find(of_two.begin(), of_two.end(), e) != of_two.end();
  });
}

}  // namespace

std::vector<std::string> words_of_repeated_wheels(const World& world) {
  std::vector<std::string> words;
  for (const lagrangian::Island& m : lagrangian::islands_of(world)) {
    const Integrator by = m.settings.integrator;
    if (by != Integrator::rk4 && by != Integrator::rattle) continue;
    std::vector<WheelPlace> wheels;
    for (const lagrangian::Block& b : m.blocks)
      if (b.kind == lagrangian::BlockKind::joint &&
          world.links.values()[b.source].joint.kind == JointKind::wheel)
        wheels.push_back(place_of(world, b.source));
    for (std::size_t i = 0; i < wheels.size(); ++i)
      for (std::size_t k = i + 1; k < wheels.size(); ++k)
        if (share_an_axle(world, wheels[i], wheels[k]))
          words.push_back(fmt::format(
              "wheels {} and {} are on one axle, so both forbid the same motion along it, which "
              "shortens the steps of {}; tie one by a cylindrical joint, which lets it slide along "
              "the axle, or choose \"integrator\": \"radau\" or \"implicit\"",
              world.name_of(wheels[i].joint), world.name_of(wheels[k].joint), name_of(by)));
  }
  return words;
}

}  // namespace pantin::program

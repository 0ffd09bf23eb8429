#pragma once
/// Joints of any kind and laminas, with members that bytes make: see random_program.hpp.
#include <pantin/joints.hpp>
#include <pantin/laminas.hpp>
#include <string>
#include <vector>

namespace pantin::test::random_program {

template <class Bytes>
AnyJoint random_joint(Bytes& bytes, Entity a, Entity b) {
  static const std::vector<std::string> kinds = joint_kinds();
  const auto interval = [&] { return Interval{bytes.number(), bytes.number()}; };
  AnyJoint joint{.kind = kinds[bytes.pick(kinds.size())], .a = a, .b = b};
  joint.anchor = bytes.place();
  if (bytes.chance(2)) joint.axis = bytes.chance(8) ? bytes.numbers() : bytes.place();
  if (bytes.chance(4)) joint.anchor_b = bytes.place();
  if (bytes.chance(4)) joint.across = bytes.place();
  for (const std::string& key : parameters_of_kind(joint.kind))
    if (!bytes.chance(8))
      joint.parameters.push_back({key, bytes.chance(4) ? bytes.number() : bytes.positive()});
  if (bytes.chance(4)) joint.limits = interval();
  if (bytes.chance(8)) joint.second_limits = interval();
  if (bytes.chance(8)) joint.travel_limits = interval();
  if (bytes.chance(8)) joint.cone = ConeLimit{bytes.positive(), bytes.number()};
  if (bytes.chance(8)) joint.angle.spring = {bytes.number(), bytes.number()};
  if (bytes.chance(8)) joint.travel.motor = {MotorKind::velocity, bytes.number(), bytes.number()};
  if (bytes.chance(8)) joint.frames = LocalFrames{{bytes.place(), bytes.turn()}, {}};
  return joint;
}

template <class Bytes>
LaminaBody random_lamina(Bytes& bytes) {
  const auto place = [&]() -> Vec3 {
    const Vec3 at = bytes.chance(12) ? bytes.numbers() : bytes.place();
    return {at.x, at.y, 0};
  };
  LaminaBody lamina;
  if (bytes.chance(2)) {  // one that a finger finds
    lamina.outline = {{0, 0, 0}, {1, 0, 0}, {1, 0.5, 0}, {0, 0.5, 0}};
    lamina.fingers.push_back({.point = {bytes.positive() / 2, 0, 0}, .velocity = place()});
    lamina.fingers.push_back({.point = {bytes.positive() / 2, 0, 0}, .velocity = place()});
  } else {
    for (unsigned i = 2 + bytes.pick(4); i-- > 0;) lamina.outline.push_back(place());
  }
  for (unsigned i = bytes.pick(3); i-- > 0;) {
    LaminaBody::Finger& finger = lamina.fingers.emplace_back();
    finger.point = place(), finger.flat = bytes.chance(4);
    if (bytes.chance(2)) finger.normal = place();
    if (bytes.chance(3)) finger.waypoints = {{bytes.number(), place()}, {bytes.number(), place()}};
    if (bytes.chance(4)) finger.roll = bytes.number(), finger.slide = bytes.number();
  }
  if (bytes.chance(4)) lamina.mass = bytes.number();
  if (bytes.chance(4)) lamina.force = place(), lamina.torque = bytes.number();
  return lamina;
}

}  // namespace pantin::test::random_program

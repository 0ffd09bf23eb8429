#pragma once
/// A posed marionette that the tests of pictures look at.
#include <string>

#include "engine/base/rotation.hpp"
#include "engine/world/world.hpp"

namespace pantin::picture {

using namespace detail;

enum : std::uint32_t { kPlain, kShirt, kTrousers, kSkin, kHair, kShoe, kWood, kBrass };

inline std::vector<Material> puppet_materials() {
  return {{"plain", {0.7, 0.7, 0.7}, 0.5, 0},       {"shirt", {0.62, 0.05, 0.04}, 0.55, 0},
          {"trousers", {0.05, 0.14, 0.42}, 0.6, 0}, {"skin", {0.78, 0.50, 0.34}, 0.5, 0},
          {"hair", {0.16, 0.07, 0.03}, 0.7, 0},     {"shoe", {0.04, 0.03, 0.03}, 0.3, 0},
          {"wood", {0.50, 0.27, 0.10}, 0.45, 0},    {"brass", {0.85, 0.60, 0.22}, 0.3, 1}};
}

/// Adds bodies one by one, without the solvers' ideas of mass.
class PuppetMaker {
 public:
  explicit PuppetMaker(World& world) : world_(world) {}

  Entity body(const Pose& pose, std::vector<Shape> parts, Motion motion = Motion::dynamic) {
    const Entity e = world_.create();
    Body b;
    b.pose = pose;
    b.motion = motion;
    world_.bodies.add(e, b);
    world_.shapes.add(e, Shapes{std::move(parts)});
    return e;
  }

  /// A capsule between two points.
  Entity limb(Vec3 from, Vec3 to, Real radius, std::uint32_t material) {
    const Vec3 way = to - from;
    const Real length = glm::length(way);
    const Vec3 axis = glm::cross(Vec3{0, 1, 0}, way / length);
    const Real cosine = way.y / length;
    const Quat rotation =
        cosine < -0.9999 ? Quat{0, 1, 0, 0} : glm::normalize(Quat(1 + cosine, axis));
    return body({(from + to) / 2.0, rotation},
                {{ShapeKind::capsule, {radius, length / 2, 0}, {}, material}});
  }

  void joint(Entity a, Entity b, Vec3 at) {
    Joint joint;
    joint.anchor_a = to_local(world_.bodies[a].pose, at);
    joint.anchor_b = to_local(world_.bodies[b].pose, at);
    world_.links.add(world_.create(), {a, b, joint});
  }

  void string(Entity a, Vec3 from, Entity b, Vec3 to, Real length_factor = 1) {
    Cable s{a, b, {}};
    s.joint.anchor_a = to_local(world_.bodies[a].pose, from);
    s.joint.anchor_b = to_local(world_.bodies[b].pose, to);
    s.joint.length = length_factor * glm::length(to - from);
    world_.cables.add(world_.create(), s);
  }

 private:
  World& world_;
};

/// One marionette with its feet near `at`: 16 bodies, 9 cables, one of them slack.
inline void add_puppet(World& world, Vec3 at) {
  PuppetMaker make(world);
  const auto p = [&](Real x, Real y, Real z) { return at + Vec3{x, y, z}; };
  const Vec3 hip_l = p(0.075, 0.80, 0), hip_r = p(-0.075, 0.80, 0);
  const Vec3 knee_l = p(0.10, 0.47, 0.13), knee_r = p(-0.085, 0.45, -0.03);
  const Vec3 ankle_l = p(0.10, 0.13, 0.02), ankle_r = p(-0.09, 0.10, -0.16);
  const Vec3 shoulder_l = p(0.17, 1.22, 0), shoulder_r = p(-0.17, 1.22, 0);
  const Vec3 elbow_l = p(0.33, 1.06, 0.05), elbow_r = p(-0.27, 1.00, 0.02);
  const Vec3 wrist_l = p(0.53, 1.12, 0.17), wrist_r = p(-0.36, 1.14, 0.24);

  const Entity chest =
      make.body({p(0, 1.10, 0), kIdentity}, {{ShapeKind::capsule, {0.115, 0.10, 0}, {}, kShirt},
                                             {ShapeKind::capsule,
                                              {0.07, 0.12, 0},
                                              {{0, 0.11, 0}, from_rotation_vector({0, 0, kPi / 2})},
                                              kShirt}});
  const Entity pelvis =
      make.body({p(0, 0.85, 0), kIdentity}, {{ShapeKind::capsule,
                                              {0.09, 0.06, 0},
                                              {{0, 0, 0}, from_rotation_vector({0, 0, kPi / 2})},
                                              kTrousers}});
  const Entity head =
      make.body({p(0, 1.47, 0.01), from_rotation_vector({0.08, 0.3, 0.05})},
                {{ShapeKind::capsule, {0.088, 0.025, 0}, {}, kSkin},
                 {ShapeKind::sphere, {0.093, 0, 0}, {{0, 0.045, -0.018}, kIdentity}, kHair},
                 {ShapeKind::sphere, {0.013, 0, 0}, {{0.034, 0.005, 0.083}, kIdentity}, kShoe},
                 {ShapeKind::sphere, {0.013, 0, 0}, {{-0.034, 0.005, 0.083}, kIdentity}, kShoe},
                 {ShapeKind::sphere, {0.017, 0, 0}, {{0, -0.03, 0.092}, kIdentity}, kShirt}});
  const Entity neck = make.limb(p(0, 1.30, 0), p(0, 1.37, 0), 0.04, kSkin);
  const Entity thigh_l = make.limb(hip_l, knee_l, 0.066, kTrousers);
  const Entity thigh_r = make.limb(hip_r, knee_r, 0.066, kTrousers);
  const Entity shin_l = make.limb(knee_l, ankle_l, 0.05, kTrousers);
  const Entity shin_r = make.limb(knee_r, ankle_r, 0.05, kTrousers);
  const Entity foot_l =
      make.limb(ankle_l + Vec3{0, -0.05, -0.02}, ankle_l + Vec3{0, -0.06, 0.12}, 0.045, kShoe);
  const Entity foot_r =
      make.limb(ankle_r + Vec3{0, -0.04, -0.02}, ankle_r + Vec3{0, -0.05, 0.12}, 0.045, kShoe);
  const Entity upper_l = make.limb(shoulder_l, elbow_l, 0.048, kShirt);
  const Entity upper_r = make.limb(shoulder_r, elbow_r, 0.048, kShirt);
  const Entity fore_l = make.limb(elbow_l, wrist_l, 0.037, kSkin);
  const Entity fore_r = make.limb(elbow_r, wrist_r, 0.037, kSkin);
  const Pose bar_at{p(0, 2.25, 0.05), from_rotation_vector({0.1, 0.25, 0.06})};
  const Entity bar =
      make.body(bar_at,
                {{ShapeKind::box, {0.42, 0.018, 0.028}, {}, kWood},
                 {ShapeKind::box, {0.028, 0.018, 0.25}, {{0, 0.036, 0.05}, kIdentity}, kWood},
                 {ShapeKind::sphere, {0.024, 0, 0}, {{0, 0.06, 0}, kIdentity}, kBrass}},
                Motion::kinematic);
  world.paths.add(
      bar, KinematicPath{Lissajous{bar_at, {0.15, 0.02, 0.1}, {0.4, 0.8, 0.3}, {}, {}, {}, {}}});

  make.joint(chest, pelvis, p(0, 0.95, 0)), make.joint(chest, neck, p(0, 1.29, 0));
  make.joint(neck, head, p(0, 1.38, 0));
  make.joint(pelvis, thigh_l, hip_l), make.joint(pelvis, thigh_r, hip_r);
  make.joint(thigh_l, shin_l, knee_l), make.joint(thigh_r, shin_r, knee_r);
  make.joint(shin_l, foot_l, ankle_l), make.joint(shin_r, foot_r, ankle_r);
  make.joint(chest, upper_l, shoulder_l), make.joint(chest, upper_r, shoulder_r);
  make.joint(upper_l, fore_l, elbow_l), make.joint(upper_r, fore_r, elbow_r);

  const auto on_bar = [&](Real x, Real y, Real z) { return to_world(bar_at, {x, y, z}); };
  make.string(bar, on_bar(0.09, -0.018, 0), head, p(0.085, 1.50, 0.01));
  make.string(bar, on_bar(-0.09, -0.018, 0), head, p(-0.085, 1.50, 0.01));
  make.string(bar, on_bar(0.22, -0.018, 0), chest, shoulder_l + Vec3{0, 0.06, 0});
  make.string(bar, on_bar(-0.22, -0.018, 0), chest, shoulder_r + Vec3{0, 0.06, 0});
  make.string(bar, on_bar(0.41, -0.018, 0), fore_l, wrist_l + Vec3{0, 0.035, 0});
  make.string(bar, on_bar(-0.41, -0.018, 0), fore_r, wrist_r + Vec3{0, 0.035, 0});
  make.string(bar, on_bar(0.02, 0.018, 0.29), thigh_l, knee_l + Vec3{0, 0.06, 0.04});
  make.string(bar, on_bar(-0.02, 0.018, 0.29), thigh_r, knee_r + Vec3{0, 0.06, 0.04});
  make.string(bar, on_bar(0, 0.018, -0.20), pelvis, p(0, 0.90, -0.09), 1.1);
}

inline World puppet_world() {
  World world;
  world.materials = puppet_materials();
  add_puppet(world, {0, 0, 0});
  return world;
}

}  // namespace pantin::picture

#include "engine/scene/build/place.hpp"

#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail {
namespace {

/// The rotation from joint axes to the frame in which the recipe gives them.
Quat axes_of(const AxesRecipe& recipe) {
  const Vec3 x = recipe.axis;
  if (recipe.across) {
    const Vec3 y = glm::normalize(*recipe.across - glm::dot(*recipe.across, x) * x);
    return glm::normalize(glm::quat_cast(Mat3(x, y, glm::cross(x, y))));
  }
  if (x.x > 1 - 1e-15) return kIdentity;
  if (x.x < -1 + 1e-12) return Quat(0, 0, 0, 1);
  return glm::normalize(Quat(1 + x.x, glm::cross(Vec3(1, 0, 0), x)));
}

Quat turn_of_body(const BuiltScene& built, std::uint32_t body) {
  return built.pose_of(body).rotation;
}

/// A rotation given in a body's own frame, in its mass-centre frame.
Quat axes_from_own_frame(const BuiltScene& built, std::uint32_t body, Quat axes) {
  if (body == kWorldBody || !built.bodies[body].mass_properties->is_moved) return axes;
  return glm::normalize(glm::conjugate(built.bodies[body].mass_properties->centre.rotation) * axes);
}

/// The same for a rotation given in the scene at the start.
Quat axes_from_scene(const BuiltScene& built, std::uint32_t body, Quat axes) {
  return glm::normalize(glm::conjugate(turn_of_body(built, body)) * axes);
}

/// Places the joint of two bodies.
struct JointPlacement {
  const BuiltScene& built;
  const JointRecipe& recipe;
  std::uint32_t a, b;  // its bodies

  void place_anchors(Joint& joint) const;
  void place_line(Joint& joint) const;
  void measure_parameter(Joint& joint) const;
  void place_axes(Joint& joint) const;
};

void JointPlacement::place_anchors(Joint& joint) const {
  if (recipe.anchor_a) joint.anchor_a = from_own_frame(built, a, *recipe.anchor_a);
  if (recipe.anchor_b) joint.anchor_b = from_own_frame(built, b, *recipe.anchor_b);
  Vec3 point = recipe.anchor.value_or(Vec3(0));
  if (recipe.anchor_a)
    point = to_scene(built, a, joint.anchor_a);
  else if (recipe.anchor_b)
    point = to_scene(built, b, joint.anchor_b);
  if (!recipe.anchor_a) joint.anchor_a = from_scene(built, a, point);
  if (!recipe.anchor_b) joint.anchor_b = from_scene(built, b, point);
}

/// The anchors of a kind that acts along a line.
void JointPlacement::place_line(Joint& joint) const {
  joint.anchor_a = anchor_of(built, a, {recipe.point_a, recipe.anchor_a});
  joint.anchor_b = anchor_of(built, b, {recipe.point_b, recipe.anchor_b});
}

/// A parameter that defaults to the distance of the anchors, and what follows from it.
void JointPlacement::measure_parameter(Joint& joint) const {
  const JointKindInfo& kind = info_of(joint.kind);
  const Parameter* parameter = kind.measured();
  if (!parameter) return;
  const Vec3 line = to_scene(built, b, joint.anchor_b) - to_scene(built, a, joint.anchor_a);
  JointParameters& parameters = joint.parameters.edit();
  parameter->value(parameters) = recipe.turn.length.value_or(glm::length(line));
  kind.complete(parameters);
}

/// Sets both frames so that the initial rotation of b's axes in a's is that of the recipe.
void JointPlacement::place_axes(Joint& joint) const {
  if (recipe.axes_a) joint.frames.set_a(axes_from_own_frame(built, a, axes_of(*recipe.axes_a)));
  if (recipe.axes_b) joint.frames.set_b(axes_from_own_frame(built, b, axes_of(*recipe.axes_b)));
  if (recipe.axes_a && recipe.axes_b) return;
  Quat axes = axes_of(recipe.axes);  // a's, in the scene
  if (recipe.axes_a) axes = turn_of_body(built, a) * joint.frames.a();
  if (recipe.axes_b) axes = turn_of_body(built, b) * joint.frames.b() * glm::conjugate(recipe.rest);
  if (!recipe.axes_a) joint.frames.set_a(axes_from_scene(built, a, axes));
  if (!recipe.axes_b) joint.frames.set_b(axes_from_scene(built, b, axes * recipe.rest));
}

}  // namespace

Vec3 from_own_frame(const BuiltScene& built, std::uint32_t body, Vec3 point) {
  if (body == kWorldBody || !built.bodies[body].mass_properties->is_moved) return point;
  return to_local(built.bodies[body].mass_properties->centre, point);
}

Vec3 from_scene(const BuiltScene& built, std::uint32_t body, Vec3 point) {
  return body == kWorldBody ? point : to_local(built.bodies[body].body.pose, point);
}

Vec3 to_scene(const BuiltScene& built, std::uint32_t body, Vec3 anchor) {
  return to_world(built.pose_of(body), anchor);
}

Vec3 anchor_of(const BuiltScene& built, std::uint32_t body, const PointRecipe& point) {
  if (point.in_scene) return from_scene(built, body, *point.in_scene);
  return from_own_frame(built, body, point.in_body.value_or(Vec3(0)));
}

Joint joint_of(const BuiltScene& built, const JointRecipe& recipe, std::uint32_t a,
               std::uint32_t b) {
  const JointPlacement placement{built, recipe, a, b};
  Joint joint;
  joint.kind = recipe.turn.kind, joint.limits = recipe.turn.limits;
  joint.parameters = recipe.turn.parameters;
  if (recipe.turn.is_line())
    placement.place_line(joint);
  else
    placement.place_anchors(joint);
  // For a plain ball joint the orientation of the axes is irrelevant.
  if (!recipe.turn.is_line() && recipe.turn.needs_axes()) placement.place_axes(joint);
  placement.measure_parameter(joint);
  return joint;
}

Joint chain_end_joint(const BuiltScene& built, const RotationRecipe& turn, const ChainEnd& end) {
  Joint joint = chain_joint(built, turn, end.link);
  joint.anchor_a = from_scene(built, end.body, end.point), joint.anchor_b = end.anchor;
  if (turn.needs_axes())
    joint.frames.set_a(
        axes_from_scene(built, end.body, turn_of_body(built, end.link) * joint.frames.b()));
  return joint;
}

Joint chain_joint(const BuiltScene& built, const RotationRecipe& turn, std::uint32_t link) {
  Joint joint;
  joint.kind = turn.kind, joint.limits = turn.limits, joint.parameters = turn.parameters;
  if (turn.needs_axes()) {
    const Quat axes = axes_from_own_frame(built, link, chain_axes(turn.kind));
    joint.frames.set(axes, axes);
  }
  return joint;
}

JointDrive shifted(const JointDrive& drive, Real ahead) {
  JointDrive result = drive;
  for (PoseKey& key : result.keys) key.time -= ahead;
  DriveMotion& motion = result.motion;
  for (MotionKnot& knot : motion.knots) knot.time -= ahead;
  motion.phase += 2 * kPi * motion.frequency * ahead, motion.offset += motion.speed * ahead;
  return result;
}

}  // namespace pantin::detail

#include "engine/scene/place.hpp"

#include <cmath>

#include "engine/base/rotation.hpp"

namespace pantin {
namespace {

/// The turn from joint axes to the frame that the recipe gives them in.
Quat axes_of(const AxesRecipe& recipe) {
  const Vec3 x = recipe.axis;
  if (recipe.across) {
    const Vec3 y = glm::normalize(*recipe.across - glm::dot(*recipe.across, x) * x);
    return glm::normalize(glm::quat_cast(Mat3(x, y, glm::cross(x, y))));
  }
  if (x.x > 1 - 1e-15) return kNoTurn;
  if (x.x < -1 + 1e-12) return Quat(0, 0, 0, 1);
  return glm::normalize(Quat(1 + x.x, glm::cross(Vec3(1, 0, 0), x)));
}

Quat turn_of_body(const Assembly& assembly, std::uint32_t body) {
  return assembly.pose_of(body).rotation;
}

/// A turn of axes given in a body's own frame, in its mass-centre frame.
Quat axes_from_own_frame(const Assembly& assembly, std::uint32_t body, Quat axes) {
  if (body == kWorldBody || !assembly.bodies[body].matter->is_moved) return axes;
  return glm::normalize(glm::conjugate(assembly.bodies[body].matter->centre.rotation) * axes);
}

/// ... given in the scene at the start.
Quat axes_from_scene(const Assembly& assembly, std::uint32_t body, Quat axes) {
  return glm::normalize(glm::conjugate(turn_of_body(assembly, body)) * axes);
}

void place_anchors(const Assembly& assembly, const JointRecipe& recipe, std::uint32_t a,
                   std::uint32_t b, Joint& joint) {
  if (recipe.anchor_a) joint.anchor_a = from_own_frame(assembly, a, *recipe.anchor_a);
  if (recipe.anchor_b) joint.anchor_b = from_own_frame(assembly, b, *recipe.anchor_b);
  Vec3 point = recipe.anchor.value_or(Vec3(0));
  if (recipe.anchor_a)
    point = to_scene(assembly, a, joint.anchor_a);
  else if (recipe.anchor_b)
    point = to_scene(assembly, b, joint.anchor_b);
  if (!recipe.anchor_a) joint.anchor_a = from_scene(assembly, a, point);
  if (!recipe.anchor_b) joint.anchor_b = from_scene(assembly, b, point);
}

/// The ends of a kind that is a line.
void place_line(const Assembly& assembly, const JointRecipe& recipe, std::uint32_t a,
                std::uint32_t b, Joint& joint) {
  joint.anchor_a = anchor_of(assembly, a, {recipe.point_a, recipe.anchor_a});
  joint.anchor_b = anchor_of(assembly, b, {recipe.point_b, recipe.anchor_b});
}

/// The parameter that the file may leave to how the anchors lie, and what follows from it.
void measure_parameter(const Assembly& assembly, const JointRecipe& recipe, std::uint32_t a,
                       std::uint32_t b, Joint& joint) {
  const JointKindInfo& kind = info_of(joint.kind);
  const Parameter* parameter = kind.measured();
  if (!parameter) return;
  const Vec3 line = to_scene(assembly, b, joint.anchor_b) - to_scene(assembly, a, joint.anchor_a);
  JointExtras& extras = joint.extras.edit();
  parameter->value(extras) = recipe.turn.length.value_or(glm::length(line));
  kind.complete(extras);
}

/// Both frames, such that b's axes stand in a's at the start as the recipe says.
void place_axes(const Assembly& assembly, const JointRecipe& recipe, std::uint32_t a,
                std::uint32_t b, Joint& joint) {
  if (recipe.axes_a) joint.frames.set_a(axes_from_own_frame(assembly, a, axes_of(*recipe.axes_a)));
  if (recipe.axes_b) joint.frames.set_b(axes_from_own_frame(assembly, b, axes_of(*recipe.axes_b)));
  if (recipe.axes_a && recipe.axes_b) return;
  Quat axes = axes_of(recipe.axes);  // a's, in the scene
  if (recipe.axes_a) axes = turn_of_body(assembly, a) * joint.frames.a();
  if (recipe.axes_b)
    axes = turn_of_body(assembly, b) * joint.frames.b() * glm::conjugate(recipe.rest);
  if (!recipe.axes_a) joint.frames.set_a(axes_from_scene(assembly, a, axes));
  if (!recipe.axes_b) joint.frames.set_b(axes_from_scene(assembly, b, axes * recipe.rest));
}

}  // namespace

Vec3 from_own_frame(const Assembly& assembly, std::uint32_t body, Vec3 point) {
  if (body == kWorldBody || !assembly.bodies[body].matter->is_moved) return point;
  return to_local(assembly.bodies[body].matter->centre, point);
}

Vec3 from_scene(const Assembly& assembly, std::uint32_t body, Vec3 point) {
  return body == kWorldBody ? point : to_local(assembly.bodies[body].body.pose, point);
}

Vec3 to_scene(const Assembly& assembly, std::uint32_t body, Vec3 anchor) {
  return to_world(assembly.pose_of(body), anchor);
}

Vec3 anchor_of(const Assembly& assembly, std::uint32_t body, const PointRecipe& point) {
  if (point.in_scene) return from_scene(assembly, body, *point.in_scene);
  return from_own_frame(assembly, body, point.in_body.value_or(Vec3(0)));
}

Joint joint_of(const Assembly& assembly, const JointRecipe& recipe, std::uint32_t a,
               std::uint32_t b) {
  Joint joint;
  joint.kind = recipe.turn.kind, joint.limits = recipe.turn.limits;
  joint.extras = recipe.turn.extras;
  if (recipe.turn.is_line())
    place_line(assembly, recipe, a, b, joint);
  else
    place_anchors(assembly, recipe, a, b, joint);
  // A plain ball joint may turn all ways, however its axes lie.
  if (!recipe.turn.is_line() && recipe.turn.needs_axes())
    place_axes(assembly, recipe, a, b, joint);
  measure_parameter(assembly, recipe, a, b, joint);
  return joint;
}

Joint chain_end_joint(const Assembly& assembly, const TurnRecipe& turn, const ChainEnd& end) {
  Joint joint = chain_joint(assembly, turn, end.link);
  joint.anchor_a = from_scene(assembly, end.body, end.point), joint.anchor_b = end.anchor;
  if (turn.needs_axes())
    joint.frames.set_a(axes_from_scene(assembly, end.body,
                                       turn_of_body(assembly, end.link) * joint.frames.b()));
  return joint;
}

Joint chain_joint(const Assembly& assembly, const TurnRecipe& turn, std::uint32_t link) {
  Joint joint;
  joint.kind = turn.kind, joint.limits = turn.limits, joint.extras = turn.extras;
  if (turn.needs_axes()) {
    const Quat axes = axes_from_own_frame(assembly, link, chain_axes(turn.kind));
    joint.frames.set(axes, axes);
  }
  return joint;
}

Lissajous sway_of(const DriveRecipe& recipe, const Pose& start) {
  Lissajous sway = recipe.sway;
  const Pose away = pose_at({sway}, 0);
  sway.centre.position = recipe.centre.value_or(start.position - away.position);
  sway.centre.rotation = glm::conjugate(away.rotation) * start.rotation;
  return sway;
}

Keyframes keyframes_of(const DriveRecipe& recipe, const Pose& start) {
  Keyframes path;
  path.loop = recipe.loop;
  for (const KeyRecipe& key : recipe.keys)
    path.keys.push_back(
        {key.time, {key.position.value_or(start.position), key.rotation.value_or(start.rotation)}});
  return path;
}

PoseDrive hastened(const PoseDrive& drive, Real ahead) {
  PoseDrive result = drive;
  for (PoseKey& key : result.keys) key.time -= ahead;
  return result;
}

}  // namespace pantin

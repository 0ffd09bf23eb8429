#include <string>

#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

/// "axis" and "across", or the same with `suffix` in a body's own frame; nothing without both.
std::optional<AxesRecipe> read_axes(const Reader& from, const std::string& suffix) {
  const std::string axis = "axis" + suffix, across = "across" + suffix;
  if (!from.has(axis) && !from.has(across)) return std::nullopt;
  AxesRecipe axes;
  if (from.has(axis)) axes.axis = from.direction(axis, axes.axis);
  if (!from.has(across)) return axes;
  axes.across = from.direction(across, Vec3(0, 1, 0));
  if (glm::length(glm::cross(axes.axis, *axes.across)) > 1e-6) return axes;
  from.diagnostics.error_value(from.find(across),
                               "a direction that is not that of \"" + axis + "\"");
  axes.across.reset();
  return axes;
}

void read_frames(const Reader& from, JointRecipe& joint) {
  if (const auto axes = read_axes(from, "")) joint.axes = *axes;
  joint.axes_a = read_axes(from, "_a"), joint.axes_b = read_axes(from, "_b");
  if (joint.axes_a && joint.axes_b) {
    if (!joint.axes_a->across || !joint.axes_b->across)
      from.diagnostics.error(from.node,
                             "found \"axis_a\" and \"axis_b\", expected \"across_a\" and "
                             "\"across_b\" beside them: the joint's zero is where the two agree");
    for (std::string_view key : {"rest", "rest_deg"})
      if (from.has(key))
        from.diagnostics.error_at_key(from.find(key),
                                      "found \"" + std::string(key) +
                                          "\" beside the axes in both bodies, expected only one of "
                                          "them: those tell it");
    return;
  }
  joint.rest = read_joint_turn(from, "rest", joint.turn.kind).value_or(kIdentity);
}

}  // namespace

std::optional<JointRecipe> read_joint(const Reading& reading, NodeId node) {
  const Reader from = open_of_class(reading, node, "joint");
  JointRecipe joint;
  joint.name = optional_name(from);
  const auto a = from.reference("a");
  const auto b = from.reference("b");
  joint.anchor = from.vec_if("anchor");
  joint.anchor_a = from.vec_if("anchor_a");
  joint.anchor_b = from.vec_if("anchor_b");
  joint.turn = read_turn(reading, from);
  joint.point_a = from.vec_if("point_a"), joint.point_b = from.vec_if("point_b");
  if (from.is_object() && !joint.turn.is_line() && !joint.anchor && !joint.anchor_a &&
      !joint.anchor_b)
    reading.diagnostics.error(
        node,
        "found no \"anchor\", expected the point of the scene where the bodies "
        "meet, or \"anchor_a\" and \"anchor_b\" in their own frames");
  if (!joint.turn.is_line()) read_frames(from, joint);
  if (!a || !b) return std::nullopt;
  joint.a = *a, joint.b = *b;
  return joint;
}

}  // namespace pantin::detail

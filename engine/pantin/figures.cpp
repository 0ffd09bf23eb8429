#include <pantin/figures.hpp>

#include "engine/base/rotation.hpp"
#include "engine/pantin/detail/builder.hpp"
#include "engine/pantin/detail/findings.hpp"

namespace pantin {

using namespace detail;

namespace {

/// The shortest rotation from y to a unit direction.
Quat from_y(Vec3 to) {
  const Vec3 axis = glm::cross(Vec3(0, 1, 0), to);
  const Real sine = glm::length(axis);
  if (sine < 1e-12) return to.y > 0 ? kIdentity : Quat(0, 1, 0, 0);
  return from_rotation_vector(axis / sine * std::atan2(sine, to.y));
}

void check(const ChainOptions& options, Findings& findings) {
  findings.finite("from", options.from), findings.finite("to", options.to);
  findings.above_zero("radius", options.radius);
  if (options.links < 1 || options.links > 1'000'000)
    findings.add("links", std::to_string(options.links), "1 to 1000000");
  if (options.start) findings.body("start", options.start);
  if (options.end) findings.body("end", options.end);
  if (!findings.ok()) return;
  const Real half = glm::distance(options.from, options.to) / options.links / 2;
  if (!(half > options.radius))
    findings.add("radius", shown(options.radius), "less than half a link, " + shown(half));
}

/// The axes of a universal joint are the axis of `joint` and its `across`.
Entity join(Builder& builder, ChainJoint kind, const BallJoint& joint, const std::string& part) {
  if (kind == ChainJoint::ball) return builder.add(joint, part);
  return builder.add(UniversalJoint{.a = joint.a,
                                    .b = joint.b,
                                    .anchor = joint.anchor,
                                    .axis_a = joint.axis,
                                    .axis_b = joint.across},
                     part);
}

}  // namespace

Result<Chain> build_chain(World& world, const ChainOptions& options) {
  Findings findings(world, "Chain", options.name);
  check(options, findings);
  if (!findings.ok()) return findings.take();
  Builder builder(world, options.name);
  Chain chain;
  const Vec3 step = (options.to - options.from) / Real(options.links);
  const Real half = glm::length(step) / 2;
  const Quat along = from_y(step / (2 * half));
  const auto joint_at = [&](int stage) { return options.from + Real(stage) * step; };
  for (int i = 0; i < options.links && builder.ok(); ++i) {
    RigidBody link;
    link.shape = CapsuleShape{.radius = options.radius, .half_length = half - options.radius};
    link.density = options.density, link.drag = options.drag, link.collision = options.collision;
    link.position = joint_at(i) + step / 2.0, link.rotation = along;
    chain.links.push_back(builder.add(link, std::to_string(i)));
  }
  for (int i = 0; i <= options.links && builder.ok(); ++i) {
    const Entity a = i == 0 ? options.start : chain.links[static_cast<std::size_t>(i - 1)];
    const Entity b = i == options.links ? options.end : chain.links[static_cast<std::size_t>(i)];
    if (!a || !b) continue;
    const BallJoint joint{.a = a,
                          .b = b,
                          .anchor = joint_at(i),
                          .axis = along * Vec3(1, 0, 0),
                          .across = along * Vec3(0, 0, 1)};
    chain.joints.push_back(join(builder, options.joint, joint, "joint" + std::to_string(i)));
  }
  if (!builder.ok()) return builder.take();
  return chain;
}

}  // namespace pantin

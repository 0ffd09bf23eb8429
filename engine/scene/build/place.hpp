#pragma once
/// Geometry of joints, cables, pins and paths, once their bodies are known.
#include "engine/scene/build/build.hpp"

namespace pantin::detail {

/// A point of a body's own frame in its mass-centre frame.
Vec3 from_own_frame(const BuiltScene& built, std::uint32_t body, Vec3 point);
/// A point of the scene at the start, likewise.
Vec3 from_scene(const BuiltScene& built, std::uint32_t body, Vec3 point);
/// Where a point of a mass-centre frame is in the scene at the start.
Vec3 to_scene(const BuiltScene& built, std::uint32_t body, Vec3 anchor);
/// Where a point was given, in the mass-centre frame; otherwise the own frame's origin.
Vec3 anchor_of(const BuiltScene& built, std::uint32_t body, const PointRecipe& point);

/// The joint of two bodies; what is not given in a body's frame follows from the initial poses.
Joint joint_of(const BuiltScene& built, const JointRecipe& recipe, std::uint32_t a,
               std::uint32_t b);

/// The joint of a body and a chain's first or last link. Joint axes are those of the chain in the
/// link; in the body they agree with them at the start.
struct ChainEnd {
  std::uint32_t body, link;  // the link's side of the joint is b
  Vec3 point;                // in the scene
  Vec3 anchor;               // in the link's mass-centre frame
};
Joint chain_end_joint(const BuiltScene& built, const RotationRecipe& turn, const ChainEnd& end);

/// The joint between two links of a chain, the same all along it.
Joint chain_joint(const BuiltScene& built, const RotationRecipe& turn, std::uint32_t link);

/// A joint drive with its keys shifted by a time (s).
JointDrive shifted(const JointDrive& drive, Real ahead);

}  // namespace pantin::detail

#pragma once
/// Geometry of joints, cables, pins and paths, once their bodies are known.
#include "engine/scene/build/build.hpp"

namespace pantin::detail {

/// A point of a body's own frame in its mass-centre frame.
Vec3 from_own_frame(const BuiltScene& built, std::uint32_t body, Vec3 point);
/// A point of the scene at the start, in a body's mass-centre frame.
Vec3 from_scene(const BuiltScene& built, std::uint32_t body, Vec3 point);
/// A point of a mass-centre frame, in the scene at the start.
Vec3 to_scene(const BuiltScene& built, std::uint32_t body, Vec3 anchor);
/// The given point in the mass-centre frame; by default the origin of the body's own frame.
Vec3 anchor_of(const BuiltScene& built, std::uint32_t body, const PointRecipe& point);

/// The joint of two bodies; values not given in a body's frame follow from the initial poses.
Joint joint_of(const BuiltScene& built, const JointRecipe& recipe, std::uint32_t a,
               std::uint32_t b);

/// The joint of a body and a chain's first or last link. Joint axes are those of the chain in the
/// link; those in the body agree with them at the start.
struct ChainEnd {
  std::uint32_t body, link;  // the link's side of the joint is b
  Vec3 point;                // in the scene
  Vec3 anchor;               // in the link's mass-centre frame
};
Joint chain_end_joint(const BuiltScene& built, const RotationRecipe& turn, const ChainEnd& end);

/// The joint between two links of a chain, equal for all of them.
Joint chain_joint(const BuiltScene& built, const RotationRecipe& turn, std::uint32_t link);

/// A joint drive with its keys shifted by a time (s).
JointDrive shifted(const JointDrive& drive, Real ahead);

}  // namespace pantin::detail

#pragma once
/// Where joints, strings, pins and drives are, once it is known which bodies they speak of.
#include "engine/scene/assembly.hpp"

namespace pantin {

/// A point of a body's own frame in its mass-centre frame.
Vec3 from_own_frame(const Assembly& assembly, std::uint32_t body, Vec3 point);
/// A point of the scene at the start, likewise.
Vec3 from_scene(const Assembly& assembly, std::uint32_t body, Vec3 point);
/// Where a point of a mass-centre frame is in the scene at the start.
Vec3 to_scene(const Assembly& assembly, std::uint32_t body, Vec3 anchor);
/// Where a point was given, in the mass-centre frame; otherwise the own frame's origin.
Vec3 anchor_of(const Assembly& assembly, std::uint32_t body, const PointRecipe& point);

/// The joint of two bodies: whatever is not given in a body's frame follows from where they lie.
Joint joint_of(const Assembly& assembly, const JointRecipe& recipe, std::uint32_t a,
               std::uint32_t b);

/// The joint of a body and a chain's first or last link. Joint axes are those of the chain in the
/// link; in the body they agree with them at the start.
struct ChainEnd {
  std::uint32_t body, link;  // the link's side of the joint is b
  Vec3 point;                // in the scene
  Vec3 anchor;               // in the link's mass-centre frame
};
Joint chain_end_joint(const Assembly& assembly, const TurnRecipe& turn, const ChainEnd& end);

/// The joint between two links of a chain, the same all along it.
Joint chain_joint(const Assembly& assembly, const TurnRecipe& turn, std::uint32_t link);

/// Unless the file says where the sway's centre is, it passes through the body's place at time 0.
Lissajous sway_of(const DriveRecipe& recipe, const Pose& start);

/// Keys that leave out a place or a turn take that of the start.
Keyframes keyframes_of(const DriveRecipe& recipe, const Pose& start);

/// A muscle whose keys run ahead by a time (s).
PoseDrive hastened(const PoseDrive& drive, Real ahead);

}  // namespace pantin

#pragma once
/// Joints that constrain rotations or exert torques in a step by the energy-momentum method: see
/// conserving_joints.cpp, and conserving_torques.cpp for what they exert.
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

/// A part of a step of an island with such joints.
struct StiffStep {
  const World& world;
  Island& a;
  Real h;  // s, of the part
  StepPart part;
  bool knows_yields = true;  // of actuated joints: see ConservingNode::yield
};

/// The rotations of both bodies of a joint at the start of the part and at the iterate.
struct JointEnds {
  Quat own0, own1, parent0, parent1;
};
JointEnds ends_of(const StiffStep& s, std::size_t c);

/// The hooks of the kernels; `step` has to outlive them.
ConservingJoints stiff_joints(StiffStep& step);

/// Arms of impulses: at the means of the poses, or at the end.
enum class Arms : std::uint8_t { mean, end };
/// The response of the island to the impulses in scratch.tie_impulses and tie_torques, by the last
/// elimination: see respond in conserving_ties.cpp.
void respond_stiff(Island& a, Arms arms);

/// Whether a joint has a drive, soft zones, a spring, friction or a motor; what these exert on the
/// own body, and how that depends on its turn relative to its parent at the iterate, into its node.
bool exerts_torque(const PackedJoint& joint);
void find_torque(const StiffStep& s, std::size_t c, const JointEnds& ends);
/// Cayley's vector of the relative turn over the part: the work of a torque is its product with it.
Vec3 turned_by(const StiffStep& s, std::size_t c, const JointEnds& ends);

}  // namespace pantin::detail::articulated

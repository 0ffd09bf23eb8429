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

/// The torque on the own body of a joint, N m, and minus its derivative by the turn of the own body
/// relative to its parent at the iterate, N m/rad.
struct JointTorque {
  Vec3 torque{0};
  Mat3 stiffness{0};
};
/// Whether a joint has a drive, springs, friction or a motor.
bool exerts_torque(const PackedJoint& joint);
JointTorque torque_of(const StiffStep& s, std::size_t c);
/// Work of that torque over the part, J.
Real work_of(const StiffStep& s, std::size_t c);

}  // namespace pantin::detail::articulated

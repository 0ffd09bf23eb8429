// Torques of joints in the energy-momentum method: drives, springs, friction, motors.
#include "engine/solvers/articulated/conserving_joints.hpp"

namespace pantin::detail::articulated {

bool exerts_torque(const PackedJoint&) { return false; }
JointTorque torque_of(const StiffStep&, std::size_t) { return {}; }
Real work_of(const StiffStep&, std::size_t) { return 0; }

}  // namespace pantin::detail::articulated

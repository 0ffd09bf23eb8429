// Reaction forces and torques of joints, after a step.
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

Real force_per_lambda(const Island& a) {
  const Real h = a.last_step;
  const bool knows = a.settings.solver == Solver::articulated && !a.scratch.work.numbers().empty();
  return knows && h > 0 ? 1 / (h * h) : 0;
}

JointLoad joint_load(const Island& a, std::size_t column) {
  const Real to_force = force_per_lambda(a);
  JointLoad load{to_force * a.memory.vec(kLambda, column), Vec3(0)};
  const bool stiff = !a.joints.empty() && a.joints[column].stiff;
  if (to_force != 0 && stiff && a.knows_torques) load.torque = a.joint_memory[column].torque;
  return load;
}

}  // namespace pantin::detail::articulated

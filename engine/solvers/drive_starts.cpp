#include "engine/solvers/drive_starts.hpp"

#include <cmath>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail {
namespace {

BodyState state_of(const Body& b) {
  return {b.pose.position, b.pose.rotation, glm::mat3_cast(b.pose.rotation), {}, {}};
}

}  // namespace

void start_drives(World& world) {
  for (std::size_t i = 0; i < world.joint_drives.size(); ++i) {
    JointDrive& drive = world.joint_drives.values()[i];
    if (!drive.exact || !drive.motion.at_start) continue;
    Real before = 0;
    for (const SolverRow* solver : kSolvers)
      if (const Real angle = solver->drive_angle(world, world.joint_drives.owners()[i]);
          std::isfinite(angle))
        before = angle;
    const Link* link = world.links.find(world.joint_drives.owners()[i]);
    const Body *a = link ? world.bodies.find(link->a) : nullptr,
               *b = link ? world.bodies.find(link->b) : nullptr;
    if (!a || !b) continue;
    DriveMotion& motion = drive.motion;
    Real now = 0;
    write_coordinate({link->joint, state_of(*a), state_of(*b), before},
                     motion.travels ? Coordinate::travel : Coordinate::angle,
                     {&now, nullptr, nullptr});
    motion.offset += now - motion_at(motion, world.time).value;
    motion.at_start = false;
  }
}

}  // namespace pantin::detail

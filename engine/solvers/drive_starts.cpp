#include "engine/solvers/drive_starts.hpp"

#include <cmath>

#include "engine/solvers/solver.hpp"
#include "engine/world/joint_coordinate.hpp"

namespace pantin::detail {

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
    if (!link || !world.bodies.find(link->a) || !world.bodies.find(link->b)) continue;
    DriveMotion& motion = drive.motion;
    const Coordinate which = motion.travels ? Coordinate::travel : Coordinate::angle;
    const Real now = coordinate_at(world, *link, which, before).value;
    motion.offset += now - motion_at(motion, world.time).value;
    motion.at_start = false;
  }
}

}  // namespace pantin::detail

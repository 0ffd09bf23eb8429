#pragma once
/// What can be solved in the xy plane: bodies that keep their z and rotate about z alone.
#include <span>
#include <string>
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/joints/joint.hpp"
#include "engine/world/body.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/joint_drive.hpp"
#include "engine/world/kinematic_path.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

struct IslandPlan;

/// Whether this build has the solver "planar".
bool has_planar_solver();

/// The equivalent of a joint in the plane.
enum class FlatJoint : std::uint8_t {
  none,    // constrains no motion in the plane
  hinge,   // ball, hinge and cylindrical joint with its axis along z
  weld,    // fixed
  slider,  // prismatic or cylindrical joint with its axis in the plane
  rod,     // distance
  spring
};

/// Why a dynamic body cannot be moved in the plane, as a clause ("leaves the plane: ..."), or
/// empty.
std::string flat_fault(const Body& body);

/// Why a joint cannot be enforced in the plane at the present poses, or empty.
std::string flat_fault(const Joint& joint, const Pose& a, const Pose& b);

/// The same if one body follows a path, with the joint's anchor on it.
std::string flat_fault(const Joint& joint, const KinematicPath& path, Vec3 anchor);

/// Why an exact drive cannot move its coordinate in the plane, the travel or the angle of a joint
/// that has no fault itself, or empty.
std::string flat_drive_fault(const Joint& joint, const DriveMotion& motion, const Pose& a);

/// Why two curves in contact cannot be solved in the plane, or empty.
std::string flat_fault(const SurfaceContact& contact, const Pose& a, const Pose& b);

/// The equivalent of a joint that has no fault.
FlatJoint flat_kind(const Joint& joint, const Pose& a);

/// Why bodies leave the plane under this gravity, or empty.
std::string flat_fault(Vec3 gravity);

/// Whether a shape of a body at `rotation` has a section at constant z that consists of discs and
/// convex polygons.
bool has_section(const Shape& shape, Quat rotation);

/// Why the island of a dynamic body cannot be moved in the plane, as a clause, or empty. Considers
/// the present World: the bodies that joints connect and the fixed shapes that the island may
/// touch, but no later disturbance.
std::string plane_fault(const World& world, Entity body);
/// The same for several islands at once, in linear time.
std::vector<std::string> plane_faults(const World& world, std::span<const IslandPlan> islands);

}  // namespace pantin::detail

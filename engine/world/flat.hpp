#pragma once
/// What can be solved in the plane of x and y: bodies that keep their z and turn about z alone.
#include <string>

#include "engine/geometry/shape.hpp"
#include "engine/joints/joint.hpp"
#include "engine/world/body.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/kinematic_path.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

/// Whether this build has the solver "planar".
bool has_planar_solver();

/// How a joint acts in the plane.
enum class FlatJoint : std::uint8_t {
  none,    // it leaves all motions free that a plane has
  hinge,   // ball, hinge and cylindrical joint with its axis along z
  weld,    // fixed
  slider,  // prismatic or cylindrical joint with its axis in the plane
  rod,     // distance
  spring
};

/// Why a dynamic body cannot be moved in the plane, as a clause ("leaves the plane: ..."), or
/// empty.
std::string flat_fault(const Body& body);

/// Why a joint cannot be held in the plane, or empty; of bodies as they stand.
std::string flat_fault(const Joint& joint, const Pose& a, const Pose& b);

/// Why a joint cannot be held in the plane by a body on a path, where it has its anchor; or empty.
std::string flat_fault(const Joint& joint, const KinematicPath& path, Vec3 anchor);

/// Why curves that touch cannot do so in the plane, or empty.
std::string flat_fault(const SurfaceContact& contact, const Pose& a, const Pose& b);

/// Of a joint without a fault.
FlatJoint flat_kind(const Joint& joint, const Pose& a);

/// Why bodies under this gravity leave the plane, or empty.
std::string flat_fault(Vec3 gravity);

/// Whether a shape of a body that stands at `rotation` has a section at constant z that is made of
/// discs and convex polygons.
bool has_section(const Shape& shape, Quat rotation);

/// Why the island of a dynamic body cannot be moved in the plane, as a clause, or empty: of the
/// World as it stands. What its joints tie to it counts, and the fixed shapes it may touch; what
/// else may come to push it out of the plane does not.
std::string plane_fault(const World& world, Entity body);

}  // namespace pantin::detail

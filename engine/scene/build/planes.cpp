// Reports what cannot be solved in a plane.
#include <algorithm>
#include <string>

#include "engine/scene/build/build.hpp"
#include "engine/world/flat.hpp"

namespace pantin::detail {
namespace {

/// A fault of a body in the plane: the member of the file, and the reason.
struct Found {
  std::string_view member;
  std::string what;
};

Found fault_of(const BuiltBody& b) {
  if (std::string why = flat_fault(b.body); !why.empty()) return {"", std::move(why)};
  if (!b.collision || b.collision->sensor || !b.mass_properties) return {};
  const Pose& at = b.body.pose;
  for (const Shape& shape : b.mass_properties->shapes)
    if (!has_section(shape, at.rotation))
      return {"", "has a shape without a planar section of discs and polygons"};
  return {};
}

constexpr const char* kExpected = ", expected motion in the xy plane, as \"planar\" requires";

constexpr const char* kExpectedOfBelts =
    ", expected motion in the xy plane, as the belt on it requires";

}  // namespace

void check_planes(const BuiltScene& built, const std::vector<Solver>& solvers, Vec3 gravity,
                  BuildMessages& messages) {
  const auto is_flat = [&](std::uint32_t body) {
    return built.is_dynamic(body) && solvers[body] == Solver::planar;
  };
  bool any = false, falls = false;  // of these bodies; reported once
  for (std::uint32_t i = 0; i < built.bodies.size(); ++i) {
    if (!is_flat(i)) continue;
    const BuiltBody& b = built.bodies[i];
    if (!any && !has_planar_solver())
      return messages.error(b.at, "solver",
                            "found the solver \"planar\", expected another: this build of pantin "
                            "was made without Box2D");
    any = true;
    std::string why = b.body.gravity_scale != 0 ? flat_fault(gravity) : std::string();
    if (!falls && !why.empty())
      messages.error(b.at, "", "found body \"" + b.name + "\", which " + why + kExpected);
    falls = falls || !why.empty();
    if (const Found found = fault_of(b); !found.what.empty())
      messages.error(b.at, found.member,
                     "found body \"" + b.name + "\", which " + found.what + kExpected);
  }
  std::vector<bool> carries(built.bodies.size(), false);
  for (const BuiltBelt& belt : built.belts)
    for (const std::uint32_t body : belt.bodies) carries[body] = true;
  const auto is_belted = [&](std::uint32_t body) { return body != kWorldBody && carries[body]; };
  for (const BuiltJoint& j : built.joints) {
    if (!is_flat(j.a) && !is_flat(j.b) && !is_belted(j.a) && !is_belted(j.b)) continue;
    std::string why = flat_fault(j.joint, built.pose_of(j.a), built.pose_of(j.b));
    for (const BuiltPath& p : built.paths)
      if (why.empty() && (p.body == j.a || p.body == j.b))
        why = flat_fault(j.joint, p.path, p.body == j.a ? j.joint.anchor_a : j.joint.anchor_b);
    if (why.empty() && j.drive && j.drive->exact)
      why = flat_drive_fault(j.joint, j.drive->motion, built.pose_of(j.a));
    if (!why.empty())
      messages.error(j.at, "",
                     "found joint \"" + j.name + "\", which " + why +
                         (is_flat(j.a) || is_flat(j.b) ? kExpected : kExpectedOfBelts));
  }
  for (const BuiltSurfaceJoint& s : built.surface_joints) {
    if (!s.contact.on_b.curve || (!is_flat(s.a) && !is_flat(s.b))) continue;
    const std::string why = flat_fault(s.contact, built.pose_of(s.a), built.pose_of(s.b));
    if (!why.empty())
      messages.error(s.at, "", "found surface joint \"" + s.name + "\", which " + why + kExpected);
  }
}

}  // namespace pantin::detail

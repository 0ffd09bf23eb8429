#pragma once
/// Mirror images of bodies and of what ties them. With S the reflection, a body at position p,
/// rotation R stands at S p, S R S afterwards; what is fixed in it is reflected by S in its frame.
///
/// A joint's axes F become -S F, so that the rotation Q of b's axes in a's stays what it was:
/// limits, targets and angles keep their numbers. A translation along x changes its sign.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine/scene/build/build.hpp"

namespace pantin::detail {

/// Reflections by a plane.
struct Reflection {
  MirrorPlane plane;

  Vec3 direction(Vec3 v) const {
    v[plane.axis] = -v[plane.axis];
    return v;
  }
  Vec3 point(Vec3 p) const {
    p[plane.axis] = 2 * plane.offset - p[plane.axis];
    return p;
  }
  /// Of angular velocities, torques and axes of rotation.
  Vec3 axial(Vec3 v) const { return -direction(v); }
  /// S R S.
  Quat rotation(Quat q) const { return Quat(q.w, axial({q.x, q.y, q.z})); }
  Pose pose(const Pose& at) const { return {point(at.position), rotation(at.rotation)}; }
  /// -S: the axes of a joint.
  Quat axes(Quat q) const {
    Vec3 normal(0);
    normal[plane.axis] = 1;
    return Quat(0, normal) * q;
  }
};

/// Images that several bodies share, by the original and the axis.
struct MirrorImages {
  std::map<std::pair<const void*, int>, std::shared_ptr<const BodyMassProperties>> bodies;
  std::map<std::pair<const void*, int>, std::shared_ptr<const Surface>> surfaces;
  std::map<std::pair<const void*, int>, std::shared_ptr<const nurbs::Skin>> skins;
};

/// The name of an image: left and right change places, as do l and r where they stand alone. The
/// same name if it has no side.
std::string mirrored_name(const std::string& name);

/// The kind of a shape of an image that lacks its surface, since that cannot be mirrored.
std::optional<ShapeKind> unmirrored(const BodyMassProperties& image);

BuiltBody mirrored(const BuiltBody& body, const Reflection& by, MirrorImages& images);

/// What does not depend on where the ends are: the travel along x, and what follows from it.
void mirror_travel(Joint& joint);
Gear mirrored(const Gear& gear);
/// A surface fixed in an image of a body.
ContactSurface mirrored(const ContactSurface& surface, const Reflection& by, MirrorImages& images);
/// One that stays in the frame at `body`, which has no image: where the whole is reflected.
ContactSurface mirrored_in(const Pose& body, const ContactSurface& surface, const Reflection& by,
                           MirrorImages& images);

/// The whole, across a plane through the origin. Its paths are left out.
BuiltScene mirrored(const BuiltScene& whole, const Reflection& by, MirrorImages& images);

}  // namespace pantin::detail

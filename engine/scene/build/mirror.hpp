#pragma once
/// Mirror images of bodies and of what connects them. With S the reflection, a body at position p,
/// rotation R has its image at S p, S R S; its shapes and anchors are reflected by S in its frame.
///
/// The axes F of a joint become -S F, so that the rotation Q of b's axes in a's is unchanged:
/// limits, targets and angles keep their values. A translation along x changes its sign.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine/scene/build/build.hpp"

namespace pantin::detail {

/// Reflection by a plane.
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
  /// The image of an axial vector: angular velocity, torque, axis of rotation.
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

/// Images that several bodies share, by original and axis.
struct MirrorImages {
  std::map<std::pair<const void*, int>, std::shared_ptr<const BodyMassProperties>> bodies;
  std::map<std::pair<const void*, int>, std::shared_ptr<const Surface>> surfaces;
  std::map<std::pair<const void*, int>, std::shared_ptr<const nurbs::Skin>> skins;
};

/// The name of an image: exchanges left and right, and l and r as separate words. Returns the name
/// unchanged if it contains no side.
std::string mirrored_name(const std::string& name);

/// The kind of a shape whose surface could not be mirrored, if there is one.
std::optional<ShapeKind> unmirrored(const BodyMassProperties& image);

BuiltBody mirrored(const BuiltBody& body, const Reflection& by, MirrorImages& images);

/// Mirrors what does not depend on the ends of a joint: the travel along x, and its parameters.
void mirror_travel(Joint& joint);
Gear mirrored(const Gear& gear);
/// Mirrors a surface fixed in a mirrored body.
ContactSurface mirrored(const ContactSurface& surface, const Reflection& by, MirrorImages& images);
/// Mirrors a surface fixed in a body without an image, within its frame at `body`.
ContactSurface mirrored_in(const Pose& body, const ContactSurface& surface, const Reflection& by,
                           MirrorImages& images);

/// Mirrors a whole scene across a plane through the origin, without its paths.
BuiltScene mirrored(const BuiltScene& whole, const Reflection& by, MirrorImages& images);

}  // namespace pantin::detail

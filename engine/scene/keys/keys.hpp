#pragma once
/// The keys of a scene file by kind of object: THE tables by which the reader works and from which
/// the JSON Schema is generated. The reader rejects all other keys.
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/scene/keys/key.hpp"

namespace pantin::detail {

struct ShapeTraits;
struct SizeKey;

namespace keys {

#define PANTIN_OBJECTS                                                                            \
  scene, solver, material, material_pair, defaults, object_class, body_class, joint_class,        \
      cable_class, pin_class, body, collision, joint, limits, soft, spring, friction, motor, dof, \
      gear, belt, belt_pulley, surface_joint, surface_side, joint_drive, pose_key, drive_motion,  \
      sensor, cable_guide, cable, pin, keyframe, pose, free_number, prefab, instance, generators, \
      lamina, finger, chain, grid, ring, stairs, mirror, camera, light, ground, output, surface,  \
      nurbs_face, plane_face, cylinder_face, cone_face, sphere_face, ellipsoid_face, torus_face,  \
      revolution_face, extrusion_face, sweep_face, interpolation_face, nurbs_curve, line_curve,   \
      arc_curve, circle_curve, ellipse_curve, interpolation_curve, outline_curve, joined_curve,   \
      gear_curve, rack_curve, cam_curve, geneva_wheel_curve, geneva_disc_curve, helix_curve

/// All kinds of objects except shapes, paths and events.
extern const KeySet PANTIN_OBJECTS;
inline constexpr auto kAll = [](const auto&... sets) {
  return std::array{&sets...};
}(PANTIN_OBJECTS);

/// Predicates on the kinds of joints that may have a key.
constexpr bool is_line(const JointKindInfo& kind) { return kind.is_line; }
constexpr bool is_no_line(const JointKindInfo& kind) { return !kind.is_line; }
/// The number of coordinates with springs, friction and motors.
constexpr int actuated(const JointKindInfo& kind) {
  int count = 0;
  for (const FreeCoordinate& c : kind.coordinates) count += (c.use & kActuated) != 0;
  return count;
}
constexpr bool acts(const JointKindInfo& kind) { return actuated(kind) > 0; }
constexpr bool acts_twice(const JointKindInfo& kind) { return actuated(kind) > 1; }
constexpr bool is_driven(const JointKindInfo& kind) {
  return (kind.holds_point && kind.rotations != Turns::nowhere) || acts(kind);
}
constexpr bool is_of_files(const JointKindInfo& kind) { return kind.in_files; }
constexpr bool is_of_chains(const JointKindInfo& kind) { return kind.in_files && kind.holds_point; }

constexpr void each_word_of_kinds(bool (*fits)(const JointKindInfo&), auto take) {
  for (const JointKindInfo& kind : kJointKindInfos)
    if (fits(kind)) take(kind.name);
  for (const JointKindInfo& kind : kJointKindInfos)
    if (fits(kind) && !kind.alias.empty()) take(kind.alias);
}
/// Names of the kinds, followed by their aliases.
template <bool (*fits)(const JointKindInfo&)>
inline constexpr auto kWords = [] {
  constexpr std::size_t kCount = [] {
    std::size_t count = 0;
    each_word_of_kinds(fits, [&](std::string_view) { ++count; });
    return count;
  }();
  std::array<std::string_view, kCount> words;
  std::size_t i = 0;
  each_word_of_kinds(fits, [&](std::string_view word) { words[i++] = word; });
  return words;
}();

/// The parameters of joint kinds, each key once, with the union of its ranges.
std::span<const Key> joint_parameters();
constexpr Range range_of(const Parameter& p) {
  switch (p.range) {
    case ParameterRange::not_negative:
      return kNotNegative;
    case ParameterRange::size:
      return kSize;
    case ParameterRange::any:
      break;
  }
  return kAnyNumber;
}
constexpr const Parameter* parameter_of(const JointKindInfo& kind, std::string_view key) {
  for (const Parameter& p : kind.parameters)
    if (p.key == key) return &p;
  return nullptr;
}

}  // namespace keys

/// The keys of one kind of object; the kind must be in the list.
const KeySet& keys_of(std::string_view what);
/// The keys of a kind of shape, from the table of kinds.
const KeySet& keys_of(ShapeKind kind);
/// Its length along y, which may also be given by the ends "from" and "to"; null if it has none.
const SizeKey* length_of(const ShapeTraits& kind);
/// The keys of "path", then of the kinds of paths that are objects, from the list of kinds.
std::span<const KeySet> path_key_sets();

/// The keys of events, from the list of their kinds.
std::span<const KeySet> event_key_sets();

/// All kinds of objects.
std::vector<const KeySet*> all_key_sets();

}  // namespace pantin::detail

#pragma once
/// The keys of a scene file by kind of object. The reader rejects all others. The JSON Schema has
/// the same names under $defs, which a test compares.
#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "engine/joints/kinds.hpp"

namespace pantin::detail {

struct KeySet {
  std::string_view what;  // the kind of object, as errors name it
  std::span<const std::string_view> keys;
};

namespace keys {

using K = const std::string_view[];

inline constexpr K kScene{
    "$schema",  "version",     "title",  "gravity",   "step",      "substeps",
    "duration", "drift_bound", "solver", "materials", "bodies",    "joints",
    "cables",   "pins",        "paths",  "prefabs",   "instances", "generators",
    "camera",   "light",       "ground", "output",    "collision", "collision_groups",
    "gears"};
inline constexpr K kSolver{"type",
                           "rotation_stiffness",
                           "calm_angle_deg",
                           "reservoir_time",
                           "sweeps",
                           "tolerance",
                           "stall_drop",
                           "tension_stiffness",
                           "limiter",
                           "paper_reluctance",
                           "active_set_iterations",
                           "sleep_speed",
                           "integrator",
                           "stabilisation",
                           "baumgarte",
                           "step_tolerance",
                           "damping_ratio"};
inline constexpr K kMaterial{"name", "colour", "roughness", "metallic"};
inline constexpr K kBody{
    "name",         "shape",    "shapes",           "material", "density",
    "mass",         "inertia",  "centre_of_mass",   "position", "rotation",
    "rotation_deg", "velocity", "angular_velocity", "drag",     "gravity_scale",
    "motion",       "solver",   "collision"};
inline constexpr K kCollision{"friction", "restitution", "groups", "with",
                              "others",   "self",        "sensor"};
/// What kinds of joints have of their own, each key once.
constexpr auto each_parameter(auto take) {
  for (int i = 0; i < kJointKinds; ++i)
    for (const Parameter& p : kJointKindInfos[i].parameters) {
      bool first = true;
      for (int k = 0; k < i; ++k)
        for (const Parameter& q : kJointKindInfos[k].parameters) first = first && q.key != p.key;
      if (first) take(p.key);
    }
}
inline constexpr std::size_t kParameterCount = [] {
  std::size_t count = 0;
  each_parameter([&](std::string_view) { ++count; });
  return count;
}();
inline constexpr auto kJointParameters = [] {
  std::array<std::string_view, kParameterCount> keys;
  std::size_t count = 0;
  each_parameter([&](std::string_view key) { keys[count++] = key; });
  return keys;
}();

inline constexpr K kEveryJoint{"name",     "type",     "kind",     "a",        "b",
                               "anchor",   "anchor_a", "anchor_b", "axis",     "across",
                               "axis_a",   "across_a", "axis_b",   "across_b", "rest",
                               "rest_deg", "limits",   "drive",    "point_a",  "point_b",
                               "spring",   "friction", "motor",    "angle",    "travel"};
inline constexpr auto kJoint = [] {
  std::array<std::string_view, std::size(kEveryJoint) + kParameterCount> keys;
  std::ranges::copy(kJointParameters, std::ranges::copy(kEveryJoint, keys.begin()).out);
  return keys;
}();
inline constexpr K kLimits{"angle",    "angle_deg",  "twist",     "twist_deg", "cone",
                           "cone_deg", "swing",      "swing_deg", "first",     "first_deg",
                           "second",   "second_deg", "soft",      "travel",    "restitution"};
inline constexpr K kSoft{"zone", "zone_deg", "stiffness", "damping"};
inline constexpr K kSpring{"stiffness", "damping", "rest", "rest_deg"};
inline constexpr K kFriction{"viscous", "dry", "slip"};
inline constexpr K kMotor{"velocity", "velocity_deg", "position", "position_deg",
                          "gain",     "damping",      "cap"};
inline constexpr K kDof{"spring", "friction", "motor"};
inline constexpr K kGear{"name",  "first",  "first_coordinate", "second", "second_coordinate",
                         "ratio", "offset", "offset_deg"};
inline constexpr K kJointDrive{"target",  "target_deg", "angle", "angle_deg", "stiffness",
                               "damping", "max_torque", "keys",  "loop"};
inline constexpr K kPoseKey{"time", "target", "target_deg", "angle", "angle_deg"};
inline constexpr K kCable{"name",    "a",       "b",      "anchor_a", "anchor_b",
                          "point_a", "point_b", "length", "slack",    "compliance"};
inline constexpr K kPin{"name",      "body",   "anchor",   "point", "to",
                        "anchor_to", "target", "priority", "grip",  "stiffness"};
inline constexpr K kPath{"body", "keyframes", "loop", "lissajous"};
inline constexpr K kKeyframe{"time", "position", "rotation", "rotation_deg"};
inline constexpr K kLissajous{
    "centre",       "amplitude",          "frequency",          "phase_deg",
    "rotation_deg", "rotation_frequency", "rotation_phase_deg", "rise"};
inline constexpr K kPrefab{"name",  "bodies",    "joints",     "cables", "pins",
                           "paths", "instances", "generators", "gears"};
inline constexpr K kInstance{"name",         "prefab",      "position", "rotation",
                             "rotation_deg", "time_offset", "solver"};
inline constexpr K kGenerators{"chains", "grids", "stairs"};
inline constexpr K kChain{"name",       "links",
                          "length",     "start",
                          "direction",  "end",
                          "sag",        "attach",
                          "end_attach", "shape",
                          "shapes",     "materials",
                          "density",    "mass",
                          "inertia",    "centre_of_mass",
                          "mass_ratio", "tip_mass_factor",
                          "velocity",   "angular_velocity",
                          "drag",       "gravity_scale",
                          "solver",     "collision",
                          "path",       "closed",
                          "kind",       "axis",
                          "limits",     "drive",
                          "spring",     "friction",
                          "motor"};
inline constexpr K kGrid{"name",     "prefab",       "count",       "spacing", "position",
                         "rotation", "rotation_deg", "time_offset", "solver"};
inline constexpr K kStairs{"name",     "count",    "width",        "rise",     "run",
                           "position", "rotation", "rotation_deg", "material", "collision"};
inline constexpr K kCamera{"eye", "target", "field_of_view_deg", "automatic"};
inline constexpr K kLight{"direction", "colour", "strength", "sky", "ground"};
inline constexpr K kGround{"visible", "height"};
inline constexpr K kOutput{"size", "fps"};

}  // namespace keys

inline constexpr std::array<KeySet, 30> kKeySets{{
    {"scene", keys::kScene},
    {"solver", keys::kSolver},
    {"material", keys::kMaterial},
    {"body", keys::kBody},
    {"collision", keys::kCollision},
    {"joint", keys::kJoint},
    {"limits", keys::kLimits},
    {"soft", keys::kSoft},
    {"spring", keys::kSpring},
    {"friction", keys::kFriction},
    {"motor", keys::kMotor},
    {"dof", keys::kDof},
    {"gear", keys::kGear},
    {"joint_drive", keys::kJointDrive},
    {"pose_key", keys::kPoseKey},
    {"cable", keys::kCable},
    {"pin", keys::kPin},
    {"path", keys::kPath},
    {"keyframe", keys::kKeyframe},
    {"lissajous", keys::kLissajous},
    {"prefab", keys::kPrefab},
    {"instance", keys::kInstance},
    {"generators", keys::kGenerators},
    {"chain", keys::kChain},
    {"grid", keys::kGrid},
    {"stairs", keys::kStairs},
    {"camera", keys::kCamera},
    {"light", keys::kLight},
    {"ground", keys::kGround},
    {"output", keys::kOutput},
}};

/// A key, or a word under a key, that files of earlier versions use. The reader takes it with a
/// warning that names today's.
struct OldKey {
  std::string_view what, old, today;
};
inline constexpr OldKey kOldKeys[] = {
    {"scene", "strings", "cables"},
    {"scene", "drives", "paths"},
    {"scene", "ratios", "gears"},
    {"prefab", "strings", "cables"},
    {"prefab", "drives", "paths"},
    {"prefab", "ratios", "gears"},
    {"solver", "passes", "active_set_iterations"},
    {"solver", "rounds", "sweeps"},
    {"solver", "rest_speed", "sleep_speed"},
    {"solver", "turn_stiffness", "rotation_stiffness"},
    {"joint", "turn", "angle"},
    {"joint", "slide", "travel"},
    {"gear", "first_moves", "first_coordinate"},
    {"gear", "second_moves", "second_coordinate"},
    {"lissajous", "turn_deg", "rotation_deg"},
    {"lissajous", "turn_frequency", "rotation_frequency"},
    {"lissajous", "turn_phase_deg", "rotation_phase_deg"},
};
inline constexpr OldKey kOldWords[] = {
    {"gear", "turn", "angle"},
    {"gear", "slide", "travel"},
};

/// Today's name for an old one in such a table, or "".
constexpr std::string_view today_of(std::span<const OldKey> table, std::string_view what,
                                    std::string_view old) {
  for (const OldKey& key : table)
    if (key.what == what && key.old == old) return key.today;
  return {};
}

/// The keys of one kind of object; the kind must be in the list.
constexpr const KeySet& keys_of(std::string_view what) {
  for (const KeySet& set : kKeySets)
    if (set.what == what) return set;
  return kKeySets[0];
}

}  // namespace pantin::detail

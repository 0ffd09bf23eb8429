#include "tools/pantin/view_tune.hpp"

#ifdef PANTIN_HAS_VIEW
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>

#include "engine/scene/read/units.hpp"
#include "tools/pantin/joint_source.hpp"
#include "tools/pantin/scene_number.hpp"
#include "tools/pantin/view_knobs.hpp"

namespace pantin::program {

using namespace detail;

namespace {

/// A value of the file, and its pointer there.
struct FileValue {
  std::string pointer, value;
};

/// Where a value goes, or why nowhere.
struct Target {
  std::optional<FileValue> value;
  std::string shared;  // what else has this value then
  std::string reason;
};

/// A number of a joint's law: its key, its unit where it is along an angle, and the coordinate.
struct JointNumber {
  std::string key;
  std::string_view unit_of_angle;
  Coordinate along;
};

/// A scene file, parsed.
struct SceneText {
  JsonDocument json;
  double unit = 1;  // m

  explicit SceneText(std::string_view text) {
    JsonLimits limits;
    limits.style = JsonStyle::json5;
    json = parse_json(text, limits);
    unit = length_unit_of(json);
  }
  /// The member of a joint's object under a key, in rad or m, or in degrees under key_deg.
  std::optional<FileValue> number(NodeId object, const JointNumber& of, double value) const {
    if (object == kNoNode || json[object].kind != JsonKind::object) return std::nullopt;
    if (const NodeId node = json.member(object, of.key + "_deg"); node != kNoNode)
      return FileValue{json.pointer(node), fmt::format("{}", glm::degrees(value))};
    const NodeId node = json.member(object, of.key);
    if (node == kNoNode) return std::nullopt;
    const double scale = to_si(of.unit_of_angle, of.along, unit);
    return FileValue{json.pointer(node), fmt::format("{}", value / scale)};
  }
};

/// A joint of the file, and the knob that was turned.
struct TurnedJoint {
  const SceneText& file;
  const JointSource& source;
  JointKnob knob;
  double value;

  bool travels() const { return knob.along == Coordinate::travel; }
  std::optional<FileValue> law(std::string_view name, const std::string& key,
                               std::string_view of_angle) const;
  std::optional<FileValue> limit(int which) const;
  std::optional<FileValue> place() const;
};

/// A number of a law: in the joint itself, or below the coordinate's name where it has several.
std::optional<FileValue> TurnedJoint::law(std::string_view name, const std::string& key,
                                          std::string_view of_angle) const {
  NodeId object = source.value(file.json, name);
  if (knob.is_named)
    if (const NodeId own = source.value(file.json, travels() ? "travel" : "angle"); own != kNoNode)
      object = file.json.member(own, name);
  return file.number(object, {key, of_angle, knob.along}, value);
}

/// The end of a limit: `which` is 0 or 1.
std::optional<FileValue> TurnedJoint::limit(int which) const {
  const NodeId limits = source.value(file.json, "limits");
  if (limits == kNoNode || file.json[limits].kind != JsonKind::object) return std::nullopt;
  constexpr std::string_view kAngles[] = {"angle",     "angle_deg", "twist",
                                          "twist_deg", "first",     "first_deg"};
  constexpr std::string_view kTravels[] = {"travel"};
  for (const std::string_view key :
       travels() ? std::span<const std::string_view>(kTravels) : std::span(kAngles)) {
    const NodeId range = file.json.member(limits, key);
    if (range == kNoNode || file.json[range].count != 2) continue;
    const double shown = key.ends_with("_deg") ? glm::degrees(value)
                         : travels()           ? value / file.unit
                                               : value;
    return FileValue{fmt::format("{}/{}", file.json.pointer(range), which),
                     fmt::format("{}", shown)};
  }
  return std::nullopt;
}

std::optional<FileValue> TurnedJoint::place() const {
  switch (knob.value) {
    case JointValue::motor: {
      const auto velocity = law("motor", "velocity", "rad/s");
      return velocity ? velocity : law("motor", "position", "rad");
    }
    case JointValue::stiffness:
    case JointValue::damping: {
      const std::string key = knob.value == JointValue::damping ? "damping" : "stiffness";
      const char* unit = knob.value == JointValue::damping ? "N m s/rad" : "N m/rad";
      // A spring between two points has them as keys of its own.
      if (source.text(file.json, "kind") == "spring")
        return file.number(source.objects.front(), {key, unit, knob.along}, value);
      return law("spring", key, unit);
    }
    case JointValue::least:
    case JointValue::most:
      return limit(knob.value == JointValue::least ? 0 : 1);
  }
  return std::nullopt;
}

Target value_of_joint(const SceneText& file, const JointKnob& knob, double value) {
  const JointSource source = source_of_joint(file.json, knob.joint);
  if (!source.missing.empty()) return {std::nullopt, {}, source.missing};
  const TurnedJoint joint{file, source, knob, value};
  const bool has_sign = knob.value != JointValue::stiffness && knob.value != JointValue::damping;
  if (source.is_image && joint.travels() && has_sign)
    return {std::nullopt, {}, "it is mirrored: move the slider of the original"};
  Target target{joint.place(), source.shared, {}};
  if (!target.value) target.reason = "the file gives no number for it";
  return target;
}

/// Where a knob's value belongs in the file.
Target target_of(const SceneText& file, const std::string& name, double value, const World& start) {
  const auto plain = [](const std::string& pointer, double x) {
    return Target{FileValue{pointer, fmt::format("{}", x)}, {}, {}};
  };
  if (name == "step") return plain("/step", 1e-3 * value);
  if (name == "substeps") return plain("/substeps", value);
  if (name == "gravity") {
    const Real g = glm::length(start.gravity);
    const Vec3 v = value / file.unit * (g > 0 ? start.gravity / g : Vec3(0, -1, 0));
    return {FileValue{"/gravity", fmt::format("[{}, {}, {}]", v.x, v.y, v.z)}, {}, {}};
  }
  if (name == "sleep_speed") return plain("/solver/sleep_speed", value / file.unit);
  for (const char* setting : {"sweeps", "rotation_stiffness", "damping_ratio"})
    if (name == setting) return plain("/solver/" + name, value);
  if (const auto knob = joint_knob(start, name)) return value_of_joint(file, *knob, value);
  return {std::nullopt, {}, "it scales the drives of all joints"};
}

}  // namespace

TunedText with_knobs(std::string_view text,
                     const std::vector<std::pair<std::string, double>>& turned,
                     const World& start) {
  TunedText tuned{std::string(text), {}, {}};
  for (const auto& [name, value] : turned) {
    const SceneText file(tuned.text);
    const Target to = target_of(file, name, value, start);
    auto written = to.value ? with_value(tuned.text, to.value->pointer, to.value->value)
                            : Result<std::string>(Error{to.reason});
    if (!written) {
      tuned.left.push_back(name + ": " + written.errors().front().message);
      continue;
    }
    tuned.text = std::move(*written);
    if (!to.shared.empty()) tuned.shared.push_back(name + ", of " + to.shared);
  }
  return tuned;
}

}  // namespace pantin::program
#endif

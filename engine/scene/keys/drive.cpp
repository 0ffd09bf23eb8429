// Keys of joint drives, and rotations of joint axes.
#include <cmath>
#include <string>

#include "engine/base/rotation.hpp"
#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using D = JointDrive;

constexpr Key kJointDrive[] = {
    row("target", ValueType::joint_turn, "", "Target rotation. Default: Q = 1."),
    row("target_deg", ValueType::joint_turn_deg, "degrees", "The same."),
    angle("angle", "Target angle of a hinge."),
    angle_deg("angle_deg", "The same."),
    number<&D::stiffness>("stiffness", "N m/rad", kNotNegative, "Of the spring."),
    number<&D::damping>("damping", "N m s/rad", kNotNegative, "Of the damper."),
    number<&D::max_torque>("max_torque", "N m", kNotNegative,
                           "Maximum torque; N for a motion along a travel. Default: unlimited."),
    objects("keys", "pose_key",
            "Targets over time instead, in order of time, by the shortest rotation from each to "
            "the next; constant before the first and after the last."),
    flag<&D::loop>("loop", "Repeat the keys forever; the last must equal the first."),
    object("motion", "drive_motion",
           "Instead of a spring: the coordinate follows this motion exactly, by whatever torque "
           "that takes. Beyond max_torque it yields with that torque, and catches up later. For "
           "the solvers lagrangian and planar."),
};
constexpr Exclusive kDrivePairs[] = {{"target", "angle angle_deg keys"},
                                     {"target_deg", "angle angle_deg keys"},
                                     {"angle", "keys"},
                                     {"angle_deg", "keys"},
                                     {"motion",
                                      "target target_deg angle angle_deg stiffness damping keys "
                                      "loop"}};
constexpr AnyOf kDriveNeeds[] = {{"stiffness damping motion",
                                  "found neither \"stiffness\" nor \"damping\", expected one of "
                                  "them, or an exact \"motion\": without them a drive has no "
                                  "effect"}};
constexpr Beside kDrivePartners[] = {
    {"loop", "keys", "found \"loop\" without \"keys\", expected it with them"}};

constexpr Key kPoseKey[] = {
    number("time", "s", kTime, "When.").needed("a time in seconds"),
    row("target", ValueType::joint_turn, "", "Target at that time."),
    row("target_deg", ValueType::joint_turn_deg, "degrees", "The same."),
    angle("angle", "Target angle of a hinge."),
    angle_deg("angle_deg", "The same."),
};
constexpr Exclusive kPosePairs[] = {{"target", "angle angle_deg"},
                                    {"target_deg", "angle angle_deg"}};
constexpr AnyOf kPoseNeeds[] = {{"target target_deg angle angle_deg",
                                 "found no \"target\", expected the rotation at that time"}};

/// Whether one angle about x determines Q.
bool turns_about_x(JointKind kind) { return turns_of(kind) == Turns::about_x; }

/// Accepted forms of a rotation of joint axes; `whole` is the form that every kind accepts.
std::string turn_words(JointKind kind, std::string_view whole) {
  std::string words;
  if (turns_about_x(kind)) words = "an angle, or ";
  if (turns_of(kind) == Turns::about_two) words = "two angles, or ";
  return words.append(whole);
}

/// "target", or "angle" of a hinge.
std::optional<Quat> read_target(const Reader& from, JointKind kind) {
  const NodeId angle = either(from, "angle");
  if (angle == kNoNode) return read_joint_turn(from, "target", kind);
  Real x = 0;
  if (!read_angles(from, "angle", {&x, 1})) return std::nullopt;
  if (turns_about_x(kind)) return from_rotation_vector({x, 0, 0});
  from.diagnostics.error_at_key(angle,
                                "found the angle of " + a_joint(kind) +
                                    ", expected \"target\": only a hinge has a single angle");
  return std::nullopt;
}

std::optional<PoseKey> read_pose_key(const Reading& reading, NodeId node, JointKind kind) {
  const Reader from = reading.open(node, "pose_key");
  PoseKey key{from.number("time", NAN), read_target(from, kind).value_or(kIdentity)};
  if (std::isnan(key.time)) return std::nullopt;
  return key;
}

void read_pose_keys(const Reading& reading, const Reader& from, JointKind kind, JointDrive& drive) {
  const std::vector<NodeId> nodes = from.items("keys");
  for (NodeId node : nodes) {
    const auto key = read_pose_key(reading, node, kind);
    if (!key) continue;
    if (!drive.keys.empty() && !(key->time > drive.keys.back().time))
      reading.diagnostics.error(node, "found time " + written(key->time) + " after " +
                                          written(drive.keys.back().time) +
                                          ", expected a later one");
    drive.keys.push_back(*key);
  }
  const NodeId list = from.find("keys");
  const bool is_list = list != kNoNode && from.json[list].kind == JsonKind::array;
  if (is_list && nodes.size() < (drive.loop ? 2 : 1))
    reading.diagnostics.error_value(list,
                                    drive.loop ? "two keys or more for a loop" : "one key or more");
  if (!drive.loop || drive.keys.size() < 2) return;
  const Quat last = drive.keys.back().rotation, first = drive.keys.front().rotation;
  const Real turn = glm::length(rotation_vector(last * glm::conjugate(first)));
  if (turn > 1e-6)
    from.error("keys", "found a loop whose last key is " + written(turn * 180 / kPi) +
                           " degrees from its first, expected the same");
}

}  // namespace

constinit const KeySet keys::joint_drive{
    "joint_drive",
    "A spring and damper that rotate a joint towards a target, or an exact motion along its "
    "coordinate. Needs stiffness, damping or both, or a motion.",
    kJointDrive,
    kDrivePairs,
    kDriveNeeds,
    kDrivePartners};
constinit const KeySet keys::pose_key{"pose_key", "A target at a time.", kPoseKey, kPosePairs,
                                      kPoseNeeds};

std::optional<JointDrive> read_pose_drive(const Reading& reading, const Reader& outer,
                                          JointKind kind) {
  const NodeId node = outer.find("drive");
  if (node == kNoNode) return std::nullopt;
  const Reader from = reading.open(node, "joint_drive");
  if (const NodeId motion = from.is_object() ? from.find("motion") : kNoNode; motion != kNoNode) {
    JointDrive drive;
    read_rows(reading, from, drive);
    drive.exact = true;
    drive.motion = read_drive_motion(reading.open(motion, "drive_motion"), reading, kind);
    if (drive.motion.travels) drive.max_torque /= reading.length_unit;  // N, not N m
    return drive;
  }
  if (holds_point(kind) && turns_of(kind) == Turns::nowhere)
    reading.diagnostics.error_at_key(
        node, "found a drive of " + a_joint(kind) + ", expected none: it has no rotation");
  if (!holds_point(kind))
    reading.diagnostics.error_at_key(
        node, "found a drive of " + a_joint(kind) +
                  ", expected a \"motion\" in it, a \"motor\" or a \"spring\": springs of drives "
                  "rotate joints with a shared point");
  JointDrive drive;
  read_rows(reading, from, drive);
  drive.target = read_target(from, kind).value_or(kIdentity);
  read_pose_keys(reading, from, kind, drive);
  return drive;
}

std::optional<Quat> read_joint_turn(const Reader& from, std::string_view key, JointKind kind) {
  const std::string key_deg = std::string(key) + "_deg";
  const NodeId node = either(from, key);
  if (node == kNoNode) return std::nullopt;
  Real angles[2];
  if (turns_about_x(kind) && from.json[node].kind == JsonKind::number) {
    if (!read_angles(from, key, {angles, 1})) return std::nullopt;
    return from_rotation_vector({angles[0], 0, 0});
  }
  if (turns_of(kind) == Turns::about_two && from.json[node].count == 2) {
    if (!read_angles(from, key, angles)) return std::nullopt;
    return rotation_of(UniversalAngles{angles[0], angles[1]});
  }
  const bool in_degrees = !from.has(key);
  if (from.json[node].count != (in_degrees ? 3u : 4u)) {
    from.diagnostics.error_value(node, turn_words(kind, in_degrees ? "three angles in degrees"
                                                                   : "a quaternion [x, y, z, w]"));
    return std::nullopt;
  }
  const Quat turn = from.rotation(kIdentity, key);
  const Real off = glm::length(rotation_vector(allowed_by_kind(kind, turn) * glm::conjugate(turn)));
  if (off <= 1e-6) return turn;
  from.diagnostics.error(node, "found a rotation " + written(off * 180 / kPi) +
                                   " degrees from what " + a_joint(kind) +
                                   " allows, expected one that it allows");
  return std::nullopt;
}

}  // namespace pantin::detail

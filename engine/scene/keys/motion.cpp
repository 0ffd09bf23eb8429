// Keys of the motions of exact drives.
#include <string>

#include "engine/scene/read/read.hpp"
#include "engine/world/drive_motion.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using M = DriveMotion;

constexpr std::string_view kAlong[] = {"angle", "travel"};
/// In the order of MotionLaw.
constexpr std::string_view kLaws[] = {"linear", "spline", "cycloidal", "3-4-5"};

constexpr Key kMotion[] = {
    word<&M::travels>("along", kAlong,
                      "Of a cylindrical joint. Default: the coordinate that the joint has, or the "
                      "angle.")
        .without_default(),
    number("offset", "rad", kAnyNumber,
           "m for a travel. Default: such that the joint starts where it stands."),
    angle_deg("offset_deg", "The same for an angle."),
    number("speed", "rad/s", kAnyNumber, "m/s for a travel.").or_else(0),
    number("speed_deg", "degrees/s", kDegreesRate, "The same for an angle."),
    number("amplitude", "rad", kAnyNumber, "Of a sine; m for a travel.").or_else(0),
    angle_deg("amplitude_deg", "The same for an angle."),
    number<&M::frequency>("frequency", "Hz", kAnyNumber, "Of the sine."),
    angle<&M::phase>("phase", "Of the sine at time 0."),
    angle_deg<&M::phase>("phase_deg", "The same."),
    row("table", ValueType::pairs, "",
        "Times in s, and values in rad or m: [[0, 0], [1, 0.5], [2, 0.5]]. Constant before the "
        "first and after the last."),
    row("table_deg", ValueType::pairs, "", "The same with angles in degrees."),
    word<&M::law>("law", kLaws,
                  "From a row of the table to the next. spline: a smooth curve through all, at "
                  "rest at both ends. cycloidal, 3-4-5: laws of cams, from rest to rest; equal "
                  "values are a dwell."),
    flag<&M::loop>("loop",
                   "Repeat the table forever. If its last value differs from the first, each "
                   "round goes on from there."),
};
constexpr std::string_view kTable = "table table_deg";
constexpr Beside kPartners[] = {
    {"amplitude", "frequency", "found \"amplitude\" without \"frequency\", expected both"},
    {"amplitude_deg", "frequency", "found \"amplitude_deg\" without \"frequency\", expected both"},
    {"frequency", "amplitude amplitude_deg",
     "found \"frequency\" without \"amplitude\", expected both"},
    {"law", kTable, "found \"law\" without \"table\", expected it with one"},
    {"loop", kTable, "found \"loop\" without \"table\", expected it with one"}};

void read_table(const Reader& from, DriveMotion& motion) {
  const bool in_degrees = from.has("table_deg");
  const std::string_view key = in_degrees ? "table_deg" : "table";
  if (!from.has(key)) return;
  if (in_degrees && motion.travels)
    from.error_at_key(key, "found \"table_deg\" for a travel, expected \"table\" in m");
  for (const NodeId node : from.items(key)) {
    Real row[2] = {};
    if (!from.numbers_at(node, row, kAnyNumber)) continue;
    const MotionKnot knot{row[0], in_degrees ? row[1] * kPi / 180 : row[1]};
    if (!motion.knots.empty() && !(knot.time > motion.knots.back().time))
      from.diagnostics.error(node, "found time " + written(knot.time) + " after " +
                                       written(motion.knots.back().time) +
                                       ", expected a later one");
    motion.knots.push_back(knot);
  }
  fit_spline(motion);
  if (motion.knots.size() < 2 && from.json[from.find(key)].kind == JsonKind::array)
    from.error_value(key, "two rows or more, each a time and a value");
}

void read_numbers(const Reader& from, DriveMotion& motion) {
  const Coordinate along = motion.travels ? Coordinate::travel : Coordinate::angle;
  motion.at_start = !from.has("offset") && !from.has("offset_deg");
  motion.offset = read_coordinate(from, "offset", along);
  motion.speed = read_coordinate(from, "speed", along);
  motion.amplitude = read_coordinate(from, "amplitude", along);
  read_table(from, motion);
}

}  // namespace

constinit const KeySet keys::drive_motion{
    "drive_motion",
    "A coordinate of a joint as a function of time: offset + speed t + amplitude sin(2 pi "
    "frequency t + phase) + table.",
    kMotion,
    kNoPairs,
    kNoNeeds,
    kPartners};

DriveMotion read_drive_motion(const Reader& from, const Reading& reading, JointKind kind) {
  DriveMotion motion;
  if (!from.is_object()) return motion;
  const JointKindInfo& info = info_of(kind);
  motion.travels = !info.is_used(Coordinate::angle, kActuated);
  read_rows(reading, from, motion);
  const Coordinate along = motion.travels ? Coordinate::travel : Coordinate::angle;
  const std::string which =
      keys::acts(info) ? " along the " + std::string(kAlong[motion.travels]) : std::string();
  if (!info.is_used(along, kActuated))
    from.error("found a motion" + which + " of " + a_joint(kind) +
               ", expected one of these kinds: " + kinds_where(keys::acts));
  read_numbers(from, motion);
  if (motion.travels) scale(motion, reading.length_unit);
  return motion;
}

UnboundMotion read_drive_motion(const Reader& from, const Reading& reading) {
  UnboundMotion read;
  if (!from.is_object()) return read;
  read_rows(reading, from, read.motion);
  const bool travels = read.motion.travels;
  for (const std::string_view key : {"offset_deg", "speed_deg", "amplitude_deg", "table_deg"})
    read.in_degrees = read.in_degrees || from.has(key);
  read.says_along = from.has("along");
  read.motion.travels = travels && !read.in_degrees;
  read_numbers(from, read.motion);
  read.motion.travels = travels;
  return read;
}

}  // namespace pantin::detail

// Keys of sensors.
#include <string>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using S = SensorRecipe;

/// In the order of SensorKind.
constexpr std::string_view kKinds[] = {"point",    "velocity", "acceleration", "accelerometer",
                                       "distance", "angle",    "force",        "torque",
                                       "motor",    "contact"};

constexpr Key kSensor[] = {
    own_name<&S::name>("Columns of a record are named by it: NAME, or NAME.x to NAME.z.")
        .needed("a name"),
    word<&S::kind>(
        "type", kKinds,
        "point, velocity, acceleration: of a point of a body. accelerometer: acceleration minus "
        "gravity, in the body's axes. distance: between two points. angle: between two points as "
        "seen from a third, or the rotation between two bodies. force, torque: of a joint on its "
        "second body. motor: torque or force of a joint's motor or exact drive. contact: force of "
        "all contacts on a body.")
        .needed("what it measures"),
    reference<&S::body>("body", "the name of a body", "The body it is fixed to."),
    vector<&S::anchor>("anchor", "m", "A point in the body's own frame. Default: its origin."),
    reference<&S::to>("to", "the name of a body", "The body at the other end."),
    vector<&S::to_anchor>("to_anchor", "m", "A point in the frame of \"to\"."),
    reference<&S::from>("from", "the name of a body",
                        "Of an angle between points: the body with the vertex."),
    vector<&S::from_anchor>("from_anchor", "m", "A point in the frame of \"from\"."),
    reference<&S::joint>("joint", "the name of a joint", "Of a force, a torque or a motor."),
};

}  // namespace

constinit const KeySet keys::sensor{
    "sensor", "A quantity that records and programs read; it has no effect on the motion.",
    kSensor};

bool read_members(const Reading& reading, const Reader& from, SensorRecipe& sensor) {
  if (!read_rows(reading, from, sensor)) return false;
  const bool spans = sensor.kind == SensorKind::distance || sensor.kind == SensorKind::angle;
  const std::string a_sensor = "of a sensor of type " + std::string(kKinds[int(sensor.kind)]);
  enum class Use { needed, optional, none };
  const auto check = [&](std::string_view key, Use use) {
    const std::string found = "\"" + std::string(key) + "\" " + a_sensor;
    if (use == Use::needed && !from.has(key)) from.error("found no " + found + ", expected one");
    if (use == Use::none && from.has(key))
      from.error_at_key(key, "found " + found + ", expected none: see its types");
  };
  const bool of_joint = is_of_joint(sensor.kind);
  const bool of_point = !of_joint && sensor.kind != SensorKind::contact;
  check("joint", of_joint ? Use::needed : Use::none);
  check("body", of_joint ? Use::none : Use::needed);
  check("anchor", of_point ? Use::optional : Use::none);
  check("to", spans ? Use::needed : Use::none);
  check("to_anchor", spans ? Use::optional : Use::none);
  check("from", sensor.kind == SensorKind::angle ? Use::optional : Use::none);
  check("from_anchor", from.has("from") ? Use::optional : Use::none);
  return true;
}

}  // namespace pantin::detail

#pragma once
/// A sensor: a quantity that is read from a World between steps.
#include <limits>
#include <string>

#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

/// What a sensor measures: one number, or a vector in world axes unless said otherwise.
enum class SensorKind : std::uint8_t {
  point,          // m: the position of point a
  velocity,       // m/s, of point a
  acceleration,   // m/s^2, of point a: mean since the last reading
  accelerometer,  // the same minus gravity, in the axes of its body
  distance,       // m, from point a to point b
  angle,          // rad: at point b between a and c, 0 to pi; between bodies a and b, by which b
                  // has rotated against a's axes
  force,          // N: of joint a on its body b, with its stops, mean over the step
  torque,         // N m: the same, about the anchor
  motor,          // N m or N, along the coordinate of joint a: of its motor, or of its exact drive
  contact         // N: of all contacts on body a, mean over the step
};
constexpr SensorKind last_of(SensorKind) { return SensorKind::contact; }

/// A point fixed in a body (its mass-centre frame, m); in the world without one.
struct SensorPoint {
  Entity on = {};  // a joint, for force, torque and motor
  Vec3 at{0};
};

/// It costs nothing but its reading: see read_sensor() in <pantin/measure.hpp>.
struct Sensor {
  std::string name = {};
  SensorKind kind = SensorKind::point;
  SensorPoint a = {}, b = {}, c = {};
  bool by_points = false;  // angle: at point b
  // The last reading, of accelerations:
  Vec3 velocity{0};
  Real time = std::numeric_limits<Real>::quiet_NaN();
};

/// Whether it measures a joint, not points of bodies.
constexpr bool is_of_joint(SensorKind kind) {
  return kind == SensorKind::force || kind == SensorKind::torque || kind == SensorKind::motor;
}

/// 1 or 3 numbers.
constexpr int components_of(SensorKind kind) {
  const bool is_number =
      kind == SensorKind::distance || kind == SensorKind::angle || kind == SensorKind::motor;
  return is_number ? 1 : 3;
}

}  // namespace pantin

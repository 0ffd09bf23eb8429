#pragma once
// Quantities of joints, cables, pins and contacts, as columns of a record.
#include <array>
#include <functional>
#include <iterator>
#include <pantin/contacts.hpp>
#include <pantin/measure.hpp>
#include <span>
#include <string>
#include <vector>

namespace pantin::program {

/// One column: its name and unit, and its value after a step; NaN where there is none.
struct Reading {
  std::string name, unit;
  std::function<Real(const World&)> value;
};

/// The readings of a World whose structure is built, by name: for each joint those of its
/// coordinates (angle, second_angle, travel in rad and m, angular_speed, speed per second), what
/// its motor or exact drive exerts (motor, N m or N), and its reaction (reaction_fx to reaction_tz,
/// N and N m, about the anchor, on body b); for each cable its tension (N); for each pin its force
/// (pin_fx to pin_fz, N); for each body that collides the force of all its contacts (contact_fx to
/// contact_fz, N, mean over the step), and the number of bodies that it touches or, as a sensor,
/// overlaps (contacts). `events` must outlive them and be updated after each step; `step` is its
/// length, s.
std::vector<Reading> readings_of(const World& world, const ContactEvents& events, Real step);

/// The same of one joint, cable, pin or body; of a body behind its position and velocities (x to
/// z, m; vx to vz, m/s; wx to wz, rad/s), as a record has them. Nothing for another entity.
std::vector<Reading> readings_of(const World& world, Entity object, const ContactEvents& events,
                                 Real step);

/// The columns of a body in a record: its origin's position (m) and rotation (quaternion x, y, z,
/// w), velocity and angular velocity of its mass centre (m/s, rad/s), world axes.
struct BodyColumn {
  const char *name, *unit;
};
inline constexpr BodyColumn kBodyColumns[] = {
    {"x", "m"},      {"y", "m"},      {"z", "m"},     {"qx", ""},    {"qy", ""},
    {"qz", ""},      {"qw", ""},      {"vx", "m/s"},  {"vy", "m/s"}, {"vz", "m/s"},
    {"wx", "rad/s"}, {"wy", "rad/s"}, {"wz", "rad/s"}};
/// Their values; NaN if the body is gone.
std::array<Real, std::size(kBodyColumns)> columns_of_body(const World& world, Entity body);

/// The readings of sensors: NAME, or NAME.x to NAME.z.
std::vector<Reading> readings_of(std::span<const Sensor> sensors);

}  // namespace pantin::program

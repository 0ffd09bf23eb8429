#pragma once
/// A lamina and its fingers as a scene file or a program describes them, in the x-y plane of the
/// scene, at time 0: SI units, moments about the scene's origin, counter-clockwise positive.
/// Invalid descriptions are rejected here, for both.
#include <optional>
#include <string>
#include <vector>

#include "engine/modes/lamina.hpp"
#include "engine/modes/uncertain.hpp"

namespace pantin::detail {

/// Position of a finger at a time.
struct Waypoint {
  Real time = 0;  // s
  modes::Vec2 at;
};

struct FingerPlan {
  std::string name;
  modes::Vec2 point, normal;   // normal: unit, into the lamina, across the nearest edge
  bool flat = false;           // an edge of its own touches a corner of the lamina
  std::vector<Waypoint> path;  // two or more, times rising from 0; it rests after the last
  Real roll = 0.5, slide = 0.5;
  modes::Spread spread;  // of its one coefficient, if that is not certain
  bool touches = true;   // at the start
};

struct LaminaPlan {
  std::string name;
  std::vector<modes::Vec2>
      outline;         // corners, counter-clockwise; none: only its contacts are known
  modes::Vec2 centre;  // of mass
  Real mass = 1;       // kg
  modes::Vec2 force;   // at the mass centre, weight included, N
  Real torque = 0;     // N m
  std::vector<FingerPlan> fingers;

  /// Force and moment about the origin.
  Vec3 load() const { return {force.x, force.y, torque + modes::cross(centre, force)}; }
};

/// Whether it can be moved: it has an outline and a mass.
inline bool is_body(const LaminaPlan& lamina) { return !lamina.outline.empty() && lamina.mass > 0; }

/// The name of the body of a finger: "rod/left".
inline std::string body_name(const LaminaPlan& lamina, const FingerPlan& finger) {
  return lamina.name + '/' + finger.name;
}

/// Velocity over the first stretch of its path, m/s.
modes::Vec2 first_velocity(const FingerPlan& finger);

/// The error in a description, and its place: "found ..., expected ...".
struct LaminaFault {
  enum class Place : std::uint8_t { outline, corner, finger, point, normal, load } place;
  std::size_t corner = 0;
  std::string found, expected;
};
using LaminaFinding = std::optional<LaminaFault>;

/// Rejects outlines that bound no area; reorders clockwise ones.
LaminaFinding check_outline(std::vector<modes::Vec2>& corners);

/// Starts a finger's path at its point; call it before waypoints are added.
void start_path(FingerPlan& finger);
/// Appends a waypoint; rejects times that do not grow.
LaminaFinding add_waypoint(FingerPlan& finger, const Waypoint& next);
/// Gives a finger without waypoints a constant velocity for ever.
void move_steadily(FingerPlan& finger, modes::Vec2 velocity);

/// Places a finger that has a point and a path on the edge or corner that it touches, or off the
/// outline. A normal of (0, 0) is replaced by the edge's.
LaminaFinding place_finger(const LaminaPlan& lamina, FingerPlan& finger);

/// Faults where the finger repeats the name, or the point and normal, of another one.
std::vector<LaminaFault> repeated(const LaminaPlan& lamina, const FingerPlan& finger);

/// Rejects laminas without load.
LaminaFinding check_load(const LaminaPlan& lamina);

}  // namespace pantin::detail

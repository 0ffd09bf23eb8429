#pragma once
/// Claims of shipped scenes: what a title says, shown by numbers of its run.
///
///   CLAIM("two_balls", "the one that is hit goes on as fast") {
///     const Played p = play("two_balls");
///     CHECK(...);
///   }
#include <catch2/catch.hpp>
#include <functional>
#include <pantin/pantin.hpp>
#include <pantin/scene.hpp>
#include <set>
#include <string>

namespace pantin::test {

/// The scenes that have a claim.
inline std::set<std::string>& claimed() {
  static std::set<std::string> all;
  return all;
}
inline bool note_claim(const char* scene) { return claimed().insert(scene).second; }

/// A run of a shipped scene, whose steps could all be taken, whose joints stayed closed.
struct Played {
  Scene scene;
  World end;
  Real worst_gap = 0;                               // part of the island's size
  Real worst_violation = 0;                         // rad, of what joints allow
  Real worst_depth = 0;                             // m, at contacts
  Real worst_residual = 0;                          // m, of pins, cables and loops
  Real most_energy = -1e300, least_energy = 1e300;  // J, over all steps
  Real start_energy = 0;                            // J
  StepReport last = {};

  const Body& body(const char* name) const { return end.bodies[end.find(name)]; }
  Vec3 place(const char* name) const { return end.origin_pose(end.find(name)).position; }
  Vec3 start(const char* name) const {
    return scene.world.origin_pose(scene.world.find(name)).position;
  }
};

/// Sees the World before the first step and after every step.
using Watch = std::function<void(const World&)>;

/// Runs a scene for its duration, or for some seconds of it.
Played play(const std::string& name, const Watch& watch = {}, Real seconds = 0);

/// Calls `see` with each dynamic body.
void each_moving(const World& world, const std::function<void(const Body&)>& see);

/// Speed of the fastest dynamic body, m/s.
Real fastest(const World& world);

/// The lowest and the highest of the numbers seen.
struct Extent {
  Real least = 1e300, most = -1e300;
  void add(Real x) { least = std::min(least, x), most = std::max(most, x); }
};

/// Counts whole turns of an angle that goes round.
struct Turns {
  Real angle = 0, way = 0;  // rad
  bool known = false;
  void add(Real now) {
    if (known) way += std::remainder(now - angle, 2 * kPi);
    angle = now, known = true;
  }
};

/// The angle of a body's own x axis about z, rad.
inline Real angle_of(const World& w, Entity body) {
  const Vec3 x = w.origin_pose(body).rotation * Vec3(1, 0, 0);
  return std::atan2(x.y, x.x);
}

}  // namespace pantin::test

#define PANTIN_JOIN_(a, b) a##b
#define PANTIN_JOIN(a, b) PANTIN_JOIN_(a, b)
#define CLAIM(scene, what)                                                              \
  [[maybe_unused]] static const bool PANTIN_JOIN(claim_, __LINE__) = note_claim(scene); \
  TEST_CASE(scene ".json: " what)

#pragma once
// The record of a run: one CSV row a step.
#include <string>

#include "engine/base/atomic_file.hpp"
#include "engine/world/report.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// Writes `path`: time_s; for each body its origin's position x y z (m), rotation x y z w, velocity
/// and angular velocity of its mass centre (m/s, rad/s, world axes); for each joint its gap (m);
/// kinetic, potential and total energy (J); momentum (kg m/s) and angular momentum about the origin
/// (kg m^2/s). Where the Lagrangian solver is at work also: for each of its joints the force (N)
/// and torque (N m, about the mass centre) on body b, world axes; elastic energy (J), equations of
/// the joints and their rank. Grows beside `path` and takes its place when it is closed.
class Record {
 public:
  /// Opens the file and writes the header.
  Result<Done> open(const std::string& path, const World& world);
  /// Writes the row of a state.
  Result<Done> add(const World& world, const Measures& measures);
  /// Puts the file into its place, whole up to the last row; after a failed `add` it fails too, and
  /// an older file stays.
  Result<Done> close();

 private:
  AtomicFile file_;
  bool exact_ = false;  // islands are recorded
};

}  // namespace pantin::program

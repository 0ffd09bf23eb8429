#pragma once
// The record of a run: one CSV row per step.
#include <string>
#include <vector>

#include "engine/base/atomic_file.hpp"
#include "engine/world/report.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// Writes `path`. Columns: time_s; for each body its origin's position x y z (m), rotation x y z w,
/// velocity and angular velocity of its mass centre (m/s, rad/s, world axes); for each joint its
/// gap (m); kinetic, potential and total energy (J); momentum (kg m/s) and angular momentum about
/// the origin (kg m^2/s). With the Lagrangian solver also: for each of its joints the force (N) and
/// torque (N m, about the mass centre) on body b, world axes; elastic energy (J), constraint rows
/// and their rank. Objects that an event removes have empty cells from then on; objects added after
/// the start have no columns. The file is written beside `path` and renamed when it is closed.
class Record {
 public:
  /// Opens the file and writes the header.
  Result<Done> open(const std::string& path, const World& world);
  /// Writes the row of the present state.
  Result<Done> add(const World& world, const Measures& measures);
  /// Moves the file into place, with all rows so far. After a failed `add` it fails too, and an
  /// older file is kept.
  Result<Done> close();

 private:
  void add_bodies(std::string& row, const World& world) const;
  void add_gaps(std::string& row, const World& world) const;
  void add_islands(std::string& row, const World& world, const Measures& m) const;

  AtomicFile file_;
  // In the order of the columns:
  std::vector<Entity> bodies_, links_, exact_links_;
  bool exact_ = false;  // the islands of the Lagrangian solver are recorded
};

}  // namespace pantin::program

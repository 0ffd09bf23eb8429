#pragma once
// The record of a run: one CSV row per step.
#include <optional>
#include <string>
#include <vector>

#include "engine/base/atomic_file.hpp"
#include "engine/world/report.hpp"
#include "engine/world/world.hpp"
#include "tools/pantin/npz.hpp"
#include "tools/pantin/readings.hpp"

namespace pantin::program {

using namespace detail;

/// What a record holds.
struct RecordChoices {
  std::vector<std::string> columns;  // patterns of names, with * and ?; empty: the standard ones
  int digits = 0;                    // significant; 0: as many as needed to read back the same bits
  double step = 0;                   // s
  std::vector<Sensor> sensors;       // of the scene
};

/// Writes `path`. Columns: time_s; for each body its origin's position x y z (m), rotation x y z w,
/// velocity and angular velocity of its mass centre (m/s, rad/s, world axes); for each joint its
/// gap (m); kinetic, potential and total energy (J); momentum (kg m/s) and angular momentum about
/// the origin (kg m^2/s). With the Lagrangian solver also: for each of its joints the force (N) and
/// torque (N m, about the mass centre) on body b, world axes; elastic energy (J), constraint rows
/// and their rank. Objects that an event removes have empty cells from then on; objects added after
/// the start have no columns. With patterns, only the columns that match one and time_s, in this
/// order, followed by the readings of joints, cables, pins, contacts and sensors (`readings_of`). A
/// path in .npz gets an array for each column instead, NaN where there is no value. The file is
/// written beside `path` and renamed when it is closed.
class Record {
 public:
  /// Finds the columns; an error if a pattern matches none.
  Result<Done> check(const World& world, const RecordChoices& choices);
  /// Opens the file and writes the header, after `check`.
  Result<Done> open(const std::string& path);
  /// Writes the row of the present state.
  Result<Done> add(const World& world, const Measures& measures);
  /// Moves the file into place, with all rows so far. After a failed `add` it fails too, and an
  /// older file is kept.
  Result<Done> close();

 private:
  std::vector<std::string> standard_columns(const World& built);
  std::string choose(const std::vector<std::string>& patterns,
                     const std::vector<std::string>& names);
  void add_gaps(std::vector<Real>& row, const World& world) const;
  void add_islands(std::vector<Real>& row, const World& world, const Measures& m) const;

  AtomicFile file_;
  // In the order of the columns:
  std::vector<Entity> bodies_, links_, exact_links_;
  std::vector<std::string> names_;       // of all columns
  std::vector<std::size_t> chosen_;      // of these; empty: all
  std::size_t standard_ = 0;             // readings follow behind these
  std::vector<Reading> readings_;        // refer to the events
  std::optional<ContactEvents> events_;  // where readings are recorded
  int digits_ = 0;
  bool is_npz_ = false;
  std::vector<NpzArray> arrays_;  // of a .npz file, until it is closed
  bool exact_ = false;            // the islands of the Lagrangian solver are recorded
};

}  // namespace pantin::program

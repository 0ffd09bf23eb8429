#pragma once
/// What stores energy between bodies or does work on them: springs, motors, drives and soft stops
/// of joints, elastic cables, spring pins. Reckoned from poses and velocities alone, whatever the
/// solver.
#include <vector>

#include "engine/joints/coordinates.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// One of them. Values are those at the start of a substep.
struct EnergyStore {
  enum class Kind : std::uint8_t {
    coordinate,
    drive,
    soft_stop,
    cable,
    pin
  } kind = Kind::coordinate;
  Coordinate along = Coordinate::angle;  // of kind `coordinate`
  std::uint32_t slot = 0;  // in the store of joints (soft stops too), drives, cables or pins
  std::uint32_t body = 0;  // slot of a dynamic body that it acts on
  Real x = 0, rate = 0;    // the coordinate; from step to step, so that turns count
  Real moved = 0;          // by how much in the last substep
  Quat turn{1, 0, 0, 0}, target{1, 0, 0, 0};  // of a drive
  Vec3 gap{0}, place{0};                      // of a pin, to where its target was; that
  Real energy = 0;                            // J
};

/// What happened to a store in a substep, J.
struct StoreChange {
  Real stored = 0;  // more than before
  Real worked = 0;  // at most done on the bodies by motors and by targets that moved
};

/// All that can act on a dynamic body, at the present poses.
void list_stores(const World& world, std::vector<EnergyStore>& stores);
/// Notes the start of a substep.
void begin_store(const World& world, EnergyStore& store);
StoreChange end_store(const World& world, EnergyStore& store, Real h);

}  // namespace pantin::detail

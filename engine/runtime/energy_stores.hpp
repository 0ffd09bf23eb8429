#pragma once
/// Elements that store energy between bodies or do work on them: springs, motors, drives and soft
/// stops of joints, elastic cables, spring pins. Evaluated from poses and velocities alone,
/// whatever the solver.
#include <vector>

#include "engine/joints/coordinates.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// One such element. Values are those at the start of a substep.
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
  Real x = 0, rate = 0;    // the coordinate, tracked from step to step to count whole turns; its
                           // rate
  Real moved = 0;          // change of the coordinate in the last substep
  Quat turn{1, 0, 0, 0}, target{1, 0, 0, 0};  // of a drive
  Vec3 gap{0}, place{0};                      // of a pin: vector to its previous target; that
                                              // target
  Real energy = 0;                            // J
};

/// Energy exchanged by a store in a substep, J.
struct StoreChange {
  Real stored = 0;  // increase of the stored energy
  Real worked = 0;  // upper bound on the work of motors and moving targets on the bodies
};

/// Lists all such elements that act on a dynamic body, at the present poses.
void list_stores(const World& world, std::vector<EnergyStore>& stores);
/// Notes the start of a substep.
void begin_store(const World& world, EnergyStore& store);
StoreChange end_store(const World& world, EnergyStore& store, Real h);

}  // namespace pantin::detail

#pragma once
/// THE list of findings: events of a step that make its result doubtful. `Status` says that a run
/// cannot go on. A finding says that it goes on with an error that is named, located and measured.
#include <cstdint>
#include <string_view>

#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

enum class FindingKind : std::uint8_t {
  energy_gained,
  energy_lost,
  angular_momentum_changed,
  joint_open,
  limit_exceeded,
  cable_overlong,
  pin_missed,
  gear_slipped,
  belt_slipped,
  surfaces_apart,
  sunk,
  passed_through,
  flung,
  turned_too_far,
  spring_unresolved,
  energy_limited,
  step_rescued,
  contacts_unsolved,
  place_uncertain,
};
constexpr FindingKind last_of(FindingKind) { return FindingKind::place_uncertain; }

/// A row of the table; engine/runtime/README.md has an example of each.
struct FindingInfo {
  std::string_view name;     // in programs and JSON
  std::string_view unit;     // of the amount
  std::string_view meaning;  // one sentence, with the bound
  std::string_view change;   // the remedy, one sentence
};
const FindingInfo& info_of(FindingKind kind);

/// A finding at one body, joint or cable.
struct Finding {
  FindingKind kind = FindingKind::energy_gained;
  Entity where;             // none: the whole World
  Real time = 0;            // s, when it was first found
  Real amount = 0;          // the worst so far, in the unit of its kind
  std::uint64_t steps = 0;  // in which it was found
};

}  // namespace pantin

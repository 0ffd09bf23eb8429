#pragma once
/// THE list of findings: what a step can do that makes its result doubtful. `Status` says that a
/// run cannot go on; a finding, that it goes on with an error which is named, placed and measured.
#include <cstdint>
#include <string_view>

#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

enum class FindingKind : std::uint8_t {
  energy_gained,
  joint_open,
  cable_overlong,
};
constexpr FindingKind last_of(FindingKind) { return FindingKind::cable_overlong; }

/// A row of the table: one paragraph of README.md each.
struct FindingInfo {
  std::string_view name;     // in programs and JSON
  std::string_view unit;     // of the amount
  std::string_view meaning;  // one sentence
  std::string_view change;   // what to do about it, one sentence
};
const FindingInfo& info_of(FindingKind kind);

/// What was found at one body, joint or cable.
struct Finding {
  FindingKind kind = FindingKind::energy_gained;
  Entity where;             // none: the whole World
  Real time = 0;            // s, when it was first found
  Real amount = 0;          // the worst so far, in the unit of its kind
  std::uint64_t steps = 0;  // in which it was found
};

}  // namespace pantin

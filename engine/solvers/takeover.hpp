#pragma once
/// One solver steps bodies that may collide: islands near one of another solver are taken over
/// until they separate.
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/settings.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

/// An island that is stepped by another solver than the one it asks for.
struct Takeover {
  Entity body;        // the first of the island
  SolverSettings by;  // those of the island that it can touch, or the solver's defaults
  Entity other;       // a body that it can touch

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("by", self.by);
    field("other", passive(self.other));
  }
};

struct Takeovers {
  static constexpr std::string_view name = "takeovers";  // in saved Worlds
  std::vector<Takeover> list;                            // in the order of slots

  static void fields(auto& self, auto&& field) { field("list", self.list); }
};

/// Before a substep of `h` seconds: finds which islands may touch, and compiles anew where that
/// changes their solvers. Costs nothing while all solid bodies are of one solver.
void take_over(World& world, Real h);

/// One line for each island that is taken over: which, by which solver, and why.
std::vector<std::string> takeover_lines(const World& world);
/// One line for each island that asks for "auto" and has features that "auto" does not support.
std::vector<std::string> lines_beyond_auto(const World& world);

}  // namespace pantin::detail

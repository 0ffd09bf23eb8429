#pragma once
/// Requests of a program to the next steps: impulses, and pairs of bodies that ignore each other.
#include <string_view>

#include "engine/world/world.hpp"

namespace pantin::detail {

/// An impulse on its owner, a dynamic body, within the next substep.
struct Impulse {
  static constexpr std::string_view name = "impulse";  // in saved Worlds
  Vec3 linear{0};                                      // N s, world axes
  Vec3 angular{0};                                     // N m s, about the mass centre

  static void fields(auto& self, auto&& field) {
    field("linear", self.linear);
    field("angular", self.angular);
  }
};

/// Two bodies that do not collide until a given time. It is an entity of its own.
struct IgnoredPair {
  static constexpr std::string_view name = "ignored pair";  // in saved Worlds
  Entity a, b;
  Real until = 0;  // s

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("until", self.until);
  }
};

}  // namespace pantin::detail

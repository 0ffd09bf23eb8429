#pragma once
/// Modes by linear programmes: those whose motion or forces are not unique, and every mode for
/// cross checks. Each contact rolls, slides either way or separates; a mode is feasible if one
/// programme finds a motion and another finds forces.
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/modes/prepare.hpp"

namespace pantin::detail::modes {

/// Sets of contacts, a bit each; those in none separate.
struct Signs {
  std::uint32_t roll = 0, plus = 0, minus = 0;

  static void fields(auto& self, auto&& field) {
    field("roll", self.roll);
    field("plus", self.plus);
    field("minus", self.minus);
  }
  friend bool operator==(const Signs&, const Signs&) = default;
};
Signs signs_of(const Region& r);
/// "R+-B": rolls, slides along the tangent or against it, separates.
std::string name_of(const Signs& s, std::size_t count);

struct SignedMode {
  Signs signs;
  Vec3 twist{0};  // one motion: m/s at the world origin, rad/s
  bool motion_unique = true;
  Vec3 free_direction{0};  // another motion differs by a multiple of this; 0 if unique or several
  bool forces_unique = true;
  // One set of forces, N.
  std::array<Real, kMostContacts> normal_force{}, tangent_force{};
};

struct SignedModes {
  std::vector<SignedMode> list;
  int programs = 0;      // solved
  bool complete = true;  // false: stopped at kMostPrograms, or a programme stalled
};
inline constexpr int kMostPrograms = 20000;

/// All signed modes at these coefficients.
void find_signed_modes(const Prepared& p, const Friction& mu, SignedModes& out);

/// Whether the lamina can move at all without penetrating a finger.
bool motion_exists(const Prepared& p);
/// Whether forces within the cones of all contacts balance the load.
bool balance_exists(const Prepared& p, const Friction& mu);

}  // namespace pantin::detail::modes

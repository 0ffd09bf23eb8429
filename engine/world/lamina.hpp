#pragma once
/// Laminas: planar parts in the xy plane that fingers hold or push, moved by the solver
/// "quasistatic". A lamina is a component of a dynamic body; its fingers are kinematic bodies.
///
/// Internal (pantin::detail). Call World::mark_dirty() after adding or changing one.
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/store.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

/// A key of a finger's path: where its contact point is at a time.
struct FingerKey {
  Real time = 0;  // s
  Vec3 at{0};     // m, in the World

  static void fields(auto& self, auto&& field) {
    field("time", self.time);
    field("at", self.at);
  }
};

struct LaminaFinger {
  Entity body;                   // kinematic
  Vec3 point{0};                 // the contact point, m, in the mass-centre frame of its body
  Vec3 normal{0, 1, 0};          // unit, into the lamina; a flat finger is an edge across it
  bool flat = false;             // an edge contact; otherwise a point contact
  Real roll = 0.5, slide = 0.5;  // Coulomb's coefficients: while the contact sticks, while it
                                 // slides
  /// The finger moves in straight lines at constant speed from key to key, and rests before the
  /// first and after the last. Empty: the caller moves the body, or a KinematicPath.
  std::vector<FingerKey> path;

  static void fields(auto& self, auto&& field) {
    field("body", self.body);
    field("point", self.point);
    field("normal", self.normal);
    field("flat", self.flat);
    field("roll", self.roll);
    field("slide", self.slide);
    field("path", self.path);
  }
};

struct Lamina {
  std::vector<Vec3> outline;  // corners in the mass-centre frame, counter-clockwise about z, m
  std::vector<LaminaFinger> fingers;

  static constexpr std::string_view name = "lamina";  // in saved Worlds
  static void fields(auto& self, auto&& field) {
    field("outline", self.outline);
    field("fingers", self.fingers);
  }
  /// Checks a saved lamina; returns null, or the fault.
  const char* restored() const;
};

Store<Lamina>& laminas_of(World& world);
const Store<Lamina>* laminas_of(const World& world);

/// Why a body cannot be stepped as a lamina, as a clause, or empty.
std::string lamina_fault(const World& world, Entity body);

/// The contact point of a finger with a path at `time` (s), and its velocity from then on.
struct FingerMotion {
  Vec3 at{0}, velocity{0};
  Real until = 0;  // s: when the velocity changes next; infinite: never
};
FingerMotion motion_of(const std::vector<FingerKey>& path, Real time);

/// Moves the bodies of fingers with paths to their poses at `until` (s), the end of a step of `h`.
void move_fingers(World& world, Real until, Real h);

}  // namespace pantin::detail

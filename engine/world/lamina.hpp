#pragma once
/// Laminas: parts in the plane of x and y that fingers hold or push, moved by the solver
/// "quasistatic". A lamina is a component of a dynamic body, its fingers are kinematic bodies.
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

/// Where the point of a finger is at a time.
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
  Vec3 point{0};                 // that touches, in the mass-centre frame of its body, m
  Vec3 normal{0, 1, 0};          // of a flat one, which is an edge across it: into the lamina, unit
  bool flat = false;             // otherwise it is a point
  Real roll = 0.5, slide = 0.5;  // Coulomb's coefficients where the contact sticks, where it slides
  /// It moves straight and steadily from one to the next and rests before the first and after the
  /// last. None: the caller moves the body, or a KinematicPath.
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
  /// Null, or what no step can use, for a saved World.
  const char* restored() const;
};

Store<Lamina>& laminas_of(World& world);
const Store<Lamina>* laminas_of(const World& world);

/// Why no step can be computed with a body as a lamina, as a clause, or empty.
std::string lamina_fault(const World& world, Entity body);

/// Where the point of a finger with a path is at `time` (s), and its velocity from then on.
struct FingerMotion {
  Vec3 at{0}, velocity{0};
  Real until = 0;  // s: when the velocity changes next; infinite: never
};
FingerMotion motion_of(const std::vector<FingerKey>& path, Real time);

/// Moves the bodies of fingers that have paths to where they are at `until` (s), `h` later.
void move_fingers(World& world, Real until, Real h);

}  // namespace pantin::detail

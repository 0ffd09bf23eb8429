#pragma once
/// Laminas: planar parts in the xy plane that fingers hold or push so slowly that inertia is
/// negligible. Forces balance at every moment, and each contact sticks, slides or separates:
/// contact modes (engine/modes). Solver::quasistatic moves them. If no mode is feasible, dynamics
/// takes over, which StepReport::lamina reports.
///
///   const Entity rod = must(world.add(LaminaBody{
///       .outline = {{-0.6, 0, 0}, {0.6, 0, 0}, {0.6, 0.02, 0}, {-0.6, 0.02, 0}},
///       .fingers = {{.point = {-0.4, 0, 0}, .velocity = {0.01, 0, 0}},
///                   {.point = {0.25, 0, 0}, .velocity = {-0.01, 0, 0}}}}));
///   for (const ContactMode& mode : contact_modes(world, rod)) ...
#include <cstdint>
#include <optional>
#include <pantin/world.hpp>
#include <string>
#include <vector>

namespace pantin {

/// A plate of constant thickness in its initial position, and its fingers. Points have z = 0.
///
/// Errors: outlines that cross themselves or enclose no area; fingers inside it, at a corner
/// without a normal, or at the same point; no force, torque or weight.
struct LaminaBody {
  /// The position of a finger at a time.
  struct Waypoint {
    Real time = 0;  // s, above 0
    Vec3 at{0};     // m
  };
  /// A kinematic body that touches the lamina, or approaches it.
  struct Finger {
    Vec3 point{0};                         // m, initial contact point
    std::optional<Vec3> normal = {};       // into the lamina; none: perpendicular to the edge at
                                           // its point
    bool flat = false;                     // an edge perpendicular to `normal`, on which corners
                                           // may rest
    Real roll = 0.5, slide = 0.5;          // coefficients: while it sticks, while it slides
    Vec3 velocity{0};                      // m/s, constant, without waypoints
    std::vector<Waypoint> waypoints = {};  // linear from one to the next; it rests after the last
    std::uint32_t material = 0;            // index into World::materials
    std::string name = {};                 // none: its number, from 1; the body's is "rod/left"
  };
  std::vector<Vec3> outline = {};        // corners, in either direction, m
  std::optional<Vec3> mass_centre = {};  // none: the centroid of the area
  Real mass = 1;                         // kg
  Vec3 force{0};                         // N, at the mass centre, besides its weight
  Real torque = 0;                       // N m
  std::vector<Finger> fingers = {};      // 1 to 32
  std::uint32_t material = 0;
  std::string name = {};
};
/// Returns the body of the lamina; those of its fingers are fingers_of().
Result<Entity> add_to(World& world, const LaminaBody& lamina);

/// The bodies of its fingers, in order; empty if the entity is not a lamina.
std::vector<Entity> fingers_of(const World& world, Entity lamina);

enum class ContactState : std::uint8_t {
  separates,
  sticks,
  slides_left,  // the lamina, as seen along the normal into it
  slides_right
};

/// A contact of a finger with the lamina; a flat finger may have two.
struct FingerContact {
  Entity finger = {};
  Vec3 point{0};   // m
  Vec3 normal{0};  // into the lamina, unit
  ContactState state = ContactState::separates;
  Vec3 force{0};  // N, on the lamina
};

/// A possible motion of a lamina for the present motion of its fingers.
struct ContactMode {
  std::vector<FingerContact> contacts = {};
  Vec3 velocity{0};           // m/s, of its mass centre
  Real angular_velocity = 0;  // rad/s
  bool is_stable = false;     // a small disturbance decays; known if the forces are unique
};

/// All feasible modes at present: forces balance within friction, and no finger penetrates. Empty
/// if dynamics has to take over. With several modes, friction alone does not decide.
std::vector<ContactMode> contact_modes(const World& world, Entity lamina);

/// The mode of the last step; none if dynamics moved the lamina.
std::optional<ContactMode> contact_mode(const World& world, Entity lamina);

}  // namespace pantin

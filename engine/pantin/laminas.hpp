#pragma once
/// Laminas: parts in the plane of x and y that fingers hold or push so slowly that their inertia
/// does not count. Forces balance at every moment, and each contact sticks, slides or separates:
/// contact modes (engine/modes). Solver::quasistatic moves them; where no mode has an answer,
/// dynamics goes on, which StepReport::lamina names.
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

/// A plate of even thickness, as it stands, and the fingers on it. Points have z = 0.
///
/// Errors: outlines that cross themselves or bound no area; fingers inside of it, at a corner
/// without a normal, twice at one place; neither force, torque nor weight.
struct LaminaBody {
  /// Where a finger is at a time.
  struct Waypoint {
    Real time = 0;  // s, above 0
    Vec3 at{0};     // m
  };
  /// A kinematic body that touches the lamina, or waits before it.
  struct Finger {
    Vec3 point{0};                         // m, where it starts
    std::optional<Vec3> normal = {};       // into the lamina; none: across the edge at its point
    bool flat = false;                     // an edge across `normal`, on which corners may lie
    Real roll = 0.5, slide = 0.5;          // friction where it sticks, where it slides
    Vec3 velocity{0};                      // m/s, for ever, if it has no waypoints
    std::vector<Waypoint> waypoints = {};  // straight from one to the next; it rests after the last
    std::uint32_t material = 0;            // index into World::materials
    std::string name = {};                 // none: its number, from 1; the body's is "rod/left"
  };
  std::vector<Vec3> outline = {};        // corners, either way round, m
  std::optional<Vec3> mass_centre = {};  // none: the middle of the area
  Real mass = 1;                         // kg
  Vec3 force{0};                         // N, at the mass centre, beside its weight
  Real torque = 0;                       // N m
  std::vector<Finger> fingers = {};      // 1 to 32
  std::uint32_t material = 0;
  std::string name = {};
};
/// Its body; those of its fingers: fingers_of().
Result<Entity> add_to(World& world, const LaminaBody& lamina);

/// The bodies of its fingers, in their order; none of what is no lamina.
std::vector<Entity> fingers_of(const World& world, Entity lamina);

enum class ContactState : std::uint8_t {
  separates,
  sticks,
  slides_left,  // the lamina, as seen along the normal into it
  slides_right
};

/// A finger where it touches the lamina; a flat one may do so twice.
struct FingerContact {
  Entity finger = {};
  Vec3 point{0};   // m
  Vec3 normal{0};  // into the lamina, unit
  ContactState state = ContactState::separates;
  Vec3 force{0};  // N, on the lamina
};

/// One way in which a lamina can move while its fingers move as they do.
struct ContactMode {
  std::vector<FingerContact> contacts = {};
  Vec3 velocity{0};           // m/s, of its mass centre
  Real angular_velocity = 0;  // rad/s
  bool is_stable = false;     // a small disturbance dies away; where forces are unique
};

/// All that hold as it stands, none where dynamics has to go on: forces balance within friction,
/// and no finger gets into it. Several: friction alone does not decide.
std::vector<ContactMode> contact_modes(const World& world, Entity lamina);

/// The one that it moved in at the last step; none where dynamics moved it.
std::optional<ContactMode> contact_mode(const World& world, Entity lamina);

}  // namespace pantin

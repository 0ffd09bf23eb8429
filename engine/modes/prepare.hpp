#pragma once
/// The part of a lamina's contact modes that is independent of friction: motions, slips, regions.
#include <vector>

#include "engine/modes/region.hpp"

namespace pantin::detail::modes {

/// Whether the fingers' motion allows a mode.
enum class Kinematics : std::uint8_t {
  ok,
  break_tie,   // ok, but another contact neither separates nor penetrates: it could carry load
  penetrates,  // another contact would penetrate
  zero_slip,   // a contact said to slide does not: a case of several rolling contacts
  singular     // contacts on one edge, normals through one point, one point twice: no unique motion
};
const char* word_for(Kinematics status);

/// A mode with as many unknowns as equations: three contacts slide, or one rolls and one slides.
struct Candidate {
  Kind kind = Kind::three_slide;
  Kinematics status = Kinematics::ok;
  std::array<std::uint8_t, 3> contacts{};
  std::int32_t region = -1;  // in Prepared::regions; -1 unless ok or break_tie
};

/// Filled by prepare(); may be used again for another lamina, and then takes no memory.
struct Prepared {
  std::size_t count = 0;              // contacts
  std::vector<Candidate> candidates;  // all C(n,3) + n(n-1), three_slide first
  std::vector<Region> regions;        // of those that the motion allows
  std::array<int, 5> found{};         // candidates of each Kinematics

  // In the solver's frame: about the contacts' centroid, lengths in `scale`, velocities in `speed`.
  std::array<Vec3, kMostContacts> normal, tangent;                    // wrenches of unit forces
  std::array<Real, kMostContacts> normal_velocity, tangent_velocity;  // of the fingers
  Vec3 load{0};
  Vec2 centre;     // m
  Real scale = 1;  // m
  Real speed = 1;  // m/s
};

/// Finds the motion of every candidate and the region of each that the motion allows. The lamina
/// has passed check().
void prepare(const Lamina& lamina, Prepared& out);

/// A twist of the solver's frame, in SI units about the world origin.
Vec3 to_world(const Prepared& p, Vec3 twist);

/// "SSB", "RSB", ...: a letter for each contact.
std::string name_of(const Prepared& p, const Candidate& c);
std::string name_of(const Prepared& p, const Region& r);
/// "3S" or "R1S3", with the numbers of sliding contacts where there are more than three.
std::string short_name(const Prepared& p, const Region& r);

}  // namespace pantin::detail::modes

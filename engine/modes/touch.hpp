#pragma once
/// Where fingers touch a lamina that has an outline and a pose.
#include "engine/base/fields.hpp"
#include "engine/modes/outline.hpp"

namespace pantin::detail::modes {

/// A moving lamina: its outline in the initial pose, and its load.
struct Part {
  std::span<const Vec2> outline;  // corners, counter-clockwise
  Vec2 centre;                    // of mass
  Vec2 force;                     // at the mass centre, N; it keeps its direction
  Real torque = 0;                // N m
};

/// The lamina's pose: rotated about the origin from the initial pose, then shifted.
struct Placement {
  Vec2 shift;  // m
  Real angle = 0;
};

/// A finger at the start of a step, during which its velocity is constant.
struct Finger {
  Vec2 at, velocity;
  Vec2 normal;  // of a flat one, into the lamina
  bool flat = false;
  Real roll = 0.5, slide = 0.5;  // friction
};

/// A finger and the edge of the lamina that it touches; of a flat finger the corner.
struct Touch {
  std::uint8_t finger = 0;
  std::uint32_t feature = 0;

  static void fields(auto& self, auto&& field) {
    field("finger", self.finger);
    field("feature", self.feature);
  }
};

/// The lamina and its fingers at a moment of a step.
struct Moment {
  const Part& part;
  std::span<const Finger> fingers;
  Placement placed{};
  Vec2 facing{1, 0};  // cosine and sine of its angle
  Real time = 0;      // s, since the start of the step

  void place(const Placement& there) {
    placed = there;
    facing = {std::cos(there.angle), std::sin(there.angle)};
  }
  Vec2 finger_at(std::size_t i) const { return fingers[i].at + time * fingers[i].velocity; }
};

Contact contact_of(const Moment& now, Touch touch);
/// Gap of a contact, m; below 0 where the finger is in the lamina.
Real gap_of(const Moment& now, Touch touch);
/// Distance of the finger from the nearer end of its edge, m; below 0 beyond it. Infinite for a
/// flat finger.
Real left_on_edge(const Moment& now, Touch touch);
/// The load in SI units about the world's origin.
Vec3 load_of(const Moment& now);

struct Touches {
  std::array<Touch, kMostContacts> list;
  std::size_t count = 0;
  bool at_corner = false;  // a point finger is at a convex corner: it has no normal there
  bool too_many = false;

  static void fields(auto& self, auto&& field) {
    field("list", self.list);
    field("count", self.count);
    field("at_corner", self.at_corner);
    field("too_many", self.too_many);
  }

  const Touch* begin() const { return list.data(); }
  const Touch* end() const { return list.data() + count; }
};
/// All contacts with a gap of at most `tolerance` (m), finger by finger.
Touches touches_of(const Moment& now, Real tolerance);
/// The least gap of a finger, m.
Real least_gap(const Moment& now, std::size_t finger);

}  // namespace pantin::detail::modes

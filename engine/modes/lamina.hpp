#pragma once
/// A lamina in the plane, held or pushed by point contacts whose velocities are given.
///
/// SI units. Moments and twists are about the world origin; counter-clockwise is positive.
/// The tangent of a contact is its normal turned by +90 degrees. [Trinkle & Zeng 1995]
#include <array>
#include <cstdint>
#include <span>

#include "engine/base/math.hpp"
#include "engine/base/result.hpp"

namespace pantin::detail::modes {

inline constexpr std::size_t kMostContacts = 32;

struct Vec2 {
  Real x = 0, y = 0;
};
inline Real dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
inline Real cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
inline Vec2 tangent_of(Vec2 normal) { return {-normal.y, normal.x}; }

/// One point of a finger against an edge of the lamina. A finger with several contacts, or a reflex
/// vertex that a finger fills, is several of these.
struct Contact {
  Vec2 point;     // m
  Vec2 normal;    // unit, into the lamina
  Vec2 velocity;  // of the finger's point, m/s
};

struct Lamina {
  std::span<const Contact> contacts;
  Vec3 load{0};  // external force (N, N) and moment (N m)
};

/// Coefficients of friction, one for each contact: where it rolls (sticks) and where it slides.
struct Friction {
  std::span<const Real> roll, slide;

  static Friction same(std::span<const Real> mu) { return {mu, mu}; }
};

/// Rejects input that has no modes, a line for each finding: no contacts or more than
/// kMostContacts, numbers that are not finite, normals that are not unit vectors (1e-6), repeated
/// contacts, no load.
Result<Done> check(const Lamina& lamina);
/// Rejects coefficients that are negative or not finite, or another number of them than contacts.
Result<Done> check(const Friction& friction, std::size_t contacts);

}  // namespace pantin::detail::modes

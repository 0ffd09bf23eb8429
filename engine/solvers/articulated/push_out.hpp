#pragma once
/// The way out of several half-spaces at once.
#include <array>

#include "engine/base/math.hpp"

namespace pantin::articulated {

/// Up to eight places that have to be left: normal . u >= depth for the translation u, m.
struct HalfSpaces {
  std::array<Vec3, 8> normals{};
  std::array<Real, 8> depths{};
  std::size_t count = 0;
  /// Keeps the deepest where there are more.
  void add(Vec3 normal, Real depth);
};

/// The shortest translation that leaves them all, acute wedges included: the deepest one alone, or
/// the edge of two, or the corner of three, whichever is nearest and leaves the others too. Where
/// nothing does (a cleft without a way out), the way out of the deepest. [Lee 2000, sec. 4: the
/// deepest vertex along the normal; planes of a wedge solved together instead of in turn]
Vec3 push_out(const HalfSpaces& planes);

}  // namespace pantin::articulated

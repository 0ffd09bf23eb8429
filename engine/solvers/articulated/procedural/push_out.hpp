#pragma once
/// The shortest translation out of several half-spaces.
#include <array>
#include <optional>

#include "engine/base/math.hpp"

namespace pantin::detail::articulated {

/// Up to eight half-spaces: normal . u >= depth for the translation u, m.
struct HalfSpaces {
  std::array<Vec3, 8> normals{};
  std::array<Real, 8> depths{};
  std::size_t count = 0;
  /// Keeps the deepest ones if there are more.
  void add(Vec3 normal, Real depth);
};

/// The shortest translation that satisfies all of them, acute wedges included: along one normal, to
/// the edge of two planes, or to the corner of three. None if it is longer than `farthest`, m.
/// [Lee 2000, sec. 4.2: the deepest vertex along the normal; planes of a wedge solved together
/// instead of in turn]
std::optional<Vec3> way_out(const HalfSpaces& planes, Real farthest);
/// The same however far, else the translation for the deepest one.
Vec3 push_out(const HalfSpaces& planes);

}  // namespace pantin::detail::articulated

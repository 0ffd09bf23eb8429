#pragma once
/// Where two skins face one another: pairs of points on one line that is normal to both.
///
/// All in the frame of b. Unknown are the four parameters s; with n the outward normal of b and
/// d = A - B, the pair fulfils A_u.n = A_v.n = 0 and d.B_u = d.B_v = 0. The gap n.d is smooth
/// through zero, below which the bodies overlap. [Nelson & Cohen]
///
/// Internal (pantin::detail); installed because a World holds surfaces.
#include <span>

#include "engine/nurbs/skin.hpp"

namespace pantin::detail::nurbs {

struct PlacePair {
  Place a, b;

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
  }
};

enum class ContactStatus {
  found,
  left_patch,  // the pair crossed a trim, or the rim of a face that has no neighbour there
  singular,    // a face has no normal where the pair is
  degenerate,  // the surfaces fit one another: the pair is not isolated (ball in its own socket)
  lost,        // no pair was found from this start
};
const char* word_of(ContactStatus status);

struct CommonNormal {
  ContactStatus status = ContactStatus::lost;
  PlacePair at;
  Vec3 on_a{0}, on_b{0};  // the two points, m
  Vec3 normal{0};         // of b, outwards, unit
  Real gap = 0;           // m
  // The smaller curvature of the gap where both points slide, 1/m: above 0 at a minimum, near 0
  // where the surfaces fit one another.
  Real least_curvature = 0;
  int iterations = 0;
};

/// Two skins; a has the pose `a_in_b` in the frame of b.
struct Meeting {
  const Skin& a;
  const Skin& b;
  Pose a_in_b;
};

/// The pair near `from`, by Newton's method; if that fails, by damped descent of the distance
/// first. No heap.
CommonNormal track(const Meeting& of, const PlacePair& from);

/// The same by Newton's method alone.
CommonNormal track_newton(const Meeting& of, const PlacePair& from);

/// Motion of a as seen from b: velocity of a's frame, m/s, and angular velocity, rad/s.
struct Twist {
  Vec3 linear{0}, angular{0};
};

/// Rates of the four parameters (a.u, a.v, b.u, b.v) of a pair while a moves; 0 where degenerate.
std::array<Real, 4> rates(const Meeting& of, const PlacePair& at, const Twist& twist);

/// Motion of a pair: rates of the four parameters, of its points along their surfaces (m/s, in the
/// frame of b) and of the normal (1/s) as seen from b. 0 where degenerate.
struct Moving {
  std::array<Real, 4> rates{};
  Vec3 on_a{0}, on_b{0}, normal{0};
};
Moving moving(const Meeting& of, const PlacePair& at, const Twist& twist);

/// The parameters of a pair after `time`, as a start.
PlacePair predicted(const Meeting& of, const PlacePair& at, std::array<Real, 4> rates, Real time);

/// Cost of a search: pairs of cells and branches visited, and descents or Newton iterations
/// started.
struct SearchCost {
  int pairs = 0, starts = 0;
};

/// The pair of least distance, edges and corners included. `is_on_edge`: its line need not be
/// normal to both. Cells are discarded by guaranteed bounds; in the remaining ones, descents start
/// from the middle.
struct ClosestPair {
  PlacePair at;
  Vec3 on_a{0}, on_b{0};
  Real distance = 0;
  bool is_on_edge = false;
  SearchCost cost;
};
ClosestPair closest_pair(const Meeting& of);

/// All pairs whose gap is a local minimum and from -reach to `reach` (m), the least first; as many
/// as `out` holds. Returns how many there are. A reach below the thickness of the bodies excludes
/// pairs of far sides.
std::size_t find_contacts(const Meeting& of, Real reach, std::span<CommonNormal> out,
                          SearchCost* cost = nullptr);

}  // namespace pantin::detail::nurbs

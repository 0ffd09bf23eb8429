#pragma once
/// The set of coefficients of friction for which a contact mode has forces: closed forms.
///
/// Every mode with a unique motion and unique forces has forces f_i(mu) / X(mu), where all f_i and
/// X are multi-affine in the mode's coefficients: of degree one in each. The mode is feasible where
/// X is not 0 and no f_i has the other sign. On a line parallel to an axis a sign of X therefore
/// holds in one interval, and a box lies in one branch (sign of X) if its corners do. [Trinkle &
/// Zeng 1995, Eqs. 28-33]
#include "engine/modes/lamina.hpp"

namespace pantin::detail::modes {

enum class Kind : std::uint8_t {
  three_slide,  // three contacts slide, all others separate
  roll_slide    // one contact rolls (sticks), one slides, all others separate
};

/// A mode's own coefficients: of its sliding contacts, or of the rolling and then the sliding one.
using OwnFriction = std::array<Real, 3>;

struct Region {
  Kind kind = Kind::three_slide;
  std::array<std::uint8_t, 3> contacts{};  // in order; roll_slide: the rolling one, the sliding one
  std::array<std::int8_t, 3> slip_sign{};  // of each; 0 where it rolls
  bool break_tie = false;                  // another contact neither separates nor penetrates
  Vec3 twist{0};                           // velocity (m/s) at the world origin, rad/s
  std::array<Real, 3> slip{};              // m/s, of each
  Real determinant = 0;                    // of the kinematics: D or B

  /// X: the coefficient of a product of own frictions is at the index that is the sum of their bits
  /// 1, 2, 4.
  std::array<Real, 8> divisor{};
  /// Each of two own frictions (form_variables), bits 1, 2. three_slide: Y1, Y2, Y3. roll_slide:
  /// D3, mu_r C + T, mu_r C - T, C, where C is the normal force of the rolling contact times X and
  /// T its tangential one.
  std::array<std::array<Real, 4>, 4> forms{};

  int variables() const { return kind == Kind::three_slide ? 3 : 2; }
  int form_count() const { return kind == Kind::three_slide ? 3 : 4; }
};

/// Which own frictions the form reads.
constexpr std::array<std::uint8_t, 2> form_variables(Kind kind, int form) {
  if (kind == Kind::roll_slide || form == 2) return {0, 1};
  return form == 0 ? std::array<std::uint8_t, 2>{1, 2} : std::array<std::uint8_t, 2>{0, 2};
}

/// The region's own coefficients out of all.
inline OwnFriction own(const Region& r, const Friction& mu) {
  if (r.kind == Kind::three_slide)
    return {mu.slide[r.contacts[0]], mu.slide[r.contacts[1]], mu.slide[r.contacts[2]]};
  return {mu.roll[r.contacts[0]], mu.slide[r.contacts[1]], 0};
}

struct Values {
  Real divisor = 0;
  std::array<Real, 4> forms{};
};
Values values(const Region& r, const OwnFriction& mu);
/// Sums of absolute terms: what values() rounds relative to.
Values magnitudes(const Region& r, const OwnFriction& mu);

/// The sign of X if the mode has forces at these coefficients, else 0.
int branch_of(const Region& r, const OwnFriction& mu);
inline bool contains(const Region& r, const OwnFriction& mu) { return branch_of(r, mu) != 0; }

/// three_slide: the normal forces of the three. roll_slide: normal and tangential force of the
/// rolling contact, normal force of the sliding one. Newtons; not finite where X is 0.
std::array<Real, 3> forces(const Region& r, const OwnFriction& mu);

/// The sign of det W det K: +1 is the branch that is connected to mu = 0; -1 is unstable when the
/// contacts yield a little (viscous or compliant).
int index_of(const Region& r, int branch);

/// Own frictions base + t along, t >= 0.
struct Line {
  OwnFriction base{}, along{};
};
/// Coefficients of a cubic in t, constant first.
using Cubic = std::array<Real, 4>;
Cubic divisor_along(const Region& r, const Line& line);
Cubic form_along(const Region& r, int form, const Line& line);

struct Interval {
  Real low = 0, high = 0;  // high may be infinite
  int branch = 0;
  bool low_closed = true, high_closed = true;  // closed where a force is 0, open where X is
};
/// No more can be: X and the forms have at most 15 roots.
struct Intervals {
  std::array<Interval, 16> list;
  int count = 0;

  const Interval* begin() const { return list.data(); }
  const Interval* end() const { return list.data() + count; }
};
/// All t >= 0 for which the mode has forces, in order; each lies in one branch.
Intervals intervals_along(const Region& r, const Line& line);
/// The same for one coefficient common to all contacts.
Intervals equal_friction(const Region& r);

/// The largest m such that the mode has forces whenever each of its coefficients is within [0, m];
/// 0 if it has none without friction; may be infinite.
Real cube_bound(const Region& r);

enum class BoxVerdict : std::uint8_t { inside, outside, undecided };
/// inside and outside are exact statements about every point of the box. A small box that is
/// neither meets the boundary, or nearly does.
BoxVerdict box(const Region& r, const OwnFriction& low, const OwnFriction& high);

}  // namespace pantin::detail::modes

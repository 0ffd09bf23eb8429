#pragma once
/// Contact modes when coefficients of friction are uncertain.
///
/// Each contact has one coefficient, the same where it rolls and where it slides, independent of
/// the others'.
#include <span>
#include <vector>

#include "engine/modes/prepare.hpp"

namespace pantin::detail::modes {

/// Distribution of a coefficient of friction.
struct Spread {
  enum class Kind : std::uint8_t { exact, uniform, normal };
  Kind kind = Kind::exact;
  Real low = 0, high = 0;        // exact: both the value. normal: where it is truncated
  Real mean = 0, deviation = 0;  // of the normal distribution before truncation

  static Spread at(Real mu) { return {Kind::exact, mu, mu}; }
  static Spread between(Real low, Real high) { return {Kind::uniform, low, high}; }
  static Spread around(Real mean, Real deviation, Real low, Real high) {
    return {Kind::normal, low, high, mean, deviation};
  }
};
/// Rejects bounds that are negative, not finite or the wrong way round, deviations that are not
/// positive, normal distributions with almost no probability between their bounds, and another
/// number of spreads than contacts.
Result<Done> check(std::span<const Spread> spreads, std::size_t contacts);
/// The probability that the coefficient is at most mu.
Real cumulative(const Spread& spread, Real mu);
/// The mu below which it lies with probability `part`, 0 to 1.
Real quantile(const Spread& spread, Real part);

struct Sampling {
  int count = 20000;  // at least 2
  std::uint64_t seed = 1;
};

struct Probability {
  Real value = 0;
  Real error = 0;   // half the width of the 95 % interval; 0 for closed forms
  int samples = 0;  // 0 for closed forms
};

/// Probability that the mode is feasible. Closed form if at most one of its coefficients is
/// uncertain, or for a rolling and a sliding contact that are uniform. Otherwise one coefficient is
/// integrated in closed form and the others are sampled. The same seed gives the same numbers.
Probability probability(const Region& r, std::span<const Spread> spreads, const Sampling& sampling);

/// Probabilities that no mode is feasible, exactly one, or several; sampled together.
struct Outlook {
  std::vector<Probability> modes;  // for each of Prepared::regions
  Probability none, unique, ambiguous;
};
Outlook outlook(const Prepared& p, std::span<const Spread> spreads, const Sampling& sampling);

/// A mode over all coefficients between two bounds.
enum class Occurrence : std::uint8_t { always, sometimes, never, unknown };
const char* word_for(Occurrence occurrence);

struct WorstCase {
  Occurrence occurrence = Occurrence::unknown;
  // Own coefficients at which the mode is feasible, and at which it is not or its forces are
  // without bound.
  OwnFriction with{}, without{};
  Real largest_force = 0;  // N, of all its normal forces, if it is always feasible
  int boxes = 0;           // evaluated
};
/// Exact statements, by corners of boxes that are halved at most `most_boxes` times; unknown if
/// that is not conclusive. `low` and `high` are own coefficients of the region.
WorstCase worst_case(const Region& r, const OwnFriction& low, const OwnFriction& high,
                     int most_boxes = 4096);

}  // namespace pantin::detail::modes

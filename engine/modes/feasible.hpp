#pragma once
/// Which contact modes hold at given coefficients of friction.
#include "engine/modes/signed_modes.hpp"

namespace pantin::detail::modes {

struct FeasibleMode {
  std::int32_t region = 0;      // in Prepared::regions
  int index = 0;                // +1 or -1, see index_of
  std::array<Real, 3> force{};  // N, see forces()
  Real margin = 0;              // least of X and the forms, each relative to its terms
  Real amplification = 0;       // largest normal force over the load's size
  bool boundary = false;        // the margin is below kBoundary: the neighbour is listed too
  bool break_tie = false;
};
inline constexpr Real kBoundary = 1e-9;

/// The same mode by contact: the status and force of each.
SignedMode signed_mode_of(const Prepared& p, const FeasibleMode& mode, const Friction& mu);

enum class Verdict : std::uint8_t {
  unique,
  ambiguous,   // several modes
  squeezed,    // none: no motion keeps the lamina out of the fingers
  no_balance,  // none: no forces within the cones of friction balance the load
  conflict,    // none: a jam or an escape; motions exist and forces exist, but no mode has both
  unresolved   // too many linear programmes
};
const char* word_for(Verdict verdict);

struct ModeSet {
  std::vector<FeasibleMode> modes;
  /// Modes whose motion or forces are not unique, and others with more or fewer contacts than those
  /// above. Searched only if `degenerate`.
  std::vector<SignedMode> indeterminate;
  Verdict verdict = Verdict::unique;
  bool degenerate = false;     // a candidate is singular, does not slip, ties or is on its boundary
  bool near_singular = false;  // X of a candidate is a rounding error: forces without bound
  int programs = 0;            // linear programmes solved
  SignedModes search;          // scratch memory
};

/// All modes at these coefficients; if there is none, the verdict says why.
void find_modes(const Prepared& p, const Friction& mu, ModeSet& out);

/// The number of regions that contain these coefficients, without linear programmes: for maps and
/// samples.
int count_modes(const Prepared& p, const Friction& mu);

}  // namespace pantin::detail::modes

#include "engine/modes/feasible.hpp"

#include <algorithm>
#include <limits>

namespace pantin::detail::modes {
namespace {

constexpr Real kNearSingular = 1e-14;

Real ratio(Real value, Real magnitude) { return magnitude > 0 ? value / magnitude : 0; }

/// The least form relative to its terms. A rolling contact's normal force is implied by its cone.
Real margin_of(const Region& r, int branch, const Values& v, const Values& size) {
  const int forms = r.kind == Kind::roll_slide ? 3 : r.form_count();
  Real least = std::abs(ratio(v.divisor, size.divisor));
  for (int i = 0; i < forms; ++i) {
    const auto k = static_cast<std::size_t>(i);
    least = std::min(least, branch * ratio(v.forms[k], size.forms[k]));
  }
  return least;
}

Real largest_normal(const Region& r, const std::array<Real, 3>& f) {
  if (r.kind == Kind::roll_slide) return std::max(std::abs(f[0]), std::abs(f[2]));
  return std::max({std::abs(f[0]), std::abs(f[1]), std::abs(f[2])});
}

void consider(const Prepared& p, const Friction& mu, std::size_t at, ModeSet& out) {
  const Region& r = p.regions[at];
  const OwnFriction m = own(r, mu);
  const Values v = values(r, m), size = magnitudes(r, m);
  if (std::abs(v.divisor) <= kNearSingular * size.divisor) {
    out.near_singular = out.degenerate = true;
    return;
  }
  const int branch = v.divisor > 0 ? 1 : -1;
  const Real margin = margin_of(r, branch, v, size);
  if (margin < -kBoundary) return;
  FeasibleMode mode;
  mode.region = static_cast<std::int32_t>(at);
  mode.index = index_of(r, branch);
  mode.force = forces(r, m);
  mode.margin = margin;
  const Real load = std::hypot(p.load.x, p.load.y, p.load.z);
  mode.amplification = load > 0 ? largest_normal(r, mode.force) / load : 0;
  mode.boundary = margin < kBoundary;
  mode.break_tie = r.break_tie;
  out.degenerate |= mode.boundary || mode.break_tie;
  out.modes.push_back(mode);
}

int found(const Prepared& p, Kinematics status) {
  return p.found[static_cast<std::size_t>(status)];
}

void add_indeterminate(const Prepared& p, const Friction& mu, ModeSet& out) {
  find_signed_modes(p, mu, out.search);
  out.programs += out.search.programs;
  for (const SignedMode& mode : out.search.list) {
    const auto same = [&](const FeasibleMode& m) {
      return signs_of(p.regions[static_cast<std::size_t>(m.region)]) == mode.signs;
    };
    if (std::none_of(out.modes.begin(), out.modes.end(), same)) out.indeterminate.push_back(mode);
  }
}

Verdict verdict_of(const Prepared& p, const Friction& mu, ModeSet& out) {
  if (out.degenerate && !out.search.complete) return Verdict::unresolved;
  // A tied mode is the limit of one with another contact, if that one is there.
  const auto tied = [](const FeasibleMode& m) { return m.break_tie; };
  const auto ties =
      static_cast<std::size_t>(std::count_if(out.modes.begin(), out.modes.end(), tied));
  const std::size_t firm = out.modes.size() - ties + out.indeterminate.size();
  const std::size_t count = firm > 0 ? firm : ties;
  if (count > 0) return count == 1 ? Verdict::unique : Verdict::ambiguous;
  out.programs += 2;
  if (!motion_exists(p)) return Verdict::squeezed;
  return balance_exists(p, mu) ? Verdict::conflict : Verdict::no_balance;
}

}  // namespace

const char* word_for(Verdict verdict) {
  constexpr const char* kWords[] = {"unique",          "ambiguous",
                                    "none (squeezed)", "none (no equilibrium)",
                                    "none (conflict)", "unresolved"};
  return kWords[static_cast<std::size_t>(verdict)];
}

void find_modes(const Prepared& p, const Friction& mu, ModeSet& out) {
  out.modes.clear(), out.indeterminate.clear();
  out.programs = 0, out.near_singular = false;
  out.degenerate =
      p.count < 2 || found(p, Kinematics::singular) > 0 || found(p, Kinematics::zero_slip) > 0;
  for (std::size_t i = 0; i < p.regions.size(); ++i) consider(p, mu, i, out);
  if (out.degenerate) add_indeterminate(p, mu, out);
  out.verdict = verdict_of(p, mu, out);
}

int count_modes(const Prepared& p, const Friction& mu) {
  int count = 0;
  for (const Region& r : p.regions) count += contains(r, own(r, mu));
  return count;
}

SignedMode signed_mode_of(const Prepared& p, const FeasibleMode& mode, const Friction& mu) {
  const Region& r = p.regions[static_cast<std::size_t>(mode.region)];
  SignedMode told;
  told.signs = signs_of(r), told.twist = r.twist;
  const OwnFriction m = own(r, mu);
  if (r.kind == Kind::roll_slide) {
    const std::size_t a = r.contacts[0], b = r.contacts[1];
    told.normal_force[a] = mode.force[0], told.tangent_force[a] = mode.force[1];
    told.normal_force[b] = mode.force[2];
    told.tangent_force[b] = -r.slip_sign[1] * m[1] * mode.force[2];
    return told;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    told.normal_force[r.contacts[k]] = mode.force[k];
    told.tangent_force[r.contacts[k]] = -r.slip_sign[k] * m[k] * mode.force[k];
  }
  return told;
}

}  // namespace pantin::detail::modes

#include "engine/modes/signed_modes.hpp"

#include <algorithm>

#include "engine/modes/linear_program.hpp"

namespace pantin::detail::modes {
namespace {

constexpr Real kStrict = 1e-9;  // least excess of strict inequalities, velocities in `speed`

/// Motions that meet equations, weak and strict inequalities: the dual of
///   maximise s <= 1,  k q = d,  a q >= e,  a q - s >= e.
/// Its multipliers are the motion q and s.
class Motion {
 public:
  Motion() { lp_.rows = 4, lp_.columns = 0, lp_.right = {0, 0, 0, 1}, lp_.add({0, 0, 0, 1}, 1); }

  void equal(Vec3 k, Real d) {
    lp_.add({k.x, k.y, k.z, 0}, d);
    lp_.add({-k.x, -k.y, -k.z, 0}, -d);
  }
  void at_least(Vec3 a, Real e) { lp_.add({-a.x, -a.y, -a.z, 0}, -e); }
  void above(Vec3 a, Real e) { lp_.add({-a.x, -a.y, -a.z, 1}, -e); }

  /// The motion with the largest margin in the strict inequalities.
  bool find(Vec3& twist, Outcome& outcome) const {
    const Optimum best = solve(lp_);
    outcome = best.outcome;
    if (best.outcome != Outcome::optimal || best.cost <= kStrict) return false;
    twist = {best.multipliers[0], best.multipliers[1], best.multipliers[2]};
    return true;
  }

 private:
  LinearProgram lp_;
};

/// Forces along given wrenches that balance the load.
class Balance {
 public:
  explicit Balance(const Prepared& p) {
    const Real size = std::sqrt(glm::dot(p.load, p.load));
    size_ = size > 0 ? size : 1;
    lp_.rows = 3, lp_.columns = 0;
    lp_.right = {-p.load.x / size_, -p.load.y / size_, -p.load.z / size_, 0};
  }
  void add(Vec3 w, std::uint8_t contact, Real tangent) {
    const Real size = std::sqrt(glm::dot(w, w));
    along_[lp_.columns] = {contact, size_ / size, tangent * size_ / size};
    lp_.add({w.x / size, w.y / size, w.z / size, 0}, 0);
  }
  bool find(SignedMode* mode, Outcome& outcome) const {
    const Optimum best = solve(lp_);
    outcome = best.outcome;
    if (best.outcome != Outcome::optimal) return false;
    for (std::size_t i = 0; mode && i < lp_.rows; ++i) {
      if (best.basis[i] < 0) continue;
      const Along& a = along_[static_cast<std::size_t>(best.basis[i])];
      mode->normal_force[a.contact] += best.x[i] * a.normal;
      mode->tangent_force[a.contact] += best.x[i] * a.tangent;
    }
    return true;
  }

 private:
  struct Along {
    std::uint8_t contact;
    Real normal, tangent;  // force for each unit of the variable
  };
  LinearProgram lp_;
  std::array<Along, kMostColumns> along_;
  Real size_;
};

/// Orthonormal basis of the space of rows, and its rank.
struct RowSpace {
  int rank = 0;
  std::array<Vec3, 3> basis;  // orthonormal

  void add(Vec3 row) {
    const Real size = std::sqrt(glm::dot(row, row));
    for (int k = 0; k < rank; ++k) row -= glm::dot(row, basis[k]) * basis[k];
    const Real left = std::sqrt(glm::dot(row, row));
    if (rank < 3 && left > 1e-9 * size) basis[static_cast<std::size_t>(rank++)] = row / left;
  }
};

class Search {
 public:
  Search(const Prepared& p, const Friction& mu, SignedModes& out) : p_(p), mu_(mu), out_(out) {}

  void run(std::size_t depth, const Signs& signs) {
    if (!out_.complete) return;
    SignedMode mode;
    mode.signs = signs;
    if (!moves(depth, signs, mode.twist) || !balances(depth, signs, mode)) return;
    if (depth == p_.count) return finish(mode);
    const std::uint32_t bit = 1u << depth;
    for (std::uint32_t Signs::*set : {&Signs::roll, &Signs::plus, &Signs::minus}) {
      Signs next = signs;
      next.*set |= bit;
      run(depth + 1, next);
    }
    run(depth + 1, signs);
  }

 private:
  /// Counts solved programmes; the search ends where one stalls or they become too many.
  bool may_go_on(Outcome outcome) {
    if (outcome == Outcome::stalled || ++out_.programs >= kMostPrograms) out_.complete = false;
    return out_.complete;
  }

  /// Contacts from `depth` on are undecided: none may penetrate.
  bool moves(std::size_t depth, const Signs& s, Vec3& twist) {
    Motion motion;
    for (std::size_t i = 0; i < p_.count; ++i) {
      const std::uint32_t bit = 1u << i;
      const Vec3 n = p_.normal[i], t = p_.tangent[i];
      const Real dn = p_.normal_velocity[i], dt = p_.tangent_velocity[i];
      if (i >= depth) {
        motion.at_least(n, dn);
      } else if ((s.roll | s.plus | s.minus) & bit) {
        motion.equal(n, dn);
        if (s.roll & bit) motion.equal(t, dt);
        if (s.plus & bit) motion.above(t, dt);
        if (s.minus & bit) motion.above(-t, -dt);
      } else {
        motion.above(n, dn);
      }
    }
    Outcome outcome = Outcome::infeasible;
    const bool found = motion.find(twist, outcome);
    return may_go_on(outcome) && found;
  }

  bool balances(std::size_t depth, const Signs& s, SignedMode& mode) {
    Balance balance(p_);
    for (std::size_t i = 0; i < p_.count; ++i) {
      const std::uint32_t bit = 1u << i;
      if (i >= depth) {
        const Real most = std::max(mu_.roll[i], mu_.slide[i]);
        add(balance, i, most), add(balance, i, -most);
      } else if (s.roll & bit) {
        add(balance, i, mu_.roll[i]);
        if (mu_.roll[i] > 0) add(balance, i, -mu_.roll[i]);
      } else if (s.plus & bit) {
        add(balance, i, -mu_.slide[i]);
      } else if (s.minus & bit) {
        add(balance, i, mu_.slide[i]);
      }
    }
    Outcome outcome = Outcome::infeasible;
    const bool found = balance.find(depth == p_.count ? &mode : nullptr, outcome);
    return may_go_on(outcome) && found;
  }
  void add(Balance& balance, std::size_t i, Real mu) {
    balance.add(p_.normal[i] + mu * p_.tangent[i], static_cast<std::uint8_t>(i), mu);
  }

  void finish(SignedMode& mode) {
    RowSpace motion, wrenches;
    int unknowns = 0;
    for (std::size_t i = 0; i < p_.count; ++i) {
      const std::uint32_t bit = 1u << i;
      if (!((mode.signs.roll | mode.signs.plus | mode.signs.minus) & bit)) continue;
      motion.add(p_.normal[i]);
      const bool rolls = mode.signs.roll & bit;
      if (rolls) motion.add(p_.tangent[i]);
      const Real mu = mode.signs.plus & bit ? -mu_.slide[i] : mu_.slide[i];
      wrenches.add(rolls ? p_.normal[i] : p_.normal[i] + mu * p_.tangent[i]), ++unknowns;
      if (rolls && mu_.roll[i] > 0) wrenches.add(p_.tangent[i]), ++unknowns;
    }
    mode.motion_unique = motion.rank == 3;
    mode.forces_unique = unknowns <= wrenches.rank;
    if (motion.rank == 2)
      mode.free_direction = to_world(p_, glm::cross(motion.basis[0], motion.basis[1]));
    mode.twist = to_world(p_, mode.twist);
    out_.list.push_back(mode);
  }

  const Prepared& p_;
  const Friction& mu_;
  SignedModes& out_;
};

}  // namespace

Signs signs_of(const Region& r) {
  Signs s;
  for (std::size_t k = 0; k < static_cast<std::size_t>(r.variables()); ++k) {
    const std::uint32_t bit = 1u << r.contacts[k];
    (r.slip_sign[k] == 0 ? s.roll : r.slip_sign[k] > 0 ? s.plus : s.minus) |= bit;
  }
  return s;
}

std::string name_of(const Signs& s, std::size_t count) {
  std::string name(count, 'B');
  for (std::size_t i = 0; i < count; ++i)
    name[i] = s.roll >> i & 1 ? 'R' : s.plus >> i & 1 ? '+' : s.minus >> i & 1 ? '-' : 'B';
  return name;
}

void find_signed_modes(const Prepared& p, const Friction& mu, SignedModes& out) {
  out.list.clear();
  out.programs = 0, out.complete = true;
  Search(p, mu, out).run(0, {});
}

bool motion_exists(const Prepared& p) {
  Motion motion;
  for (std::size_t i = 0; i < p.count; ++i) motion.at_least(p.normal[i], p.normal_velocity[i]);
  Outcome outcome = Outcome::infeasible;
  Vec3 twist;
  return motion.find(twist, outcome);
}

bool balance_exists(const Prepared& p, const Friction& mu) {
  Balance balance(p);
  for (std::size_t i = 0; i < p.count; ++i)
    for (const Real side : {-1.0, 1.0}) {
      const Real along = side * std::max(mu.roll[i], mu.slide[i]);
      balance.add(p.normal[i] + along * p.tangent[i], static_cast<std::uint8_t>(i), along);
    }
  Outcome outcome = Outcome::infeasible;
  return balance.find(nullptr, outcome);
}

}  // namespace pantin::detail::modes

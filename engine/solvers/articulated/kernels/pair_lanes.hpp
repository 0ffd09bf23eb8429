#pragma once
/// Contact points of pairs of bodies without joints, four pairs side by side
/// (impulses/group_lanes.cpp). A lane depends on its own pair only.
#include "engine/solvers/articulated/kernels.hpp"
#include "engine/solvers/articulated/kernels/table.hpp"

namespace pantin::detail::articulated {
namespace {

/// The bodies on one side of the pairs.
struct LaneSide {
  Four per_mass;
  Sym<Four> response;                 // inverse inertia, world axes
  Vec<Four> velocity, spin, twist{};  // twist: sum of the moments of the impulses, N m s

  LaneSide(const PairLanes& pairs, std::size_t row, double* const (&bodies)[kPairLanes])
      : per_mass(num<Four>(pairs.table, row)), response(sym<Four>(pairs.table, row + 1)) {
    const auto state = [&](std::size_t at) {
      return Four{bodies[0][at], bodies[1][at], bodies[2][at], bodies[3][at]};
    };
    velocity = {state(0), state(1), state(2)}, spin = {state(3), state(4), state(5)};
  }
  INLINE Vec<Four> speed_at(Vec<Four> arm) const { return velocity + cross(spin, arm); }
  INLINE void push(Vec<Four> impulse, Vec<Four> arm) {
    const Vec<Four> moment = cross(arm, impulse);
    velocity = velocity + per_mass * impulse, spin = spin + mul(response, moment);
    twist = twist + moment;
  }
  void write(double* const (&bodies)[kPairLanes], std::size_t pairs) const {
    for (std::size_t l = 0; l < pairs; ++l) {
      if (!(per_mass[l] > 0)) continue;
      double* const b = bodies[l];
      b[0] = velocity.x[l], b[1] = velocity.y[l], b[2] = velocity.z[l];
      b[3] = spin.x[l], b[4] = spin.y[l], b[5] = spin.z[l];
      b[6] += twist.x[l], b[7] += twist.y[l], b[8] += twist.z[l];
    }
  }
};

INLINE double* point_of(const PairLanes& p, std::size_t i) {
  return p.table + kPairLanes * (kPairRows + kPointRows * i);
}
INLINE Vec<Four> axis_of(const double* k, std::size_t n) {
  return vec<Four>(k, kPointAxes + 3 * n);
}
INLINE Vec<Four> in_world(const double* k, Vec<Four> v) {
  return v.x * axis_of(k, 0) + v.y * axis_of(k, 1) + v.z * axis_of(k, 2);
}
INLINE Four inverse_or_none(Four x) {
  return choose(x > all(0), 1.0 / choose(x > all(0), x, all(1)), all(0));
}

/// Responses of each point to impulses there.
void prepare_pairs(const PairLanes& p) {
  const Four per_mass = num<Four>(p.table, kPairOfA) + num<Four>(p.table, kPairOfB);
  const Sym<Four> a = sym<Four>(p.table, kPairOfA + 1), b = sym<Four>(p.table, kPairOfB + 1);
  for (std::size_t i = 0; i < p.points; ++i) {
    double* const k = point_of(p, i);
    const Vec<Four> arm_a = vec<Four>(k, kPointArmA), arm_b = vec<Four>(k, kPointArmB);
    Vec<Four> of_a[3], of_b[3], turned_a[3], turned_b[3];
    for (std::size_t n = 0; n < 3; ++n) {
      of_a[n] = cross(arm_a, axis_of(k, n)), of_b[n] = cross(arm_b, axis_of(k, n));
      turned_a[n] = mul(a, of_a[n]), turned_b[n] = mul(b, of_b[n]);
    }
    const auto response = [&](std::size_t n, std::size_t m) {
      const Four turned = dot(of_a[n], turned_a[m]) + dot(of_b[n], turned_b[m]);
      return n == m ? dot(axis_of(k, n), axis_of(k, n)) * per_mass + turned : turned;
    };
    const Four along = response(0, 0), first = response(1, 1), second = response(2, 2);
    const Four mixed = response(1, 2), apart = 0.5 * (first - second);
    const Four aside = 0.5 * (first + second) + root(apart * apart + mixed * mixed);
    write(k + kPointAlong * kPairLanes, along);
    write(k + kPointPerAlong * kPairLanes, inverse_or_none(along));
    write(k + kPointPerAside * kPairLanes, inverse_or_none(aside));
    write(k + kPointCross * kPairLanes, response(1, 0));
    write(k + (kPointCross + 1) * kPairLanes, response(2, 0));
  }
}

/// Applies the impulses of all points.
void push_pairs(const PairLanes& p) {
  LaneSide a(p, kPairOfA, p.a), b(p, kPairOfB, p.b);
  for (std::size_t i = 0; i < p.points; ++i) {
    const double* const k = point_of(p, i);
    const Vec<Four> impulse = in_world(k, vec<Four>(k, kPointImpulse));
    a.push(impulse, vec<Four>(k, kPointArmA)), b.push(-1.0 * impulse, vec<Four>(k, kPointArmB));
  }
  a.write(p.a, p.pairs), b.write(p.b, p.pairs);
}

/// Solves one point of each pair: the normal impulse, then friction within Coulomb's cone; not in
/// lanes that are done. Returns the squares of the changes of speed.
INLINE Four solve_points(double* k, LaneSide& a, LaneSide& b, Four runs) {
  const Vec<Four> arm_a = vec<Four>(k, kPointArmA), arm_b = vec<Four>(k, kPointArmB);
  const Vec<Four> before = vec<Four>(k, kPointImpulse);
  const Vec<Four> speed = a.speed_at(arm_a) - b.speed_at(arm_b);
  const Four along = num<Four>(k, kPointAlong), per_aside = num<Four>(k, kPointPerAside);
  const Four least =
      choose(before.x > all(0), num<Four>(k, kPointSpeed), num<Four>(k, kPointParted));
  const Four gain = num<Four>(k, kPointByMass) * num<Four>(k, kPointPerAlong);
  const Four wanted =
      num<Four>(k, kPointKept) * before.x + gain * (least - dot(axis_of(k, 0), speed));
  const Four normal = choose(wanted > all(0), wanted, all(0)), more = normal - before.x;
  const auto aside = [&](std::size_t n, Four impulse) {
    const Four now = dot(axis_of(k, n), speed) + num<Four>(k, kPointSurface + n - 1);
    return impulse - (now + num<Four>(k, kPointCross + n - 1) * more) * per_aside;
  };
  const Four first = aside(1, before.y), second = aside(2, before.z);
  const Four held = first * first + second * second, most = num<Four>(k, kPointFriction) * normal;
  const auto slides = held > most * most;
  // Without a normal impulse squares of tiny values may underflow to zero.
  const Four part = choose(
      normal > all(0), choose(slides, most / root(choose(slides, held, all(1))), all(1)), all(0));
  const Vec<Four> after =
      chosen(runs > 0.5, Vec<Four>{normal, part * first, part * second}, before);
  const Vec<Four> change = after - before, impulse = in_world(k, change);
  put(k, kPointImpulse, after);
  a.push(impulse, arm_a), b.push(-1.0 * impulse, arm_b);
  return along * along * dot(change, change);
}

double solve_pairs(const PairLanes& p) {
  LaneSide a(p, kPairOfA, p.a), b(p, kPairOfB, p.b);
  const Four iterations = num<Four>(p.table, kPairIterations);
  Four runs = all(1), most = all(0), enough = all(0);
  for (int n = 1;; ++n) {
    Four now = all(0);
    for (std::size_t i = 0; i < p.points; ++i) {
      const Four changed = solve_points(point_of(p, n % 2 ? i : p.points - 1 - i), a, b, runs);
      now = choose(changed > now, changed, now);
    }
    most = choose(now > most, now, most);
    if (n == 1) enough = (p.tolerance * p.tolerance) * now;
    runs = choose((now > enough) & (iterations > all(n)), runs, all(0));
    if (largest(runs) == 0) break;
  }
  a.write(p.a, p.pairs), b.write(p.b, p.pairs);
  return ::sqrt(largest(most));
}

}  // namespace
}  // namespace pantin::detail::articulated

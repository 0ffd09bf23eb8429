#pragma once
/// An iterate of a step by the energy-momentum method: the bodies' equations at the iterate, and
/// their elimination along the joints; see conserving.hpp.
#include "engine/solvers/articulated/kernels/body_lanes.hpp"
#include "engine/solvers/articulated/kernels/conserving_block.hpp"

namespace pantin::detail::articulated {
namespace {

template <class Lanes>
struct ConservingIterate {
  ConservingIterate(Lanes& islands, const ConservingInput& common) : lanes(islands), in(common) {}

  using N = typename Lanes::Number;
  using P = typename Lanes::Wide;
  static constexpr std::size_t kNumber = kNumbersIn<N>;

  Lanes& lanes;
  const ConservingInput& in;  // of one of the islands: the common values
  const N h = lanes.step_length(), per = 1.0 / h;
  const P h4 = Lanes::spread(h), per4 = Lanes::spread(per);

  const double* constants(std::size_t i) const { return lanes.constants(i); }
  double* work(std::size_t i) const { return lanes.work(i); }
  double* memory(std::size_t i) const { return lanes.memory(i); }
  std::int32_t parent(std::size_t i) const { return lanes.parents()[i]; }
  std::size_t count() const { return lanes.count(); }

  /// The first iterate of a block: rotation at constant velocity, or at constant acceleration if
  /// the last step had the same length.
  INLINE void guess(std::size_t i) {
    const StartState<P> s = lanes.start(i);
    probe_.add(i, dot(s.x, s.x));
    Vec<P> r = lanes.following(in, h4 * s.w, vec<P>(memory(i), kLastRotation));
    const P r2 = dot(r, r), most = all<P>(1.5);
    r = choose(r2 > most * most, most / root(r2), all<P>(1.0)) * r;
    double* k = work(i);
    put(k, kEndRotation, unit_again(mul(exponential(r), s.q)));
    put(k, kJointWay, h4 * s.v);  // of a free root
  }

  /// Arms, reaches and positions of a block whose rotations are known; parents come before.
  INLINE void place(std::size_t i, const StartState<P>& s, const Axes<P>& d0, const Axes<P>& d1) {
    const double* c = constants(i);
    double* k = work(i);
    const Vec<P> anchor = vec<P>(c, kOwnAnchor);
    put(k, kEndArm, all<P>(-1) * along(d1, anchor));
    put(k, kMeanArm, all<P>(-0.5) * (along(d0, anchor) + along(d1, anchor)));
    const Qua<P> turned = mul(qua<P>(k, kEndRotation), back(s.q));
    put(memory(i), kTurned, (2.0 / turned.w) * Vec<P>{turned.x, turned.y, turned.z});
    const ParentState<P> o = lanes.parents_of(i, s);
    const Vec<P> there = vec<P>(c, kParentAnchor);
    const Vec<P> end = rotated(o.q1, there), begin = rotated(o.q0, there);
    put(k, kEndReach, end + o.end_arm);
    put(k, kMeanReach, all<P>(0.5) * (end + begin) + o.mean_arm);
    const std::size_t left = count() - i;
    for (std::size_t l = 0; l < (left < Lanes::kAtOnce ? left : Lanes::kAtOnce); ++l)
      put_way(i + l);
  }
  /// Writes the displacement of body i's joint point; that of a free root is known.
  INLINE void put_way(std::size_t i) {
    double* k = work(i);
    if (parent(i) >= 0)
      put(k, kJointWay,
          vec<N>(work(static_cast<std::size_t>(parent(i))), kJointWay) +
              2.0 * (vec<N>(k, kEndReach) - vec<N>(k, kMeanReach)));
    if (parent(i) == kHeld) put(k, kJointWay, get_vec<N>(held_, 0));
    if (parent(i) < 0) held_ += 3 * kNumber;
  }

  static INLINE P size_of(P x) { return choose(x > all<P>(0), x, all<P>(-1) * x); }

  /// Writes the equations of each body of a block for the elimination. Where that keeps its
  /// matrices it needs no derivatives.
  template <Unknown unknown, Factor factor = Factor::renewed>
  INLINE void fill(std::size_t i) {
    const StartState<P> s = lanes.start(i);
    const double* c = constants(i);
    double* k = work(i);
    const Axes<P> d0 = axes_of(s.q), d1 = axes_of(qua<P>(k, kEndRotation));
    place(i, s, d0, d1);
    const Vec<P> moments = vec<P>(c, kInertia);
    const P half = 0.5 * (moments.x + moments.y + moments.z);
    const P second[3] = {half - moments.x, half - moments.y, half - moments.z};
    const P mass = num<P>(c, kMass);
    const Vec<P> arm = vec<P>(k, kEndArm);
    const Vec<P> way = per4 * (vec<P>(k, kJointWay) + all<P>(2) * (arm - vec<P>(k, kMeanArm)));
    const double* f = lanes.forces(i);
    Vec<P> torque{all<P>(0), all<P>(0), all<P>(0)}, impulse;
    Outer<P> turn;
    if (unknown == Unknown::displacement) {
      Vec<P> a = num<P>(c, kGravityScale) *
                 Vec<P>{all<P>(in.gravity[0]), all<P>(in.gravity[1]), all<P>(in.gravity[2])};
      if (f) a = a + vec<P>(f, 0), torque = (-0.5 * h4) * vec<P>(f, 3);
      const Vec<P> mean_arm = vec<P>(k, kMeanArm);
      impulse = mass * (way - s.v - (0.5 * h4) * a);
      if (factor != Factor::kept) turn.add(arm, all<P>(0.5) * impulse - (mass * per4) * mean_arm);
      for (int n = 0; n < 3; ++n) {
        const Vec<P> w = per4 * (d1.d[n] - d0.d[n]) - cross(s.w, d0.d[n]);
        const Vec<P> mean = all<P>(0.5) * (d0.d[n] + d1.d[n]);
        torque = torque + second[n] * cross(mean, w);
        if (factor != Factor::kept) turn.add(second[n] * d1.d[n], all<P>(0.5) * w - per4 * mean);
      }
      torque = torque + cross(mean_arm, impulse);
    } else {
      const P own = lanes.mask_of(i);
      const Vec<P> v = way + way - s.v;
      const Vec<P> g{all<P>(in.gravity[0]), all<P>(in.gravity[1]), all<P>(in.gravity[2])};
      const P fall = (2.0 * h4) * num<P>(c, kGravityScale) * dot(g, way);
      impulse = mass * v;
      // Speeds below a 1e12th of the radius per step are rounding, also without weight.
      const P radius2 = dot(arm, arm) + half / mass;
      weight_.add(i, own * mass * (root(dot(g, g) * radius2) + 1e-14 * per4 * per4 * radius2));
      due_.add(i, own * mass * (dot(s.v, s.v) + fall));
      work_.add(i, own * mass * size_of(fall));
      const Vec<P> turned = vec<P>(memory(i), kTurned);
      const P turned2 = own * dot(turned, turned);
      turned2_ = choose(turned2 > turned2_, turned2, turned2_);
      if (f) {
        const P by_force = (2.0 * h4) * mass * dot(vec<P>(f, 0), way);
        const P pushed = by_force + all<P>(2) * dot(vec<P>(f, 3), turned);
        due_.add(i, own * pushed), work_.add(i, own * size_of(pushed));
      }
      turn.add(arm, all<P>(-1) * (mass * arm));
      for (int n = 0; n < 3; ++n) {
        const Vec<P> before = cross(s.w, d0.d[n]);
        const Vec<P> w = (2.0 * per4) * (d1.d[n] - d0.d[n]) - before;
        torque = torque - second[n] * cross(d1.d[n], w);
        due_.add(i, own * second[n] * dot(before, before));
        turn.add(second[n] * d1.d[n], all<P>(-1) * d1.d[n]);
      }
      torque = torque - cross(arm, impulse);
    }
    put(k, kImpulse, impulse), put(k, kTorqueImpulse, torque);
    if (factor == Factor::kept) return;
    for (std::size_t n = 0; n < 3; ++n)
      put(k, kTurn + 3 * n, lanes.renewed(factor, turn.crossed(n), vec<P>(k, kTurn + 3 * n)));
  }
  template <Unknown unknown, Factor factor = Factor::renewed>
  void fill_all() {
    held_ = lanes.ways();
    for (std::size_t i = 0; i < count(); i += Lanes::kAtOnce) fill<unknown, factor>(i);
  }

  /// Inward pass, leaves to roots. Writes the impulses at the joints to the memory.
  template <Unknown unknown>
  void inward(Factor factor = Factor::renewed) const {
    if constexpr (Lanes::kHooks)
      if (in.joints) return in.joints->inward(in.joints->context, unknown);
    if (factor != Factor::kept) factorise<unknown>(factor);
    if (factor != Factor::renewed) inward_by_kept(factor);
  }
  /// Eliminates all bodies.
  template <Unknown unknown>
  void factorise(Factor factor) const {
    Rows<N> mass{};  // of the body before
    Vec<N> impulse{N{}, N{}, N{}};
    for (std::size_t i = count(); i-- > 0;) {
      ConservingBlock<N> b = ConservingBlock<N>::none();
      add_own<unknown>(work(i), num<N>(constants(i), kMass), per, b);
      std::uint32_t c = first_child_of(lanes.p, i);
      if (c == i + 1) {
        add_child<unknown>(b, mass, impulse, work(c));
        c = sibling_of(lanes.p, c);
      }
      for (; c != kNoChild; c = sibling_of(lanes.p, c))
        add_child<unknown>(b, Rows<N>::from(lanes.node(c), kArticulatedMass),
                           vec<N>(memory(c), kLambda), work(c));
      if (unknown == Unknown::displacement && lanes.has_ties()) {
        add_ties(b, lanes.tie_block(i));
        if (lanes.is_grounded(i)) add_grounded(b, lanes.tie_block(i));
      }
      impulse = b.impulse;
      if (unknown == Unknown::displacement) settle(i, b);
      const Inverse<N> inverse(b.tt);
      if (lanes.has_ties()) keep_factor(b, inverse, lanes.tie_factor(i));
      if (unknown == Unknown::displacement && lanes.may_keep()) keep_inverse(i, inverse, factor);
      lanes.renew(i, factor, [&](double* node) { mass = eliminate(b, inverse, node); });
    }
  }
  INLINE void keep_inverse(std::size_t i, const Inverse<N>& inverse, Factor factor) const {
    double* k = work(i);
    const auto& [u, v, w] = inverse;
    const Vec<N> rows[3] = {{u.x, v.x, w.x}, {u.y, v.y, w.y}, {u.z, v.z, w.z}};
    for (std::size_t n = 0; n < 3; ++n)
      put(k, kTurn + 3 * n, lanes.renewed(factor, rows[n], vec<N>(k, kTurn + 3 * n)));
  }
  /// The same for displacements by the matrices of the last renewal: right-hand sides only. Ties
  /// have no such iterations.
  void inward_by_kept(Factor factor) const {
    for (std::size_t i = count(); i-- > 0;) {
      const double* k = work(i);
      const Vec<N> none{N{}, N{}, N{}};
      Vec<N> torque = none - vec<N>(k, kTorqueImpulse), impulse = none + vec<N>(k, kImpulse);
      Vec<N> bias = none;
      const std::uint32_t first = first_child_of(lanes.p, i);
      for (std::uint32_t c = first; c != kNoChild; c = sibling_of(lanes.p, c)) {
        const Vec<N> r = vec<N>(work(c), kMeanReach), lambda = vec<N>(memory(c), kLambda);
        const Vec<N> own = fourths<N>(lanes.node(c), kArticulatedMass);
        bias = bias + own, impulse = impulse + lambda;
        torque = torque + cross(r, own) - cross(r, lambda);
      }
      put_impulse(i, impulse);
      const MatrixRows<N> inverse{vec<N>(k, kTurn), vec<N>(k, kTurn + 3), vec<N>(k, kTurn + 6)};
      const Vec<N> turn = mul(inverse, torque);
      Vec<N> moved = cross(turn, (num<N>(constants(i), kMass) * per) * vec<N>(k, kEndArm));
      for (std::uint32_t c = first; c != kNoChild; c = sibling_of(lanes.p, c))
        moved = moved + mul(MatrixRows<N>::from(lanes.node(c), kArticulatedMass),
                            cross(turn, vec<N>(work(c), kEndReach)));
      double* node = lanes.node(i);
      set_fourths(node, kResponse, lanes.kept(factor, turn, fourths<N>(node, kResponse)));
      set_fourths(node, kArticulatedMass,
                  lanes.kept(factor, bias - moved, fourths<N>(node, kArticulatedMass)));
    }
  }
  /// Finishes a body's block once all its children are added.
  INLINE void settle(std::size_t i, ConservingBlock<N>& b) const {
    put_impulse(i, b.impulse);
    turn_axes(b, vec<N>(memory(i), kTurned));
  }
  INLINE void put_impulse(std::size_t i, Vec<N> impulse) const {
    double* m = memory(i);
    put(m, kLambda, lanes.running(impulse, vec<N>(m, kLambda)));
  }

  /// Displacement, or velocity, of a root's joint point.
  template <Unknown unknown>
  INLINE Vec<N> of_root(std::size_t i, const double* held) const {
    if (parent(i) == kHeld)
      return unknown == Unknown::displacement ? Vec<N>{N{}, N{}, N{}} : get_vec<N>(held, 0);
    const Rows<N> g = Rows<N>::from(lanes.node(i), kArticulatedMass);
    Vec<N> f{g.x[3], g.y[3], g.z[3]};
    if (unknown == Unknown::displacement) f = f - vec<N>(memory(i), kLambda);
    const Inverse<N> mass(g);
    return f.x * mass.u + f.y * mass.v + f.z * mass.w;
  }
  /// Outward pass, roots to leaves: the unknowns of body i.
  template <Unknown unknown>
  INLINE void outward(std::size_t i, const double*& held) {
    double* m = memory(i);
    Vec<N> y;
    if (parent(i) < 0) {
      y = of_root<unknown>(i, held);
      held += 3 * kNumber;
    } else {
      const double* o = memory(static_cast<std::size_t>(parent(i)));
      y = vec<N>(o, kMove) + cross(vec<N>(o, kTurnBy), vec<N>(work(i), kEndReach));
    }
    const double* node = lanes.node(i);
    const auto n = [&](std::size_t at) { return get<N>(node, at); };
    const Vec<N> t{n(3) - (n(0) * y.x + n(1) * y.y + n(2) * y.z),
                   n(7) - (n(4) * y.x + n(5) * y.y + n(6) * y.z),
                   n(11) - (n(8) * y.x + n(9) * y.y + n(10) * y.z)};
    put(m, kMove, y), put(m, kTurnBy, t);
    // The impulse over half the step after this iteration, or with that of the projection.
    const auto g = [&](std::size_t at) { return n(kArticulatedMass + at); };
    const Vec<N> gain{(g(0) * y.x + g(1) * y.y + g(2) * y.z) - g(3),
                      (g(4) * y.x + g(5) * y.y + g(6) * y.z) - g(7),
                      (g(8) * y.x + g(9) * y.y + g(10) * y.z) - g(11)};
    const Vec<N> before = vec<N>(m, kLambda);
    const double share = unknown == Unknown::displacement ? 1.0 : 0.5;
    const Vec<N> after = before + share * gain;
    put(m, kLambda, unknown == Unknown::displacement ? lanes.running(after, before) : after);
  }

  typename Lanes::Sum due_;       // twice the kinetic energy due at the end, J
  typename Lanes::Sum work_;      // J: sum of the magnitudes of the work terms in it
  typename Lanes::Sum weight_;    // J: scale of the work that the weight and rounding can do
  typename Lanes::Sum probe_;     // finite if all positions are
  P turned2_ = all<P>(0);         // square of the longest Cayley vector of a rotation over the step
  const double* held_ = nullptr;  // of the next root: displacement of its anchor
};

}  // namespace
}  // namespace pantin::detail::articulated

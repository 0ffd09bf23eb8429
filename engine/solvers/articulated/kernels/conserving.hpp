#pragma once
/// A whole step of a tree of free ball joints by the energy-momentum method, solved by Newton
/// iterations in the rotations of the bodies.
///
/// A rigid body is seen as its mass centre and three material directions d_k with masses J_k (the
/// principal second moments, kg m^2). Joints are linear in these coordinates and rigidity is
/// quadratic, so that the mid-point rule with the constraint gradients at the mean of the two
/// poses conserves energy, momentum and angular momentum. [Betsch & Steinmann 2001, "Constrained
/// integration of rigid body dynamics"] The mean velocity of the step, V = (z1 - z0) / h, makes
///
///   (V - v0 - h f / 2) . dz = 0   for every displacement dz that the joints and rigidity allow
///
/// at the mean of the poses z0 and z1, masses understood. The velocity at the end, 2 V - v0, is
/// projected to those that joints and rigidity allow there, which can only remove energy. Nothing
/// depends on the ratio of a body's moments of inertia: thin bodies are no special case.
///
/// The unknowns of an iteration are the rotation of each body (rad) and the displacement of its
/// own joint point (m). Bodies are eliminated from the leaves to the roots, in linear time.
#include "engine/solvers/articulated/kernels/conserving_block.hpp"
#include "engine/solvers/articulated/kernels/predict.hpp"

namespace pantin::detail::articulated {
namespace {

/// The step of one island; see the head of the file.
struct ConservingStep {
  /// Cayley's vector of a turn by 2 rad.
  static constexpr double kMostTurned = 3.11;
  const IslandView& p;
  const ConservingInput& in;
  const double h = in.h, per = 1 / in.h;
  DampingFactor damping{0.5 * in.h};
  double largest2 = 0;  // square of the largest rotation of the last iteration, rad^2

  /// State of four bodies at the start of the step, after half its drag.
  struct Start {
    Vec<Four> x, v, w;
    Qua<Four> q;
  };
  INLINE Start start(std::size_t i) {
    const FourBodies bodies(p, i);
    const Four keep = damping.of(num<Four>(column(p.constants, kConstantRows, i), kDrag));
    return {bodies.vec(p.layout.position), keep * bodies.vec(p.layout.velocity),
            keep * bodies.vec(p.layout.angular_velocity), bodies.qua(p.layout.rotation)};
  }

  /// The first iterate of a block: rotation at constant velocity, or at constant acceleration if
  /// the last step had the same length.
  INLINE void guess(std::size_t i) {
    const Start s = start(i);
    probe_ += dot(s.x, s.x);
    Vec<Four> r = all(h) * s.w;
    if (in.follows_equal_step)
      r = r + r - vec<Four>(column(p.memory, kMemoryRows, i), kLastRotation);
    const Four r2 = dot(r, r), most = all(1.5);
    r = choose(r2 > most * most, most / root(r2), all(1.0)) * r;
    double* k = column(p.work, kWorkRows, i);
    put(k, kEndRotation, unit_again(mul(exponential(r), s.q)));
    put(k, kJointWay, all(h) * s.v);  // of a free root
  }

  /// Arms, reaches and positions of a block whose rotations are known; parents come before.
  INLINE void place(std::size_t i, const Start& s, const Axes<Four>& d0, const Axes<Four>& d1) {
    const double* c = column(p.constants, kConstantRows, i);
    double* k = column(p.work, kWorkRows, i);
    const Vec<Four> anchor = vec<Four>(c, kOwnAnchor);
    const Vec<Four> arm = all(-1) * along(d1, anchor);
    put(k, kEndArm, arm);
    put(k, kMeanArm, all(-0.5) * (along(d0, anchor) + along(d1, anchor)));
    Qua<Four> q0 = s.q, q1 = qua<Four>(k, kEndRotation);
    const Qua<Four> turned = mul(q1, back(q0));
    put(column(p.memory, kMemoryRows, i), kTurned,
        (2.0 / turned.w) * Vec<Four>{turned.x, turned.y, turned.z});
    Vec<Four> arm1 = arm, arm_mean = vec<Four>(k, kMeanArm);
    for (std::size_t l = 0; l < kLanes; ++l) {
      const std::int32_t parent = p.parents[i + l];
      if (parent < 0) continue;
      const auto at = static_cast<std::size_t>(parent);
      const double* b = p.bodies + p.slots[at] * p.layout.stride + p.layout.rotation;
      q0.x[l] = b[0], q0.y[l] = b[1], q0.z[l] = b[2], q0.w[l] = b[3];
      const double* o = column(p.work, kWorkRows, at);
      q1.x[l] = o[kEndRotation * kLanes], q1.y[l] = o[(kEndRotation + 1) * kLanes];
      q1.z[l] = o[(kEndRotation + 2) * kLanes], q1.w[l] = o[(kEndRotation + 3) * kLanes];
      const Vec<double> e1 = vec<double>(o, kEndArm), em = vec<double>(o, kMeanArm);
      arm1.x[l] = e1.x, arm1.y[l] = e1.y, arm1.z[l] = e1.z;
      arm_mean.x[l] = em.x, arm_mean.y[l] = em.y, arm_mean.z[l] = em.z;
    }
    const Vec<Four> there = vec<Four>(c, kParentAnchor);
    const Vec<Four> end = rotated(q1, there), begin = rotated(q0, there);
    put(k, kEndReach, end + arm1);
    put(k, kMeanReach, all(0.5) * (end + begin) + arm_mean);
    const std::size_t lanes = p.count - i < kLanes ? p.count - i : kLanes;
    for (std::size_t l = 0; l < lanes; ++l) put_way(i + l, k + l);
  }
  /// Displacement of the joint point of body i; that of a free root is known.
  INLINE void put_way(std::size_t i, double* k) {
    const std::int32_t parent = p.parents[i];
    if (parent >= 0)
      put(k, kJointWay,
          vec<double>(column(p.work, kWorkRows, static_cast<std::size_t>(parent)), kJointWay) +
              2.0 * (vec<double>(k, kEndReach) - vec<double>(k, kMeanReach)));
    if (parent == kHeld) put(k, kJointWay, Vec<double>{held_[0], held_[1], held_[2]});
    if (parent < 0) held_ += 3;
  }

  static INLINE Four size_of(Four x) { return choose(x > all(0), x, all(-1) * x); }

  /// What the elimination needs of each body of a block.
  template <Unknown unknown>
  INLINE void fill(std::size_t i) {
    const Start s = start(i);
    const double* c = column(p.constants, kConstantRows, i);
    double* k = column(p.work, kWorkRows, i);
    const Axes<Four> d0 = axes_of(s.q), d1 = axes_of(qua<Four>(k, kEndRotation));
    place(i, s, d0, d1);
    const Vec<Four> moments = vec<Four>(c, kInertia);
    const Four half = 0.5 * (moments.x + moments.y + moments.z);
    const Four second[3] = {half - moments.x, half - moments.y, half - moments.z};
    const Four mass = num<Four>(c, kMass);
    const Vec<Four> arm = vec<Four>(k, kEndArm);
    const Vec<Four> way =
        all(per) * (vec<Four>(k, kJointWay) + all(2) * (arm - vec<Four>(k, kMeanArm)));
    Vec<Four> torque{all(0), all(0), all(0)}, impulse;
    Outer turn;
    if (unknown == Unknown::displacement) {
      Vec<Four> a = num<Four>(c, kGravityScale) *
                    Vec<Four>{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
      if (p.forces) {
        const double* f = column(p.forces, 6, i);
        a = a + vec<Four>(f, 0), torque = all(-0.5 * h) * vec<Four>(f, 3);
      }
      const Vec<Four> mean_arm = vec<Four>(k, kMeanArm);
      impulse = mass * (way - s.v - all(0.5 * h) * a);
      turn.add(arm, all(0.5) * impulse - (mass * per) * mean_arm);
      for (int n = 0; n < 3; ++n) {
        const Vec<Four> w = all(per) * (d1.d[n] - d0.d[n]) - cross(s.w, d0.d[n]);
        const Vec<Four> mean = all(0.5) * (d0.d[n] + d1.d[n]);
        torque = torque + second[n] * cross(mean, w);
        turn.add(second[n] * d1.d[n], all(0.5) * w - all(per) * mean);
      }
      torque = torque + cross(mean_arm, impulse);
    } else {
      const Vec<Four> v = way + way - s.v;
      const Vec<Four> g{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
      const Four fall = all(2 * h) * num<Four>(c, kGravityScale) * dot(g, way);
      impulse = mass * v,
      weight_ += mask(i, p.count) * mass * root(dot(g, g) * (dot(arm, arm) + half / mass));
      due_ += mask(i, p.count) * mass * (dot(s.v, s.v) + fall);
      work_ += mask(i, p.count) * mass * size_of(fall);
      const Vec<Four> turned = vec<Four>(column(p.memory, kMemoryRows, i), kTurned);
      const Four turned2 = mask(i, p.count) * dot(turned, turned);
      turned2_ = choose(turned2 > turned2_, turned2, turned2_);
      if (p.forces) {
        const double* f = column(p.forces, 6, i);
        const Four by_force = all(2 * h) * mass * dot(vec<Four>(f, 0), way);
        const Four pushed = by_force + all(2) * dot(vec<Four>(f, 3), turned);
        due_ += mask(i, p.count) * pushed, work_ += mask(i, p.count) * size_of(pushed);
      }
      turn.add(arm, all(-1) * (mass * arm));
      for (int n = 0; n < 3; ++n) {
        const Vec<Four> before = cross(s.w, d0.d[n]);
        const Vec<Four> w = all(2 * per) * (d1.d[n] - d0.d[n]) - before;
        torque = torque - second[n] * cross(d1.d[n], w);
        due_ += mask(i, p.count) * second[n] * dot(before, before);
        turn.add(second[n] * d1.d[n], all(-1) * d1.d[n]);
      }
      torque = torque - cross(arm, impulse);
    }
    put(k, kImpulse, impulse), put(k, kTorqueImpulse, torque);
    turn.put_crossed(k, kTurn);
  }
  template <Unknown unknown>
  void fill_all() {
    held_ = in.ways;
    for (std::size_t i = 0; i < p.count; i += kLanes) fill<unknown>(i);
  }

  /// Leaves to roots. The impulses at the joints go to the memory.
  template <Unknown unknown>
  void inward() const {
    if (in.joints) return in.joints->inward(in.joints->context, unknown);
    if (p.is_chain && !in.ties) {
      Rows mass{};
      Vec<double> impulse{0, 0, 0};
      for (std::size_t i = p.count; i-- > 0;) {
        ConservingBlock b = nothing();
        add_own<unknown>(p, per, i, b);
        if (i + 1 < p.count) add_child<unknown>(b, mass, impulse, column(p.work, kWorkRows, i + 1));
        impulse = b.impulse;
        if (unknown == Unknown::displacement) settle(i, b);
        mass = eliminate(b, {b.tt.x, b.tt.y, b.tt.z}, p.nodes + kNodeSize * i);
      }
      return;
    }
    for (std::size_t i = 0; i < p.count; ++i) put_block(i, nothing());
    for (std::size_t i = p.count; i-- > 0;) {
      ConservingBlock b = block_at(i);
      add_own<unknown>(p, per, i, b);
      if (unknown == Unknown::displacement && in.ties) add_ties(b, in.ties->blocks + kTieBlock * i);
      if (unknown == Unknown::displacement) settle(i, b);
      const Inverse inverse(b.tt.x, b.tt.y, b.tt.z);
      if (in.ties) keep_factor(b, inverse, in.ties->factors + kTieFactor * i);
      const Rows mass = eliminate(b, inverse, p.nodes + kNodeSize * i);
      if (p.parents[i] < 0) continue;
      const auto parent = static_cast<std::size_t>(p.parents[i]);
      ConservingBlock of_parent = block_at(parent);
      add_child<unknown>(of_parent, mass, b.impulse, column(p.work, kWorkRows, i));
      put_block(parent, of_parent);
    }
  }
  /// Of a body whose children are all added.
  INLINE void settle(std::size_t i, ConservingBlock& b) const {
    double* m = column(p.memory, kMemoryRows, i);
    put(m, kLambda, b.impulse);
    turn_axes(b, vec<double>(m, kTurned));
  }
  INLINE ConservingBlock block_at(std::size_t i) const {
    const double* b = in.blocks + kConservingBlock * i;
    return {Rows::from(b),      Rows::from(b + 12),    Rows::from(b + 24),
            Rows::from(b + 36), {b[48], b[49], b[50]}, {b[51], b[52], b[53]}};
  }
  INLINE void put_block(std::size_t i, const ConservingBlock& b) const {
    double* to = in.blocks + kConservingBlock * i;
    b.tt.to(to), b.ty.to(to + 12), b.yt.to(to + 24), b.yy.to(to + 36);
    to[48] = b.impulse.x, to[49] = b.impulse.y, to[50] = b.impulse.z;
    to[51] = b.torque.x, to[52] = b.torque.y, to[53] = b.torque.z;
  }

  /// Displacement, or velocity, of a root's joint point.
  template <Unknown unknown>
  INLINE Vec<double> of_root(std::size_t i, const double* held) const {
    if (p.parents[i] == kHeld)
      return unknown == Unknown::displacement ? Vec<double>{0, 0, 0}
                                              : Vec<double>{held[0], held[1], held[2]};
    const double* g = p.nodes + kNodeSize * i + kArticulatedMass;
    Vec<double> f{g[3], g[7], g[11]};
    if (unknown == Unknown::displacement)
      f = f - vec<double>(column(p.memory, kMemoryRows, i), kLambda);
    const Inverse mass(load(g), load(g + 4), load(g + 8));
    return f.x * mass.u + f.y * mass.v + f.z * mass.w;
  }
  /// Roots to leaves: the unknowns of body i.
  template <Unknown unknown>
  INLINE void outward(std::size_t i, const double*& held) {
    double* m = column(p.memory, kMemoryRows, i);
    const double* n = p.nodes + kNodeSize * i;
    Vec<double> y;
    const std::int32_t parent = p.parents[i];
    if (parent < 0) {
      y = of_root<unknown>(i, held);
      held += 3;
    } else {
      const double* o = column(p.memory, kMemoryRows, static_cast<std::size_t>(parent));
      y = vec<double>(o, kMove) +
          cross(vec<double>(o, kTurnBy), vec<double>(column(p.work, kWorkRows, i), kEndReach));
    }
    const Vec<double> t{n[3] - (n[0] * y.x + n[1] * y.y + n[2] * y.z),
                        n[7] - (n[4] * y.x + n[5] * y.y + n[6] * y.z),
                        n[11] - (n[8] * y.x + n[9] * y.y + n[10] * y.z)};
    put(m, kMove, y), put(m, kTurnBy, t);
    put_impulse(m, n, y, unknown == Unknown::displacement ? 1.0 : 0.5);
  }
  /// The impulse over half the step after this iteration, or with that of the projection.
  static INLINE void put_impulse(double* m, const double* n, Vec<double> y, double share) {
    const double* g = n + kArticulatedMass;
    put(m, kLambda,
        vec<double>(m, kLambda) +
            share * Vec<double>{(g[0] * y.x + g[1] * y.y + g[2] * y.z) - g[3],
                                (g[4] * y.x + g[5] * y.y + g[6] * y.z) - g[7],
                                (g[8] * y.x + g[9] * y.y + g[10] * y.z) - g[11]});
  }

  /// One Newton iteration: eliminates, rotates, and fills for what comes next.
  bool iterate() {
    if (in.ties) in.ties->load(in.ties->context);
    inward<Unknown::displacement>();
    const double* held = in.ways;
    Four most = all(0), probe = all(0);
    if (in.joints) in.joints->outward(in.joints->context, Unknown::displacement);
    for (std::size_t i = 0; !in.joints && i < p.count; ++i) outward<Unknown::displacement>(i, held);
    if (in.ties && !in.ties->correct(in.ties->context)) return false;
    for (std::size_t i = 0; i < p.count; i += kLanes) {
      double* k = column(p.work, kWorkRows, i);
      Vec<Four> t = vec<Four>(column(p.memory, kMemoryRows, i), kTurnBy);
      const Four t2 = mask(i, p.count) * dot(t, t);
      most = choose(t2 > most, t2, most), probe += t2;
      t = choose(t2 > 1.0, 1.0 / root(t2), all(1.0)) * t;
      put(k, kEndRotation,
          unit(
              mul(Qua<Four>{0.5 * t.x, 0.5 * t.y, 0.5 * t.z, all(1)}, qua<Four>(k, kEndRotation))));
    }
    largest2 = sum(probe) < HUGE_VAL ? largest(most) : HUGE_VAL;
    return largest2 < 1e6;
  }

  /// Newton iterations; false if they do not converge.
  bool solve() {
    for (std::size_t i = 0; i < p.count; i += kLanes) guess(i);
    if (!(sum(probe_) < HUGE_VAL)) return false;
    fill_all<Unknown::displacement>();
    for (int n = 0; n < in.most_iterations; ++n) {
      const double before2 = largest2;
      if (!iterate()) return false;
      const bool near = largest2 < in.enough * in.enough ||
                        (n > 0 && largest2 < in.enough_next * ::sqrt(before2));
      move_roots();
      if (near && !in.ties) return true;
      fill_all<Unknown::displacement>();
      if (near && in.ties->settled(in.ties->context)) return true;
    }
    return false;
  }
  /// Free roots move by what was found.
  void move_roots() {
    for (std::size_t i = 0; i < p.count; ++i)
      if (p.parents[i] == kFree) {
        double* k = column(p.work, kWorkRows, i);
        put(k, kJointWay,
            vec<double>(k, kJointWay) + vec<double>(column(p.memory, kMemoryRows, i), kMove));
      }
  }

  /// A free tree gets the momentum that it must have, to the last digit: what the iterations left
  /// is the same velocity for all its bodies.
  void balance(std::size_t first, std::size_t last) {
    Vec<double> lacks{0, 0, 0};
    double mass = 0;
    for (std::size_t i = first; i < last; ++i) {
      const double* c = column(p.constants, kConstantRows, i);
      const double* b = p.bodies + p.slots[i] * p.layout.stride + p.layout.velocity;
      const double keep = ::exp(-0.5 * h * num<double>(c, kDrag)), m = num<double>(c, kMass);
      const double weight = h * num<double>(c, kGravityScale);
      Vec<double> v{keep * b[0] + weight * in.gravity[0], keep * b[1] + weight * in.gravity[1],
                    keep * b[2] + weight * in.gravity[2]};
      if (p.forces) v = v + h * vec<double>(column(p.forces, 6, i), 0);
      lacks = lacks + (m * v - vec<double>(column(p.work, kWorkRows, i), kImpulse));
      mass += m;
    }
    const Vec<double> change = (1 / mass) * lacks;
    for (std::size_t i = first; i < last; ++i) {
      double* k = column(p.work, kWorkRows, i);
      const Vec<double> gain = num<double>(column(p.constants, kConstantRows, i), kMass) * change;
      put(k, kImpulse, vec<double>(k, kImpulse) + gain);
      put(k, kTorqueImpulse, vec<double>(k, kTorqueImpulse) - cross(vec<double>(k, kEndArm), gain));
      if (i == first) put(k, kJointWay, vec<double>(k, kJointWay) + (0.5 * h) * change);
    }
  }

  /// Twice the work at the anchors of the roots, J: by their impulses over `ways`, m, or at the
  /// velocities at the end, m/s.
  double anchor_work(const double* moved, double share) const {
    double work = 0;
    for (std::size_t i = 0; i < p.count; ++i) {
      if (p.parents[i] >= 0) continue;
      const Vec<double> way{moved[0], moved[1], moved[2]};
      if (p.parents[i] == kHeld)
        work += share * dot(vec<double>(column(p.memory, kMemoryRows, i), kLambda), way);
      moved += 3;
    }
    return work;
  }

  /// Velocities at the end, and everything written back; false, and nothing written, where energy
  /// came from nowhere, or a body turned about half around: the iterations then ended at no
  /// solution, or at a spurious one.
  bool finish() {
    double released = 0;
    if (in.joints) in.joints->align(in.joints->context);
    fill_all<Unknown::velocity>();
    if (in.divisible && largest(turned2_) > kMostTurned * kMostTurned) return false;
    if (in.ties && !in.ties->accept(in.ties->context, released)) return false;
    const bool keeps = !(in.joints && !in.joints->add_work(in.joints->context, released));
    bool still = keeps && in.still;
    const bool known = keeps && in.knows_work;
    const double by_ways = anchor_work(in.ways, 4 * per);
    const double at_end = anchor_work(in.anchor_velocities, 4);
    for (std::size_t first = 0, last = 0; first < p.count; first = last) {
      last = first + 1;
      while (last < p.count && p.parents[last] >= 0) ++last;
      if (p.parents[first] == kFree && (!in.ties || *in.ties->inner)) balance(first, last);
    }
    inward<Unknown::velocity>();
    if (in.joints) in.joints->outward(in.joints->context, Unknown::velocity);
    const double *held = in.anchor_velocities, *target = in.targets;
    Four kept = all(0);
    for (std::size_t i = 0; i < p.count; i += kLanes) {
      const std::size_t lanes = p.count - i < kLanes ? p.count - i : kLanes;
      for (std::size_t l = 0; l < lanes; ++l) {
        if (!in.joints) outward<Unknown::velocity>(i + l, held);
        put_joint(i + l, target);
      }
    }
    if (in.ties && !in.ties->project(in.ties->context)) return false;
    const bool struck = in.ties && *in.ties->struck;  // a blow takes energy, it gives none
    still = still && !struck;
    for (std::size_t i = 0; known && i < p.count; i += kLanes) kept += twice_kinetic(i);
    // The projection takes energy of the second order in the step. Below an anchor that stands
    // still velocities are scaled to the energy that is due, at most by a tenth: beyond that
    // the step does not resolve the motion, and shorter ones are tried. The projection impulses
    // do no more work at anchors than at the velocities that these have at the end.
    if (known) {
      const double by_anchors = by_ways + anchor_work(in.anchor_velocities, 4) - at_end;
      const double by_places = in.ties ? 2 * *in.ties->place_work : 0;
      const double due = sum(due_) + 2 * released + by_anchors + by_places, found = sum(kept);
      const double rounding =
          still ? 0 : 1e-3 * (sum(work_) + ::fabs(by_anchors) + ::fabs(by_places));
      const bool moves =
          found > 1e-10 * sum(weight_);  // beyond rounding errors of the weight's work
      if (moves && !(due + rounding >= 0.99 * found)) return false;
      if (moves && !struck && due > in.most_due * found) return false;
      if (moves && still) factor_ = due < 1.2 * found ? ::sqrt(due / found) : ::sqrt(1.2);
    }
    for (std::size_t i = 0; i < p.count; i += kLanes)
      write_back(i, p.count - i < kLanes ? p.count - i : kLanes);
    return true;
  }
  /// Twice the kinetic energy of a block by its projected velocities, J.
  INLINE Four twice_kinetic(std::size_t i) const {
    const double* k = column(p.work, kWorkRows, i);
    const double* c = column(p.constants, kConstantRows, i);
    const double* m = column(p.memory, kMemoryRows, i);
    const Vec<Four> w = vec<Four>(m, kTurnBy);
    const Vec<Four> v = vec<Four>(m, kMove) + cross(w, vec<Four>(k, kEndArm));
    const Vec<Four> l = times_inertia(qua<Four>(k, kEndRotation), vec<Four>(c, kInertia), w);
    return mask(i, p.count) * (num<Four>(c, kMass) * dot(v, v) + dot(l, w));
  }
  /// Position of the joint of body i at the end.
  INLINE void put_joint(std::size_t i, const double*& target) const {
    double* k = column(p.work, kWorkRows, i);
    const std::int32_t parent = p.parents[i];
    Vec<double> joint;
    if (parent >= 0) {
      const double* o = column(p.work, kWorkRows, static_cast<std::size_t>(parent));
      joint = vec<double>(o, kEndJoint) + vec<double>(k, kEndReach);
    } else if (parent == kHeld) {
      joint = {target[0], target[1], target[2]};
    } else {
      const double* b = p.bodies + p.slots[i] * p.layout.stride + p.layout.position;
      const Vec<double> arm_before = 2.0 * vec<double>(k, kMeanArm) - vec<double>(k, kEndArm);
      joint = Vec<double>{b[0], b[1], b[2]} - arm_before + vec<double>(k, kJointWay);
    }
    if (parent < 0) target += 3;
    put(k, kEndJoint, joint);
  }
  INLINE void write_back(std::size_t i, std::size_t lanes) {
    const double* k = column(p.work, kWorkRows, i);
    double* m = column(p.memory, kMemoryRows, i);
    const FourBodies bodies(p, i);
    const Four keep = damping.of(num<Four>(column(p.constants, kConstantRows, i), kDrag));
    const Vec<Four> x = vec<Four>(k, kEndJoint) + vec<Four>(k, kEndArm);
    const Qua<Four> q = qua<Four>(k, kEndRotation);
    const Vec<Four> w = all(factor_) * vec<Four>(m, kTurnBy);
    const Vec<Four> v =
        keep * (all(factor_) * vec<Four>(m, kMove) + cross(w, vec<Four>(k, kEndArm)));
    const Vec<Four> turned = vec<Four>(m, kTurned);  // by 2 atan(t / 2) = t - t^3 / 12 + t^5 / 80
    const Four t2 = dot(turned, turned);
    put(m, kLastRotation, (1.0 - t2 * (1.0 / 12) + t2 * t2 * (1.0 / 80)) * turned);
    put(m, kLastTranslation, x - bodies.vec(p.layout.position));
    put(m, kLambda, all(2 * h) * vec<Four>(m, kLambda));
    bodies.set(p.layout.position, x, lanes);
    bodies.set(p.layout.rotation, Vec<Four>{q.x, q.y, q.z}, lanes);
    bodies.set(p.layout.rotation + 3, q.w, lanes);
    bodies.set(p.layout.velocity, v, lanes);
    bodies.set(p.layout.angular_velocity, keep * w, lanes);
  }

  Four due_ = all(0);      // twice the kinetic energy that the bodies must have at the end, J
  Four work_ = all(0);     // J: sizes of the works in it
  Four turned2_ = all(0);  // square of the largest rotation over the step, by Cayley's vector
  Four weight_ = all(0);   // J: scale of the work that the weight can do
  double factor_ = 1;      // of the velocities after it
  Four probe_ = all(0);    // finite where all positions are
  const double* held_ = nullptr;  // of the next root: displacement of its anchor
};

bool conserve(const IslandView& p, const ConservingInput& in) {
  ConservingStep step{p, in};
  const bool solved = step.solve() && step.finish();
  // The other passes expect an identity there.
  for (std::size_t i = p.count; i % kLanes != 0; ++i)
    put(column(p.work, kWorkRows, i), kAppliedRotation, Qua<double>{0, 0, 0, 1});
  return solved;
}

}  // namespace
}  // namespace pantin::detail::articulated

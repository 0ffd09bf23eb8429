#pragma once
/// A whole step of a tree of free ball joints by the energy-momentum method, solved by Newton
/// iterations in the rotations of the bodies.
///
/// A rigid body is seen as its mass centre and three material directions d_k with masses J_k (the
/// principal second moments, kg m^2). Joints are linear in these coordinates and rigidity is
/// quadratic, so that the mid-point rule with the constraint gradients at the mean of the two
/// poses conserves energy, momentum and angular momentum. [Betsch, Steinmann 2001, "Constrained
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
#include "engine/solvers/articulated/kernels/outward.hpp"
#include "engine/solvers/articulated/kernels/predict.hpp"

namespace pantin::detail::articulated {
namespace {

/// What is solved for: displacements that take the residual away, or the velocities allowed.
enum class Unknown { displacement, velocity };

/// Rows of the work table during this step.
enum ConservingRow : std::size_t {
  kEndRotation,         // 4, of the iterate
  kJointWay = 4,        // 3, displacement of the own joint over the step
  kEndArm = 7,          // 3, from the own joint to the mass centre, at the iterate
  kMeanArm = 10,        // 3, mean of that and of the arm at the start
  kEndReach = 13,       // 3, from the parent's own joint to this one
  kMeanReach = 16,      // 3
  kImpulse = 19,        // 3, residual of the translation, or momentum, kg m/s
  kTorqueImpulse = 22,  // 3, about the own joint, kg m^2/s
  kTurn = 25,           // 9, derivative of the torque impulse, by rows
  kConservingRows = kTurn + 9
};
static_assert(std::size_t{kConservingRows} <= std::size_t{kWorkRows});
constexpr std::size_t kEndJoint = kImpulse;  // 3, position of the own joint, once all is solved

/// The bodies' unknowns share rows of the memory table that belong to the other rules.
constexpr std::size_t kMove = kVelocityBefore, kTurnBy = kAngularMomentumBefore;

/// A body with its outboard subtree, before its rotation is eliminated; each row is followed by the
/// component of a vector.
struct ConservingBlock {
  Rows tt, ty, yt, yy;  // ty: | torque impulse to be made; yy: | momentum, or nothing
  Vec<double> impulse;  // at the own joint, from the parent
};
static_assert(sizeof(ConservingBlock) <= kConservingBlock * sizeof(double) &&
              "see lane_layout.hpp");

template <class T>
struct Axes {
  Vec<T> d[3];
};
/// The columns of the rotation matrix.
INLINE Axes<Four> axes_of(Qua<Four> q) {
  const Four xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z,
             yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  const Four one = all(1.0);
  return {{{one - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)},
           {2.0 * (xy - wz), one - 2.0 * (xx + zz), 2.0 * (yz + wx)},
           {2.0 * (xz + wy), 2.0 * (yz - wx), one - 2.0 * (xx + yy)}}};
}
INLINE Vec<Four> along(const Axes<Four>& r, Vec<Four> v) {
  return v.x * r.d[0] + v.y * r.d[1] + v.z * r.d[2];
}

/// A sum of outer products a b^T, by rows.
struct Outer {
  Vec<Four> x{all(0), all(0), all(0)}, y = x, z = x;
  INLINE void add(Vec<Four> a, Vec<Four> b) { x = x + a.x * b, y = y + a.y * b, z = z + a.z * b; }
  /// Minus the trace, on the diagonal: a (b . t) - t (a . b), the turned a crossed with b.
  INLINE void put_crossed(double* k, std::size_t row) const {
    const Four trace = x.x + y.y + z.z;
    put(k, row, Vec<Four>{x.x - trace, x.y, x.z});
    put(k, row + 3, Vec<Four>{y.x, y.y - trace, y.z});
    put(k, row + 6, Vec<Four>{z.x, z.y, z.z - trace});
  }
};

/// The step of one island; see the head of the file.
struct ConservingStep {
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
      impulse = mass * (way + way - s.v);
      turn.add(arm, all(-1) * (mass * arm));
      for (int n = 0; n < 3; ++n) {
        const Vec<Four> w = all(2 * per) * (d1.d[n] - d0.d[n]) - cross(s.w, d0.d[n]);
        torque = torque - second[n] * cross(d1.d[n], w);
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

  /// The block of a body without its children.
  template <Unknown unknown>
  INLINE void add_own(std::size_t i, ConservingBlock& b) const {
    const double* k = column(p.work, kWorkRows, i);
    const double mass = num<double>(column(p.constants, kConstantRows, i), kMass);
    const double m = unknown == Unknown::displacement ? mass * per : mass;
    const std::size_t arm_row = unknown == Unknown::displacement ? kMeanArm : kEndArm;
    const Vec<double> e = m * vec<double>(k, arm_row), e1 = m * vec<double>(k, kEndArm);
    const Vec<double> t = vec<double>(k, kTorqueImpulse), f = vec<double>(k, kImpulse);
    const Vec<double> x = vec<double>(k, kTurn), y = vec<double>(k, kTurn + 3),
                      z = vec<double>(k, kTurn + 6);
    b.tt.x += Four{x.x, x.y, x.z, 0}, b.tt.y += Four{y.x, y.y, y.z, 0};
    b.tt.z += Four{z.x, z.y, z.z, 0};
    b.ty.x += Four{0, -e.z, e.y, -t.x}, b.ty.y += Four{e.z, 0, -e.x, -t.y};
    b.ty.z += Four{-e.y, e.x, 0, -t.z};
    b.yt.x += Four{0, e1.z, -e1.y, 0}, b.yt.y += Four{-e1.z, 0, e1.x, 0};
    b.yt.z += Four{e1.y, -e1.x, 0, 0};
    const bool moves = unknown == Unknown::velocity;
    b.yy.x += Four{m, 0, 0, moves ? f.x : 0}, b.yy.y += Four{0, m, 0, moves ? f.y : 0};
    b.yy.z += Four{0, 0, m, moves ? f.z : 0};
    if (!moves) b.impulse = b.impulse + f;
  }

  /// r x v for the rows of a 3x3 matrix, into the first three components.
  static INLINE Four row_cross(Four row, Vec<double> r) {
    return Four{row[1] * r.z - row[2] * r.y, row[2] * r.x - row[0] * r.z,
                row[0] * r.y - row[1] * r.x, 0};
  }

  /// Adds an eliminated child, given as mass | bias at its joint and the impulse there.
  template <Unknown unknown>
  INLINE void add_child(ConservingBlock& b, const Rows& child, Vec<double> impulse,
                        const double* k) const {
    const Vec<double> r1 = vec<double>(k, kEndReach);
    const Vec<double> r = unknown == Unknown::displacement ? vec<double>(k, kMeanReach) : r1;
    b.yy.x += child.x, b.yy.y += child.y, b.yy.z += child.z;
    b.yt.x -= row_cross(child.x, r1), b.yt.y -= row_cross(child.y, r1);
    b.yt.z -= row_cross(child.z, r1);
    const Four kx = r.y * child.z - r.z * child.y, ky = r.z * child.x - r.x * child.z,
               kz = r.x * child.y - r.y * child.x;
    b.ty.x += kx, b.ty.y += ky, b.ty.z += kz;
    b.tt.x -= row_cross(kx, r1), b.tt.y -= row_cross(ky, r1), b.tt.z -= row_cross(kz, r1);
    if (unknown == Unknown::velocity) return;
    const Vec<double> f = 0.5 * impulse, t = cross(r, impulse);
    const double along = dot(f, r1);
    b.tt.x += Four{r1.x * f.x - along, r1.x * f.y, r1.x * f.z, 0};
    b.tt.y += Four{r1.y * f.x, r1.y * f.y - along, r1.y * f.z, 0};
    b.tt.z += Four{r1.z * f.x, r1.z * f.y, r1.z * f.z - along, 0};
    b.ty.x[3] -= t.x, b.ty.y[3] -= t.y, b.ty.z[3] -= t.z;
    b.impulse = b.impulse + impulse;
  }

  /// Eliminates the rotation: mass | bias at the own joint; both go to the node.
  static INLINE Rows eliminate(const ConservingBlock& b, double* node) {
    const Vec<double> x{b.tt.x[0], b.tt.x[1], b.tt.x[2]}, y{b.tt.y[0], b.tt.y[1], b.tt.y[2]},
        z{b.tt.z[0], b.tt.z[1], b.tt.z[2]};
    const Vec<double> yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
    const double per_det = 1 / dot(x, yz);
    const Vec<double> u = per_det * yz, v = per_det * zx, w = per_det * xy;
    const Rows response{u.x * b.ty.x + v.x * b.ty.y + w.x * b.ty.z,
                        u.y * b.ty.x + v.y * b.ty.y + w.y * b.ty.z,
                        u.z * b.ty.x + v.z * b.ty.y + w.z * b.ty.z};
    response.to(node + kResponse);
    const auto less = [&](Four yy, Four yt) {
      return ((yy - yt[0] * response.x) - yt[1] * response.y) - yt[2] * response.z;
    };
    const Rows mass{less(b.yy.x, b.yt.x), less(b.yy.y, b.yt.y), less(b.yy.z, b.yt.z)};
    mass.to(node + kArticulatedMass);
    return mass;
  }

  static INLINE ConservingBlock nothing() {
    const Rows none{all(0), all(0), all(0)};
    return {none, none, none, none, {0, 0, 0}};
  }

  /// Leaves to roots. The impulses at the joints go to the memory.
  template <Unknown unknown>
  void inward() const {
    if (p.is_chain) {
      Rows mass{};
      Vec<double> impulse{0, 0, 0};
      for (std::size_t i = p.count; i-- > 0;) {
        ConservingBlock b = nothing();
        add_own<unknown>(i, b);
        if (i + 1 < p.count) add_child<unknown>(b, mass, impulse, column(p.work, kWorkRows, i + 1));
        impulse = b.impulse;
        if (unknown == Unknown::displacement)
          put(column(p.memory, kMemoryRows, i), kLambda, impulse);
        mass = eliminate(b, p.nodes + kNodeSize * i);
      }
      return;
    }
    for (std::size_t i = 0; i < p.count; ++i) put_block(i, nothing());
    for (std::size_t i = p.count; i-- > 0;) {
      ConservingBlock b = block_at(i);
      add_own<unknown>(i, b);
      if (unknown == Unknown::displacement)
        put(column(p.memory, kMemoryRows, i), kLambda, b.impulse);
      const Rows mass = eliminate(b, p.nodes + kNodeSize * i);
      if (p.parents[i] < 0) continue;
      const auto parent = static_cast<std::size_t>(p.parents[i]);
      ConservingBlock of_parent = block_at(parent);
      add_child<unknown>(of_parent, mass, b.impulse, column(p.work, kWorkRows, i));
      put_block(parent, of_parent);
    }
  }
  INLINE ConservingBlock block_at(std::size_t i) const {
    const double* b = in.blocks + kConservingBlock * i;
    return {Rows::from(b),
            Rows::from(b + 12),
            Rows::from(b + 24),
            Rows::from(b + 36),
            {b[48], b[49], b[50]}};
  }
  INLINE void put_block(std::size_t i, const ConservingBlock& b) const {
    double* to = in.blocks + kConservingBlock * i;
    b.tt.to(to), b.ty.to(to + 12), b.yt.to(to + 24), b.yy.to(to + 36);
    to[48] = b.impulse.x, to[49] = b.impulse.y, to[50] = b.impulse.z;
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
    // The mass of a free root is nearly symmetric; a general solve takes any.
    const Vec<double> x{g[0], g[1], g[2]}, y{g[4], g[5], g[6]}, z{g[8], g[9], g[10]};
    const Vec<double> yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
    const double per_det = 1 / dot(x, yz);
    return per_det * (f.x * yz + f.y * zx + f.z * xy);
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
    if (unknown == Unknown::displacement) put_impulse(m, n, y);
  }
  /// The impulse after this iteration.
  static INLINE void put_impulse(double* m, const double* n, Vec<double> y) {
    const double* g = n + kArticulatedMass;
    put(m, kLambda,
        vec<double>(m, kLambda) + Vec<double>{(g[0] * y.x + g[1] * y.y + g[2] * y.z) - g[3],
                                              (g[4] * y.x + g[5] * y.y + g[6] * y.z) - g[7],
                                              (g[8] * y.x + g[9] * y.y + g[10] * y.z) - g[11]});
  }

  /// One Newton iteration: eliminates, rotates, and fills for what comes next.
  void iterate() {
    inward<Unknown::displacement>();
    const double* held = in.ways;
    Four most = all(0), probe = all(0);
    for (std::size_t i = 0; i < p.count; ++i) outward<Unknown::displacement>(i, held);
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
  }

  /// Newton iterations; false if they do not converge.
  bool solve() {
    for (std::size_t i = 0; i < p.count; i += kLanes) guess(i);
    fill_all<Unknown::displacement>();
    for (int n = 0; n < in.most_iterations; ++n) {
      iterate();
      if (!(largest2 < 1e6)) return false;
      const bool near = largest2 < in.enough * in.enough;
      move_roots();
      if (near) return true;
      fill_all<Unknown::displacement>();
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

  /// Velocities at the end, and everything written back.
  void finish() {
    fill_all<Unknown::velocity>();
    for (std::size_t first = 0, last = 0; first < p.count; first = last) {
      last = first + 1;
      while (last < p.count && p.parents[last] >= 0) ++last;
      if (p.parents[first] == kFree) balance(first, last);
    }
    inward<Unknown::velocity>();
    const double *held = in.anchor_velocities, *target = in.targets;
    for (std::size_t i = 0; i < p.count; i += kLanes) {
      const std::size_t lanes = p.count - i < kLanes ? p.count - i : kLanes;
      for (std::size_t l = 0; l < lanes; ++l)
        outward<Unknown::velocity>(i + l, held), put_joint(i + l, target);
      write_back(i, lanes);
    }
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
    const Vec<Four> w = vec<Four>(m, kTurnBy);
    const Vec<Four> v = keep * (vec<Four>(m, kMove) + cross(w, vec<Four>(k, kEndArm)));
    put(m, kLastTranslation, x - bodies.vec(p.layout.position));
    put(m, kLastRotation, logarithm(mul(q, back(bodies.qua(p.layout.rotation)))));
    put(m, kLambda, all(2 * h) * vec<Four>(m, kLambda));
    bodies.set(p.layout.position, x, lanes);
    bodies.set(p.layout.rotation, Vec<Four>{q.x, q.y, q.z}, lanes);
    bodies.set(p.layout.rotation + 3, q.w, lanes);
    bodies.set(p.layout.velocity, v, lanes);
    bodies.set(p.layout.angular_velocity, keep * w, lanes);
  }

  const double* held_ = nullptr;  // of the next root: displacement of its anchor
};

bool conserve(const IslandView& p, const ConservingInput& in) {
  ConservingStep step{p, in};
  if (!step.solve()) return false;
  step.finish();
  return true;
}

}  // namespace
}  // namespace pantin::detail::articulated

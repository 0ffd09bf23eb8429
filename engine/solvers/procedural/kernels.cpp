// Compiled once for each instruction set with PANTIN_KERNELS naming it.
#include "engine/solvers/procedural/kernels.hpp"

#include <math.h>

#ifndef PANTIN_KERNELS
#define PANTIN_KERNELS baseline
#endif

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed between inlined functions only
#endif

namespace pantin::procedural {
namespace {

// ---------------------------------------------------------------- numbers, four side by side

typedef double Four __attribute__((vector_size(32)));
typedef double FourAnyhow __attribute__((vector_size(32), aligned(8), may_alias));
#define INLINE inline __attribute__((always_inline))

INLINE Four load(const double* p) { return *reinterpret_cast<const FourAnyhow*>(p); }
INLINE void store(double* p, Four v) { *reinterpret_cast<FourAnyhow*>(p) = v; }
INLINE Four all(double x) { return Four{x, x, x, x}; }
INLINE Four root(Four x) {
  return Four{__builtin_sqrt(x[0]), __builtin_sqrt(x[1]), __builtin_sqrt(x[2]),
              __builtin_sqrt(x[3])};
}
INLINE double sum(Four x) { return (x[0] + x[1]) + (x[2] + x[3]); }
INLINE double largest(Four x) {
  const double a = x[0] > x[1] ? x[0] : x[1], b = x[2] > x[3] ? x[2] : x[3];
  return a > b ? a : b;
}
INLINE bool any_not_below(Four x, double bound) {
  return !(x[0] < bound && x[1] < bound && x[2] < bound && x[3] < bound);
}

/// Vectors and quaternions of T: one number, or four bodies' numbers.
template <class T>
struct Vec {
  T x, y, z;
};
template <class T>
struct Qua {
  T x, y, z, w;
};
/// Symmetric 3x3.
template <class T>
struct Sym {
  T xx, xy, xz, yy, yz, zz;
};

template <class T>
INLINE Vec<T> operator+(Vec<T> a, Vec<T> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
INLINE Vec<T> operator-(Vec<T> a, Vec<T> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
INLINE Vec<T> operator*(T s, Vec<T> a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
INLINE T dot(Vec<T> a, Vec<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
INLINE Vec<T> cross(Vec<T> a, Vec<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
INLINE Vec<T> mul(Sym<T> m, Vec<T> v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
template <class T>
INLINE Qua<T> mul(Qua<T> p, Qua<T> q) {
  return {
      p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y, p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x,
      p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w, p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z};
}
template <class T>
INLINE Vec<T> turn(Qua<T> q, Vec<T> v) {
  const Vec<T> u{q.x, q.y, q.z};
  Vec<T> t = cross(u, v);
  t = t + t;
  return v + q.w * t + cross(u, t);
}
template <class T>
INLINE Qua<T> back(Qua<T> q) {
  return {-q.x, -q.y, -q.z, q.w};
}
INLINE Qua<Four> unit(Qua<Four> q) {
  const Four s = 1.0 / root(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {s * q.x, s * q.y, s * q.z, s * q.w};
}

/// The quaternion of a rotation vector. Up to 1 rad by its series, beyond by the library.
INLINE Qua<Four> exponential(Vec<Four> r) {
  const Four t = 0.25 * dot(r, r);  // square of half the angle
  Four c, s;                        // cos(a/2), sin(a/2) / (a/2)
  if (!any_not_below(t, 0.25)) {
    c = all(1.0 / 20922789888000);
    c = c * t - 1.0 / 87178291200;
    c = c * t + 1.0 / 479001600;
    c = c * t - 1.0 / 3628800;
    c = c * t + 1.0 / 40320;
    c = c * t - 1.0 / 720;
    c = c * t + 1.0 / 24;
    c = c * t - 0.5;
    c = c * t + 1.0;
    s = all(1.0 / 355687428096000);
    s = s * t - 1.0 / 1307674368000;
    s = s * t + 1.0 / 6227020800;
    s = s * t - 1.0 / 39916800;
    s = s * t + 1.0 / 362880;
    s = s * t - 1.0 / 5040;
    s = s * t + 1.0 / 120;
    s = s * t - 1.0 / 6;
    s = s * t + 1.0;
  } else {
    for (int l = 0; l < 4; ++l) {
      const double half = ::sqrt(t[l]);
      c[l] = ::cos(half);
      s[l] = half > 1e-8 ? ::sin(half) / half : 1.0;
    }
  }
  s = 0.5 * s;
  return {s * r.x, s * r.y, s * r.z, c};
}

/// The rotation vector of a quaternion of any length, the short way round.
/// atan by the rational approximation of the Cephes library for |x| <= 0.66.
INLINE Vec<Four> logarithm(Qua<Four> q) {
  const Four sign = q.w < 0 ? all(-1.0) : all(1.0);
  const Four w = sign * q.w;
  const Four n2 = q.x * q.x + q.y * q.y + q.z * q.z;
  const Four w2 = w * w;
  Four s;
  if (!any_not_below(n2 - 0.43 * w2, 0.0)) {
    const Four i = 1.0 / w;
    const Four z = n2 * i * i;
    Four p = all(-8.750608600031904122785e-1);
    p = p * z - 1.615753718733365076637e1;
    p = p * z - 7.500855792314704667340e1;
    p = p * z - 1.228866684490136173410e2;
    p = p * z - 6.485021904942025371773e1;
    Four d = z + 2.485846490142306297962e1;
    d = d * z + 1.650270098316988542046e2;
    d = d * z + 4.328810604912902668951e2;
    d = d * z + 4.853903996359136964868e2;
    d = d * z + 1.945506571482613964425e2;
    s = 2.0 * i * (1.0 + z * p / d);
  } else {
    for (int l = 0; l < 4; ++l) {
      const double n = ::sqrt(n2[l]);
      s[l] = n > 1e-150 ? 2 * ::atan2(n, w[l]) / n : 2 / w[l];
    }
  }
  s = sign * s;
  return {s * q.x, s * q.y, s * q.z};
}

// ---------------------------------------------------------------- tables

/// The block of a table that holds column i.
INLINE double* column(double* table, std::size_t rows, std::size_t i) {
  return table + i / kLanes * rows * kLanes + i % kLanes;
}
INLINE const double* column(const double* table, std::size_t rows, std::size_t i) {
  return table + i / kLanes * rows * kLanes + i % kLanes;
}

template <class T>
T read(const double* p);
template <>
INLINE double read<double>(const double* p) {
  return *p;
}
template <>
INLINE Four read<Four>(const double* p) {
  return load(p);
}
INLINE void write(double* p, double v) { *p = v; }
INLINE void write(double* p, Four v) { store(p, v); }

/// Rows of a table at one column (T = double) or at a block of four (T = Four).
template <class T>
INLINE Vec<T> vec(const double* c, std::size_t row) {
  return {read<T>(c + row * kLanes), read<T>(c + (row + 1) * kLanes),
          read<T>(c + (row + 2) * kLanes)};
}
template <class T>
INLINE Qua<T> qua(const double* c, std::size_t row) {
  return {read<T>(c + row * kLanes), read<T>(c + (row + 1) * kLanes),
          read<T>(c + (row + 2) * kLanes), read<T>(c + (row + 3) * kLanes)};
}
template <class T>
INLINE Sym<T> sym(const double* c, std::size_t row) {
  return {read<T>(c + row * kLanes),       read<T>(c + (row + 1) * kLanes),
          read<T>(c + (row + 2) * kLanes), read<T>(c + (row + 3) * kLanes),
          read<T>(c + (row + 4) * kLanes), read<T>(c + (row + 5) * kLanes)};
}
template <class T>
INLINE T num(const double* c, std::size_t row) {
  return read<T>(c + row * kLanes);
}
template <class T>
INLINE void put(double* c, std::size_t row, Vec<T> v) {
  write(c + row * kLanes, v.x), write(c + (row + 1) * kLanes, v.y),
      write(c + (row + 2) * kLanes, v.z);
}
template <class T>
INLINE void put(double* c, std::size_t row, Qua<T> q) {
  write(c + row * kLanes, q.x), write(c + (row + 1) * kLanes, q.y),
      write(c + (row + 2) * kLanes, q.z), write(c + (row + 3) * kLanes, q.w);
}
template <class T>
INLINE void put(double* c, std::size_t row, Sym<T> m) {
  write(c + row * kLanes, m.xx), write(c + (row + 1) * kLanes, m.xy),
      write(c + (row + 2) * kLanes, m.xz), write(c + (row + 3) * kLanes, m.yy),
      write(c + (row + 4) * kLanes, m.yz), write(c + (row + 5) * kLanes, m.zz);
}

/// Four bodies' numbers out of the component store.
struct FourBodies {
  double* b[4];
  FourBodies(const Packed& p, std::size_t i) {
    for (int l = 0; l < 4; ++l)
      b[l] = p.bodies + p.slots[i + static_cast<std::size_t>(l)] * p.layout.stride;
  }
  INLINE Four num(std::size_t at) const { return Four{b[0][at], b[1][at], b[2][at], b[3][at]}; }
  INLINE Vec<Four> vec(std::size_t at) const { return {num(at), num(at + 1), num(at + 2)}; }
  INLINE Qua<Four> qua(std::size_t at) const {
    return {num(at), num(at + 1), num(at + 2), num(at + 3)};
  }
  INLINE void set(std::size_t at, Four v, std::size_t lanes) const {
    for (std::size_t l = 0; l < lanes; ++l) b[l][at] = v[l];
  }
  INLINE void set(std::size_t at, Vec<Four> v, std::size_t lanes) const {
    set(at, v.x, lanes), set(at + 1, v.y, lanes), set(at + 2, v.z, lanes);
  }
};

/// World vector of principal `moments` times the body-frame part of v: I v or its like.
INLINE Vec<Four> times_inertia(Qua<Four> q, Vec<Four> moments, Vec<Four> v) {
  const Vec<Four> b = turn(back(q), v);
  return turn(q, Vec<Four>{moments.x * b.x, moments.y * b.y, moments.z * b.z});
}
INLINE Vec<Four> over_inertia(Qua<Four> q, Vec<Four> moments, Vec<Four> v) {
  const Vec<Four> b = turn(back(q), v);
  return turn(q, Vec<Four>{b.x / moments.x, b.y / moments.y, b.z / moments.z});
}

/// Lanes below `count` as ones, the padding as zeros.
INLINE Four mask(std::size_t i, std::size_t count) {
  Four m = all(1.0);
  for (std::size_t l = 0; l < 4; ++l)
    if (i + l >= count) m[l] = 0;
  return m;
}

// ---------------------------------------------------------------- update stage

/// Spin at the end of a turn `start + w reach` that keeps the angular momentum `l`: two fixed-point
/// rounds on w = I(q(w))^-1 l.
INLINE Vec<Four> spin_keeping(Vec<Four> l, Qua<Four> q, Vec<Four> moments, Vec<Four> start,
                              Four reach) {
  Vec<Four> w = over_inertia(q, moments, l);
  for (int round = 0; round < 2; ++round)
    w = over_inertia(mul(exponential(start + reach * w), q), moments, l);
  return w;
}

template <Rule rule, bool forced>
StartSums predict_by(const Packed& p, const PredictInput& in) {
  const Four h = all(in.h), third = all(1.0 / 3), two_thirds_h = all(2.0 / 3 * in.h);
  const Vec<Four> g{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
  Four kinetic = all(0), potential = all(0), damped = all(0);
  Vec<Four> momentum{all(0), all(0), all(0)};
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    const double* c = column(p.constants, kConstantRows, i);
    double* m = column(p.memory, kMemoryRows, i);
    double* k = column(p.work, kWorkRows, i);
    const FourBodies bodies(p, i);
    const Four mass = num<Four>(c, kMass), drag = num<Four>(c, kDrag);
    const Vec<Four> moments = vec<Four>(c, kInertia);
    const Vec<Four> x = bodies.vec(p.layout.position), v = bodies.vec(p.layout.velocity);
    const Vec<Four> spin = bodies.vec(p.layout.spin);
    const Qua<Four> q = bodies.qua(p.layout.rotation);
    Vec<Four> a = num<Four>(c, kGravityScale) * g;
    const Four here = mask(i, p.count) * mass;
    potential -= here * dot(a, x);
    Vec<Four> torque{all(0), all(0), all(0)};
    if (forced) {
      const double* f = column(p.forces, 6, i);
      a = a + vec<Four>(f, 0), torque = vec<Four>(f, 3);
    }
    const Vec<Four> l = times_inertia(q, moments, spin);
    const Four energy = 0.5 * (here * dot(v, v) + mask(i, p.count) * dot(l, spin));
    kinetic += energy;
    momentum = momentum + here * v;

    Vec<Four> slide, w, r;
    if (rule == Rule::bdf2) {
      const Four brake = 1.0 / (1.0 + two_thirds_h * drag);
      damped += energy * (1.0 - brake * brake);
      const Vec<Four> v_before = vec<Four>(m, kVelocityBefore);
      const Vec<Four> l_before = vec<Four>(m, kSpinMomentumBefore);
      const Vec<Four> v_star = brake * (third * (all(4) * v - v_before) + two_thirds_h * a);
      const Vec<Four> l_star = brake * (third * (all(4) * l - l_before) + two_thirds_h * torque);
      slide = third * vec<Four>(m, kLastSlide) + two_thirds_h * v_star;
      const Vec<Four> start = third * vec<Four>(m, kLastTurn);
      w = spin_keeping(l_star, q, moments, start, two_thirds_h);
      r = start + two_thirds_h * w;
    } else {
      Four keep;
      for (int lane = 0; lane < 4; ++lane) keep[lane] = ::exp(-drag[lane] * in.h);
      damped += energy * (1.0 - keep * keep);
      const Four push = in.first ? 0.5 * h : h;
      slide = h * (keep * v + push * a);
      if (rule == Rule::verlet) {
        w = keep * spin;
        if (forced) w = w + push * over_inertia(q, moments, torque);
      } else {
        const Vec<Four> nothing{all(0), all(0), all(0)};
        const Vec<Four> kept =
            rule == Rule::midpoint
                ? times_inertia(mul(exponential(all(-0.5) * h * spin), q), moments, spin)
                : l;
        w = spin_keeping(keep * kept + push * torque, q, moments, nothing,
                         rule == Rule::midpoint ? 0.5 * h : push);
      }
      r = h * w;
    }
    put(k, kPosition, x + slide);
    put(k, kRotation, unit(mul(exponential(r), q)));
    put(k, kSpinStar, w);
    put(m, kVelocityBefore, v);
    put(m, kSpinMomentumBefore, l);
  }
  return {sum(kinetic),
          sum(potential),
          sum(damped),
          {sum(momentum.x), sum(momentum.y), sum(momentum.z)}};
}

StartSums predict(const Packed& p, const PredictInput& in) {
  const bool f = p.forces != nullptr;
  switch (in.rule) {
    case Rule::verlet:
      return f ? predict_by<Rule::verlet, true>(p, in) : predict_by<Rule::verlet, false>(p, in);
    case Rule::midpoint:
      return f ? predict_by<Rule::midpoint, true>(p, in) : predict_by<Rule::midpoint, false>(p, in);
    case Rule::euler:
      return f ? predict_by<Rule::euler, true>(p, in) : predict_by<Rule::euler, false>(p, in);
    case Rule::bdf2:
      return f ? predict_by<Rule::bdf2, true>(p, in) : predict_by<Rule::bdf2, false>(p, in);
  }
  return {};
}

// ---------------------------------------------------------------- adjust stage

void arms(const Packed& p, std::size_t position_row, std::size_t rotation_row) {
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    const double* c = column(p.constants, kConstantRows, i);
    double* k = column(p.work, kWorkRows, i);
    const Qua<Four> q = qua<Four>(k, rotation_row);
    const Vec<Four> x = vec<Four>(k, position_row);
    const Vec<Four> arm = turn(q, vec<Four>(c, kOwnAnchor));
    put(k, kArm, arm);

    // R diag(I) R^T, from the columns of R.
    const Vec<Four> m = vec<Four>(c, kInertia);
    const Vec<Four> ex = turn(q, Vec<Four>{all(1), all(0), all(0)});
    const Vec<Four> ey = turn(q, Vec<Four>{all(0), all(1), all(0)});
    const Vec<Four> ez = cross(ex, ey);
    const Vec<Four> mx = m.x * ex, my = m.y * ey, mz = m.z * ez;
    put(k, kWorldInertia,
        Sym<Four>{mx.x * ex.x + my.x * ey.x + mz.x * ez.x, mx.x * ex.y + my.x * ey.y + mz.x * ez.y,
                  mx.x * ex.z + my.x * ey.z + mz.x * ez.z, mx.y * ex.y + my.y * ey.y + mz.y * ez.y,
                  mx.y * ex.z + my.y * ey.z + mz.y * ez.z,
                  mx.z * ex.z + my.z * ey.z + mz.z * ez.z});

    // The parents' poses, lane by lane; roots have none and keep their own.
    Qua<Four> pq = q;
    Vec<Four> px = x;
    for (std::size_t l = 0; l < 4; ++l) {
      const std::int32_t parent = p.parents[i + l];
      if (parent < 0) continue;
      const double* o = column(p.work, kWorkRows, static_cast<std::size_t>(parent));
      pq.x[l] = o[rotation_row * kLanes], pq.y[l] = o[(rotation_row + 1) * kLanes];
      pq.z[l] = o[(rotation_row + 2) * kLanes], pq.w[l] = o[(rotation_row + 3) * kLanes];
      px.x[l] = o[position_row * kLanes], px.y[l] = o[(position_row + 1) * kLanes];
      px.z[l] = o[(position_row + 2) * kLanes];
    }
    const Vec<Four> parent_arm = turn(pq, vec<Four>(c, kParentAnchor));
    put(k, kParentArm, parent_arm);
    put(k, kGap, (px + parent_arm) - (x + arm));
  }
}

/// LDL^T of a symmetric positive definite 3x3, pivots floored.
struct Factor {
  double i0, i1, i2, l10, l20, l21;
  INLINE explicit Factor(const Sym<double>& a) {
    const double floor = 4 * 2.220446049250313e-16 * (a.xx + a.yy + a.zz);
    i0 = 1 / (a.xx > floor ? a.xx : floor);
    l10 = a.xy * i0, l20 = a.xz * i0;
    const double d1 = a.yy - l10 * a.xy, t = a.yz - l20 * a.xy;
    i1 = 1 / (d1 > floor ? d1 : floor);
    l21 = t * i1;
    const double d2 = a.zz - l20 * a.xz - l21 * t;
    i2 = 1 / (d2 > floor ? d2 : floor);
  }
  INLINE Vec<double> solve(Vec<double> b) const {
    const double y1 = b.y - l10 * b.x, y2 = b.z - l20 * b.x - l21 * y1;
    const double z2 = y2 * i2, z1 = y1 * i1 - l21 * z2;
    return {b.x * i0 - l10 * z1 - l20 * z2, z1, z2};
  }
};

/// Rows of a general 3x3.
struct Mat {
  Vec<double> x, y, z;
};

/// What a body and everything outboard of it asks of its own joint, before its turn is eliminated:
/// A_yy, A_ty, A_tt, g_y, g_t of the method.
struct Block {
  Sym<double> yy, tt;
  Mat ty;
  Vec<double> gy, gt;
};

INLINE void add(Sym<double>& a, const Sym<double>& b) {
  a.xx += b.xx, a.xy += b.xy, a.xz += b.xz, a.yy += b.yy, a.yz += b.yz, a.zz += b.zz;
}

/// Stiffness of a joint under tension t along `arm`: t (1 - r r^T / r^2), so that the direction of
/// the force turns with the body within the step.
INLINE void add_tension(Sym<double>& tt, double t, Vec<double> arm) {
  const double r2 = dot(arm, arm);
  if (!(t > 0) || !(r2 > 0)) return;
  const double s = t / r2;
  tt.xx += t - s * arm.x * arm.x, tt.xy -= s * arm.x * arm.y, tt.xz -= s * arm.x * arm.z;
  tt.yy += t - s * arm.y * arm.y, tt.yz -= s * arm.y * arm.z, tt.zz += t - s * arm.z * arm.z;
}

/// Adds a child, felt as mass M and load g at its joint, to the block of its parent.
INLINE void add_child(Block& b, const Sym<double>& m, Vec<double> load, Vec<double> gap,
                      Vec<double> rho) {
  const Vec<double> f = load - mul(m, gap);
  add(b.yy, m);
  // K(rho) M, row by row; K(a) b = a x b.
  const Mat km{
      {rho.y * m.xz - rho.z * m.xy, rho.y * m.yz - rho.z * m.yy, rho.y * m.zz - rho.z * m.yz},
      {rho.z * m.xx - rho.x * m.xz, rho.z * m.xy - rho.x * m.yz, rho.z * m.xz - rho.x * m.zz},
      {rho.x * m.xy - rho.y * m.xx, rho.x * m.yy - rho.y * m.xy, rho.x * m.yz - rho.y * m.xz}};
  b.ty.x = b.ty.x + km.x, b.ty.y = b.ty.y + km.y, b.ty.z = b.ty.z + km.z;
  // -K M K: each row of K M crossed the other way.
  const Vec<double> rx = cross(rho, km.x), ry = cross(rho, km.y), rz = cross(rho, km.z);
  add(b.tt, Sym<double>{rx.x, rx.y, rx.z, ry.y, ry.z, rz.z});
  b.gy = b.gy + f;
  b.gt = b.gt + cross(rho, f);
}

INLINE Block own_block(const double* c, const double* k, Vec<double> e) {
  const double mass = num<double>(c, kMass);
  const Sym<double> in = sym<double>(k, kWorldInertia);
  const Vec<double> me = mass * e;
  const double e2 = dot(me, e);
  return {{mass, 0, 0, mass, 0, mass},
          {in.xx + e2 - me.x * e.x, in.xy - me.x * e.y, in.xz - me.x * e.z, in.yy + e2 - me.y * e.y,
           in.yz - me.y * e.z, in.zz + e2 - me.z * e.z},
          {{0, -me.z, me.y}, {me.z, 0, -me.x}, {-me.y, me.x, 0}},
          {0, 0, 0},
          {0, 0, 0}};
}

/// Eliminates the turn of a body: what its joint feels, and how it will answer.
INLINE void eliminate(const Block& b, double* k, double* inverse, Sym<double>& group,
                      Vec<double>& load) {
  const Factor f(b.tt);
  const Vec<double> c0 = f.solve({b.ty.x.x, b.ty.y.x, b.ty.z.x});
  const Vec<double> c1 = f.solve({b.ty.x.y, b.ty.y.y, b.ty.z.y});
  const Vec<double> c2 = f.solve({b.ty.x.z, b.ty.y.z, b.ty.z.z});
  const Vec<double> z = f.solve(b.gt);
  const auto t0 = [&](Vec<double> v) { return b.ty.x.x * v.x + b.ty.y.x * v.y + b.ty.z.x * v.z; };
  const auto t1 = [&](Vec<double> v) { return b.ty.x.y * v.x + b.ty.y.y * v.y + b.ty.z.y * v.z; };
  const auto t2 = [&](Vec<double> v) { return b.ty.x.z * v.x + b.ty.y.z * v.y + b.ty.z.z * v.z; };
  group = {b.yy.xx - t0(c0), b.yy.xy - t0(c1), b.yy.xz - t0(c2),
           b.yy.yy - t1(c1), b.yy.yz - t1(c2), b.yy.zz - t2(c2)};
  load = {b.gy.x - t0(z), b.gy.y - t1(z), b.gy.z - t2(z)};
  put(k, kGroupMass, group), put(k, kGroupLoad, load);
  put(k, kAnswer, Vec<double>{c0.x, c1.x, c2.x});
  put(k, kAnswer + 3, Vec<double>{c0.y, c1.y, c2.y});
  put(k, kAnswer + 6, Vec<double>{c0.z, c1.z, c2.z});
  put(k, kRest, z);
  if (!inverse) return;
  const Vec<double> i0 = f.solve({1, 0, 0}), i1 = f.solve({0, 1, 0}), i2 = f.solve({0, 0, 1});
  inverse[0] = i0.x, inverse[1] = i1.x, inverse[2] = i2.x;
  inverse[3] = i1.y, inverse[4] = i2.y, inverse[5] = i2.z;
}

/// A chain: the only child is the next column, so its group stays in registers.
void gather_chain(const Packed& p, bool tension) {
  Sym<double> group{};
  Vec<double> load{};
  for (std::size_t i = p.count; i-- > 0;) {
    const double* c = column(p.constants, kConstantRows, i);
    double* k = column(p.work, kWorkRows, i);
    const Vec<double> arm = vec<double>(k, kArm), e{-arm.x, -arm.y, -arm.z};
    Block b = own_block(c, k, e);
    if (i + 1 < p.count) {
      const double* child = column(p.work, kWorkRows, i + 1);
      const Vec<double> out = vec<double>(child, kParentArm);
      add_child(b, group, load, vec<double>(child, kGap), out + e);
      if (tension) {
        const Vec<double> l = vec<double>(column(p.memory, kMemoryRows, i + 1), kLoad);
        add_tension(b.tt, -dot(l, out), out);
      }
    }
    if (tension && p.parents[i] != kFree)
      add_tension(b.tt, dot(vec<double>(column(p.memory, kMemoryRows, i), kLoad), arm), arm);
    eliminate(b, k, p.inverse ? p.inverse + 6 * i : nullptr, group, load);
  }
}

void fill_blocks(const Packed& p, double* blocks) {
  static_assert(sizeof(Block) == kBlockSize * sizeof(double));
  for (std::size_t i = 0; i < p.count; ++i) {
    const double* k = column(p.work, kWorkRows, i);
    const Vec<double> arm = vec<double>(k, kArm);
    *reinterpret_cast<Block*>(blocks + kBlockSize * i) =
        own_block(column(p.constants, kConstantRows, i), k, Vec<double>{-arm.x, -arm.y, -arm.z});
  }
}

/// A tree: children add themselves to their parent's block as they are finished.
void gather_tree(const Packed& p, bool tension, double* blocks) {
  for (std::size_t i = p.count; i-- > 0;) {
    double* k = column(p.work, kWorkRows, i);
    Block& b = *reinterpret_cast<Block*>(blocks + kBlockSize * i);
    const Vec<double> l = vec<double>(column(p.memory, kMemoryRows, i), kLoad);
    const Vec<double> arm = vec<double>(k, kArm);
    if (tension && p.parents[i] != kFree) add_tension(b.tt, dot(l, arm), arm);
    Sym<double> group;
    Vec<double> load;
    eliminate(b, k, p.inverse ? p.inverse + 6 * i : nullptr, group, load);
    if (p.parents[i] < 0) continue;
    const auto parent = static_cast<std::size_t>(p.parents[i]);
    Block& pb = *reinterpret_cast<Block*>(blocks + kBlockSize * parent);
    const Vec<double> out = vec<double>(k, kParentArm);
    const Vec<double> parent_arm = vec<double>(column(p.work, kWorkRows, parent), kArm);
    add_child(pb, group, load, vec<double>(k, kGap), out - parent_arm);
    if (tension) add_tension(pb.tt, -dot(l, out), out);
  }
}

/// How a turned body carries a vector: v -> v + s (w (u x v) + u x (u x v)).
struct Carry {
  Vec<double> u;
  double w, s;
  INLINE Vec<double> operator()(Vec<double> v) const {
    const Vec<double> t = cross(u, v);
    return v + s * (w * t + cross(u, t));
  }
};

INLINE double bounded(double x) { return x < 0 ? -x : x; }

/// Walks from the roots outwards; `turn_of(i, k, goal)` gives the turn that body i makes when its
/// own joint goes to `goal`.
template <bool chain, class TurnOf>
INLINE void outwards(const Packed& p, const double* targets, std::size_t position_row,
                     const TurnOf& turn_of) {
  Vec<double> goal{}, arm{};
  Carry carry{{0, 0, 0}, 1, 2};
  for (std::size_t i = 0; i < p.count; ++i) {
    double* k = column(p.work, kWorkRows, i);
    const std::int32_t parent = p.parents[i];
    if (parent < 0) {
      goal = {targets[0], targets[1], targets[2]};
      targets += 3;
    } else {
      if (!chain) {
        const double* o = column(p.work, kWorkRows, static_cast<std::size_t>(parent));
        goal = vec<double>(o, kAttach), arm = vec<double>(o, kArm);
        const Qua<double> q = qua<double>(o, kTurn);
        carry = {{q.x, q.y, q.z}, q.w, 2 / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)};
      }
      goal = goal + carry(vec<double>(k, kParentArm) - arm);
    }
    arm = vec<double>(k, kArm);
    const Vec<double> x = vec<double>(k, position_row);
    Qua<double> q;
    if (parent == kFree) {
      goal = x;  // a free root is placed by turn_of
    }
    q = turn_of(i, k, x, arm, goal);
    put(k, kTurn, q), put(k, kAttach, goal);
    if (chain) carry = {{q.x, q.y, q.z}, q.w, 2 / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)};
  }
}

template <bool chain>
void close_by(const Packed& p, const double* targets, std::size_t position_row) {
  outwards<chain>(p, targets, position_row,
                  [&](std::size_t i, double* k, Vec<double> x, Vec<double> arm, Vec<double>& goal) {
                    const Sym<double> m = sym<double>(k, kGroupMass);
                    const Vec<double> g = vec<double>(k, kGroupLoad);
                    Vec<double> y = goal - (x + arm), load{0, 0, 0};
                    if (p.parents[i] == kFree) {
                      y = Factor(m).solve(g);
                      goal = x + y;
                    } else {
                      load = mul(m, y) - g;
                      if (!(dot(load, load) < 1e36)) load = {0, 0, 0};
                    }
                    put(column(p.memory, kMemoryRows, i), kLoad, load);
                    const Vec<double> z = vec<double>(k, kRest);
                    Vec<double> d{z.x - dot(vec<double>(k, kAnswer), y),
                                  z.y - dot(vec<double>(k, kAnswer + 3), y),
                                  z.z - dot(vec<double>(k, kAnswer + 6), y)};
                    // The angle stays below 148 degrees; a number that is none turns nothing.
                    const double most = bounded(d.x) + bounded(d.y) + bounded(d.z);
                    if (!(most < 4)) {
                      double far = bounded(d.x) > bounded(d.y) ? bounded(d.x) : bounded(d.y);
                      if (bounded(d.z) > far) far = bounded(d.z);
                      if (!(most < 1e30))
                        d = {0, 0, 0};
                      else if (far > 4)
                        d = (4 / far) * d;
                    }
                    return Qua<double>{0.5 * d.x, 0.5 * d.y, 0.5 * d.z, 1};
                  });
}

void close(const Packed& p, const double* targets, std::size_t position_row) {
  if (p.is_chain)
    close_by<true>(p, targets, position_row);
  else
    close_by<false>(p, targets, position_row);
}

/// Least displacement, scaled by |r x s|^2 so that nothing is divided: the quaternion
/// (Z + C, S) with S = m r x s, C = beta a^T I a + m r.(r + s), Z = sqrt(C^2 + S^2).
template <bool chain>
void sweep_by(const Packed& p, const double* targets, std::size_t position_row, double stiffness) {
  outwards<chain>(p, targets, position_row,
                  [&](std::size_t i, double* k, Vec<double> x, Vec<double> arm, Vec<double>& goal) {
                    if (p.parents[i] == kFree) return Qua<double>{0, 0, 0, 1};
                    const double mass = num<double>(column(p.constants, kConstantRows, i), kMass);
                    const Vec<double> to = goal - x;       // r + s
                    const Vec<double> a = cross(arm, to);  // r x s = r x (r + s)
                    const double a2 = dot(a, a);
                    const double along = dot(arm, to);
                    if (!(a2 > 1e-100)) return Qua<double>{0, 0, 0, 1};
                    const double c = stiffness * dot(a, mul(sym<double>(k, kWorldInertia), a)) +
                                     mass * a2 * along;
                    const Vec<double> s = (mass * a2) * a;
                    const double s2 = dot(s, s);
                    const double z = __builtin_sqrt(c * c + s2);
                    return Qua<double>{s.x, s.y, s.z, c >= 0 ? z + c : s2 / (z - c)};
                  });
}

void sweep(const Packed& p, const double* targets, std::size_t position_row, double stiffness) {
  if (p.is_chain)
    sweep_by<true>(p, targets, position_row, stiffness);
  else
    sweep_by<false>(p, targets, position_row, stiffness);
}

void commit(const Packed& p, std::size_t from) {
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    double* k = column(p.work, kWorkRows, i);
    const Qua<Four> q = unit(mul(qua<Four>(k, kTurn), qua<Four>(k, from)));
    const Vec<Four> arm = turn(q, vec<Four>(column(p.constants, kConstantRows, i), kOwnAnchor));
    put(k, kFinalRotation, q);
    put(k, kFinalPosition, vec<Four>(k, kAttach) - arm);
  }
}

// ---------------------------------------------------------------- velocities

template <Rule rule>
EndSums finish_by(const Packed& p, const FinishInput& in) {
  const double per = 1 / in.h;
  const Vec<Four> g{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
  const double calm2 = in.calm_angle * in.calm_angle;
  Four kinetic = all(0), potential = all(0), work = all(0), turned = all(0);
  Vec<Four> momentum{all(0), all(0), all(0)};
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    const std::size_t lanes = p.count - i < kLanes ? p.count - i : kLanes;
    const double* c = column(p.constants, kConstantRows, i);
    double* m = column(p.memory, kMemoryRows, i);
    const double* k = column(p.work, kWorkRows, i);
    const FourBodies bodies(p, i);
    const Four mass = num<Four>(c, kMass);
    const Vec<Four> moments = vec<Four>(c, kInertia);
    const Vec<Four> x = vec<Four>(k, kFinalPosition);
    const Qua<Four> q = qua<Four>(k, kFinalRotation);
    const Vec<Four> slide = x - bodies.vec(p.layout.position);
    const Vec<Four> turned_by = logarithm(mul(q, back(bodies.qua(p.layout.rotation))));
    const Four turned2 = mask(i, p.count) * dot(turned_by, turned_by);
    turned = turned2 > turned ? turned2 : turned;

    Vec<Four> v, w, l;
    if (rule == Rule::verlet) {
      v = all(per) * slide, w = all(per) * turned_by;
      l = times_inertia(q, moments, w);
    } else if (in.first) {
      // Trapezoid from the given velocities; predict() left them in the memory.
      v = all(2 * per) * slide - vec<Four>(m, kVelocityBefore);
      w = all(2 * per) * turned_by - bodies.vec(p.layout.spin);
      l = times_inertia(q, moments, w);
    } else {
      // Differencing rotation vectors would cost an order in space: the turn that the joints forced
      // is an impulse on the predicted angular momentum.
      const double rate = rule == Rule::bdf2 ? 1.5 * per : per;
      v = rule == Rule::bdf2 ? all(0.5 * per) * (all(3) * slide - vec<Four>(m, kLastSlide))
                             : all(per) * slide;
      const Qua<Four> predicted = qua<Four>(k, kRotation);
      const Vec<Four> forced = logarithm(mul(q, back(predicted)));
      l = times_inertia(predicted, moments, vec<Four>(k, kSpinStar) + all(rate) * forced);
      w = over_inertia(q, moments, l);
      if (rule == Rule::euler && any_not_below(turned2, calm2)) {
        // A large turn: its own rate is bounded, the impulse is not.
        const Vec<Four> plain = all(per) * turned_by;
        w.x = turned2 >= calm2 ? plain.x : w.x;
        w.y = turned2 >= calm2 ? plain.y : w.y;
        w.z = turned2 >= calm2 ? plain.z : w.z;
        l = times_inertia(q, moments, w);
      }
    }
    put(m, kLastSlide, slide), put(m, kLastTurn, turned_by);
    bodies.set(p.layout.position, x, lanes);
    bodies.set(p.layout.rotation, Vec<Four>{q.x, q.y, q.z}, lanes);
    bodies.set(p.layout.rotation + 3, q.w, lanes);
    bodies.set(p.layout.velocity, v, lanes);
    bodies.set(p.layout.spin, w, lanes);

    const Four here = mask(i, p.count);
    const Vec<Four> a = num<Four>(c, kGravityScale) * g;
    kinetic += 0.5 * here * (mass * dot(v, v) + dot(l, w));
    potential -= here * mass * dot(a, x);
    momentum = momentum + (here * mass) * v;
    if (p.forces) {
      const double* f = column(p.forces, 6, i);
      work += here * (mass * dot(vec<Four>(f, 0), slide) + dot(vec<Four>(f, 3), turned_by));
    }
  }
  return {sum(kinetic),
          sum(potential),
          sum(work),
          {sum(momentum.x), sum(momentum.y), sum(momentum.z)},
          largest(turned)};
}

EndSums finish(const Packed& p, const FinishInput& in) {
  switch (in.rule) {
    case Rule::verlet:
    case Rule::midpoint:
      return finish_by<Rule::verlet>(p, in);
    case Rule::euler:
      return finish_by<Rule::euler>(p, in);
    case Rule::bdf2:
      return finish_by<Rule::bdf2>(p, in);
  }
  return {};
}

void scale(const Packed& p, double factor, const double* mean) {
  for (std::size_t i = 0; i < p.count; ++i) {
    double* b = p.bodies + p.slots[i] * p.layout.stride;
    for (std::size_t n = 0; n < 3; ++n) {
      double& v = b[p.layout.velocity + n];
      v = mean[n] + factor * (v - mean[n]);
      b[p.layout.spin + n] *= factor;
    }
  }
}

#define PANTIN_TEXT_OF(word) #word
#define PANTIN_TEXT(word) PANTIN_TEXT_OF(word)

}  // namespace

#define PANTIN_JOINED_OF(a, b) a##b
#define PANTIN_JOINED(a, b) PANTIN_JOINED_OF(a, b)
extern const Kernels PANTIN_JOINED(kernels_, PANTIN_KERNELS);
const Kernels PANTIN_JOINED(kernels_, PANTIN_KERNELS) = {PANTIN_TEXT(PANTIN_KERNELS),
                                                         predict,
                                                         arms,
                                                         gather_chain,
                                                         fill_blocks,
                                                         gather_tree,
                                                         close,
                                                         sweep,
                                                         commit,
                                                         finish,
                                                         scale};

}  // namespace pantin::procedural

// Compiled once per instruction set; PANTIN_KERNELS is its name.
#include "engine/solvers/articulated/kernels.hpp"

#include <math.h>

#include "engine/base/lanes.hpp"

#ifndef PANTIN_KERNELS
#define PANTIN_KERNELS baseline
#endif

namespace pantin::detail::articulated {
namespace {

// ---------------------------------------------------------------- numbers, four side by side

#define INLINE PANTIN_INLINE

INLINE Four load(const double* p) { return load_four(p); }
INLINE void store(double* p, Four v) { store_four(p, v); }
INLINE Four all(double x) { return Four{x, x, x, x}; }
INLINE Four root(Four x) { return Four{::sqrt(x[0]), ::sqrt(x[1]), ::sqrt(x[2]), ::sqrt(x[3])}; }
INLINE double sum(Four x) { return (x[0] + x[1]) + (x[2] + x[3]); }
INLINE double largest(Four x) {
  const double a = x[0] > x[1] ? x[0] : x[1], b = x[2] > x[3] ? x[2] : x[3];
  return a > b ? a : b;
}
INLINE bool any_not_below(Four x, double bound) {
  const auto below = x < all(bound);
  return (below[0] & below[1] & below[2] & below[3]) == 0;
}

/// Vectors and quaternions of T: a scalar, or the values of four bodies.
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
INLINE Vec<T> rotated(Qua<T> q, Vec<T> v) {
  const Vec<T> u{q.x, q.y, q.z};
  Vec<T> t = cross(u, v);
  t = t + t;
  return v + q.w * t + cross(u, t);
}
template <class T>
INLINE Qua<T> back(Qua<T> q) {
  return {-q.x, -q.y, -q.z, q.w};
}
INLINE Four norm2(Qua<Four> q) { return q.x * q.x + q.y * q.y + (q.z * q.z + q.w * q.w); }
INLINE Qua<Four> scaled(Four s, Qua<Four> q) { return {s * q.x, s * q.y, s * q.z, s * q.w}; }
INLINE Qua<Four> unit(Qua<Four> q) { return scaled(1.0 / root(norm2(q)), q); }
/// The same for a quaternion that is normalised up to rounding: no root, no division.
INLINE Qua<Four> unit_again(Qua<Four> q) {
  const Four off = norm2(q) - 1.0;
  if (any_not_below(off * off, 1e-12)) return unit(q);
  return scaled((0.375 * off - 0.5) * off + 1.0, q);
}

/// cos(a/2) and sin(a/2)/(a/2) of four angles up to 1 rad, from t = (a/2)^2. Taylor series, in
/// pairs so that the additions do not wait for one another.
INLINE Four cosine_of(Four t) {
  const Four t2 = t * t, t4 = t2 * t2;
  return ((1.0 - t * (1.0 / 2)) + t2 * (1.0 / 24 - t * (1.0 / 720))) +
         t4 * ((1.0 / 40320 - t * (1.0 / 3628800)) +
               t2 * (1.0 / 479001600 - t * (1.0 / 87178291200)));
}
INLINE Four sine_part_of(Four t) {
  const Four t2 = t * t, t4 = t2 * t2;
  return ((1.0 - t * (1.0 / 6)) + t2 * (1.0 / 120 - t * (1.0 / 5040))) +
         t4 * ((1.0 / 362880 - t * (1.0 / 39916800)) +
               t2 * (1.0 / 6227020800 - t * (1.0 / 1307674368000)));
}

/// The quaternion of a rotation vector: by series up to 1 rad, by doubling an eighth of the angle
/// up to 8 rad, by the library beyond.
INLINE Qua<Four> exponential(Vec<Four> r) {
  const Four t = 0.25 * dot(r, r);
  if (!any_not_below(t, 0.25)) {
    const Four s = 0.5 * sine_part_of(t);
    return {s * r.x, s * r.y, s * r.z, cosine_of(t)};
  }
  if (!any_not_below(t, 16.0)) {
    const Four part = (1.0 / 64) * t;
    const Four s = (1.0 / 16) * sine_part_of(part);
    Qua<Four> q{s * r.x, s * r.y, s * r.z, cosine_of(part)};
    for (int doubling = 0; doubling < 3; ++doubling) {
      const Four w = q.w + q.w;
      q = {w * q.x, w * q.y, w * q.z, w * q.w - 1.0};
    }
    return q;
  }
  Four c, s;
  for (int l = 0; l < 4; ++l) {
    const double half = ::sqrt(t[l]);
    c[l] = ::cos(half);
    s[l] = half > 1e-8 ? 0.5 * ::sin(half) / half : 0.5;
  }
  return {s * r.x, s * r.y, s * r.z, c};
}

/// A quarter of the angle from its tangent in [0, 1]: atan by the rational approximation of the
/// Cephes library, which holds to 0.66, and beyond from a quarter of pi.
INLINE Four arc_tangent(Four t) {
  const auto large = t > all(0.66);
  const Four x = choose(large, (t - 1.0) / (t + 1.0), t);
  const Four z = x * x;
  const Four p = ((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
                  7.500855792314704667340e1) *
                     z -
                 1.228866684490136173410e2;
  const Four d = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                   4.328810604912902668951e2) *
                      z +
                  4.853903996359136964868e2) *
                     z +
                 1.945506571482613964425e2;
  const Four a = x + x * z * (p * z - 6.485021904942025371773e1) / d;
  return choose(large, a + 0.78539816339744830962, a);
}

/// The shortest rotation vector of a unit quaternion: 2 asin(n)/n times its vector part, by the
/// series up to 0.4 rad, beyond by the tangent of a quarter of the angle.
INLINE Vec<Four> logarithm(Qua<Four> q) {
  const Four sign = choose(q.w < 0.0, all(-1.0), all(1.0));
  const Four z = q.x * q.x + q.y * q.y + q.z * q.z;
  Four s;
  if (!any_not_below(z, 0.04)) {
    const Four z2 = z * z, z4 = z2 * z2, z8 = z4 * z4;
    s = ((1.0 + z * (1.0 / 6)) + z2 * (3.0 / 40 + z * (5.0 / 112))) +
        z4 * ((35.0 / 1152 + z * (63.0 / 2816)) + z2 * (231.0 / 13312 + z * (143.0 / 10240))) +
        z8 * ((6435.0 / 557056 + z * (12155.0 / 1245184)) + z2 * (46189.0 / 5505024));
    s = 2.0 * sign * s;
  } else {
    const Four n = root(z);
    const auto turned = n > all(1e-150);
    const Four some = choose(turned, n, all(1.0));
    s = choose(turned, 4.0 * arc_tangent(some / (1.0 + sign * q.w)) / some, all(2.0));
    s = sign * s;
  }
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

/// Gathers and scatters the state of four bodies.
struct FourBodies {
  double* b[4];
  FourBodies(const IslandView& p, std::size_t i) {
    for (int l = 0; l < 4; ++l)
      b[l] = p.bodies + p.slots[i + static_cast<std::size_t>(l)] * p.layout.stride;
  }
  INLINE Four num(std::size_t at) const { return Four{b[0][at], b[1][at], b[2][at], b[3][at]}; }
  INLINE Vec<Four> vec(std::size_t at) const { return {num(at), num(at + 1), num(at + 2)}; }
  INLINE Qua<Four> qua(std::size_t at) const {
    return {num(at), num(at + 1), num(at + 2), num(at + 3)};
  }
  INLINE void set(std::size_t at, Four v, std::size_t lanes) const {
    if (lanes == kLanes) {
      b[0][at] = v[0], b[1][at] = v[1], b[2][at] = v[2], b[3][at] = v[3];
      return;
    }
    for (std::size_t l = 0; l < lanes; ++l) b[l][at] = v[l];
  }
  INLINE void set(std::size_t at, Vec<Four> v, std::size_t lanes) const {
    set(at, v.x, lanes), set(at + 1, v.y, lanes), set(at + 2, v.z, lanes);
  }
};

/// World vector of principal `moments` times the body-frame part of v: I v or its like.
INLINE Vec<Four> times_inertia(Qua<Four> q, Vec<Four> moments, Vec<Four> v) {
  const Vec<Four> b = rotated(back(q), v);
  return rotated(q, Vec<Four>{moments.x * b.x, moments.y * b.y, moments.z * b.z});
}
INLINE Vec<Four> inverted(Vec<Four> m) { return {1.0 / m.x, 1.0 / m.y, 1.0 / m.z}; }

/// 1 for lanes below `count`, 0 for padding.
INLINE Four mask(std::size_t i, std::size_t count) {
  if (i + kLanes <= count) return all(1.0);
  Four m = all(1.0);
  for (std::size_t l = 0; l < kLanes; ++l)
    if (i + l >= count) m[l] = 0;
  return m;
}

// ---------------------------------------------------------------- update stage

/// Angular velocity after a rotation `start + w reach` with angular momentum `l`: two fixed-point
/// iterations of w = I(q(w))^-1 l, from a guess.
INLINE Vec<Four> angular_velocity_keeping(Vec<Four> l, Qua<Four> q, Vec<Four> per_moment,
                                          Vec<Four> start, Four reach, Vec<Four> guess) {
  Vec<Four> w = guess;
  for (int round = 0; round < 2; ++round)
    w = times_inertia(mul(exponential(start + reach * w), q), per_moment, l);
  return w;
}

/// exp(-drag h) for four bodies, reused while the drag is the same.
class DampingFactor {
 public:
  explicit DampingFactor(double h) : h_(h) {}
  INLINE Four of(Four drag) {
    const auto same = drag == last_;
    if ((same[0] & same[1] & same[2] & same[3]) == 0) {
      for (int l = 0; l < 4; ++l) keep_[l] = ::exp(-drag[l] * h_);
      last_ = drag;
    }
    return keep_;
  }

 private:
  double h_;
  Four last_ = all(0.0), keep_ = all(1.0);
};

template <Rule rule, bool forced>
StartSums predict_by(const IslandView& p, const PredictInput& in) {
  const Four h = all(in.h), third = all(1.0 / 3), two_thirds_h = all(2.0 / 3 * in.h);
  const Vec<Four> g{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
  Four kinetic = all(0), potential = all(0), damped = all(0), probe = all(0);
  Vec<Four> momentum{all(0), all(0), all(0)};
  DampingFactor damping(in.h);
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    const double* c = column(p.constants, kConstantRows, i);
    double* m = column(p.memory, kMemoryRows, i);
    double* k = column(p.work, kWorkRows, i);
    const FourBodies bodies(p, i);
    const Four mass = num<Four>(c, kMass), drag = num<Four>(c, kDrag);
    const Vec<Four> moments = vec<Four>(c, kInertia);
    const Vec<Four> x = bodies.vec(p.layout.position), v = bodies.vec(p.layout.velocity);
    const Vec<Four> angular_velocity = bodies.vec(p.layout.angular_velocity);
    const Qua<Four> q = bodies.qua(p.layout.rotation);
    const Vec<Four> weight = num<Four>(c, kGravityScale) * g;
    const Four here = mask(i, p.count) * mass;
    Vec<Four> a = weight, torque{all(0), all(0), all(0)};
    if (forced) {
      const double* f = column(p.forces, 6, i);
      a = a + vec<Four>(f, 0), torque = vec<Four>(f, 3);
    }
    Vec<Four> translation, w, r;
    if (rule == Rule::verlet) {  // no energy balance
      const Four keep = damping.of(drag), push = in.first ? 0.5 * h : h;
      translation = h * (keep * v + push * a);
      w = keep * angular_velocity;
      if (forced) w = w + push * times_inertia(q, inverted(moments), torque);
      r = h * w;
    } else {
      const Vec<Four> per_moment = inverted(moments),
                      l = times_inertia(q, moments, angular_velocity);
      const Four energy = 0.5 * (here * dot(v, v) + mask(i, p.count) * dot(l, angular_velocity));
      kinetic += energy, momentum = momentum + here * v, potential -= here * dot(weight, x);
      if (rule == Rule::bdf2) {
        const Four brake = 1.0 / (1.0 + two_thirds_h * drag);
        damped += energy * (1.0 - 1.0 / (1.0 + 2.0 * h * drag));
        const Vec<Four> v_before = vec<Four>(m, kVelocityBefore);
        const Vec<Four> l_before = vec<Four>(m, kAngularMomentumBefore);
        const Vec<Four> v_star = brake * (third * (all(4) * v - v_before) + two_thirds_h * a);
        const Vec<Four> l_star = brake * (third * (all(4) * l - l_before) + two_thirds_h * torque);
        translation = third * vec<Four>(m, kLastTranslation) + two_thirds_h * v_star;
        const Vec<Four> start = third * vec<Four>(m, kLastRotation);
        w = angular_velocity_keeping(l_star, q, per_moment, start, two_thirds_h, angular_velocity);
        r = start + two_thirds_h * w;
      } else {
        const Four keep = damping.of(drag), push = in.first ? 0.5 * h : h;
        damped += energy * (1.0 - keep * keep);
        translation = h * (keep * v + push * a);
        const Vec<Four> nothing{all(0), all(0), all(0)};
        const bool midpoint = rule == Rule::midpoint;
        const Vec<Four> kept =
            midpoint ? times_inertia(mul(exponential(all(-0.5) * h * angular_velocity), q), moments,
                                     angular_velocity)
                     : l;
        w = angular_velocity_keeping(keep * kept + push * torque, q, per_moment, nothing,
                                     midpoint ? 0.5 * h : push, angular_velocity);
        r = h * w;
      }
      put(m, kVelocityBefore, v), put(m, kAngularMomentumBefore, l);
    }
    probe += dot(translation + x, translation + x) + dot(r, r);
    const Qua<Four> predicted = unit_again(mul(exponential(r), q));
    put(k, kPosition, x + translation), put(k, kRotation, predicted),
        put(k, kAngularVelocityStar, w);
  }
  return {sum(kinetic),
          sum(potential),
          sum(damped),
          {sum(momentum.x), sum(momentum.y), sum(momentum.z)},
          sum(probe) < HUGE_VAL};
}

StartSums predict(const IslandView& p, const PredictInput& in) {
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

/// Own arm and world inertia of a block at a pose.
INLINE void put_arm(double* k, Qua<Four> q, Vec<Four> anchor, Vec<Four> moments) {
  put(k, kArm, rotated(q, anchor));
  // R diag(I) R^T, from the columns of R.
  const Four xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z,
             yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  const Four two = all(2.0), one = all(1.0);
  const Vec<Four> ex{one - two * (yy + zz), two * (xy + wz), two * (xz - wy)};
  const Vec<Four> ey{two * (xy - wz), one - two * (xx + zz), two * (yz + wx)};
  const Vec<Four> ez{two * (xz + wy), two * (yz - wx), one - two * (xx + yy)};
  const Vec<Four> mx = moments.x * ex, my = moments.y * ey, mz = moments.z * ez;
  put(k, kRotationalInertia,
      Sym<Four>{mx.x * ex.x + my.x * ey.x + mz.x * ez.x, mx.x * ex.y + my.x * ey.y + mz.x * ez.y,
                mx.x * ex.z + my.x * ey.z + mz.x * ez.z, mx.y * ex.y + my.y * ey.y + mz.y * ez.y,
                mx.y * ex.z + my.y * ey.z + mz.y * ez.z, mx.z * ex.z + my.z * ey.z + mz.z * ez.z});
}

/// Joint geometry of a block: own arms and inertias, the parents' arms to the same joints, the
/// gaps.
INLINE void put_levers(const IslandView& p, std::size_t i, std::size_t position_row,
                       std::size_t rotation_row) {
  const double* c = column(p.constants, kConstantRows, i);
  double* k = column(p.work, kWorkRows, i);
  const Vec<Four> x = vec<Four>(k, position_row);
  const Qua<Four> q = qua<Four>(k, rotation_row);
  put_arm(k, q, vec<Four>(c, kOwnAnchor), vec<Four>(c, kInertia));
  // The parents' poses, lane by lane; roots use their own.
  Qua<Four> pq = q;
  Vec<Four> px = x;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const std::int32_t parent = p.parents[i + l];
    if (parent < 0) continue;
    const double* o = column(p.work, kWorkRows, static_cast<std::size_t>(parent));
    pq.x[l] = o[rotation_row * kLanes], pq.y[l] = o[(rotation_row + 1) * kLanes];
    pq.z[l] = o[(rotation_row + 2) * kLanes], pq.w[l] = o[(rotation_row + 3) * kLanes];
    px.x[l] = o[position_row * kLanes], px.y[l] = o[(position_row + 1) * kLanes];
    px.z[l] = o[(position_row + 2) * kLanes];
  }
  const Vec<Four> arm = rotated(pq, vec<Four>(c, kParentAnchor));
  put(k, kParentArm, arm);
  put(k, kGap, (px + arm) - (x + vec<Four>(k, kArm)));
}

void levers(const IslandView& p, std::size_t position_row, std::size_t rotation_row) {
  for (std::size_t i = 0; i < p.count; i += kLanes) put_levers(p, i, position_row, rotation_row);
}

/// Geometric stiffness t (1 - r r^T / r^2) of a joint in tension t > 0: the force rotates with the
/// body within the step.
INLINE Sym<Four> tension_stiffness(Four t, Vec<Four> r) {
  const Four r2 = dot(r, r);
  const auto pulls = (t > 0.0) & (r2 > 0.0);
  t = choose(pulls, t, all(0.0));
  const Four s = t / choose(pulls, r2, all(1.0));
  const Vec<Four> sr = s * r;
  return {t - sr.x * r.x, -sr.x * r.y, -sr.x * r.z, t - sr.y * r.y, -sr.y * r.z, t - sr.z * r.z};
}

template <class T>
INLINE void add(Sym<T>& a, const Sym<T>& b) {
  a.xx += b.xx, a.xy += b.xy, a.xz += b.xz, a.yy += b.yy, a.yz += b.yz, a.zz += b.zz;
}

/// Joint geometry of a block, and its rotational inertia about the own joints.
INLINE void put_turning(const IslandView& p, std::size_t i, std::size_t position_row,
                        std::size_t rotation_row, bool tension) {
  put_levers(p, i, position_row, rotation_row);
  double* k = column(p.work, kWorkRows, i);
  const Vec<Four> arm = vec<Four>(k, kArm);
  const Vec<Four> ma = num<Four>(column(p.constants, kConstantRows, i), kMass) * arm;
  const Four a2 = dot(ma, arm);
  Sym<Four> tt = sym<Four>(k, kRotationalInertia);
  add(tt, Sym<Four>{a2 - ma.x * arm.x, -ma.x * arm.y, -ma.x * arm.z, a2 - ma.y * arm.y,
                    -ma.y * arm.z, a2 - ma.z * arm.z});
  if (tension) {
    const Vec<Four> lambda = vec<Four>(column(p.memory, kMemoryRows, i), kLambda);
    const Vec<Four> out = vec<Four>(k, kParentArm);
    add(tt, tension_stiffness(dot(lambda, arm), arm));  // zero for a free root
    put(k, kOutwardTension, tension_stiffness(-dot(lambda, out), out));
  }
  put(k, kRotationalInertia, tt);
}

void prepare(const IslandView& p, std::size_t position_row, std::size_t rotation_row,
             bool tension) {
  for (std::size_t i = 0; i < p.count; i += kLanes)
    put_turning(p, i, position_row, rotation_row, tension);
}

/// LDL^T of a symmetric positive definite 3x3 matrix, with a lower bound on the pivots.
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

/// Three rows of a 3x3 matrix, each followed by the component of a vector.
struct Rows {
  Four x, y, z;
  INLINE static Rows from(const double* p) { return {load(p), load(p + 4), load(p + 8)}; }
  INLINE void to(double* p) const { store(p, x), store(p + 4, y), store(p + 8, z); }
};

/// The block of a body with its outboard subtree, before its rotation is eliminated: A_tt, A_ty |
/// g_t and A_yy | g_y.
struct Block {
  Sym<double> tt;
  Rows ty, yy;
};

INLINE Four with_last(Four v, double last) {
  v[3] = last;
  return v;
}

/// Adds a child, given as articulated mass | bias at its joint, to the block of its parent.
INLINE void add_child(Block& b, const Rows& mass_and_bias, Vec<double> gap, Vec<double> rho) {
  // Bias after the gap is closed: g - M s.
  const Four ms = gap.x * mass_and_bias.x + gap.y * mass_and_bias.y + gap.z * mass_and_bias.z;
  const Four fx = with_last(mass_and_bias.x, mass_and_bias.x[3] - ms[0]);
  const Four fy = with_last(mass_and_bias.y, mass_and_bias.y[3] - ms[1]);
  const Four fz = with_last(mass_and_bias.z, mass_and_bias.z[3] - ms[2]);
  b.yy.x += fx, b.yy.y += fy, b.yy.z += fz;
  // K(rho) M | rho x f, with K(a) b = a x b; and -K M K.
  const Four kx = rho.y * fz - rho.z * fy;
  const Four ky = rho.z * fx - rho.x * fz;
  const Four kz = rho.x * fy - rho.y * fx;
  b.ty.x += kx, b.ty.y += ky, b.ty.z += kz;
  add(b.tt, Sym<double>{rho.y * kx[2] - rho.z * kx[1], rho.z * kx[0] - rho.x * kx[2],
                        rho.x * kx[1] - rho.y * kx[0], rho.z * ky[0] - rho.x * ky[2],
                        rho.x * ky[1] - rho.y * ky[0], rho.x * kz[1] - rho.y * kz[0]});
}

/// The block of a body alone: A_tt is prepared, A_ty = m K(e) with e = -arm, A_yy = m.
INLINE Block own_block(const double* c, const double* k) {
  const double m = num<double>(c, kMass);
  const Vec<double> ma = m * vec<double>(k, kArm);
  return {sym<double>(k, kRotationalInertia),
          {Four{0, ma.z, -ma.y, 0}, Four{-ma.z, 0, ma.x, 0}, Four{ma.y, -ma.x, 0, 0}},
          {Four{m, 0, 0, 0}, Four{0, m, 0, 0}, Four{0, 0, m, 0}}};
}

/// Eliminates the rotation of a body: articulated mass and bias at its joint, and its response.
/// Pivot by pivot, since the next body depends on the articulated mass only.
INLINE Rows eliminate(const Block& b, double* node) {
  const double floor = 4 * 2.220446049250313e-16 * (b.tt.xx + b.tt.yy + b.tt.zz);
  const double d0 = b.tt.xx, i0 = 1 / (d0 > floor ? d0 : floor);
  const double l01 = b.tt.xy * i0, l02 = b.tt.xz * i0;
  const double d1 = b.tt.yy - l01 * b.tt.xy, s12 = b.tt.yz - l01 * b.tt.xz;
  const double e2 = b.tt.zz - l02 * b.tt.xz;
  const Four r0 = b.ty.x, m0 = i0 * r0;
  const Four r1 = b.ty.y - l01 * r0, q2 = b.ty.z - l02 * r0;

  const double i1 = 1 / (d1 > floor ? d1 : floor);
  const double l12 = s12 * i1, d2 = e2 - l12 * s12;
  const Four m1 = i1 * r1, r2 = q2 - l12 * r1;

  const double i2 = 1 / (d2 > floor ? d2 : floor);
  const Four m2 = i2 * r2;
  const Rows mass_and_bias{((b.yy.x - m0[0] * r0) - m1[0] * r1) - m2[0] * r2,
                           ((b.yy.y - m0[1] * r0) - m1[1] * r1) - m2[1] * r2,
                           ((b.yy.z - m0[2] * r0) - m1[2] * r1) - m2[2] * r2};
  mass_and_bias.to(node + kArticulatedMass);
  // Back substitution: rows of the response, each followed by the bias.
  const Four a1 = m1 - l12 * m2;
  Rows{(m0 - l01 * a1) - l02 * m2, a1, m2}.to(node + kResponse);
  return mass_and_bias;
}

/// A chain: the only child is the next column, so its articulated mass stays in registers.
template <bool tension>
void inward_pass_chain_by(const IslandView& p) {
  Rows mass_and_bias{};
  for (std::size_t i = p.count; i-- > 0;) {
    // Preparing a block here hides the latency of the divisions.
    if (i % kLanes == kLanes - 1 || i == p.count - 1)
      put_turning(p, i / kLanes * kLanes, kPosition, kRotation, tension);
    const double* k = column(p.work, kWorkRows, i);
    Block b = own_block(column(p.constants, kConstantRows, i), k);
    if (i + 1 < p.count) {
      const double* child = column(p.work, kWorkRows, i + 1);
      add_child(b, mass_and_bias, vec<double>(child, kGap),
                vec<double>(child, kParentArm) - vec<double>(k, kArm));
      if (tension) add(b.tt, sym<double>(child, kOutwardTension));
    }
    mass_and_bias = eliminate(b, p.nodes + kNodeSize * i);
  }
}

void inward_pass_chain(const IslandView& p, bool tension) {
  if (tension)
    inward_pass_chain_by<true>(p);
  else
    inward_pass_chain_by<false>(p);
}

INLINE void put_block(double* at, const Block& b) {
  at[0] = b.tt.xx, at[1] = b.tt.xy, at[2] = b.tt.xz, at[3] = b.tt.yy, at[4] = b.tt.yz;
  at[5] = b.tt.zz;
  b.ty.to(at + kRotationTranslation), b.yy.to(at + kTranslationTranslation);
}
INLINE Block block_at(const double* at) {
  return {{at[0], at[1], at[2], at[3], at[4], at[5]},
          Rows::from(at + kRotationTranslation),
          Rows::from(at + kTranslationTranslation)};
}

void fill_blocks(const IslandView& p, double* blocks) {
  for (std::size_t i = 0; i < p.count; ++i)
    put_block(blocks + kBlockSize * i,
              own_block(column(p.constants, kConstantRows, i), column(p.work, kWorkRows, i)));
}

/// A tree: each body adds itself to its parent's block once it is eliminated.
void inward_pass_tree(const IslandView& p, bool tension, double* blocks) {
  for (std::size_t i = p.count; i-- > 0;) {
    const double* k = column(p.work, kWorkRows, i);
    const Rows mass_and_bias =
        eliminate(block_at(blocks + kBlockSize * i), p.nodes + kNodeSize * i);
    if (p.parents[i] < 0) continue;
    const auto parent = static_cast<std::size_t>(p.parents[i]);
    Block b = block_at(blocks + kBlockSize * parent);
    add_child(b, mass_and_bias, vec<double>(k, kGap),
              vec<double>(k, kParentArm) - vec<double>(column(p.work, kWorkRows, parent), kArm));
    if (tension) add(b.tt, sym<double>(k, kOutwardTension));
    put_block(blocks + kBlockSize * parent, b);
  }
}

/// Rotation of a vector by a body's rotation: v -> v + a (u x v) + b u x (u x v).
struct Carry {
  Vec<double> u;
  double a, b;
  INLINE Vec<double> operator()(Vec<double> v) const {
    const Vec<double> t = cross(u, v);
    return v + (a * t + b * cross(u, t));
  }
};
/// By a quaternion (u, w) of any length.
INLINE Carry carry_by(Qua<double> q) {
  const double s = 2 / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {{q.x, q.y, q.z}, s * q.w, s};
}

INLINE double magnitude(double x) { return x < 0 ? -x : x; }

/// The rotation of one body whose own joint point moves to `goal`, by the articulated response; for
/// a free root it sets `goal`. Stores the multiplier of the joint.
struct Articulated {
  const IslandView& p;
  std::size_t position_row;

  INLINE Carry operator()(std::size_t i, double* k, Vec<double> arm, Vec<double>& goal) const {
    const double* n = p.nodes + kNodeSize * i;
    const double* g = n + kArticulatedMass;
    const Vec<double> x = vec<double>(k, position_row);
    Vec<double> y = goal - (x + arm), lambda{0, 0, 0};
    if (p.parents[i] == kFree) {
      y = Factor(Sym<double>{g[0], g[1], g[2], g[5], g[6], g[10]}).solve({g[3], g[7], g[11]});
      goal = x + y;
    } else {
      lambda = {(g[0] * y.x + g[1] * y.y + g[2] * y.z) - g[3],
                (g[4] * y.x + g[5] * y.y + g[6] * y.z) - g[7],
                (g[8] * y.x + g[9] * y.y + g[10] * y.z) - g[11]};
      if (!(dot(lambda, lambda) < 1e36)) lambda = {0, 0, 0};
    }
    put(column(p.memory, kMemoryRows, i), kLambda, lambda);
    Vec<double> d{n[3] - (n[0] * y.x + n[1] * y.y + n[2] * y.z),
                  n[7] - (n[4] * y.x + n[5] * y.y + n[6] * y.z),
                  n[11] - (n[8] * y.x + n[9] * y.y + n[10] * y.z)};
    // The angle stays below 148 degrees; no rotation if a number is not finite.
    const double most = magnitude(d.x) + magnitude(d.y) + magnitude(d.z);
    if (!(most < 4)) {
      double far = magnitude(d.x) > magnitude(d.y) ? magnitude(d.x) : magnitude(d.y);
      if (magnitude(d.z) > far) far = magnitude(d.z);
      if (!(most < 1e30))
        d = {0, 0, 0};
      else if (far > 4)
        d = (4 / far) * d;
    }
    // Cayley's map: the quaternion (d/2, 1).
    const Vec<double> u = 0.5 * d;
    put(k, kAppliedRotation, Qua<double>{u.x, u.y, u.z, 1});
    const double s = 2 / (1 + dot(u, u));
    return {u, s, s};
  }
};

/// The same by least displacement, scaled by |r x s|^2 to avoid divisions: the quaternion (Z + C,
/// S) with S = m r x s, C = beta a^T I a + m r.(r + s), Z = sqrt(C^2 + S^2).
struct LeastDisplacement {
  const IslandView& p;
  std::size_t position_row;
  double stiffness;

  INLINE Carry operator()(std::size_t i, double* k, Vec<double> arm, Vec<double>& goal) const {
    const Vec<double> x = vec<double>(k, position_row);
    const Vec<double> to = goal - x;       // r + s
    const Vec<double> a = cross(arm, to);  // r x s = r x (r + s)
    const double a2 = dot(a, a);
    if (p.parents[i] == kFree || !(a2 > 1e-100)) {
      if (p.parents[i] == kFree) goal = x;
      put(k, kAppliedRotation, Qua<double>{0, 0, 0, 1});
      return {{0, 0, 0}, 0, 0};
    }
    const double ma2 = num<double>(column(p.constants, kConstantRows, i), kMass) * a2;
    const double c =
        stiffness * dot(a, mul(sym<double>(k, kRotationalInertia), a)) + ma2 * dot(arm, to);
    const Vec<double> s = ma2 * a;
    const double s2 = ma2 * ma2 * a2;
    // With M = Z + |C|: Z + C is M or S^2 / M, and the quaternion (S, Z + C) or (M S, S^2). |(S, Z
    // + C)|^2 = 2 Z (Z + C). The case is unpredictable, hence no branch.
    const double z = ::sqrt(c * c + s2), m = z + magnitude(c);
    const auto same = Two{c, c} >= Two{0, 0};
    const Two pick = choose(same, Two{1, m}, Two{m, s2});  // factor of S, scalar part
    put(k, kAppliedRotation, Qua<double>{pick[0] * s.x, pick[0] * s.y, pick[0] * s.z, pick[1]});
    return {s, 1 / z, pick[0] / (z * pick[1])};
  }
};

/// State of the previous body in an outward pass along a chain.
struct Step {
  Vec<double> goal{0, 0, 0}, arm{0, 0, 0};
  Carry carry{{0, 0, 0}, 0, 0};
};

/// One body of the outward pass: position of its joint, and its rotation.
template <bool chain, class Rotate>
INLINE void outwards(const IslandView& p, const double*& targets, std::size_t i, Step& at,
                     const Rotate& rotate) {
  double* k = column(p.work, kWorkRows, i);
  const std::int32_t parent = p.parents[i];
  if (parent < 0) {
    at.goal = {targets[0], targets[1], targets[2]};
    targets += 3;
  } else {
    if (!chain) {
      const double* o = column(p.work, kWorkRows, static_cast<std::size_t>(parent));
      at = {vec<double>(o, kAttach), vec<double>(o, kArm),
            carry_by(qua<double>(o, kAppliedRotation))};
    }
    at.goal = at.goal + at.carry(vec<double>(k, kParentArm) - at.arm);
  }
  at.arm = vec<double>(k, kArm);
  at.carry = rotate(i, k, at.arm, at.goal);
  put(k, kAttach, at.goal);
}

template <class Rotate>
INLINE void walk(const IslandView& p, const double* targets, const Rotate& rotate) {
  Step at;
  if (p.is_chain)
    for (std::size_t i = 0; i < p.count; ++i) outwards<true>(p, targets, i, at, rotate);
  else
    for (std::size_t i = 0; i < p.count; ++i) outwards<false>(p, targets, i, at, rotate);
}

void outward_pass(const IslandView& p, const double* targets, std::size_t position_row) {
  walk(p, targets, Articulated{p, position_row});
}

void sweep(const IslandView& p, const double* targets, std::size_t position_row, double stiffness) {
  walk(p, targets, LeastDisplacement{p, position_row, stiffness});
}

/// The final pose of a block: rotations applied, own joints in place.
struct BlockPose {
  Vec<Four> x;
  Qua<Four> q;
};
INLINE BlockPose pose_of(const IslandView& p, std::size_t i, std::size_t from_rotation_row) {
  const double* k = column(p.work, kWorkRows, i);
  const Qua<Four> q = unit(mul(qua<Four>(k, kAppliedRotation), qua<Four>(k, from_rotation_row)));
  const Vec<Four> arm = rotated(q, vec<Four>(column(p.constants, kConstantRows, i), kOwnAnchor));
  return {vec<Four>(k, kAttach) - arm, q};
}

void apply_poses(const IslandView& p, std::size_t from_rotation_row) {
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    double* k = column(p.work, kWorkRows, i);
    const BlockPose at = pose_of(p, i, from_rotation_row);
    put(k, kFinalRotation, at.q), put(k, kFinalPosition, at.x);
  }
}

// ---------------------------------------------------------------- velocities

/// Velocities of one block from its final pose, written to the bodies; accumulates sums.
template <Rule rule>
struct VelocityUpdate {
  const IslandView& p;
  const VelocityInput& in;
  const double per = 1 / in.h;
  const Vec<Four> g{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
  Four kinetic = all(0), potential = all(0), work = all(0), turned = all(0);
  Vec<Four> momentum{all(0), all(0), all(0)};
  bool sane = true;

  INLINE void operator()(std::size_t i, Vec<Four> x, Qua<Four> q) {
    const std::size_t lanes = p.count - i < kLanes ? p.count - i : kLanes;
    const Four here = mask(i, p.count);
    if (any_not_below(dot(x, x), kTooFar * kTooFar)) {
      sane = false;
      return;
    }
    const double* c = column(p.constants, kConstantRows, i);
    double* m = column(p.memory, kMemoryRows, i);
    const double* k = column(p.work, kWorkRows, i);
    const FourBodies bodies(p, i);
    const Vec<Four> moments = vec<Four>(c, kInertia);
    const Vec<Four> translation = x - bodies.vec(p.layout.position);
    const Vec<Four> turned_by = logarithm(mul(q, back(bodies.qua(p.layout.rotation))));
    const Four turned2 = here * dot(turned_by, turned_by);
    turned = choose(turned2 > turned, turned2, turned);

    Vec<Four> v, w, l;
    if (rule == Rule::verlet || rule == Rule::midpoint) {
      v = all(per) * translation, w = all(per) * turned_by;
      if (rule == Rule::midpoint) l = times_inertia(q, moments, w);
    } else if (in.first) {
      // Trapezoidal rule from the initial velocities, stored by predict().
      v = all(2 * per) * translation - vec<Four>(m, kVelocityBefore);
      w = all(2 * per) * turned_by - bodies.vec(p.layout.angular_velocity);
      l = times_inertia(q, moments, w);
    } else {
      // Differences of rotation vectors would lose an order of accuracy: the rotation caused by the
      // joints is an impulse on the predicted angular momentum.
      const double rate = rule == Rule::bdf2 ? 1.5 * per : per;
      v = rule == Rule::bdf2
              ? all(0.5 * per) * (all(3) * translation - vec<Four>(m, kLastTranslation))
              : all(per) * translation;
      const Qua<Four> predicted = qua<Four>(k, kRotation);
      const Vec<Four> forced = logarithm(mul(q, back(predicted)));
      l = times_inertia(predicted, moments,
                        vec<Four>(k, kAngularVelocityStar) + all(rate) * forced);
      w = times_inertia(q, inverted(moments), l);
      if (rule == Rule::euler && any_not_below(turned2, in.calm_angle * in.calm_angle)) {
        // A large rotation: its rate is bounded, the impulse is not.
        const Four calm2 = all(in.calm_angle * in.calm_angle);
        const Vec<Four> plain = all(per) * turned_by;
        w.x = choose(turned2 >= calm2, plain.x, w.x);
        w.y = choose(turned2 >= calm2, plain.y, w.y);
        w.z = choose(turned2 >= calm2, plain.z, w.z);
        l = times_inertia(q, moments, w);
      }
    }
    bodies.set(p.layout.position, x, lanes);
    bodies.set(p.layout.rotation, Vec<Four>{q.x, q.y, q.z}, lanes);
    bodies.set(p.layout.rotation + 3, q.w, lanes);
    bodies.set(p.layout.velocity, v, lanes);
    bodies.set(p.layout.angular_velocity, w, lanes);
    if (rule == Rule::verlet) return;  // no energy balance

    put(m, kLastTranslation, translation), put(m, kLastRotation, turned_by);
    const Four mass = num<Four>(c, kMass);
    const Vec<Four> weight = num<Four>(c, kGravityScale) * g;
    kinetic += 0.5 * here * (mass * dot(v, v) + dot(l, w));
    potential -= here * mass * dot(weight, x);
    momentum = momentum + (here * mass) * v;
    if (p.forces) {
      const double* f = column(p.forces, 6, i);
      work += here * (mass * dot(vec<Four>(f, 0), translation) + dot(vec<Four>(f, 3), turned_by));
    }
  }

  EndSums sums() const {
    return {sum(kinetic),    sum(potential),
            sum(work),       {sum(momentum.x), sum(momentum.y), sum(momentum.z)},
            largest(turned), sane};
  }
};

template <class Job>
EndSums by_rule(const IslandView& p, const VelocityInput& in, const Job& job) {
  const auto run = [&](auto update_velocities) {
    job(update_velocities);
    return update_velocities.sums();
  };
  switch (in.rule) {
    case Rule::verlet:
      return run(VelocityUpdate<Rule::verlet>{p, in});
    case Rule::midpoint:
      return run(VelocityUpdate<Rule::midpoint>{p, in});
    case Rule::euler:
      return run(VelocityUpdate<Rule::euler>{p, in});
    case Rule::bdf2:
      return run(VelocityUpdate<Rule::bdf2>{p, in});
  }
  return {};
}

EndSums update_velocities(const IslandView& p, const VelocityInput& in) {
  return by_rule(p, in, [&](auto& update_block) {
    for (std::size_t i = 0; i < p.count; i += kLanes) {
      const double* k = column(p.work, kWorkRows, i);
      update_block(i, vec<Four>(k, kFinalPosition), qua<Four>(k, kFinalRotation));
    }
  });
}

/// The outward pass is sequential; vector work on neighbouring blocks hides its latency. The next
/// block is prepared and the previous one gets poses and velocities, one job per body.
template <bool chain, class Rotate, class Prepare, class Block>
INLINE void walk_and_update(const IslandView& p, const double* targets, const Rotate& rotate,
                            const Prepare& prepare_block, Block& update_block) {
  const auto put_pose = [&](std::size_t i) {
    double* k = column(p.work, kWorkRows, i);
    const BlockPose at = pose_of(p, i, kRotation);
    put(k, kFinalRotation, at.q), put(k, kFinalPosition, at.x);
  };
  const auto update_placed = [&](std::size_t i) {
    const double* k = column(p.work, kWorkRows, i);
    update_block(i, vec<Four>(k, kFinalPosition), qua<Four>(k, kFinalRotation));
  };
  Step at;
  prepare_block(0);
  for (std::size_t n = 0; n < p.count; ++n) {
    outwards<chain>(p, targets, n, at, rotate);
    const std::size_t job = n % kLanes, i = n - job;
    if (job == 0 && i + kLanes < p.count) prepare_block(i + kLanes);
    if (job == 1 && i > 0) put_pose(i - kLanes);
    if (job == 2 && i > 0) update_placed(i - kLanes);
  }
  const std::size_t last = (p.count - 1) / kLanes * kLanes;
  if (last > 0 && p.count - last < 2) put_pose(last - kLanes);
  if (last > 0 && p.count - last < 3) update_placed(last - kLanes);
  put_pose(last);
  update_placed(last);
}

EndSums outward_pass_and_update(const IslandView& p, const double* targets,
                                const VelocityInput& in) {
  return by_rule(p, in, [&](auto& update_block) {
    const auto prepared = [](std::size_t) {};
    if (p.is_chain)
      walk_and_update<true>(p, targets, Articulated{p, kPosition}, prepared, update_block);
    else
      walk_and_update<false>(p, targets, Articulated{p, kPosition}, prepared, update_block);
  });
}

EndSums sweep_and_update(const IslandView& p, const double* targets, double stiffness,
                         const VelocityInput& in) {
  return by_rule(p, in, [&](auto& update_block) {
    const LeastDisplacement rotate{p, kPosition, stiffness};
    const auto prepare_block = [&](std::size_t i) { put_levers(p, i, kPosition, kRotation); };
    if (p.is_chain)
      walk_and_update<true>(p, targets, rotate, prepare_block, update_block);
    else
      walk_and_update<false>(p, targets, rotate, prepare_block, update_block);
  });
}

void scale(const IslandView& p, double factor, const double* mean) {
  for (std::size_t i = 0; i < p.count; ++i) {
    double* b = p.bodies + p.slots[i] * p.layout.stride;
    for (std::size_t n = 0; n < 3; ++n) {
      double& v = b[p.layout.velocity + n];
      v = mean[n] + factor * (v - mean[n]);
      b[p.layout.angular_velocity + n] *= factor;
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
                                                         levers,
                                                         prepare,
                                                         inward_pass_chain,
                                                         fill_blocks,
                                                         inward_pass_tree,
                                                         outward_pass,
                                                         sweep,
                                                         apply_poses,
                                                         update_velocities,
                                                         outward_pass_and_update,
                                                         sweep_and_update,
                                                         scale};

}  // namespace pantin::detail::articulated

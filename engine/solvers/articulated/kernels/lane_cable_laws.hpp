#pragma once
/// Cables of islands side by side: their laws, as conserving_ties.cpp and slack_cables.cpp have
/// them for one island, an island in each lane.
#include "engine/solvers/articulated/kernels/lane_tables.hpp"

namespace pantin::detail::articulated {
namespace {

inline constexpr std::uint32_t kNoColumn = 0xffffffff;

/// As glm has them, to the last bit.
INLINE Vec<Four> turned(Qua<Four> q, Vec<Four> v) {
  const Vec<Four> u{q.x, q.y, q.z}, uv = cross(u, v);
  return v + 2.0 * (q.w * uv + cross(u, uv));
}
INLINE Vec<Four> normalized(Vec<Four> v) { return (1.0 / root(dot(v, v))) * v; }
INLINE Four length_of(Vec<Four> v) { return root(dot(v, v)); }
class LaneCableLaws {
 public:
  LaneCableLaws(const ConservingLanes& lanes, LaneTables& tables) : all_(lanes), t_(tables) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const LaneIsland& own = all_.islands[l < all_.count ? l : 0];
      size_[l] = own.size, mass_[l] = own.mass, yield_[l] = own.yield;
    }
    near_ = kAtLength * size_, least_ = -1.0 * yield_ * near_;
  }

  /// Whether the equations of a lane need more than a row for a cable.
  bool is_alone(std::size_t l) const { return alone_[l]; }

 protected:
  /// As conserving_ties.cpp and slack_cables.cpp have them.
  static constexpr int kChangeAtOnce = 6;
  static constexpr double kAtLength = 1e-10, kAccepted = 3e-6, kFollowed = 1e-9, kSlight = 0.1;

  /// All bits of a lane set, or none.
  using Mask = decltype(Four{} < Four{});
  /// Of an elastic cable: see load_of_cable.
  struct Load {
    Vec<Four> mu, derivative[3];  // by columns
    Four across;
  };

  std::size_t count() const { return all_.ties->count; }
  const LaneTies::Tie& tie(std::size_t n) const { return all_.ties->ties[n]; }
  const LaneIsland& island(std::size_t l) const { return all_.islands[l]; }
  bool runs(std::size_t l) const { return t_.running[l] > 0.5; }
  INLINE double* at(std::size_t n) const { return all_.tie_table + kLaneCableRows * kLanes * n; }
  double kind(std::size_t n, std::size_t l) const { return at(n)[kCableKind * kLanes + l]; }
  bool acts(std::size_t n, std::size_t l) const { return at(n)[kCableActs * kLanes + l] > 0.5; }
  std::uint32_t& row(std::size_t r) const { return all_.tie_rows[r]; }
  INLINE Mask taut(std::size_t n) const { return num<Four>(at(n), kCableKind) == kTautTie; }
  bool strikes(std::size_t l) const {
    for (std::size_t n = 0; n < count(); ++n)
      if (kind(n, l) == kStrikingTie) return true;
    return false;
  }
  static INLINE bool any(Mask mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }
  static INLINE Four ones(Mask mask) { return choose(mask, all(1), all(0)); }
  /// How much too long a cable is at the iterate, m.
  static INLINE Four over_of(const double* k) {
    return length_of(vec<Four>(k, kCableNow)) - num<Four>(k, kCableLength);
  }
  /// Arms from the own joint, and d, at the iterate.
  void look_at(std::size_t n) {
    double* const k = at(n);
    const auto moved = [&](std::uint32_t c, std::size_t side) {
      const double* const w = t_.work_at(c);
      const Vec<Four> start = vec<Four>(k, kCableStartA + side);
      const Vec<Four> end = turned(qua<Four>(w, kEndRotation), vec<Four>(k, kCableAnchorA + side));
      put(k, kCableEndA + side, end), put(k, kCableMeanA + side, 0.5 * (start + end));
      return vec<Four>(w, kJointWay) + (end - start);
    };
    const Vec<Four> of_a = tie(n).a != kNoColumn ? moved(tie(n).a, 0) : Vec<Four>{};
    const Vec<Four> of_b = moved(tie(n).b, 3);
    put(k, kCableNow, vec<Four>(k, kCableBefore) + (of_b - of_a - vec<Four>(k, kCableWay)));
  }
  Mask has_to_change(std::size_t n) const {
    const double* const k = at(n);
    const Vec<Four> sum = vec<Four>(k, kCableBefore) + vec<Four>(k, kCableNow);
    const Four pull = dot(vec<Four>(k, kCableMu), normalized(sum));
    const auto pushes = pull * num<Four>(k, kCableSoftness) < least_;
    const auto too_long = over_of(k) > near_;
    const Four kinds = num<Four>(k, kCableKind), waits = num<Four>(k, kCableFollowed);
    return ((kinds == kTautTie) & pushes) | ((kinds + waits == kSlackTie) & too_long);
  }
  void change(std::size_t n, std::size_t l) const {
    double* const k = at(n) + l;
    double& kind = k[kCableKind * kLanes];
    kind = kind == kTautTie ? kSlackTie : kTautTie;
    for (std::size_t i = 0; i < 3; ++i) k[(kCableMu + i) * kLanes] = 0;
    k[kCableSoftness * kLanes] = 0;
  }

  Load load_of(std::size_t n, Four h) const {
    const double* const k = at(n);
    const Vec<Four> before = vec<Four>(k, kCableBefore), now = vec<Four>(k, kCableNow);
    const Four length = num<Four>(k, kCableLength), stiffness = num<Four>(k, kCableStiffness);
    const Four l0 = length_of(before), l1 = length_of(now), none = all(0);
    const Four over0 = choose(l0 > length, l0 - length, none),
               over1 = choose(l1 > length, l1 - length, none);
    const Vec<Four> mean = 0.5 * (before + now);
    const Four both = l0 + l1, squares = l1 * l1 - l0 * l0;
    const auto stretched0 = over0 > none, stretched1 = over1 > none;
    const Four of_both = stiffness * (1.0 - 2.0 * length / both);
    const Four by_both = 2.0 * stiffness * length / (both * both);
    const Four of_one = stiffness * (over1 * over1 - over0 * over0) / squares;
    const Four by_one = 2.0 * (stiffness * over1 - of_one * l1) / squares;
    const Four s =
        choose(stretched0, choose(stretched1, of_both, of_one), choose(stretched1, of_one, none));
    const Four by_length =
        choose(stretched0, choose(stretched1, by_both, by_one), choose(stretched1, by_one, none));
    const Four diagonal = 0.5 * h * (0.5 * s), f = 0.5 * h * by_length;
    const auto has_length = l1 > none;
    const Vec<Four> along{now.x / l1, now.y / l1, now.z / l1};
    const auto column_of = [&](Four component) {
      const Vec<Four> v{f * (mean.x * component), f * (mean.y * component),
                        f * (mean.z * component)};
      return chosen(has_length, v, Vec<Four>{});
    };
    Load load{0.5 * h * s * mean,
              {column_of(along.x), column_of(along.y), column_of(along.z)},
              0.5 * h * s};
    load.derivative[0].x += diagonal, load.derivative[1].y += diagonal;
    load.derivative[2].z += diagonal;
    return load;
  }
  static INLINE Vec<Four> times(Vec<Four> v, const Vec<Four> (&columns)[3]) {
    return {dot(v, columns[0]), dot(v, columns[1]), dot(v, columns[2])};
  }
  Mask stretched(std::size_t n) const {
    const double* const k = at(n);
    Four any = all(0);
    for (std::size_t i = 0; i < 9; ++i) {
      const Four d = num<Four>(k, kCableDerivative + i);
      any = choose(d == all(0), any, all(1));
    }
    return any > 0.5;
  }
  /// Whether the impulse of an elastic cable is not that of its length at the iterate.
  Mask is_not_followed(std::size_t n, Four h) const {
    const double* const k = at(n);
    const Load now = load_of(n, h);
    const Four own = num<Four>(k, kCableResponse);
    const Four response = choose(own > all(0), own, h / mass_);
    const Vec<Four> direction = normalized(vec<Four>(k, kCableBefore) + vec<Four>(k, kCableNow));
    const Four stiffness = length_of(times(direction, now.derivative));
    const Four off = response * length_of(now.mu - vec<Four>(k, kCableMu));
    const Four bound = kFollowed * size_ * (1.0 + response * stiffness);
    // What is no number is not followed.
    return choose(bound >= off, all(0), all(1)) > 0.5;
  }

  /// The row of a cable: see taut_rows and elastic_rows.
  void put_row(std::size_t n) {
    double* const k = at(n);
    const Vec<Four> now = vec<Four>(k, kCableNow);
    const Vec<Four> direction = normalized(vec<Four>(k, kCableBefore) + now);
    put(k, kCableDirection, direction);
    const Four turning = 0.5 * num<Four>(k, kCableAcross) * num<Four>(k, kCableResponse);
    const Four much = choose(turning < all(kSlight), all(0), num<Four>(k, kCableActs) * t_.running);
    if (any(much > 0.5))
      for (std::size_t l = 0; l < kLanes; ++l) alone_[l] = alone_[l] || much[l] > 0.5;
    if (tie(n).stretches) {
      const Vec<Four> columns[3] = {vec<Four>(k, kCableDerivative),
                                    vec<Four>(k, kCableDerivative + 3),
                                    vec<Four>(k, kCableDerivative + 6)};
      const Vec<Four> by = times(direction, columns);
      const Four stiffness = length_of(by);
      put(k, kCableBy, Vec<Four>{by.x / stiffness, by.y / stiffness, by.z / stiffness});
      write(k + kCableRight * kLanes, all(0)), write(k + kCableOwn * kLanes, 1.0 / stiffness);
      return;
    }
    const Four l = length_of(now), length = num<Four>(k, kCableLength);
    const Four softness = num<Four>(k, kCableSoftness);
    put(k, kCableBy, Vec<Four>{now.x / l, now.y / l, now.z / l});
    const Four too_long = 0.5 * (l - length * length / l);
    write(k + kCableRight * kLanes, softness * dot(direction, vec<Four>(k, kCableMu)) - too_long);
    write(k + kCableOwn * kLanes, softness);
  }

  INLINE void add_to_block(std::uint32_t c, Vec<Four> impulse, Vec<Four> mean, Vec<Four> end) {
    double* const b = t_.tie_block_at(c);
    const Vec<Four> f = 0.5 * impulse, torque = cross(mean, impulse);
    const Four along = dot(f, end);
    const Four e[3] = {end.x, end.y, end.z};
    for (std::size_t i = 0; i < 3; ++i) {
      Vec<Four> r = get_vec<Four>(b, 3 * i) + e[i] * f;
      (i == 0 ? r.x : i == 1 ? r.y : r.z) -= along;
      set_vec(b, 3 * i, r);
    }
    set_vec(b, 9, get_vec<Four>(b, 9) + impulse), set_vec(b, 12, get_vec<Four>(b, 12) + torque);
  }

  const ConservingLanes& all_;
  LaneTables& t_;
  Four size_ = all(1), mass_ = all(1), yield_ = all(1);  // of each island
  Four near_ = all(0);                                   // m: a cable is at its length
  Four least_ = all(0);  // m: by which one that pulls gives way at least
  bool alone_[kLanes] = {};
};

}  // namespace
}  // namespace pantin::detail::articulated

#pragma once
/// Laws of cables, vectorised over islands, one per lane; conserving_ties.cpp and slack_cables.cpp
/// are the code for one island.
#include "engine/solvers/articulated/kernels/lane_tables.hpp"
#include "engine/solvers/articulated/smooth/cable_law.hpp"

namespace pantin::detail::articulated {
namespace {

inline constexpr std::uint32_t kNoColumn = 0xffffffff;

/// Rotates a vector with the same bits as glm.
INLINE Vec<Lane> turned(Qua<Lane> q, Vec<Lane> v) {
  const Vec<Lane> u{q.x, q.y, q.z}, uv = cross(u, v);
  return v + 2.0 * (q.w * uv + cross(u, uv));
}
class LaneCableLaws {
 public:
  LaneCableLaws(const ConservingLanes& lanes, LaneTables& tables) : all_(lanes), t_(tables) {
    for (std::size_t l = 0; l < kWide; ++l) {
      const LaneIsland& own = all_.islands[l < all_.count ? l : 0];
      size_[l] = own.size, mass_[l] = own.mass, yield_[l] = own.yield, h_[l] = own.input.h;
    }
    near_ = kAtLength * size_, least_ = -1.0 * yield_ * near_;
  }

  /// Whether the equations of a lane need more than one row for a cable.
  bool is_alone(std::size_t l) const { return alone_[l]; }

 protected:
  /// Per lane, all bits set or none.
  using Mask = decltype(Lane{} < Lane{});

  std::size_t count() const { return all_.ties->count; }
  const LaneTies::Tie& tie(std::size_t n) const { return all_.ties->ties[n]; }
  const LaneIsland& island(std::size_t l) const { return all_.islands[l]; }
  bool runs(std::size_t l) const { return t_.running[l] > 0.5; }
  INLINE double* at(std::size_t n) const { return all_.tie_table + kLaneCableRows * kWide * n; }
  double kind(std::size_t n, std::size_t l) const { return at(n)[kCableKind * kWide + l]; }
  bool acts(std::size_t n, std::size_t l) const { return at(n)[kCableActs * kWide + l] > 0.5; }
  std::uint32_t& row(std::size_t r) const { return all_.tie_rows[r]; }
  std::uint32_t& row_of_tie(std::size_t n) const { return all_.tie_rows[count() + n]; }
  INLINE Mask taut(std::size_t n) const { return num<Lane>(at(n), kCableKind) == kTautTie; }
  INLINE Mask grounded(std::size_t n) const { return num<Lane>(at(n), kCableGrounded) > 0.5; }
  bool strikes(std::size_t l) const {
    for (std::size_t n = 0; n < count(); ++n)
      if (kind(n, l) == kStrikingTie) return true;
    return false;
  }
  static INLINE bool any(Mask mask) {
    auto some = mask[0];
    for (std::size_t l = 1; l < kWide; ++l) some |= mask[l];
    return some != 0;
  }
  static INLINE Lane ones(Mask mask) { return choose(mask, all<Lane>(1), all<Lane>(0)); }
  /// m: stretch of a cable at the iterate, negative if slack.
  static INLINE Lane over_of(const double* k) {
    return length_of(vec<Lane>(k, kCableNow)) - num<Lane>(k, kCableLength);
  }
  /// Updates arms and d at the iterate.
  void look_at(std::size_t n) {
    double* const k = at(n);
    const auto moved = [&](std::uint32_t c, std::size_t side) {
      const double* const w = t_.work_at(c);
      const Vec<Lane> start = vec<Lane>(k, kCableStartA + side);
      const Vec<Lane> end = turned(qua<Lane>(w, kEndRotation), vec<Lane>(k, kCableAnchorA + side));
      put(k, kCableEndA + side, end), put(k, kCableMeanA + side, 0.5 * (start + end));
      return vec<Lane>(w, kJointWay) + (end - start);
    };
    const Vec<Lane> of_a = tie(n).a != kNoColumn ? moved(tie(n).a, 0) : Vec<Lane>{};
    const Vec<Lane> of_b = moved(tie(n).b, 3);
    put(k, kCableNow, vec<Lane>(k, kCableBefore) + (of_b - of_a - vec<Lane>(k, kCableWay)));
  }
  Mask has_to_change(std::size_t n) const {
    const double* const k = at(n);
    const Lane pull = dot(vec<Lane>(k, kCableMu), direction_of(span_of(k)));
    const auto pushes = pull * num<Lane>(k, kCableSoftness) < least_;
    const auto too_long = over_of(k) > near_;
    const Lane kinds = num<Lane>(k, kCableKind), waits = num<Lane>(k, kCableFollowed);
    // A followed cable stays slack until it reaches its length: its sum is not kSlackTie.
    return ((kinds == kTautTie) & pushes) | ((kinds + waits == kSlackTie) & too_long);
  }
  void change(std::size_t n, std::size_t l) const {
    double* const k = at(n) + l;
    double& kind = k[kCableKind * kWide];
    kind = kind == kTautTie ? kSlackTie : kTautTie;
    for (std::size_t i = 0; i < 3; ++i) k[(kCableMu + i) * kWide] = 0;
    k[kCableSoftness * kWide] = 0;
  }

  INLINE CableSpan<Vec<Lane>> span_of(const double* k) const {
    return {vec<Lane>(k, kCableBefore), vec<Lane>(k, kCableNow)};
  }
  CableLoad<Vec<Lane>, Lane> load_of(std::size_t n) const {
    const double* const k = at(n);
    return load_of_cable(span_of(k), num<Lane>(k, kCableLength), num<Lane>(k, kCableStiffness), h_);
  }
  Mask stretched(std::size_t n) const {
    const double* const k = at(n);
    Lane any = all<Lane>(0);
    for (std::size_t i = 0; i < 9; ++i) {
      const Lane d = num<Lane>(k, kCableDerivative + i);
      any = choose(d == all<Lane>(0), any, all<Lane>(1));
    }
    return any > 0.5;
  }
  /// Whether the impulse of an elastic cable has not converged to that of its length.
  Mask is_not_followed(std::size_t n) const {
    const double* const k = at(n);
    const CableLoad<Vec<Lane>, Lane> now = load_of(n);
    const Lane own = num<Lane>(k, kCableResponse);
    const Lane response = choose(own > all<Lane>(0), own, h_ / mass_);
    const Lane stiffness = length_of(times_columns(direction_of(span_of(k)), now.derivative));
    const Lane off = response * length_of(now.mu - vec<Lane>(k, kCableMu));
    const Lane bound = kFollowed * size_ * (1.0 + response * stiffness);
    // NaN counts as not converged.
    return choose(bound >= off, all<Lane>(0), all<Lane>(1)) > 0.5;
  }

  /// Writes the row of a cable: see taut_rows and elastic_rows.
  void put_row(std::size_t n) {
    double* const k = at(n);
    const Lane turning = 0.5 * num<Lane>(k, kCableAcross) * num<Lane>(k, kCableResponse);
    const Lane much = choose((turning < all<Lane>(kSlight)) | grounded(n), all<Lane>(0),
                             num<Lane>(k, kCableActs) * t_.running);
    if (any(much > 0.5))
      for (std::size_t l = 0; l < kWide; ++l) alone_[l] = alone_[l] || much[l] > 0.5;
    const Vec<Lane> derivative[3] = {vec<Lane>(k, kCableDerivative),
                                     vec<Lane>(k, kCableDerivative + 3),
                                     vec<Lane>(k, kCableDerivative + 6)};
    const CableEquation<Vec<Lane>, Lane> e =
        tie(n).stretches
            ? equation_of_elastic(span_of(k), derivative)
            : equation_of_taut(span_of(k), vec<Lane>(k, kCableMu), num<Lane>(k, kCableLength),
                               num<Lane>(k, kCableSoftness));
    put(k, kCableDirection, e.direction), put(k, kCableBy, e.by);
    write(k + kCableRight * kWide, e.right), write(k + kCableOwn * kWide, e.own);
  }

  INLINE void add_to_block(std::uint32_t c, Vec<Lane> impulse, Vec<Lane> mean, Vec<Lane> end) {
    double* const b = t_.tie_block_at(c);
    const Vec<Lane> f = 0.5 * impulse, torque = cross(mean, impulse);
    const Lane along = dot(f, end);
    const Lane e[3] = {end.x, end.y, end.z};
    for (std::size_t i = 0; i < 3; ++i) {
      Vec<Lane> r = get_vec<Lane>(b, 3 * i) + e[i] * f;
      (i == 0 ? r.x : i == 1 ? r.y : r.z) -= along;
      set_vec(b, 3 * i, r);
    }
    set_vec(b, 9, get_vec<Lane>(b, 9) + impulse), set_vec(b, 12, get_vec<Lane>(b, 12) + torque);
  }
  /// Adds the derivative of the impulse of a grounded cable to its body's block.
  INLINE void add_grounded(std::size_t n) {
    const double* const k = at(n);
    double* const b = t_.tie_block_at(tie(n).b);
    Vec<Lane> columns[3];
    for (std::size_t i = 0; i < 3; ++i)
      columns[i] = num<Lane>(k, kCableGrounded) * vec<Lane>(k, kCableDerivative + 3 * i);
    const GroundedBlock<Vec<Lane>> own =
        grounded_block(columns, vec<Lane>(k, kCableMeanB), vec<Lane>(k, kCableEndB));
    const auto add = [&](std::size_t to, const Vec<Lane>(&rows)[3]) {
      for (std::size_t i = 0; i < 3; ++i)
        set_vec(b, to + 3 * i, get_vec<Lane>(b, to + 3 * i) + rows[i]);
    };
    add(kTieTurn, own.tt), add(kTieTurnMove, own.ty);
    add(kTieMoveTurn, own.yt), add(kTieMoveMove, own.yy);
  }

  const ConservingLanes& all_;
  LaneTables& t_;
  Lane size_ = all<Lane>(1), mass_ = all<Lane>(1), yield_ = all<Lane>(1);  // of each island
  Lane h_ = all<Lane>(1);                                                  // s
  Lane near_ = all<Lane>(0);   // m: tolerance of a cable's length
  Lane least_ = all<Lane>(0);  // m: a taut cable pushes if compliance times impulse is below
  bool alone_[kWide] = {};
};

}  // namespace
}  // namespace pantin::detail::articulated

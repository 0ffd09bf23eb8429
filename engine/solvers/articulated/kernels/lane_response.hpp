#pragma once
/// Cables of islands side by side: how the bodies answer their impulses, as tie_response.cpp has it
/// for one island. A cable that acts in any lane has a row in all of them; each lane solves those
/// of its own.
#include "engine/solvers/articulated/kernels/lane_cable_laws.hpp"

namespace pantin::detail::articulated {
namespace {

/// By rows, as factors of ties and nodes have them.
struct MatrixRows {
  Vec<Four> x, y, z;
};
INLINE Vec<Four> mul(const MatrixRows& m, Vec<Four> v) {
  return {dot(m.x, v), dot(m.y, v), dot(m.z, v)};
}
INLINE Vec<Four> mul(Vec<Four> v, const MatrixRows& m) {
  return (v.x * m.x + v.y * m.y) + v.z * m.z;
}

/// Rows of what passes along a path from a cable to the root, and of a share.
enum LanePassing : std::size_t {
  kPassedImpulse = 0,  // 3, likewise below
  kPassedTorque = 3,
  kPassedByMove = 6,
  kPassedByTurn = 9,
  kPassingRows = 12,
  kShareTurn = 0,
  kShareByTurn = 3,
  kShareRows = 6
};

/// Arms of impulses: at the means of the poses, or at the end.
enum class LaneArms : std::uint8_t { mean, end };

class LaneResponse : public LaneCableLaws {
 public:
  using LaneCableLaws::LaneCableLaws;

  /// Numbers of memory beyond the tables.
  struct Room {
    double *blocks, *factors, *impulses, *torques, *joints, *passing, *shares, *matrix;
    Room(LaneMemory& memory, const LaneTies& ties, std::size_t bodies) {
      blocks = memory.take(kTieBlock * bodies), factors = memory.take(kTieFactor * bodies);
      impulses = memory.take(3 * bodies), torques = memory.take(3 * bodies);
      joints = memory.take(3 * bodies), passing = memory.take(kPassingRows * ties.longest);
      shares = memory.take(kShareRows * ties.steps), matrix = memory.take(ties.count * ties.count);
    }
    Room() = default;
  };
  void lay_out(LaneMemory& memory) {
    room_ = Room(memory, *all_.ties, t_.count);
    t_.tie_blocks = room_.blocks, t_.tie_factors = room_.factors;
  }

 protected:
  /// What is solved for, and for which lanes.
  struct Solve {
    LaneArms arms;
    Four h;
    bool wanted[kLanes];
  };
  // What the elimination left of a body: see BallNodes.
  INLINE MatrixRows factor(std::size_t c, std::size_t i) const {
    const double* f = t_.tie_factor_at(c);
    return {get_vec<Four>(f, i), get_vec<Four>(f, i + 3), get_vec<Four>(f, i + 6)};
  }
  INLINE MatrixRows compliance(std::size_t c) const { return factor(c, 0); }
  INLINE MatrixRows crossing(std::size_t c) const { return factor(c, 9); }
  INLINE MatrixRows of_node(std::size_t c, std::size_t i) const {
    const double* n = t_.node_at(c);
    return {get_vec<Four>(n, i), get_vec<Four>(n, i + 4), get_vec<Four>(n, i + 8)};
  }
  /// Of the turn by a displacement of the own joint: the negative.
  INLINE MatrixRows minus_turn_y(std::size_t c) const { return of_node(c, kResponse); }
  INLINE MatrixRows force_y(std::size_t c) const { return of_node(c, kArticulatedMass); }
  INLINE Vec<Four> reach(std::size_t c, LaneArms arms) const {
    return vec<Four>(t_.work_at(c), arms == LaneArms::mean ? kMeanReach : kEndReach);
  }

  /// What an impulse along the row of a cable turns on its path, and what the row asks there.
  void fill_shares(std::size_t n, double* shares, LaneArms arms) const {
    const double* const k = at(n);
    const TiePathStep* const path = all_.ties->paths + tie(n).path;
    const std::size_t steps = tie(n).count;
    const auto passing = [&](std::size_t i) { return room_.passing + kPassingRows * kLanes * i; };
    for (std::size_t i = 0; i < kPassingRows * steps; ++i)
      store(room_.passing + i * kLanes, all(0));
    const auto add = [&](double* to, std::size_t i, Vec<Four> v) {
      set_vec(to, i, get_vec<Four>(to, i) + v);
    };
    const auto begin = [&](std::uint32_t c, std::size_t side, double sign) {
      std::size_t i = 0;
      while (path[i].column != c) ++i;
      const Vec<Four> end = vec<Four>(k, kCableEndA + side);
      const Vec<Four> on = arms == LaneArms::mean ? vec<Four>(k, kCableMeanA + side) : end;
      const Vec<Four> impulse = -sign * vec<Four>(k, kCableDirection),
                      asked = sign * vec<Four>(k, kCableBy);
      double* const to = passing(i);
      add(to, kPassedImpulse, impulse), add(to, kPassedTorque, cross(on, impulse));
      add(to, kPassedByMove, asked), add(to, kPassedByTurn, cross(end, asked));
    };
    begin(tie(n).b, 3, 1);
    if (tie(n).a != kNoColumn) begin(tie(n).a, 0, -1);
    for (std::size_t i = 0; i < steps; ++i) {
      const std::size_t c = path[i].column;
      const double* const own = passing(i);
      double* const share = shares + kShareRows * kLanes * i;
      if (c >= t_.count) {  // the place of a free root
        set_vec(share, kShareTurn,
                mul(inverse(force_y(c - t_.count)), get_vec<Four>(own, kPassedImpulse)));
        set_vec(share, kShareByTurn, get_vec<Four>(own, kPassedByMove));
        continue;
      }
      const Vec<Four> turn = mul(compliance(c), get_vec<Four>(own, kPassedTorque));
      const Vec<Four> by_turn = get_vec<Four>(own, kPassedByTurn);
      set_vec(share, kShareTurn, turn), set_vec(share, kShareByTurn, by_turn);
      if (path[i].parent == kNoColumn) continue;
      double* const p = passing(path[i].parent);
      const Vec<Four> impulse = get_vec<Four>(own, kPassedImpulse) - mul(crossing(c), turn);
      const Vec<Four> by_move = get_vec<Four>(own, kPassedByMove) - mul(by_turn, minus_turn_y(c));
      add(p, kPassedImpulse, impulse), add(p, kPassedByMove, by_move);
      if (all_.islands[0].view.parents[c] < 0) continue;
      add(p, kPassedTorque, cross(reach(c, arms), impulse));
      add(p, kPassedByTurn, cross(vec<Four>(t_.work_at(c), kEndReach), by_move));
    }
  }
  static INLINE MatrixRows inverse(const MatrixRows& m) {
    const Four c00 = m.y.y * m.z.z - m.y.z * m.z.y, c10 = m.x.y * m.z.z - m.x.z * m.z.y,
               c20 = m.x.y * m.y.z - m.x.z * m.y.y;
    const Four per =
        1.0 / (m.x.x * (m.y.y * m.z.z - m.y.z * m.z.y) - m.x.y * (m.y.x * m.z.z - m.y.z * m.z.x) +
               m.x.z * (m.y.x * m.z.y - m.y.y * m.z.x));
    const Four d01 = m.y.x * m.z.z - m.y.z * m.z.x, d11 = m.x.x * m.z.z - m.x.z * m.z.x,
               d21 = m.x.x * m.y.z - m.x.z * m.y.x;
    const Four e02 = m.y.x * m.z.y - m.y.y * m.z.x, e12 = m.x.x * m.z.y - m.x.y * m.z.x,
               e22 = m.x.x * m.y.y - m.x.y * m.y.x;
    return {{c00 * per, -(c10 * per), c20 * per},
            {-(d01 * per), d11 * per, -(d21 * per)},
            {e02 * per, -(e12 * per), e22 * per}};
  }

  double* shares_of(std::size_t r) const {
    return room_.shares + kShareRows * kLanes * tie(row(r)).path;
  }
  /// The matrix of the cables' rows.
  void fill_matrix(LaneArms arms) {
    for (std::size_t r = 0; r < rows_; ++r) fill_shares(row(r), shares_of(r), arms);
    const LaneTies& ties = *all_.ties;
    for (std::size_t r = 0; r < rows_; ++r)
      for (std::size_t s = 0; s < rows_; ++s) {
        const std::uint32_t* const from = ties.meeting_starts + row(r) * ties.count + row(s);
        const double *const of = shares_of(r), *const by = shares_of(s);
        Four sum = all(0);
        for (std::size_t i = from[0]; i < from[1]; ++i) {
          const TieMeeting at = ties.meetings[i];
          sum += dot(get_vec<Four>(of, kShareRows * at.on_first + kShareByTurn),
                     get_vec<Four>(by, kShareRows * at.on_second + kShareTurn));
        }
        store(matrix_at(r, s), sum);
      }
  }
  double* matrix_at(std::size_t r, std::size_t s) const {
    return room_.matrix + kLanes * (r * rows_ + s);
  }
  Four gain(std::size_t r) const { return load_four(all_.tie_gains + kLanes * r); }

  /// Change of d of a cable by the unknowns of the bodies.
  Vec<Four> change_of(std::size_t n) const {
    const double* const k = at(n);
    const auto of = [&](std::uint32_t c, std::size_t side) {
      const double* const m = t_.memory_at(c);
      return vec<Four>(m, kMove) + cross(vec<Four>(m, kTurnBy), vec<Four>(k, kCableEndA + side));
    };
    const Vec<Four> of_b = of(tie(n).b, 3);
    return tie(n).a != kNoColumn ? of_b - of(tie(n).a, 0) : of_b;
  }

  /// Solves for the impulses of the cables that act, and moves the bodies by them. False where none
  /// does.
  bool answer(const Solve& solve, bool (&fails)[kLanes]) {
    rows_ = 0;
    for (std::size_t n = 0; n < count(); ++n) {
      bool acts_in_any = false;
      for (std::size_t l = 0; l < kLanes; ++l)
        acts_in_any = acts_in_any || (solve.wanted[l] && acts(n, l));
      if (acts_in_any) row(rows_++) = static_cast<std::uint32_t>(n);
    }
    if (rows_ == 0) return false;
    fill_matrix(solve.arms);
    for (std::size_t r = 0; r < rows_; ++r) complete_row(r, solve);
    for (std::size_t l = 0; l < kLanes; ++l) {
      for (std::size_t r = 0; r < rows_; ++r) all_.tie_gains[kLanes * r + l] = 0;
      if (solve.wanted[l] && !solve_lane(l)) fails[l] = true;
    }
    respond(solve.arms);
    return true;
  }
  /// What is a cable's own, with its softness if it has none yet.
  void complete_row(std::size_t r, const Solve& solve) {
    const std::size_t n = row(r);
    double* const k = at(n);
    const Four diagonal = load_four(matrix_at(r, r));
    Four wanted = num<Four>(k, kCableActs);
    for (std::size_t l = 0; l < kLanes; ++l)
      if (!solve.wanted[l]) wanted[l] = 0;
    const auto is_asked = wanted > 0.5;
    const Four response = choose(diagonal > all(0), diagonal, -1.0 * diagonal);
    write(k + kCableResponse * kLanes, choose(is_asked, response, num<Four>(k, kCableResponse)));
    const Four softness = num<Four>(k, kCableSoftness);
    write(k + kCableSoftness * kLanes,
          choose(is_asked & (softness == 0.0), yield_ * response, softness));
    if (solve.arms == LaneArms::mean)
      put_row(n);
    else
      write(k + kCableOwn * kLanes, num<Four>(k, kCableSoftness));
    store(matrix_at(r, r), diagonal - num<Four>(k, kCableOwn));
    const Four right = num<Four>(k, kCableRight) - dot(change_of(n), vec<Four>(k, kCableBy));
    write(k + kCableRight * kLanes, right);
  }
  bool solve_lane(std::size_t l) {
    const LaneIsland& own = island(l);
    std::size_t size = 0;
    for (std::size_t r = 0; r < rows_; ++r) size += acts(row(r), l);
    if (size == 0) return true;
    std::size_t i = 0;
    for (std::size_t r = 0; r < rows_; ++r) {
      if (!acts(row(r), l)) continue;
      std::size_t j = 0;
      for (std::size_t s = 0; s < rows_; ++s)
        if (acts(row(s), l)) own.matrix[i * size + j++] = matrix_at(r, s)[l];
      own.solution[i++] = at(row(r))[kCableRight * kLanes + l];
    }
    if (!own.solve(own.context, size)) return false;
    i = 0;
    for (std::size_t r = 0; r < rows_; ++r)
      if (acts(row(r), l)) all_.tie_gains[kLanes * r + l] = own.solution[i++];
    return true;
  }

  /// The motion of the bodies by the impulses found; see respond in tie_response.cpp.
  void respond(LaneArms arms) {
    const std::int32_t* const parents = all_.islands[0].view.parents;
    for (std::size_t i = 0; i < 3 * t_.count; ++i)
      store(room_.impulses + i * kLanes, all(0)), store(room_.torques + i * kLanes, all(0));
    const auto add = [&](double* to, std::size_t c, Vec<Four> v) {
      set_vec(to, 3 * c, get_vec<Four>(to, 3 * c) + v);
    };
    for (std::size_t r = 0; r < rows_; ++r) {
      const double* const k = at(row(r));
      const Vec<Four> mu = gain(r) * vec<Four>(k, kCableDirection);
      const auto act = [&](std::uint32_t c, std::size_t side, double sign) {
        const Vec<Four> on =
            vec<Four>(k, (arms == LaneArms::mean ? kCableMeanA : kCableEndA) + side);
        add(room_.impulses, c, sign * mu), add(room_.torques, c, sign * cross(on, mu));
      };
      act(tie(row(r)).b, 3, -1);
      if (tie(row(r)).a != kNoColumn) act(tie(row(r)).a, 0, 1);
    }
    for (std::size_t c = t_.count; c-- > 0;) {
      const Vec<Four> turn = mul(compliance(c), get_vec<Four>(room_.torques, 3 * c));
      const Vec<Four> impulse = get_vec<Four>(room_.impulses, 3 * c) - mul(crossing(c), turn);
      set_vec(room_.impulses, 3 * c, impulse), set_vec(room_.torques, 3 * c, turn);
      if (parents[c] < 0) continue;
      const auto p = static_cast<std::size_t>(parents[c]);
      add(room_.impulses, p, impulse), add(room_.torques, p, cross(reach(c, arms), impulse));
    }
    for (std::size_t c = 0; c < t_.count; ++c) {
      const MatrixRows mass = force_y(c);
      const Vec<Four> impulse = get_vec<Four>(room_.impulses, 3 * c);
      Vec<Four> y{};
      if (parents[c] >= 0) {
        const auto p = static_cast<std::size_t>(parents[c]);
        y = get_vec<Four>(room_.impulses, 3 * p) +
            cross(get_vec<Four>(room_.torques, 3 * p), vec<Four>(t_.work_at(c), kEndReach));
      } else if (parents[c] == kFree) {
        y = mul(inverse(mass), impulse);
      }
      set_vec(room_.joints, 3 * c, mul(mass, y) - impulse);
      set_vec(room_.impulses, 3 * c, y);
      const Vec<Four> turn = get_vec<Four>(room_.torques, 3 * c) - mul(minus_turn_y(c), y);
      set_vec(room_.torques, 3 * c, turn);
      double* const m = t_.memory_at(c);
      put(m, kMove, vec<Four>(m, kMove) + y), put(m, kTurnBy, vec<Four>(m, kTurnBy) + turn);
    }
  }
  /// What the cables' impulses add to those at the joints.
  void add_joint_impulses(double share) {
    for (std::size_t c = 0; c < t_.count; ++c) {
      double* const m = t_.memory_at(c);
      const Vec<Four> before = vec<Four>(m, kLambda);
      const Vec<Four> after = before + share * get_vec<Four>(room_.joints, 3 * c);
      put(m, kLambda, share == 1 ? t_.kept(after, before) : after);
    }
  }

  Room room_;
  std::size_t rows_ = 0;
};

}  // namespace
}  // namespace pantin::detail::articulated

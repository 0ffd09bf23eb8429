#pragma once
/// Response of the bodies to impulses of cables, vectorised over islands; tie_response.cpp is the
/// code for one island. A cable active in any lane has a row in all lanes, a trivial one in others.
#include "engine/solvers/articulated/kernels/lane_cable_laws.hpp"

namespace pantin::detail::articulated {
namespace {

/// Rows of the quantities accumulated along a path from a cable to the root: see TiePassing.
enum LanePassing : std::size_t {
  kPassedImpulse = 0,  // 3, likewise below
  kPassedTorque = 3,
  kPassedByMove = 6,
  kPassedByTurn = 9,
  kPassingRows = 12
};

/// Arms of impulses: at the means of the poses, or at the end.
enum class LaneArms : std::uint8_t { mean, end };

class LaneResponse : public LaneCableLaws {
  using Matrix = MatrixRows<Lane>;

 public:
  using LaneCableLaws::LaneCableLaws;

  /// Workspace beyond the tables.
  struct Room {
    double *blocks, *factors, *impulses, *torques, *joints, *passing, *asked, *turns, *matrix;
    Room(LaneMemory& memory, const LaneTies& ties, std::size_t bodies) {
      blocks = memory.take(kTieBlock * bodies), factors = memory.take(kTieFactor * bodies);
      impulses = memory.take(3 * bodies), torques = memory.take(3 * bodies);
      joints = memory.take(3 * bodies), passing = memory.take(kPassingRows * ties.longest);
      asked = memory.take(3 * ties.steps), turns = memory.take(3 * ties.steps),
      matrix = memory.take(ties.count * ties.count);
    }
    Room() = default;
  };
  void lay_out(LaneMemory& memory) {
    room_ = Room(memory, *all_.ties, t_.count);
    t_.tie_blocks = room_.blocks, t_.tie_factors = room_.factors;
  }

 protected:
  /// The arms of the impulses, and the lanes that are solved.
  struct Solve {
    LaneArms arms;
    Lane asked;  // 1 for solved lanes, else 0
  };
  // Results of the elimination for a body: see BallNodes.
  INLINE Matrix factor(std::size_t c, std::size_t i) const {
    const double* f = t_.tie_factor_at(c);
    return {get_vec<Lane>(f, i), get_vec<Lane>(f, i + 3), get_vec<Lane>(f, i + 6)};
  }
  INLINE Matrix compliance(std::size_t c) const { return factor(c, 0); }
  INLINE Matrix crossing(std::size_t c) const { return factor(c, 9); }
  INLINE Matrix of_node(std::size_t c, std::size_t i) const {
    return Matrix::from(t_.node_at(c), i);
  }
  /// Minus the rotation per displacement of the own joint.
  INLINE Matrix minus_turn_y(std::size_t c) const { return of_node(c, kResponse); }
  INLINE Matrix force_y(std::size_t c) const { return of_node(c, kArticulatedMass); }
  INLINE Vec<Lane> reach(std::size_t c, LaneArms arms) const {
    return vec<Lane>(t_.work_at(c), arms == LaneArms::mean ? kMeanReach : kEndReach);
  }

  /// What a cable's row passes on along its path: see TiePassing.
  struct Passed {
    Vec<Lane> impulse, torque, by_move, by_turn;
    INLINE void add(const Passed& o) {
      impulse = impulse + o.impulse, torque = torque + o.torque;
      by_move = by_move + o.by_move, by_turn = by_turn + o.by_turn;
    }
  };
  /// Rows of a cable's end after those of end a.
  enum class End : std::size_t { a = 0, b = 3 };
  static INLINE Passed passed_at(const double* k, End on_end, LaneArms arms) {
    const auto side = static_cast<std::size_t>(on_end);
    const double sign = on_end == End::b ? 1 : -1;
    const Vec<Lane> end = vec<Lane>(k, kCableEndA + side);
    const Vec<Lane> on = arms == LaneArms::mean ? vec<Lane>(k, kCableMeanA + side) : end;
    const Vec<Lane> impulse = -sign * vec<Lane>(k, kCableDirection),
                    asked = sign * vec<Lane>(k, kCableBy);
    return {impulse, cross(on, impulse), asked, cross(end, asked)};
  }
  /// Writes the shares at a step of a path. False at the end of the path; else `sum` becomes what
  /// is passed on.
  INLINE bool share(std::size_t step, LaneArms arms, Passed& sum) const {
    const TiePathStep& at = all_.ties->paths[step];
    const std::size_t c = at.column;
    double* const turned = room_.turns + 3 * kWide * place_of(step);
    if (c >= t_.count) {  // the displacement of a free root
      set_vec(turned, 0, mul(inverse(force_y(c - t_.count)), sum.impulse));
      set_vec(room_.asked, 3 * step, sum.by_move);
      return false;
    }
    const Vec<Lane> turn = mul(compliance(c), sum.torque), by_turn = sum.by_turn;
    set_vec(turned, 0, turn), set_vec(room_.asked, 3 * step, by_turn);
    if (at.parent == kNoColumn) return false;
    sum.impulse = sum.impulse - mul(crossing(c), turn);
    sum.by_move = sum.by_move - mul(by_turn, minus_turn_y(c));
    if (all_.islands[0].view.parents[c] < 0) {
      sum.torque = sum.by_turn = Vec<Lane>{};
      return true;
    }
    sum.torque = cross(reach(c, arms), sum.impulse);
    sum.by_turn = cross(vec<Lane>(t_.work_at(c), kEndReach), sum.by_move);
    return true;
  }
  /// The shares on a path on which each body is the parent of the one before.
  void fill_chain(std::size_t n, LaneArms arms) const {
    const double* const k = at(n);
    const LaneTies::Tie& own = tie(n);
    Passed sum{};
    for (std::size_t step = own.path; step < own.path + own.count; ++step) {
      const std::uint32_t c = all_.ties->paths[step].column;
      if (c == own.b) sum.add(passed_at(k, End::b, arms));
      if (c == own.a) sum.add(passed_at(k, End::a, arms));
      if (!share(step, arms, sum)) return;
    }
  }
  /// Fills the shares of a cable's row on its path: see TieShare.
  void fill_shares(std::size_t n, LaneArms arms) const {
    const double* const k = at(n);
    const TiePathStep* const path = all_.ties->paths + tie(n).path;
    const std::size_t steps = tie(n).count;
    if (tie(n).is_chain) return fill_chain(n, arms);
    const auto passing = [&](std::size_t i) { return room_.passing + kPassingRows * kWide * i; };
    for (std::size_t i = 0; i < kPassingRows * steps; ++i)
      store(room_.passing + i * kWide, all<Lane>(0));
    const auto add = [&](double* to, std::size_t i, Vec<Lane> v) {
      set_vec(to, i, get_vec<Lane>(to, i) + v);
    };
    const auto begin = [&](std::uint32_t c, End on_end) {
      std::size_t i = 0;
      while (path[i].column != c) ++i;
      const Passed at_end = passed_at(k, on_end, arms);
      double* const to = passing(i);
      add(to, kPassedImpulse, at_end.impulse), add(to, kPassedTorque, at_end.torque);
      add(to, kPassedByMove, at_end.by_move), add(to, kPassedByTurn, at_end.by_turn);
    };
    begin(tie(n).b, End::b);
    if (tie(n).a != kNoColumn) begin(tie(n).a, End::a);
    for (std::size_t i = 0; i < steps; ++i) {
      double* const own = passing(i);
      Passed sum{get_vec<Lane>(own, kPassedImpulse), get_vec<Lane>(own, kPassedTorque),
                 get_vec<Lane>(own, kPassedByMove), get_vec<Lane>(own, kPassedByTurn)};
      if (!share(tie(n).path + i, arms, sum)) continue;
      double* const p = passing(path[i].parent);
      add(p, kPassedImpulse, sum.impulse), add(p, kPassedByMove, sum.by_move);
      add(p, kPassedTorque, sum.torque), add(p, kPassedByTurn, sum.by_turn);
    }
  }
  static INLINE Matrix inverse(const Matrix& m) {
    const Lane c00 = m.y.y * m.z.z - m.y.z * m.z.y, c10 = m.x.y * m.z.z - m.x.z * m.z.y,
               c20 = m.x.y * m.y.z - m.x.z * m.y.y;
    const Lane per =
        1.0 / (m.x.x * (m.y.y * m.z.z - m.y.z * m.z.y) - m.x.y * (m.y.x * m.z.z - m.y.z * m.z.x) +
               m.x.z * (m.y.x * m.z.y - m.y.y * m.z.x));
    const Lane d01 = m.y.x * m.z.z - m.y.z * m.z.x, d11 = m.x.x * m.z.z - m.x.z * m.z.x,
               d21 = m.x.x * m.y.z - m.x.z * m.y.x;
    const Lane e02 = m.y.x * m.z.y - m.y.y * m.z.x, e12 = m.x.x * m.z.y - m.x.y * m.z.x,
               e22 = m.x.x * m.y.y - m.x.y * m.y.x;
    return {{c00 * per, -(c10 * per), c20 * per},
            {-(d01 * per), d11 * per, -(d21 * per)},
            {e02 * per, -(e12 * per), e22 * per}};
  }

  /// Lists the steps of active cables column by column: their rows, and where their rotations are
  /// stored.
  void list_steps() {
    const LaneTies& ties = *all_.ties;
    for (std::size_t c = 0; c < 2 * t_.count; ++c) {
      std::uint32_t next = ties.column_starts[c];
      for (std::size_t k = next, end = ties.column_starts[c + 1]; k < end; ++k) {
        const std::uint32_t r = row_of_tie(ties.tie_at[k]);
        if (r == kNoColumn) continue;
        row_at(next) = r, all_.tie_rows[2 * count() + ties.steps + k] = next++;
      }
      end_of(c) = next;
    }
  }
  std::uint32_t& row_at(std::size_t place) const { return all_.tie_rows[2 * count() + place]; }
  std::size_t place_of(std::size_t step) const {
    return all_.tie_rows[2 * count() + all_.ties->steps + all_.ties->positions[step]];
  }
  std::uint32_t& end_of(std::size_t column) const {
    return all_.tie_rows[2 * count() + 2 * all_.ties->steps + column];
  }
  /// Fills the matrix of the cables' rows.
  void fill_matrix(LaneArms arms) {
    list_steps();
    for (std::size_t r = 0; r < rows_; ++r) fill_shares(row(r), arms);
    const LaneTies& ties = *all_.ties;
    for (std::size_t r = 0; r < rows_; ++r) {
      double* const to = matrix_at(r, 0);
      for (std::size_t s = 0; s < rows_; ++s) store(to + kWide * s, all<Lane>(0));
      const LaneTies::Tie& own = tie(row(r));
      for (std::size_t i = own.path; i < own.path + own.count; ++i) {
        const Vec<Lane> ask = get_vec<Lane>(room_.asked, 3 * i);
        const std::size_t c = ties.paths[i].column, first = ties.column_starts[c];
        const double* turn = room_.turns + 3 * kWide * first;
        for (std::size_t k = first, end = end_of(c); k < end; ++k, turn += 3 * kWide) {
          double* const at = to + kWide * row_at(k);
          store(at, read<Lane>(at) + dot(ask, get_vec<Lane>(turn, 0)));
        }
      }
    }
  }
  double* matrix_at(std::size_t r, std::size_t s) const {
    return room_.matrix + kWide * (r * rows_ + s);
  }
  double* gain_at(std::size_t r) const { return all_.tie_gains + kWide * r; }
  Lane gain(std::size_t r) const { return read<Lane>(gain_at(r)); }
  /// Lanes that are solved and in which the cable is active.
  INLINE Mask wanted(const Solve& solve, std::size_t n) const {
    return (num<Lane>(at(n), kCableActs) * solve.asked) > 0.5;
  }

  /// Change of d of a cable by the unknowns of the bodies.
  Vec<Lane> change_of(std::size_t n) const {
    const double* const k = at(n);
    const auto of = [&](std::uint32_t c, std::size_t side) {
      const double* const m = t_.memory_at(c);
      return vec<Lane>(m, kMove) + cross(vec<Lane>(m, kTurnBy), vec<Lane>(k, kCableEndA + side));
    };
    const Vec<Lane> of_b = of(tie(n).b, 3);
    return tie(n).a != kNoColumn ? of_b - of(tie(n).a, 0) : of_b;
  }

  /// Solves for the impulses of the active cables, and adds their motion to the bodies. False if no
  /// cable is active.
  bool answer(const Solve& solve, bool (&fails)[kWide]) {
    rows_ = 0;
    for (std::size_t n = 0; n < count(); ++n) {
      const bool acts = any(wanted(solve, n));
      row_of_tie(n) = acts ? static_cast<std::uint32_t>(rows_) : kNoColumn;
      if (acts) row(rows_++) = static_cast<std::uint32_t>(n);
    }
    if (rows_ == 0) return false;
    fill_matrix(solve.arms);
    for (std::size_t r = 0; r < rows_; ++r) complete_row(r, solve);
    solve_lanes(solve);
    for (std::size_t l = 0; l < kWide; ++l) fails[l] = fails[l] || alone_[l];
    respond(solve.arms);
    return true;
  }
  /// Adds a cable's own diagonal entry and right-hand side; sets its compliance if unset.
  void complete_row(std::size_t r, const Solve& solve) {
    const std::size_t n = row(r);
    double* const k = at(n);
    const Lane diagonal = read<Lane>(matrix_at(r, r));
    const Mask is_asked = wanted(solve, n);
    const Lane response = choose(diagonal > all<Lane>(0), diagonal, -1.0 * diagonal);
    const Lane least = kRigidPart * ((solve.arms == LaneArms::mean ? h_ : all<Lane>(1)) / mass_);
    write(k + kCableResponse * kWide, choose(is_asked, response, num<Lane>(k, kCableResponse)));
    const Lane softness = num<Lane>(k, kCableSoftness);
    write(k + kCableSoftness * kWide,
          choose(is_asked & (softness == 0.0), yield_ * choose(response > least, response, least),
                 softness));
    if (solve.arms == LaneArms::mean)
      put_row(n);
    else
      write(k + kCableOwn * kWide, num<Lane>(k, kCableSoftness));
    store(matrix_at(r, r), diagonal - num<Lane>(k, kCableOwn));
    const Lane right = num<Lane>(k, kCableRight) - dot(change_of(n), vec<Lane>(k, kCableBy));
    write(k + kCableRight * kWide, right);
  }
  /// Solves the equations of all lanes, with diagonal pivots; see Pivot::diagonal. A cable that is
  /// inactive in a lane has the row and column of an identity there.
  void solve_lanes(const Solve& solve) {
    Lane ok = all<Lane>(1);
    for (std::size_t r = 0; r < rows_; ++r) {
      const Mask own = wanted(solve, row(r));
      Lane most = all<Lane>(0), probe = most;
      for (std::size_t s = 0; s < rows_; ++s) {
        double* const at = matrix_at(r, s);
        const Lane own_entry = all<Lane>(r == s ? 1 : 0);
        const Lane entry = choose(own & wanted(solve, row(s)), read<Lane>(at), own_entry);
        const Lane size = choose(entry > all<Lane>(0), entry, -1.0 * entry);
        most = choose(size > most, size, most), probe += size;
        store(at, entry);
      }
      ok = choose(probe < all<Lane>(HUGE_VAL), ok, all<Lane>(0));
      const Lane by = choose(most > all<Lane>(0), 1.0 / most, all<Lane>(1));
      for (std::size_t s = 0; s < rows_; ++s)
        store(matrix_at(r, s), read<Lane>(matrix_at(r, s)) * by);
      const Lane right = choose(own, num<Lane>(at(row(r)), kCableRight), all<Lane>(0));
      store(gain_at(r), right * by);
    }
    const std::size_t n = rows_, stride = kWide * n;
    double *const m = room_.matrix, *const x = all_.tie_gains;
    for (std::size_t k = 0; k < n; ++k) {
      const double* const above = m + k * stride;
      const Lane pivot = read<Lane>(above + k * kWide), right = read<Lane>(x + k * kWide);
      const Lane size = choose(pivot > all<Lane>(0), pivot, -1.0 * pivot);
      ok = choose(size > all<Lane>(kSafePivot), ok, all<Lane>(0));
      const Lane per = 1.0 / pivot;
      for (std::size_t i = k + 1; i < n; ++i) {
        double* const own = m + i * stride;
        const Lane f = read<Lane>(own + k * kWide) * per;
        for (std::size_t j = (k + 1) * kWide; j < n * kWide; j += kWide)
          store(own + j, read<Lane>(own + j) - f * read<Lane>(above + j));
        store(x + i * kWide, read<Lane>(x + i * kWide) - f * right);
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      const double* const own = m + i * stride;
      Lane sum = read<Lane>(x + i * kWide);
      for (std::size_t j = i + 1; j < n; ++j)
        sum = sum - read<Lane>(own + j * kWide) * read<Lane>(x + j * kWide);
      store(x + i * kWide, sum / read<Lane>(own + i * kWide));
    }
    for (std::size_t l = 0; l < kWide; ++l)
      alone_[l] = alone_[l] || (solve.asked[l] > 0.5 && ok[l] < 0.5);
    // Unwanted lanes may hold NaN.
    for (std::size_t r = 0; r < rows_; ++r)
      store(gain_at(r), choose(wanted(solve, row(r)) & (ok > 0.5), gain(r), all<Lane>(0)));
  }

  /// Adds the response to the impulses to the bodies' motion; see respond in tie_response.cpp.
  void respond(LaneArms arms) {
    const std::int32_t* const parents = all_.islands[0].view.parents;
    for (std::size_t i = 0; i < 3 * t_.count; ++i)
      store(room_.impulses + i * kWide, all<Lane>(0)),
          store(room_.torques + i * kWide, all<Lane>(0));
    const auto add = [&](double* to, std::size_t c, Vec<Lane> v) {
      set_vec(to, 3 * c, get_vec<Lane>(to, 3 * c) + v);
    };
    for (std::size_t r = 0; r < rows_; ++r) {
      const double* const k = at(row(r));
      const Vec<Lane> mu = gain(r) * vec<Lane>(k, kCableDirection);
      const auto act = [&](std::uint32_t c, std::size_t side, double sign) {
        const Vec<Lane> on =
            vec<Lane>(k, (arms == LaneArms::mean ? kCableMeanA : kCableEndA) + side);
        add(room_.impulses, c, sign * mu), add(room_.torques, c, sign * cross(on, mu));
      };
      act(tie(row(r)).b, 3, -1);
      if (tie(row(r)).a != kNoColumn) act(tie(row(r)).a, 0, 1);
    }
    for (std::size_t c = t_.count; c-- > 0;) {
      const Vec<Lane> turn = mul(compliance(c), get_vec<Lane>(room_.torques, 3 * c));
      const Vec<Lane> impulse = get_vec<Lane>(room_.impulses, 3 * c) - mul(crossing(c), turn);
      set_vec(room_.impulses, 3 * c, impulse), set_vec(room_.torques, 3 * c, turn);
      if (parents[c] < 0) continue;
      const auto p = static_cast<std::size_t>(parents[c]);
      add(room_.impulses, p, impulse), add(room_.torques, p, cross(reach(c, arms), impulse));
    }
    for (std::size_t c = 0; c < t_.count; ++c) {
      const Matrix mass = force_y(c);
      const Vec<Lane> impulse = get_vec<Lane>(room_.impulses, 3 * c);
      Vec<Lane> y{};
      if (parents[c] >= 0) {
        const auto p = static_cast<std::size_t>(parents[c]);
        y = get_vec<Lane>(room_.impulses, 3 * p) +
            cross(get_vec<Lane>(room_.torques, 3 * p), vec<Lane>(t_.work_at(c), kEndReach));
      } else if (parents[c] == kFree) {
        y = mul(inverse(mass), impulse);
      }
      set_vec(room_.joints, 3 * c, mul(mass, y) - impulse);
      set_vec(room_.impulses, 3 * c, y);
      const Vec<Lane> turn = get_vec<Lane>(room_.torques, 3 * c) - mul(minus_turn_y(c), y);
      set_vec(room_.torques, 3 * c, turn);
      double* const m = t_.memory_at(c);
      put(m, kMove, vec<Lane>(m, kMove) + y), put(m, kTurnBy, vec<Lane>(m, kTurnBy) + turn);
    }
  }
  /// Adds the response to the cables' impulses to the impulses at the joints.
  void add_joint_impulses(double share) {
    for (std::size_t c = 0; c < t_.count; ++c) {
      double* const m = t_.memory_at(c);
      const Vec<Lane> before = vec<Lane>(m, kLambda);
      const Vec<Lane> after = before + share * get_vec<Lane>(room_.joints, 3 * c);
      put(m, kLambda, share == 1 ? t_.kept(after, before) : after);
    }
  }

  Room room_;
  std::size_t rows_ = 0;
};

}  // namespace
}  // namespace pantin::detail::articulated

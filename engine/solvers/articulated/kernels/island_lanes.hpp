#pragma once
/// Data of a step by the energy-momentum method (conserving.hpp) for a batch of islands of equal
/// structure, one per SIMD lane. Each lane depends on its own island only, bit for bit.
#include "engine/solvers/articulated/kernels/conserving.hpp"
#include "engine/solvers/articulated/kernels/lane_cables.hpp"

namespace pantin::detail::articulated {
namespace {

class IslandLanes {
 public:
  using Number = Lane;
  using Wide = Lane;
  static constexpr std::size_t kAtOnce = 1;
  static constexpr int kIslands = kWide;
  static constexpr bool kHooks = false;

  explicit IslandLanes(const ConservingLanes& all)
      : p(all.islands[0].view), lanes_(all), cables_(all, tables_) {
    LaneMemory memory{all.memory};
    tables_.lay_out(memory, p.count, trees_of(p));
    if (all.ties) cables_.lay_out(memory);
    for (int l = 0; l < kIslands; ++l)
      if (!is_used(l)) stop(l);
    read_islands();
  }

  const IslandView& p;  // of the first island: the common structure

  std::size_t count() const { return p.count; }
  const std::int32_t* parents() const { return p.parents; }
  Lane step_length() const { return h_; }
  static INLINE Lane spread(Lane x) { return x; }
  bool is_used(int l) const { return static_cast<std::size_t>(l) < lanes_.count; }
  /// Unused lanes repeat the first island.
  const LaneIsland& island(int l) const { return lanes_.islands[is_used(l) ? l : 0]; }
  const ConservingInput& input(int l) const { return island(l).input; }
  INLINE const double* constants(std::size_t i) const { return tables_.constants_at(i); }
  INLINE double* work(std::size_t i) const { return tables_.work_at(i); }
  INLINE double* memory(std::size_t i) const { return tables_.memory_at(i); }
  INLINE double* node(std::size_t i) const { return tables_.node_at(i); }
  bool may_keep() const {
    for (std::size_t l = 0; l < lanes_.count; ++l)
      if (lanes_.islands[l].input.may_keep) return true;
    return false;
  }
  /// Has the node of body i written, in lanes that renew their matrices.
  template <class Do>
  INLINE void renew(std::size_t i, Factor factor, const Do& write) const {
    double* const n = node(i);
    const bool mixed = factor == Factor::mixed;
    double before[kNodeSize * kWide];
    for (std::size_t at = 0; mixed && at < kNodeSize * kWide; ++at) before[at] = n[at];
    write(n);
    for (std::size_t at = 0; mixed && at < kNodeSize * kWide; at += kWide)
      store(n + at, choose(renews_ > 0.5, read<Lane>(n + at), read<Lane>(before + at)));
  }
  /// In lanes that renew their matrices the new values, in others those before; and the other way.
  INLINE Vec<Lane> renewed(Factor factor, Vec<Lane> now, Vec<Lane> before) const {
    return factor == Factor::mixed ? chosen(renews_ > 0.5, now, before) : now;
  }
  INLINE Vec<Lane> kept(Factor factor, Vec<Lane> now, Vec<Lane> before) const {
    return factor == Factor::mixed ? chosen(renews_ > 0.5, before, now) : now;
  }
  void choose_factor(int l, Factor factor) {
    renews_[static_cast<std::size_t>(l)] = factor == Factor::renewed;
  }
  static const double* forces(std::size_t /*i*/) { return nullptr; }
  const double* targets() const { return tables_.targets; }
  const double* ways() const { return tables_.ways; }
  const double* anchor_velocities() const { return tables_.anchor_velocities; }

  INLINE StartState<Lane> start(std::size_t i) const {
    const double* s = tables_.start_at(i);
    return {vec<Lane>(s, kStartPosition), vec<Lane>(s, kStartVelocity), vec<Lane>(s, kStartSpin),
            qua<Lane>(s, kStartRotation)};
  }
  INLINE Lane half_drag(std::size_t i) const {
    return num<Lane>(tables_.start_at(i), kStartHalfDrag);
  }
  INLINE Vec<Lane> position(std::size_t i) const {
    return vec<Lane>(tables_.start_at(i), kStartPosition);
  }
  INLINE Vec<Lane> velocity(std::size_t i) const {
    return vec<Lane>(tables_.start_at(i), kStartVelocity);
  }
  INLINE ParentState<Lane> parents_of(std::size_t i, const StartState<Lane>& own) const {
    const double* k = work(i);
    if (p.parents[i] < 0)
      return {own.q, qua<Lane>(k, kEndRotation), vec<Lane>(k, kEndArm), vec<Lane>(k, kMeanArm)};
    const auto at = static_cast<std::size_t>(p.parents[i]);
    const double* o = work(at);
    return {qua<Lane>(tables_.start_at(at), kStartRotation), qua<Lane>(o, kEndRotation),
            vec<Lane>(o, kEndArm), vec<Lane>(o, kMeanArm)};
  }

  /// A sum over the bodies, in the order in which BodyLanes adds.
  class Sum {
   public:
    INLINE void add(std::size_t body, Lane v) { sums_[body % kLanes] += v; }
    Lane total() const { return (sums_[0] + sums_[1]) + (sums_[2] + sums_[3]); }

   private:
    Lane sums_[kLanes] = {all<Lane>(0), all<Lane>(0), all<Lane>(0), all<Lane>(0)};
  };
  static Lane largest_of(Lane x) { return x; }
  static INLINE Lane mask_of(std::size_t /*i*/) { return all<Lane>(1.0); }
  static double of_island(Lane x, int l) { return x[static_cast<std::size_t>(l)]; }
  static Lane factors_of(const double (&factors)[kIslands]) { return read<Lane>(factors); }

  void stop(int l) { tables_.running[static_cast<std::size_t>(l)] = 0; }
  INLINE Vec<Lane> running(Vec<Lane> now, Vec<Lane> before) const {
    return tables_.kept(now, before);
  }
  INLINE Qua<Lane> running(Qua<Lane> now, Qua<Lane> before) const {
    return chosen(tables_.running > 0.5, now, before);
  }
  INLINE Vec<Lane> following(const ConservingInput& /*in*/, Vec<Lane> now, Vec<Lane> last) const {
    return chosen(follows_ > 0.5, now + now - last, now);
  }

  void set_outcome(int l, LaneOutcome outcome) {
    if (is_used(l)) lanes_.outcomes[l] = outcome;
  }
  bool is_taken(std::size_t l) const { return lanes_.outcomes[l] == LaneOutcome::taken; }
  bool any_taken() const {
    for (std::size_t l = 0; l < lanes_.count; ++l)
      if (is_taken(l)) return true;
    return false;
  }
  /// Marks the islands that the lanes cannot step, which are then stepped alone.
  void send_away() const {
    for (std::size_t l = 0; l < lanes_.count; ++l)
      if (at_limits_[l] || (lanes_.ties && cables_.is_alone(l)))
        lanes_.outcomes[l] = LaneOutcome::alone;
  }
  INLINE void set_bodies(std::size_t i, std::size_t at, Lane v) const {
    for (std::size_t l = 0; l < lanes_.count; ++l)
      if (is_taken(l)) body(i, l)[at] = v[l];
  }
  INLINE void set_bodies(std::size_t i, std::size_t at, Vec<Lane> v) const {
    set_bodies(i, at, v.x), set_bodies(i, at + 1, v.y), set_bodies(i, at + 2, v.z);
  }
  /// Writes the memory that the next step starts from, as a step of an island alone does.
  void write_memory() const {
    for (std::size_t l = 0; l < lanes_.count; ++l) {
      if (!is_taken(l)) continue;
      for (std::size_t i = 0; i < p.count; ++i) {
        const double* from = memory(i) + l;
        double* to = column(lanes_.islands[l].view.memory, kMemoryRows, i);
        for (std::size_t row = 0; row < kMemoryRows; ++row) to[row * kLanes] = from[row * kWide];
      }
      clear_padding(lanes_.islands[l].view);
    }
  }

  bool has_ties() const { return lanes_.ties; }
  INLINE const double* tie_block(std::size_t i) const { return tables_.tie_block_at(i); }
  INLINE bool is_grounded(std::size_t i) const { return lanes_.ties->grounded[i] != 0; }
  INLINE double* tie_factor(std::size_t i) const { return tables_.tie_factor_at(i); }
  void load_ties() { cables_.load(); }
  void correct_ties(bool (&fails)[kIslands]) { cables_.correct(fails); }
  void settle_ties(bool (&near)[kIslands]) { cables_.settle(near); }
  bool accept_ties(int l, double& released) {
    return cables_.accept(static_cast<std::size_t>(l), released);
  }
  /// Copies the rotations of an island at the end to its own table, and asks it.
  bool accept_limits(int island) {
    const auto l = static_cast<std::size_t>(island);
    const LaneIsland& own = lanes_.islands[l];
    if (!own.input.limits) return true;
    for (std::size_t i = 0; i < p.count; ++i) {
      double* const to = column(own.view.work, kWorkRows, i);
      for (std::size_t n = kEndRotation; n < kEndRotation + 4; ++n)
        to[n * kLanes] = work(i)[n * kWide + l];
    }
    at_limits_[l] = !own.input.limits->are_clear(own.input.limits->context);
    return !at_limits_[l];
  }
  void project_ties(const bool (&wanted)[kIslands], bool (&fails)[kIslands]) {
    cables_.project(wanted, fails);
  }
  Lane inner_ties() const {
    Lane inner = all<Lane>(1);
    for (std::size_t l = 0; lanes_.ties && l < lanes_.count; ++l)
      if (!*lanes_.islands[l].inner) inner[l] = 0;
    return inner;
  }
  bool is_struck(int l) const { return lanes_.ties && *island(l).struck; }
  double place_work(int l) const { return lanes_.ties ? *island(l).place_work : 0; }

 private:
  INLINE double* body(std::size_t i, std::size_t l) const {
    const IslandView& view = island(static_cast<int>(l)).view;
    return view.bodies + view.slots[i] * view.layout.stride;
  }
  /// Reads constants, states at the start and anchors of each island into its lane.
  void read_islands() {
    for (std::size_t l = 0; l < kWide; ++l) {
      const LaneIsland& from = island(static_cast<int>(l));
      h_[l] = from.input.h, follows_[l] = from.input.follows_equal_step;
      for (std::size_t i = 0; i < p.count; ++i) {
        const double* c = column(from.view.constants, kConstantRows, i);
        double* to = tables_.constants_at(i) + l;
        for (std::size_t row = 0; row < kConstantRows; ++row) to[row * kWide] = c[row * kLanes];
        const double* m = column(from.view.memory, kMemoryRows, i);
        double* last = memory(i) + l;
        for (std::size_t row = kLastRotation; row < kLastRotation + 3; ++row)
          last[row * kWide] = m[row * kLanes];
        const double* b = body(i, l);
        const BodyLayout& at = from.view.layout;
        double* s = tables_.start_at(i) + l;
        for (std::size_t n = 0; n < 3; ++n) {
          s[(kStartPosition + n) * kWide] = b[at.position + n];
          s[(kStartVelocity + n) * kWide] = b[at.velocity + n];
          s[(kStartSpin + n) * kWide] = b[at.angular_velocity + n];
        }
        for (std::size_t n = 0; n < 4; ++n) s[(kStartRotation + n) * kWide] = b[at.rotation + n];
      }
      for (std::size_t n = 0; n < 3 * tables_.trees; ++n) {
        tables_.targets[n * kWide + l] = from.input.targets[n];
        tables_.ways[n * kWide + l] = from.input.ways[n];
        tables_.anchor_velocities[n * kWide + l] = from.input.anchor_velocities[n];
      }
    }
    Lane drag = all<Lane>(-1), keep = all<Lane>(1);
    for (std::size_t i = 0; i < p.count; ++i) {
      const Lane own = num<Lane>(constants(i), kDrag);
      const auto same = own == drag;
      auto every = same[0];
      for (std::size_t l = 1; l < kWide; ++l) every &= same[l];
      if (every == 0)
        for (std::size_t l = 0; l < kWide; ++l) keep[l] = ::exp(-own[l] * (0.5 * h_[l]));
      drag = own;
      double* s = tables_.start_at(i);
      write(s + kStartHalfDrag * kWide, keep);
      put(s, kStartVelocity, keep * vec<Lane>(s, kStartVelocity));
      put(s, kStartSpin, keep * vec<Lane>(s, kStartSpin));
    }
  }

  const ConservingLanes& lanes_;
  LaneTables tables_;
  LaneCables cables_;
  bool at_limits_[kWide] = {};
  Lane h_ = all<Lane>(1), follows_ = all<Lane>(0);
  Lane renews_ = all<Lane>(1);  // 1 in lanes whose matrices the next elimination renews, else 0
};

void conserve_lanes(const ConservingLanes& all) {
  for (std::size_t l = 0; l < all.count; ++l) all.outcomes[l] = LaneOutcome::refused;
  IslandLanes lanes(all);
  conserve_by(lanes, all.islands[0].input);
  lanes.write_memory();
  lanes.send_away();
}

std::size_t lane_numbers(std::size_t bodies, std::size_t trees, const LaneTies* ties) {
  LaneMemory memory{nullptr};
  LaneTables tables;
  tables.lay_out(memory, bodies, trees);
  if (ties) LaneCables::Room(memory, *ties, bodies);
  return memory.used;
}

}  // namespace
}  // namespace pantin::detail::articulated

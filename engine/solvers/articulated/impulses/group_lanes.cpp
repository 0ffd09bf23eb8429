// Contact points of pairs of bodies without joints, four pairs side by side. No body that moves is
// in two pairs of a colour, so those of a colour are independent: their order does not matter, and
// each gets a SIMD lane. [Catto 2024, graph colouring of contacts]
#include "engine/solvers/articulated/impulses/group_lanes.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "engine/solvers/articulated/impulses/gather.hpp"
#include "engine/solvers/articulated/impulses/group_threads.hpp"

namespace pantin::detail::articulated {
namespace {

/// Colours of at most this number; further pairs, and those of colours of few, are solved one by
/// one.
constexpr std::uint32_t kMostColours = 48;
constexpr std::size_t kLeastOfColour = 4;
/// Batches of a colour that are worth a part of a thread's work.
constexpr std::size_t kLeastOfThread = 8;
/// Pairs of a group that are worth colouring.
constexpr std::size_t kLeastLaned = 8;

/// Whether the points of a pair can be solved in a lane.
bool fits_lane(const Group& g, const GroupPair& p) {
  const GroupContact& c = g.contacts[p.first];
  return g.a(c).node == kNoNode && g.b(c).node == kNoNode && c.rolling == kNoNode;
}

constexpr std::size_t numbers_of(std::size_t points) {
  return kPairLanes * (kPairRows + kPointRows * points);
}

/// The contacts of a batch that work: calls `visit(contact, number of the point, lane)`.
template <class Visit>
void for_each_point(const Group& g, const PairBatch& batch, const Visit& visit) {
  for (std::size_t l = 0; l < batch.count; ++l) {
    const GroupPair& p = g.pairs[batch.pairs[l]];
    std::size_t i = 0;
    for (GroupContact& c : g.contacts.subspan(p.first, p.count))
      if (c.works) visit(c, i++, l);
  }
}

/// A point of a batch in its lane.
struct LanePoint {
  Real* at;
  Real& operator[](std::size_t row) const { return at[kPairLanes * row]; }
  Vec3 vec(std::size_t row) const { return {(*this)[row], (*this)[row + 1], (*this)[row + 2]}; }
  void set(std::size_t row, Vec3 v) const {
    for (int n = 0; n < 3; ++n) (*this)[row + static_cast<std::size_t>(n)] = v[n];
  }
};
LanePoint point_of(const PairLanes& lanes, std::size_t i, std::size_t lane) {
  return {lanes.table + kPairLanes * (kPairRows + kPointRows * i) + lane};
}

static_assert(offsetof(GroupBody, spin) == offsetof(GroupBody, velocity) + 3 * sizeof(Real) &&
              offsetof(GroupBody, angular_momentum) ==
                  offsetof(GroupBody, spin) + 3 * sizeof(Real));
Real* state_of(GroupBody& b) { return &b.velocity.x; }

PairLanes lanes_of(const Group& g, const PairBatch& batch) {
  PairLanes lanes{batch.count, batch.points, 0, g.numbers.data() + batch.numbers, {}, {}};
  for (std::size_t l = 0; l < kPairLanes; ++l) {
    const GroupContact& c = g.contacts[g.pairs[batch.pairs[l < batch.count ? l : 0]].first];
    lanes.a[l] = state_of(g.a(c)), lanes.b[l] = state_of(g.b(c));
  }
  return lanes;
}

void write_body(const GroupBody& b, Real* to) {
  const Mat3& r = b.response;
  const Real numbers[7] = {b.per_mass, r[0][0], r[1][0], r[2][0], r[1][1], r[2][1], r[2][2]};
  for (std::size_t n = 0; n < 7; ++n) to[kPairLanes * n] = numbers[n];
}

/// Writes masses and inertias at the current poses: momentum is kept in each sweep.
void write_bodies(const Group& g, const PairBatch& batch, const PairLanes& lanes) {
  for (std::size_t l = 0; l < batch.count; ++l) {
    const GroupContact& c = g.contacts[g.pairs[batch.pairs[l]].first];
    write_body(g.a(c), lanes.table + kPairLanes * kPairOfA + l);
    write_body(g.b(c), lanes.table + kPairLanes * kPairOfB + l);
  }
}

/// Fills the table of a batch, but for impulses and goals.
void fill_batch(const Group& g, const PairBatch& batch) {
  const PairLanes lanes = lanes_of(g, batch);
  std::fill_n(lanes.table, numbers_of(batch.points), Real(0));
  write_bodies(g, batch, lanes);
  for (std::size_t l = 0; l < batch.count; ++l)
    lanes.table[kPairLanes * kPairIterations + l] =
        g.pairs[batch.pairs[l]].working > 1 ? kPointIterations : 1;
  for_each_point(g, batch, [&](const GroupContact& c, std::size_t i, std::size_t l) {
    const LanePoint to = point_of(lanes, i, l);
    for (std::size_t n = 0; n < 3; ++n) to.set(kPointAxes + 3 * n, c.axes[n]);
    to.set(kPointArmA, c.arm_a), to.set(kPointArmB, c.arm_b);
    to[kPointSurface] = c.surface_first, to[kPointSurface + 1] = c.surface_second;
    to[kPointFriction] = c.friction;
  });
  kernels().prepare_pairs(lanes);
  for_each_point(g, batch, [&](GroupContact& c, std::size_t i, std::size_t l) {
    c.along = point_of(lanes, i, l)[kPointAlong];
  });
}

/// Puts the pairs with active points into batches of one colour.
std::size_t find_batches(const Group& g) {
  std::size_t count = 0, numbers = g.lane_numbers;
  std::uint32_t colour = 0;
  bool open = false;
  for (const LanedPair& laned : g.laned) {
    const GroupPair& p = g.pairs[laned.pair];
    if (p.working == 0) continue;
    if (!open || colour != laned.colour || g.batches[count - 1].count == kPairLanes) {
      if (open) numbers += numbers_of(g.batches[count - 1].points);
      g.batches[count++] = {{}, 0, 0, laned.colour, numbers};
      open = true, colour = laned.colour;
    }
    PairBatch& batch = g.batches[count - 1];
    batch.pairs[batch.count++] = laned.pair;
    batch.points = std::max(batch.points, p.working);
  }
  if (count < g.batches.size()) g.batches[count].count = 0;
  return count;
}

/// The batches in use.
std::span<PairBatch> batches_of(const Group& g) {
  std::size_t count = 0;
  while (count < g.batches.size() && g.batches[count].count > 0) ++count;
  return g.batches.first(count);
}

}  // namespace

void prepare_lanes(const Group& g) {
  const std::span<PairBatch> batches = g.batches.first(find_batches(g));
  in_parts(g.threads, batches.size(), kLeastInPart, [&](const ListPart& part) {
    for (std::size_t i = part.begin; i < part.end; ++i) fill_batch(g, batches[i]);
  });
}

void push_lanes(const Group& g) {
  for (const PairBatch& batch : batches_of(g)) {
    const PairLanes lanes = lanes_of(g, batch);
    for_each_point(g, batch, [&](const GroupContact& c, std::size_t i, std::size_t l) {
      point_of(lanes, i, l).set(kPointImpulse, c.impulse);
    });
    kernels().push_pairs(lanes);
  }
}

namespace {

/// Iterates the impulses of a batch. Returns the largest change of speed, m/s.
Real solve_batch(const Group& g, const PairBatch& batch, const Substep& s, Sweep sweep) {
  PairLanes lanes = lanes_of(g, batch);
  lanes.tolerance = g.trees.empty() ? kPairTolerance : 0;
  write_bodies(g, batch, lanes);
  for_each_point(g, batch, [&](const GroupContact& c, std::size_t i, std::size_t l) {
    const LanePoint to = point_of(lanes, i, l);
    const Goal goal = goal_of(c, spring_of(g, c, s), s, sweep);
    to.set(kPointImpulse, c.impulse);
    to[kPointSpeed] = goal.speed, to[kPointParted] = goal.parted;
    to[kPointKept] = 1 - goal.spring.by_impulse, to[kPointByMass] = goal.spring.by_mass;
  });
  const Real most = kernels().solve_pairs(lanes);
  for_each_point(g, batch, [&](GroupContact& c, std::size_t i, std::size_t l) {
    c.impulse = point_of(lanes, i, l).vec(kPointImpulse);
  });
  return most;
}

}  // namespace

Real sweep_lanes(const Group& g, const Substep& s, Sweep sweep, Order order) {
  const std::span<PairBatch> all = batches_of(g);
  Real most[kMostParts] = {};
  const auto solve = [&](std::span<const PairBatch> colour) {
    in_parts(g.threads, colour.size(), kLeastOfThread, [&](const ListPart& part) {
      for (const PairBatch& batch : colour.subspan(part.begin, part.end - part.begin))
        most[part.number] = std::max(most[part.number], solve_batch(g, batch, s, sweep));
    });
  };
  for (std::size_t from = 0, left = all.size(); left > 0;) {
    std::size_t count = 1;
    if (order == Order::forwards) {
      while (count < left && all[from + count].colour == all[from].colour) ++count;
      solve(all.subspan(from, count)), from += count;
    } else {
      while (count < left && all[left - 1 - count].colour == all[left - 1].colour) ++count;
      solve(all.subspan(left - count, count));
    }
    left -= count;
  }
  return *std::max_element(std::begin(most), std::end(most));
}

void gather_laned(GroupScratch& r, GroupScratch::Range& range) {
  Group g;
  g.bodies = std::span(r.bodies).subspan(range.first_body);
  g.contacts = std::span(r.contacts).subspan(range.first_contact);
  g.pairs = std::span(r.pairs).subspan(range.first_pair);
  range.lane_numbers = r.numbers - range.first_number;
  if (g.pairs.size() < kLeastLaned) return;
  r.colours.assign(g.bodies.size(), 0), r.keys.clear();
  std::size_t sizes[kMostColours] = {};
  for (std::uint32_t i = 0; i < g.pairs.size(); ++i) {
    const GroupPair& p = g.pairs[i];
    if (!fits_lane(g, p)) continue;
    const GroupContact& c = g.contacts[p.first];
    std::uint64_t &of_a = r.colours[c.a], &of_b = r.colours[c.b];
    const auto moves = [&](const GroupBody& b) { return b.per_mass > 0; };
    const std::uint64_t taken = (moves(g.a(c)) ? of_a : 0) | (moves(g.b(c)) ? of_b : 0);
    const auto colour = static_cast<std::uint32_t>(std::countr_one(taken));
    if (colour >= kMostColours) continue;
    of_a |= std::uint64_t(1) << colour, of_b |= std::uint64_t(1) << colour;
    ++sizes[colour];
    // Pairs of as many points side by side.
    r.keys.push_back(std::uint64_t(colour) << 40 | std::uint64_t(kMostPoints - p.count) << 32 | i);
  }
  std::sort(r.keys.begin(), r.keys.end());
  std::size_t in_batch = 0;
  std::uint32_t last = kMostColours;
  for (const std::uint64_t key : r.keys) {
    const auto colour = static_cast<std::uint32_t>(key >> 40),
               pair = static_cast<std::uint32_t>(key);
    if (sizes[colour] < kLeastOfColour) continue;
    GroupPair& p = g.pairs[pair];
    p.in_lanes = true;
    for (GroupContact& c : g.contacts.subspan(p.first, p.count)) c.in_lanes = true;
    r.laned.push_back({pair, colour});
    if (colour != last || in_batch == kPairLanes) {
      r.batches.emplace_back(), r.numbers += numbers_of(p.count);
      last = colour, in_batch = 0;
    }
    ++in_batch;
  }
}

}  // namespace pantin::detail::articulated

// Batches of islands of equal structure, stepped by the energy-momentum method with one island per
// SIMD lane (kernels/island_lanes.hpp). Each lane depends on its own island only: its result has
// the same bits whatever the other lanes hold, and as when the island is stepped alone.
#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/smooth/conserving_ties.hpp"
#include "engine/solvers/rebuild.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

/// Batches are found again when more islands than these came since, and a part of those in batches.
constexpr std::size_t kFewUnsorted = 8, kPartUnsorted = 8;

/// Whether the vectorised kernel supports an island: free ball joints and cables only, or ball
/// joints with limits that are not active.
bool fits_lanes(const Island& a) {
  return a.settings.solver == Solver::articulated && (a.joints.empty() || has_only_limits(a)) &&
         a.pins.empty() && a.cables.size() <= kMostTies && a.count() > 0;
}

bool stretches(const World& world, const Island& a, std::size_t cable) {
  return world.cables.values()[a.cables[cable].cable].joint.compliance > 0;
}

bool is_reeled(const World& world, const PackedCable& c) {
  return is_reeled(c.before(), world.cables.values()[c.cable].joint);
}

/// Hash of an island's structure, which must be equal within a batch.
std::uint64_t shape_of(const World& world, const Island& a) {
  std::uint64_t hash = 1469598103934665603ull;
  const auto add = [&](std::uint64_t x) { hash = (hash ^ x) * 1099511628211ull; };
  add(a.count()), add(a.cables.size());
  for (std::size_t c = 0; c < a.count(); ++c) add(static_cast<std::uint32_t>(a.parents[c]));
  for (std::size_t n = 0; n < a.cables.size(); ++n)
    add(a.cables[n].column_a), add(a.cables[n].column_b), add(stretches(world, a, n));
  return hash;
}
bool are_alike(const World& world, const Island& a, const Island& b) {
  if (a.count() != b.count() || a.cables.size() != b.cables.size()) return false;
  if (!std::equal(a.parents.begin(), a.parents.begin() + static_cast<std::ptrdiff_t>(a.count()),
                  b.parents.begin()))
    return false;
  for (std::size_t n = 0; n < a.cables.size(); ++n)
    if (a.cables[n].column_a != b.cables[n].column_a ||
        a.cables[n].column_b != b.cables[n].column_b ||
        stretches(world, a, n) != stretches(world, b, n))
      return false;
  return true;
}

/// Workspace of the batch that a thread steps.
struct LaneRoom {
  const std::size_t wide = kernels().lanes;
  std::vector<Real> numbers, table, gains;
  std::vector<std::uint32_t> rows;

  /// Grows to the size that the islands need, and keeps it from step to step.
  void fit(const Island& a, const LaneTies* of) {
    grow(numbers, kernels().lane_numbers(a.count(), a.trees.size(), of));
    if (!of) return;
    grow(table, kLaneCableRows * wide * of->count), grow(gains, wide * of->count);
    grow(rows, lane_tie_rows(*of, a.count()));
  }

 private:
  template <class T>
  static void grow(std::vector<T>& v, std::size_t n) {
    if (v.size() < n) v.resize(n);
  }
};
LaneRoom& lane_room() {
  thread_local LaneRoom room;
  return room;
}

/// An island in a lane, as the hooks of the kernel see it.
struct Lane {
  TiedStep step;
  LaneRoom& room;
  std::size_t lane;

  std::vector<ConservingTie>& ties() const { return step.a.scratch.ties; }
  Real number(std::size_t tie, std::size_t row) const {
    return room.table[(kLaneCableRows * tie + row) * room.wide + lane];
  }
  void set(std::size_t tie, std::size_t row, Real x) const {
    room.table[(kLaneCableRows * tie + row) * room.wide + lane] = x;
  }
  Vec3 vec(std::size_t tie, std::size_t row) const {
    return {number(tie, row), number(tie, row + 1), number(tie, row + 2)};
  }
  void set(std::size_t tie, std::size_t row, Vec3 v) const {
    set(tie, row, v.x), set(tie, row + 1, v.y), set(tie, row + 2, v.z);
  }
};

/// Writes cables to the lane at the start of a substep.
void write_ties(const Lane& lane) {
  for (std::size_t n = 0; n < lane.ties().size(); ++n) {
    const ConservingTie& t = lane.ties()[n];
    lane.set(n, kCableAnchorA, t.anchor_a), lane.set(n, kCableAnchorB, t.anchor_b);
    lane.set(n, kCableStartA, t.start_a), lane.set(n, kCableStartB, t.start_b);
    lane.set(n, kCableWay, t.way), lane.set(n, kCableVelocity, t.velocity);
    lane.set(n, kCableBefore, t.before), lane.set(n, kCableMu, t.mu);
    lane.set(n, kCableLength, t.length), lane.set(n, kCableStiffness, t.stiffness);
    lane.set(n, kCableAcross, Real(0)), lane.set(n, kCableSoftness, t.softness);
    lane.set(n, kCableResponse, t.response);
    lane.set(n, kCableKind, t.kind == TieKind::slack ? kSlackTie : kTautTie);
    lane.set(n, kCableFollowed, Real(t.followed)), lane.set(n, kCableGrounded, Real(t.grounded));
  }
}
/// Reads the states of cables back from the lane; write_kinds() writes kinds to the lane.
void read_ties(const Lane& lane) {
  for (std::size_t n = 0; n < lane.ties().size(); ++n) {
    ConservingTie& t = lane.ties()[n];
    t.softness = lane.number(n, kCableSoftness), t.now = lane.vec(n, kCableNow);
    if (t.kind == TieKind::cable) continue;
    t.kind = lane.number(n, kCableKind) == kSlackTie ? TieKind::slack : TieKind::taut;
  }
}
void write_kinds(const Lane& lane) {
  for (std::size_t n = 0; n < lane.ties().size(); ++n) {
    const ConservingTie& t = lane.ties()[n];
    if (t.kind == TieKind::taut) lane.set(n, kCableKind, t.strikes ? kStrikingTie : kTautTie);
  }
}

bool is_hit_early(void* context) {
  const Lane& lane = *static_cast<const Lane*>(context);
  read_ties(lane);
  return is_hit_early(lane.step);
}
bool ends_early(void* context) {
  const Lane& lane = *static_cast<const Lane*>(context);
  read_ties(lane);
  if (has_to_end_early(lane.step)) return true;
  lane.step.with.inner = ties_are_inner(lane.step.a);
  write_kinds(lane);
  return false;
}
bool strike(void* context) {
  const Lane& lane = *static_cast<const Lane*>(context);
  for (std::size_t n = 0; n < lane.ties().size(); ++n) {
    ConservingTie& t = lane.ties()[n];
    t.end_a = lane.vec(n, kCableEndA), t.end_b = lane.vec(n, kCableEndB);
  }
  return project_ties(lane.step);
}

LaneIsland lane_island(World& world, Lane& lane, const ConservingInput& in) {
  Island& a = lane.step.a;
  StepScratch& r = a.scratch;
  TiedPart& with = lane.step.with;
  return {view_of(world, a),
          in,
          a.size,
          a.mass,
          r.tie_yield,
          &lane,
          &with.iterations,
          r.tie_factors.data(),
          is_hit_early,
          ends_early,
          strike,
          &with.inner,
          &with.struck,
          &with.place_work};
}

/// Takes the next substep of up to Kernels::lanes islands of one batch.
void take_parts_together(World& world, CrowdScratch& crowd, std::span<const std::uint32_t> going) {
  const auto step = [&](std::size_t l) -> CrowdStep& { return crowd.steps[going[l]]; };
  if (going.size() == 1) return take_part(world, *step(0).island, step(0).parts);
  LaneRoom& room = lane_room();
  Island& first = *step(0).island;
  const CrowdShape& shape = crowd.shapes[step(0).shape];
  const StepScratch& r = first.scratch;
  const LaneTies ties{shape.ties.size(),      shape.ties.data(),   r.tie_paths.data(),
                      r.tie_paths.size(),     shape.longest,       shape.column_starts.data(),
                      shape.positions.data(), shape.tie_at.data(), r.tie_grounded.data()};
  const LaneTies* const tied = first.cables.empty() ? nullptr : &ties;
  room.fit(first, tied);
  std::array<ConservingInput, kMostAbreast> inputs;
  std::array<std::optional<TiedPart>, kMostAbreast> parts;
  std::array<std::optional<Lane>, kMostAbreast> lanes;
  std::array<std::optional<OpenPart>, kMostAbreast> open;
  std::array<OpenLimits, kMostAbreast> limits;
  std::array<LaneIsland, kMostAbreast> islands;
  std::array<LaneOutcome, kMostAbreast> outcomes{};
  for (std::size_t l = 0; l < going.size(); ++l) {
    Island& a = *step(l).island;
    a.scratch.cable_rows_before = a.scratch.cable_rows;
    inputs[l] = begin_part(world, a, step(l).parts);
    parts[l].emplace(tied_part(step(l).parts));
    lanes[l].emplace(Lane{{world, a, inputs[l].h, *parts[l]}, room, l});
    open[l].emplace(OpenPart{world, a, step(l).parts.now});
    limits[l] = open_limits(*open[l]);
    if (step(l).parts.opens) inputs[l].limits = &limits[l];
    if (tied) write_ties(*lanes[l]);
    islands[l] = lane_island(world, *lanes[l], inputs[l]);
  }
  kernels().conserve_lanes({going.size(), islands.data(), tied, room.table.data(), room.rows.data(),
                            room.gains.data(), room.numbers.data(), outcomes.data()});
  for (std::size_t l = 0; l < going.size(); ++l) {
    Island& a = *step(l).island;
    if (outcomes[l] == LaneOutcome::alone) {
      a.scratch.cable_rows = a.scratch.cable_rows_before;
      step(l).parts.opens = step(l).parts.opens && open[l]->are_clear;
      take_part(world, a, step(l).parts);
      continue;
    }
    step(l).parts.taken = outcomes[l] == LaneOutcome::taken;
    for (std::size_t n = 0; step(l).parts.taken && n < lanes[l]->ties().size(); ++n)
      lanes[l]->ties()[n].mu = lanes[l]->vec(n, kCableMu);
    end_part(world, a, step(l).parts, *parts[l]);
  }
}

bool is_chain(const std::vector<TiePathStep>& paths, std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t k = 0; k + 1 < count; ++k)
    if (paths[first + k].parent != k + 1) return false;
  return true;
}

/// The structure of an island's cables: their ends, their paths, and the paths through each body.
void find_shape(const World& world, const Island& a, CrowdShape& shape) {
  const StepScratch& r = a.scratch;
  for (std::size_t i = 0; i < a.cables.size(); ++i) {
    const PackedCable& cable = a.cables[i];
    const bool has_b = cable.column_b != UINT32_MAX;
    const std::uint32_t first = r.tie_path_starts[i], count = r.tie_path_starts[i + 1] - first;
    shape.longest = std::max<std::size_t>(shape.longest, count);
    shape.ties.push_back({has_b ? cable.column_a : UINT32_MAX,
                          has_b ? cable.column_b : cable.column_a, first, count,
                          stretches(world, a, i), is_chain(r.tie_paths, first, count)});
  }
  shape.column_starts.assign(2 * a.count() + 1, 0);
  for (const TiePathStep& step : r.tie_paths) ++shape.column_starts[step.column + 1];
  for (std::size_t c = 0; c < 2 * a.count(); ++c)
    shape.column_starts[c + 1] += shape.column_starts[c];
  shape.positions.resize(r.tie_paths.size()), shape.tie_at.resize(r.tie_paths.size());
  std::vector<std::uint32_t> next = shape.column_starts;
  for (std::uint32_t i = 0; i < shape.ties.size(); ++i)
    for (std::uint32_t k = shape.ties[i].path; k < shape.ties[i].path + shape.ties[i].count; ++k) {
      shape.positions[k] = next[r.tie_paths[k].column]++;
      shape.tie_at[shape.positions[k]] = i;
    }
}

}  // namespace

void find_crowds(const World& world, Islands& all) {
  CrowdScratch& crowd = all.crowd;
  crowd.order.clear(), crowd.steps.clear(), crowd.shapes.clear();
  crowd.is_known = true, crowd.unsorted = 0;
  std::vector<std::uint64_t> hashes(all.list.size(), 0);
  for (std::uint32_t i = 0; i < all.list.size(); ++i) {
    if (!fits_lanes(all.list[i])) continue;
    crowd.order.push_back({i, 0}), hashes[i] = shape_of(world, all.list[i]);
  }
  std::stable_sort(crowd.order.begin(), crowd.order.end(),
                   [&](const CrowdScratch::Member& i, const CrowdScratch::Member& j) {
                     return hashes[i.island] < hashes[j.island];
                   });
  // Islands without a match are stepped alone.
  std::vector<CrowdScratch::Member> members;
  for (std::size_t i = 0, end = 0; i < crowd.order.size(); i = end) {
    const Island& first = all.list[crowd.order[i].island];
    end = i + 1;
    while (end < crowd.order.size() && are_alike(world, first, all.list[crowd.order[end].island]))
      ++end;
    if (end - i == 1) continue;
    const auto shape = static_cast<std::uint32_t>(crowd.shapes.size());
    find_shape(world, first, crowd.shapes.emplace_back());
    for (std::size_t k = i; k < end; ++k) members.push_back({crowd.order[k].island, shape});
  }
  crowd.order = std::move(members);
  const std::size_t most = crowd.order.size();
  crowd.steps.reserve(most), crowd.going.reserve(most);
}

void renumber_crowds(Islands& all, const Rebuild& rebuild) {
  CrowdScratch& crowd = all.crowd;
  if (!crowd.is_known) return;
  for (CrowdScratch::Member& m : crowd.order) m.island = rebuild.now[m.island];
  std::erase_if(crowd.order, [](const auto& m) { return m.island == Rebuild::kGone; });
  for (const std::uint32_t i : rebuild.places) crowd.unsorted += fits_lanes(all.list[i]);
  crowd.is_known = crowd.unsorted <= kFewUnsorted + crowd.order.size() / kPartUnsorted;
}

namespace {

/// Islands that a thread steps from start to end before it takes others, at most: few enough for
/// all threads to have some, many enough to fill the lanes.
constexpr std::size_t kBlock = 128;

/// Steps of islands that no block has begun, for a budget.
struct Waiting {
  std::atomic<Real> weight;  // of one substep of each, and of the islands of no batch
};

/// Whether, after one more round, there would be no time for a substep of each unfinished step and
/// of those that wait.
bool has_to_hurry(const Islands& all, const Waiting& waiting,
                  std::span<const std::uint32_t> going) {
  Real own = 0;
  for (const std::uint32_t i : going) own += weight_of(*all.crowd.steps[i].island);
  return is_late(all.rates, 2 * own + waiting.weight.load(std::memory_order_relaxed));
}

/// Which cables are taut: lanes whose cables are alike have fewer rows.
std::uint64_t taut_cables(const Island& a) {
  std::uint64_t set = 0;
  for (std::size_t n = 0; n < a.cables.size(); ++n)
    set ^= std::uint64_t{a.cables[n].lambda > 0} << (n % 64);
  return set;
}

/// A block of steps from `first` on.
struct Block {
  std::size_t first, count;
};

/// Each round takes the next substep of every unfinished step of a block.
void step_block(World& world, const StepTask& task, const Block& block, Waiting& waiting) {
  Islands& all = world.memory.of<Islands>();
  CrowdScratch& crowd = all.crowd;
  const std::span<CrowdStep> steps = std::span(crowd.steps).subspan(block.first, block.count);
  const std::span<std::uint32_t> going = std::span(crowd.going).subspan(block.first, block.count);
  std::iota(going.begin(), going.end(), static_cast<std::uint32_t>(block.first));
  for (CrowdStep& s : steps) {
    s.parts = begin_parts(world, *s.island, s.island->step), s.taut = taut_cables(*s.island);
    if (task.budget) waiting.weight.fetch_sub(weight_of(*s.island), std::memory_order_relaxed);
  }
  std::sort(going.begin(), going.end(), [&](std::uint32_t i, std::uint32_t j) {
    const CrowdStep &a = crowd.steps[i], &b = crowd.steps[j];
    return std::tie(a.shape, a.taut, i) < std::tie(b.shape, b.taut, j);
  });
  // Lanes have no reels, no cables that are taken up, and no limits that are active.
  const auto alone = [&](std::size_t i) {
    const CrowdStep& s = crowd.steps[going[i]];
    return s.parts.takes_up || (!s.island->joints.empty() && !s.parts.opens);
  };
  bool hurries = false;
  for (std::size_t left = going.size(); left > 0;) {
    hurries = hurries || (task.budget && has_to_hurry(all, waiting, going.first(left)));
    if (hurries)
      for (const std::uint32_t i : going.first(left)) crowd.steps[i].parts.hurries = true;
    for (std::size_t i = 0, end = 0; i < left; i = end) {
      end = i + 1;
      while (end < left && end - i < kernels().lanes && !alone(i) && !alone(end) &&
             crowd.steps[going[i]].shape == crowd.steps[going[end]].shape)
        ++end;
      take_parts_together(world, crowd, going.subspan(i, end - i));
    }
    const auto ended = [&](std::uint32_t i) { return !crowd.steps[i].parts.goes_on(); };
    left = static_cast<std::size_t>(
        std::remove_if(going.begin(), going.begin() + static_cast<std::ptrdiff_t>(left), ended) -
        going.begin());
  }
  for (CrowdStep& s : steps) end_parts(world, *s.island, s.parts, s.island->lost);
}

}  // namespace

void step_crowds(World& world, const StepTask& task) {
  Islands& all = world.memory.of<Islands>();
  CrowdScratch& crowd = all.crowd;
  crowd.steps.clear();
  const std::vector<std::uint32_t>& awake = rest_lists(world).awake;
  // Also of islands that have left their batch since: nobody else would step them.
  for (const std::uint32_t i : awake) all.list[i].in_crowd = false;
  if (crowd.order.empty() || awake.empty()) return;
  crowd.is_awake.assign(all.list.size(), 0);
  for (const std::uint32_t i : awake) crowd.is_awake[i] = 1;
  for (const auto& [island, shape] : crowd.order) {
    if (!crowd.is_awake[island]) continue;
    Island& a = all.list[island];
    if (a.asleep || a.step == 0 || a.in_group || a.forced || !a.conserves || !a.finite) continue;
    // A cable's compliance may have been changed.
    const std::vector<LaneTies::Tie>& ties = crowd.shapes[shape].ties;
    bool fits = true;
    for (std::size_t n = 0; n < ties.size(); ++n)
      fits = fits && ties[n].stretches == stretches(world, a, n) && !is_reeled(world, a.cables[n]);
    if (!fits) continue;
    a.in_crowd = true, forget_result(a);
    crowd.steps.push_back({&a, shape, 0, {}});
  }
  crowd.going.resize(crowd.steps.size());
  Waiting waiting{0};
  if (task.budget) waiting.weight = all.rates.weight;
  const std::size_t count = crowd.steps.size(), blocks = (count + kBlock - 1) / kBlock;
  for_each_island(blocks, task, [&](std::size_t i) {
    const std::size_t first = i * count / blocks, end = (i + 1) * count / blocks;
    step_block(world, task, {first, end - first}, waiting);
  });
}

}  // namespace pantin::detail::articulated

// Unilateral surface joints: finds penetration within a step at pairs that are not tracked, or that
// occurs only between the start and the end.
#include "engine/solvers/lagrangian/surface_spots.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Spacing of the sampled poses, as a fraction of the smaller surface, and their largest number.
/// Half the spacing is the radius of a ball within which near and far sides are told apart.
constexpr Real kStride = 0.25;
constexpr int kMostStrides = 400;
/// m: a deeper gap is a penetration.
constexpr Real kWithin = 1e-9;
/// Substeps of a step, attempts included, after which penetration is checked.
constexpr int kManyParts = 8;
/// Fraction of the smaller surface: a deeper penetration at the end of a step is a failure.
constexpr Real kSunk = 1e-4;

Pose between(const Pose& from, const Pose& to, Real part) {
  if (part == 1) return to;
  return {from.position + part * (to.position - from.position),
          glm::slerp(from.rotation, to.rotation, part)};
}

/// Whether no contact can be missed: there is one pair, and it is tracked.
bool is_sure(const Spots& s) {
  const SurfaceContact& c = s.contact();
  bool any_open = false;
  for (std::size_t n = 0; n < s.count; ++n) any_open = any_open || !s.memory(n).is_over();
  if (!c.lifts || !any_open) return true;
  // A single slot moves over to deeper pairs at the next search.
  return s.count == 1 && s.memory(0).known && (is_convex(c) || s.bears(0)) && !has_ended(s, 0);
}

enum class Seen : std::uint8_t { no, followed, bears };
/// Whether a pair found by the sweep is tracked, and active.
Seen seen(const Spots& s, const Pose& at, const nurbs::CommonNormal& pair) {
  const SurfaceContact& c = s.contact();
  Seen best = Seen::no;
  for (std::size_t n = 0; n < s.count; ++n) {
    if (!s.memory(n).known) continue;
    const nurbs::PlacePair& to = s.m.scratch.state.touches[s.first + n].at;
    if (!are_alike(c, to, pair.at) && !are_alike(c, track_pair(c, at, to).at, pair.at)) continue;
    best = std::max(best, s.bears(n) ? Seen::bears : Seen::followed);
  }
  return best;
}

/// The relative motion of a contact in the last substep.
struct Way {
  Pose from, to;
  Real length = 0;  // m, of the farthest point of a
  int strides = 1;
};

/// Samples one pose of the motion: the least gap, m, and whether an untracked contact was found.
struct Look {
  Real least = 0;
  bool met = false;
};
Look look_at(const Spots& s, const Way& way, int stride) {
  const SurfaceContact& c = s.contact();
  const Real left = way.length * (way.strides - stride) / way.strides;
  nurbs::CommonNormal found[kMostPairs];
  const Pose at = between(way.from, way.to, Real(stride) / way.strides);
  Look out{std::max(kStride * smaller_size(c), left), false};
  const std::size_t count = find_pairs(c, at, {out.least, found});
  const Real deepest = kDeepest * smaller_size(c) + way.length / way.strides;
  for (std::size_t i = 0; i < count; ++i) {
    const nurbs::CommonNormal& pair = found[i];
    if (pair.gap < 0 && !may_have_met(pair, deepest)) continue;
    out.least = std::min(out.least, pair.gap);
    if (!(pair.gap < -kWithin)) continue;
    const Seen is = seen(s, at, pair);
    out.met = out.met || is == Seen::no || (is == Seen::followed && stride < way.strides);
  }
  return out;
}

/// The fraction of the motion after which an untracked contact penetrates, or 2.
Real part_of(const Spots& s) {
  if (is_sure(s)) return 2;
  const SurfaceContact& c = s.contact();
  Way way{s.m.scratch.touching[s.first].begun, a_in_b_now(s)};
  way.length = moved(way.from, way.to).most(c);
  const Moved since = moved(s.memory(0).searched, way.to);
  if (since.most(c) < s.m.scratch.touching[s.first].clear) return 2;
  way.strides = static_cast<int>(
      std::clamp(std::ceil(way.length / (kStride * smaller_size(c))), Real(1), Real(kMostStrides)));
  bool any_ended = false;
  for (std::size_t n = 0; n < s.count; ++n)
    any_ended = any_ended || (has_ended(s, n) && !s.bears(n));
  if (way.strides == 1 && !any_ended && !is_far(since, c)) return 2;
  for (int i = 1; i <= way.strides;) {
    const Look look = look_at(s, way, i);
    if (look.met) return Real(i) / way.strides;
    if (i == way.strides) break;
    const Real free = std::max(look.least, Real(0)) * way.strides / way.length;
    i = std::min(way.strides, i + std::max(1, static_cast<int>(free)));
  }
  return 2;
}

/// Whether surfaces penetrate deeply after a step in which this may have been missed: no pair that
/// touched before is active any more, or the step took many substeps. A single active slot is
/// exempt: it moves over to a deeper pair at the next search.
bool has_sunk(const Spots& s) {
  const SurfaceContact& c = s.contact();
  bool touched = c.touches, any_bears = false;
  for (const SurfaceSpot& spot : c.more) touched = touched || spot.touches;
  for (std::size_t n = 0; n < s.count; ++n) {
    if (s.memory(n).is_over()) return false;
    any_bears = any_bears || s.bears(n);
  }
  const bool was_cut = s.m.substeps > kManyParts && (s.count > 1 || !any_bears);
  if (!c.lifts || !(was_cut || (touched && !any_bears))) return false;
  const Pose at = a_in_b_now(s);
  const Real way = moved(s.m.scratch.touching[s.first].begun, at).most(c);
  nurbs::CommonNormal found[kMostPairs];
  const std::size_t count = find_pairs(c, at, {kDeepest * smaller_size(c) + way, found});
  for (std::size_t i = 0; i < count; ++i)
    if (found[i].gap < -kSunk * smaller_size(c) &&
        may_have_met(found[i], kDeepest * smaller_size(c) + way))
      return true;
  return false;
}

}  // namespace

bool any_sank(const World& world, Island& m) {
  bool any = false;
  for_each_contact(world, m, [&](const Spots& s) {
    if (any || !has_sunk(s)) return;
    any = true;
    m.scratch.lost_touch = static_cast<std::uint32_t>(s.first);
    m.scratch.lost_how = nurbs::ContactStatus::lost;
  });
  return any;
}

void note_sweep(const World& world, Island& m) {
  for_each_contact(world, m, [&](const Spots& s) {
    if (s.contact().lifts) m.scratch.touching[s.first].begun = a_in_b_now(s);
  });
}

Real first_untracked_contact(const World& world, Island& m) {
  Real first = 2;
  for_each_contact(world, m, [&](const Spots& s) { first = std::min(first, part_of(s)); });
  return first;
}

}  // namespace pantin::detail::lagrangian

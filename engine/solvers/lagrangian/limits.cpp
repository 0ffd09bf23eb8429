// Limits and strings: one row each, which bears only while it pushes.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::lagrangian {
namespace {

/// Slower approaches are not given back, m/s or rad/s.
constexpr Real kQuiet = 1e-3;
/// A limit that is overstepped by less is met, m or rad.
constexpr Real kTouch = 1e-9;
/// So many blows of a step are given back; those after them are the last of ever smaller ones.
constexpr int kMostBounces = 4;
/// Blows in a step, tries to find one, and tries of a step after which none is looked for.
constexpr int kMostEvents = 8, kMostSearches = 16, kMostAttempts = 60;

/// Limits but for locks, and strings.
bool is_one_sided(const Island& m, std::size_t i) {
  const Block& b = m.blocks[i];
  return (b.kind == BlockKind::limit && !b.lock) || b.kind == BlockKind::cable;
}

/// How far the nearest limit is that does not bear; below zero where one is overstepped.
Real clearance(const Island& m) {
  Real least = 1e300;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (is_one_sided(m, i) && !m.memory[i].active)
      least = std::min(least, m.room.c[m.blocks[i].first_row]);
  return least;
}

/// Limits that would have pulled let go. True if any did.
bool let_go(Island& m) {
  bool any = false;
  Real scale = 0;
  for (Real load : m.loads) scale = std::max(scale, std::abs(load));
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!is_one_sided(m, i) || !m.memory[i].active) continue;
    if (m.loads[m.blocks[i].first_row] >= -1e-9 * scale) continue;
    m.memory[i].active = false, any = true;
  }
  return any;
}

/// What reached a limit stops there, or is thrown back; blows reach through the whole mechanism.
void strike(const World& world, Island& m, bool gives_back) {
  StepScratch& room = m.room;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (is_one_sided(m, i) && !m.memory[i].active && room.c[m.blocks[i].first_row] <= kTouch)
      m.memory[i].active = true;
  for (int round = 0; round < 8; ++round) {
    place(m);
    write_all_rows(world, m, {true, false});
    factor(m, false);
    std::vector<Real>& wanted = room.sum_lambda;
    std::fill(wanted.begin(), wanted.end(), 0.0);
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      if (!is_one_sided(m, i) || !m.memory[i].active) continue;
      const Block& b = m.blocks[i];
      const Real rate = rate_of(m, b, 0);
      const Real bounce = b.kind == BlockKind::limit && gives_back
                              ? world.links.values()[b.source].joint.extras->restitution
                              : 0;
      if (rate < -kQuiet) wanted[b.first_row] = -bounce * rate;
    }
    room.start.v = room.state.v, room.start.w = room.state.w;
    project_twists(m, wanted);
    bool pulled = false;
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      if (!is_one_sided(m, i) || !m.memory[i].active) continue;
      const std::size_t row = m.blocks[i].first_row;
      const bool leaves = wanted[row] > 0;
      if (room.lambda[row] < 0) m.memory[i].active = false, pulled = true;
      else if (leaves && round == 7) m.memory[i].active = false;
    }
    if (!pulled) {
      for (std::size_t r = 0; r < m.rows; ++r) room.impulses[r] += room.lambda[r];
      for (std::size_t i = 0; i < m.blocks.size(); ++i)
        if (is_one_sided(m, i) && wanted[m.blocks[i].first_row] > 0) m.memory[i].active = false;
      return;
    }
    room.state.v = room.start.v, room.state.w = room.start.w;
  }
}

}  // namespace

void begin_limits(const World& world, Island& m) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    m.memory[i].active = is_one_sided(m, i) && m.room.c[m.blocks[i].first_row] <= kTouch;
  write_all_rows(world, m, {true, false});
  for (std::size_t i = 0; i < m.blocks.size(); ++i)  // what is leaving its limit may go
    if (m.memory[i].active && rate_of(m, m.blocks[i], 0) > kQuiet) m.memory[i].active = false;
}

bool advance_among_limits(World& world, Island& m, Real h) {
  StepScratch& room = m.room;
  Real done = 0;
  int attempts = 0;
  m.events = 0;
  // What is left after so many blows is taken at once.
  for (int tries = 0; done < h * (1 - 1e-12); ++tries) {
    room.begin = room.state, room.impulses_before = room.impulses;
    place(m), place_frames(world, m, done / h, h);
    write_all_rows(world, m, {true, false});
    const Real at_start = clearance(m);
    bool again = false;
    const auto attempt = [&](Real length) {
      ++attempts;
      room.state = room.begin, room.impulses = room.impulses_before;
      m.fresh = m.fresh || again, again = true;
      return advance(world, m, {done, length, h});
    };
    Real length = h - done;
    if (!attempt(length)) return false;
    for (int n = 0; n < 16 && let_go(m); ++n)
      if (!attempt(length)) return false;
    if (Real left = clearance(m); left < -kTouch && tries < kMostEvents && attempts < kMostAttempts) {
      // Where the first limit is met: regula falsi, an end that stays loses half its weight
      // (Illinois).
      Real low = 0, high = length, at_low = std::max(at_start, kTouch), at_high = left;
      int side = 0;
      bool met = false;
      for (int n = 0; n < kMostSearches && !met && high - low > 1e-12 * h; ++n) {
        length = low + (high - low) * at_low / (at_low - at_high);
        if (!attempt(length)) return false;
        left = clearance(m);
        met = std::abs(left) <= kTouch;
        if (left < 0) {
          high = length, at_high = left;
          if (side < 0) at_low *= 0.5;
          side = -1;
        } else {
          low = length, at_low = left;
          if (side > 0) at_high *= 0.5;
          side = 1;
        }
      }
      if (!met && !attempt(length = high)) return false;
    }
    done += length;
    bool reached = false;
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      reached = reached || (is_one_sided(m, i) && !m.memory[i].active &&
                            room.c[m.blocks[i].first_row] <= kTouch);
    if (!reached) continue;
    ++m.events;
    strike(world, m, m.events <= kMostBounces);
    if (row_of(m.settings.integrator).keeps_accelerations) m.fresh = true;
    place_frames(world, m, done / h, h);
    if (!project(world, m, done / h, h)) return false;
  }
  return true;
}

}  // namespace pantin::lagrangian

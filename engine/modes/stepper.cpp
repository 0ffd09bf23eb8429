#include "engine/modes/stepper.hpp"

#include <algorithm>

namespace pantin::detail::modes {
namespace {

constexpr Real kTouching = 1e-9;   // of the outline's extent
constexpr Real kSharp = 1e-12;     // of a step: tolerance of the end of a mode
constexpr Real kStraight = 1e-6;   // of a stretch: a part this short is straight to 1e-12
constexpr Real kDwell = 1.0 / 16;  // of a step: how long a mode is kept where switches pile up
constexpr Real kShort = 1e-6;      // of a step: stretches below are piling up
constexpr int kMostShort = 2, kMostSwitches = 200;
constexpr Real kSameRatio = 0.02, kRest = 0.01;  // see PileUp

/// Bracket of the end of a mode, as times within a stretch.
struct Stretch {
  Real good = 0, bad = 0;  // s: it holds, it does not
  Real slack_good = 0, slack_bad = 0;
  int tries = 0;
  bool last_was_good = false;

  bool is_known() const { return slack_good >= 0 && slack_bad < 0; }
  Real next(Real sharp) const;
  void narrow(Real at, const Slack& s);
};

/// Detects switches that come ever faster. Stretches that shrink by a constant ratio converge to a
/// point in time. Where that is closer than kRest of the step, the remaining ones are not followed.
struct PileUp {
  Real step = 0;  // s
  std::array<Real, 3> last{};
  int stretches = 0, brief = 0;

  void add(Real took) {
    last = {last[1], last[2], took};
    ++stretches;
    brief = took < kShort * step ? brief + 1 : 0;
  }
  bool is_near() const {
    const Real ratio = last[2] / last[1], before = last[1] / last[0];
    return brief > kMostShort ||
           (stretches >= 3 && ratio < 1 && std::abs(ratio - before) < kSameRatio * ratio &&
            last[2] * ratio / (1 - ratio) < kRest * step);
  }
};

/// Margin of a mode: the least of X and the forms on a branch, relative to their terms; below 0
/// outside.
Real margin(const Region& r, const OwnFriction& m, int branch) {
  const Values v = values(r, m), size = magnitudes(r, m);
  Real least = branch * v.divisor / size.divisor;
  for (std::size_t i = 0; i < static_cast<std::size_t>(r.form_count()); ++i)
    least = std::min(least, branch * v.forms[i] / std::max(size.forms[i], 1e-300));
  return least;
}

/// Rows k q = d of a motion. solve() uses three independent ones, the most independent first.
struct RowSet {
  std::array<Vec3, 2 * kMostContacts> rows;
  std::array<Real, 2 * kMostContacts> right;
  std::size_t count = 0;

  void add(Vec3 row, Real d) { rows[count] = row, right[count++] = d; }

  bool solve(Vec3& q) const {
    std::array<Vec3, 2 * kMostContacts> left;
    std::copy_n(rows.begin(), count, left.begin());
    std::array<std::size_t, 3> pick{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::size_t best = 0;
      for (std::size_t i = 1; i < count; ++i)
        if (glm::dot(left[i], left[i]) > glm::dot(left[best], left[best])) best = i;
      const Real size = count ? glm::length(left[best]) : 0;
      if (!(size > 1e-9)) return false;
      const Vec3 unit = left[best] / size;
      pick[k] = best;
      for (std::size_t i = 0; i < count; ++i) left[i] -= glm::dot(left[i], unit) * unit;
    }
    const Vec3 a = rows[pick[0]], b = rows[pick[1]], c = rows[pick[2]];
    const Vec3 bc = glm::cross(b, c), ca = glm::cross(c, a), ab = glm::cross(a, b);
    q = (right[pick[0]] * bc + right[pick[1]] * ca + right[pick[2]] * ab) / glm::dot(a, bc);
    return true;
  }
};

Vec3 row_of(Vec2 point, Vec2 along, Vec2 about) {
  return {along.x, along.y, cross(point - about, along)};
}

bool has(std::uint32_t set, std::size_t i) { return set >> i & 1; }
std::uint32_t kept(const Signs& s) { return s.roll | s.plus | s.minus; }

/// A twist about a point, expressed about the origin.
Vec3 about_origin(Vec3 twist, Vec2 at) {
  return {twist.x + twist.z * at.y, twist.y - twist.z * at.x, twist.z};
}

/// A placement that a twist about the origin has moved for a time, to first order.
Placement moved(const Placement& p, Vec3 twist, Real h) {
  return {{p.shift.x + h * (twist.x - twist.z * p.shift.y),
           p.shift.y + h * (twist.y + twist.z * p.shift.x)},
          p.angle + h * twist.z};
}

}  // namespace

const char* word_for(Ending ending) {
  constexpr const char* kWords[] = {"done",
                                    "no mode",
                                    "the motion is not determined",
                                    "a finger is at a corner, where it has no normal",
                                    "more than 32 contacts",
                                    "several modes hold",
                                    "modes switch without end"};
  return kWords[static_cast<std::size_t>(ending)];
}

void Stepper::prepare_at(const Moment& now) {
  const Touches& t = motion.touches;
  for (std::size_t i = 0; i < t.count; ++i) {
    contacts_[i] = contact_of(now, t.list[i]);
    roll_[i] = now.fingers[t.list[i].finger].roll;
    slide_[i] = now.fingers[t.list[i].finger].slide;
  }
  prepare({{contacts_.data(), t.count}, load_of(now)}, prepared_);
}

bool Stepper::find_twist(const Moment& now, Vec3& twist) const {
  RowSet rows;
  const Vec2 about = now.finger_at(motion.touches.list[0].finger);
  for (std::size_t i = 0; i < motion.touches.count; ++i) {
    if (!has(kept(motion.signs), i)) continue;
    const Contact c = contact_of(now, motion.touches.list[i]);
    const Vec2 t = tangent_of(c.normal);
    rows.add(row_of(c.point, c.normal, about), dot(c.normal, c.velocity));
    if (has(motion.signs.roll, i)) rows.add(row_of(c.point, t, about), dot(t, c.velocity));
  }
  Vec3 q;
  if (!rows.solve(q)) return false;
  twist = about_origin(q, about);
  return true;
}

/// Closes the gaps of the contacts that are kept, without slip of rolling ones.
void Stepper::close(Moment& now) const {
  RowSet rows;
  const Vec2 about = now.finger_at(motion.touches.list[0].finger);
  for (std::size_t i = 0; i < motion.touches.count; ++i) {
    if (!has(kept(motion.signs), i)) continue;
    const Touch touch = motion.touches.list[i];
    const Contact c = contact_of(now, touch);
    rows.add(row_of(c.point, c.normal, about), -gap_of(now, touch));
    if (has(motion.signs.roll, i)) rows.add(row_of(c.point, tangent_of(c.normal), about), 0);
  }
  Vec3 q;
  if (rows.solve(q)) now.place(moved(now.placed, about_origin(q, about), 1));
}

/// Runge-Kutta, order 4; false where the rows lose their rank.
bool Stepper::advance(Moment& now, Real h) const {
  const Placement from = now.placed;
  const Real start = now.time;
  std::array<Placement, 4> rates;
  constexpr Real kParts[] = {0, 0.5, 0.5, 1};
  for (std::size_t k = 0; k < 4; ++k) {
    const Real part = kParts[k] * h;
    now.time = start + part;
    if (k > 0)
      now.place({from.shift + part * rates[k - 1].shift, from.angle + part * rates[k - 1].angle});
    Vec3 twist;
    if (!find_twist(now, twist)) return false;
    const Placement next = moved(now.placed, twist, 1);
    rates[k] = {next.shift - now.placed.shift, twist.z};
  }
  const auto mean = [](const auto& a, const auto& b, const auto& c, const auto& d) {
    return 1.0 / 6 * (a + 2 * (b + c) + d);
  };
  now.place(
      {from.shift + h * mean(rates[0].shift, rates[1].shift, rates[2].shift, rates[3].shift),
       from.angle + h * mean(rates[0].angle, rates[1].angle, rates[2].angle, rates[3].angle)});
  now.time = start + h;
  close(now);
  return true;
}

/// Whether the forces and slips of the mode still hold.
Slack Stepper::forces_hold(const Moment& now) {
  prepare_at(now);
  const Friction mu{{roll_.data(), prepared_.count}, {slide_.data(), prepared_.count}};
  const std::uint32_t all = kept(motion.signs);
  for (const Region& r : prepared_.regions) {
    const Signs signs = signs_of(r);
    if (signs.roll != motion.signs.roll || kept(signs) != all) continue;
    Real least = 1;
    for (std::size_t k = 0; k < static_cast<std::size_t>(r.variables()); ++k)
      if (r.slip_sign[k] != 0) least = std::min(least, std::abs(r.slip[k]) / prepared_.speed);
    if (!(signs == motion.signs)) return {false, -least};  // a slip has changed its sign
    const OwnFriction m = own(r, mu);
    const int branch = r.determinant > 0 ? motion.index : -motion.index;
    return {contains(r, m), std::min(least, margin(r, m, branch))};
  }
  if (motion.index != 0) return {};
  find_modes(prepared_, mu, modes_);
  for (const SignedMode& mode : modes_.indeterminate)
    if (mode.signs == motion.signs) return {true, Slack{}.value};
  return {};
}

/// Whether no other finger has reached the lamina, and no contact has left its edge.
Slack Stepper::contacts_stay(const Moment& before, const Moment& now) const {
  std::uint32_t touching = 0;
  const Real size = tolerance_ / kTouching;
  Slack s{true, 1};
  const auto expect = [&](Real length, Real least) {
    s.holds &= length >= least;
    s.value = std::min(s.value, (length - least) / size);
  };
  for (std::size_t i = 0; i < motion.touches.count; ++i) {
    const Touch touch = motion.touches.list[i];
    touching |= 1u << touch.finger;
    if (has(kept(motion.signs), i))
      expect(left_on_edge(now, touch), 0);
    else
      expect(gap_of(now, touch), -tolerance_);
  }
  for (std::size_t i = 0; i < now.fingers.size(); ++i)
    if (!has(touching, i) && least_gap(before, i) >= -tolerance_) expect(least_gap(now, i), 0);
  return s;
}

Slack Stepper::holds(const Moment& before, const Moment& now) {
  const Slack contacts = contacts_stay(before, now);
  if (!contacts.holds) return contacts;
  const Slack forces = forces_hold(now);
  return {forces.holds, std::min(forces.value, contacts.value)};
}

/// Bisects between two moments at which a mode holds and does not. The path between is straight.
void Stepper::sharpen(const Moment& start, Moment& low, Moment& high, Real sharp) {
  while (high.time - low.time > sharp) {
    Moment middle = low;
    middle.place({0.5 * (low.placed.shift + high.placed.shift),
                  0.5 * (low.placed.angle + high.placed.angle)});
    middle.time = (low.time + high.time) / 2;
    Moment& end = holds(start, middle).holds ? low : high;
    end.place(middle.placed), end.time = middle.time;
  }
}

/// The next time to test for the end of a mode: by the rule of false position (Illinois) where
/// margins are known at both ends, else in the middle.
Real Stretch::next(Real sharp) const {
  const Real middle = (good + bad) / 2;
  if (!(slack_good >= 0 && slack_bad < 0) || tries % 4 == 3) return middle;
  const Real zero = good + (bad - good) * slack_good / (slack_good - slack_bad);
  const Real rim = 0.4 * std::min(sharp, bad - good);
  return std::clamp(zero, good + rim, bad - rim);
}

void Stretch::narrow(Real at, const Slack& s) {
  ++tries;
  if (s.holds) {
    if (last_was_good) slack_bad /= 2;
    good = at, slack_good = s.value;
  } else {
    if (tries > 1 && !last_was_good) slack_good /= 2;
    bad = at, slack_bad = s.value;
  }
  last_was_good = s.holds;
}

/// Advances while the mode holds, at most by `longest`; returns how long. Its end is found to
/// `sharp`.
Real Stepper::go(Moment& now, Real longest, Real sharp) {
  const Moment start = now;
  const auto try_for = [&](Real h) -> Slack {
    Moment next = start;
    if (!advance(next, h)) return {};
    now.place(next.placed), now.time = next.time;
    return holds(start, next);
  };
  const Slack whole = try_for(longest);
  if (whole.holds) return longest;
  Stretch s{.bad = longest, .slack_good = holds(start, start).value, .slack_bad = whole.value};
  while (s.bad - s.good > (s.is_known() ? sharp : std::max(kStraight * longest, sharp))) {
    const Real at = s.next(sharp);
    s.narrow(at, try_for(at));
  }
  if (s.bad - s.good > sharp) {
    Moment low = start, high = start;
    if (advance(low, s.good) && advance(high, s.bad)) sharpen(start, low, high, sharp);
    s.bad = high.time - start.time;
  }
  try_for(s.bad);  // just beyond the end, where the next mode holds
  return s.bad;
}

bool Stepper::take(const Moment& now, const Region& r) {
  const Friction mu{{roll_.data(), prepared_.count}, {slide_.data(), prepared_.count}};
  const OwnFriction m = own(r, mu);
  const std::array<Real, 3> f = forces(r, m);
  motion.signs = signs_of(r);
  motion.index = index_of(r, values(r, m).divisor > 0 ? 1 : -1);
  motion.normal_force = {}, motion.tangent_force = {};
  if (r.kind == Kind::roll_slide) {
    motion.normal_force[r.contacts[0]] = f[0], motion.tangent_force[r.contacts[0]] = f[1];
    motion.normal_force[r.contacts[1]] = f[2];
    motion.tangent_force[r.contacts[1]] = -r.slip_sign[1] * m[1] * f[2];
  } else {
    for (std::size_t k = 0; k < 3; ++k) {
      motion.normal_force[r.contacts[k]] = f[k];
      motion.tangent_force[r.contacts[k]] = -r.slip_sign[k] * m[k] * f[k];
    }
  }
  return motion.is_known = find_twist(now, motion.twist);
}

bool Stepper::take(const Moment& now, const SignedMode& mode) {
  motion.signs = mode.signs;
  motion.index = 0;
  motion.normal_force = mode.normal_force, motion.tangent_force = mode.tangent_force;
  return motion.is_known = find_twist(now, motion.twist);
}

/// Chooses the mode to continue in; false where there is none.
bool Stepper::choose(const Moment& now, StepEnd& end) {
  const Touches before = motion.touches;
  const Signs last = motion.signs;
  const auto same = [](Touch a, Touch b) { return a.finger == b.finger && a.feature == b.feature; };
  motion.touches = touches_of(now, tolerance_);
  const bool as_before =
      motion.is_known &&
      std::equal(before.begin(), before.end(), motion.touches.begin(), motion.touches.end(), same);
  motion.is_known = false;
  end.verdict = Verdict::no_balance;
  end.ending = motion.touches.at_corner  ? Ending::at_corner
               : motion.touches.too_many ? Ending::crowded
                                         : Ending::no_mode;
  if (end.ending != Ending::no_mode || motion.touches.count == 0) return false;
  prepare_at(now);
  const Friction mu{{roll_.data(), prepared_.count}, {slide_.data(), prepared_.count}};
  const Region* best = nullptr;
  std::array<Real, 2> of_best{};
  std::size_t count = 0, stable = 0;
  for (const Region& r : prepared_.regions) {
    const OwnFriction m = own(r, mu);
    const int branch = branch_of(r, m);
    if (branch == 0) continue;
    ++count;
    const bool is_last = as_before && signs_of(r) == last;
    const std::array<Real, 2> rank{is_last ? 2.0 : Real(index_of(r, branch)), margin(r, m, branch)};
    if (!best || rank > of_best) best = &r, of_best = rank;
    stable += index_of(r, branch) > 0;
  }
  end.choices = std::max(end.choices, count);
  end.verdict = count > 1 ? Verdict::ambiguous : Verdict::unique;
  if (best && doubt == Doubt::stop && of_best[0] < 2 && stable != 1) {
    end.ending = Ending::undecided;
    return false;
  }
  if (best && take(now, *best)) return true;
  find_modes(prepared_, mu, modes_);
  end.verdict = modes_.verdict;
  for (const FeasibleMode& mode : modes_.modes)  // on its boundary
    if (take(now, prepared_.regions[static_cast<std::size_t>(mode.region)])) return true;
  for (const SignedMode& mode : modes_.indeterminate)
    if (take(now, mode)) return true;
  if (!modes_.indeterminate.empty() || !modes_.modes.empty()) end.ending = Ending::free_motion;
  return false;
}

StepEnd Stepper::step(const Part& part, std::span<const Finger> fingers, Real duration) {
  StepEnd end;
  tolerance_ = kTouching * extent(part.outline);
  Moment now{part, fingers};
  now.place(placed);
  PileUp pile{.step = duration};
  while (duration - now.time > kSharp * duration) {
    const Signs before = motion.signs;
    const bool moved_before = motion.is_known;
    if (!choose(now, end)) break;
    if (moved_before && !(before == motion.signs)) ++end.switches;
    const bool piles_up = pile.is_near() || end.switches > kMostSwitches;
    end.zeno |= piles_up;
    if (end.zeno && doubt == Doubt::stop) {
      end.ending = Ending::zeno;
      break;
    }
    if (piles_up) {  // modes alternate
      Moment next = now;
      if (!advance(next, std::min(kDwell * duration, duration - now.time))) break;
      now.place(next.placed), now.time = next.time;
      continue;
    }
    pile.add(go(now, duration - now.time, kSharp * duration));
  }
  placed = now.placed;
  end.time = now.time;
  if (duration - now.time <= kSharp * duration) end.ending = Ending::done;
  return end;
}

namespace {

/// Moves a lamina to close its contacts, one after another, each by the least motion.
void close_all(Moment& now, const Touches& touches, Real size) {
  constexpr int kMostSweeps = 200;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    Real worst = 0;
    for (const Touch touch : touches) {
      const Contact c = contact_of(now, touch);
      const Real gap = gap_of(now, touch);
      const Vec2 middle = now.placed.shift;
      const Real arm = cross(c.point - middle, c.normal) / size;
      const Real by = -gap / (1 + arm * arm), turn = by * arm / size;
      now.place({now.placed.shift + by * c.normal, now.placed.angle + turn});
      worst = std::max(worst, std::abs(gap));
    }
    if (worst < 1e-13 * size) return;
  }
}

/// The largest velocity difference of two motions on the outline, m/s.
Real apart(const Moment& now, Vec3 p, Vec3 q) {
  const Vec3 d = p - q;
  Real most = 0;
  for (const Vec2 corner : now.part.outline) {
    const Vec2 at = now.placed.shift + turned(corner, now.facing.x, now.facing.y);
    most = std::max(most, std::hypot(d.x - d.z * at.y, d.y + d.z * at.x));
  }
  return most;
}

}  // namespace

bool Stepper::resume(const Part& part, std::span<const Finger> fingers, const Found& found) {
  constexpr Real kNear = 0.01;  // of the extent
  const Real size = extent(part.outline);
  tolerance_ = kTouching * size;
  Moment now{part, fingers};
  now.place(found.placed);
  Touches near = touches_of(now, kNear * size);
  const auto touches = [&](Touch t) { return has(found.fingers, t.finger); };
  near.count = static_cast<std::size_t>(
      std::partition(near.list.begin(), near.list.begin() + near.count, touches) -
      near.list.begin());
  if (near.count == 0 || near.at_corner || near.too_many) return false;
  close_all(now, near, size);
  const Motion before = motion;
  motion.touches = touches_of(now, tolerance_);
  if (motion.touches.count == near.count && take_nearest(now, found)) {
    placed = now.placed;
    return true;
  }
  motion = before;
  return false;
}

/// Takes the stable mode whose motion is most similar to a given one.
bool Stepper::take_nearest(const Moment& now, const Found& found) {
  prepare_at(now);
  const Friction mu{{roll_.data(), prepared_.count}, {slide_.data(), prepared_.count}};
  const Region* best = nullptr;
  const SignedMode* other = nullptr;
  Real least = found.apart;
  for (const Region& r : prepared_.regions) {
    const int branch = branch_of(r, own(r, mu));
    const Real away = apart(now, r.twist, found.twist);
    if (branch != 0 && index_of(r, branch) > 0 && away <= least) best = &r, least = away;
  }
  if (!best) {
    find_modes(prepared_, mu, modes_);
    for (const SignedMode& mode : modes_.indeterminate) {
      const Real away = apart(now, mode.twist, found.twist);
      if (mode.motion_unique && away <= least) other = &mode, least = away;
    }
  }
  return best ? take(now, *best) : other && take(now, *other);
}

void Stepper::reserve(std::size_t contacts) {
  const std::size_t n = std::min(contacts, kMostContacts);
  prepared_.candidates.reserve(n * (n - 1) * (n + 4) / 6);
  // The motion of n fingers in general position allows at most 2 n - 4 and 6 n - 12 modes.
  prepared_.regions.reserve(16 * n);
  modes_.modes.reserve(16 * n), modes_.indeterminate.reserve(16 * n);
  modes_.search.list.reserve(16 * n);
}

}  // namespace pantin::detail::modes

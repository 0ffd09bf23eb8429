// Loops, pins and elastic cables in the energy-momentum method: forces between two points of the
// bodies or of the world. As at joints, a force acts at the mean of the arms before and after the
// step; its work is then exactly its product with the change of the distance d between the points.
//
// The unknown of a tie is the impulse mu of half the step. A rigid tie makes d vanish but for a
// tiny compliance. The force of
// an elastic one is a function of d before and after whose work is the difference of the stored
// energy, so that it is given back to the last digit. [Gonzalez 1996]
//
// A taut inextensible cable keeps the length of d, which is quadratic: its force is along the mean
// of d before and after, and does no work. One that would push is left to the other rules.
//
// The elimination of the tree gives the motion for the present mu; its response to further impulses
// at the ties takes an inward and an outward pass a tie.
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/conserving_joints.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNobody = UINT32_MAX;
/// A rigid tie gives way by this part of the motion that its impulse makes in the step. Loops that
/// say the same twice thus share their load, and a net stretched flat has a finite tension. Where
/// that finds no solution, as in a net whose corners are moved apart, by the second part.
constexpr Real kSoftness = 1e-7, kYielding = 0.03;

Mat3 rows_at(const Real* m, std::size_t stride) {
  return Mat3(m[0], m[stride], m[2 * stride], m[1], m[stride + 1], m[2 * stride + 1], m[2],
              m[stride + 2], m[2 * stride + 2]);
}

/// Parts of the island's size: below the first, a tie's gap is its own compliance, whose energy
/// counts; more than the second is no solution.
constexpr Real kClosed = 1e-5, kAccepted = 3e-6;
/// rad: rounding of a joint's angle.
constexpr Real kBeyond = 1e-12;

/// One step, as the hooks of the kernel see it.
struct TiedStep {
  const World& world;
  Island& a;
  Real h;
  bool* in_the_way;

  const Body& body(std::uint32_t c) const { return world.bodies.values()[a.slots[c]]; }
};

/// Where a point of a body is at the iterate; its anchor is measured from the own joint.
Vec3 point_now(const TiedStep& s, std::uint32_t c, Vec3 anchor) {
  const Body& b = s.body(c);
  const Vec3 joint = b.pose.position + b.pose.rotation * s.a.constants.vec(kOwnAnchor, c) +
                     s.a.scratch.work.vec(kJointWay, c);
  return joint + s.a.scratch.work.quat(kEndRotation, c) * anchor;
}

/// Arms from the own joint, and d, at the iterate.
void look_at(const TiedStep& s, ConservingTie& t) {
  const auto arms = [&](std::uint32_t c, Vec3 anchor, Vec3& mean, Vec3& end) {
    end = s.a.scratch.work.quat(kEndRotation, c) * anchor;
    mean = 0.5 * (s.body(c).pose.rotation * anchor + end);
  };
  arms(t.b, t.anchor_b, t.mean_b, t.end_b);
  if (t.a != kNobody) arms(t.a, t.anchor_a, t.mean_a, t.end_a);
  t.now =
      point_now(s, t.b, t.anchor_b) - (t.a != kNobody ? point_now(s, t.a, t.anchor_a) : t.target);
}

/// Impulse and derivative of a spring with a damper.
void load_spring(ConservingTie& t, Real h) {
  const Real along = 0.5 * t.stiffness + t.damping / h;
  t.mu = 0.5 * h * (along * t.now + (0.5 * t.stiffness - t.damping / h) * t.before);
  t.derivative = Mat3(0.5 * h * along);
}

/// The same of an elastic cable: minus its tension is s d, s = 2 (V_1 - V_0) / (l_1^2 - l_0^2), d
/// being the mean of d before and after.
void load_cable(ConservingTie& t, Real h) {
  const Real l0 = glm::length(t.before), l1 = glm::length(t.now);
  const Real over0 = std::max(Real(0), l0 - t.length), over1 = std::max(Real(0), l1 - t.length);
  const Vec3 mean = 0.5 * (t.before + t.now);
  Real s = 0, by_length = 0;
  if (over0 > 0 && over1 > 0) {
    s = t.stiffness * (1 - 2 * t.length / (l0 + l1));
    by_length = 2 * t.stiffness * t.length / ((l0 + l1) * (l0 + l1));
  } else if (over0 > 0 || over1 > 0) {
    const Real squares = l1 * l1 - l0 * l0;
    s = t.stiffness * (over1 * over1 - over0 * over0) / squares;
    by_length = 2 * (t.stiffness * over1 - s * l1) / squares;
  }
  t.mu = 0.5 * h * s * mean;
  t.derivative = 0.5 * h * Mat3(0.5 * s);
  if (l1 > 0) t.derivative += 0.5 * h * by_length * glm::outerProduct(mean, t.now / l1);
}

/// The impulse of a taut cable is along the mean of d.
void load_taut(ConservingTie& t) {
  const Vec3 mean = 0.5 * (t.before + t.now);
  t.stiffness = glm::dot(t.mu, mean) / glm::dot(mean, mean);
  t.mu = t.stiffness * mean;
}

/// Adds the impulse of a tie to the block of one of its bodies, as that of a child without mass.
void add_to_block(Real* block, Vec3 impulse, Vec3 mean, Vec3 end) {
  const Vec3 f = 0.5 * impulse, torque = glm::cross(mean, impulse);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) block[3 * i + j] += end[i] * f[j];
    block[4 * i] -= glm::dot(f, end);
    block[9 + i] += impulse[i], block[12 + i] += torque[i];
  }
}

void load(void* context) {
  const TiedStep& s = *static_cast<const TiedStep*>(context);
  StepScratch& r = s.a.scratch;
  std::fill(r.tie_blocks.begin(), r.tie_blocks.end(), 0.0);
  for (ConservingTie& t : r.ties) {
    look_at(s, t);
    if (t.kind == TieKind::spring) load_spring(t, s.h);
    if (t.kind == TieKind::cable) load_cable(t, s.h);
    if (t.kind == TieKind::taut) load_taut(t);
    add_to_block(&r.tie_blocks[kTieBlock * t.b], t.mu, t.mean_b, t.end_b);
    if (t.a != kNobody) add_to_block(&r.tie_blocks[kTieBlock * t.a], -t.mu, t.mean_a, t.end_a);
  }
}

/// Clears the impulses of all bodies; adds one to both bodies of a tie.
void clear(StepScratch& r) {
  std::fill(r.tie_impulses.begin(), r.tie_impulses.end(), Mat3(0));
  std::fill(r.tie_torques.begin(), r.tie_torques.end(), Mat3(0));
}
void push(StepScratch& r, const ConservingTie& t, const Mat3& mu, Arms arms) {
  const Vec3 on_b = arms == Arms::mean ? t.mean_b : t.end_b;
  r.tie_impulses[t.b] -= mu, r.tie_torques[t.b] -= cross_matrix(on_b) * mu;
  if (t.a == kNobody) return;
  const Vec3 on_a = arms == Arms::mean ? t.mean_a : t.end_a;
  r.tie_impulses[t.a] += mu, r.tie_torques[t.a] += cross_matrix(on_a) * mu;
}

/// Response of the island to these impulses, three at a time: displacements of the own joints into
/// `tie_impulses`, rotations into `tie_torques`, impulses at the joints into `tie_joints`.
void respond(Island& a, Arms arms) {
  if (!a.joints.empty()) return respond_stiff(a, arms);
  StepScratch& r = a.scratch;
  for (std::size_t c = a.count(); c-- > 0;) {
    const Mat3 turn = rows_at(&r.tie_factors[kTieFactor * c], 3) * r.tie_torques[c];
    r.tie_torques[c] = turn;
    r.tie_impulses[c] -= rows_at(&r.tie_factors[kTieFactor * c + 9], 3) * turn;
    if (a.parents[c] < 0) continue;
    const auto p = static_cast<std::size_t>(a.parents[c]);
    const Vec3 reach = r.work.vec(arms == Arms::mean ? kMeanReach : kEndReach, c);
    r.tie_impulses[p] += r.tie_impulses[c];
    r.tie_torques[p] += cross_matrix(reach) * r.tie_impulses[c];
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Real* node = r.nodes.data() + kNodeSize * c;
    const Mat3 mass = rows_at(node + kArticulatedMass, 4);
    Mat3 y(0);
    if (a.parents[c] >= 0) {
      const auto p = static_cast<std::size_t>(a.parents[c]);
      y = r.tie_impulses[p] - cross_matrix(r.work.vec(kEndReach, c)) * r.tie_torques[p];
    } else if (a.parents[c] == kFree) {
      y = glm::inverse(mass) * r.tie_impulses[c];
    }
    r.tie_joints[c] = mass * y - r.tie_impulses[c];
    r.tie_impulses[c] = y;
    r.tie_torques[c] -= rows_at(node + kResponse, 4) * y;
  }
}

/// Change of d of a tie by the response.
Mat3 change_of(const StepScratch& r, const ConservingTie& t) {
  Mat3 d = r.tie_impulses[t.b] - cross_matrix(t.end_b) * r.tie_torques[t.b];
  if (t.a != kNobody) d -= r.tie_impulses[t.a] - cross_matrix(t.end_a) * r.tie_torques[t.a];
  return d;
}
/// The same by the unknowns of the bodies.
Vec3 change_of(const Island& a, const ConservingTie& t) {
  const auto at = [&](std::uint32_t c, Vec3 arm) {
    return a.memory.vec(kMove, c) + glm::cross(a.memory.vec(kTurnBy, c), arm);
  };
  return at(t.b, t.end_b) - (t.a != kNobody ? at(t.a, t.end_a) : Vec3(0));
}

/// The part of a tie in the equations, for the unknowns as the elimination left them.
struct TieRows {
  bool takes = true;      // part in these equations
  Mat3 before = Mat3(1);  // of the change of d, in its equations
  Vec3 right{0};          // their right-hand side
  Mat3 own{0};            // factor of its impulse in them
};

Real size_of(const Mat3& m) { return std::abs(m[0][0]) + std::abs(m[1][1]) + std::abs(m[2][2]); }

/// Solves for the impulses of all ties for which `rows_of` has equations, and moves the bodies by
/// them: before (d + W mu) - own mu = right, W being the response.
template <class RowsOf, class Take>
bool solve_ties(Island& a, Arms arms, const RowsOf& rows_of, const Take& take) {
  StepScratch& r = a.scratch;
  std::size_t count = 0;
  for (const ConservingTie& t : r.ties) count += rows_of(t).takes;
  if (count == 0) return true;
  const std::size_t n = 3 * count;
  std::size_t column = 0;
  for (ConservingTie& t : r.ties) {
    if (!rows_of(t).takes) continue;
    clear(r);
    push(r, t, Mat3(1), arms);
    respond(a, arms);
    if (t.softness == 0) t.softness = r.tie_yield / 3 * size_of(change_of(r, t));
    std::size_t row = 0;
    for (const ConservingTie& other : r.ties) {
      const TieRows rows = rows_of(other);
      if (!rows.takes) continue;
      Mat3 w = rows.before * change_of(r, other);
      if (row == column) w -= rows.own;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          r.tie_matrix[(row + static_cast<std::size_t>(i)) * n + column +
                       static_cast<std::size_t>(j)] = w[j][i];
      row += 3;
    }
    column += 3;
  }
  std::size_t row = 0;
  for (const ConservingTie& t : r.ties) {
    const TieRows rows = rows_of(t);
    if (!rows.takes) continue;
    const Vec3 right = rows.right - rows.before * change_of(a, t);
    for (int i = 0; i < 3; ++i) r.tie_solution[row++] = right[i];
  }
  if (!solve_tie_equations(r, n)) return false;
  clear(r);
  row = 0;
  for (ConservingTie& t : r.ties) {
    if (!rows_of(t).takes) continue;
    const Vec3 mu(r.tie_solution[row], r.tie_solution[row + 1], r.tie_solution[row + 2]);
    push(r, t, Mat3(mu, Vec3(0), Vec3(0)), arms);
    take(t, mu);
    row += 3;
  }
  respond(a, arms);
  for (std::size_t c = 0; c < a.count(); ++c) {
    a.memory.set(kMove, c, a.memory.vec(kMove, c) + r.tie_impulses[c][0]);
    a.memory.set(kTurnBy, c, a.memory.vec(kTurnBy, c) + r.tie_torques[c][0]);
  }
  return true;
}

/// What the ties' impulses add to those at the joints.
void add_joint_impulses(Island& a, Real share) {
  for (std::size_t c = 0; c < a.count(); ++c)
    a.memory.set(kLambda, c, a.memory.vec(kLambda, c) + share * a.scratch.tie_joints[c][0]);
}

/// The factor of a taut cable's impulse: across n it is what its direction says, scaled alike.
Mat3 taut_factor(const TiedStep& s, const ConservingTie& t, const Mat3& along) {
  return s.h / s.a.mass * (Mat3(1) - along) + t.softness * along;
}
/// Along the mean of d, its length; across it, an impulse that stays along the mean.
TieRows taut_rows(const TiedStep& s, const ConservingTie& t) {
  const Vec3 n = glm::normalize(t.before + t.now);
  const Mat3 along = glm::outerProduct(n, n);
  const Real l = glm::length(t.now), over = 0.5 * (l - t.length * t.length / l);
  return {true,
          glm::outerProduct(n, t.now / l) + 0.5 * s.h / s.a.mass * t.stiffness * (Mat3(1) - along),
          (t.softness * glm::dot(n, t.mu) - over) * n, taut_factor(s, t, along)};
}
/// Of velocities: along d at the end.
TieRows taut_speeds(const TiedStep& s, const ConservingTie& t) {
  const Vec3 n = glm::normalize(t.now);
  const Mat3 along = glm::outerProduct(n, n);
  return {true, along, along * t.velocity, taut_factor(s, t, along)};
}

bool correct(void* context) {
  const TiedStep& s = *static_cast<const TiedStep*>(context);
  const auto rows_of = [&](const ConservingTie& t) {
    if (t.kind == TieKind::taut) return taut_rows(s, t);
    return t.kind == TieKind::rigid
               ? TieRows{true, Mat3(1), t.softness * t.mu - t.now, Mat3(t.softness)}
               : TieRows{true, t.derivative, Vec3(0), Mat3(1)};
  };
  if (!solve_ties(s.a, Arms::mean, rows_of, [](ConservingTie& t, Vec3 mu) { t.mu += mu; }))
    return false;
  add_joint_impulses(s.a, 1);
  return true;
}

bool project(void* context) {
  const TiedStep& s = *static_cast<const TiedStep*>(context);
  const auto rows_of = [&](const ConservingTie& t) {
    if (t.kind == TieKind::taut) return taut_speeds(s, t);
    return TieRows{t.kind == TieKind::rigid, Mat3(1), t.velocity, Mat3(t.softness)};
  };
  std::vector<ConservingTie>& ties = s.a.scratch.ties;
  for (ConservingTie& t : ties) t.softness = 0;
  // The impulses of the projection count in the mean over the step.
  if (!solve_ties(s.a, Arms::end, rows_of, [](ConservingTie&, Vec3) {})) return false;
  if (std::any_of(ties.begin(), ties.end(), [&](auto& t) { return rows_of(t).takes; }))
    add_joint_impulses(s.a, 0.5);
  return true;
}

/// Whether an inextensible cable would be too long at the iterate.
bool is_taut(const TiedStep& s, const PackedCable& cable) {
  const CableParameters& c = s.world.cables.values()[cable.cable].joint;
  if (c.compliance > 0 || cable.lambda > 0) return false;
  const auto end = [&](std::uint32_t column, std::uint32_t slot, Vec3 anchor) {
    return column == kNobody ? point_on(s.world, slot, anchor)
                             : point_now(s, column, anchor - s.a.constants.vec(kOwnAnchor, column));
  };
  return glm::length(end(cable.column_b, cable.slot_b, c.anchor_b) -
                     end(cable.column_a, cable.slot_a, c.anchor_a)) > c.length;
}

/// Whether a joint would be beyond its limits at the iterate.
bool is_beyond(const TiedStep& s, std::size_t c) {
  const PackedJoint& j = s.a.joints[c];
  if (!j.stiff || !j.joint.limits.any()) return false;
  const auto row = static_cast<Work>(kEndRotation);
  const Quat rotation =
      joint_rotation(j, s.a.scratch.work.quat(row, c), parent_rotation(s.world, s.a, c, row));
  return violation(j.joint, rotation) > kBeyond;
}

bool accept(void* context, Real& released) {
  const TiedStep& s = *static_cast<const TiedStep*>(context);
  Real most = 0;
  for (ConservingTie& t : s.a.scratch.ties) {
    look_at(s, t);
    released += 2 / s.h * glm::dot(t.mu, t.before - t.now);
    if (t.kind == TieKind::rigid) most = std::max(most, glm::length(t.now));
    if (t.kind != TieKind::taut) continue;
    most = std::max(most, std::abs(glm::length(t.now) - t.length));
    *s.in_the_way = *s.in_the_way || glm::dot(t.mu, t.before + t.now) < 0;
  }
  for (const PackedCable& cable : s.a.cables) *s.in_the_way = *s.in_the_way || is_taut(s, cable);
  for (std::size_t c = 0; c < s.a.joints.size(); ++c)
    *s.in_the_way = *s.in_the_way || is_beyond(s, c);
  const bool yields = s.a.scratch.tie_yield > kSoftness;
  return !*s.in_the_way && most <= (yields ? kNearTie : kAccepted) * s.a.size;
}

/// Where a tie is fixed in the world over the step, and how fast it is at its end.
struct Place {
  Vec3 before, after, velocity;
};

Place place_of(const World& world, const PackedPin& pin, Real h) {
  const bool jumps = pin.held_body != kNobody && world.bodies.values()[pin.held_body].teleport;
  const Vec3 before = jumps ? pin.target : pin.target_before;
  Vec3 velocity = (pin.target - before) / h;
  if (pin.held_body != kNobody) {
    const Body& b = world.bodies.values()[pin.held_body];
    velocity = b.velocity + glm::cross(b.angular_velocity, b.pose.rotation * pin.held_anchor);
  }
  return {before, pin.target, velocity};
}

/// The same in one part of the step.
struct PlaceInStep {
  Place place;
  const StepPart& part;
};

/// Completes a tie for a part of the step of length h in all.
void begin_tie(const World& world, Island& a, ConservingTie t, const PlaceInStep& fixed) {
  const auto& [place, part] = fixed;
  const Real begin = part.begin;
  const auto start = [&](std::uint32_t c, Vec3& anchor) {
    const Vec3 at = point_on(world, a.slots[c], anchor);
    anchor -= a.constants.vec(kOwnAnchor, c);
    return at;
  };
  const Vec3 way = place.after - place.before;
  t.target = place.after - (1 - part.end) * way;
  t.velocity = t.a != kNobody ? Vec3(0) : part.end == 1 ? place.velocity : way / part.whole;
  t.still = t.a != kNobody || (way == Vec3(0) && t.velocity == Vec3(0));
  t.before = start(t.b, t.anchor_b) -
             (t.a != kNobody ? start(t.a, t.anchor_a) : place.before + begin * way);
  if (t.kind == TieKind::rigid && glm::length(t.before) > kClosed * a.size) t.still = false;
  t.mu = Vec3(0);
  a.scratch.ties.push_back(t);
}

}  // namespace

void begin_ties(const World& world, Island& a, const StepPart& part) {
  StepScratch& r = a.scratch;
  r.ties.clear();
  r.tie_yield = part.yields ? kYielding : kSoftness;
  const Real to_mu = 0.5 / (part.whole * part.whole) * (part.end - part.begin) * part.whole;
  for (const PackedPin& pin : a.pins) {
    ConservingTie t;
    t.b = pin.column, t.anchor_b = pin.anchor;
    t.a = pin.partner, t.anchor_a = pin.held_anchor;
    t.kind = pin.compliance > 0 ? TieKind::spring : TieKind::rigid;
    if (pin.compliance > 0)
      t.stiffness = 1 / pin.compliance, t.damping = kSpringDamping * t.stiffness;
    begin_tie(world, a, t,
              {pin.partner == kNobody ? place_of(world, pin, part.whole) : Place{}, part});
    if (t.kind == TieKind::rigid) r.ties.back().mu = -to_mu * pin.lambda;
  }
  for (const PackedCable& cable : a.cables) {
    const CableParameters& s = world.cables.values()[cable.cable].joint;
    const bool stretches = s.compliance > 0;
    if (!stretches && !(cable.lambda > 0)) continue;
    ConservingTie t;
    const bool has_b = cable.column_b != kNobody;
    t.cable = static_cast<std::uint32_t>(&cable - a.cables.data());
    t.kind = stretches ? TieKind::cable : TieKind::taut, t.length = s.length;
    if (stretches) t.stiffness = 1 / s.compliance;
    t.b = has_b ? cable.column_b : cable.column_a;
    t.anchor_b = has_b ? s.anchor_b : s.anchor_a;
    t.a = has_b ? cable.column_a : kNobody, t.anchor_a = s.anchor_a;
    Place place{};
    if (t.a == kNobody) {
      const std::uint32_t slot = has_b ? cable.slot_a : cable.slot_b;
      const Vec3 anchor = has_b ? s.anchor_a : s.anchor_b;
      place.before = point_before(world, slot, anchor, part.whole);
      place.after = point_on(world, slot, anchor);
      const Body& b = world.bodies.values()[slot];
      place.velocity = b.velocity + glm::cross(b.angular_velocity, b.pose.rotation * anchor);
    }
    begin_tie(world, a, t, {place, part});
    if (!stretches) r.ties.back().mu = to_mu * cable.lambda * glm::normalize(r.ties.back().before);
  }
}

void store_ties(Island& a, const StepPart& part) {
  const Real to_lambda = 2 * part.whole / (part.end - part.begin);
  auto tie = a.scratch.ties.cbegin();
  for (PackedPin& pin : a.pins) pin.lambda = -to_lambda * (tie++)->mu, pin.reachable = true;
  for (PackedCable& cable : a.cables) cable.lambda = 0;
  for (; tie != a.scratch.ties.cend(); ++tie)
    a.cables[tie->cable].lambda = to_lambda * glm::length(tie->mu);
}

bool conserve_tied(World& world, Island& a, ConservingInput in, TiedPart& with) {
  StepScratch& r = a.scratch;
  const StepPart& part = with.part;
  TiedStep step{world, a, in.h, &with.in_the_way};
  const ConservingTies ties{
      &step, r.tie_blocks.data(), r.tie_factors.data(), load, correct, accept, project};
  in.ties = &ties;
  if (a.joints.empty()) return kernels().conserve(view_of(world, a), in);
  StiffStep stiff{world, a, in.h, part};
  const ConservingJoints joints = stiff_joints(stiff);
  in.joints = &joints;
  return kernels().conserve(view_of(world, a), in);
}

}  // namespace pantin::detail::articulated

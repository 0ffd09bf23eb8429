// Strings and held points as rows of the articulated solve: the response of the whole articulation
// to a load at a point costs one way up and one way down the tree, and the loads follow from a
// small dense system whose strings can only pull.
#include <algorithm>

#include "engine/solvers/articulated/internal.hpp"

namespace pantin::articulated {
namespace {

constexpr std::uint32_t kNobody = UINT32_MAX;

/// From the joint point of a body to one of its anchors, world axes.
Vec3 lever(const Island& a, std::size_t column, Vec3 anchor, Work rotation_row) {
  return a.room.work.quat(rotation_row, column) * anchor - a.room.work.vec(kArm, column);
}

struct Ends {
  Vec3 a, b;
};

Ends ends_of(const World& world, const Island& a, const Cord& cord, Work position_row,
             Work rotation_row) {
  const StringJoint& s = world.strings.values()[cord.string].joint;
  return {cord.column_a == kNobody
              ? point_on(world, cord.slot_a, s.anchor_a)
              : point_at(a, cord.column_a, s.anchor_a, position_row, rotation_row),
          cord.column_b == kNobody
              ? point_on(world, cord.slot_b, s.anchor_b)
              : point_at(a, cord.column_b, s.anchor_b, position_row, rotation_row)};
}

/// t (1 - n n^T): how a pull t turns away sideways motion.
Mat3 sideways(Real t, Vec3 n) { return t * (Mat3(1) - glm::outerProduct(n, n)); }

/// a x v as a matrix.
Mat3 crossing(Vec3 a) { return Mat3(0, a.z, -a.y, -a.z, 0, a.x, a.y, -a.x, 0); }

/// A pull of `load` along `to` (unit) at a point of a body, over a string of length `span`: the
/// pull keeps its direction in space while the body moves under it and turns.
void add_pull(const Island& a, JointBlock& block, std::size_t column, Vec3 anchor, Vec3 to,
              Real load, Real span, Work rotation_row) {
  const Mat3 k = sideways(load / span, to);
  const Mat3 c = crossing(lever(a, column, anchor, rotation_row));
  const Mat3 ck = c * k;
  block.yy += k, block.ty += ck, block.tt += ck * glm::transpose(c);
  const Vec3 arm = a.room.work.quat(rotation_row, column) * anchor;
  const Real reach2 = glm::dot(arm, arm), t = load * glm::dot(to, arm);
  if (t > 0 && reach2 > 0) block.tt += sideways(t, arm / std::sqrt(reach2));
}

/// A held point that rows can meet: soft, or exact with some slack left in the links between.
bool takes_rows(const Island& a, const Hold& h) {
  if (h.compliance > 0 || h.partner != kNobody) return true;
  const Tree& t = a.trees[h.tree];
  if (a.parents[t.first] != kHeld) return true;
  const Real span = glm::length(h.target - t.target);
  return span < (1 - 1e-9) * h.reach && span > (1 + 1e-9) * h.dead_reach;
}

constexpr Real kSpringDamping = 0.1;  // s: a spring grip brakes like 0.1 s of its stiffness

void list_hold(Island& a, const Hold& h, Real step, Work position_row, Work rotation_row,
               bool again) {
  Vec3 gap = target_of(a, h, position_row, rotation_row) -
             point_at(a, h.column, h.anchor, position_row, rotation_row);
  Row row;
  row.column_a = h.partner, row.column_b = h.column;
  row.arm_b = lever(a, h.column, h.anchor, rotation_row);
  if (h.partner != kNobody) row.arm_a = lever(a, h.partner, h.held_anchor, rotation_row);
  if (h.compliance > 0) {
    // k g + c (g - g_before) / h, as one spring of stiffness k + c/h.
    const Real stiffer = 1 + kSpringDamping / step;
    row.softness = h.compliance / stiffer / (a.force_share * step * step);
    gap -= (1 - 1 / stiffer) * h.gap_before;
  }
  for (int axis = 0; axis < 3; ++axis) {
    row.direction = Vec3(0);
    row.direction[axis] = 1;
    row.bound = gap[axis], row.load = again ? 0 : h.load[axis];
    a.room.rows.push_back(row);
  }
}

void list_cord(const World& world, Island& a, std::uint32_t index, Real step,
               Work position_row, Work rotation_row, bool again) {
  const Cord& cord = a.cords[index];
  const StringJoint& s = world.strings.values()[cord.string].joint;
  const Ends e = ends_of(world, a, cord, position_row, rotation_row);
  const Real span = glm::length(e.b - e.a);
  Row row;
  row.one_sided = true, row.cord = index;
  row.column_a = cord.column_a, row.column_b = cord.column_b;
  if (cord.column_a != kNobody) row.arm_a = lever(a, cord.column_a, s.anchor_a, rotation_row);
  if (cord.column_b != kNobody) row.arm_b = lever(a, cord.column_b, s.anchor_b, rotation_row);
  row.direction = span > 0 ? (e.a - e.b) / span : Vec3(0);
  row.bound = span - s.length;
  if (again) {
    // Elastic strings were settled by the first solve.
    if (s.compliance > 0) row.bound = -1e300;
  } else {
    row.softness = s.compliance / (a.force_share * step * step);
    row.load = cord.load;
  }
  a.room.rows.push_back(row);
}

void clear(StepScratch& r) {
  std::fill(r.forces_in.begin(), r.forces_in.end(), Loads{});
  std::fill(r.torques_in.begin(), r.torques_in.end(), Loads{});
}

/// Adds the load of a row to one side of the forces and torques at the joint points.
void push(StepScratch& r, const Row& row, Real load, std::size_t side) {
  const Vec3 f = load * row.direction;
  if (row.column_b != kNobody) {
    r.forces_in[row.column_b].add_to_side(side, f);
    r.torques_in[row.column_b].add_to_side(side, glm::cross(row.arm_b, f));
  }
  if (row.column_a != kNobody) {
    r.forces_in[row.column_a].add_to_side(side, -f);
    r.torques_in[row.column_a].add_to_side(side, -glm::cross(row.arm_a, f));
  }
}

/// direction . (u_b - u_a) of a row, for displacements `at(column, arm)`.
template <class At>
Real move_along(const Row& row, const At& at) {
  Vec3 moved(0);
  if (row.column_b != kNobody) moved += at(row.column_b, row.arm_b);
  if (row.column_a != kNobody) moved -= at(row.column_a, row.arm_a);
  return glm::dot(row.direction, moved);
}

/// What every row feels of a unit load on every other, four loads at a time.
void find_response(const Island& a, StepScratch& r) {
  const std::size_t n = r.rows.size();
  for (std::size_t first = 0; first < n; first += Loads::kSides) {
    const std::size_t sides = std::min(Loads::kSides, n - first);
    clear(r);
    for (std::size_t s = 0; s < sides; ++s) push(r, r.rows[first + s], 1, s);
    carry_up(a, r.forces_in, r.torques_in);
    carry_down(a, r.forces_in, r.torques_in);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t s = 0; s < sides; ++s)
        r.response[i * n + first + s] = move_along(r.rows[i], [&](std::uint32_t c, Vec3 arm) {
          return r.forces_in[c].side(s) + glm::cross(r.torques_in[c].side(s), arm);
        });
  }
  for (std::size_t j = 0; j < n; ++j) r.response[j * n + j] += r.rows[j].softness + 1e-300;
}

/// Leaves out strings that hang well below what this step can draw tight; one that does come tight
/// is found by the closing rounds.
void drop_slack(StepScratch& r, Real size) {
  Real most = 0;
  for (const Row& row : r.rows) most = std::max(most, row.wanted);
  const Real margin = 4 * most + 1e-3 * size;
  std::erase_if(r.rows, [&](const Row& row) {
    return row.one_sided && row.load == 0 && row.wanted < -margin;
  });
}

/// A row that nothing can move along (a planar linkage, out of its plane) bears nothing.
void drop_rigid(StepScratch& r) {
  const std::size_t n = r.rows.size();
  Real most = 0;
  for (std::size_t i = 0; i < n; ++i) most = std::max(most, r.response[i * n + i]);
  for (std::size_t i = 0; i < n; ++i) r.rows[i].rigid = !(r.response[i * n + i] > 1e-12 * most);
}

/// Projected Gauss-Seidel from the last step's loads: rows that can only pull stay non-negative.
void iterate(StepScratch& r, int rounds) {
  const std::size_t n = r.rows.size();
  for (int round = 0; round < rounds; ++round) {
    Real largest = 0, change = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Row& row = r.rows[i];
      if (row.rigid) {
        row.load = 0;
        continue;
      }
      const Real* w = &r.response[i * n];
      Real lack = row.wanted;
      for (std::size_t j = 0; j < n; ++j) lack -= w[j] * r.rows[j].load;
      Real load = row.load + lack / w[i];
      if (row.one_sided) load = std::max(Real(0), load);
      change = std::max(change, std::abs(load - row.load));
      largest = std::max(largest, std::abs(load));
      row.load = load;
    }
    if (!(change > 1e-13 * largest)) break;
  }
}

/// Solves the rows marked active exactly, by LDL^T. A row that follows from those before it is
/// marked inactive and rigid; false if a string does.
bool solve_active(StepScratch& r, std::vector<std::uint8_t>& active) {
  const std::size_t n = r.rows.size();
  std::vector<Real>&l = r.factor, &x = r.solved;
  for (std::size_t i = 0; i < n; ++i) {
    if (!active[i]) continue;
    for (std::size_t j = 0; j <= i; ++j) {
      if (!active[j]) continue;
      Real s = r.response[i * n + j];
      for (std::size_t k = 0; k < j; ++k)
        if (active[k]) s -= l[i * n + k] * l[k * n + k] * l[j * n + k];
      if (i == j && !(s > 1e-10 * r.response[i * n + i])) {
        if (r.rows[i].one_sided) return false;
        r.rows[i].rigid = true, active[i] = 0;
        break;
      }
      l[i * n + j] = i == j ? s : s / l[j * n + j];
    }
    if (!active[i]) continue;
    x[i] = r.rows[i].wanted;
    for (std::size_t k = 0; k < i; ++k)
      if (active[k]) x[i] -= l[i * n + k] * x[k];
  }
  for (std::size_t i = n; i-- > 0;) {
    if (!active[i]) continue;
    x[i] /= l[i * n + i];
    for (std::size_t k = i + 1; k < n; ++k)
      if (active[k]) x[i] -= l[k * n + i] * x[k];
  }
  return true;
}

/// Exact loads: the iteration guesses which strings are taut, a direct solve confirms or corrects.
/// Where it does not settle (contradictory or nearly dependent rows) the iteration's answer stands.
void solve_loads(StepScratch& r) {
  const std::size_t n = r.rows.size();
  drop_rigid(r);
  iterate(r, 12);
  std::vector<std::uint8_t>& active = r.on_path;
  if (active.size() < n) active.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    active[i] = !r.rows[i].rigid && (!r.rows[i].one_sided || r.rows[i].load > 0);
  for (int trial = 0; trial < 8; ++trial) {
    if (!solve_active(r, active)) break;
    bool settled = true;
    for (std::size_t i = 0; i < n; ++i)
      if (active[i] && r.rows[i].one_sided && r.solved[i] < 0) active[i] = 0, settled = false;
    for (std::size_t i = 0; settled && i < n; ++i) {
      if (active[i] || r.rows[i].rigid) continue;
      Real lack = r.rows[i].wanted, terms = std::abs(lack);
      for (std::size_t j = 0; j < n; ++j) {
        if (!active[j]) continue;
        const Real term = r.response[i * n + j] * r.solved[j];
        lack -= term, terms += std::abs(term);
      }
      if (lack > 1e-13 * terms) active[i] = 1, settled = false;  // beyond rounding
    }
    if (!settled) continue;
    for (std::size_t i = 0; i < n; ++i) r.rows[i].load = active[i] ? r.solved[i] : 0;
    return;
  }
  iterate(r, 200);
}

}  // namespace

void answer_freely(Island& a, Work position_row) {
  const Table& w = a.room.work;
  auto tree = a.trees.begin();
  for (std::size_t c = 0; c < a.count(); ++c) {
    const JointNode& n = a.room.joint_nodes[c];
    Vec3 y, follow(0);
    if (a.parents[c] >= 0) {
      const auto parent = static_cast<std::size_t>(a.parents[c]);
      y = a.room.slide[parent] + glm::cross(a.room.turn[parent], a.room.levers[c]) + a.room.gaps[c];
      if (!n.loose) follow = n.follow * a.room.turn[parent];
    } else {
      const Tree& t = *tree++;
      y = a.parents[c] == kFree ? solve_symmetric(n.group, n.load)
                                : t.target - (w.vec(position_row, c) + w.vec(kArm, c));
    }
    a.room.slide[c] = y;
    a.room.turn[c] = n.turn + follow - n.swing * y;
  }
}

void add_loads(Island& a) {
  StepScratch& r = a.room;
  carry_up(a, r.forces_in, r.torques_in);
  for (std::size_t c = 0; c < a.count(); ++c) {
    r.joint_nodes[c].load += r.forces_in[c].side(0);
    r.joint_nodes[c].turn += r.torques_in[c].side(0);
  }
}

void add_string_stiffness(const World& world, Island& a, std::vector<JointBlock>& blocks,
                          Work position_row, Work rotation_row) {
  for (const Cord& cord : a.cords) {
    if (!(cord.load > 0)) continue;
    const StringJoint& s = world.strings.values()[cord.string].joint;
    const Ends e = ends_of(world, a, cord, position_row, rotation_row);
    const Real span = glm::length(e.b - e.a);
    if (!(span > 0)) continue;
    const Vec3 to_b = (e.b - e.a) / span;
    if (cord.column_a != kNobody)
      add_pull(a, blocks[cord.column_a], cord.column_a, s.anchor_a, to_b, cord.load, span,
               rotation_row);
    if (cord.column_b != kNobody)
      add_pull(a, blocks[cord.column_b], cord.column_b, s.anchor_b, -to_b, cord.load, span,
               rotation_row);
  }
}

Real worst_stretch(const World& world, const Island& a) {
  Real worst = 0;
  for (const Cord& cord : a.cords) {
    const StringJoint& s = world.strings.values()[cord.string].joint;
    if (s.compliance > 0) continue;
    const Ends e = ends_of(world, a, cord, kFinalPosition, kFinalRotation);
    worst = std::max(worst, glm::length(e.b - e.a) - s.length);
  }
  return worst;
}

namespace {

constexpr Real kSight = 0.3;  // rad: turns up to which the first-order answer can be trusted

/// Shortens the way to the held points so that no body turns farther than the rows can see.
void keep_in_sight(Island& a) {
  StepScratch& r = a.room;
  clear(r);
  for (const Row& row : r.rows) push(r, row, row.load, 0);
  carry_up(a, r.forces_in, r.torques_in);
  carry_down(a, r.forces_in, r.torques_in);
  Real most = 0;
  for (const Loads& turn : r.torques_in) most = std::max(most, glm::length(turn.side(0)));
  r.part = most > kSight ? kSight / most : 1;
  for (Row& row : r.rows) row.load *= r.part;
}

}  // namespace

Vec3 target_of(const Island& a, const Hold& hold, Work position_row, Work rotation_row) {
  return hold.partner == kNobody
             ? hold.target
             : point_at(a, hold.partner, hold.held_anchor, position_row, rotation_row);
}

Real worst_hold(const Island& a) {
  Real worst = 0;
  for (const Hold& h : a.holds)
    if (h.compliance == 0)
      worst = std::max(
          worst, glm::length(target_of(a, h, kFinalPosition, kFinalRotation) -
                             point_at(a, h.column, h.anchor, kFinalPosition, kFinalRotation)));
  return worst;
}

void solve_rows(World& world, Island& a, Real h, Work position_row, Work rotation_row,
                bool again) {
  StepScratch& r = a.room;
  r.rows.clear();
  const auto taken = [&](const Hold& hold) {
    return takes_rows(a, hold) && !(again && hold.compliance > 0);
  };
  for (const Hold& hold : a.holds)
    if (taken(hold)) list_hold(a, hold, h, position_row, rotation_row, again);
  for (std::uint32_t c = 0; c < a.cords.size(); ++c)
    list_cord(world, a, c, h, position_row, rotation_row, again);
  if (r.rows.empty()) return;

  answer_freely(a, position_row);
  for (Row& row : r.rows)
    row.wanted = row.bound - move_along(row, [&](std::uint32_t c, Vec3 arm) {
                   return r.slide[c] + glm::cross(r.turn[c], arm);
                 });
  drop_slack(r, a.size);
  find_response(a, r);
  solve_loads(r);

  if (again) keep_in_sight(a);
  // All loads at once, added to what was gathered.
  clear(r);
  for (const Row& row : r.rows) push(r, row, row.load, 0);
  add_loads(a);

  const std::size_t n = r.rows.size();
  std::size_t at = 0;
  for (Hold& hold : a.holds) {
    const bool is_taken = taken(hold);
    for (int axis = 0; axis < 3; ++axis) {
      const Real load = is_taken ? r.rows[at++].load : 0;
      hold.load[axis] = again ? hold.load[axis] + load : load;
    }
  }
  for (std::uint32_t c = 0; c < a.cords.size(); ++c) {
    Cord& cord = a.cords[c];
    const Real load = at < n && r.rows[at].cord == c ? r.rows[at++].load : 0;
    // A string that has just drawn tight is a blow, and one let go a release: no calm step.
    if (!again && (load > 0) != (cord.load > 0)) a.disturbed = true;
    cord.load = again ? cord.load + load : load;
  }
}

}  // namespace pantin::articulated

// Cables and pins as rows of the articulated solve. The response of the island to a force at a
// point costs one inward and one outward pass; the lambdas follow from a small dense system with
// unilateral cable rows.
#include <algorithm>

#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNobody = UINT32_MAX;

/// From the joint point of a body to one of its anchors, world axes.
Vec3 lever(const Island& a, std::size_t column, Vec3 anchor, Work rotation_row) {
  return a.scratch.work.quat(rotation_row, column) * anchor - a.scratch.work.vec(kArm, column);
}

struct Ends {
  Vec3 a, b;
};

Ends ends_of(const World& world, const Island& a, const PackedCable& cord, PoseRows at) {
  const CableParameters& s = world.cables.values()[cord.cable].joint;
  return {cord.column_a == kNobody ? point_on(world, cord.slot_a, s.anchor_a)
                                   : point_at(a, cord.column_a, s.anchor_a, at),
          cord.column_b == kNobody ? point_on(world, cord.slot_b, s.anchor_b)
                                   : point_at(a, cord.column_b, s.anchor_b, at)};
}

/// t (1 - n n^T): geometric stiffness of a tension t along n.
Mat3 sideways(Real t, Vec3 n) { return t * (Mat3(1) - glm::outerProduct(n, n)); }

/// A cable of length `span` that pulls at a point of a body along `to` (unit).
struct Pull {
  std::uint32_t column;
  Vec3 anchor, to;
  Real lambda, span;
};

/// Geometric stiffness of a taut cable, at the predicted poses.
void add_pull(const Island& a, const Pull& pull, std::vector<JointBlock>& blocks) {
  PANTIN_ASSERT(pull.column < blocks.size() && is_positive(pull.span));
  JointBlock& block = blocks[pull.column];
  const Mat3 k = sideways(pull.lambda / pull.span, pull.to);
  const Mat3 c = cross_matrix(lever(a, pull.column, pull.anchor, kRotation));
  const Mat3 ck = c * k;
  block.yy += k, block.ty += ck, block.tt += ck * glm::transpose(c);
  const Vec3 arm = a.scratch.work.quat(kRotation, pull.column) * pull.anchor;
  const Real reach2 = glm::dot(arm, arm), t = pull.lambda * glm::dot(pull.to, arm);
  if (t > 0 && reach2 > 0) block.tt += sideways(t, arm / std::sqrt(reach2));
}

/// A pin that rows can satisfy: compliant, or rigid with the links between not fully extended.
bool takes_rows(const Island& a, const PackedPin& h) {
  if (h.compliance > 0 || h.partner != kNobody) return true;
  PANTIN_ASSERT(h.tree < a.trees.size());
  const Tree& t = a.trees[h.tree];
  if (a.parents[t.first] != kHeld) return true;
  const Real span = glm::length(h.target - t.target);
  return span < (1 - 1e-9) * h.reach && span > (1 + 1e-9) * h.dead_reach;
}

void list_pin_rows(Island& a, const PackedPin& h, Real step, const Pass& pass) {
  const Work rotation_row = pass.from.rotation;
  Vec3 gap = target_of(a, h, pass.from) - point_at(a, h.column, h.anchor, pass.from);
  Row row;
  row.column_a = h.partner, row.column_b = h.column;
  row.arm_b = lever(a, h.column, h.anchor, rotation_row);
  if (h.partner != kNobody) row.arm_a = lever(a, h.partner, h.held_anchor, rotation_row);
  if (h.compliance > 0) {
    // k g + c (g - g_before) / h, as one spring of stiffness k + c/h.
    const Real stiffer = 1 + h.damping * h.compliance / step;
    row.softness = h.compliance / stiffer / (a.force_share * step * step);
    gap -= (1 - 1 / stiffer) * h.gap_before;
  }
  for (int axis = 0; axis < 3; ++axis) {
    row.direction = Vec3(0);
    row.direction[axis] = 1;
    row.bound = gap[axis], row.lambda = pass.corrects ? 0 : h.lambda[axis];
    a.scratch.rows.push_back(row);
  }
}

Row cable_row(const World& world, const Island& a, const PackedCable& cord, const Pass& pass) {
  const Work rotation_row = pass.from.rotation;
  const CableParameters& s = world.cables.values()[cord.cable].joint;
  const Ends e = ends_of(world, a, cord, pass.from);
  const Real span = glm::length(e.b - e.a);
  Row row;
  row.one_sided = true;
  row.cable = static_cast<std::uint32_t>(&cord - a.cables.data());
  PANTIN_ASSERT(row.cable < a.cables.size());
  row.column_a = cord.column_a, row.column_b = cord.column_b;
  if (cord.column_a != kNobody) row.arm_a = lever(a, cord.column_a, s.anchor_a, rotation_row);
  if (cord.column_b != kNobody) row.arm_b = lever(a, cord.column_b, s.anchor_b, rotation_row);
  row.direction = span > 0 ? (e.a - e.b) / span : Vec3(0);
  row.bound = span - s.length;
  if (pass.corrects) {
    // Elastic cables were solved in the first pass.
    if (s.compliance > 0) row.bound = -1e300;
  } else {
    row.softness = s.compliance;  // in m/N until the step is known
    row.lambda = cord.lambda;
  }
  return row;
}

void clear(StepScratch& r) {
  std::fill(r.forces_in.begin(), r.forces_in.end(), Vec3x4{});
  std::fill(r.torques_in.begin(), r.torques_in.end(), Vec3x4{});
}

/// Adds the force of a row to one lane of the forces and torques at the joint points.
void push(StepScratch& r, const Row& row, Real lambda, std::size_t side) {
  PANTIN_ASSERT(is_index_or_none(row.column_a, r.forces_in.size()) &&
                is_index_or_none(row.column_b, r.forces_in.size()));
  const Vec3 f = lambda * row.direction;
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

/// Response of every row to a unit force along every other (Delassus matrix), four columns at a
/// time.
void find_response(const Island& a, StepScratch& r) {
  const std::size_t n = r.rows.size();
  PANTIN_ASSERT(r.response.size() >= n * n && r.forces_in.size() == a.count());
  for (std::size_t first = 0; first < n; first += Vec3x4::kSides) {
    const std::size_t sides = std::min(Vec3x4::kSides, n - first);
    clear(r);
    for (std::size_t s = 0; s < sides; ++s) push(r, r.rows[first + s], 1, s);
    propagate_inward(a, r.forces_in, r.torques_in);
    propagate_outward(a, r.forces_in, r.torques_in);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t s = 0; s < sides; ++s)
        r.response[i * n + first + s] = move_along(r.rows[i], [&](std::uint32_t c, Vec3 arm) {
          return r.forces_in[c].side(s) + glm::cross(r.torques_in[c].side(s), arm);
        });
  }
  for (std::size_t j = 0; j < n; ++j) r.response[j * n + j] += r.rows[j].softness + 1e-300;
}

/// Leaves out cables too slack to become taut in this step; the closing iterations find exceptions.
void drop_slack(StepScratch& r, Real size) {
  Real most = 0;
  for (const Row& row : r.rows) most = std::max(most, row.bias);
  const Real margin = 4 * most + 1e-3 * size;
  std::erase_if(r.rows, [&](const Row& row) {
    return row.one_sided && row.lambda == 0 && row.bias < -margin;
  });
}

/// A row without response (a planar linkage, out of its plane) has no force.
void drop_rigid(StepScratch& r) {
  const std::size_t n = r.rows.size();
  Real most = 0;
  for (std::size_t i = 0; i < n; ++i) most = std::max(most, r.response[i * n + i]);
  for (std::size_t i = 0; i < n; ++i) r.rows[i].rigid = !(r.response[i * n + i] > 1e-12 * most);
}

/// Projected Gauss-Seidel, warm-started: unilateral rows stay non-negative.
void iterate(StepScratch& r, int rounds) {
  const std::size_t n = r.rows.size();
  for (int round = 0; round < rounds; ++round) {
    Real largest = 0, change = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Row& row = r.rows[i];
      if (row.rigid) {
        row.lambda = 0;
        continue;
      }
      const Real* w = &r.response[i * n];
      Real residual = row.bias;
      for (std::size_t j = 0; j < n; ++j) residual -= w[j] * r.rows[j].lambda;
      Real lambda = row.lambda + residual / w[i];
      if (row.one_sided) lambda = std::max(Real(0), lambda);
      change = std::max(change, std::abs(lambda - row.lambda));
      largest = std::max(largest, std::abs(lambda));
      row.lambda = lambda;
    }
    if (!(change > 1e-13 * largest)) break;
  }
}

/// Solves the active rows by LDL^T. A dependent row is marked inactive and rigid; false if it is a
/// cable.
bool solve_active(StepScratch& r, std::vector<std::uint8_t>& active) {
  const std::size_t n = r.rows.size();
  std::vector<Real>&l = r.factor, &x = r.solved;
  PANTIN_ASSERT(l.size() >= n * n && x.size() >= n && active.size() >= n);
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
    x[i] = r.rows[i].bias;
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

/// Exact solution: the iteration estimates the active set, direct solves correct it. Without
/// convergence (inconsistent or nearly dependent rows) the result of the iteration is used.
void solve_row_lambdas(StepScratch& r) {
  const std::size_t n = r.rows.size();
  drop_rigid(r);
  iterate(r, 12);
  std::vector<std::uint8_t>& active = r.on_path;
  if (active.size() < n) active.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    active[i] = !r.rows[i].rigid && (!r.rows[i].one_sided || r.rows[i].lambda > 0);
  for (int trial = 0; trial < 8; ++trial) {
    if (!solve_active(r, active)) break;
    bool converged = true;
    for (std::size_t i = 0; i < n; ++i)
      if (active[i] && r.rows[i].one_sided && r.solved[i] < 0) active[i] = 0, converged = false;
    for (std::size_t i = 0; converged && i < n; ++i) {
      if (active[i] || r.rows[i].rigid) continue;
      Real residual = r.rows[i].bias, terms = std::abs(residual);
      for (std::size_t j = 0; j < n; ++j) {
        if (!active[j]) continue;
        const Real term = r.response[i * n + j] * r.solved[j];
        residual -= term, terms += std::abs(term);
      }
      if (residual > 1e-13 * terms) active[i] = 1, converged = false;  // beyond rounding
    }
    if (!converged) continue;
    for (std::size_t i = 0; i < n; ++i) r.rows[i].lambda = active[i] ? r.solved[i] : 0;
    return;
  }
  iterate(r, 200);
}

}  // namespace

void free_response(Island& a, Work position_row) {
  const LaneTable& w = a.scratch.work;
  PANTIN_ASSERT(a.scratch.joint_nodes.size() == a.count() && a.scratch.gaps.size() == a.count());
  auto tree = a.trees.begin();
  for (std::size_t c = 0; c < a.count(); ++c) {
    const JointNode& n = a.scratch.joint_nodes[c];
    Vec3 y, propagated(0);
    if (a.parents[c] >= 0) {
      const auto parent = static_cast<std::size_t>(a.parents[c]);
      y = a.scratch.translation[parent] +
          glm::cross(a.scratch.rotation[parent], a.scratch.levers[c]) + a.scratch.gaps[c];
      if (!n.free_ball) propagated = n.propagation * a.scratch.rotation[parent];
    } else {
      PANTIN_ASSERT(tree != a.trees.end());
      const Tree& t = *tree++;
      y = a.parents[c] == kFree ? solve_symmetric(n.articulated_mass, n.lambda)
                                : t.target - (w.vec(position_row, c) + w.vec(kArm, c));
    }
    a.scratch.translation[c] = y;
    a.scratch.rotation[c] = n.bias_rotation + propagated - n.rotation_per_translation * y;
  }
}

void add_bias_lambdas(Island& a) {
  StepScratch& r = a.scratch;
  propagate_inward(a, r.forces_in, r.torques_in);
  for (std::size_t c = 0; c < a.count(); ++c) {
    r.joint_nodes[c].lambda += r.forces_in[c].side(0);
    r.joint_nodes[c].bias_rotation += r.torques_in[c].side(0);
  }
}

void add_cable_stiffness(const World& world, Island& a, std::vector<JointBlock>& blocks) {
  for (const PackedCable& cord : a.cables) {
    if (!(cord.lambda > 0)) continue;
    const CableParameters& s = world.cables.values()[cord.cable].joint;
    const Ends e = ends_of(world, a, cord, kPredictedPoses);
    const Real span = glm::length(e.b - e.a);
    if (!(span > 0)) continue;
    const Vec3 to_b = (e.b - e.a) / span;
    if (cord.column_a != kNobody)
      add_pull(a, {cord.column_a, s.anchor_a, to_b, cord.lambda, span}, blocks);
    if (cord.column_b != kNobody)
      add_pull(a, {cord.column_b, s.anchor_b, -to_b, cord.lambda, span}, blocks);
  }
}

Real worst_stretch(const World& world, const Island& a) {
  Real worst = 0;
  for (const PackedCable& cord : a.cables) {
    const CableParameters& s = world.cables.values()[cord.cable].joint;
    if (s.compliance > 0) continue;
    const Ends e = ends_of(world, a, cord, kFinalPoses);
    worst = std::max(worst, glm::length(e.b - e.a) - s.length);
  }
  return worst;
}

namespace {

constexpr Real kMaxRotation = 0.3;  // rad: largest rotation for which the linearisation is trusted

/// Scales the step towards the pins so that no body rotates beyond the trust region.
void limit_rotation(Island& a) {
  StepScratch& r = a.scratch;
  clear(r);
  for (const Row& row : r.rows) push(r, row, row.lambda, 0);
  propagate_inward(a, r.forces_in, r.torques_in);
  propagate_outward(a, r.forces_in, r.torques_in);
  Real most = 0;
  for (const Vec3x4& rotation : r.torques_in) most = std::max(most, glm::length(rotation.side(0)));
  r.step_fraction = most > kMaxRotation ? kMaxRotation / most : 1;
  for (Row& row : r.rows) row.lambda *= r.step_fraction;
}

}  // namespace

Vec3 target_of(const Island& a, const PackedPin& constraint, PoseRows at) {
  return constraint.partner == kNobody
             ? constraint.target
             : point_at(a, constraint.partner, constraint.held_anchor, at);
}

Real worst_pin_gap(const Island& a) {
  Real worst = 0;
  for (const PackedPin& h : a.pins)
    if (h.compliance == 0)
      worst = std::max(worst, glm::length(target_of(a, h, kFinalPoses) -
                                          point_at(a, h.column, h.anchor, kFinalPoses)));
  return worst;
}

void solve_rows(World& world, Island& a, Real h, const Pass& pass) {
  StepScratch& r = a.scratch;
  r.rows.clear();
  const auto taken = [&](const PackedPin& constraint) {
    return takes_rows(a, constraint) && !(pass.corrects && constraint.compliance > 0);
  };
  for (const PackedPin& constraint : a.pins)
    if (taken(constraint)) list_pin_rows(a, constraint, h, pass);
  for (const PackedCable& cord : a.cables) {
    r.rows.push_back(cable_row(world, a, cord, pass));
    r.rows.back().softness /= a.force_share * h * h;
  }
  if (r.rows.empty()) return;

  free_response(a, pass.from.position);
  for (Row& row : r.rows)
    row.bias = row.bound - move_along(row, [&](std::uint32_t c, Vec3 arm) {
                 return r.translation[c] + glm::cross(r.rotation[c], arm);
               });
  drop_slack(r, a.size);
  find_response(a, r);
  solve_row_lambdas(r);

  if (pass.corrects) limit_rotation(a);
  // Adds all forces to the result of the inward pass.
  clear(r);
  for (const Row& row : r.rows) push(r, row, row.lambda, 0);
  add_bias_lambdas(a);

  const std::size_t n = r.rows.size();
  std::size_t at = 0;
  for (PackedPin& constraint : a.pins) {
    const bool is_taken = taken(constraint);
    for (int axis = 0; axis < 3; ++axis) {
      const Real lambda = is_taken ? r.rows[at++].lambda : 0;
      constraint.lambda[axis] = pass.corrects ? constraint.lambda[axis] + lambda : lambda;
    }
  }
  PANTIN_ASSERT(at <= n);
  for (std::uint32_t c = 0; c < a.cables.size(); ++c) {
    PackedCable& cord = a.cables[c];
    const Real lambda = at < n && r.rows[at].cable == c ? r.rows[at++].lambda : 0;
    // A cable that becomes taut or slack is an event: the order of integration drops. The force
    // of an elastic one has no jump.
    const bool rigid = !(world.cables.values()[cord.cable].joint.compliance > 0);
    if (rigid && !pass.corrects && (lambda > 0) != (cord.lambda > 0)) a.disturbed = true;
    cord.lambda = pass.corrects ? cord.lambda + lambda : lambda;
  }
}

}  // namespace pantin::detail::articulated

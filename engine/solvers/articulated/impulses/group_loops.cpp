// Loops in contact: a direct solver closes all of them together.
//
// The rigid ties of an island (joints that close loops, exact pins besides those of the roots) need
// impulses p on their points with
//   (A + yield) p = -(u + closing velocity of their gaps),   A = sum over joints of T^T m T,
// u being the points' relative velocities without p, m the mobility of a joint and T its torque
// per unit impulse at a tie, on the tie's path to the root. The Cholesky factor A = L L^T is made
// once a substep. Each row begins at the first tie coupled to it (envelope storage).
//
// Impulses of contacts, springs and cables act through the loop-closed response. Each body on which
// they act has further rows Z = W L^-T, where W is the ties' response to an impulse on it. Its
// loop-closed response is W_0 - Z^T Z (a Schur complement), W_0 being that without loops. While
// such impulses f are iterated, z += Z f, and the loops change the body's motion by -Z^T z. At the
// end p = -L^-T z acts on the trees. So a light net stops a heavy ball in one iteration, not in a
// thousand.
//
// Blocks are 3 x 3; they are stored by columns, each padded to four numbers.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/impulses/group_ties.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Regularisation, as a fraction of the response of a rigid tie, and at least of the whole island:
/// singular loops stay solvable, and points of a rigid part have no response but rounding.
constexpr Real kYield = 1e-7;
/// Geometric stiffness is added only where, over a substep, it exceeds this fraction of the body's
/// inertia.
constexpr Real kTaut = 1;
/// Mass assigned to a fixed body in press(), as a multiple of the mass of the body it presses on.
constexpr Real kFixedMass = 1e3;
/// m/s: the fastest closing velocity of a gap.
constexpr Real kFastestReturn = 4;

constexpr std::size_t kWide = kBlockWide;

std::span<GroupTie> ties_of(const Group& g, const GroupLoops& l) {
  return g.ties.subspan(l.first_tie, l.ties);
}
/// A block of the factor: those of a row follow one another.
Real* block_of(const Group& g, const GroupTie& row, std::size_t column) {
  PANTIN_ASSERT(column >= row.first);
  return g.numbers.data() + row.row + (column - row.first) * kBlockNumbers;
}

/// Impulses and their moments, by those along the axes of the world.
struct Wrenches {
  Mat3 force{0}, torque{0};
};

/// The wrenches that the joint of a node passes on to its parent's joint.
Wrenches passed_on(const GroupNode& n, const Wrenches& f) {
  const Mat3 relative = n.mobility * f.torque;
  Wrenches p;
  p.force = f.force - n.whole.ft * relative;
  p.torque = cross_matrix(n.lever) * p.force;
  if (!n.is_ball) p.torque += f.torque - n.whole.tt * relative;
  return p;
}

/// Adds a joint to a path and moves on to the parent; true while there is a parent.
bool climb(const Group& g, std::uint32_t& node, Wrenches& f, PathStep*& to) {
  const GroupNode& n = g.nodes[node];
  PANTIN_ASSERT(to < g.path_steps.data() + g.path_steps.size());
  to->node = node;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      to->torque[3 * c + r] = f.torque[c][r], to->force[3 * c + r] = f.force[c][r];
  ++to;
  node = n.parent;
  if (node == kNoNode) return false;
  f = passed_on(n, f);
  return true;
}

std::uint32_t node_of(const Group& g, std::uint32_t body) { return g.bodies[body].node; }

/// The paths of a tie's two ends to the root, merged from their lowest common ancestor on.
void find_way(const Group& g, GroupTie& t) {
  PathStep* const begin = g.path_steps.data() + t.first_step;
  PathStep* to = begin;
  std::uint32_t a = node_of(g, t.a), b = node_of(g, t.b);
  Wrenches fa{Mat3(-1), -cross_matrix(t.arm_a)}, fb{Mat3(1), cross_matrix(t.arm_b)};
  const bool one_tree = a != kNoNode && b != kNoNode && g.nodes[a].tree == g.nodes[b].tree;
  while (one_tree && a != b) {
    const std::uint32_t da = g.nodes[a].depth, db = g.nodes[b].depth;
    if (da >= db) climb(g, a, fa, to);
    if (db >= da) climb(g, b, fb, to);
  }
  if (one_tree) {
    fb.force += fa.force, fb.torque += fa.torque;
  } else if (a != kNoNode) {
    while (climb(g, a, fa, to)) {
    }
  }
  if (b != kNoNode)
    while (climb(g, b, fb, to)) {
    }
  t.steps = static_cast<std::uint32_t>(to - begin);
}

std::span<PathStep> way_of(const Group& g, const GroupTie& t) {
  return g.path_steps.subspan(t.first_step, t.steps);
}

/// Lists the steps of all ties by joint.
void list_steps(const Group& g, const GroupLoops& l) {
  for (const GroupTree& t : g.trees.subspan(l.first_tree, l.trees))
    for (std::uint32_t i = t.first; i < t.first + t.count; ++i) g.nodes[i].step = kNoPathStep;
  for (std::uint32_t i = l.ties; i-- > 0;) {
    const GroupTie& t = ties_of(g, l)[i];
    for (std::uint32_t k = t.first_step; k < t.first_step + t.steps; ++k) {
      PathStep& step = g.path_steps[k];
      GroupNode& n = g.nodes[step.node];
      step.tie = i, step.next = n.step, n.step = k;
    }
  }
}

void set_block(Real* to, const Mat3& m) {  // m(row, column) = m[column][row]
  for (int c = 0; c < 3; ++c, to += kWide)
    for (int r = 0; r < 3; ++r) to[r] = m[c][r];
}
Mat3 transposed(const Real (&m)[9]) {
  return Mat3(m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]);
}

/// Adds the response of the ties up to `last`, one block each, to impulses with the given path: the
/// sum of T^T m T over the joints that the paths share.
void add_responses(const Group& g, std::span<const PathStep> path, std::uint32_t last, Real* row) {
  for (const PathStep& s : path) {
    const GroupNode& n = g.nodes[s.node];
    const Mat3 torque = transposed(s.torque);
    PathJoint joint{g.path_steps.data(), n.step, last, n.free_root, {}, {}};
    if (n.free_root) {
      const Mat3 force = transposed(s.force);
      const Response& r = n.response;
      set_block(joint.by_torque, force * r.vt + torque * r.wt);
      set_block(joint.by_force, force * r.vf + torque * glm::transpose(r.vt));
    } else {
      set_block(joint.by_torque, torque * n.mobility);
    }
    kernels().add_path_responses(joint, row);
  }
}

/// m - a b^T.
Mat3 less_products(const Mat3& m, const Real* a, const Real* b, std::size_t columns) {
  Real block[kBlockNumbers] = {};
  set_block(block, m);
  kernels().subtract_products(block, a, b, columns);
  return Mat3(block[0], block[1], block[2], block[kWide], block[kWide + 1], block[kWide + 2],
              block[2 * kWide], block[2 * kWide + 1], block[2 * kWide + 2]);
}

/// Solves x L^T = x for one block; L is a diagonal block with inverse pivots.
void divide(Real* x, const Real* l) {
  for (std::size_t r = 0; r < 3; ++r) {
    x[r] *= l[0];
    x[kWide + r] = (x[kWide + r] - x[r] * l[1]) * l[kWide + 1];
    x[2 * kWide + r] =
        (x[2 * kWide + r] - x[r] * l[2] - x[kWide + r] * l[kWide + 2]) * l[2 * kWide + 2];
  }
}

/// Factors a diagonal block, storing inverse pivots. A vanishing pivot gives no impulse.
void factor_block(Real* l, Real least) {
  const auto inverse = [&](Real pivot) { return pivot > least ? 1 / std::sqrt(pivot) : 0; };
  l[0] = inverse(l[0]);
  l[1] *= l[0], l[2] *= l[0];
  l[kWide + 1] = inverse(l[kWide + 1] - l[1] * l[1]);
  l[kWide + 2] = (l[kWide + 2] - l[1] * l[2]) * l[kWide + 1];
  l[2 * kWide + 2] = inverse(l[2 * kWide + 2] - l[2] * l[2] - l[kWide + 2] * l[kWide + 2]);
}

/// A range of blocks in a row.
struct Blocks {
  std::uint32_t first, end;
};
/// Solves x L^T = x in this range, for one block row.
void divide_row(const Group& g, const GroupLoops& l, Real* row, Blocks blocks) {
  const auto [first, end] = blocks;
  PANTIN_ASSERT(first <= end && end <= l.ties);
  const std::span<GroupTie> ties = ties_of(g, l);
  for (std::uint32_t j = first; j < end; ++j) {
    const std::size_t from = std::max(first, ties[j].first), width = kBlockNumbers;
    if (j > from)
      kernels().subtract_products(row + j * width, row + from * width, block_of(g, ties[j], from),
                                  3 * (j - from));
    divide(row + j * width, block_of(g, ties[j], j));
  }
}

void factor(const Group& g, const GroupLoops& l) {
  const std::span<GroupTie> ties = ties_of(g, l);
  list_steps(g, l);
  Real mass = 0;
  for (const GroupTree& t : g.trees.subspan(l.first_tree, l.trees)) mass += t.mass;
  const Real least = 1 / mass;
  Real* const row = g.numbers.data() + l.row;
  for (std::uint32_t i = 0; i < l.ties; ++i) {
    GroupTie& t = ties[i];
    Real *const begin = row + t.first * kBlockNumbers, *const own = row + i * kBlockNumbers;
    std::fill(begin, own + kBlockNumbers, Real(0));
    add_responses(g, way_of(g, t), i, row);
    t.yield = kYield * std::max((own[0] + own[kWide + 1] + own[2 * kWide + 2]) / 3, least);
    for (int k = 0; k < 3; ++k) own[k * kWide + k] += t.yield;
    divide_row(g, l, row, {t.first, i});
    kernels().subtract_products(own, begin, begin, 3 * (i - t.first));
    factor_block(own, 0.01 * t.yield);
    std::copy(begin, own + kBlockNumbers, block_of(g, t, t.first));
  }
}

Vec3 limited(Vec3 speed) {
  const Real size = glm::length(speed);
  return size > kFastestReturn ? kFastestReturn / size * speed : speed;
}

/// L z = z.
void solve_forwards(const Group& g, const GroupLoops& l) {
  Real* z = g.numbers.data() + l.left;
  for (std::uint32_t i = 0; i < l.ties; ++i) {
    const GroupTie& t = ties_of(g, l)[i];
    const Real* block = block_of(g, t, t.first);
    Real sum[kWide] = {};
    for (std::size_t k = 3 * t.first; k < 3 * i; ++k, block += kWide)
      for (std::size_t r = 0; r < kWide; ++r) sum[r] += block[r] * z[k];
    const Real* const d = block;
    Real* x = z + 3 * i;
    x[0] = (x[0] - sum[0]) * d[0];
    x[1] = (x[1] - sum[1] - d[1] * x[0]) * d[kWide + 1];
    x[2] = (x[2] - sum[2] - d[2] * x[0] - d[kWide + 2] * x[1]) * d[2 * kWide + 2];
  }
}

/// L^T z = z.
void solve_backwards(const Group& g, const GroupLoops& l) {
  Real* z = g.numbers.data() + l.left;
  for (std::uint32_t i = l.ties; i-- > 0;) {
    const GroupTie& t = ties_of(g, l)[i];
    const Real* const d = block_of(g, t, i);
    Real* x = z + 3 * i;
    x[2] *= d[2 * kWide + 2];
    x[1] = (x[1] - d[kWide + 2] * x[2]) * d[kWide + 1];
    x[0] = (x[0] - d[1] * x[1] - d[2] * x[2]) * d[0];
    const Real* block = block_of(g, t, t.first);
    for (std::size_t k = 3 * t.first; k < 3 * i; ++k, block += kWide)
      z[k] -= block[0] * x[0] + block[1] * x[1] + block[2] * x[2];
  }
}

Vec3 left_of(const Group& g, const GroupLoops& l, std::uint32_t tie) {
  PANTIN_ASSERT(tie < l.ties);
  const Real* z = g.numbers.data() + l.left + 3 * tie;
  return {z[0], z[1], z[2]};
}
void set_left(const Group& g, const GroupLoops& l, std::uint32_t tie, Vec3 v) {
  PANTIN_ASSERT(tie < l.ties);
  Real* z = g.numbers.data() + l.left + 3 * tie;
  z[0] = v.x, z[1] = v.y, z[2] = v.z;
}

/// Applies an impulse at a point of a body.
void push_at(const Group& g, std::uint32_t body, Vec3 arm, Vec3 impulse) {
  const std::uint32_t node = node_of(g, body);
  if (node == kNoNode) return;
  visit(g, node);
  apply(g, node, {impulse, glm::cross(arm, impulse)});
}

/// Geometric stiffness of a tension at a point of a body, times h^2: it resists rotation about axes
/// across the lever from the joint to the point. `pull`: h times the tension's impulse, along the
/// lever times its length.
void add_pull(GroupNode& n, Vec3 lever, Real pull) {
  if (!(pull > 0)) return;
  const Real size = glm::dot(lever, lever);
  n.tautness += pull * (Mat3(1) - glm::outerProduct(lever, lever) / size);
}

Vec3 lever_of(const GroupNode& n, const GroupBody& b, Vec3 anchor) {
  return b.pose.rotation * (n.free_root ? anchor : anchor - n.own_anchor);
}

}  // namespace

void stiffen(const Group& g, Real h) {
  for (GroupNode& n : g.nodes) n.tautness = Mat3(0);
  if (!(h > 0)) return;
  const auto pull = [&](std::uint32_t body, Vec3 anchor, Vec3 impulse) {
    const std::uint32_t node = node_of(g, body);
    if (node == kNoNode) return;
    const Vec3 lever = lever_of(g.nodes[node], g.bodies[body], anchor);
    add_pull(g.nodes[node], lever, h * glm::dot(impulse, lever));
  };
  for (const GroupLoops& l : g.loops)
    for (const GroupTie& t : ties_of(g, l))
      pull(t.a, t.anchor_a, -t.impulse), pull(t.b, t.anchor_b, t.impulse);
  for (const GroupNode& n : g.nodes) {
    if (n.parent == kNoNode) continue;
    GroupNode& to = g.nodes[n.parent];
    const Vec3 lever = lever_of(to, g.bodies[to.body], n.parent_anchor);
    // A tension that lasts, not that of an impact.
    const Real lasting = std::max(glm::dot(n.pulled, lever), glm::dot(n.pulled_earlier, lever));
    add_pull(to, lever, -h * lasting);
  }
  for (GroupNode& n : g.nodes) {
    const Vec3 arm = n.free_root ? Vec3(0) : n.own_anchor;
    const Real own =
        std::max({n.inertia.x, n.inertia.y, n.inertia.z}) + n.mass * glm::dot(arm, arm);
    const Real all = 0.5 * (n.tautness[0][0] + n.tautness[1][1] + n.tautness[2][2]);
    n.tautness *= all > kTaut * own ? 1 - kTaut * own / all : 0;
  }
}

void press(const Group& g) {
  const auto on = [&](std::uint32_t body, std::uint32_t by, Vec3 at, Vec3 normal) {
    const GroupBody &b = g.bodies[body], &other = g.bodies[by];
    if (b.looped == kNoNode) return;
    GroupNode& n = g.nodes[b.node];
    const Real mass = other.per_mass > 0 ? 1 / other.per_mass : kFixedMass / b.per_mass;
    const Vec3 across = glm::cross(lever_of(n, b, at), normal);
    n.pressed.ff += mass * glm::outerProduct(normal, normal);
    n.pressed.ft += mass * glm::outerProduct(normal, across);
    n.pressed.tt += mass * glm::outerProduct(across, across);
  };
  for (const GroupContact& c : g.contacts) {
    if (!(c.impulse.x > 0)) continue;
    on(c.a, c.b, c.on_a.core, c.axes[0]), on(c.b, c.a, c.on_b.core, c.axes[0]);
  }
}

void release(const Group& g) {
  for (const LoopedBody& b : g.looped) g.nodes[b.node].pressed = {};
}

void prepare_loops(const Group& g) {
  for (const GroupLoops& l : g.loops) {
    for (GroupTie& t : ties_of(g, l)) {
      place_tie(g, t);
      t.impulse = Vec3(0);
      find_way(g, t);
    }
    factor(g, l);
    for (std::uint32_t i = 0; i < l.ties; ++i) set_left(g, l, i, Vec3(0));
  }
  for (LoopedBody& b : g.looped) b.known = false;
}

void prepare_looped(const Group& g, std::uint32_t body) {
  const GroupBody& b = g.bodies[body];
  if (b.looped == kNoNode || g.looped[b.looped].known) return;
  LoopedBody& looped = g.looped[b.looped];
  const GroupLoops& l = g.loops[looped.loops];
  const std::size_t width = kBlockNumbers;
  PANTIN_ASSERT(b.node == looped.node);
  looped.first = std::min(l.ties, g.trees[g.nodes[b.node].tree].first_tie);
  Real* const by_force = g.numbers.data() + looped.rows;
  Real* const by_torque = by_force + l.ties * width;
  for (Real* row : {by_force, by_torque}) {
    const bool force = row == by_force;
    PathStep* to = g.path_steps.data() + l.first_step;
    Wrenches f{Mat3(force ? 1.0 : 0.0), Mat3(force ? 0.0 : 1.0)};
    std::uint32_t node = b.node;
    while (climb(g, node, f, to)) {
    }
    const auto count =
        static_cast<std::uint32_t>(to - g.path_steps.data() - std::ptrdiff_t(l.first_step));
    std::fill(row + looped.first * width, row + l.ties * width, Real(0));
    add_responses(g, g.path_steps.subspan(l.first_step, count), l.ties, row);
    divide_row(g, l, row, {looped.first, l.ties});
  }
  const Response& own = g.nodes[b.node].response;
  const std::size_t columns = 3 * (l.ties - looped.first), skipped = looped.first * width;
  const Real *const force = by_force + skipped, *const torque = by_torque + skipped;
  looped.response.vf = less_products(own.vf, force, force, columns);
  looped.response.vt = less_products(own.vt, force, torque, columns);
  looped.response.wt = less_products(own.wt, torque, torque, columns);
  looped.known = true;
}

void begin_loops(const Group& g, Real h, Real part) {
  for (const GroupLoops& l : g.loops) {
    for (GroupTree& t : g.trees.subspan(l.first_tree, l.trees)) settle_tree(g, t);
    for (std::uint32_t i = 0; i < l.ties; ++i) {
      const GroupTie& t = ties_of(g, l)[i];
      const Vec3 speed = speed_at(g.bodies[t.b], t.arm_b) - speed_at(g.bodies[t.a], t.arm_a);
      const Vec3 closing = part > 0 ? limited(part / h * t.apart) : Vec3(0);
      set_left(g, l, i, speed + closing + t.yield * t.impulse);
    }
    solve_forwards(g, l);
  }
}

void end_loops(const Group& g) {
  for (const GroupLoops& l : g.loops) {
    solve_backwards(g, l);
    for (std::uint32_t i = 0; i < l.ties; ++i) {
      GroupTie& t = ties_of(g, l)[i];
      const Vec3 more = -left_of(g, l, i);
      t.impulse += more;
      push_at(g, t.a, t.arm_a, -more), push_at(g, t.b, t.arm_b, more);
      set_left(g, l, i, Vec3(0));
    }
  }
}

Wrench change_by_loops(const Group& g, const LoopedBody& b) {
  PANTIN_ASSERT(b.known);
  const GroupLoops& l = g.loops[b.loops];
  const Real* z = g.numbers.data() + l.left;
  const Real* by_force = g.numbers.data() + b.rows;
  const Real* by_torque = by_force + l.ties * kBlockNumbers;
  Real f[kWide] = {}, t[kWide] = {};
  for (std::size_t k = 3 * b.first; k < 3 * l.ties; ++k)
    for (std::size_t r = 0; r < kWide; ++r) {
      f[r] -= by_force[k * kWide + r] * z[k];
      t[r] -= by_torque[k * kWide + r] * z[k];
    }
  return {Vec3(f[0], f[1], f[2]), Vec3(t[0], t[1], t[2])};
}

void push_looped(const Group& g, const LoopedBody& b, const Wrench& impulse) {
  PANTIN_ASSERT(b.known);
  const GroupLoops& l = g.loops[b.loops];
  Real* z = g.numbers.data() + l.left;
  const Real* by_force = g.numbers.data() + b.rows;
  const Real* by_torque = by_force + l.ties * kBlockNumbers;
  for (std::size_t k = 3 * b.first; k < 3 * l.ties; ++k) {
    const Real *f = by_force + k * kWide, *t = by_torque + k * kWide;
    z[k] += f[0] * impulse.force.x + f[1] * impulse.force.y + f[2] * impulse.force.z +
            t[0] * impulse.torque.x + t[1] * impulse.torque.y + t[2] * impulse.torque.z;
  }
}

LoopGaps gaps_of(const Group& g, const GroupLoops& l) {
  LoopGaps gaps;
  for (GroupTie& t : ties_of(g, l)) {
    t.apart = to_world(g.bodies[t.b].pose, t.anchor_b) - to_world(g.bodies[t.a].pose, t.anchor_a);
    gaps.worst = std::max(gaps.worst, glm::length(t.apart));
    gaps.squares += glm::dot(t.apart, t.apart);
  }
  return gaps;
}

void close_cuts(const Group& g) {
  for (const GroupLoops& l : g.loops)
    for (const GroupTie& t : ties_of(g, l)) {
      if (!t.is_joint) continue;
      PANTIN_ASSERT(node_of(g, t.b) != kNoNode);
      const GroupTree& tree = g.trees[g.nodes[node_of(g, t.b)].tree];
      const Vec3 way =
          to_world(g.bodies[t.a].pose, t.anchor_a) - to_world(g.bodies[t.b].pose, t.anchor_b);
      for (std::uint32_t i = tree.first; i < tree.first + tree.count; ++i)
        g.bodies[g.nodes[i].body].pose.position += way;
    }
}

void push_closing(const Group& g, const GroupLoops& l) {
  for (std::uint32_t i = 0; i < l.ties; ++i) {
    const Vec3 apart = ties_of(g, l)[i].apart;
    const Real gap = glm::length(apart);
    set_left(g, l, i, gap > l.open ? (1 - l.open / gap) * apart : Vec3(0));
  }
  solve_forwards(g, l), solve_backwards(g, l);
  for (std::uint32_t i = 0; i < l.ties; ++i) {
    const GroupTie& t = ties_of(g, l)[i];
    const Vec3 impulse = -left_of(g, l, i);
    const std::uint32_t a = node_of(g, t.a), b = node_of(g, t.b);
    if (a != kNoNode) g.nodes[a].passing += {-impulse, -glm::cross(t.arm_a, impulse)};
    if (b != kNoNode) g.nodes[b].passing += {impulse, glm::cross(t.arm_b, impulse)};
    set_left(g, l, i, Vec3(0));
  }
}

CrossResponse cross_response_of(const Group& g, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t node = node_of(g, a), on = node_of(g, b);
  PANTIN_ASSERT(node != kNoNode && on != kNoNode);
  CrossResponse x;
  if (g.nodes[node].tree == g.nodes[on].tree) x = cross_response(g, node, on);
  if (g.bodies[a].looped == kNoNode || g.bodies[b].looped == kNoNode) return x;
  const LoopedBody &first = g.looped[g.bodies[a].looped], &second = g.looped[g.bodies[b].looped];
  PANTIN_ASSERT(first.loops == second.loops && first.known && second.known);
  const std::uint32_t ties = g.loops[first.loops].ties, from = std::max(first.first, second.first);
  const std::size_t columns = 3 * (ties - from), torque = ties * kBlockNumbers;
  const Real* const rows_a = g.numbers.data() + first.rows + from * kBlockNumbers;
  const Real* const rows_b = g.numbers.data() + second.rows + from * kBlockNumbers;
  x.vf = less_products(x.vf, rows_a, rows_b, columns);
  x.vt = less_products(x.vt, rows_a, rows_b + torque, columns);
  x.wf = less_products(x.wf, rows_a + torque, rows_b, columns);
  x.wt = less_products(x.wt, rows_a + torque, rows_b + torque, columns);
  return x;
}

}  // namespace pantin::detail::articulated

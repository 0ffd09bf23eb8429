// Response of ties to impulses: the matrix of their equations, and the motion of the bodies.
//
// An impulse at a point propagates from its body to the root; its effect on another point
// propagates from the root to that point's body. A row of the matrix is the second path taken
// backwards. An entry is the sum, over the bodies that both paths share, of the row's gradient by
// the rotation times the rotation by the impulse. [Featherstone 2010, "Exploiting sparsity in
// operational-space dynamics"] So a row costs the depth of its bodies, not their number.
#include <algorithm>
#include <span>

#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/smooth/conserving_ties.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;

Mat3 rows_at(const Real* m, std::size_t stride) {
  return Mat3(m[0], m[stride], m[2 * stride], m[1], m[stride + 1], m[2 * stride + 1], m[2],
              m[stride + 2], m[2 * stride + 2]);
}

/// Results of the elimination for a body: BallNodes for free ball joints, by the kernels;
/// StiffNodes for others (conserving_joints.cpp). compliance: rotation per torque; crossing:
/// impulse per rotation; turn_y, force_y: rotation and impulse per displacement of the own joint.
struct BallNodes {
  static constexpr bool kPassTorque = false;
  StepScratch& r;
  Mat3 compliance(std::size_t c) const { return rows_at(&r.tie_factors[kTieFactor * c], 3); }
  Mat3 crossing(std::size_t c) const { return rows_at(&r.tie_factors[kTieFactor * c + 9], 3); }
  Mat3 turn_y(std::size_t c) const { return -rows_at(&r.nodes[kNodeSize * c + kResponse], 4); }
  Mat3 force_y(std::size_t c) const {
    return rows_at(&r.nodes[kNodeSize * c + kArticulatedMass], 4);
  }
};
struct StiffNodes {
  static constexpr bool kPassTorque = true;
  StepScratch& r;
  ConservingNode& node(std::size_t c) const { return r.conserving_nodes[c]; }
  const Mat3& compliance(std::size_t c) const { return node(c).compliance; }
  const Mat3& crossing(std::size_t c) const { return node(c).crossing; }
  const Mat3& turn_y(std::size_t c) const { return node(c).turn_y; }
  const Mat3& force_y(std::size_t c) const { return node(c).force_y; }
};

/// The vector from the parent's joint to the own one, at the mean or the end of the substep.
Vec3 reach_of(const StepScratch& r, Arms arms, std::size_t c) {
  return r.work.vec(arms == Arms::mean ? kMeanReach : kEndReach, c);
}

/// Response of the whole island to the impulses in `tie_impulses` and `tie_torques`: replaces them
/// by displacements of the own joints and rotations; writes impulses at the joints to `tie_joints`.
template <class Nodes>
void respond(Island& a, const Nodes& nodes, Arms arms) {
  StepScratch& r = a.scratch;
  PANTIN_ASSERT(r.tie_impulses.size() == a.count() && r.tie_torques.size() == a.count());
  for (std::size_t c = a.count(); c-- > 0;) {
    Vec3 &torque = r.tie_torques[c], &impulse = r.tie_impulses[c];
    if constexpr (Nodes::kPassTorque) nodes.node(c).tie_passed = Vec3(0);
    // Most bodies have no tie outboard of them.
    if (torque == Vec3(0) && impulse == Vec3(0)) continue;
    const Vec3 turn = nodes.compliance(c) * torque;
    impulse -= nodes.crossing(c) * turn;
    if (a.parents[c] >= 0) {
      const auto p = static_cast<std::size_t>(a.parents[c]);
      r.tie_impulses[p] += impulse;
      r.tie_torques[p] += glm::cross(reach_of(r, arms, c), impulse);
    }
    if constexpr (Nodes::kPassTorque) {
      ConservingNode& n = nodes.node(c);
      n.tie_passed = n.turning * turn - torque;
      if (n.passes_torque && a.parents[c] >= 0)
        r.tie_torques[static_cast<std::size_t>(a.parents[c])] -= n.tie_passed;
    }
    torque = turn;
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Mat3 mass = nodes.force_y(c);
    Vec3 y(0), turn_p(0);
    if (a.parents[c] >= 0) {
      const auto p = static_cast<std::size_t>(a.parents[c]);
      turn_p = r.tie_torques[p];
      y = r.tie_impulses[p] + glm::cross(turn_p, r.work.vec(kEndReach, c));
    } else if (a.parents[c] == kFree) {
      y = glm::inverse(mass) * r.tie_impulses[c];
    }
    r.tie_joints[c] = mass * y - r.tie_impulses[c];
    r.tie_impulses[c] = y;
    r.tie_torques[c] += nodes.turn_y(c) * y;
    if constexpr (Nodes::kPassTorque) {
      const ConservingNode& n = nodes.node(c);
      if (n.passes_torque)
        r.tie_joints[c] += n.force_p * turn_p, r.tie_torques[c] += n.turn_p * turn_p;
    }
  }
}

/// A row of the ties' equations: direction of its impulse, and the component of d it constrains.
struct AskedRow {
  const ConservingTie& tie;
  Vec3 direction, by;
};

/// Fills the shares of a row: see the top of the file.
template <class Nodes>
void fill_shares(Island& a, const Nodes& nodes, Arms arms, const AskedRow& row) {
  StepScratch& r = a.scratch;
  const TieRow& to = r.tie_rows.back();
  PANTIN_ASSERT(is_part(to.path, to.count, r.tie_paths.size()));
  PANTIN_ASSERT(is_part(to.share, to.count, r.tie_shares.size()) &&
                to.count <= r.tie_passing.size());
  const auto path = std::span(r.tie_paths).subspan(to.path, to.count);
  const auto at = std::span(r.tie_passing).first(to.count);
  TieShare* const shares = &r.tie_shares[to.share];
  std::fill(at.begin(), at.end(), TiePassing{});
  const auto begin = [&](std::uint32_t c, Vec3 on, Vec3 end, Real sign) {
    std::size_t k = 0;
    while (path[k].column != c) ++k;
    PANTIN_ASSERT(k < path.size());
    const Vec3 impulse = -sign * row.direction, asked = sign * row.by;
    at[k].impulse += impulse, at[k].torque += glm::cross(on, impulse);
    at[k].by_move += asked, at[k].by_turn += glm::cross(end, asked);
  };
  const ConservingTie& t = row.tie;
  const bool mean = arms == Arms::mean;
  begin(t.b, mean ? t.mean_b : t.end_b, t.end_b, 1);
  if (t.a != kNone) begin(t.a, mean ? t.mean_a : t.end_a, t.end_a, -1);
  for (std::size_t k = 0; k < path.size(); ++k) {
    const std::size_t c = path[k].column;
    if (c >= a.count()) {  // the displacement of a free root
      shares[k] = {glm::inverse(nodes.force_y(c - a.count())) * at[k].impulse, at[k].by_move};
      continue;
    }
    const Vec3 turn = nodes.compliance(c) * at[k].torque;
    shares[k] = {turn, at[k].by_turn};
    if (path[k].parent == kNone) continue;
    PANTIN_ASSERT(path[k].parent > k && path[k].parent < path.size());
    TiePassing& p = at[path[k].parent];
    const Vec3 impulse = at[k].impulse - nodes.crossing(c) * turn;
    const Vec3 by_move = at[k].by_move + at[k].by_turn * nodes.turn_y(c);
    p.impulse += impulse, p.by_move += by_move;
    if (a.parents[c] < 0) continue;
    p.torque += glm::cross(reach_of(r, arms, c), impulse);
    p.by_turn += glm::cross(r.work.vec(kEndReach, c), by_move);
    if constexpr (Nodes::kPassTorque) {
      const ConservingNode& n = nodes.node(c);
      if (!n.passes_torque) continue;
      p.torque += at[k].torque - n.turning * turn, p.by_turn += at[k].by_turn * n.turn_p;
    }
  }
}

template <class Nodes>
void fill_all_shares(Island& a, const Nodes& nodes, Arms arms) {
  StepScratch& r = a.scratch;
  PANTIN_ASSERT(r.tie_path_starts.size() == r.ties.size() + 1);
  r.tie_rows.clear();
  std::uint32_t share = 0;
  for (std::size_t tie = 0; tie < r.ties.size(); ++tie) {
    const ConservingTie& t = r.ties[tie];
    const std::uint32_t first = r.tie_path_starts[tie], count = r.tie_path_starts[tie + 1] - first;
    const TieRows& rows = r.tie_sets[tie];
    for (int i = 0; i < rows.count; ++i) {
      r.tie_rows.push_back({first, count, share});
      fill_shares(a, nodes, arms, {t, rows.directions[i], rows.by[i]});
      share += count;
    }
  }
}

/// Adds the path of a tie: the bodies from its ends to their roots, children first.
void add_path(Island& a, std::uint32_t b, std::uint32_t other) {
  std::vector<TiePathStep>& paths = a.scratch.tie_paths;
  const auto first = static_cast<std::uint32_t>(paths.size());
  const auto n = static_cast<std::uint32_t>(a.count());
  for (std::uint32_t x = b, y = other; x != kNone || y != kNone;) {
    const std::uint32_t c = x == kNone ? y : y == kNone ? x : std::max(x, y);
    PANTIN_ASSERT(c < a.count());
    const std::int32_t parent = a.parents[c];
    const std::uint32_t next = parent < 0 ? kNone : static_cast<std::uint32_t>(parent);
    paths.push_back({c, next});
    if (parent == kFree) paths.back().parent = n + c, paths.push_back({n + c, kNone});
    if (x == c) x = next;
    if (y == c) y = next;
  }
  for (std::uint32_t k = first; k < paths.size(); ++k) {
    if (paths[k].parent == kNone) continue;
    std::uint32_t p = k + 1;
    while (paths[p].column != paths[k].parent) ++p;
    PANTIN_ASSERT(p < paths.size());
    paths[k].parent = p - first;
  }
}

}  // namespace

void reserve_tie_rows(Island& a) {
  StepScratch& r = a.scratch;
  r.tie_paths.clear(), r.tie_path_starts.assign(1, 0);
  for (const PackedPin& pin : a.pins) {
    add_path(a, pin.column, pin.partner);
    r.tie_path_starts.push_back(static_cast<std::uint32_t>(r.tie_paths.size()));
  }
  for (const PackedCable& cable : a.cables) {
    const bool has_b = cable.column_b != kNone;
    add_path(a, has_b ? cable.column_b : cable.column_a, has_b ? cable.column_a : kNone);
    r.tie_path_starts.push_back(static_cast<std::uint32_t>(r.tie_paths.size()));
  }
  std::uint32_t longest = 0;
  for (std::size_t tie = 0; tie + 1 < r.tie_path_starts.size(); ++tie)
    longest = std::max(longest, r.tie_path_starts[tie + 1] - r.tie_path_starts[tie]);
  r.tie_passing.assign(longest, {}), r.tie_shares.assign(3 * r.tie_paths.size(), {});
  r.tie_rows.reserve(3 * tie_count(a));
  r.tie_steps.assign(r.tie_paths.size(), {}), r.tie_step_starts.assign(2 * a.count(), kNoPathStep);
  r.tie_blocks_of_row.assign(kBlockNumbers * tie_count(a), 0);
}

namespace {

/// Lists the steps of all ties with rows by column, with the rotations that their rows cause there.
/// Ties are numbered by these lists. Returns their number.
std::uint32_t list_steps(StepScratch& r) {
  std::fill(r.tie_step_starts.begin(), r.tie_step_starts.end(), kNoPathStep);
  std::uint32_t number = 0;
  for (const TieRows& rows : r.tie_sets) number += rows.count > 0;
  const std::uint32_t all = number;
  const std::uint32_t columns = all == r.tie_rows.size() ? 1 : 3;  // of the widest rows
  auto row = static_cast<std::uint32_t>(r.tie_rows.size());
  for (std::size_t tie = r.ties.size(); tie-- > 0;) {
    const auto count = static_cast<std::uint32_t>(r.tie_sets[tie].count);
    if (count == 0) continue;
    row -= count, --number;
    const TieRow& first = r.tie_rows[row];
    for (std::uint32_t k = 0; k < first.count; ++k) {
      PathStep& step = r.tie_steps[first.path + k];
      std::uint32_t& start = r.tie_step_starts[r.tie_paths[first.path + k].column];
      step.tie = number, step.next = start, start = first.path + k;
      for (std::uint32_t c = 0; c < columns; ++c)
        for (int n = 0; n < 3; ++n)
          step.torque[3 * c + static_cast<std::uint32_t>(n)] =
              c < count ? r.tie_shares[first.share + c * first.count + k].turn[n] : 0;
    }
  }
  return all;
}

/// The blocks of the rows of a tie, one for each tie with rows.
void fill_blocks_of(StepScratch& r, std::size_t row, std::uint32_t count, std::uint32_t ties) {
  Real* const blocks = r.tie_blocks_of_row.data();
  std::fill_n(blocks, kBlockNumbers * ties, Real(0));
  const TieRow& first = r.tie_rows[row];
  for (std::uint32_t k = 0; k < first.count; ++k) {
    PathJoint at{r.tie_steps.data(),
                 r.tie_step_starts[r.tie_paths[first.path + k].column],
                 ties,
                 false,
                 {},
                 {}};
    for (std::uint32_t c = 0; c < count; ++c)
      for (std::uint32_t n = 0; n < 3; ++n)
        at.by_torque[kBlockWide * n + c] =
            r.tie_shares[first.share + c * first.count + k].by_turn[static_cast<int>(n)];
    kernels().add_path_responses(at, blocks);
  }
}

/// The matrix of ties that have one row each, as cables do: an entry is a number, not a block.
void fill_single_rows(StepScratch& r, std::size_t n) {
  Real* to = r.tie_matrix.data();
  for (const TieRow& row : r.tie_rows) {
    std::fill_n(to, n, Real(0));
    for (std::uint32_t k = 0; k < row.count; ++k) {
      const Vec3 by = r.tie_shares[row.share + k].by_turn;
      const PathStep* step = nullptr;
      for (std::uint32_t s = r.tie_step_starts[r.tie_paths[row.path + k].column]; s != kNoPathStep;
           s = step->next) {
        step = &r.tie_steps[s];
        to[step->tie] += by.x * step->torque[0] + by.y * step->torque[1] + by.z * step->torque[2];
      }
    }
    to += n;
  }
}

}  // namespace

void fill_tie_matrix(Island& a, Arms arms, std::size_t n) {
  StepScratch& r = a.scratch;
  if (!r.stiff)
    fill_all_shares(a, BallNodes{r}, arms);
  else
    fill_all_shares(a, StiffNodes{r}, arms);
  PANTIN_ASSERT(n == r.tie_rows.size() && r.tie_matrix.size() >= n * n);
  const std::uint32_t ties = list_steps(r);
  if (n == ties) return fill_single_rows(r, n);
  PANTIN_ASSERT(r.tie_blocks_of_row.size() >= kBlockNumbers * ties);
  Real* to = r.tie_matrix.data();
  std::size_t row = 0;
  for (const TieRows& rows : r.tie_sets) {
    if (rows.count == 0) continue;
    fill_blocks_of(r, row, static_cast<std::uint32_t>(rows.count), ties);
    for (int i = 0; i < rows.count; ++i) {
      const Real* block = r.tie_blocks_of_row.data() + i;
      for (const TieRows& other : r.tie_sets) {
        for (int c = 0; c < other.count; ++c)
          *to++ = block[kBlockWide * static_cast<std::size_t>(c)];
        if (other.count > 0) block += kBlockNumbers;
      }
    }
    row += static_cast<std::size_t>(rows.count);
  }
}

void clear_tie_impulses(StepScratch& r) {
  std::fill(r.tie_impulses.begin(), r.tie_impulses.end(), Vec3(0));
  std::fill(r.tie_torques.begin(), r.tie_torques.end(), Vec3(0));
}

void add_tie_impulse(StepScratch& r, const ConservingTie& t, Vec3 mu, Arms arms) {
  PANTIN_ASSERT(t.b < r.tie_impulses.size() && is_index_or_none(t.a, r.tie_impulses.size()));
  const Vec3 on_b = arms == Arms::mean ? t.mean_b : t.end_b;
  r.tie_impulses[t.b] -= mu, r.tie_torques[t.b] -= glm::cross(on_b, mu);
  if (t.a == kNone) return;
  const Vec3 on_a = arms == Arms::mean ? t.mean_a : t.end_a;
  r.tie_impulses[t.a] += mu, r.tie_torques[t.a] += glm::cross(on_a, mu);
}

void respond_to_ties(Island& a, Arms arms) {
  if (!a.scratch.stiff)
    respond(a, BallNodes{a.scratch}, arms);
  else
    respond(a, StiffNodes{a.scratch}, arms);
}

}  // namespace pantin::detail::articulated

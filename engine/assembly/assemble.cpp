#include "engine/assembly/assemble.hpp"

#include <algorithm>
#include <cmath>

#include "engine/assembly/branches.hpp"
#include "engine/assembly/surfaces.hpp"
#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"

namespace pantin::detail::assembly {

using lagrangian::Block;
using lagrangian::BlockKind;

namespace {

/// Sizes of perturbed starts, in rad and in sizes of the mechanism: growing, so that a solution
/// near the start is found before one far away.
constexpr Real kSmallestStart = 0.05, kLargestStart = 3;
/// Joints turned over in one attempt: at most this many, and as many again as there are joints.
constexpr int kMostTurned = 16;
/// A later attempt replaces the pose of least squares if it is better by this factor.
constexpr Real kBetter = 0.98;

/// One part with its descents.
struct Assembling {
  World& world;
  Part& part;
  const AssemblyChoices& choices;
  AssemblyReport& report;
  Random random;

  /// Descends from the present poses, and turns joints off spurious branches. True: assembled.
  bool attempt(Bring bring = Bring::lost);
  /// Descends to the pose of least squares.
  bool settle();
  /// Perturbs the first poses; the size grows with the number of the start.
  void restart(const Poses& first, int number);
};

bool Assembling::attempt(Bring bring) {
  const Method& method = choices.method ? *choices.method : methods().front();
  const int most = kMostTurned + static_cast<int>(part.m.blocks.size());
  report.turned_over += face(world, part);
  report.brought += bring_into_contact(world, part, bring);
  for (int turned = 0;; ++turned) {
    Descent d{world, part, choices.effort, random, choices.watch};
    const Ending ending = method.descend(d);
    report.iterations += d.iterations, report.perturbations += d.perturbations;
    if (ending != Ending::closed) return false;
    const std::vector<std::uint32_t> wrong = wrong_branches(world, part);
    if (wrong.empty()) return true;
    if (turned >= most) return false;
    // Not always the same one, for turning one over may turn its neighbour back.
    turn_over(world, part, wrong[random.word() % wrong.size()]);
    ++report.turned_over;
  }
}

bool Assembling::settle() {
  const Method& method = choices.method ? *choices.method : methods().front();
  Descent d{world, part, choices.effort, random, choices.watch};
  d.settles = true;
  const Ending ending = method.descend(d);
  report.iterations += d.iterations;
  return ending == Ending::closed && wrong_branches(world, part).empty();
}

void Assembling::restart(const Poses& first, int number) {
  const Real part_of_range = std::min(Real(1), Real(number - 2) / 12);
  // The first one only lays the bodies out.
  const Real size =
      number == 1 ? 0 : kSmallestStart * std::pow(kLargestStart / kSmallestStart, part_of_range);
  Poses poses = first;
  for (std::size_t b = 0; b < poses.size(); ++b) {
    poses[b].rotation =
        glm::normalize(from_rotation_vector(size * random.in_ball()) * poses[b].rotation);
    poses[b].position += 0.3 * size * std::sqrt(part.m.inertia[b].x) * random.in_ball();
  }
  set_poses(world, part, poses);
}

/// Poses and design variables of a part.
struct Configuration {
  Poses poses;
  std::vector<Real> numbers;
};
Configuration configuration_of(const Part& part) { return {poses_of(part), part.design.numbers}; }
void set_configuration(World& world, Part& part, const Configuration& to) {
  set_design(world, part, to.numbers);
  set_poses(world, part, to.poses);
}

/// Attempts from the present poses, then from perturbed ones. Leaves the part assembled, or in the
/// best pose of least squares.
bool assemble_part(Assembling& a) {
  const Poses first = poses_of(a.part);
  if (a.attempt()) return true;
  Configuration best = configuration_of(a.part);
  Real least = merit_of(a.part);
  for (int n = 1; n <= a.choices.starts; ++n) {
    ++a.report.starts;
    set_design(a.world, a.part, std::vector<Real>(a.part.design.numbers.size(), 0));
    a.restart(first, n);
    if (n % 3 != 0) lay_out(a.world, a.part);
    if (a.attempt(n % 2 == 0 ? Bring::all : Bring::lost)) return true;
    const Real merit = merit_of(a.part);
    if (!(merit < kBetter * least)) continue;
    least = merit, best = configuration_of(a.part);
  }
  set_configuration(a.world, a.part, best);
  return a.settle();
}

void list_residuals(const World& world, const Part& part, AssemblyReport& report) {
  for (std::size_t i = 0; i < part.m.blocks.size(); ++i) {
    const Block& b = part.m.blocks[i];
    if (lagrangian::is_compliant(b.kind) || binds_no_poses(b)) continue;
    const bool is_limit = b.kind == BlockKind::limit;
    const bool on = counts(part, i);
    if (is_limit && !on) continue;
    Real sum = 0;
    for (std::size_t r = b.first_row; r < b.first_row + b.rows && on; ++r)
      sum += part.m.scratch.c[r] * part.m.scratch.c[r];
    const Entity law = joint_of(world, b);
    auto same = std::find_if(report.residuals.begin(), report.residuals.end(),
                             [&](const auto& l) { return l.law == law && l.is_limit == is_limit; });
    if (same == report.residuals.end()) same = report.residuals.insert(same, {law, 0, is_limit});
    same->residual = std::hypot(same->residual, std::sqrt(sum));
  }
  for (const std::uint32_t i : wrong_branches(world, part))
    report.wrong_branch.push_back(joint_of(world, part.m.blocks[i]));
}

/// Rank, redundant laws and mobility at the present poses, without one-sided rows.
void count_freedoms(const World& world, Part& part, AssemblyReport& report) {
  lagrangian::Island& m = part.m;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!lagrangian::is_one_sided(m, i)) continue;
    if (lagrangian::is_active(m, i)) report.reached_limits.push_back(joint_of(world, m.blocks[i]));
    m.memory[i].active = false;
    lagrangian::write_block(world, m, i, {true, false});
  }
  std::fill(m.scratch.weights.begin(), m.scratch.weights.end(), 0.0);
  m.loops = true;  // trees may be singular where they were assembled
  factor_and_report(m);
  find_rank(m);
  std::size_t rows = 0, dependent = 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (!lagrangian::is_compliant(m.blocks[i].kind) && !binds_no_poses(m.blocks[i]) &&
        lagrangian::is_active(m, i))
      rows += m.blocks[i].rows;
  for (const lagrangian::Fault& f : m.faults) {
    if (f.kind != lagrangian::Fault::redundant) continue;
    dependent += static_cast<std::size_t>(f.rows);
    const Entity law = joint_of(world, m.blocks[f.block]);
    auto same = std::find_if(report.redundant.begin(), report.redundant.end(),
                             [&](const RedundantLaw& l) { return l.law == law; });
    if (same == report.redundant.end())
      report.redundant.push_back({law, f.rows});
    else
      same->rows += f.rows;
  }
  report.rows += rows, report.rank += rows - dependent;
  report.bodies += m.count();
  report.mobility +=
      6 * static_cast<std::int64_t>(m.count()) - static_cast<std::int64_t>(rows - dependent);
}

/// Values before and after. A length or radius at a bound, but not from the start, has reached it.
void list_design(const World& start, const World& world, const AssemblyChoices& choices,
                 AssemblyReport& report) {
  for (const DesignVariable& v : choices.free) {
    if (!fault_of(world, v).empty()) continue;
    DesignChange change{v, value_of(start, v), value_of(world, v)};
    const Real now = change.after.numbers.x;
    const Real near = 1e-9 * std::abs(now);
    change.is_at_bound = is_size(v.quantity) && (now <= v.least + near || now >= v.most - near);
    report.design.push_back(change);
  }
}

void note_motion(const Poses& first, const Poses& last, AssemblyReport& report) {
  for (std::size_t b = 0; b < first.size(); ++b) {
    report.moved = std::max(report.moved, glm::distance(first[b].position, last[b].position));
    const Quat turn = last[b].rotation * glm::conjugate(first[b].rotation);
    report.turned = std::max(report.turned, glm::length(rotation_vector(turn)));
  }
}

}  // namespace

AssemblyReport assemble(World& world, const AssemblyChoices& choices) {
  AssemblyReport report;
  report.seed = choices.seed;
  const World start = world;
  Problem p = make_problem(world, choices.held, choices.free);
  report.assembled = p.unfit.empty();
  for (Part& part : p.parts) {
    const Poses first = poses_of(part);
    Assembling a{p.world, part, choices, report, Random(choices.seed)};
    const bool is_closed = assemble_part(a);
    if (is_closed) lessen_change(p.world, part, choices.effort.tolerance);
    report.assembled = is_closed && report.assembled;
    report.residual = std::max(report.residual, worst_of(part));
    note_motion(first, poses_of(part), report);
    list_residuals(p.world, part, report);
    write_poses(part, world);
    for (const FreeQuantity& q : part.design.all) set_value(world, q.of, value_of(p.world, q.of));
    count_freedoms(p.world, part, report);
  }
  std::stable_sort(
      report.residuals.begin(), report.residuals.end(),
      [](const LawResidual& x, const LawResidual& y) { return x.residual > y.residual; });
  list_design(start, world, choices, report);
  if (!report.assembled && choices.finds_contradictions)
    report.contradictory = find_contradiction(world, start, report, choices);
  return report;
}

void scatter(World& world, std::uint64_t seed, Real spread, std::span<const Entity> held) {
  Random random(seed);
  const auto normal = [&] {  // Box-Muller
    const Real u = 0.5 * (random.signed_unit() + 1), v = random.signed_unit();
    return std::sqrt(-2 * std::log(std::max(u, Real(1e-300)))) * std::cos(kPi * v);
  };
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    Body& body = world.bodies.values()[i];
    const Entity e = world.bodies.owners()[i];
    if (body.motion != Motion::dynamic || std::find(held.begin(), held.end(), e) != held.end())
      continue;
    const Real x = normal(), y = normal(), z = normal();
    body.pose.position += spread * Vec3(x, y, z);
    const Real w = normal(), a = normal(), b = normal(), c = normal();
    body.pose.rotation = glm::normalize(Quat(w, a, b, c));
  }
}

}  // namespace pantin::detail::assembly

// The smallest set of laws found that cannot all hold: each is left out in turn, and stays out if
// the others still cannot hold. [deletion filter: Chinneck & Dravnieks 1991]
#include <algorithm>

#include "engine/assembly/assemble.hpp"

namespace pantin::detail::assembly {
namespace {

/// Perturbed starts of each test.
constexpr int kStarts = 6;
constexpr int kIterations = 200;

/// A World with some of its laws only.
struct Subset {
  World world;
  explicit Subset(const World& from, std::span<const Entity> left_out) : world(from) {
    world.destroy(left_out);
  }
};

/// Whether the laws that remain can hold together, from either start.
bool can_hold(const World& world, const World& start, std::span<const Entity> left_out,
              const AssemblyChoices& choices) {
  AssemblyChoices own;
  own.method = nullptr, own.effort = choices.effort, own.held = choices.held,
  own.free = choices.free;
  own.effort.iterations = kIterations, own.starts = kStarts, own.seed = choices.seed;
  own.finds_contradictions = false;
  Subset near(world, left_out);
  own.starts = 0;
  if (assemble(near.world, own).assembled) return true;
  Subset far(start, left_out);
  own.starts = kStarts;
  return assemble(far.world, own).assembled;
}

}  // namespace

std::vector<Entity> find_contradiction(const World& world, const World& start,
                                       const AssemblyReport& report,
                                       const AssemblyChoices& choices) {
  // A method may have stopped short of a solution that there is.
  if (can_hold(world, start, {}, choices)) return {};
  // Laws with the least residual first: those with the largest are left.
  std::vector<Entity> order, out;
  for (auto it = report.residuals.rbegin(); it != report.residuals.rend(); ++it)
    if (std::find(order.begin(), order.end(), it->law) == order.end()) order.push_back(it->law);
  // Halves at a time while they can be left out, then one at a time.
  std::size_t from = 0, length = std::max<std::size_t>(1, order.size() / 2);
  std::vector<Entity> needed;
  while (from < order.size()) {
    length = std::min(length, order.size() - from);
    std::vector<Entity> without = out;
    without.insert(without.end(), order.begin() + static_cast<std::ptrdiff_t>(from),
                   order.begin() + static_cast<std::ptrdiff_t>(from + length));
    if (!can_hold(world, start, without, choices)) {
      out = without, from += length;
      length *= 2;
    } else if (length == 1) {
      needed.push_back(order[from++]);
    } else {
      length = std::max<std::size_t>(1, length / 2);
    }
  }
  std::reverse(needed.begin(), needed.end());
  return needed;
}

}  // namespace pantin::detail::assembly

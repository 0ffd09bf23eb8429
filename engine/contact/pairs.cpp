#include "engine/contact/pairs.hpp"

#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::contact {
namespace {

/// The solver of a body, as in kSolvers; UINT8_MAX: none.
std::uint8_t solver_of(const SweptSearch& s, std::uint32_t slot) {
  const Owner owner = owner_of(s.partition, slot);
  return owner ? owner.solver : UINT8_MAX;
}

/// Index in kSolvers of the solver whose bodies are obstacles to all others.
constexpr std::uint8_t kLaminas = 0;

const Collision& collision_of(const SweptSearch& s, std::uint32_t slot) {
  return s.world.collisions[s.world.bodies.owners()[slot]];
}

}  // namespace

bool have_two_solvers(const SweptSearch& s, std::uint32_t a, std::uint32_t b) {
  return solver_of(s, a) != solver_of(s, b);
}

bool is_first(const SweptSearch& s, std::uint32_t a, std::uint32_t b) {
  return have_two_solvers(s, a, b) ? solver_of(s, a) > solver_of(s, b) : a < b;
}

std::uint64_t island_of(const SweptSearch& s, std::uint32_t slot) {
  const Owner owner = owner_of(s.partition, slot);
  return owner ? std::uint64_t(owner.solver) << 32 | owner.island : UINT64_MAX;
}

bool may_collide(const SweptSearch& s, const Search& search, std::uint32_t a, std::uint32_t b) {
  const std::uint8_t one = solver_of(s, a), two = solver_of(s, b);
  const bool apart =
      one != two && one != UINT8_MAX && two != UINT8_MAX && one != kLaminas && two != kLaminas;
  return !apart && do_groups_agree(collision_of(s, a), collision_of(s, b)) &&
         !are_joined(search.joined, a, b) && !are_joined(search.ignored, a, b);
}

bool asked_for(const SweptSearch& s, std::uint32_t slot_a, std::uint32_t slot_b) {
  const Collision &a = collision_of(s, slot_a), &b = collision_of(s, slot_b);
  if (have_two_solvers(s, slot_a, slot_b)) return true;
  const std::uint64_t island = island_of(s, slot_a);
  const bool own = island != UINT64_MAX && island == island_of(s, slot_b);
  return own ? a.self && b.self : a.others || b.others;
}

void list_pairs(const SweptSearch& s, Search& search) {
  search.pairs.clear();
  const bool two_solvers =
      std::any_of(search.colliders.begin(), search.colliders.end(), [&](const Collider& c) {
        return have_two_solvers(s, c.slot, search.colliders.front().slot);
      });
  const auto asks = [&](const Collider& c) {
    return two_solvers || c.collision->others || c.collision->self;
  };
  if (std::none_of(search.colliders.begin(), search.colliders.end(), asks)) return;
  PANTIN_ASSERT(search.boxes.size() == search.colliders.size());
  update_tree(search.tree, search.boxes);
  for (std::uint32_t i = 0; i < search.colliders.size(); ++i) {
    const Collider& a = search.colliders[i];
    if (!asks(a)) continue;
    const Real slop = kContactSlop * search.shapes[a.first].extent;
    search.tree.query(search.boxes[i].grown(slop), [&](std::uint32_t j) {
      const Collider& b = search.colliders[j];
      // If both request it, the pair is reported once, by the lower index.
      if (i == j || (j < i && asks(b)) || (a.rests && b.rests)) return;
      if (!asked_for(s, a.slot, b.slot) || !may_collide(s, search, a.slot, b.slot)) return;
      const std::uint64_t first = is_first(s, a.slot, b.slot) ? i : j;
      search.pairs.push_back(first << 32 | (first == i ? j : i));
    });
  }
  std::sort(search.pairs.begin(), search.pairs.end());
  search.pairs.erase(std::unique(search.pairs.begin(), search.pairs.end()), search.pairs.end());
}

}  // namespace pantin::detail::contact

#pragma once
/// Work on a large group by several threads, to the bits of one.
#include "engine/solvers/articulated/impulses/contact_groups.hpp"

namespace pantin::detail::articulated {

/// Trees or pairs that are worth a part of a thread's work.
inline constexpr std::size_t kLeastInPart = 4;

/// Calls `work(tree)` for each tree of the group. The calls are independent.
template <class Work>
void for_each_tree(const Group& g, const Work& work) {
  in_parts(g.threads, g.trees.size(), kLeastInPart, [&](const ListPart& part) {
    for (std::size_t i = part.begin; i < part.end; ++i) work(g.trees[i]);
  });
}

}  // namespace pantin::detail::articulated

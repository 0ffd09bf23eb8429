#pragma once
/// Orders the rows of a factor by the graph of what is coupled.
#include "engine/solvers/articulated/impulses/group_scratch.hpp"

namespace pantin::detail::articulated {

/// Lists the neighbours of each of `count` vertices in `links`: those of vertex i from `ends[i]` to
/// `ends[i + 1]`. `for_edges(visit)` calls visit(a, b) once for each edge.
template <class ForEdges>
void find_links(GroupScratch& r, std::size_t count, const ForEdges& for_edges) {
  r.ends.assign(count + 2, 0);
  for_edges([&](std::uint32_t a, std::uint32_t b) { ++r.ends[a + 2], ++r.ends[b + 2]; });
  for (std::size_t i = 2; i < r.ends.size(); ++i) r.ends[i] += r.ends[i - 1];
  r.links.resize(r.ends.back());
  for_edges([&](std::uint32_t a, std::uint32_t b) {
    r.links[r.ends[a + 1]++] = b, r.links[r.ends[b + 1]++] = a;
  });
}

/// Leaves in `roots` an order of the linked vertices of small bandwidth, and in `numbered` the
/// place of each. The reverse order has less fill-in. [Cuthill & McKee 1969; George & Liu 1981]
void find_order(GroupScratch& r, std::size_t count);

/// The same for an elimination with little fill-in: each vertex has the fewest neighbours left when
/// it is eliminated. Large graphs are ordered by bandwidth. [George & Liu 1981, minimum degree]
void find_elimination_order(GroupScratch& r, std::size_t count);

}  // namespace pantin::detail::articulated

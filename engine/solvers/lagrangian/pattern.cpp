// Elimination order: bodies with few blocks first, then minimum degree. A block whose bodies are
// all hubs must follow one of them, since it has no pivot before.
#include <algorithm>
#include <set>

#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;
/// Bodies with more blocks become hubs: d blocks make d (d - 1) / 2 products.
constexpr std::size_t kMaxBlocksPerBody = 4;

using Sets = std::vector<std::vector<std::uint32_t>>;  // sorted neighbours, by node

void connect(Sets& near, std::uint32_t a, std::uint32_t b) {
  const auto add = [&](std::uint32_t x, std::uint32_t y) {
    const auto it = std::lower_bound(near[x].begin(), near[x].end(), y);
    if (it == near[x].end() || *it != y) near[x].insert(it, y);
  };
  if (a != b) add(a, b), add(b, a);
}

using Incident = KktPattern::Incident;

std::vector<std::vector<Incident>> incidents(const Island& m) {
  std::vector<std::vector<Incident>> met(m.count());
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
    for (std::uint8_t k = 0; k < m.blocks[i].count; ++k)
      if (m.blocks[i].body[k] < m.count()) met[m.blocks[i].body[k]].push_back({i, k});
  return met;
}

/// Minimum-degree ordering; `near` becomes each node's neighbours that are eliminated later.
std::vector<std::uint32_t> least_degree(Sets& near, std::vector<std::uint8_t>& ready,
                                        const std::vector<std::uint32_t>& size) {
  const auto cost = [&](std::uint32_t n) {
    std::size_t sum = 0;
    for (std::uint32_t i : near[n]) sum += size[i];
    return sum;
  };
  std::set<std::pair<std::size_t, std::uint32_t>> queue;
  std::vector<std::size_t> key(near.size());
  for (std::uint32_t n = 0; n < near.size(); ++n) {
    key[n] = cost(n);
    if (ready[n]) queue.insert({key[n], n});
  }
  std::vector<std::uint32_t> order;
  std::vector<std::uint8_t> done(near.size(), 0);
  while (order.size() < near.size()) {
    if (queue.empty()) {  // rows between frames only: no pivot
      for (std::uint32_t n = 0; n < near.size(); ++n)
        if (!done[n] && !ready[n]) ready[n] = 1, queue.insert({key[n], n});
    }
    // Alternates between both ends, so that consecutive eliminations are independent.
    PANTIN_ASSERT(!queue.empty());
    auto next = queue.begin();
    if (order.size() % 2 == 1) next = std::prev(queue.lower_bound({next->first + 1, 0}));
    const std::uint32_t n = next->second;
    queue.erase(next);
    done[n] = 1, order.push_back(n);
    for (std::uint32_t i : near[n]) {
      near[i].erase(std::lower_bound(near[i].begin(), near[i].end(), n));
      for (std::uint32_t j : near[n]) connect(near, i, j);
    }
    for (std::uint32_t i : near[n]) {
      if (ready[i]) queue.erase({key[i], i});
      key[i] = cost(i), ready[i] = 1;
      queue.insert({key[i], i});
    }
  }
  return order;
}

/// Builder of a pattern; its functions run in the order below.
struct Draft {
  const Island& m;
  std::vector<std::vector<Incident>> met;  // by body
  std::uint32_t blocks;
  Sets near;                        // neighbours by node; in the end those eliminated later
  std::vector<std::uint32_t> size;  // unknowns, by node
  KktPattern p;

  std::uint32_t nodes() const { return blocks + static_cast<std::uint32_t>(p.hubs.size()); }
  bool is_hub(std::uint32_t body) const { return p.hub_of[body] != kNone; }
  /// Offset of the entry of two nodes in the factor, by their places.
  std::uint32_t number_at(std::uint32_t one, std::uint32_t two) const {
    if (one == two) return p.diagonal[one];
    const std::uint32_t row = std::max(one, two), column = std::min(one, two);
    const auto from = p.below.begin() + p.first[column], to = p.below.begin() + p.first[column + 1];
    PANTIN_ASSERT(std::binary_search(from, to, row));
    return p.offset[static_cast<std::size_t>(std::lower_bound(from, to, row) - p.below.begin())];
  }
};

void find_hubs(Draft& d, Hubs hubs) {
  d.p.hub_of.assign(d.m.count(), kNone);
  for (std::uint32_t b = 0; b < d.m.count(); ++b)
    if (hubs == Hubs::allowed && d.met[b].size() > kMaxBlocksPerBody)
      d.p.hub_of[b] = static_cast<std::uint32_t>(d.p.hubs.size()), d.p.hubs.push_back(b);
}

void find_order(Draft& d) {
  const std::size_t nodes = d.nodes();
  d.near.resize(nodes);
  std::vector<std::uint8_t> ready(nodes, 0);
  d.size.assign(nodes, 6);
  for (std::uint32_t i = 0; i < d.blocks; ++i) d.size[i] = d.m.blocks[i].rows;
  for (std::uint32_t b = 0; b < d.m.count(); ++b) {
    const std::vector<Incident>& met = d.met[b];
    PANTIN_ASSERT(d.near.size() == nodes && d.size.size() == nodes);
    const std::uint32_t hub = d.blocks + d.p.hub_of[b];
    for (std::size_t i = 0; i < met.size(); ++i) {
      if (d.is_hub(b)) {
        connect(d.near, met[i].block, hub);
        continue;
      }
      ready[met[i].block] = 1;
      for (std::size_t j = 0; j < i; ++j) connect(d.near, met[i].block, met[j].block);
    }
    if (d.is_hub(b)) ready[hub] = 1;
  }
  d.p.order = least_degree(d.near, ready, d.size);
  d.p.unknowns = d.m.rows + 6 * d.p.hubs.size();
  d.p.place.assign(nodes, 0);
  for (std::uint32_t at = 0; at < nodes; ++at) d.p.place[d.p.order[at]] = at;
}

/// Offsets of the entries of each node: its diagonal block, then those below it.
void lay_out_columns(Draft& d) {
  KktPattern& p = d.p;
  for (const std::uint32_t n : p.order) {
    p.size.push_back(static_cast<std::uint8_t>(d.size[n]));
    p.unknown.push_back(n < d.blocks ? d.m.blocks[n].first_row
                                     : static_cast<std::uint32_t>(d.m.rows) + 6 * (n - d.blocks));
    p.diagonal.push_back(static_cast<std::uint32_t>(p.numbers));
    p.numbers += d.size[n] * d.size[n];
    p.first.push_back(static_cast<std::uint32_t>(p.below.size()));
    std::vector<std::uint32_t> below;
    for (std::uint32_t i : d.near[n]) below.push_back(p.place[i]);
    std::sort(below.begin(), below.end());
    for (std::uint32_t to : below) {
      p.below.push_back(to);
      p.offset.push_back(static_cast<std::uint32_t>(p.numbers));
      p.numbers += d.size[n] * d.size[p.order[to]];
    }
  }
  p.first.push_back(static_cast<std::uint32_t>(p.below.size()));
}

/// Entries that the elimination of each node updates.
void list_targets(Draft& d) {
  KktPattern& p = d.p;
  for (std::uint32_t at = 0; at < d.nodes(); ++at) {
    p.first_target.push_back(static_cast<std::uint32_t>(p.targets.size()));
    for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i)
      for (std::uint32_t j = p.first[at]; j <= i; ++j)
        p.targets.push_back(d.number_at(p.below[i], p.below[j]));
  }
  p.first_target.push_back(static_cast<std::uint32_t>(p.targets.size()));
}

/// Contributions of each body to the matrix.
void list_products(Draft& d) {
  KktPattern& p = d.p;
  for (std::uint32_t b = 0; b < d.m.count(); ++b) {
    const std::vector<Incident>& met = d.met[b];
    p.first_product.push_back(static_cast<std::uint32_t>(p.products.size()));
    const bool all_points = std::all_of(
        met.begin(), met.end(), [&](const Incident& k) { return d.m.blocks[k.block].point; });
    for (std::size_t i = 0; i < met.size(); ++i) {
      const std::uint32_t one = p.place[met[i].block];
      if (d.is_hub(b)) {
        const std::uint32_t hub = p.place[d.blocks + p.hub_of[b]];
        p.hub_products.push_back({met[i].block, d.number_at(one, hub), met[i].at, one > hub});
        continue;
      }
      for (std::size_t j = i; j < met.size(); ++j) {
        const std::uint32_t two = p.place[met[j].block];
        p.products.push_back({met[i].block, met[j].block, d.number_at(one, two), met[i].at,
                              met[j].at, one > two, all_points});
      }
    }
  }
  p.first_product.push_back(static_cast<std::uint32_t>(p.products.size()));
}

/// Entries that no product writes.
void list_fill(Draft& d) {
  KktPattern& p = d.p;
  std::vector<std::uint8_t> written(p.numbers, 0);
  for (KktPattern::BlockProduct& k : p.products)
    k.first_write = written[k.target] == 0, written[k.target] = 1;
  const auto note_fill = [&](std::uint32_t from, std::size_t count) {
    if (!written[from]) p.fill_ranges.push_back({from, static_cast<std::uint32_t>(count)});
  };
  for (std::uint32_t at = 0; at < d.nodes(); ++at) {
    note_fill(p.diagonal[at], std::size_t{p.size[at]} * p.size[at]);
    for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i)
      note_fill(p.offset[i], std::size_t{p.size[at]} * p.size[p.below[i]]);
  }
}

void list_incidents(Draft& d) {
  KktPattern& p = d.p;
  for (const auto& of_body : d.met) {
    p.first_incident.push_back(static_cast<std::uint32_t>(p.incidents.size()));
    p.incidents.insert(p.incidents.end(), of_body.begin(), of_body.end());
  }
  p.first_incident.push_back(static_cast<std::uint32_t>(p.incidents.size()));
  for (std::uint32_t i = 0; i < d.blocks; ++i)
    if (std::any_of(d.m.blocks[i].body, d.m.blocks[i].body + d.m.blocks[i].count,
                    [&](std::uint32_t b) { return b >= d.m.count(); }))
      p.framed.push_back(i);
}

}  // namespace

KktPattern make_pattern(const Island& m, Hubs hubs) {
  Draft d{m, incidents(m), static_cast<std::uint32_t>(m.blocks.size()), {}, {}, {}};
  find_hubs(d, hubs);
  find_order(d);
  lay_out_columns(d);
  list_targets(d);
  list_products(d);
  list_fill(d);
  list_incidents(d);
  assert_factorable(d.p);
  return std::move(d.p);
}

}  // namespace pantin::detail::lagrangian

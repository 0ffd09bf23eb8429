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

}  // namespace

KktPattern make_pattern(const Island& m, bool may_have_hubs) {
  KktPattern p;
  const auto met = incidents(m);
  const auto blocks = static_cast<std::uint32_t>(m.blocks.size());
  p.hub_of.assign(m.count(), kNone);
  for (std::uint32_t b = 0; b < m.count(); ++b)
    if (may_have_hubs && met[b].size() > kMaxBlocksPerBody)
      p.hub_of[b] = static_cast<std::uint32_t>(p.hubs.size()), p.hubs.push_back(b);
  const std::size_t nodes = blocks + p.hubs.size();

  Sets near(nodes);
  std::vector<std::uint8_t> ready(nodes, 0);
  std::vector<std::uint32_t> size(nodes, 6);
  for (std::uint32_t i = 0; i < blocks; ++i) size[i] = m.blocks[i].rows;
  for (std::uint32_t b = 0; b < m.count(); ++b) {
    const std::uint32_t hub = p.hub_of[b];
    for (std::size_t i = 0; i < met[b].size(); ++i) {
      if (hub != kNone) {
        connect(near, met[b][i].block, blocks + hub);
        continue;
      }
      ready[met[b][i].block] = 1;
      for (std::size_t j = 0; j < i; ++j) connect(near, met[b][i].block, met[b][j].block);
    }
    if (hub != kNone) ready[blocks + hub] = 1;
  }
  p.order = least_degree(near, ready, size);
  p.unknowns = m.rows + 6 * p.hubs.size();

  p.place.assign(nodes, 0);
  for (std::uint32_t at = 0; at < nodes; ++at) p.place[p.order[at]] = at;
  for (std::uint32_t at = 0; at < nodes; ++at) {
    const std::uint32_t n = p.order[at];
    p.size.push_back(static_cast<std::uint8_t>(size[n]));
    p.unknown.push_back(n < blocks ? m.blocks[n].first_row
                                   : static_cast<std::uint32_t>(m.rows) + 6 * (n - blocks));
    p.diagonal.push_back(static_cast<std::uint32_t>(p.numbers));
    p.numbers += size[n] * size[n];
    p.first.push_back(static_cast<std::uint32_t>(p.below.size()));
    std::vector<std::uint32_t> below;
    for (std::uint32_t i : near[n]) below.push_back(p.place[i]);
    std::sort(below.begin(), below.end());
    for (std::uint32_t to : below) {
      p.below.push_back(to);
      p.offset.push_back(static_cast<std::uint32_t>(p.numbers));
      p.numbers += size[n] * size[p.order[to]];
    }
  }
  p.first.push_back(static_cast<std::uint32_t>(p.below.size()));

  const auto number_at = [&](std::uint32_t row, std::uint32_t column) {
    if (row == column) return p.diagonal[row];
    const auto from = p.below.begin() + p.first[column], to = p.below.begin() + p.first[column + 1];
    return p.offset[static_cast<std::size_t>(std::lower_bound(from, to, row) - p.below.begin())];
  };
  for (std::uint32_t at = 0; at < nodes; ++at) {
    p.first_target.push_back(static_cast<std::uint32_t>(p.targets.size()));
    for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i)
      for (std::uint32_t j = p.first[at]; j <= i; ++j)
        p.targets.push_back(number_at(p.below[i], p.below[j]));
  }
  p.first_target.push_back(static_cast<std::uint32_t>(p.targets.size()));

  for (std::uint32_t b = 0; b < m.count(); ++b) {
    p.first_product.push_back(static_cast<std::uint32_t>(p.products.size()));
    for (std::size_t i = 0; i < met[b].size(); ++i) {
      const std::uint32_t one = p.place[met[b][i].block];
      if (p.hub_of[b] != kNone) {
        const std::uint32_t hub = p.place[blocks + p.hub_of[b]];
        p.hub_products.push_back({met[b][i].block,
                                  number_at(std::max(one, hub), std::min(one, hub)), met[b][i].at,
                                  one > hub});
        continue;
      }
      const bool all_points = std::all_of(
          met[b].begin(), met[b].end(), [&](const Incident& k) { return m.blocks[k.block].point; });
      for (std::size_t j = i; j < met[b].size(); ++j) {
        const std::uint32_t two = p.place[met[b][j].block];
        p.products.push_back({met[b][i].block, met[b][j].block,
                              number_at(std::max(one, two), std::min(one, two)), met[b][i].at,
                              met[b][j].at, one > two, all_points});
      }
    }
  }
  p.first_product.push_back(static_cast<std::uint32_t>(p.products.size()));

  std::vector<std::uint8_t> written(p.numbers, 0);
  for (KktPattern::BlockProduct& k : p.products)
    k.first_write = written[k.target] == 0, written[k.target] = 1;
  const auto note_fill = [&](std::uint32_t from, std::size_t count) {
    if (!written[from]) p.fill_ranges.push_back({from, static_cast<std::uint32_t>(count)});
  };
  for (std::uint32_t at = 0; at < nodes; ++at) {
    note_fill(p.diagonal[at], std::size_t{p.size[at]} * p.size[at]);
    for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i)
      note_fill(p.offset[i], std::size_t{p.size[at]} * p.size[p.below[i]]);
  }
  for (const auto& of_body : met) {
    p.first_incident.push_back(static_cast<std::uint32_t>(p.incidents.size()));
    p.incidents.insert(p.incidents.end(), of_body.begin(), of_body.end());
  }
  p.first_incident.push_back(static_cast<std::uint32_t>(p.incidents.size()));
  for (std::uint32_t i = 0; i < blocks; ++i)
    if (std::any_of(m.blocks[i].body, m.blocks[i].body + m.blocks[i].count,
                    [&](std::uint32_t b) { return b >= m.count(); }))
      p.framed.push_back(i);
  return p;
}

}  // namespace pantin::detail::lagrangian

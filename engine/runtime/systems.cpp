#include "engine/runtime/systems.hpp"

#include <algorithm>

namespace pantin::detail {
namespace {

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return !name.empty() && std::find(names.begin(), names.end(), name) != names.end();
}

bool must_precede(const StagedSystem& first, const StagedSystem& second) {
  return contains(first.order.before, second.order.name) ||
         contains(second.order.after, first.order.name);
}

/// Topological order of the systems: of those without pending predecessors, the first inserted
/// comes next. The result is shorter than the input if there is a cycle.
std::vector<std::size_t> running_order(const std::vector<StagedSystem>& all) {
  std::vector<std::size_t> order;
  std::vector<bool> done(all.size(), false);
  const auto is_ready = [&](std::size_t i) {
    for (std::size_t k = 0; k < all.size(); ++k)
      if (k != i && !done[k] && must_precede(all[k], all[i])) return false;
    return true;
  };
  for (;;) {
    std::size_t next = all.size();
    for (std::size_t i = 0; i < all.size(); ++i)
      if (!done[i] && is_ready(i) && (next == all.size() || all[i].number < all[next].number))
        next = i;
    if (next == all.size()) return order;
    done[next] = true;
    order.push_back(next);
  }
}

void arrange(std::vector<StagedSystem>& all, const std::vector<std::size_t>& order) {
  std::vector<StagedSystem> arranged;
  for (const std::size_t i : order) arranged.push_back(std::move(all[i]));
  all = std::move(arranged);
}

}  // namespace

void Systems::insert(Stage stage, System system) {
  std::vector<StagedSystem>& all = systems_[static_cast<std::size_t>(stage)];
  all.push_back({std::move(system), {}, inserted_++});
  arrange(all, running_order(all));
}

Result<Done> Systems::insert(Stage stage, SystemOrder wish, System system) {
  if (wish.name.empty()) return Error{"system: found an empty name, expected a name"};
  const std::string who = "system '" + wish.name + "'";
  if (has(wish.name)) return Error{who + ": found another system of that name, expected a new one"};
  if (contains(wish.before, wish.name) || contains(wish.after, wish.name))
    return Error{who + ": found an order before or after itself, expected another's name"};
  std::vector<StagedSystem>& all = systems_[static_cast<std::size_t>(stage)];
  all.push_back({std::move(system), std::move(wish), inserted_});
  const std::vector<std::size_t> order = running_order(all);
  if (order.size() < all.size()) {
    all.pop_back();
    return Error{who +
                 ": found a cycle in the order of systems, expected a first and a last system"};
  }
  ++inserted_;
  arrange(all, order);
  return Done{};
}

bool Systems::remove(std::string_view name) {
  if (!has(name)) return false;
  for (auto& all : systems_)
    if (std::erase_if(all, [&](const StagedSystem& s) { return s.order.name == name; }) > 0)
      arrange(all, running_order(all));
  return true;
}

bool Systems::has(std::string_view name) const {
  return !name.empty() && std::any_of(systems_.begin(), systems_.end(), [&](const auto& all) {
    return std::any_of(all.begin(), all.end(),
                       [&](const StagedSystem& s) { return s.order.name == name; });
  });
}

}  // namespace pantin::detail

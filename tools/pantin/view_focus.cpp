#include "tools/pantin/view_focus.hpp"

#include <algorithm>

#include "engine/solvers/solver.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr std::size_t kComponents = 3;

/// Whether a quantity is plotted only if it is asked for: there are too many otherwise.
bool is_secondary(std::string_view name) {
  for (const std::string_view start : {"reaction_", "contact", "vx", "vy", "vz", "wx", "wy", "wz"})
    if (name.starts_with(start)) return true;
  return false;
}

}  // namespace

void Focus::choose(const World& world, Entity object, Real step) {
  clear();
  if (!world.is_alive(object)) return;
  World built = world;
  compile_if_changed(built);
  events_.emplace(built);
  for (Reading& r : readings_of(built, object, *events_, step))
    quantities_.push_back({std::move(r), {}});
  if (quantities_.empty()) return clear();
  object_ = object, name_ = world.name_of(object);
  std::size_t shown = 0;
  for (Plotted& p : quantities_) shown += p.is_shown = !is_secondary(short_name(*this, p));
  for (std::size_t i = 0; shown == 0 && i < std::min(kComponents, quantities_.size()); ++i)
    quantities_[i].is_shown = true;
}

void Focus::start(const World& world, Real step) {
  const bool is_same = world.is_alive(object_) && world.name_of(object_) == name_;
  const std::string name = name_;
  choose(world, is_same ? object_ : world.find(name), step);
}

void Focus::clear() {
  quantities_.clear(), events_.reset();
  object_ = Entity{}, name_.clear();
}

void Focus::sample(const World& world) {
  if (quantities_.empty()) return;
  events_->update(world);
  for (Plotted& p : quantities_) p.values.push({world.time, p.reading.value(world)});
}

std::string short_name(const Focus& focus, const Plotted& plotted) {
  return plotted.reading.name.substr(focus.name().size() + 1);
}

}  // namespace pantin::program

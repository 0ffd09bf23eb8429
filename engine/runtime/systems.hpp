#pragma once
/// A user's own functions within a step: where they run and in which order.
#include <array>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin {

/// The named places of a step where a user's own system may run.
enum class Place : std::uint8_t {
  before_drive,
  before_update,
  before_touch,
  before_adjust,
  before_measure,
  after_step
};
inline constexpr std::size_t kPlaces = 6;

/// A user's own system: called with the World and the step length in seconds. A function of a const
/// World& is one too.
using System = std::function<void(World&, Real)>;

/// What a system is called, and which others of its place it runs before and after. Others may be
/// inserted later; a name that nobody has orders nothing.
struct SystemOrder {
  std::string name = {};
  std::vector<std::string> before = {}, after = {};
};

/// One system in its place.
struct PlacedSystem {
  System run;
  SystemOrder order = {};
  std::uint64_t number = 0;  // of its insertion
};

/// Systems by place. Within a place they run in the order they were inserted, except where
/// SystemOrder asks for another.
class Systems {
 public:
  void insert(Place place, System system);
  /// Refuses an empty name, one that is taken (in any place), and orders that contradict one another;
  /// nothing is changed then.
  Result<Done> insert(Place place, SystemOrder order, System system);
  /// False if no system has that name.
  bool remove(std::string_view name);
  bool has(std::string_view name) const;

  /// The systems of a place, in the order they run.
  std::span<const PlacedSystem> at(Place place) const {
    return systems_[static_cast<std::size_t>(place)];
  }

 private:
  std::array<std::vector<PlacedSystem>, kPlaces> systems_;
  std::uint64_t inserted_ = 0;
};

}  // namespace pantin

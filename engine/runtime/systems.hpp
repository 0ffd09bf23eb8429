#pragma once
/// User systems: their stage within a step and their order.
#include <array>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin {

/// Stages of a step at which user systems run.
enum class Stage : std::uint8_t {
  before_drive,
  before_update,
  before_contacts,
  before_adjust,
  before_measure,
  after_step
};
/// A user system, called with the World and the step length in seconds. It may take a const World&.
using System = std::function<void(World&, Real)>;

/// Name of a system, and the systems of its stage that it runs before and after. Those may be
/// inserted later; unknown names have no effect.
struct SystemOrder {
  std::string name = {};
  std::vector<std::string> before = {}, after = {};
};

namespace detail {

inline constexpr std::size_t kStages = 6;

/// One system of a stage.
struct StagedSystem {
  System run;
  SystemOrder order = {};
  std::uint64_t number = 0;  // order of insertion
};

/// Systems by stage. Within a stage they run in order of insertion, unless SystemOrder requires
/// another order.
class Systems {
 public:
  void insert(Stage stage, System system);
  /// Inserts a system. An empty name, a name in use (at any stage) or a contradictory order is an
  /// error, and nothing changes.
  Result<Done> insert(Stage stage, SystemOrder order, System system);
  /// Removes a system; returns false if none has that name.
  bool remove(std::string_view name);
  bool has(std::string_view name) const;

  /// The systems of a stage, in the order of execution.
  std::span<const StagedSystem> at(Stage stage) const {
    return systems_[static_cast<std::size_t>(stage)];
  }

 private:
  std::array<std::vector<StagedSystem>, kStages> systems_;
  std::uint64_t inserted_ = 0;
};

}  // namespace detail

}  // namespace pantin

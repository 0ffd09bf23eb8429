#pragma once
// The object whose quantities the viewer plots.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/pantin/readings.hpp"
#include "tools/pantin/view_trace.hpp"

namespace pantin::program {

/// A quantity of the chosen object, over the last steps.
struct Plotted {
  Reading reading;
  Ring<Value> values;
  bool is_shown = false;
};

/// A chosen joint, cable, pin or body, and its quantities: those of a record (see readings_of).
class Focus {
 public:
  Focus() = default;
  Focus(const Focus&) = delete;  // readings refer to the events
  Focus& operator=(const Focus&) = delete;

  /// Chooses an object of a World; `step` is the length of its steps, s.
  /// An entity without quantities clears it.
  void choose(const World& world, Entity object, Real step);
  /// Starts anew in another World, with the object of the same name, if there is one.
  void start(const World& world, Real step);
  void clear();
  /// After each step.
  void sample(const World& world);

  Entity object() const { return object_; }
  /// Its name; empty without one.
  const std::string& name() const { return name_; }
  const std::vector<Plotted>& quantities() const { return quantities_; }
  /// Shows a quantity, or hides it.
  void toggle(std::size_t quantity) {
    quantities_[quantity].is_shown = !quantities_[quantity].is_shown;
  }

 private:
  Entity object_;
  std::string name_;
  std::optional<ContactEvents> events_;
  std::vector<Plotted> quantities_;
};

/// The name of a quantity without that of its object: "angle".
std::string short_name(const Focus& focus, const Plotted& plotted);

}  // namespace pantin::program

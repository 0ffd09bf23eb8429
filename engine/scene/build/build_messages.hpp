#pragma once
/// The interface by which building a recipe reports errors and warnings about its elements. The
/// recipe knows no file; the reader that filled it knows the position of each element.
#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

#include "engine/scene/json/words.hpp"

namespace pantin::detail {

enum class ElementKind : std::uint8_t {
  group,  // the scene or a prefab itself
  body,
  joint,
  ratio,
  belt,
  string,
  pin,
  drive,
  instance,
  grid,
  chain,
  mirror,
  surface_joint,
  event,
  pose,
  sensor,
  free
};

/// One element of a recipe.
struct ElementId {
  ElementKind kind = ElementKind::group;
  std::uint32_t group = 0;  // 0: the scene; 1 + i: prefab i
  std::uint32_t index = 0;  // in the group's list of this kind
  auto operator<=>(const ElementId&) const = default;
};

class BuildMessages {
 public:
  virtual ~BuildMessages() = default;

  /// An error: the recipe cannot be built. `member` is the faulty part of the element, named as in
  /// scene files, "limits/restitution" for a nested one; empty: the whole element.
  virtual void error(const ElementId& at, std::string_view member, std::string message) = 0;
  /// A warning: the recipe can be built. Warnings of one `kind` about one element are reported
  /// once, with their number.
  virtual void warn(const ElementId& at, std::string_view kind, std::string message) = 0;
  /// Number of errors so far, those of the reader included.
  virtual std::size_t errors() const = 0;

  virtual Hints& hints() = 0;
};

}  // namespace pantin::detail

// Design variables by their paths in the scene: "joints/3/length", "cables/hoist/over/0/radius".
#include <algorithm>
#include <charconv>
#include <utility>

#include "engine/joints/kinds.hpp"
#include "engine/scene/build/build.hpp"

namespace pantin::detail {
namespace {

constexpr std::string_view kForm =
    "a path such as \"joints/3/length\" or \"cables/rope/over/0/radius\"";
constexpr std::pair<std::string_view, Quantity> kQuantities[] = {
    {"length", Quantity::length},     {"radius", Quantity::radius},
    {"pitch", Quantity::pitch},       {"anchor_a", Quantity::anchor_a},
    {"anchor_b", Quantity::anchor_b}, {"axis_a", Quantity::axis_a},
    {"axis_b", Quantity::axis_b}};

std::optional<std::uint32_t> number_in(std::string_view text) {
  std::uint32_t number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = fault == std::errc() && end == text.data() + text.size();
  return is_number ? std::optional(number) : std::nullopt;
}

/// Removes the last part of a path and returns it.
std::string_view take_last(std::string_view& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string_view::npos) return std::exchange(path, {});
  const std::string_view last = path.substr(slash + 1);
  path = path.substr(0, slash);
  return last;
}

/// The element with this number in the file, or with this name.
template <class T>
std::optional<std::uint32_t> find_element(const std::vector<T>& all, ElementKind kind,
                                          std::string_view which) {
  const auto number = number_in(which);
  const auto it = std::find_if(all.begin(), all.end(), [&](const T& x) {
    return x.name == which || (number && x.at == ElementId{kind, 0, *number});
  });
  if (it == all.end()) return std::nullopt;
  return static_cast<std::uint32_t>(it - all.begin());
}

/// The name that is nearest to an unknown one, for an error.
template <class T>
std::string nearest_of(const std::vector<T>& all, std::string_view which) {
  std::vector<std::string_view> names;
  for (const T& x : all) names.push_back(x.name);
  return hint(which, names);
}

/// Why the bounds do not suit the value, as "expected ..."; empty if they do.
std::string fault_of_bounds(const FreeRecipe& recipe, Quantity quantity, Real value) {
  if (!recipe.least && !recipe.most) return {};
  if (!is_size(quantity)) return "expected \"min\" and \"max\" beside a length or a radius only";
  if (recipe.least && recipe.most && *recipe.least > *recipe.most)
    return "expected a \"min\" of at most \"max\"";
  if (value < recipe.least.value_or(value) || value > recipe.most.value_or(value))
    return "expected bounds that its value, " + written(value) + " m, lies within";
  return {};
}

}  // namespace

std::optional<BuiltFree> find_free(const BuiltScene& built, const FreeRecipe& recipe,
                                   std::string& fault) {
  const auto refuse = [&](const std::string& expected) {
    fault = "found " + quoted_name(recipe.of) + ", " + expected;
    return std::nullopt;
  };
  std::string_view path = recipe.of;
  const std::string_view key = take_last(path);
  const auto known = std::find_if(std::begin(kQuantities), std::end(kQuantities),
                                  [&](const auto& q) { return q.first == key; });
  const bool is_joint = path.starts_with("joints/"), is_cable = path.starts_with("cables/");
  if (known == std::end(kQuantities) || (!is_joint && !is_cable))
    return refuse("expected " + std::string(kForm));
  path.remove_prefix(7);
  BuiltFree found{{{}, known->second}, is_cable, 0};
  if (found.variable.quantity == Quantity::radius) {
    const auto guide = number_in(take_last(path));
    if (!guide || take_last(path) != "over") return refuse("expected " + std::string(kForm));
    found.variable.guide = *guide;
  }
  const auto law = is_joint ? find_element(built.joints, ElementKind::joint, path)
                            : find_element(built.cables, ElementKind::string, path);
  if (!law)
    return refuse(
        "expected in place of " + quoted_name(path) +
        (is_joint
             ? " the name of a joint, or its number in the list" + nearest_of(built.joints, path)
             : " the name of a cable, or its number in the list" + nearest_of(built.cables, path)));
  found.law = *law;
  const auto& guides = is_cable ? built.cables[*law].guides : std::vector<BuiltGuide>{};
  const std::uint32_t guide = found.variable.guide;
  const Real radius = guide < guides.size() ? guides[guide].guide.radius : -1;
  const std::string_view why = is_joint
                                   ? design_fault(built.joints[*law].joint, known->second)
                                   : design_fault(built.cables[*law].joint, known->second, radius);
  if (!why.empty()) return refuse(std::string(why));
  Real value = radius;
  if (known->second == Quantity::length)
    value =
        is_joint ? built.joints[*law].joint.parameters->length : built.cables[*law].joint.length;
  const std::string bounds = fault_of_bounds(recipe, known->second, value);
  if (!bounds.empty()) return refuse(bounds);
  found.variable.least = recipe.least.value_or(found.variable.least);
  found.variable.most = recipe.most.value_or(found.variable.most);
  return found;
}

void check_free(const BuiltScene& built, const std::vector<FreeRecipe>& all,
                BuildMessages& messages) {
  if (messages.errors() > 0) return;  // elements that could not be built are missing
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    std::string fault;
    if (!find_free(built, all[i], fault))
      messages.error({ElementKind::free, 0, i}, "of", std::move(fault));
  }
}

}  // namespace pantin::detail

// Design variables by their paths in the scene: "joints/3/length", "cables/hoist/over/0/radius",
// "gears/0/ratio", "belts/drive/pulleys/1/radius", "surfaces/cam/points/2/1".
#include <algorithm>
#include <charconv>
#include <utility>

#include "engine/geometry/surface.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/nurbs/net.hpp"
#include "engine/scene/build/build.hpp"

namespace pantin::detail {
namespace {

constexpr std::string_view kForm =
    "a path such as \"joints/3/length\", \"cables/rope/over/0/radius\" or "
    "\"surfaces/cam/points/2/1\"";
constexpr std::pair<std::string_view, Quantity> kQuantities[] = {
    {"length", Quantity::length},     {"radius", Quantity::radius},
    {"pitch", Quantity::pitch},       {"ratio", Quantity::ratio},
    {"anchor_a", Quantity::anchor_a}, {"anchor_b", Quantity::anchor_b},
    {"axis_a", Quantity::axis_a},     {"axis_b", Quantity::axis_b}};

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
  if (numbers_of(quantity) > 1)
    return "expected \"min\" and \"max\" beside a quantity of one number only";
  if (recipe.least && recipe.most && *recipe.least > *recipe.most)
    return "expected a \"min\" of at most \"max\"";
  if (value < recipe.least.value_or(value) || value > recipe.most.value_or(value))
    return "expected bounds that its value, " + written(value) + ", lies within";
  return {};
}

/// The search of one path.
struct Search {
  const FreeSource& in;
  const FreeRecipe& recipe;
  std::string& fault;

  std::optional<BuiltFree> refuse(std::string_view expected) const {
    fault = "found " + quoted_name(recipe.of) + ", " + std::string(expected);
    return std::nullopt;
  }
  std::optional<BuiltFree> refuse_form() const { return refuse("expected " + std::string(kForm)); }

  template <class T>
  std::optional<BuiltFree> refuse_name(const std::vector<T>& all, std::string_view which,
                                       std::string_view what) const {
    return refuse("expected in place of " + quoted_name(which) + " the name of a " +
                  std::string(what) + ", or its number in the list" + nearest_of(all, which));
  }
  std::optional<BuiltFree> number_of_law() const;
  std::optional<BuiltFree> number_of_net() const;
  std::optional<BuiltFree> find_side(const NetRecipe& net, BuiltFree found) const;
  std::string_view fault_of(BuiltFree& found, Real& value) const;
};

/// Why it is no design variable, or its value if it has one number.
std::string_view Search::fault_of(BuiltFree& found, Real& value) const {
  const BuiltScene& built = in.built;
  const Quantity q = found.variable.quantity;
  const std::uint32_t guide = found.variable.guide;
  if (found.kind == ElementKind::joint) {
    const Joint& joint = built.joints[found.law].joint;
    const std::string_view why = design_fault(joint, q);
    if (why.empty() && numbers_of(q) == 1)
      value = q == Quantity::length ? joint.parameters->length : joint.parameters->pitch;
    return why;
  }
  if (found.kind == ElementKind::ratio) {
    value = built.gears[found.law].ratio.ratio;
    return design_fault(built.gears[found.law].ratio, q);
  }
  if (found.kind == ElementKind::belt) {
    const Belt& belt = built.belts[found.law].belt;
    if (guide < belt.pulleys.size()) value = belt.pulleys[guide].outline.radius;
    return design_fault(belt, q, guide);
  }
  const BuiltCable& cable = built.cables[found.law];
  const Real radius = guide < cable.guides.size() ? cable.guides[guide].guide.radius : -1;
  value = q == Quantity::length ? cable.joint.length : radius;
  return design_fault(cable.joint, q, radius);
}

std::optional<BuiltFree> Search::number_of_law() const {
  std::string_view path = recipe.of;
  const std::string_view key = take_last(path);
  const auto known = std::find_if(std::begin(kQuantities), std::end(kQuantities),
                                  [&](const auto& q) { return q.first == key; });
  if (known == std::end(kQuantities)) return refuse_form();
  const std::string_view list = path.substr(0, path.find('/'));
  path.remove_prefix(std::min(list.size() + 1, path.size()));
  BuiltFree found{{{}, known->second}};
  const bool has_pulleys = list == "cables" || list == "belts";
  if (found.variable.quantity == Quantity::radius && has_pulleys) {
    const auto guide = number_in(take_last(path));
    if (!guide || take_last(path) != (list == "belts" ? "pulleys" : "over")) return refuse_form();
    found.variable.guide = *guide;
  }
  std::optional<std::uint32_t> law;
  const auto look = [&](const auto& all, ElementKind kind, std::string_view what) {
    found.kind = kind, law = find_element(all, kind, path);
    if (!law) refuse_name(all, path, what);
  };
  const BuiltScene& built = in.built;
  if (list == "joints")
    look(built.joints, ElementKind::joint, "joint");
  else if (list == "cables")
    look(built.cables, ElementKind::string, "cable");
  else if (list == "gears")
    look(built.gears, ElementKind::ratio, "gear");
  else if (list == "belts")
    look(built.belts, ElementKind::belt, "belt");
  else
    return refuse_form();
  if (!law) return std::nullopt;
  found.law = *law;
  Real value = 0;
  const std::string_view why = fault_of(found, value);
  if (!why.empty()) return refuse(why);
  const std::string bounds = fault_of_bounds(recipe, known->second, value);
  return bounds.empty() ? std::optional(found) : refuse(bounds);
}

enum class Run : std::uint8_t { forward, backward };

/// The numbers in the file of a control point of the curve of a contact, which may run backwards
/// and be closed; none if it has other control points.
std::vector<std::uint32_t> images_in_file(const nurbs::Curve& file, const nurbs::Curve& own,
                                          const std::vector<std::uint32_t>& images, Run run) {
  const bool backward = run == Run::backward;
  if (file.points.size() != own.points.size()) return {};
  const auto last = static_cast<std::uint32_t>(own.points.size() - 1);
  const Real near = 1e-9 * nurbs::bounding_ball(file.points).radius;
  for (std::uint32_t i = 0; i <= last; ++i) {
    const nurbs::Weighted &a = own.points[i], &b = file.points[backward ? last - i : i];
    if (glm::distance(a.point(), b.point()) > near || a.w != b.w) return {};
  }
  std::vector<std::uint32_t> all;
  for (const std::uint32_t i : images) all.push_back(backward ? last - i : i);
  return all;
}

/// The first surface joint that has the net on a side.
std::optional<BuiltFree> Search::find_side(const NetRecipe& net, BuiltFree found) const {
  const bool is_weight = found.variable.quantity == Quantity::weight_a;
  const std::string_view name = std::string_view(net.path).substr(net.path.find('/') + 1);
  for (std::uint32_t k = 0; k < in.built.surface_joints.size(); ++k) {
    const BuiltSurfaceJoint& joint = in.built.surface_joints[k];
    for (const bool of_b : {false, true}) {
      const ContactSurface& on = of_b ? joint.contact.on_b : joint.contact.on_a;
      const std::string& curve = of_b ? joint.curve_b : joint.curve_a;
      if (net.surface ? on.skin != net.surface->skin : !on.curve || curve != name) continue;
      DesignVariable& v = found.variable;
      v.quantity = is_weight ? (of_b ? Quantity::weight_b : Quantity::weight_a)
                             : (of_b ? Quantity::point_b : Quantity::point_a);
      found.law = k;
      Real value = 0;
      if (on.curve) {
        const nurbs::Curve &own = on.curve->curve(), &file = *net.curve;
        if (v.guide >= file.points.size()) return refuse("expected the number of a control point");
        const auto mirrored = static_cast<std::uint32_t>(file.points.size() - 1) - v.guide;
        found.images = images_in_file(file, own, images_of(own, v.guide), Run::forward);
        if (found.images.empty()) {
          v.guide = mirrored;
          found.images = images_in_file(file, own, images_of(own, v.guide), Run::backward);
        }
        if (found.images.empty()) return refuse("expected a curve with clamped ends");
        value = own.points[v.guide].w;
      }
      if (const std::string_view why = design_fault(joint.contact, v); !why.empty())
        return refuse(why);
      if (on.skin) {
        const nurbs::Surface& face = on.skin->face(static_cast<int>(v.face)).surface();
        found.images = images_of(face, v.guide), value = face.points[v.guide].w;
      }
      const std::string bounds = fault_of_bounds(recipe, v.quantity, value);
      return bounds.empty() ? std::optional(found) : refuse(bounds);
    }
  }
  return refuse("expected a surface or curve of a surface joint");
}

/// surfaces/NAME/points/I/J, surfaces/NAME/faces/F/weights/I/J, curves/NAME/points/I
std::optional<BuiltFree> Search::number_of_net() const {
  std::string_view path = recipe.of;
  const bool is_surface = path.starts_with("surfaces/");
  const auto last = number_in(take_last(path)), row = is_surface ? number_in(take_last(path)) : 0u;
  const std::string_view key = take_last(path);
  if (!last || !row || (key != "points" && key != "weights")) return refuse_form();
  BuiltFree found{{{}, key == "points" ? Quantity::point_a : Quantity::weight_a}};
  found.kind = ElementKind::surface_joint;
  std::string_view rest = path;
  const auto face = number_in(take_last(rest));
  const bool has_face = is_surface && face && take_last(rest) == "faces";
  if (has_face) path = rest, found.variable.face = *face;
  const auto net = std::find_if(in.nets.begin(), in.nets.end(),
                                [&](const NetRecipe& n) { return n.path == path; });
  if (net == in.nets.end()) {
    std::vector<std::string_view> names;
    for (const NetRecipe& n : in.nets) names.push_back(n.path);
    return refuse("expected in place of " + quoted_name(path) +
                  " a surface or curve of the scene by its name" + hint(path, names));
  }
  if (is_surface && !has_face && net->is_plain.size() > 1)
    return refuse("expected the number of a face: " +
                  quoted_name(std::string(path) + "/faces/0/" + std::string(key) + "/0/0"));
  if (found.variable.face >= net->is_plain.size() || !net->is_plain[found.variable.face])
    return refuse(
        "expected one of the type \"nurbs\", by its control points, that is neither moved nor "
        "scaled nor turned inside out");
  found.net = &*net, found.variable.guide = *last;
  if (!is_surface) return find_side(*net, std::move(found));
  const nurbs::Surface& own =
      net->surface->skin->face(static_cast<int>(found.variable.face)).surface();
  if (*row >= static_cast<std::uint32_t>(own.u.count()) ||
      *last >= static_cast<std::uint32_t>(own.v.count()))
    return refuse("expected a control point from 0/0 to " + std::to_string(own.u.count() - 1) +
                  "/" + std::to_string(own.v.count() - 1));
  found.variable.guide += *row * static_cast<std::uint32_t>(own.v.count());
  return find_side(*net, std::move(found));
}

}  // namespace

std::optional<BuiltFree> find_free(const FreeSource& in, const FreeRecipe& as_given,
                                   std::string& fault) {
  FreeRecipe recipe = as_given;
  // Of the quantities of one number these are lengths, or m/rad.
  for (const std::string_view key : {"/length", "/radius", "/pitch"})
    if (recipe.of.ends_with(key))
      for (std::optional<Real>* bound : {&recipe.least, &recipe.most})
        if (*bound) **bound *= recipe.length_unit;
  const Search search{in, recipe, fault};
  const bool is_net = recipe.of.starts_with("surfaces/") || recipe.of.starts_with("curves/");
  auto found = is_net ? search.number_of_net() : search.number_of_law();
  if (!found) return found;
  found->variable.least = recipe.least.value_or(found->variable.least);
  found->variable.most = recipe.most.value_or(found->variable.most);
  return found;
}

void check_free(const FreeSource& in, const std::vector<FreeRecipe>& all, BuildMessages& messages) {
  if (messages.errors() > 0) return;  // elements that could not be built are missing
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    std::string fault;
    if (!find_free(in, all[i], fault))
      messages.error({ElementKind::free, 0, i}, "of", std::move(fault));
  }
}

}  // namespace pantin::detail

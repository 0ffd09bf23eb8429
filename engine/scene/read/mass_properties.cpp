#include "engine/geometry/mass_properties.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/base/utf8.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/tessellate.hpp"
#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

// Radius of gyration of a point mass, m. Nothing exerts torque on it, so no motion depends on it.
constexpr Real kPointRadius = 0.01;

/// Whether a body has a mass and nothing else. Links of chains have joints at their ends, and
/// rotate.
bool is_point_mass(const Reader& from) {
  return from.accepts("motion") && from.has("mass") && !from.has("inertia") && !from.has("shape") &&
         !from.has("shapes");
}

std::vector<ShapeWithDensity> read_solids(const Reading& reading, const Reader& from,
                                          Motion motion) {
  // A chain names its materials link by link.
  const std::uint32_t material = from.accepts("material") ? read_material(reading, from, 0) : 0;
  const Real density = from.number("density");
  std::vector<NodeId> nodes = from.items("shapes");
  if (const NodeId one = from.find("shape"); one != kNoNode) nodes = {one};
  std::vector<ShapeWithDensity> solids;
  for (NodeId node : nodes)
    if (const auto solid = read_shape(reading, node, {material, density, motion}))
      solids.push_back(*solid);
  return solids;
}

/// Three principal moments or the six entries xx, yy, zz, xy, xz, yz of the tensor.
std::optional<Mat3> read_inertia(const Reader& from) {
  const NodeId node = from.find("inertia");
  if (node == kNoNode) return std::nullopt;
  Real e[6] = {1, 1, 1, 0, 0, 0};
  const std::uint32_t count = from.json[node].count;
  if (from.json[node].kind != JsonKind::array || (count != 3 && count != 6)) {
    from.diagnostics.error_value(
        node, "3 principal moments, or 6 entries xx, yy, zz, xy, xz, yz, in kg m^2");
    return std::nullopt;
  }
  if (!from.numbers_at(node, {e, count}, kAnyNumber)) return std::nullopt;
  const Mat3 tensor(e[0], e[3], e[4], e[3], e[1], e[5], e[4], e[5], e[2]);
  const Vec3 m = principal_inertia(tensor).moments;
  if (is_possible_inertia(m)) return tensor;
  from.diagnostics.error(node, "found principal moments " + written(m.x) + ", " + written(m.y) +
                                   ", " + written(m.z) +
                                   ", expected positive ones, each at most the sum of the others");
  return std::nullopt;
}

/// Whether a shape is a closed skin whose outer side faces inwards.
bool is_cavity(const ShapeWithDensity& solid) {
  const auto& surface = solid.shape.surface;
  return solid.shape.kind == ShapeKind::nurbs && surface && surface->model &&
         !surface->model->is_closed && nurbs::is_closed(*surface->skin);
}

/// Mass, centre and inertia from shapes and from the file; nothing if these are inconsistent.
std::optional<MassProperties> weigh(const Reader& from, const std::vector<ShapeWithDensity>& solids,
                                    Motion motion, std::size_t refused_before) {
  MassProperties whole;
  for (const ShapeWithDensity& s : solids)
    whole = combine(whole, mass_properties(s.shape, s.density));
  if (from.has("mass")) {
    const Real mass = from.number("mass", 1);
    if (whole.mass > 0) whole.inertia *= mass / whole.mass;
    whole.mass = mass;
  }
  whole.centre = from.vec("centre_of_mass", whole.centre);
  if (const auto inertia = read_inertia(from)) whole.inertia = *inertia;
  if (motion != Motion::dynamic) return whole;
  if (solids.empty() && !from.has("shape") && !from.has("shapes")) {
    if (from.need("mass") == kNoNode) return std::nullopt;
    if (is_point_mass(from))
      whole.inertia = Mat3(whole.mass * kPointRadius * kPointRadius);
    else if (from.need("inertia") == kNoNode)
      return std::nullopt;
  }
  const Vec3 moments = principal_inertia(whole.inertia).moments;
  if (whole.mass > 0 && std::isfinite(whole.mass) && is_possible_inertia(moments)) return whole;
  if (from.diagnostics.error_count() == refused_before)
    from.error("found a mass of " + written(whole.mass) +
               " kg, expected shapes with a finite mass above 0" +
               (std::ranges::any_of(solids, is_cavity)
                    ? ", or \"mass\" and \"inertia\": a closed skin whose outer side faces inwards "
                      "is the wall of a cavity"
                    : ""));
  return std::nullopt;
}

}  // namespace

std::uint32_t read_material(const Reading& reading, const Reader& from, std::uint32_t otherwise) {
  const NodeId node = from.find("material");
  if (node == kNoNode) return otherwise;
  return find_material(reading, node, otherwise);
}

std::uint32_t find_material(const Reading& reading, NodeId node, std::uint32_t otherwise) {
  const JsonNode& value = reading.json[node];
  const std::string_view name = value.kind == JsonKind::string ? value.text : "";
  if (const auto found = reading.material_of.find(name); found != reading.material_of.end())
    return found->second;
  std::vector<std::string_view> names;
  Hints& hints = reading.diagnostics.hints;
  for (std::size_t i = reading.first_material; i < reading.materials.size() && hints.any_left();
       ++i)
    names.push_back(reading.materials[i].name);
  reading.diagnostics.error_value(node, "the name of a material" + hints.of(name, names));
  return otherwise;
}

BodyMassProperties read_mass_properties(const Reading& reading, const Reader& from, Motion motion) {
  const std::size_t refused_before = from.diagnostics.error_count();
  const std::vector<ShapeWithDensity> solids = read_solids(reading, from, motion);
  BodyMassProperties mass_properties;
  for (const ShapeWithDensity& s : solids) mass_properties.shapes.push_back(s.shape);
  std::optional<MassProperties> whole = weigh(from, solids, motion, refused_before);
  if (!whole || !(whole->mass > 0)) return mass_properties;
  mass_properties.mass = whole->mass;
  mass_properties.is_point = motion == Motion::dynamic && is_point_mass(from);
  if (motion != Motion::dynamic) {
    // The moments about the frame's own axes are also those of a valid body.
    const Vec3 moments(whole->inertia[0][0], whole->inertia[1][1], whole->inertia[2][2]);
    if (is_possible_inertia(moments)) mass_properties.inertia = moments;
    return mass_properties;
  }
  round_off(*whole);
  const PrincipalInertia principal = principal_inertia(whole->inertia);
  mass_properties.inertia = principal.moments;
  mass_properties.centre = {whole->centre, principal.rotation};
  mass_properties.is_moved = whole->centre != Vec3(0) || principal.rotation != kIdentity;
  if (mass_properties.is_moved)
    for (Shape& s : mass_properties.shapes)
      s.local = compose(inverse(mass_properties.centre), s.local);
  return mass_properties;
}

}  // namespace pantin::detail

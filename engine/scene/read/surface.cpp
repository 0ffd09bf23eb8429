// Surfaces in lists, in shapes, and in files of their own.
#include <filesystem>

#include "engine/geometry/skin_model.hpp"
#include "engine/nurbs/check.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/scene/read/named.hpp"
#include "engine/scene/read/surface_words.hpp"

namespace pantin::detail {
namespace {

using SurfacePointer = std::shared_ptr<const Surface>;

constexpr Real kSureVolume = 1e-6;  // relative: smaller uncertainties of the volume are not
                                    // reported

/// The name of the skin in messages.
std::string called(const Reader& from) {
  const NodeId name = from.find("name");
  const bool is_named = name != kNoNode && from.json[name].kind == JsonKind::string;
  return is_named ? "surface \"" + std::string(from.json[name].text) + "\"" : "the surface";
}

/// Whether it is degenerate to a curve or a point.
bool has_no_area(const nurbs::Surface& s) {
  const Real size = nurbs::bounding_ball(s.points).radius;
  const nurbs::Range u = s.u.domain(), v = s.v.domain();
  constexpr int kProbes = 9;
  for (int i = 0; i < kProbes; ++i)
    for (int j = 0; j < kProbes; ++j) {
      const auto d = nurbs::evaluate(s, u.low + u.width() * (i + 0.5) / kProbes,
                                     v.low + v.width() * (j + 0.5) / kProbes, 1);
      const Real wide = glm::length(glm::cross(d[1][0], d[0][1])) * u.width() * v.width();
      if (wide > 1e-9 * size * size) return false;
    }
  return true;
}

/// Rejects faces that cannot be evaluated; warns of creases and singular points.
bool check_face(const Reading& reading, NodeId node, const nurbs::Surface& face,
                const std::string& name) {
  const std::vector<Error> errors = nurbs::errors_of(face, name);
  for (const Error& e : errors) reading.diagnostics.error(node, e.message);
  if (!errors.empty()) return false;
  if (has_no_area(face)) {
    reading.diagnostics.error(node, name + " is a curve or a point, expected a surface");
    return false;
  }
  for (const nurbs::Flaw& flaw : nurbs::flaws_of(face, name)) {
    if (flaw.kind == nurbs::FlawKind::crease)
      reading.diagnostics.warn(node, "crease",
                               flaw.text + " rad: a contact cannot roll over it smoothly");
    else if (flaw.kind == nurbs::FlawKind::singular_point ||
             flaw.kind == nurbs::FlawKind::degenerate_edge)
      reading.diagnostics.warn(node, "no normal", flaw.text + ": contacts there are lost");
  }
  return true;
}

/// A single sphere or ellipsoid in its original position, which needs no poles.
struct Charts {
  Vec3 radii{1};
  bool is_cavity = false;
};
std::optional<Charts> charts_of(const Reading& reading, const Reader& from,
                                const std::vector<NodeId>& faces) {
  constexpr std::string_view kMoving = "position rotation rotation_deg";
  if (faces.size() != 1 || from.has_any(kMoving)) return std::nullopt;
  if (reading.json[faces[0]].kind != JsonKind::object) return std::nullopt;
  const NodeId type = reading.json.member(faces[0], "type");
  const std::string_view word = type == kNoNode ? "" : reading.json[type].text;
  if (word != "sphere" && word != "ellipsoid") return std::nullopt;
  const Reader face = reading.open(faces[0], std::string(word) + "_face");
  if (face.has_any(kMoving) || face.has("trims")) return std::nullopt;
  const Vec3 radii = word == "sphere" ? Vec3(face.number("radius", 1)) : face.vec("radii", Vec3(1));
  return Charts{from.vec_or_number("scale") * face.vec_or_number("scale") * radii,
                from.flag("inside_out") != face.flag("inside_out")};
}

SurfacePointer made_of(const Reader& from, std::shared_ptr<const nurbs::Skin> skin) {
  SurfacePointer made = from.kept(make_skin(std::move(skin))).value_or(nullptr);
  if (made && made->model->doubt > kSureVolume)
    from.diagnostics.warn(
        from.node, "volume",
        called(from) + " folds so strongly that its volume is known only to a fraction of " +
            written(made->model->doubt) + ": give the mass and the inertia of its bodies");
  return made;
}

SurfacePointer surface_of_faces(const Reading& reading, const Reader& from) {
  const std::size_t refused_before = from.diagnostics.error_count();
  const std::vector<NodeId> nodes = from.items("faces");
  const Real tolerance = from.number("tolerance");
  const nurbs::Affine by = placing_of(from);
  const bool is_turned = from.flag("inside_out");
  if (const auto charts = charts_of(reading, from, nodes)) {
    if (from.diagnostics.error_count() != refused_before) return nullptr;
    return made_of(from, std::make_shared<nurbs::Skin>(
                             charts->is_cavity ? nurbs::Skin::ellipsoid_cavity(charts->radii)
                                               : nurbs::Skin::ellipsoid(charts->radii)));
  }
  std::vector<nurbs::Surface> faces;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    auto face = read_face(reading, nodes[i]);
    if (!face) continue;
    *face = nurbs::transformed(*face, by);
    if (is_turned) *face = turned(*face);
    const std::string name = called(from) + ", face " + std::to_string(i);
    if (check_face(reading, nodes[i], *face, name)) faces.push_back(std::move(*face));
  }
  if (from.diagnostics.error_count() != refused_before) return nullptr;
  if (faces.empty()) {
    if (from.has("faces") && nodes.empty()) from.error_value("faces", "at least one face");
    return nullptr;
  }
  return made_of(from, std::make_shared<nurbs::Skin>(std::move(faces), tolerance));
}

/// The surface of a file, unchanged; read once.
SurfacePointer surface_of_file(const Reading& reading, NodeId at, const std::string& name) {
  const std::string path = (std::filesystem::path(reading.folder) / name).string();
  SceneReading& scene = reading.scene;
  const auto [known, is_new] = scene.surfaces.try_emplace({ShapeKind::nurbs, path, 1.0});
  if (!is_new) {
    if (!known->second)
      reading.diagnostics.error_value(
          at, "another file: this one was refused above, or includes itself");
    return known->second;
  }
  SceneFile* opened = scene.files.open(path, reading.file, at);
  if (!opened || !opened->is_json()) return nullptr;
  const Reading inner = reading_of(scene, *opened);
  const SurfacePointer made = read_surface(inner, 0);
  return scene.surfaces[{ShapeKind::nurbs, path, 1.0}] = made;
}

/// The same, transformed if an object gives a position, rotation or scale besides the file.
SurfacePointer placed(const Reader& from, const SurfacePointer& surface) {
  if (!surface || !(from.has_any(kPlacing) || from.has("inside_out"))) return surface;
  std::vector<nurbs::Surface> faces;
  const nurbs::Skin& skin = *surface->skin;
  const nurbs::Affine by = placing_of(from);
  const bool is_turned = from.flag("inside_out");
  if (skin.half_axes()) {
    nurbs::Surface whole = nurbs::transformed(nurbs::ellipsoid({}, *skin.half_axes()), by);
    faces = {is_turned != skin.is_ellipsoid_cavity() ? nurbs::inside_out(whole) : whole};
  } else {
    for (const nurbs::Face& face : skin.faces()) {
      const nurbs::Surface moved = nurbs::transformed(face.surface(), by);
      faces.push_back(is_turned ? nurbs::inside_out(moved) : moved);
    }
  }
  return made_of(from, std::make_shared<nurbs::Skin>(std::move(faces), skin.tolerance()));
}

}  // namespace

nurbs::Affine placing_of(const Reader& from) {
  const Vec3 scale = from.vec_or_number("scale");
  nurbs::Affine by = nurbs::affine_of(from.pose());
  for (int k = 0; k < 3; ++k) by.linear[k] *= scale[k];
  return by;
}

nurbs::Surface turned(const nurbs::Surface& face) {
  return nurbs::errors_of(face, "").empty() ? nurbs::inside_out(face) : face;
}

SurfacePointer read_surface(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "surface");
  if (!from.is_object()) return nullptr;
  from.text("$schema", "");
  if (from.has("name")) from.name();
  if (!from.has("file")) return surface_of_faces(reading, from);
  const auto file = from.reference("file");
  return file ? placed(from, surface_of_file(reading, from.find("file"), *file)) : nullptr;
}

SurfacePointer read_skin(const Reading& reading, const Reader& shape) {
  const NodeId node = shape.find("surface");
  if (node == kNoNode) return nullptr;
  const JsonNode& value = reading.json[node];
  if (value.kind == JsonKind::object) return read_surface(reading, node);
  if (value.kind == JsonKind::string) {
    if (const auto known = reading.surface_of.find(value.text); known != reading.surface_of.end())
      return known->second;
    const std::string_view name = value.text;
    if (name.ends_with(".json") || name.ends_with(".json5") || name.ends_with(".jsonc"))
      return surface_of_file(reading, node, std::string(name));
  }
  refuse_unknown(reading, node, reading.surface_of,
                 "the name of a surface, a surface, or a file that ends in .json");
  return nullptr;
}

void read_surfaces(Reading& reading, const Reader& scene) {
  read_named(reading, scene.items("surfaces"), reading.surface_of, read_surface);
}

}  // namespace pantin::detail

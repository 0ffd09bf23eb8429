#include "engine/scene/read/surface_file.hpp"

#include "engine/geometry/surface.hpp"
#include "engine/scene/json/text_file.hpp"
#include "engine/scene/json/words.hpp"
#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

template <class Values, class Text>
std::string list_of(const Values& values, const Text& text) {
  std::string all = "[";
  for (const auto& value : values) all += (all.size() > 1 ? ", " : "") + text(value);
  return all + "]";
}

std::string numbers_text(const std::vector<Real>& values) { return list_of(values, number_text); }

std::string vector_text(Vec3 p) {
  return "[" + number_text(p.x) + ", " + number_text(p.y) + ", " + number_text(p.z) + "]";
}

/// Writes points and weights if their products are exact to the bit, else the products.
std::string net_text(const std::vector<nurbs::Weighted>& net) {
  bool is_exact = true, is_plain = true;
  for (const nurbs::Weighted& w : net) {
    is_exact = is_exact && nurbs::Weighted(w.point(), w.w) == w;
    is_plain = is_plain && w.w == 1;
  }
  if (!is_exact) {
    std::vector<Real> all;
    for (const nurbs::Weighted& w : net) all.insert(all.end(), {w.x, w.y, w.z, w.w});
    return "\"homogeneous\": " + numbers_text(all);
  }
  std::string text = "\"points\": " +
                     list_of(net, [](const nurbs::Weighted& w) { return vector_text(w.point()); });
  if (!is_plain)
    text += ",\n     \"weights\": " +
            list_of(net, [](const nurbs::Weighted& w) { return number_text(w.w); });
  return text;
}

std::string loop_text(const nurbs::Curve& c) {
  return "\n      {\"type\": \"nurbs\", \"degree\": " + std::to_string(c.knots.degree) +
         (c.knots.is_periodic ? ", \"periodic\": true" : "") +
         ",\n       \"knots\": " + numbers_text(c.knots.values) + ",\n       " +
         net_text(c.points) + "}";
}

std::string face_text(const nurbs::Surface& s) {
  std::string text = "    {\"type\": \"nurbs\", \"degrees\": [" + std::to_string(s.u.degree) +
                     ", " + std::to_string(s.v.degree) + "]";
  if (s.u.is_periodic) text += ", \"periodic_u\": true";
  if (s.v.is_periodic) text += ", \"periodic_v\": true";
  text += ",\n     \"knots_u\": " + numbers_text(s.u.values);
  text += ",\n     \"knots_v\": " + numbers_text(s.v.values);
  text += ",\n     " + net_text(s.points);
  if (s.trims.empty()) return text + "}";
  return text + ",\n     \"trims\": " + list_of(s.trims, loop_text) + "}";
}

}  // namespace

std::string surface_text(const nurbs::Skin& skin) {
  std::string text = "{\n";
  if (const auto& half = skin.half_axes())
    return text + "  \"faces\": [{\"type\": \"ellipsoid\", \"radii\": " + vector_text(*half) +
           "}]" + (skin.is_ellipsoid_cavity() ? ",\n  \"inside_out\": true\n}\n" : "\n}\n");
  text += "  \"tolerance\": " + number_text(skin.tolerance()) + ",\n  \"faces\": [\n";
  for (std::size_t i = 0; i < skin.faces().size(); ++i)
    text += face_text(skin.faces()[i].surface()) + (i + 1 < skin.faces().size() ? ",\n" : "\n");
  return text + "  ]\n}\n";
}

Result<LoadedSurface> load_surface(const std::string& path) {
  const SceneLimits limits;
  auto text = read_text(path, limits.bytes, "a file of a surface");
  if (!text) return text.errors();
  SceneFiles files(limits);
  SceneFile& file = files.open(path, *text);
  LoadedSurface loaded;
  if (file.is_json()) {
    JsonPlaces places(files);
    Recipe recipe;
    SceneReading whole{recipe, files, places, limits, Poll(limits.is_cancelled)};
    const Reading reading = reading_of(whole, file);
    loaded.surface = read_surface(reading, 0);
  }
  if (files.any_errors()) return files.errors();
  loaded.warnings = files.warnings();
  return loaded;
}

}  // namespace pantin::detail

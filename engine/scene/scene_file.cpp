#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "engine/scene/assembly.hpp"
#include "engine/scene/scene.hpp"

namespace pantin {
namespace {

std::string too_long(std::string_view name, std::size_t most) {
  return std::string(name) + ": found more than " + std::to_string(most) +
         " bytes, expected a scene file";
}

/// The whole of a file, or one line that says why not.
Result<std::string> read_text(const std::string& path, std::size_t most) {
  std::error_code trouble;
  if (std::filesystem::is_directory(path, trouble))
    return Error{path + ": found a directory, expected a scene file"};
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return Error{path + ": found no file to read (" + std::strerror(errno ? errno : EIO) +
                 "), expected a scene file"};
  std::string text;
  // In pieces, so that a device without an end is noticed.
  constexpr std::size_t kPiece = 1u << 16;
  while (file && text.size() <= most) {
    const std::size_t before = text.size();
    text.resize(before + kPiece);
    file.read(text.data() + before, static_cast<std::streamsize>(kPiece));
    text.resize(before + static_cast<std::size_t>(file.gcount()));
  }
  if (text.size() > most) return Error{too_long(path, most)};
  if (file.bad()) return Error{path + ": found an error while reading, expected a scene file"};
  return text;
}

}  // namespace

void build_world(const Assembly& assembly, World& world) {
  std::vector<Entity> entities;
  entities.reserve(assembly.bodies.size());
  for (const PlacedBody& b : assembly.bodies) {
    const Entity e = world.add_body(b.body, b.name);
    entities.push_back(e);
    if (b.matter->is_moved) world.origins.add(e, inverse(b.matter->centre));
    if (!b.matter->shapes.empty()) {
      Shapes& shapes = world.shapes.add(e, {b.matter->shapes});
      if (b.material != UINT32_MAX)
        for (Shape& s : shapes.parts) s.material = b.material;
    }
    if (b.solver) world.settings.add(e, *b.solver);
  }
  Entity ground;  // one body for all that is tied to the world
  const auto entity = [&](std::uint32_t body) {
    if (body != kWorldBody) return entities[body];
    if (ground) return ground;
    Body fixed;
    fixed.motion = Motion::fixed;
    return ground = world.add_body(fixed, "world");
  };
  for (const PlacedJoint& j : assembly.joints) {
    const Entity a = entity(j.a), b = entity(j.b);
    world.add_link(a, b, j.joint, j.name);
  }
  for (const PlacedString& s : assembly.strings) {
    const Entity a = entity(s.a), b = entity(s.b);
    world.add_string(a, b, s.joint, s.name);
  }
  for (const PlacedPin& p : assembly.pins) {
    Pin pin = p.pin;
    pin.body = entities[p.body];
    world.add_pin(pin, p.name);
  }
  for (const PlacedDrive& d : assembly.drives) world.drives.add(entities[d.body], d.drive);
}

Result<Scene> parse_scene(std::string_view text, std::string_view name, const SceneLimits& limits) {
  if (text.size() > limits.bytes) return Error{too_long(name, limits.bytes)};
  const JsonDocument json = parse_json(text, {limits.values, limits.depth});
  Complaints complaints(json, std::string(name));
  const bool is_json = std::none_of(json.faults.begin(), json.faults.end(),
                                    [](const JsonFault& f) { return f.node == kNoNode; });
  if (!is_json) return complaints.errors();

  Recipe recipe = read_recipe(json, complaints, limits);
  const Assembly assembly = assemble(recipe, json, complaints, limits);
  if (complaints.any_errors()) return complaints.errors();
  warn_of_structure(assembly, complaints);
  Scene scene = std::move(recipe.scene);
  build_world(assembly, scene.world);
  if (scene.title.empty()) scene.title = std::filesystem::path(name).stem().string();
  scene.warnings = complaints.warnings();
  return scene;
}

Result<Scene> load_scene(const std::string& path, const SceneLimits& limits) {
  const Result<std::string> text = read_text(path, limits.bytes);
  if (!text) return text.errors();
  return parse_scene(*text, path, limits);
}

}  // namespace pantin

#include "engine/render/palette.hpp"

#include <charconv>
#include <optional>
#include <string_view>

namespace pantin::detail {
namespace {

/// From 8-bit sRGB [IEC 61966-2-1].
Vec3 linear(int red, int green, int blue) {
  const auto part = [](int value) {
    const Real x = value / 255.0;
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
  };
  return {part(red), part(green), part(blue)};
}

bool is_unset(const Material& m) { return m.name.empty() && m.colour == Material{}.colour; }

constexpr Real kShade = 0.5;  // of every other link of a chain

/// The number at the end of a name after a slash.
std::optional<std::uint32_t> link_number(std::string_view name) {
  const auto slash = name.rfind('/');
  std::uint32_t number = 0;
  if (slash == std::string_view::npos || slash + 1 == name.size()) return std::nullopt;
  const char* end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + slash + 1, end, number);
  return read.ec == std::errc() && read.ptr == end ? std::optional(number) : std::nullopt;
}

Vec3 colour_of(const World& world, Entity body) {
  // The links of a chain are consecutive entities.
  const auto link = link_number(world.name_of(body)).value_or(0);
  const std::uint32_t first = body.index >= link ? body.index - link : body.index;
  return (link % 2 == 0 ? 1 : kShade) * kPalette[first % kPalette.size()];
}

}  // namespace

const std::array<Vec3, 7> kPalette = {
    linear(0, 114, 178),    // blue
    linear(230, 159, 0),    // orange
    linear(0, 158, 115),    // bluish green
    linear(204, 121, 167),  // reddish purple
    linear(86, 180, 233),   // sky blue
    linear(213, 94, 0),     // vermilion
    linear(240, 228, 66)    // yellow
};

Material drawn_material(const PosedWorld& scene, std::uint32_t slot, std::uint32_t material) {
  const World& world = scene.world;
  Material drawn;
  if (slot < scene.colours.size()) {
    drawn.colour = scene.colours[slot];
    return drawn;
  }
  // Material 0 of a World is the one of shapes that name none.
  const bool known = material < world.materials.size();
  if (known && !(material == 0 && is_unset(world.materials[0]))) return world.materials[material];
  if (world.bodies.values()[slot].motion != Motion::fixed)
    drawn.colour = colour_of(world, world.bodies.owners()[slot]);
  return drawn;
}

}  // namespace pantin::detail

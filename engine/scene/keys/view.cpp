// Keys of the appearance of a scene: materials, camera, light, ground and pictures.
#include <cmath>
#include <limits>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;

constexpr Range kOpening{1, 170, "an angle from 1 to 170 degrees"};
constexpr Range kStrength{0, 1000, "a number from 0 to 1000"};
constexpr Range kLit{0, 100, "a number from 0 to 100"};
constexpr Range kPixels{16, 16384, "a whole number of pixels from 16 to 16384"};
constexpr Range kRate{0, 1000, "a number of frames per second above 0, at most 1000", true};

template <auto... path>
constexpr Key colour(Text name, const Range& range, Text about) {
  return row<path...>(name, ValueType::colour, "", about).within(range).without_default();
}

constexpr Key kSurface[] = {
    needed_name<&Material::name>(),
    colour<&Material::colour>("colour", kUnit, "Default a light grey.").once("color"),
    number<&Material::roughness>("roughness", "", kUnit, "0 is a mirror, 1 is matt."),
    number<&Material::metallic>("metallic", "", kUnit, "0 or 1."),
};

constexpr Key kCamera[] = {
    vector<&Camera::eye>("eye", "m", "Position of the eye.").without_default(),
    vector<&Camera::target>("target", "m", "Point that it looks at; not the eye.")
        .without_default(),
    number<&Camera::field_of_view>("field_of_view_deg", "degrees", kOpening,
                                   "Vertical field of view. Default 40.1."),
    flag<&Camera::automatic>("automatic",
                             "Fit the whole scene, in the direction from eye to target. Default: "
                             "true unless both are given.")
        .without_default(),
};

constexpr Key kLight[] = {
    direction<&Light::direction>("direction", "Direction of the sunlight.").without_default(),
    colour<&Light::colour>("colour", kLit, "Of the sun.").once("color"),
    number<&Light::strength>("strength", "", kStrength, "Of the sun."),
    colour<&Light::sky>("sky", kLit, "Light from above."),
    colour<&Light::ground>("ground", kLit, "Light from below."),
};

constexpr Key kGround[] = {
    flag<&View::ground>("visible", "Draw it."),
    number<&View::ground_height>("height", "m", kAnyNumber,
                                 "Height of the ground. Default: that of a fixed plane, else 0, or "
                                 "below everything.")
        .without_default(),
};

bool read_size(const RowValue& row, OutputDefaults& output) {
  Real size[2];
  if (!row.from.numbers(row.key.name, size)) return true;
  output.width = static_cast<int>(size[0]), output.height = static_cast<int>(size[1]);
  if (output.width != size[0] || output.height != size[1])
    row.from.error_value(row.key.name, "whole numbers of pixels");
  return true;
}

constexpr Key kOutput[] = {
    row<read_size>("size", ValueType::wholes, "pixels", "Width and height.")
        .holding(2)
        .within(kPixels)
        .or_else(1280, 720, 0),
    number<&OutputDefaults::fps>("fps", "", kRate, "Frames per second."),
};

}  // namespace

constinit const KeySet keys::material{"material", "A surface.", kSurface};
constinit const KeySet keys::camera{"camera", "A camera.", kCamera};
constinit const KeySet keys::light{"light", "Sun and sky.", kLight};
constinit const KeySet keys::ground{"ground", "The ground grid.", kGround};
constinit const KeySet keys::output{"output", "Picture defaults.", kOutput};

bool read_members(const Reading& reading, const Reader& from, Camera& camera) {
  // A view with both eye and target given is not framed automatically.
  camera.automatic = !(from.has("eye") && from.has("target"));
  read_rows(reading, from, camera);
  if (camera.eye == camera.target)
    from.error("found the eye at the target, expected two different places");
  return true;
}

/// A height that is not given follows from the World when pictures are made.
bool read_ground(const RowValue& row, View& view) {
  view.ground_height = std::numeric_limits<Real>::quiet_NaN();
  if (!row.is_there()) return true;
  const JsonNode& value = row.from.json[row.node()];
  if (value.kind == JsonKind::boolean)
    view.ground = value.boolean;
  else
    read_rows(row.reading, row.reading.open(row.node(), "ground"), view);
  return true;
}

}  // namespace pantin::detail

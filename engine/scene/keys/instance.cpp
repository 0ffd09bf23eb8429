// Keys of instances of prefabs, and of generators that expand to many objects.
#include <cmath>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using I = InstanceRecipe;
using G = GridRecipe;

constexpr Range kCopies{1, 1e6, "a whole number from 1 to 1000000"};
constexpr std::string_view kAxes[] = {"x", "y", "z"};

constexpr Key kOfPrefab =
    needed_reference<&I::prefab>("prefab", "the name of a prefab", "Name of a prefab.");
constexpr Key kItsSolver =
    object<&I::solver>("solver", "solver", "Solver settings for all its islands.");
constexpr Key kItsWorld = reference<&I::world>("world", "the name of a body",
                                               "Name of a body outside: what the prefab ties to "
                                               "\"world\" is tied to that body, where both are "
                                               "at the start. Default: the fixed world.");
constexpr Key kMirrored =
    word<&I::mirror>("mirror", kAxes,
                     "Mirror the prefab across the plane through its origin normal to this axis. "
                     "Names with a side change it. Default: not mirrored.");

constexpr Key kTimeOffset = number<&I::time_offset>(
    "time_offset", "s", kTime,
    "The paths and drives of each copy run ahead of those of the previous copy by this time.");

constexpr Key kInstance[] = {
    needed_name<&I::name>(),
    kOfPrefab,
    kParent.to<&I::parent>(),
    kPosition.to<&I::pose>(),
    kRotation,
    kRotationDeg,
    kItsWorld,
    kMirrored,
    number<&I::time_offset>("time_offset", "s", kTime,
                            "Its paths and drives run ahead by this time."),
    kItsSolver,
};

constexpr Key kGenerated[] = {
    objects("chains", "chain", "Chains of equal links."),
    objects("grids", "grid", "Prefabs in rows."),
    objects("rings", "ring", "Prefabs around an axis."),
    objects("stairs", "stairs", "Flights of steps."),
    objects("mirrors", "mirror", "Left and right: bodies copied across a plane."),
};

constexpr Key kMirror[] = {
    row<&MirrorRecipe::bodies>(
        "bodies", ValueType::references, "",
        "Names of bodies of this scene or prefab, or of chains, instances and grids: all their "
        "bodies. Each name has a side: \"left\" or \"right\" in it, or \"l\" or \"r\" as in "
        "\"arm_l\"; the image has the other.")
        .needed("the names of the bodies"),
    word<&MirrorRecipe::plane, &MirrorPlane::axis>(
        "axis", kAxes, "Normal of the plane, in the frame of the scene or prefab."),
    number<&MirrorRecipe::plane, &MirrorPlane::offset>("offset", "m", kAnyNumber,
                                                       "Position of the plane along that axis."),
};

bool read_count(const RowValue& row, GridRecipe& grid) {
  Real n[3] = {0, 0, 0};
  if (!row.from.numbers(row.key.name, n)) return true;
  for (std::size_t i = 0; i < 3; ++i) {
    if (n[i] != std::floor(n[i])) row.from.error_value(row.key.name, "whole numbers");
    grid.count[i] = static_cast<int>(n[i]);
  }
  return true;
}

constexpr Key kGrid[] = {
    needed_name<&I::name>(),
    kOfPrefab,
    row<read_count>("count", ValueType::wholes, "",
                    "Copies along x, y and z; they are called \"name/0\", \"name/1\", ..., x "
                    "first, then z, then y.")
        .holding(3)
        .within(kCopies)
        .needed("how many copies along x, y and z"),
    vector<&G::spacing>("spacing", "m", "Between neighbours along x, y and z."),
    kParent.to<&I::parent>(),
    vector<&I::pose>("position", "m", "Where the grid's middle is.").or_else(0),
    kRotation,
    kRotationDeg,
    kItsWorld,
    kMirrored,
    kTimeOffset,
    kItsSolver,
};

bool read_ring_count(const RowValue& row, GridRecipe& ring) {
  ring.is_ring = true;
  ring.count[0] = row.from.whole(row.key.name, 1);
  return true;
}

bool read_ring_angle(const RowValue& row, GridRecipe& ring) {
  ring.angle = row.from.number(row.key.name);
  return true;
}

constexpr Key kRing[] = {
    needed_name<&I::name>(),
    kOfPrefab,
    whole<read_ring_count>("count", 1, 1'000'000,
                           "Number of copies; they are called \"name/0\", \"name/1\", ...")
        .needed("how many copies"),
    direction<&G::axis>("axis", "Through the position."),
    angle_deg<read_ring_angle>(
        "angle_deg", "From the first copy to the last; 360: evenly around the whole circle.")
        .or_else(360),
    vector<&G::arm>("arm", "m", "From the axis to the origin of the first copy."),
    kParent.to<&I::parent>(),
    vector<&I::pose>("position", "m", "A point of the axis.").or_else(0),
    kRotation,
    kRotationDeg,
    kItsWorld,
    kMirrored,
    kTimeOffset,
    kItsSolver,
};

/// A flight of steps.
struct Stairs {
  int count = 1;
  Real width = 1, rise = 1, run = 1;  // m
};
constexpr Key kStairs[] = {
    needed_name<&BodyRecipe::name>(),
    whole<&Stairs::count>("count", 1, 10'000, "Number of steps.").needed("a number of steps"),
    number<&Stairs::width>("width", "m", kSize, "Along z.").needed(kSize.words),
    number<&Stairs::rise>("rise", "m", kSize, "Height of one step.").needed(kSize.words),
    number<&Stairs::run>("run", "m", kSize, "Depth of one step.").needed(kSize.words),
    kPosition.to<&BodyRecipe::pose>(),
    kRotation,
    kRotationDeg,
    kMaterial,
    of_object("collision", ValueType::object_or_flag, "collision",
              "Default: it collides, with the settings of the scene."),
};

}  // namespace

constinit const KeySet keys::instance{"instance", "A copy of a prefab.", kInstance};
constinit const KeySet keys::generators{"generators", "Generators of many bodies.", kGenerated};
constinit const KeySet keys::grid{"grid", "Copies of a prefab in rows.", kGrid};
constinit const KeySet keys::ring{"ring", "Copies of a prefab around an axis, rotated with it.",
                                  kRing};
constinit const KeySet keys::stairs{
    "stairs",
    "A fixed body of steps that rise along its x axis, as wide along z. Its origin is the middle "
    "of the first step's lower front edge; every step reaches down to the floor.",
    kStairs};
constinit const KeySet keys::mirror{
    "mirror",
    "Mirrors bodies across a plane, with all joints, cables, pins and gears that tie them to each "
    "other, to the world or to bodies without an image: left becomes right. The image of a hinge "
    "rotates the mirrored way through the same angles.",
    kMirror};

bool read_members(const Reading& reading, const Reader& from, InstanceRecipe& instance) {
  read_rows(reading, from, instance);
  return true;  // even without its prefab, so that its name is known
}

bool read_members(const Reading& reading, const Reader& from, GridRecipe& grid) {
  read_rows(reading, from, grid);
  return read_members(reading, from, grid.each);
}

BodyRecipe read_stairs(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "stairs");
  BodyRecipe body;
  if (!from.is_object()) return body;
  Stairs stairs;
  read_rows(reading, from, stairs), read_rows(reading, from, body);
  body.body.motion = Motion::fixed;
  const std::uint32_t material = read_material(reading, from, 0);
  // Each step reaches down to the floor, so that nothing slips under it.
  for (int i = 0; i < stairs.count; ++i) {
    Shape step{ShapeKind::box, 0.5 * Vec3(stairs.run, (i + 1) * stairs.rise, stairs.width), {}};
    step.local.position = {(i + 0.5) * stairs.run, step.size.y, 0};
    step.material = material;
    body.mass_properties.shapes.push_back(step);
  }
  body.collision = read_collision(reading, from, reading.collision.value_or(Collision{}));
  for (std::string_view key : {"count", "width", "rise", "run"})
    if (!from.has(key)) body.name.clear();
  return body;
}

}  // namespace pantin::detail

// The marks of the debug view: ranges of joints, muscles, pins and contacts.
#include "engine/render/marks.hpp"

#include "engine/base/rotation.hpp"
#include "engine/contact/contact.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/render/frame.hpp"
#include "tests/render/pictures.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

constexpr int kWidth = 480, kHeight = 270;
constexpr Real kArm = 0.5;  // m, from the joint to the middle of body b

/// Two grey capsules tied at (0, 1, 0): a above it, b turned by `rotation` from pointing downwards.
struct Stage {
  World world;
  View view;
  Entity link;
  Quat rotation;

  Stage(const Joint& like, Quat rotated) : rotation(rotated) {
    world.materials = {{"grey", {0.3, 0.3, 0.3}, 0.6, 0}};
    view.camera = {{0, 1, 3.5}, {0, 1, 0}, 0.7, false};
    view.ground = false;
    const Entity a = body({{0, 1 + kArm, 0}, kIdentity});
    const Entity b = body({Vec3{0, 1, 0} + rotation * Vec3{0, -kArm, 0}, rotation});
    Joint joint = like;
    joint.anchor_a = {0, -kArm, 0}, joint.anchor_b = {0, kArm, 0};
    link = world.create();
    world.links.add(link, {a, b, joint});
  }
  Entity body(const Pose& pose) {
    const Entity e = world.create();
    Body made;
    made.pose = pose;
    world.bodies.add(e, made);
    Shape shape;
    shape.kind = ShapeKind::capsule;
    shape.size = {0.05, 0.4, 0};
    world.shapes.add(e, Shapes{{shape}});
    return e;
  }
  Image draw() {
    Image image;
    Overlay overlay;
    overlay.joints = true;
    if (auto renderer = renderer_or_skip({kWidth, kHeight, 4, true, GlPath::automatic}))
      renderer->draw({.world = world, .view = view, .overlay = &overlay}, image);
    return image;
  }
  /// Pixels near a place that look like a mark of this colour.
  int count(const Image& image, Vec3 place, Vec3 colour, int reach = 6) const {
    const Vec3 p = make_eye(view.camera, kWidth, kHeight).project(place);
    const auto byte = [](Real c) { return static_cast<int>(std::lround(255 * c)); };
    const Pixel wanted{byte(colour.x), byte(colour.y), byte(colour.z)};
    int found = 0;
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const int px = static_cast<int>(p.x) + x, py = static_cast<int>(p.y) + y;
        if (px < 0 || py < 0 || px >= kWidth || py >= kHeight) continue;
        found += difference(pixel(image, px, py), wanted) < 60;
      }
    return found;
  }
};

/// How large marks are at the joint of a Stage, m.
Real size_of(const Stage& s) {
  const Font font;
  OverlayList list(font);
  const Eye eye = make_eye(s.view.camera, kWidth, kHeight);
  const Pen pen(list, eye);
  return mark_size({s.world, {}}, *s.world.links.find(s.link), {0, 1, 0}, pen);
}

const Vec3 kAt{0, 1, 0};

/// A hinge about z, which looks at the eye.
Joint hinge(Real low, Real high) {
  Joint joint;
  joint.kind = JointKind::hinge;
  joint.frames.set(from_rotation_vector({0, -kPi / 2, 0}),
                   from_rotation_vector({0, -kPi / 2, 0}));  // x becomes z
  joint.limits.edit().angle = {true, low, high};
  return joint;
}

/// A ball joint whose x points down the limb.
Joint ball(Real y, Real z) {
  Joint joint;
  joint.frames.set(from_rotation_vector({0, 0, -kPi / 2}),
                   from_rotation_vector({0, 0, -kPi / 2}));  // x becomes -y
  joint.limits.edit().swing = {true, y, z};
  return joint;
}

}  // namespace

TEST_CASE("a hinge within its range is marked in one colour, at its stop in the warning colour") {
  const Quat rotated = from_rotation_vector({0, 0, 0.6});
  for (const bool at_stop : {false, true}) {
    Stage s(hinge(-0.2, at_stop ? 0.6 : 1.2), rotated);
    const Image image = s.draw();
    if (image.rgba.empty()) return;
    const Vec3 tip = kAt + size_of(s) * (rotated * Vec3{0, -1, 0});
    CHECK((s.count(image, tip, ink::kWarning) > 8) == at_stop);
    CHECK((s.count(image, tip, ink::kRange) > 8) == !at_stop);
  }
}

TEST_CASE("the sector of a hinge runs from its lowest to its highest angle") {
  Stage s(hinge(-0.2, 1.2), from_rotation_vector({0, 0, 0.6}));
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  const auto rim = [&](Real angle) {
    return kAt + size_of(s) * (from_rotation_vector({0, 0, angle}) * Vec3{0, -1, 0});
  };
  for (Real angle : {-0.19, 0.2, 0.9, 1.19}) CHECK(s.count(image, rim(angle), ink::kRange, 3) > 1);
  for (Real angle : {-0.6, 1.6, 2.5}) CHECK(s.count(image, rim(angle), ink::kRange, 3) == 0);
}

TEST_CASE("a cone is drawn to its half angles and turns to the warning colour at its rim") {
  // Seen along z, swings about the joint's z show their full angle.
  for (const bool at_stop : {false, true}) {
    const Real swing = at_stop ? 0.5 : 0.1;
    Stage s(ball(0.8, 0.5), from_rotation_vector({0, 0, swing}));
    const Image image = s.draw();
    if (image.rgba.empty()) return;
    const Real size = size_of(s);
    const Vec3 colour = at_stop ? ink::kWarning : ink::kRange;
    const Vec3 other = at_stop ? ink::kRange : ink::kWarning;
    for (Real side : {-0.5, 0.5}) {
      const Vec3 rim = kAt + size * (from_rotation_vector({0, 0, side}) * Vec3{0, -1, 0});
      CHECK(s.count(image, rim, colour, 4) > 2);
      CHECK(s.count(image, rim, other, 4) == 0);
    }
    const Vec3 tip = kAt + size * (s.rotation * Vec3{0, -1, 0});
    CHECK(s.count(image, tip, colour) > 8);
  }
}

TEST_CASE("the arc of a twist turns to the warning colour where the twist is at its stop") {
  for (const bool at_stop : {false, true}) {
    Joint joint = ball(0.8, 0.8);
    joint.limits.edit().angle = {true, -0.4, at_stop ? 0.3 : 0.9};
    Stage s(joint, from_rotation_vector({0, -0.3, 0}));  // x points down: twists by 0.3
    s.view.camera = {{0, -2, 1.2}, {0, 1, 0}, 0.7, false};
    const Image image = s.draw();
    if (image.rgba.empty()) return;
    const Vec3 end = kAt + Vec3{0, -1.2 * size_of(s), 0};
    CHECK((s.count(image, end, ink::kWarning, 14) > 8) == at_stop);
  }
}

TEST_CASE("locked joints carry a square, hinges without limits only their axis") {
  Joint joint;
  joint.kind = JointKind::fixed;
  Stage fixed(joint, kIdentity);
  const Image locked = fixed.draw();
  if (locked.rgba.empty()) return;
  CHECK(fixed.count(locked, kAt, ink::kLocked) > 8);

  Joint free = hinge(0, 0);
  free.limits.edit().angle.on = false;
  free.frames.set(kIdentity, kIdentity);  // about x, across the picture
  Stage s(free, kIdentity);
  const Image image = s.draw();
  CHECK(s.count(image, kAt, ink::kRange, 40) == 0);
  CHECK(s.count(image, kAt + Vec3{0.4 * size_of(s), 0, 0}, ink::kHinge, 4) > 3);
}

TEST_CASE("a slider is marked along its axis, in the warning colour at the end of its travel") {
  for (JointKind kind : {JointKind::prismatic, JointKind::cylindrical, JointKind::screw})
    for (const bool at_stop : {false, true}) {
      Joint joint;
      joint.kind = kind;  // along x, across the picture
      joint.parameters.edit().travel = {true, at_stop ? 0.0 : -0.3, 0.3};
      Stage s(joint, kIdentity);
      const Image image = s.draw();
      if (image.rgba.empty()) return;
      CHECK(s.count(image, kAt + Vec3{0.15, 0, 0}, ink::kTie, 4) > 3);
      CHECK(s.count(image, kAt + Vec3{0.45, 0, 0}, ink::kTie, 4) == 0);
      CHECK(s.count(image, kAt + Vec3{0.3, 0, 0}, at_stop ? ink::kWarning : ink::kRange, 5) > 3);
      CHECK(s.count(image, kAt + Vec3{0.3, 0, 0}, at_stop ? ink::kRange : ink::kWarning, 5) == 0);
    }
}

TEST_CASE("a distance is a line from anchor to anchor, a spring a zigzag about it") {
  for (JointKind kind : {JointKind::distance, JointKind::spring}) {
    Joint joint;
    joint.kind = kind;
    Stage s(joint, kIdentity);
    s.world.links.find(s.link)->joint.anchor_a = {0.5, -0.5, 0};
    s.world.links.find(s.link)->joint.anchor_b = {-0.5, 0.5, 0};
    const Image image = s.draw();
    if (image.rgba.empty()) return;
    for (Real x : {-0.4, 0.4}) CHECK(s.count(image, kAt + Vec3{x, 0, 0}, ink::kTie, 4) > 3);
    int aside = 0;
    for (Real x = -0.3; x <= 0.3; x += 0.01)
      aside += s.count(image, kAt + Vec3{x, 0.03, 0}, ink::kTie, 0);
    CHECK((aside > 2) == (kind == JointKind::spring));
  }
}

TEST_CASE("a muscle's arrow grows with its torque and is in the warning colour when capped") {
  const auto marked = [](Real torque, bool capped, Vec3 colour) {
    Stage s(hinge(-3, 3), kIdentity);
    JointDrive drive;
    drive.target = from_rotation_vector({1, 0, 0});
    drive.stiffness = 10, drive.max_torque = 20;
    drive.torque = torque, drive.capped = capped;
    s.world.joint_drives.add(s.link, drive);
    const Image image = s.draw();
    return image.rgba.empty() ? -1 : s.count(image, kAt, colour, 30);
  };
  const int weak = marked(2, false, ink::kMuscle);
  if (weak < 0) return;
  CHECK(weak > 3);
  CHECK(marked(15, false, ink::kMuscle) > 2 * weak);
  CHECK(marked(20, true, ink::kMuscle) == 0);
  CHECK(marked(20, true, ink::kWarning) > 20);
}

TEST_CASE("a contact is a dot with a line along its force, and a cross where it slides") {
  Stage s(Joint{}, kIdentity);
  const Vec3 at{0.4, 0.8, 0};
  Contact contact;
  contact.slot_a = 1;
  contact.point_a = to_local(s.world.bodies.values()[1].pose, at);
  contact.active = true;
  contact.normal = {1, 0, 0}, contact.friction = 0.5;
  contact.force = {20, 0, 0};
  contacts_of(s.world).push_back(contact);
  const Image sticks = s.draw();
  if (sticks.rgba.empty()) return;
  CHECK(s.count(sticks, at, ink::kContact, 4) > 8);
  CHECK(s.count(sticks, at + Vec3{0.2, 0, 0}, ink::kContact, 4) > 5);  // about its weight
  CHECK(s.count(sticks, at - Vec3{0.2, 0, 0}, ink::kContact, 4) == 0);
  CHECK(s.count(sticks, at, ink::kSlide) == 0);
  contacts_of(s.world)[0].force = {20, 10, 0};
  CHECK(s.count(s.draw(), at, ink::kSlide) > 3);
  contacts_of(s.world)[0].active = false;
  CHECK(s.count(s.draw(), at + Vec3{0.2, 0, 0}, ink::kContact, 8) == 0);
}

TEST_CASE("a pin to another body runs to a point of that body, in the warning colour if missed") {
  Stage s(Joint{}, kIdentity);
  const Entity other = s.body({{1, 1, 0}, from_rotation_vector({0, 0, kPi / 2})});
  Pin pin;
  pin.body = s.world.bodies.owners()[1];
  pin.to = other;
  pin.target = {0.2, 0, 0};  // above the middle of `other`, in the world
  s.world.pins.add(s.world.create(), pin);
  const Vec3 target{1, 1.2, 0};
  const Image held = s.draw();
  if (held.rgba.empty()) return;
  CHECK(s.count(held, target, ink::kPin) > 5);
  s.world.pins.values()[0].reachable = false;
  const Image missed = s.draw();
  CHECK(s.count(missed, target, ink::kPin) == 0);
  CHECK(s.count(missed, target, ink::kWarning) > 5);
}

TEST_CASE(
    "flat, full and locked ranges, bodies that are gone and lost poses still give a picture") {
  Joint flat = ball(0, 0.5), full = ball(kPi, kPi), wound = hinge(-9, 9), none = ball(0, 0);
  full.limits.edit().angle = {true, -kPi, kPi}, none.limits.edit().angle = {true, 0.1, 0.1};
  for (const Joint& joint : {flat, full, wound, none}) {
    Stage s(joint, from_rotation_vector({0, 0, 0.2}));
    JointDrive drive;
    s.world.joint_drives.add(s.link, drive);
    const Image image = s.draw();
    if (image.rgba.empty()) return;
    CHECK(s.count(image, kAt, ink::kWarning, 40) == 0);
    Contact contact;
    contact.slot_a = 77;
    contacts_of(s.world).push_back(contact);
    s.world.bodies.values()[1].pose.position.x = std::nan("");
    CHECK_FALSE(s.draw().rgba.empty());
    s.world.bodies.remove(s.world.bodies.owners()[1]);
    CHECK_FALSE(s.draw().rgba.empty());
  }
}

TEST_CASE("the legend names the marks that the world can show, and no others") {
  const auto names = [](const World& world, const char* word) {
    for (const LegendEntry& entry : overlay_legend(world))
      if (entry.text.find(word) != std::string::npos) return true;
    return false;
  };
  World empty;
  CHECK(overlay_legend(empty).empty());
  Stage s(hinge(0, 1), kIdentity);
  for (const char* word : {"joint", "hinge", "range", "stop"}) CHECK(names(s.world, word));
  for (const char* word : {"pin", "drive", "contact", "locked"}) CHECK_FALSE(names(s.world, word));
  for (const char* word : {"translation", "distance", "spring"}) CHECK_FALSE(names(s.world, word));
  Joint& joint = s.world.links.find(s.link)->joint;
  joint.kind = JointKind::prismatic;
  CHECK(names(s.world, "translation"));
  joint.kind = JointKind::spring;
  CHECK(names(s.world, "spring"));
  s.world.joint_drives.add(s.link, {});
  s.world.collisions.add(s.world.bodies.owners()[0], {});
  for (const char* word : {"drive", "maximum torque", "contact", "sliding"})
    CHECK(names(s.world, word));
}

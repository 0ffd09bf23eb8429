#include "engine/render/eye.hpp"
#include "engine/render/frame.hpp"
#include "engine/world/ties.hpp"
#include "tests/render/pictures.hpp"
#include "tests/render/puppet.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

constexpr int kWidth = 320, kHeight = 180;
const Quat kOnItsSide = glm::angleAxis(Real(kPi / 2), Vec3{0, 0, 1});

View plain_view() {
  View view;
  view.camera = {{0, 1, 4}, {0, 1, 0}, 0.7, false};
  return view;
}

struct Stage {
  World world;
  View view = plain_view();
  PuppetMaker make{world};
  RenderOptions options{kWidth, kHeight, 4, true, GlPath::automatic};

  Stage() { world.materials = puppet_materials(); }

  Entity ball(Vec3 at, Real radius, std::uint32_t material, Motion motion = Motion::dynamic) {
    return make.body({at, kIdentity}, {{ShapeKind::sphere, {radius, 0, 0}, {}, material}}, motion);
  }
  Vec3 project(Vec3 world_point) const {
    return make_eye(view.camera, kWidth, kHeight).project(world_point);
  }
  Pixel at(const Image& image, Vec3 world_point) const {
    const Vec3 p = project(world_point);
    return pixel(image, static_cast<int>(p.x), static_cast<int>(p.y));
  }
  /// Empty where there is no OpenGL.
  Image draw(const Overlay& overlay = {}, std::span<const Pose> poses = {}) {
    Image image;
    if (auto renderer = renderer_or_skip(options))
      renderer->draw({world, poses, view, &overlay}, image);
    return image;
  }
};

bool is_red(Pixel p) { return p.r > 2 * p.g && p.r > 2 * p.b && p.r > 40; }
bool is_blue(Pixel p) { return p.b > 2 * p.r && p.b > p.g && p.b > 40; }

}  // namespace

TEST_CASE("bodies are seen in their colours where they project to, nearer ones before farther") {
  Stage s;
  s.ball({-0.6, 1.2, 0}, 0.2, kShirt);
  s.ball({0.6, 1.2, 0}, 0.2, kTrousers, Motion::fixed);
  s.ball({0.6, 1.2, -1}, 0.5, kShirt, Motion::kinematic);
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  CHECK(is_red(s.at(image, {-0.6, 1.2, 0.2})));
  CHECK(is_blue(s.at(image, {0.6, 1.2, 0.2})));
  CHECK(is_red(s.at(image, {0.6, 1.6, -1})));     // the farther one, beside the nearer
  CHECK_FALSE(is_red(s.at(image, {0, 1.2, 0})));  // between them
}

TEST_CASE("the top row of the picture is the sky, the bottom row the ground") {
  Stage s;
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  REQUIRE(image.width == kWidth);
  REQUIRE(image.height == kHeight);
  REQUIRE(image.rgba.size() == 4u * kWidth * kHeight);
  const Pixel sky = pixel(image, 160, 0), ground = pixel(image, 160, kHeight - 1);
  CHECK(sky.b > sky.r + 8);
  CHECK(std::abs(ground.b - ground.r) < 8);
  CHECK(sky.sum() > ground.sum());
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) REQUIRE(image.rgba[i] == 255);

  s.view.ground = false;
  const Image bare = s.draw();
  CHECK(difference(pixel(bare, 160, kHeight - 1), ground) > 30);
  CHECK(difference(pixel(bare, 160, 0), sky) == 0);
}

TEST_CASE("the ground shows tiles nearby and one colour far away") {
  Stage s;
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  const auto spread = [&](int row) {
    int low = 255, high = 0;
    for (int x = 0; x < kWidth; ++x) {
      low = std::min(low, pixel(image, x, row).g), high = std::max(high, pixel(image, x, row).g);
    }
    return high - low;
  };
  CHECK(spread(kHeight - 10) > 12);
  CHECK(spread(kHeight / 2 + 2) < 4);  // just below the horizon
}

TEST_CASE("a body darkens the ground where its shadow falls, and only with shadows on") {
  Stage s;
  s.view.camera = {{0, 2.5, 4}, {0, 0.5, 0}, 0.7, false};
  s.view.light.direction = {-0.5, -1, 0};
  s.ball({0, 1, 0}, 0.2, kShirt);
  const Vec3 in_shadow{-0.5, 0, 0}, in_sun{0.5, 0, 0};
  const Image lit = s.draw();
  if (lit.rgba.empty()) return;
  s.options.shadows = false;
  const Image flat = s.draw();
  CHECK(s.at(lit, in_shadow).sum() < 0.75 * s.at(flat, in_shadow).sum());
  CHECK(difference(s.at(lit, in_sun), s.at(flat, in_sun)) <= 6);
}

TEST_CASE("a body stands in the shadow of another") {
  Stage s;
  s.view.light.direction = {0, -1, -0.3};
  s.ball({0, 0.5, 0}, 0.2, kPlain);
  const Vec3 top{0, 0.66, 0.12};
  const Image sunny = s.draw();
  if (sunny.rgba.empty()) return;
  s.make.body({{0, 1.6, 0.3}, kIdentity}, {{ShapeKind::box, {0.4, 0.02, 0.4}, {}, kWood}});
  const Image shaded = s.draw();
  CHECK(s.at(shaded, top).sum() < 0.75 * s.at(sunny, top).sum());
}

TEST_CASE("a foot on the ground darkens the ground around it without any sun") {
  Stage s;
  s.view.camera = {{0, 1, 2}, {0, 0, 0}, 0.7, false};
  s.view.light.strength = 0;
  s.ball({0, 0.2, 0}, 0.2, kPlain);
  s.ball({0.8, 5, 0}, 0.2, kPlain);
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  CHECK(s.at(image, {0.05, 0, 0.24}).sum() < 0.85 * s.at(image, {0.05, 0, 0.9}).sum());
}

TEST_CASE("the shade around boxes and capsules fades out, without an edge") {
  const Shape shapes[] = {{ShapeKind::box, {0.3, 0.3, 0.3}, {}, kShirt},
                          {ShapeKind::box, {0.6, 0.2, 0.3}, {}, kShirt},
                          {ShapeKind::capsule, {0.2, 0.5, 0}, {{0, 0, 0}, kOnItsSide}, kShirt}};
  for (const Shape& shape : shapes) {
    CAPTURE(static_cast<int>(shape.kind), shape.size.x);
    Stage s;
    s.view.camera = {{0, 3, 4}, {0, 0, 0}, 0.9, false};
    s.view.light.strength = 0;
    const Image bare = s.draw();
    if (bare.rgba.empty()) return;
    s.make.body({{0, 0.3, 0}, kIdentity}, {shape}, Motion::fixed);
    const Image image = s.draw();
    // How dark the ground is, by the bare ground's brightness; above 1 where there is the solid.
    const auto dark = [&](int x, int y) {
      const Pixel p = pixel(image, x, y);
      if (p.r > 1.3 * p.g) return 2.0;
      return static_cast<double>(p.sum()) / pixel(bare, x, y).sum();
    };
    double steepest = 0, darkest = 1;
    for (int y = 1; y < kHeight; ++y)
      for (int x = 3; x + 3 < kWidth; ++x) {
        bool solid = false;
        for (int k = -3; k <= 3; ++k)
          for (int j = -3; j <= 3 && !solid; ++j)
            solid = dark(x + k, std::clamp(y + j, 0, kHeight - 1)) > 1.5;
        if (solid) continue;
        darkest = std::min(darkest, dark(x, y));
        steepest = std::max({steepest, std::abs(dark(x, y) - dark(x - 1, y)),
                             std::abs(dark(x, y) - dark(x, y - 1))});
      }
    CHECK(darkest < 0.9);
    CHECK(steepest < 0.1);
  }
}

TEST_CASE("strings are seen at least a pixel wide, however far away") {
  for (Real away : {1.0, 10.0}) {
    Stage s;
    s.view.ground = false;
    s.view.camera = {{0, 1, 4 * away}, {0, 1, 0}, 0.7, false};
    const Entity a = s.ball({-0.5 * away, 1 + 0.9 * away, 0}, 0.02 * away, kWood);
    const Entity b = s.ball({0.4 * away, 1 - 0.9 * away, 0}, 0.02 * away, kWood);
    const Image bare = s.draw();
    if (bare.rgba.empty()) return;
    const Vec3 from = s.world.bodies[a].pose.position, to = s.world.bodies[b].pose.position;
    s.make.string(a, from, b, to);
    const Image strung = s.draw();
    int seen = 0;
    for (int i = 1; i < 20; ++i) {
      const Vec3 p = from + (to - from) * (i / 20.0);
      if (difference(s.at(strung, p), s.at(bare, p)) > 25) ++seen;
    }
    CHECK(seen == 19);
  }
}

TEST_CASE("strings, rods and belts whose ends are out of the picture are seen within it") {
  const bool is_upright = GENERATE(true, false);
  Stage s;
  s.view.ground = false;
  const Vec3 way = is_upright ? Vec3{0.1, 5, 0.2} : Vec3{5, 0.1, -1};
  const Vec3 from = Vec3{0, 1, 0} - way, to = Vec3{0, 1, 0} + way;
  const Entity a = s.ball(from, 0.02, kWood), b = s.ball(to, 0.02, kWood);
  const Image bare = s.draw();
  if (bare.rgba.empty()) return;
  const auto seen = [&](const Image& image) {
    int count = 0;
    for (int i = -9; i <= 9; ++i) {
      const Vec3 p = Vec3{0, 1, 0} + (is_upright ? 0.013 : 0.024) * Real(i) * way;
      if (difference(s.at(image, p), s.at(bare, p)) > 25) ++count;
    }
    return count;
  };
  SECTION("a string") {
    s.make.string(a, from, b, to);
    CHECK(seen(s.draw()) == 19);
  }
  SECTION("a string that comes from behind the eye") {
    s.view.camera = {Vec3{0, 1, 4}, {0, 1, 0}, 0.7, false};
    const Vec3 near{0.3, 1.2, 6}, far{-0.3, 0.8, -6};
    const Entity c = s.ball(near, 0.02, kWood), d = s.ball(far, 0.02, kWood);
    s.make.string(c, near, d, far);
    const Vec3 middle = 0.5 * (near + far);
    CHECK(difference(s.at(s.draw(), middle), s.at(bare, middle)) > 25);
  }
  SECTION("a rod") {
    const Vec3 y = glm::normalize(way);
    const Vec3 across = glm::cross(Vec3{0, 1, 0}, y);
    const Quat turn = glm::normalize(Quat(1 + y.y, across.x, across.y, across.z));
    s.make.body({{0, 1, 0}, turn}, {{ShapeKind::capsule, {0.01, 5, 0}, {}, kShirt}},
                Motion::dynamic);
    CHECK(seen(s.draw()) == 19);
  }
}

TEST_CASE("a belt is seen where its pulleys are out of the picture") {
  Stage s;
  s.view.ground = false;
  const Entity a = s.ball({-6, 1, 0}, 0.1, kWood), b = s.ball({6, 1, 0}, 0.1, kWood);
  s.view.camera = {{0, 1, 1}, {0, 1, 0}, 0.7, false};
  const Image bare = s.draw();
  if (bare.rgba.empty()) return;
  Belt belt;
  for (const Entity e : {a, b}) {
    belt.pulleys.emplace_back().body = e;
    belt.pulleys.back().outline.radius = 0.1;
  }
  belt.width = 0.05;
  const Pose poses[] = {s.world.bodies[a].pose, s.world.bodies[b].pose};
  REQUIRE(lay_belt(belt, poses));
  add_belt(s.world, belt);
  const Image image = s.draw();
  for (const Real y : {0.9, 1.1})
    for (const Real x : {-0.3, 0.0, 0.3}) {
      CAPTURE(x, y);
      CHECK(difference(s.at(image, {x, y, 0.02}), s.at(bare, {x, y, 0.02})) > 25);
    }
}

TEST_CASE("a rod that ends out of the picture throws its shadow into it") {
  Stage s;
  s.view.ground = true;
  s.view.light.direction = {0, -1, -0.2};
  s.view.camera = {{0, 1, 4}, {0, 0.1, 0}, 0.7, false};
  s.options.shadows = true;
  const Image bare = s.draw();
  if (bare.rgba.empty()) return;
  s.make.body({{0, 2.5, 0.5}, kOnItsSide}, {{ShapeKind::capsule, {0.06, 6, 0}, {}, kShirt}},
              Motion::dynamic);
  const Image image = s.draw();
  for (const Real x : {-0.5, 0.0, 0.5}) {
    const Pixel lit = s.at(bare, {x, 0, 0}), dark = s.at(image, {x, 0, 0});
    CHECK(dark.sum() < 0.8 * lit.sum());
  }
}

TEST_CASE("a slack string sags below the line between its ends") {
  Stage s;
  s.view.ground = false;
  const Entity a = s.ball({-0.6, 1.3, 0}, 0.02, kWood), b = s.ball({0.6, 1.3, 0}, 0.02, kWood);
  const Image bare = s.draw();
  if (bare.rgba.empty()) return;
  s.make.string(a, {-0.6, 1.3, 0}, b, {0.6, 1.3, 0}, 1.3);
  const Image slack = s.draw();
  const auto lowest_change = [&](int x) {
    for (int y = kHeight - 1; y >= 0; --y)
      if (difference(pixel(slack, x, y), pixel(bare, x, y)) > 25) return y;
    return -1;
  };
  // A parabola of this length sags by 0.393 of its 1.2 m span.
  CHECK(lowest_change(kWidth / 2) == Approx(s.project({0, 1.3 - 0.4, 0}).y).margin(4));
  CHECK(difference(s.at(slack, {0, 1.3, 0}), s.at(bare, {0, 1.3, 0})) == 0);
}

TEST_CASE("poses given to draw() replace those of the World") {
  Stage s;
  s.ball({0, 1, 0}, 0.2, kShirt);
  const Pose moved[] = {{{0.8, 1, 0}, kIdentity}};
  const Image image = s.draw({}, moved);
  if (image.rgba.empty()) return;
  CHECK(is_red(s.at(image, {0.8, 1, 0.2})));
  CHECK_FALSE(is_red(s.at(image, {0, 1, 0.2})));
}

TEST_CASE("a body under the ground is hidden, one through it is cut at the ground") {
  Stage s;
  s.view.camera = {{0, 1.5, 4}, {0, 0.3, 0}, 0.7, false};
  s.ball({-0.6, -0.5, 0}, 0.3, kShirt);
  s.ball({0.6, 0, 0}, 0.3, kShirt);
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  CHECK_FALSE(is_red(s.at(image, {-0.6, -0.5, 0})));
  CHECK(is_red(s.at(image, {0.6, 0.2, 0.15})));
  CHECK_FALSE(is_red(s.at(image, {0.6, -0.15, 0.2})));
}

TEST_CASE("outlines are smooth with samples and hard without") {
  Stage s;
  s.view.ground = false;
  s.ball({0, 1, 0}, 0.6, kShirt);
  const auto mixed = [&](const Image& image) {
    int count = 0;
    for (int x = 0; x < kWidth; ++x) {
      const Pixel p = pixel(image, x, kHeight / 2);
      const bool sky = p.b > p.r, red = is_red(p);
      if (!sky && !red) ++count;
    }
    return count;
  };
  const Image smooth = s.draw();
  if (smooth.rgba.empty()) return;
  s.options.samples = 1;
  const Image hard = s.draw();
  CHECK(mixed(hard) == 0);
  CHECK(compare(smooth, hard).off_part > 0.0005);
}

TEST_CASE("labels and legends lie on dark panels in the corners, in the colours of the legend") {
  Stage s;
  const Image bare = s.draw();
  if (bare.rgba.empty()) return;
  Overlay overlay;
  overlay.lines = {"Größe 2.3 m"};
  overlay.legend = {{{1, 0, 0}, "red"}, {{0, 0, 0.5}, "blue"}};
  const Image image = s.draw(overlay);
  int light = 0, dark = 0, red = 0, blue = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Pixel p = pixel(image, x, y);
      if (y < 40 && x < 120) light += p.sum() > 690, dark += p.sum() < 380;
      red += p.r == 255 && p.g == 0 && p.b == 0;
      blue += p.r == 0 && p.g == 0 && p.b == 188;
    }
  }
  CHECK(light > 30);
  CHECK(dark > 500);
  CHECK(red > 15);
  CHECK(blue > 15);
  for (int y = 60; y < 100; ++y) CHECK(difference(pixel(image, 250, y), pixel(bare, 250, y)) == 0);
}

TEST_CASE("the debug view marks joints, pins out of reach and slack strings before the bodies") {
  Stage s;
  s.view.ground = false;
  s.world = puppet_world();
  Pin pin;
  pin.body = s.world.bodies.owners()[0];
  pin.target = {1.2, 1.5, 0};
  pin.reachable = false;
  s.world.pins.add(s.world.create(), pin);
  const Image bare = s.draw();
  if (bare.rgba.empty()) return;
  Overlay overlay;
  overlay.joints = true;
  const Image marked = s.draw(overlay);
  const auto changed_near = [&](Vec3 place, int reach) {
    const Vec3 p = s.project(place);
    int count = 0;
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const int px = static_cast<int>(p.x) + x, py = static_cast<int>(p.y) + y;
        count += difference(pixel(marked, px, py), pixel(bare, px, py)) > 60;
      }
    return count;
  };
  CHECK(changed_near({0.075, 0.80, 0}, 6) > 10);  // hip, inside the bodies
  CHECK(changed_near({1.2, 1.5, 0}, 5) > 8);      // the cross at the pin's target
  CHECK(changed_near({0.7, 1.32, 0}, 3) > 3);     // the way to it
}

TEST_CASE("nothing to draw, bad poses and materials that do not exist still give a picture") {
  Stage s;
  const Image empty = s.draw();
  if (empty.rgba.empty()) return;
  const Entity lost = s.ball({0, 1, 0}, 0.2, kShirt);
  s.world.bodies[lost].pose.position.x = std::nan("");
  CHECK(s.draw().rgba == empty.rgba);
  s.ball({0, 1, 0}, 0.2, 999);
  const Image without = s.draw();
  CHECK(difference(s.at(without, {0, 1, 0.2}), s.at(empty, {0, 1, 0.2})) > 10);
  s.world.shapes.values().back().list[0].material = 0;
  s.world.materials = {Material{}};
  CHECK(s.draw().rgba == without.rgba);
}

TEST_CASE("sizes that no target can have are refused") {
  RenderOptions options;
  options.width = 0;
  auto none = Renderer::create(options);
  REQUIRE_FALSE(none);
  options.width = 1 << 20;
  CHECK_FALSE(Renderer::create(options));
}

TEST_CASE("the report names path, driver, samples and font") {
  RenderOptions options{64, 64, 4, true, GlPath::automatic};
  auto renderer = renderer_or_skip(options);
  if (!renderer) return;
  const GlReport& report = renderer->report();
  CHECK_FALSE(report.path.empty());
  CHECK_FALSE(report.renderer.empty());
  CHECK_FALSE(report.font.empty());
  CHECK((report.samples >= 1 && report.samples <= 4));
}

TEST_CASE("display colours follow the sRGB curve") {
  CHECK(srgb({0, 0.5, 1}).x == 0);
  CHECK(srgb({0, 0.5, 1}).y == Approx(0.7353569).epsilon(1e-6));
  CHECK(srgb({0, 0.5, 1}).z == Approx(1));
  CHECK(srgb({0.002, 0.002, 0.002}).x == Approx(0.02584));
}

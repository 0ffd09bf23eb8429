// Pictures of changing sizes, wireframes, forces.
#include "tests/render/pictures.hpp"
#include "tests/render/puppet.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

struct Set {
  World world;
  View view;
  PuppetMaker make{world};

  Set() {
    world.materials = puppet_materials();
    view.camera = {{0, 1, 4}, {0, 1, 0}, 0.7, false};
    make.body({{0, 1.2, 0}, kIdentity}, {{ShapeKind::sphere, {0.4, 0, 0}, {}, kShirt}},
              Motion::dynamic);
  }
};

std::size_t reds(const Image& image) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
    count += image.rgba[i] > 2 * image.rgba[i + 1] && image.rgba[i] > 40;
  return count;
}

}  // namespace

TEST_CASE("a renderer that was resized draws what one of that size draws") {
  const Set set;
  auto resized = renderer_or_skip({.width = 320, .height = 180});
  if (!resized) return;
  Image image, expected;
  const int sizes[][2]{{100, 160}, {320, 180}, {500, 90}, {640, 400}, {64, 64}};
  for (const auto& [width, height] : sizes) {
    REQUIRE(resized->resize(width, height));
    resized->draw({set.world, {}, set.view}, image);
    const auto fresh = renderer_or_skip({.width = width, .height = height});
    fresh->draw({set.world, {}, set.view}, expected);
    CHECK(image.width == width);
    CHECK(image.height == height);
    CHECK(image.rgba == expected.rgba);
  }
  CHECK(!resized->resize(0, 100));
  CHECK(!resized->resize(100, 1 << 24));
  resized->draw({set.world, {}, set.view}, image);
  CHECK(image.rgba == expected.rgba);  // a refusal changes nothing
}

TEST_CASE("a wireframe shows edges and what is behind them") {
  const Set set;
  auto renderer = renderer_or_skip({.width = 320, .height = 180});
  if (!renderer) return;
  Image solid, wires, again;
  renderer->draw({.world = set.world, .view = set.view}, solid);
  renderer->draw({.world = set.world, .view = set.view, .wireframe = true}, wires);
  renderer->draw({.world = set.world, .view = set.view}, again);
  CHECK(reds(wires) > reds(solid) / 20);
  CHECK(reds(wires) < reds(solid) * 2 / 3);
  CHECK(again.rgba == solid.rgba);
}

TEST_CASE("a force is an arrow from its point, longer the stronger it is") {
  const Set set;
  auto renderer = renderer_or_skip({.width = 320, .height = 180});
  if (!renderer) return;
  const auto changed = [&](const Overlay& overlay) {
    Image bare, image;
    renderer->draw({.world = set.world, .view = set.view}, bare);
    renderer->draw({.world = set.world, .view = set.view, .overlay = &overlay}, image);
    std::size_t count = 0;
    int right = 0;
    for (int y = 0; y < 180; ++y)
      for (int x = 0; x < 320; ++x) {
        const std::size_t at = 4 * static_cast<std::size_t>(320 * y + x);
        if (image.rgba[at] == bare.rgba[at] && image.rgba[at + 2] == bare.rgba[at + 2]) continue;
        ++count, right = std::max(right, x);
      }
    return std::pair(count, right);
  };
  const Real weight = 9.81 * set.world.bodies.values()[0].mass;
  Overlay weak, strong, none;
  weak.forces = {{{0, 1.8, 0}, {weight, 0, 0}}};
  strong.forces = {{{0, 1.8, 0}, {20 * weight, 0, 0}}};
  none.forces = {{{0, 1.8, 0}, {0, 0, 0}}};
  CHECK(changed(none).first == 0);
  const auto [small, near] = changed(weak);
  const auto [large, far] = changed(strong);
  CHECK(small > 10);
  CHECK(large > small);
  CHECK(near == Approx(160 + 18).margin(3));  // a weight is a tenth of the picture high
  CHECK(far > near + 18);
}

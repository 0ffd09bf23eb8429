#include "engine/render/strip.hpp"

#include <catch2/catch.hpp>

using namespace pantin;
using namespace pantin::detail;

namespace {

Image plain(int width, int height, std::uint8_t value) {
  Image image{width, height, {}};
  image.rgba.assign(static_cast<std::size_t>(4 * width * height), value);
  return image;
}

std::uint8_t at(const Image& image, int x, int y) {
  return image.rgba[static_cast<std::size_t>(4 * (y * image.width + x))];
}

}  // namespace

TEST_CASE("a strip shows its pictures from left to right and from top to bottom") {
  Strip strip(2, 2, 3, 5);
  for (int value : {10, 20, 30}) strip.add(plain(3, 5, static_cast<std::uint8_t>(value)));
  strip.add(plain(4, 5, 99));  // of another size: left out
  CHECK(strip.filled() == 3);
  const Image& image = strip.image();
  REQUIRE(image.width == 6);
  REQUIRE(image.height == 10);
  CHECK(at(image, 0, 0) == 10);
  CHECK(at(image, 2, 4) == 10);
  CHECK(at(image, 3, 0) == 20);
  CHECK(at(image, 5, 4) == 20);
  CHECK(at(image, 0, 5) == 30);
  CHECK(at(image, 2, 9) == 30);
  CHECK(at(image, 3, 5) == 255);  // still empty
}

TEST_CASE("a strip shows the first and the last frame and equal shares between") {
  const Strip strip(4, 1, 2, 2);
  CHECK(strip.frame_of(0, 91) == 0);
  CHECK(strip.frame_of(1, 91) == 30);
  CHECK(strip.frame_of(3, 91) == 90);
  CHECK(Strip(1, 1, 2, 2).frame_of(0, 91) == 0);
}

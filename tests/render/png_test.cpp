#include "engine/render/png.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "engine/render/capture.hpp"
#include "tests/base/random.hpp"
#include "tests/render/pictures.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

Image noise(int width, int height, bool opaque) {
  Image image{width, height, {}};
  test::Random dice(1);
  for (int i = 0; i < 4 * width * height; ++i) {
    const std::uint8_t drawn = dice.byte();
    image.rgba.push_back(opaque && i % 4 == 3 ? std::uint8_t(255) : drawn);
  }
  return image;
}

}  // namespace

TEST_CASE("a PNG gives its pixels back, opaque or not, at odd sizes") {
  PngEncoder encoder;
  for (auto [width, height] : {std::pair{1, 1}, {7, 3}, {64, 48}, {301, 5}, {2, 2}}) {
    for (bool opaque : {true, false}) {
      const Image image = noise(width, height, opaque);
      const auto bytes = encoder.encode(image);
      const Image back = decode_png({bytes.begin(), bytes.end()});
      CHECK(back.width == width);
      CHECK(back.height == height);
      CHECK(back.rgba == image.rgba);
      CHECK(bytes[25] == (opaque ? 2 : 6));  // colour type
    }
  }
}

TEST_CASE("a PNG says that its colours are sRGB") {
  const auto bytes = encode_png(noise(4, 4, true));
  const std::string text(bytes.begin(), bytes.end());
  CHECK(text.find("sRGB") != std::string::npos);
  CHECK(text.find("sRGB") < text.find("IDAT"));
}

TEST_CASE("a damaged PNG is noticed by its checksums") {
  auto bytes = encode_png(noise(16, 16, true));
  bytes[bytes.size() / 2] ^= 1;
  CHECK(decode_png(bytes).rgba.empty());
}

TEST_CASE("write_png replaces a file at once and leaves nothing beside it") {
  namespace fs = std::filesystem;
  const fs::path place = fs::temp_directory_path() / ("pantin-png-" + std::to_string(::getpid()));
  fs::create_directories(place);
  const std::string path = (place / "one.png").string();
  const Image first = noise(8, 8, true), second = noise(16, 4, true);
  REQUIRE(write_png(path, first));
  REQUIRE(write_png(path, second));
  CHECK(decode_png(read_file(path)).rgba == second.rgba);
  CHECK_FALSE(fs::exists(path + ".part"));

  const auto refused = write_png((place / "missing" / "one.png").string(), first);
  REQUIRE_FALSE(refused);
  CHECK(refused.errors().front().message ==
        (place / "missing" / "one.png").string() + ": No such file or directory");

  // A directory stands where the file should be: the rename fails and cleans up.
  fs::create_directories(place / "taken.png" / "inner");
  CHECK_FALSE(write_png((place / "taken.png").string(), first));
  CHECK_FALSE(fs::exists(place / "taken.png.part"));
  fs::remove_all(place);
}

// Triangles over a picture, ring buffers, names of files.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tools/pantin/view_files.hpp"
#include "tools/pantin/view_painter.hpp"
#include "tools/pantin/view_trace.hpp"

using namespace pantin;
using namespace pantin::program;

namespace {

constexpr std::uint8_t kFull[1]{255};
const InkAtlas kPlain{kFull, 1, 1};
constexpr std::uint32_t kWhite = 0xffffffff, kHalf = 0x80ffffff;

Image black(int width, int height) {
  Image image{width, height, {}};
  image.rgba.assign(static_cast<std::size_t>(4 * width * height), 0);
  return image;
}

std::uint8_t red(const Image& image, int x, int y) {
  return image.rgba[static_cast<std::size_t>(4 * (y * image.width + x))];
}

}  // namespace

TEST_CASE("a rectangle covers the pixels whose middles it holds, within the clip") {
  Image image = black(16, 16);
  const std::vector<InkVertex> v{
      {2, 3, 0, 0, kWhite}, {10, 3, 0, 0, kWhite}, {10, 12, 0, 0, kWhite}, {2, 12, 0, 0, kWhite}};
  const std::vector<std::uint16_t> i{0, 1, 2, 0, 2, 3};
  paint(image, {v, i, {4, 0, 100, 100}}, kPlain);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x)
      CHECK(red(image, x, y) == (x >= 4 && x < 10 && y >= 3 && y < 12 ? 255 : 0));
}

TEST_CASE("what hides all below it leaves its colour there, and the picture as opaque as it was") {
  const std::uint32_t ink = 0xff3c82c8;
  const std::vector<InkVertex> v{
      {1, 1, 0, 0, ink}, {7, 1, 0, 0, ink}, {7, 6, 0, 0, ink}, {1, 6, 0, 0, ink}};
  Image before = black(9, 9);
  for (std::size_t i = 0; i < before.rgba.size(); ++i)
    before.rgba[i] = static_cast<std::uint8_t>(3 * i);
  Image wanted = before;
  const std::uint8_t parts[]{0xc8, 0x82, 0x3c};
  for (std::size_t y = 1; y < 6; ++y)
    for (std::size_t x = 1; x < 7; ++x)
      std::copy_n(parts, 3, wanted.rgba.begin() + static_cast<std::ptrdiff_t>(4 * (9 * y + x)));
  // As a rectangle, and as two triangles.
  for (const std::vector<std::uint16_t>& i :
       {std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3}, {1, 2, 0, 0, 2, 3}}) {
    Image image = before;
    paint(image, {v, i, {0, 0, 9, 9}}, kPlain);
    CHECK(image.rgba == wanted.rgba);
  }
}

TEST_CASE("triangles that share edges cover each pixel once") {
  // A fan about a point that lies on no grid, half opaque: a pixel painted twice would be lighter.
  Image image = black(40, 40);
  std::vector<InkVertex> v{{19.3f, 20.7f, 0, 0, kHalf}};
  std::vector<std::uint16_t> i;
  constexpr int kSides = 11;
  for (int k = 0; k < kSides; ++k) {
    const float angle = 6.2831853f * static_cast<float>(k) / kSides;
    v.push_back({20 + 17 * std::cos(angle), 20 + 17 * std::sin(angle), 0, 0, kHalf});
  }
  for (std::uint16_t k = 0; k < kSides; ++k)
    i.insert(i.end(), {0, static_cast<std::uint16_t>(1 + k),
                       static_cast<std::uint16_t>(1 + (k + 1) % kSides)});
  paint(image, {v, i, {0, 0, 40, 40}}, kPlain);
  int covered = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      const int shade = red(image, x, y);
      CHECK((shade == 0 || shade == 128));
      covered += shade > 0;
    }
  const double area = 0.5 * kSides * 17 * 17 * std::sin(6.2831853 / kSides);
  CHECK(covered == Approx(area).epsilon(0.02));
}

TEST_CASE("what lies outside of the picture is left out, and nothing is no triangle") {
  Image image = black(8, 8);
  const std::vector<InkVertex> v{{-100, -100, 0, 0, kWhite},
                                 {200, -100, 0, 0, kWhite},
                                 {-100, 200, 0, 0, kWhite},
                                 {4, 4, 0, 0, kWhite}};
  const std::vector<std::uint16_t> one{0, 1, 2}, flat{3, 3, 3};
  paint(image, {v, flat, {0, 0, 8, 8}}, kPlain);
  CHECK(red(image, 4, 4) == 0);
  paint(image, {v, one, {-50, -50, 500, 500}}, kPlain);
  CHECK(red(image, 0, 0) == 255);
  CHECK(red(image, 7, 7) == 255);
}

TEST_CASE("a trace keeps the last steps in order") {
  Trace trace;
  for (std::size_t i = 0; i < 2 * Trace::kRoom + 7; ++i)
    trace.push({.time = static_cast<double>(i), .gap = i % 2 ? 1.0 : -1.0});
  REQUIRE(trace.size() == Trace::kRoom);
  for (std::size_t i = 0; i < trace.size(); ++i)
    CHECK(trace[i].time == static_cast<double>(Trace::kRoom + 7 + i));
  CHECK(trace.last().time == static_cast<double>(2 * Trace::kRoom + 6));
  const Span span = span_of(trace, &Sample::gap);
  CHECK(span.low == -1);
  CHECK(span.high == 1);
  trace.clear();
  CHECK(trace.size() == 0);
  CHECK(span_of(trace, &Sample::gap).high == 0);
}

TEST_CASE("the first name that is free is taken") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / "pantin_free_name";
  fs::create_directories(folder);
  std::ofstream(folder / "film_1.mp4") << "mine";
  CHECK(free_name(folder.string(), "film", ".mp4", 0) == (folder / "film_2.mp4").string());
  fs::remove_all(folder);
}

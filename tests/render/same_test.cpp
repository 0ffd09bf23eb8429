// Pictures repeat bit for bit, and the golden picture is met; seeded defects are told from it.
#include <unistd.h>

#include "engine/base/hash.hpp"
#include "engine/render/capture.hpp"
#include "tests/paths.hpp"
#include "tests/render/pictures.hpp"
#include "tests/render/puppet.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

const std::string kGolden = asset("../tests/render/golden/puppet.png");

struct Shot {
  RenderOptions options{640, 360, 4, true, GlPath::automatic};
  Real sway = 0;  // m, of the whole puppet
  bool cables = true;
};

View puppet_view() {
  View view;
  view.camera = {{1.0, 1.6, 4.2}, {0, 1.15, 0}, 0.6, false};
  return view;
}

/// Without text, whose letters depend on the fonts of the machine. Empty where there is no OpenGL.
Image shoot(const Shot& shot) {
  World world = puppet_world();
  for (Body& body : world.bodies.values()) body.pose.position.x += shot.sway;
  if (!shot.cables) world.cables = {};
  Image image;
  if (auto renderer = renderer_or_skip(shot.options))
    renderer->draw({.world = world, .view = puppet_view()}, image);
  return image;
}

std::string fingerprint(const Image& image) {
  Hash hash;
  hash.add(std::string_view(reinterpret_cast<const char*>(image.rgba.data()), image.rgba.size()));
  return std::to_string(hash.value());
}

std::string own_program() {
  std::string path(4096, 0);
  const ssize_t size = ::readlink("/proc/self/exe", path.data(), path.size());
  path.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return path;
}

/// The fingerprint that another process with this environment comes to.
std::string fingerprint_under(const std::string& environment) {
  const std::string command =
      environment + " '" + own_program() + "' '[.fingerprint]' 2>/dev/null | grep '^picture '";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return "no process";
  char line[128] = "";
  const bool read = std::fgets(line, sizeof line, pipe) != nullptr;
  ::pclose(pipe);
  std::string text = read ? std::string(line).substr(8) : "nothing";
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

}  // namespace

TEST_CASE("fingerprint of the picture, for other processes", "[.fingerprint]") {
  std::printf("picture %s\n", fingerprint(shoot({})).c_str());
  std::fflush(stdout);
}

TEST_CASE("the same world gives the same picture, in one renderer and in the next") {
  const World world = puppet_world();
  const Shot shot;
  auto renderer = renderer_or_skip(shot.options);
  if (!renderer) return;
  Image first, other, again;
  renderer->draw({.world = world, .view = puppet_view()}, first);
  World elsewhere = world;
  for (Body& body : elsewhere.bodies.values()) body.pose.position.x += 1;
  renderer->draw({.world = elsewhere, .view = puppet_view()}, other);
  renderer->draw({.world = world, .view = puppet_view()}, again);
  CHECK(first.rgba != other.rgba);
  CHECK(first.rgba == again.rgba);
  CHECK(first.rgba == shoot({}).rgba);
}

TEST_CASE("what is kept while the camera stands still does not show") {
  auto renderer = renderer_or_skip({160, 90, 4, true, GlPath::automatic});
  if (!renderer) return;
  World world = puppet_world();
  View view = puppet_view();
  Image kept, fresh;
  const auto same_as_fresh = [&](int width, int height) {
    auto other = renderer_or_skip({width, height, 4, true, GlPath::automatic});
    other->draw({.world = world, .view = view}, fresh);
    for (int picture = 0; picture < 3; ++picture) {  // drawn, kept, copied
      renderer->draw({.world = world, .view = view}, kept);
      if (kept.rgba != fresh.rgba) return false;
    }
    return true;
  };
  CHECK(same_as_fresh(160, 90));
  for (Body& body : world.bodies.values()) body.pose.position.x += 0.4;
  CHECK(same_as_fresh(160, 90));
  view.camera.eye.x += 0.1;
  CHECK(same_as_fresh(160, 90));
  view.ground_height -= 0.3;
  CHECK(same_as_fresh(160, 90));
  view.light.sky *= 0.7;
  CHECK(same_as_fresh(160, 90));
  REQUIRE(renderer->resize(120, 80));
  CHECK(same_as_fresh(120, 80));
  REQUIRE(renderer->resize(200, 100));  // larger than any before
  CHECK(same_as_fresh(200, 100));
  view.ground = false;
  CHECK(same_as_fresh(200, 100));
}

TEST_CASE("all paths to the same driver give the same picture") {
  Image first;
  std::string first_driver;
  for (GlPath path : {GlPath::surfaceless, GlPath::device, GlPath::osmesa}) {
    Shot shot;
    shot.options.path = path;
    auto renderer = Renderer::create(shot.options);
    if (!renderer) {
      WARN("not on this machine: " << renderer.errors().front().message);
      continue;
    }
    const std::string driver = (*renderer)->report().renderer + (*renderer)->report().version;
    Image image;
    (*renderer)->draw({.world = puppet_world(), .view = puppet_view()}, image);
    if (first.rgba.empty()) first = image, first_driver = driver;
    INFO((*renderer)->report().path << ": " << driver);
    if (driver == first_driver)
      CHECK(image.rgba == first.rgba);
    else
      WARN("another driver, not compared: " << driver);
  }
}

TEST_CASE("the number of threads of the software rasteriser does not show") {
  const Image here = shoot({});
  if (here.rgba.empty()) return;
  for (const char* environment : {"LP_NUM_THREADS=0", "LP_NUM_THREADS=1", "LP_NUM_THREADS=7",
                                  "PANTIN_GL=osmesa LP_NUM_THREADS=2"}) {
    INFO(environment);
    CHECK(fingerprint_under(environment) == fingerprint(here));
  }
}

// Made by: PANTIN_WRITE_GOLDEN=1 pantin_tests "the picture of the puppet is the golden one"
TEST_CASE("the picture of the puppet is the golden one") {
  const Shot shot;
  auto renderer = renderer_or_skip(shot.options);
  if (!renderer) return;
  Image image;
  renderer->draw({.world = puppet_world(), .view = puppet_view()}, image);
  if (std::getenv("PANTIN_WRITE_GOLDEN")) REQUIRE(write_png(kGolden, image));
  const Likeness like = compare(image, decode_png(read_file(kGolden)));
  INFO(renderer->report().renderer << ": PSNR " << like.psnr << " dB, part of pixels off "
                                   << like.off_part << ", worst tile " << like.worst_tile);
  if (renderer->report().renderer.find("llvmpipe") != std::string::npos) {
    CHECK(like.same());
  } else {  // another driver may place an edge elsewhere, but not draw another picture
    CHECK(like.psnr > 30);
    CHECK(like.worst_tile < 20);
  }
}

TEST_CASE("seeded defects are told from the picture") {
  const Image right = shoot({});
  if (right.rgba.empty()) return;
  CHECK(compare(right, right).same());
  Shot shot;
  SECTION("no shadows") { shot.options.shadows = false; }
  SECTION("no anti-aliasing") { shot.options.samples = 1; }
  SECTION("no strings") { shot.cables = false; }
  SECTION("a slip of two millimetres") { shot.sway = 0.002; }
  if (shot.options.shadows && shot.options.samples == 4 && shot.cables && shot.sway == 0) return;
  const Likeness like = compare(right, shoot(shot));
  INFO("PSNR " << like.psnr << " dB, part of pixels off " << like.off_part << ", worst tile "
               << like.worst_tile);
  CHECK_FALSE(like.same());
}

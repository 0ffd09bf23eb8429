// One picture of a ragdoll, without a window.
#include <cstdio>
#include <pantin/pantin.hpp>
#include <pantin/render.hpp>

using namespace pantin;

int main() {
  World world;
  must(build_ragdoll(world, {}));
  auto renderer = Renderer::create({.width = 320, .height = 240});
  if (!renderer) {  // no OpenGL on this machine
    std::printf("no picture: %s\n", renderer.errors().front().message.c_str());
    return 0;
  }
  Image image;
  (*renderer)->draw({.world = world}, image);
  must(write_png("ragdoll.png", image));
  std::printf("ragdoll.png, %d x %d\n", image.width, image.height);
}
// prints: ragdoll.png, 320 x 240|no picture:

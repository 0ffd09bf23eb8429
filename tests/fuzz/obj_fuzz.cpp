// An OBJ file, and the hull and the mesh made of it.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "engine/base/utf8.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/scene/read/obj.hpp"

using namespace pantin;
using namespace pantin::detail;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto mesh = parse_obj({reinterpret_cast<const char*>(data), size}, "fuzz.obj");
  if (!mesh) {
    if (mesh.errors().empty()) std::abort();
    for (const Error& e : mesh.errors())
      if (e.message != printable(e.message)) std::abort();
    return 0;
  }
  for (const auto& triangle : mesh->triangles)
    for (std::uint32_t corner : triangle)
      if (corner >= mesh->points.size()) std::abort();
  (void)make_mesh(mesh->points, mesh->triangles);
  (void)make_hull(mesh->points);
  return 0;
}

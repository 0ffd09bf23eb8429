#pragma once
/// GPU copies of surfaces: created when first drawn, kept as long as others hold the surface.
#include <memory>
#include <unordered_map>

#include "engine/geometry/shape.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/render/gl.hpp"

namespace pantin::detail {

/// A vertex array of positions, normals (attributes 0 and 1) and triangles. Attributes 2 to 5 are
/// enabled and advance per instance; the caller binds them to its instances.
struct StoredSurface {
  GLuint array = 0, vertices = 0, triangles = 0;
  GLsizei count = 0;  // indices, 32 bits each
};

class SurfaceStore {
 public:
  explicit SurfaceStore(const Gl& gl) : gl_(gl) {}
  SurfaceStore(const SurfaceStore&) = delete;
  SurfaceStore& operator=(const SurfaceStore&) = delete;

  /// The copy of a surface, with the normals of the shape that it approximates, if any. The context
  /// is current. Changes buffer and array bindings.
  const StoredSurface& stored(const std::shared_ptr<const Surface>& surface,
                              const Shape* smooth = nullptr);
  /// Releases surfaces that nobody else holds.
  void forget_unused();

 private:
  struct Entry {
    std::shared_ptr<const Surface> surface;  // owned, because its address is the key
    StoredSurface stored;
  };
  StoredSurface store(const Surface& surface, const Shape* smooth) const;

  const Gl& gl_;
  std::unordered_map<const Surface*, Entry> entries_;
};

}  // namespace pantin::detail

#pragma once
/// The card's copies of surfaces: made when first drawn, kept as long as anybody else holds them.
#include <memory>
#include <unordered_map>

#include "engine/geometry/shape.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/render/gl.hpp"

namespace pantin::detail {

/// A vertex array of positions, normals (attributes 0 and 1) and triangles. Attributes 2 to 5 are
/// on and advance once an instance; the caller points them at its instances.
struct StoredSurface {
  GLuint array = 0, vertices = 0, triangles = 0;
  GLsizei count = 0;  // indices, 32 bits each
};

class SurfaceStore {
 public:
  explicit SurfaceStore(const Gl& gl) : gl_(gl) {}
  SurfaceStore(const SurfaceStore&) = delete;
  SurfaceStore& operator=(const SurfaceStore&) = delete;

  /// The copy of a surface, with the normals of the shape that it stands for, if any; the context
  /// is current. Binds other buffers and arrays.
  const StoredSurface& stored(const std::shared_ptr<const Surface>& surface,
                              const Shape* smooth = nullptr);
  /// Lets go of surfaces that nobody else holds.
  void forget_unused();

 private:
  struct Entry {
    std::shared_ptr<const Surface> surface;  // held: its address names it
    StoredSurface stored;
  };
  StoredSurface store(const Surface& surface, const Shape* smooth) const;

  const Gl& gl_;
  std::unordered_map<const Surface*, Entry> entries_;
};

}  // namespace pantin::detail

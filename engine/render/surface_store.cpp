#include "engine/render/surface_store.hpp"

#include "engine/render/surface_mesh.hpp"

namespace pantin::detail {

StoredSurface SurfaceStore::store(const Surface& surface, const Shape* smooth) const {
  const SurfaceMesh mesh = make_surface_mesh(surface, smooth);
  StoredSurface made;
  made.count = static_cast<GLsizei>(mesh.indices.size());
  gl_.GenVertexArrays(1, &made.array);
  gl_.BindVertexArray(made.array);
  gl_.GenBuffers(1, &made.vertices);
  gl_.BindBuffer(GL_ARRAY_BUFFER, made.vertices);
  gl_.BufferData(GL_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(MeshVertex)),
                 mesh.vertices.data(), GL_STATIC_DRAW);
  const std::size_t offsets[] = {offsetof(MeshVertex, corner), offsetof(MeshVertex, normal)};
  for (GLuint index = 0; index < 2; ++index) {
    gl_.EnableVertexAttribArray(index);
    gl_.VertexAttribPointer(index, 3, GL_FLOAT, GL_FALSE, sizeof(MeshVertex),
                            reinterpret_cast<const void*>(offsets[index]));
  }
  gl_.GenBuffers(1, &made.triangles);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, made.triangles);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(std::uint32_t)),
                 mesh.indices.data(), GL_STATIC_DRAW);
  for (GLuint index = 2; index < 6; ++index) {
    gl_.EnableVertexAttribArray(index);
    gl_.VertexAttribDivisor(index, 1);
  }
  return made;
}

const StoredSurface& SurfaceStore::stored(const std::shared_ptr<const Surface>& surface,
                                          const Shape* smooth) {
  const auto [entry, is_new] = entries_.try_emplace(surface.get());
  if (is_new) entry->second = {surface, store(*surface, smooth)};
  return entry->second.stored;
}

void SurfaceStore::forget_unused() {
  for (auto it = entries_.begin(); it != entries_.end();) {
    if (it->second.surface.use_count() > 1) {
      ++it;
      continue;
    }
    const StoredSurface& gone = it->second.stored;
    const GLuint buffers[] = {gone.vertices, gone.triangles};
    gl_.DeleteBuffers(2, buffers);
    gl_.DeleteVertexArrays(1, &gone.array);
    it = entries_.erase(it);
  }
}

}  // namespace pantin::detail

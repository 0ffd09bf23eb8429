#pragma once
/// Reading and writing the tables of an island and the states of its bodies.
#include "engine/solvers/articulated/kernels.hpp"
#include "engine/solvers/articulated/kernels/vectors.hpp"

namespace pantin::detail::articulated {
namespace {

/// The block of a table that holds column i.
INLINE double* column(double* table, std::size_t rows, std::size_t i) {
  return table + i / kLanes * rows * kLanes + i % kLanes;
}
INLINE const double* column(const double* table, std::size_t rows, std::size_t i) {
  return table + i / kLanes * rows * kLanes + i % kLanes;
}

/// Children of a body, one after the other.
INLINE std::uint32_t first_child_of(const IslandView& p, std::size_t i) {
  if (!p.is_chain) return p.children[i].first;
  return i + 1 < p.count ? static_cast<std::uint32_t>(i + 1) : kNoChild;
}
INLINE std::uint32_t sibling_of(const IslandView& p, std::size_t i) {
  return p.is_chain ? kNoChild : p.children[i].sibling;
}

template <class T>
T read(const double* p);
template <>
INLINE double read<double>(const double* p) {
  return *p;
}
template <>
INLINE Four read<Four>(const double* p) {
  return load(p);
}
#ifdef PANTIN_HAS_EIGHT
template <>
INLINE Eight read<Eight>(const double* p) {
  return load_eight(p);
}
INLINE void write(double* p, Eight v) { store(p, v); }
#endif
INLINE void write(double* p, double v) { *p = v; }
INLINE void write(double* p, Four v) { store(p, v); }

/// Distance between rows of a table, in numbers.
template <class T>
inline constexpr std::size_t kStride = kNumbersIn<T> == 1 ? kLanes : kNumbersIn<T>;

/// Rows of a table at one column (T = double) or at a block of four (T = Four or Lane).
template <class T>
INLINE Vec<T> vec(const double* c, std::size_t row) {
  return {read<T>(c + row * kStride<T>), read<T>(c + (row + 1) * kStride<T>),
          read<T>(c + (row + 2) * kStride<T>)};
}
template <class T>
INLINE Qua<T> qua(const double* c, std::size_t row) {
  return {read<T>(c + row * kStride<T>), read<T>(c + (row + 1) * kStride<T>),
          read<T>(c + (row + 2) * kStride<T>), read<T>(c + (row + 3) * kStride<T>)};
}
template <class T>
INLINE Sym<T> sym(const double* c, std::size_t row) {
  return {read<T>(c + row * kStride<T>),       read<T>(c + (row + 1) * kStride<T>),
          read<T>(c + (row + 2) * kStride<T>), read<T>(c + (row + 3) * kStride<T>),
          read<T>(c + (row + 4) * kStride<T>), read<T>(c + (row + 5) * kStride<T>)};
}
template <class T>
INLINE T num(const double* c, std::size_t row) {
  return read<T>(c + row * kStride<T>);
}
template <class T>
INLINE void put(double* c, std::size_t row, Vec<T> v) {
  write(c + row * kStride<T>, v.x), write(c + (row + 1) * kStride<T>, v.y),
      write(c + (row + 2) * kStride<T>, v.z);
}
template <class T>
INLINE void put(double* c, std::size_t row, Qua<T> q) {
  write(c + row * kStride<T>, q.x), write(c + (row + 1) * kStride<T>, q.y),
      write(c + (row + 2) * kStride<T>, q.z), write(c + (row + 3) * kStride<T>, q.w);
}
template <class T>
INLINE void put(double* c, std::size_t row, Sym<T> m) {
  write(c + row * kStride<T>, m.xx), write(c + (row + 1) * kStride<T>, m.xy),
      write(c + (row + 2) * kStride<T>, m.xz), write(c + (row + 3) * kStride<T>, m.yy),
      write(c + (row + 4) * kStride<T>, m.yz), write(c + (row + 5) * kStride<T>, m.zz);
}

/// Gathers and scatters the state of four bodies.
struct FourBodies {
  double* b[4];
  FourBodies(const IslandView& p, std::size_t i) {
    for (int l = 0; l < 4; ++l)
      b[l] = p.bodies + p.slots[i + static_cast<std::size_t>(l)] * p.layout.stride;
  }
  INLINE Four num(std::size_t at) const { return Four{b[0][at], b[1][at], b[2][at], b[3][at]}; }
  INLINE Vec<Four> vec(std::size_t at) const { return {num(at), num(at + 1), num(at + 2)}; }
  INLINE Qua<Four> qua(std::size_t at) const {
    return {num(at), num(at + 1), num(at + 2), num(at + 3)};
  }
  INLINE void set(std::size_t at, Four v, std::size_t lanes) const {
    if (lanes == kLanes) {
      b[0][at] = v[0], b[1][at] = v[1], b[2][at] = v[2], b[3][at] = v[3];
      return;
    }
    for (std::size_t l = 0; l < lanes; ++l) b[l][at] = v[l];
  }
  INLINE void set(std::size_t at, Vec<Four> v, std::size_t lanes) const {
    set(at, v.x, lanes), set(at + 1, v.y, lanes), set(at + 2, v.z, lanes);
  }
};

/// Clears the state in padding columns.
INLINE void clear_padding(const IslandView& p) {
  for (std::size_t i = p.count; i % kLanes != 0; ++i)
    for (std::size_t row = 0; row < kMemoryRows; ++row)
      column(p.memory, kMemoryRows, i)[row * kLanes] = 0;
}

/// Multiplies v, in world axes, by a tensor of principal `moments`: the inertia or its inverse.
template <class F>
INLINE Vec<F> times_inertia(Qua<F> q, Vec<F> moments, Vec<F> v) {
  const Vec<F> b = rotated(back(q), v);
  return rotated(q, Vec<F>{moments.x * b.x, moments.y * b.y, moments.z * b.z});
}
INLINE Vec<Four> inverted(Vec<Four> m) { return {1.0 / m.x, 1.0 / m.y, 1.0 / m.z}; }

/// 1 for lanes below `count`, 0 for padding.
INLINE Four mask(std::size_t i, std::size_t count) {
  if (i + kLanes <= count) return all(1.0);
  Four m = all(1.0);
  for (std::size_t l = 0; l < kLanes; ++l)
    if (i + l >= count) m[l] = 0;
  return m;
}

}  // namespace
}  // namespace pantin::detail::articulated

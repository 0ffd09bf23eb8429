#pragma once
/// Rows of constraints in a plane, and the factors of J M^-1 J^T.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/math.hpp"

namespace pantin::detail::planar {

/// One scalar row on at most four bodies. Bodies with infinite mass count in the rate alone.
struct Row {
  std::uint8_t count = 0;
  std::array<std::uint32_t, 4> body{};
  std::array<Vec3, 4> j{};  // by x, y and the angle
  Real c = 0;               // m or rad
  Real rate = 0;            // m/s or rad/s: the J v that it demands
  Real soft = 0;            // compliance, added to its pivot

  /// Adds the Jacobian of a body; to any earlier one of the same body.
  void add(std::uint32_t on, Vec3 part);
  /// The Jacobian of a body; 0 where it has none.
  Vec3 part(std::uint32_t on) const {
    for (int i = 0; i < count; ++i)
      if (body[i] == on) return j[i];
    return Vec3(0);
  }
};

/// J v.
Real rate_of(const Row& row, std::span<const Vec3> velocities);
/// By how much J v is below what the row demands.
inline Real lack_of(const Row& row, std::span<const Vec3> velocities) {
  return row.rate - rate_of(row, velocities);
}

/// Inverse masses of a body along x, y and about z; zero for infinite mass.
using InverseMasses = std::span<const Vec3>;

/// A sparse L D L^T, or L D U of two kinds of rows. The bodies of the rows determine its pattern.
class Factor {
 public:
  bool fits(std::size_t rows) const { return built_ && order_.size() == rows; }
  /// Finds an order of least degree and the pattern. Allocates.
  void analyse(std::span<const Row> rows, InverseMasses masses);
  /// Drops dependent rows.
  void compute(std::span<const Row> rows, InverseMasses masses);
  /// Of J M^-1 K^T, where K are rows of the same bodies in another state; compliant rows are never
  /// dropped.
  void compute(std::span<const Row> rows, std::span<const Row> along, InverseMasses masses);

  /// In place.
  void solve(std::span<Real> x) const;

 private:
  bool built_ = false;
  std::vector<std::uint32_t> order_;   // rows, as they are eliminated
  std::vector<std::uint32_t> first_;   // of each column, in the lists below
  std::vector<std::uint32_t> column_;  // positions of its entries below the diagonal, ascending
  std::vector<std::uint32_t> target_;  // destinations of the products of its entries
  bool symmetric_ = true;
  std::vector<Real> value_, diagonal_;
  std::vector<Real> upper_;  // of the unsymmetric factor
  mutable std::vector<Real> work_;
};

}  // namespace pantin::detail::planar

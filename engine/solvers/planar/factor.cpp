#include "engine/solvers/planar/factor.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/base/check.hpp"

namespace pantin::detail::planar {
namespace {

constexpr Real kDependent = 1e-11;  // fraction of a pivot: the row depends on those before

/// J_a M^-1 J_b^T.
Real product(const Row& a, const Row& b, InverseMasses masses) {
  Real sum = 0;
  for (int i = 0; i < a.count; ++i)
    for (int k = 0; k < b.count; ++k)
      if (a.body[i] == b.body[k]) sum += glm::dot(a.j[i] * masses[a.body[i]], b.j[k]);
  return sum;
}

/// The rows that share a moved body with each row.
std::vector<std::set<std::uint32_t>> neighbours_of(std::span<const Row> rows,
                                                   InverseMasses masses) {
  std::vector<std::vector<std::uint32_t>> of_body(masses.size());
  for (std::uint32_t r = 0; r < rows.size(); ++r)
    for (int i = 0; i < rows[r].count; ++i)
      if (masses[rows[r].body[i]] != Vec3(0)) of_body[rows[r].body[i]].push_back(r);
  std::vector<std::set<std::uint32_t>> found(rows.size());
  for (const auto& list : of_body)
    for (const std::uint32_t a : list)
      for (const std::uint32_t b : list)
        if (a != b) found[a].insert(b);
  return found;
}

}  // namespace

void Row::add(std::uint32_t on, Vec3 part) {
  const auto at = std::find(body.begin(), body.begin() + count, on) - body.begin();
  PANTIN_ASSERT(at < count || static_cast<std::size_t>(count) < body.size());
  if (at == count) body[count] = on, j[count++] = Vec3(0);
  j[at] += part;
}

Real rate_of(const Row& row, std::span<const Vec3> velocities) {
  Real rate = 0;
  for (int i = 0; i < row.count; ++i) rate += glm::dot(row.j[i], velocities[row.body[i]]);
  return rate;
}

void Factor::analyse(std::span<const Row> rows, InverseMasses masses) {
  const auto n = static_cast<std::uint32_t>(rows.size());
  std::vector<std::set<std::uint32_t>> near = neighbours_of(rows, masses);
  std::set<std::pair<std::size_t, std::uint32_t>> left;
  for (std::uint32_t r = 0; r < n; ++r) left.insert({near[r].size(), r});
  order_.clear(), column_.clear(), target_.clear(), first_.assign(1, 0);
  std::vector<std::uint32_t> place(n);
  std::vector<std::vector<std::uint32_t>> columns;
  while (!left.empty()) {
    const std::uint32_t r = left.begin()->second;
    left.erase(left.begin());
    place[r] = static_cast<std::uint32_t>(order_.size());
    order_.push_back(r);
    columns.emplace_back(near[r].begin(), near[r].end());
    for (const std::uint32_t a : columns.back()) {
      left.erase({near[a].size(), a});
      near[a].erase(r);
      for (const std::uint32_t b : columns.back())
        if (a != b) near[a].insert(b);
      left.insert({near[a].size(), a});
    }
  }
  for (auto& column : columns) {
    for (std::uint32_t& r : column) r = place[r];
    std::sort(column.begin(), column.end());
    column_.insert(column_.end(), column.begin(), column.end());
    first_.push_back(static_cast<std::uint32_t>(column_.size()));
  }
  for (const auto& column : columns)
    for (std::size_t i = 0; i < column.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const auto from = column_.begin() + first_[column[k]];
        const auto to = column_.begin() + first_[column[k] + 1];
        target_.push_back(
            static_cast<std::uint32_t>(std::lower_bound(from, to, column[i]) - column_.begin()));
      }
  PANTIN_ASSERT(order_.size() == n && first_.back() == column_.size());
  value_.resize(column_.size()), diagonal_.resize(n), work_.resize(n);
  built_ = true;
}

void Factor::compute(std::span<const Row> rows, InverseMasses masses) {
  PANTIN_ASSERT(built_ && rows.size() == order_.size() && diagonal_.size() == rows.size());
  PANTIN_ASSERT(first_.size() == order_.size() + 1 && first_.back() == value_.size());
  symmetric_ = true;
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const Row& row = rows[order_[k]];
    work_[k] = diagonal_[k] = product(row, row, masses) + row.soft;
    for (std::uint32_t e = first_[k]; e < first_[k + 1]; ++e)
      value_[e] = product(row, rows[order_[column_[e]]], masses);
  }
  const std::uint32_t* target = target_.data();
  for (std::size_t k = 0; k < order_.size(); ++k) {
    // 0 stands for the inverse of a dropped pivot.
    const Real inverse = diagonal_[k] > kDependent * work_[k] ? 1 / diagonal_[k] : 0;
    for (std::uint32_t i = first_[k]; i < first_[k + 1]; ++i) {
      const Real part = value_[i] * inverse;
      for (std::uint32_t e = first_[k]; e < i; ++e) value_[*target++] -= part * value_[e];
      diagonal_[column_[i]] -= part * value_[i];
    }
    for (std::uint32_t e = first_[k]; e < first_[k + 1]; ++e) value_[e] *= inverse;
    diagonal_[k] = inverse;
  }
}

void Factor::compute(std::span<const Row> rows, std::span<const Row> along, InverseMasses masses) {
  PANTIN_ASSERT(built_ && rows.size() == order_.size() && along.size() == rows.size());
  symmetric_ = false, upper_.resize(value_.size());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const Row &row = rows[order_[k]], &column = along[order_[k]];
    diagonal_[k] = product(row, column, masses) + column.soft;
    work_[k] = std::abs(diagonal_[k]);
    for (std::uint32_t e = first_[k]; e < first_[k + 1]; ++e) {
      value_[e] = product(rows[order_[column_[e]]], column, masses);
      upper_[e] = product(row, along[order_[column_[e]]], masses);
    }
  }
  const std::uint32_t* target = target_.data();
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const Real inverse = std::abs(diagonal_[k]) > kDependent * work_[k] ? 1 / diagonal_[k] : 0;
    for (std::uint32_t i = first_[k]; i < first_[k + 1]; ++i) {
      const Real low = value_[i] * inverse, high = upper_[i] * inverse;
      for (std::uint32_t e = first_[k]; e < i; ++e, ++target)
        value_[*target] -= low * upper_[e], upper_[*target] -= high * value_[e];
      diagonal_[column_[i]] -= low * upper_[i];
    }
    for (std::uint32_t e = first_[k]; e < first_[k + 1]; ++e)
      value_[e] *= inverse, upper_[e] *= inverse;
    diagonal_[k] = inverse;
  }
}

void Factor::solve(std::span<Real> x) const {
  const std::size_t n = order_.size();
  PANTIN_ASSERT(built_ && x.size() == n && work_.size() == n);
  const std::vector<Real>& above = symmetric_ ? value_ : upper_;

  for (std::size_t k = 0; k < n; ++k) work_[k] = x[order_[k]];
  for (std::size_t k = 0; k < n; ++k)
    for (std::uint32_t e = first_[k]; e < first_[k + 1]; ++e)
      work_[column_[e]] -= value_[e] * work_[k];
  for (std::size_t k = n; k-- > 0;) {
    work_[k] *= diagonal_[k];
    for (std::uint32_t e = first_[k]; e < first_[k + 1]; ++e)
      work_[k] -= above[e] * work_[column_[e]];
  }
  for (std::size_t k = 0; k < n; ++k) x[order_[k]] = work_[k];
}

}  // namespace pantin::detail::planar

#pragma once
// The data of the viewer's plots.
#include <array>
#include <cmath>
#include <cstddef>

namespace pantin::program {

/// Data of one step.
struct Sample {
  double time = 0;                             // s
  double kinetic = 0, potential = 0, sum = 0;  // J; the sum includes springs
  double gap = 0;                              // m, largest joint gap
  double contact = 0;                          // N, sum of the magnitudes of all contact forces
  double cost = 0;                             // s, wall time of a step
};

/// One value of a chosen quantity; NaN where it has none.
struct Value {
  double time = 0, value = 0;  // s; in the unit of the quantity
};

/// A ring buffer of the data of the last steps, oldest first. Never allocates.
template <class T>
class Ring {
 public:
  static constexpr std::size_t kRoom = 300;

  void clear() { first_ = count_ = 0; }
  void push(const T& sample) {
    if (count_ < kRoom) {
      samples_[(first_ + count_++) % kRoom] = sample;
      return;
    }
    samples_[first_] = sample;
    first_ = (first_ + 1) % kRoom;
  }
  std::size_t size() const { return count_; }
  const T& operator[](std::size_t i) const { return samples_[(first_ + i) % kRoom]; }
  const T& last() const { return (*this)[count_ - 1]; }

 private:
  std::array<T, kRoom> samples_{};
  std::size_t first_ = 0, count_ = 0;
};

using Trace = Ring<Sample>;

/// The smallest and the largest value of a quantity.
struct Span {
  double low = 0, high = 0;
  void cover(double x) {
    low = x < low ? x : low;
    high = x > high ? x : high;
  }
};
/// Without the values that are not numbers; both are 0 if there are no others.
template <class T>
Span span_of(const Ring<T>& ring, double T::*what) {
  Span span;
  bool any = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const double x = ring[i].*what;
    if (std::isnan(x)) continue;
    if (!any) span = {x, x};
    span.cover(x), any = true;
  }
  return span;
}

}  // namespace pantin::program

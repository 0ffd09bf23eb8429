#pragma once
// The data of the viewer's plots.
#include <array>
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

/// A ring buffer of the samples of the last steps, oldest first. Never allocates.
class Trace {
 public:
  static constexpr std::size_t kRoom = 300;

  void clear() { first_ = count_ = 0; }
  void push(const Sample& sample) {
    if (count_ < kRoom) {
      samples_[(first_ + count_++) % kRoom] = sample;
      return;
    }
    samples_[first_] = sample;
    first_ = (first_ + 1) % kRoom;
  }
  std::size_t size() const { return count_; }
  const Sample& operator[](std::size_t i) const { return samples_[(first_ + i) % kRoom]; }
  const Sample& last() const { return (*this)[count_ - 1]; }

 private:
  std::array<Sample, kRoom> samples_{};
  std::size_t first_ = 0, count_ = 0;
};

/// The smallest and the largest value of a quantity.
struct Span {
  double low = 0, high = 0;
  void cover(double x) {
    low = x < low ? x : low;
    high = x > high ? x : high;
  }
};
/// Both are 0 for an empty trace.
inline Span span_of(const Trace& trace, double Sample::*what) {
  if (trace.size() == 0) return {};
  Span span{trace[0].*what, trace[0].*what};
  for (std::size_t i = 1; i < trace.size(); ++i) span.cover(trace[i].*what);
  return span;
}

}  // namespace pantin::program

#pragma once
/// Threads that run the independent parts of a task.
#include <algorithm>
#include <cstddef>

#include "engine/base/job.hpp"

namespace pantin::detail {

/// Threads of this library, or a user's instead. Results depend neither on their number nor on the
/// order in which they run.
struct Threads {
  int count = 1;
  const RunJobs* run_jobs = nullptr;

  bool are_many() const { return count > 1 || run_jobs; }
  /// Runs `job(i)` for every i below `parts`.
  void run(std::size_t parts, Job job) const;
};

/// Items of a list that one thread works on: [begin, end).
struct ListPart {
  std::size_t number = 0, begin = 0, end = 0;
};
/// At most so many parts of a list.
inline constexpr std::size_t kMostParts = 32;

/// Divides `count` items into parts of at least `least` items and calls `work(part)` for each.
/// Returns how many there are.
template <class Work>
std::size_t in_parts(const Threads& threads, std::size_t count, std::size_t least,
                     const Work& work) {
  const std::size_t parts =
      threads.are_many() ? std::clamp(count / least, std::size_t(1), kMostParts) : 1;
  const auto run = [&](std::size_t p) {
    work(ListPart{p, count * p / parts, count * (p + 1) / parts});
  };
  if (parts == 1)
    run(0);
  else
    threads.run(parts, Job(run));
  return parts;
}

}  // namespace pantin::detail

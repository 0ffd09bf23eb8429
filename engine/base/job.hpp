#pragma once
/// Parallel work: independent parts, and the interface that runs them.
#include <cstddef>
#include <functional>

namespace pantin {

/// Independent parts of a task: `job(i)` runs part i. It refers to data of the caller, and is valid
/// until the call that received it returns.
class Job {
 public:
  /// `work` is borrowed.
  template <class Work>
  explicit Job(const Work& work)
      : run_([](const void* with, std::size_t i) { (*static_cast<const Work*>(with))(i); }),
        with_(&work) {}
  void operator()(std::size_t i) const { run_(with_, i); }

 private:
  void (*run_)(const void* with, std::size_t i);
  const void* with_;
};

/// Calls `job(i)` once for every i below `count`, in any order and on any threads, and returns when
/// all calls have. The calls throw nothing.
using RunJobs = std::function<void(std::size_t count, Job job)>;

}  // namespace pantin

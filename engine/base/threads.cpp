#include "engine/base/threads.hpp"

#include <atomic>
#include <new>

#ifdef PANTIN_HAS_TBB
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace pantin::detail {
namespace {

/// Runs jobs on a user's threads, which exceptions of a job (out of memory) must not reach.
void run_by_user(std::size_t count, const RunJobs& run_jobs, Job job) {
  std::atomic<bool> failed = false;
  const auto guarded = [&](std::size_t i) {
    try {
      job(i);
    } catch (...) {
      failed = true;
    }
  };
  run_jobs(count, Job(guarded));
  if (failed) throw std::bad_alloc();
}

#ifdef PANTIN_HAS_TBB
/// Kept from call to call: workers would have to join a new one first.
tbb::task_arena& arena_of(int threads) {
  thread_local tbb::task_arena arena;
  thread_local int size = 0;
  // Asking for more threads than there are cores makes TBB print a warning.
  const int now = std::min(threads, tbb::info::default_concurrency());
  if (now != size) arena.terminate(), arena.initialize(size = now);
  return arena;
}
#endif

}  // namespace

void Threads::run(std::size_t parts, Job job) const {
  if (run_jobs && parts > 1) return run_by_user(parts, *run_jobs, job);
#ifdef PANTIN_HAS_TBB
  if (count > 1 && parts > 1)
    return arena_of(count).execute(
        [&] { tbb::parallel_for(std::size_t(0), parts, [&](std::size_t i) { job(i); }); });
#endif
  for (std::size_t i = 0; i < parts; ++i) job(i);
}

}  // namespace pantin::detail

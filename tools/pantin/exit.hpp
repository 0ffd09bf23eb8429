#pragma once
// Exit codes of the program.
namespace pantin::program {

/// Exit codes, the same for every subcommand.
enum Exit : int {
  kOk = 0,
  kFailed = 1,      // the run could not be made
  kUsage = 2,       // usage or bad input
  kDiverged = 3,    // diverged, or a check failed
  kUnwritable = 4,  // a result could not be written
  kInterrupted = 130
};

}  // namespace pantin::program

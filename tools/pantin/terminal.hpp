#pragma once
/// What is said on standard output and beside it.
#include <chrono>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace pantin::program {

/// Whether `stream` is a terminal that understands control sequences.
bool is_terminal(std::FILE* stream);
/// The same, and the user has not asked for plain text (NO_COLOR, https://no-color.org).
bool has_colour(std::FILE* stream);

/// Writes to standard output at once; false, and a complaint, if that fails.
bool print(std::string_view text);

/// One line on standard error.
void complain(std::string_view line);
void complain(std::span<const Error> errors);
/// Warnings on standard error, each headed "warning:"; of many only the first.
void warn(std::span<const std::string> lines);

/// A line on standard error that is written over again; silent away from a terminal.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Whether a new line is worth making: some ten times a second, on a terminal.
  bool is_due();
  void show(std::string_view line);
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool on_, shown_ = false;
  Clock::time_point next_;
};

}  // namespace pantin::program

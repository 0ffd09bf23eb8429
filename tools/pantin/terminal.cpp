#include "tools/pantin/terminal.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace pantin::program {
namespace {

constexpr std::size_t kMostWarnings = 20;

void put(std::FILE* stream, std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stream);
}

void put_line(std::string_view head, const char* colour, std::string_view line) {
  if (!head.empty() && has_colour(stderr)) {
    put(stderr, colour), put(stderr, head), put(stderr, "\x1b[0m");
  } else {
    put(stderr, head);
  }
  put(stderr, line), put(stderr, "\n");
}

}  // namespace

bool is_terminal(std::FILE* stream) {
  const char* kind = std::getenv("TERM");
  return ::isatty(::fileno(stream)) != 0 && kind && *kind && std::strcmp(kind, "dumb") != 0;
}

bool has_colour(std::FILE* stream) {
  const char* plain = std::getenv("NO_COLOR");
  return is_terminal(stream) && !(plain && *plain);
}

bool print(std::string_view text) {
  errno = 0;
  put(stdout, text);
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return true;
  complain(std::string("standard output: ") + std::strerror(errno ? errno : EIO));
  return false;
}

void complain(std::string_view line) { put_line("", "", line); }

void complain(std::span<const Error> errors) {
  for (const Error& error : errors) complain(error.message);
}

void warn(std::span<const std::string> lines) {
  std::size_t shown = 0;
  for (const std::string& line : lines) {
    if (shown++ == kMostWarnings) {
      put_line("warning: ", "\x1b[33m",
               std::to_string(lines.size() - kMostWarnings) + " more; --json lists all of them");
      return;
    }
    put_line("warning: ", "\x1b[33m", line);
  }
}

Progress::Progress() : on_(is_terminal(stderr)), next_(Clock::now()) {}

Progress::~Progress() { clear(); }

bool Progress::is_due() {
  if (!on_ || Clock::now() < next_) return false;
  next_ = Clock::now() + std::chrono::milliseconds(100);
  return true;
}

void Progress::show(std::string_view line) {
  if (!on_) return;
  put(stderr, "\r\x1b[K"), put(stderr, line);
  std::fflush(stderr);
  shown_ = true;
}

void Progress::clear() {
  if (!shown_) return;
  put(stderr, "\r\x1b[K");
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace pantin::program

#pragma once
/// Writes files that are never seen half-written.
#include <cstdio>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace pantin::detail {

/// A file that appears under its name completely or not at all. It is written beside its
/// destination, as `path`.part, and `commit` renames it; so a full disk or an interrupt never
/// destroys an older file. A link is followed, and its target replaced. Devices, pipes and standard
/// output have no older version: they are appended to in place.
///
/// Errors are one line, "<path>: <reason>". After the first one nothing more is written, and every
/// later call returns it again.
class AtomicFile {
 public:
  AtomicFile() = default;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();  // discards a file that was not committed

  Result<Done> open(const std::string& path);
  /// Appends bytes; only between `open` and `commit`.
  Result<Done> write(std::string_view bytes);
  /// Moves the file into place. On failure an older file, if there is one, is untouched.
  Result<Done> commit();

 private:
  Result<Done> fail(int reason);
  void abandon();
  bool close();

  std::string path_, target_, part_;  // as given; links resolved; the open file
  std::FILE* file_ = nullptr;
  int failed_ = 0;  // errno of the first failure
};

/// Writes a whole file at once.
Result<Done> write_file(const std::string& path, std::string_view bytes);

}  // namespace pantin::detail

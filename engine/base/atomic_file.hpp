#pragma once
/// Writing files that are never seen half-written.
#include <cstdio>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace pantin::detail {

/// A file that appears under its name whole or not at all: it grows beside its place, as
/// `path`.part, and `commit` renames it, so that a full disk or an interrupt costs no older file. A
/// link is followed, and its target replaced. Devices, pipes and standard output have no older
/// version and must stay what they are: they are written in place, after what stands there.
///
/// Errors are one line, "<path>: <reason>". After the first one nothing more is written, and every
/// later call returns it again.
class AtomicFile {
 public:
  AtomicFile() = default;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();  // abandons what was not committed

  Result<Done> open(const std::string& path);
  /// Appends bytes; only between `open` and `commit`.
  Result<Done> write(std::string_view bytes);
  /// Puts the file into its place. After a failure the older file, if there is one, is untouched.
  Result<Done> commit();

 private:
  Result<Done> fail(int reason);
  void abandon();
  bool close();

  std::string path_, target_, part_;  // as given; with links followed; what is open
  std::FILE* file_ = nullptr;
  int failed_ = 0;  // errno of the first failure
};

/// All bytes at once.
Result<Done> write_file(const std::string& path, std::string_view bytes);

}  // namespace pantin::detail

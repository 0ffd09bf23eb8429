#include "engine/base/atomic_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace pantin::detail {
namespace {

namespace fs = std::filesystem;

// Child processes such as ffmpeg do not inherit the file.
#ifdef _WIN32
constexpr const char *kWriting = "wb", *kAppending = "ab";
#else
constexpr const char *kWriting = "wbe", *kAppending = "abe";
#endif

struct Target {
  std::string path;  // links resolved
  bool in_place = false;
};

/// Names under /dev and /proc denote streams that are open already, even if they are files.
bool names_a_device(const fs::path& path) {
  std::error_code none;
  const std::string name = fs::absolute(path, none).lexically_normal().generic_string();
  return (name.starts_with("/dev/") && !name.starts_with("/dev/shm/")) ||
         name.starts_with("/proc/");
}

Target resolve(const std::string& path) {
  constexpr int kMostLinks = 40;
  fs::path at = path;
  std::error_code none;
  for (int i = 0; i < kMostLinks && !names_a_device(at); ++i) {
    const fs::file_type kind = fs::symlink_status(at, none).type();
    if (kind != fs::file_type::symlink)
      return {at.string(), kind != fs::file_type::not_found && kind != fs::file_type::regular &&
                               kind != fs::file_type::directory};
    at = at.parent_path() / fs::read_symlink(at, none);
  }
  return {at.string(), true};
}

/// The program's own stream if the name denotes it, else null. If it were opened again, both would
/// write to the file from its start.
std::FILE* standard_stream(const std::string& path) {
  for (const char* folder : {"/dev/", "/dev/fd/", "/proc/self/fd/"}) {
    if (!path.starts_with(folder)) continue;
    const std::string name = path.substr(std::strlen(folder));
    if (name == "stdout" || name == "1") return stdout;
    if (name == "stderr" || name == "2") return stderr;
  }
  return nullptr;
}

}  // namespace

AtomicFile::~AtomicFile() { abandon(); }

void AtomicFile::abandon() {
  if (!file_) return;
  close();
  if (part_ != target_) std::remove(part_.c_str());
}

bool AtomicFile::close() {
  std::FILE* file = std::exchange(file_, nullptr);
  return file == stdout || file == stderr || std::fclose(file) == 0;
}

Result<Done> AtomicFile::fail(int reason) {
  if (failed_ == 0) failed_ = reason != 0 ? reason : EIO;
  return Error{path_ + ": " + std::strerror(failed_)};
}

Result<Done> AtomicFile::open(const std::string& path) {
  abandon();
  const Target target = resolve(path);
  path_ = path, target_ = target.path, failed_ = 0;
  part_ = target.in_place ? target_ : target_ + ".part";
  std::error_code none;
  if (path.find('\0') != std::string::npos) return fail(EINVAL);  // it would name another file
  if (fs::is_directory(target_, none)) return fail(EISDIR);
  errno = 0;
  file_ = target.in_place ? standard_stream(target_) : nullptr;
  if (!file_) file_ = std::fopen(part_.c_str(), target.in_place ? kAppending : kWriting);
  if (!file_) return fail(errno);
  return Done{};
}

Result<Done> AtomicFile::write(std::string_view bytes) {
  errno = 0;
  if (failed_ == 0 && file_ && std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size())
    return Done{};
  return fail(errno);
}

Result<Done> AtomicFile::commit() {
  errno = 0;
  if (failed_ != 0 || !file_ || std::fflush(file_) != 0) {
    auto failure = fail(errno);
    abandon();
    return failure;
  }
  const bool closed = close();
  if (part_ == target_) return closed ? Result<Done>(Done{}) : fail(errno);
  if (closed && std::rename(part_.c_str(), target_.c_str()) == 0) return Done{};
  auto failure = fail(errno);
  std::remove(part_.c_str());
  return failure;
}

Result<Done> write_file(const std::string& path, std::string_view bytes) {
  AtomicFile file;
  if (auto opened = file.open(path); !opened) return opened;
  if (auto written = file.write(bytes); !written) return written;
  return file.commit();
}

}  // namespace pantin::detail

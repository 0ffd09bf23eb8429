#include "engine/scene/json/text_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "engine/base/utf8.hpp"

namespace pantin::detail {

std::string too_long(std::string_view name, std::size_t most, std::string_view what) {
  return printable(name) + ": found more than " + std::to_string(most) + " bytes, expected " +
         std::string(what);
}

Result<std::string> read_text(const std::string& path, std::size_t most, std::string_view what) {
  const std::string expected = ", expected " + std::string(what);
  if (path.find('\0') != std::string::npos)
    return Error{printable(path) + ": found a name with a zero byte" + expected};
  std::error_code trouble;
  if (std::filesystem::is_directory(path, trouble))
    return Error{printable(path) + ": found a directory" + expected};
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return Error{printable(path) + ": found no file to read (" +
                 std::strerror(errno ? errno : EIO) + ")" + expected};
  std::string text;
  // Reads in pieces, so that an endless device is detected.
  constexpr std::size_t kPiece = 1u << 16;
  while (file && text.size() <= most) {
    const std::size_t before = text.size();
    text.resize(before + kPiece);
    file.read(text.data() + before, static_cast<std::streamsize>(kPiece));
    text.resize(before + static_cast<std::size_t>(file.gcount()));
  }
  if (text.size() > most) return Error{too_long(path, most, what)};
  if (file.bad()) return Error{printable(path) + ": found an error while reading" + expected};
  return text;
}

}  // namespace pantin::detail

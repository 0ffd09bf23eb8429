#include "tools/pantin/npz.hpp"

#include <fmt/core.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace pantin::program {

using namespace detail;

namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are written as they lie in memory");

constexpr auto kCrcTable = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
    table[i] = c;
  }
  return table;
}();

std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t c = ~0u;
  for (const char b : bytes) c = kCrcTable[(c ^ static_cast<unsigned char>(b)) & 255] ^ (c >> 8);
  return ~c;
}

/// Little-endian numbers in a text.
void add_number(std::string& to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to += static_cast<char>(value >> 8 * i & 255);
}

/// An array as a .npy file.
std::string npy_of(std::span<const Real> values) {
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", values.size());
  constexpr std::size_t kPrefix = 10, kAlignment = 64;
  header.append(kAlignment - 1 - (kPrefix + header.size()) % kAlignment, ' ');
  header += '\n';
  std::string file("\x93NUMPY\x01\x00", 8);
  add_number(file, header.size(), 2);
  file += header;
  const std::size_t start = file.size();
  file.resize(start + values.size_bytes());
  std::memcpy(file.data() + start, values.data(), values.size_bytes());
  return file;
}

/// The part that a local header and its entry in the directory share.
std::string common_header(const std::string& name, const std::string& content) {
  std::string head;
  add_number(head, 20, 2);     // version needed: 2.0
  add_number(head, 0x800, 2);  // names are UTF-8
  add_number(head, 0, 2);      // stored
  add_number(head, 0, 2);      // time
  add_number(head, 0x21, 2);   // 1980-01-01, so that equal runs give equal files
  add_number(head, crc32(content), 4);
  add_number(head, content.size(), 4);
  add_number(head, content.size(), 4);
  add_number(head, name.size(), 2);
  add_number(head, 0, 2);  // no extra field
  return head;
}

}  // namespace

Result<Done> write_npz(std::span<const NpzArray> arrays, AtomicFile& file) {
  constexpr std::uint64_t kMost = 0xffffffffu;
  constexpr std::size_t kMostFiles = 0xffff;
  std::string directory;
  std::uint64_t at = 0;
  for (const NpzArray& array : arrays) {
    const std::string name = array.name + ".npy", content = npy_of(array.values);
    const std::string head = common_header(name, content);
    directory += "PK\x01\x02";
    add_number(directory, 20, 2);  // made by version 2.0
    directory += head;
    add_number(directory, 0, 2);  // no comment
    add_number(directory, 0, 2);  // disk
    add_number(directory, 0, 2);  // internal attributes
    add_number(directory, 0, 4);  // external attributes
    add_number(directory, at, 4);
    directory += name;
    if (at + content.size() + directory.size() > kMost || arrays.size() > kMostFiles)
      return Error{
          "the record is too large for a .npz file (4 GiB, 65535 columns); fewer "
          "--columns, or .csv"};
    const std::string local = "PK\x03\x04" + head + name;
    if (auto done = file.write(local); !done) return done;
    if (auto done = file.write(content); !done) return done;
    at += local.size() + content.size();
  }
  const std::uint64_t size = directory.size();
  directory += "PK\x05\x06";
  add_number(directory, 0, 4);  // one disk
  add_number(directory, arrays.size(), 2);
  add_number(directory, arrays.size(), 2);
  add_number(directory, size, 4);
  add_number(directory, at, 4);
  add_number(directory, 0, 2);  // no comment
  return file.write(directory);
}

}  // namespace pantin::program

// Files that appear whole or not at all.
#include "engine/base/atomic_file.hpp"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

using namespace pantin;
using namespace pantin::detail;
namespace fs = std::filesystem;

namespace {

struct Folder {
  fs::path path;

  Folder() {
    std::string name = (fs::temp_directory_path() / "pantin_XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()));
    path = name;
  }
  ~Folder() { fs::remove_all(path); }
  std::string operator/(const char* name) const { return (path / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(path), fs::directory_iterator()));
  }
};

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("a file is seen when it is committed, and until then the older one") {
  const Folder folder;
  const std::string path = folder / "a.csv";
  REQUIRE(write_file(path, "old"));
  AtomicFile file;
  REQUIRE(file.open(path));
  REQUIRE(file.write("new "));
  REQUIRE(file.write("text"));
  CHECK(text_of(path) == "old");
  REQUIRE(file.commit());
  CHECK(text_of(path) == "new text");
  CHECK(folder.files() == 1);
}

TEST_CASE("a file that is not committed leaves nothing behind") {
  const Folder folder;
  {
    AtomicFile file;
    REQUIRE(file.open(folder / "a.csv"));
    REQUIRE(file.write("text"));
  }
  CHECK(folder.files() == 0);
}

TEST_CASE("a link is followed, and stays a link") {
  const Folder folder;
  REQUIRE(write_file(folder / "there", "old"));
  fs::create_symlink("there", folder.path / "link");
  fs::create_symlink("link", folder.path / "link_to_link");
  REQUIRE(write_file(folder / "link_to_link", "new"));
  CHECK(fs::is_symlink(folder.path / "link"));
  CHECK(text_of(folder / "there") == "new");
  CHECK(folder.files() == 3);
}

TEST_CASE("a failure is told with the file and the reason, by every later call") {
  const Folder folder;
  AtomicFile file;
  REQUIRE(file.open("/dev/full"));
  const std::string much(1 << 20, 'x');
  const auto first = file.write(much);
  REQUIRE_FALSE(first);
  CHECK(first.errors().front().message == "/dev/full: No space left on device");
  const auto again = file.write("x");
  REQUIRE_FALSE(again);
  CHECK(again.errors().front().message == first.errors().front().message);
  const auto last = file.commit();
  REQUIRE_FALSE(last);
  CHECK(last.errors().front().message == first.errors().front().message);
  CHECK(fs::is_character_file("/dev/full"));

  // What fits into memory fails when it is put on the disk.
  const auto small = write_file("/dev/full", "x");
  REQUIRE_FALSE(small);
  CHECK(small.errors().front().message == "/dev/full: No space left on device");

  const auto folder_itself = write_file(folder.path.string(), "x");
  REQUIRE_FALSE(folder_itself);
  CHECK(folder_itself.errors().front().message == folder.path.string() + ": Is a directory");
  const auto nowhere = write_file(folder / "no/such/folder", "x");
  REQUIRE_FALSE(nowhere);
  CHECK(folder.files() == 0);
}

TEST_CASE("what stands behind a descriptor is written after what is there") {
  const Folder folder;
  const std::string path = folder / "out";
  std::FILE* out = std::fopen(path.c_str(), "w");
  REQUIRE(out);
  std::fputs("head ", out);
  std::fflush(out);
  REQUIRE(write_file("/dev/fd/" + std::to_string(::fileno(out)), "body"));
  std::fclose(out);
  CHECK(text_of(path) == "head body");
}

TEST_CASE("a pipe is written into and stays a pipe") {
  const Folder folder;
  const std::string path = folder / "pipe";
  REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
  std::FILE* reader = ::popen(("cat '" + path + "'").c_str(), "r");
  REQUIRE(reader);
  REQUIRE(write_file(path, "text"));
  char text[16] = {};
  CHECK(std::fread(text, 1, sizeof text, reader) == 4);
  ::pclose(reader);
  CHECK(std::string(text) == "text");
  CHECK(fs::is_fifo(path));
}

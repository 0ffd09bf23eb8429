// The viewer reads a scene again when any of its files has been written.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tools/pantin/view_files.hpp"

using pantin::program::FileWatch;

TEST_CASE("A change of any watched file is told once, when all are there and at rest") {
  namespace fs = std::filesystem;
  std::string folder = (fs::temp_directory_path() / "pantin-watch-XXXXXX").string();
  REQUIRE(mkdtemp(folder.data()));
  const std::string scene = folder + "/scene.json", leg = folder + "/leg.json";
  const auto write = [](const std::string& path, const char* text) {
    std::ofstream(path, std::ios::binary) << text;
  };
  write(scene, "1"), write(leg, "1");
  FileWatch watch;
  watch.start({scene, leg});
  CHECK_FALSE(watch.changed());
  write(leg, "12");
  CHECK_FALSE(watch.changed());  // still being written, for all one knows
  CHECK(watch.changed());
  CHECK_FALSE(watch.changed());
  write(scene, "123");
  CHECK_FALSE(watch.changed());
  CHECK(watch.changed());
  fs::remove(leg);
  CHECK_FALSE(watch.changed());
  CHECK_FALSE(watch.changed());  // it is waited for
  write(leg, "1234");
  CHECK_FALSE(watch.changed());
  CHECK(watch.changed());
  fs::remove_all(folder);
}

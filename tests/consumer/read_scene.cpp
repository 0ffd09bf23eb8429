// A scene file that is none, through the installed headers: the answer is a complaint, not a crash.
#include <cstdio>
#include <pantin/scene.hpp>

int main() {
  const auto scene = pantin::parse_scene("{", "broken.json");
  if (scene || scene.errors().empty()) return 1;
  std::printf("%s\n", scene.errors().front().message.c_str());
  return 0;
}

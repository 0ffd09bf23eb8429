// One PNG, through the installed headers.
#include <cstdio>
#include <pantin/render.hpp>

int main() {
  pantin::Image grey{4, 4, std::vector<std::uint8_t>(4 * 4 * 4, 127)};
  const auto written = pantin::write_png("grey.png", grey);
  if (!written) std::printf("%s\n", written.errors().front().message.c_str());
  return written ? 0 : 1;
}

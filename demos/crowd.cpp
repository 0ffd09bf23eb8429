// A hundred marionettes in a grid.
#include "demos/demo.hpp"

int main(int argc, char** argv) {
  return pantin::demos::run(argc, argv, {.name = "crowd", .scene = pantin::demos::load("crowd")});
}

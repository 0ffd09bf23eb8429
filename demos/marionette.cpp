// A puppet on cables: it walks and waves as its bars are rocked.
#include "demos/demo.hpp"

int main(int argc, char** argv) {
  return pantin::demos::run(argc, argv,
                            {.name = "marionette", .scene = pantin::demos::load("marionette")});
}

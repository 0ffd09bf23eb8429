// A chain thrown into empty space: nothing holds it, its momenta stay.
#include "demos/demo.hpp"

int main(int argc, char** argv) {
  return pantin::demos::run(argc, argv,
                            {.name = "free_chain", .scene = pantin::demos::load("free_chain")});
}

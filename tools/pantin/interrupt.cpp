#include "tools/pantin/interrupt.hpp"

#include <csignal>

namespace pantin::program {
namespace {

volatile std::sig_atomic_t came = 0;

void note(int) { came = 1; }

}  // namespace

void watch_for_interrupts() {
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (::sigaction(signal, nullptr, &now) != 0 || now.sa_handler == SIG_IGN) continue;
    now.sa_handler = note;
    sigemptyset(&now.sa_mask);
    now.sa_flags = static_cast<int>(SA_RESTART | SA_RESETHAND);
    ::sigaction(signal, &now, nullptr);
  }
}

bool is_interrupted() { return came != 0; }

}  // namespace pantin::program

#pragma once
/// SIGINT, SIGTERM and SIGHUP ask for an end; loops look here and finish their files.

namespace pantin::program {

/// From here on the first such signal is noted; a second one ends the program at once. Signals that
/// whoever started the program had switched off stay off.
void watch_for_interrupts();

/// Whether a signal has come.
bool is_interrupted();

}  // namespace pantin::program
